"""Digital flow control unit: on/off valves in parallel, each opened by the unit's code."""

from typing import NamedTuple

from vvdp.base.kinds import Count, Flow, Kink, Power
from vvdp.base.modes import between
from vvdp.fluid.mixture import FluidState
from vvdp.hydraulics.flow import passage
from vvdp.hydraulics.flow_control_unit import (
    PoppetState,
    UnitValve,
    poppet_flow,
    poppet_opening,
    poppet_rate,
    valve_command,
)
from vvdp.network.component import Component
from vvdp.network.network import Network
from vvdp.network.nodes import Source


class UnitPassage(NamedTuple):
    """What goes through a valve of a unit, the rate of its poppet, and whether it is closed, on its way or open."""

    flow: Flow
    loss: Power
    rates: PoppetState
    side: Kink


def unit_valve(a: FluidState, b: FluidState, code: Count, state: PoppetState, values: UnitValve) -> UnitPassage:
    """On/off valve between a and b that the `code` of its unit opens and closes."""
    flow, loss = passage(poppet_flow(a.pressure - b.pressure, state.travel, values), a, b)
    rates = PoppetState(poppet_rate(valve_command(code, values), state.travel, values))
    return UnitPassage(flow, loss, rates, between(poppet_opening(state.travel, values)))


UNIT_VALVE = Component(unit_valve, symbol="switching_valve_2_2")


def add_flow_control_unit(
    net: Network, name: str, valves: tuple[UnitValve, ...], nodes: tuple[str, str], code: Source, suffix: str = ""
) -> None:
    """Add the valves of a unit between two nodes: `name_1` and so on, a `suffix` behind, all hearing its `code`."""
    for number, valve in enumerate(valves, 1):
        net.add(f"{name}_{number}{suffix}", UNIT_VALVE, valve, a=nodes[0], b=nodes[1], code=code)
