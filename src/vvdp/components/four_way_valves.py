"""Four-way proportional valve with a lap of each edge and a spool of second order."""

from typing import NamedTuple

from vvdp.base.kinds import Flow, Kink, Power, SignedFraction
from vvdp.fluid.mixture import FluidState
from vvdp.hydraulics.flow import root_passage
from vvdp.hydraulics.four_way_valve import (
    FourWayValve,
    ValveSpool,
    four_edges,
    four_sides,
    rate_side,
    spool_motion,
)
from vvdp.network.component import Component


class FourWayFlows(NamedTuple):
    """Flows of a four-way valve into its nodes, its loss, the motion of its spool, and where its edges stand."""

    pressure: Flow
    tank: Flow
    a: Flow
    b: Flow
    loss: Power
    rates: ValveSpool
    pa_side: Kink
    pb_side: Kink
    at_side: Kink
    bt_side: Kink
    rate_limit: Kink


def four_way_valve(
    pressure: FluidState,
    tank: FluidState,
    a: FluidState,
    b: FluidState,
    command: SignedFraction,
    state: ValveSpool,
    values: FourWayValve,
) -> FourWayFlows:
    """4/3 proportional valve: forward it joins pressure to a and b to tank, backward pressure to b and a to tank."""
    edges, sides = four_edges(state.position, values), four_sides(state.position, values)
    pa, pb = root_passage(pressure, a, edges.pa, values), root_passage(pressure, b, edges.pb, values)
    at, bt = root_passage(a, tank, edges.at, values), root_passage(b, tank, edges.bt, values)
    return FourWayFlows(
        pressure=-pa.flow - pb.flow,
        tank=at.flow + bt.flow,
        a=pa.flow - at.flow,
        b=pb.flow - bt.flow,
        loss=pa.loss + pb.loss + at.loss + bt.loss,
        rates=spool_motion(command, state, values),
        pa_side=sides.pa,
        pb_side=sides.pb,
        at_side=sides.at,
        bt_side=sides.bt,
        rate_limit=rate_side(state, values),
    )


FOUR_WAY_VALVE = Component(four_way_valve, symbol="proportional_valve_4_3")
