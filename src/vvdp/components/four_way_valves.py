"""Proportional directional valves with a lap of each edge: 4/3, 6/3 with a bypass, and with a load-sensing port."""

from typing import NamedTuple

from vvdp.base.kinds import Flow, Kink, Power, SignedFraction
from vvdp.fluid.mixture import FluidState
from vvdp.hydraulics.flow import Passage, passage, root_edge_flow, root_passage
from vvdp.hydraulics.four_way_valve import (
    EdgeDrops,
    Edges,
    EdgeStands,
    FourWayValve,
    LappedValve,
    SensingValve,
    SixWayValve,
    flow_push,
    four_edges,
    four_sides,
    sensing_openings,
)
from vvdp.hydraulics.proportional_spool import ValveSpool, error_side, rate_side, spool_error, spool_motion
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
    bypass_side: Kink
    rate_limit: Kink
    play: Kink


class SixWayFlows(NamedTuple):
    """As `FourWayFlows`, with the ends of the bypass."""

    pressure: Flow
    tank: Flow
    a: Flow
    b: Flow
    bypass: Flow
    onward: Flow
    loss: Power
    rates: ValveSpool
    pa_side: Kink
    pb_side: Kink
    at_side: Kink
    bt_side: Kink
    bypass_side: Kink
    rate_limit: Kink
    play: Kink


class SensingFlows(NamedTuple):
    """As `FourWayFlows`, with the port for the pressure of the load."""

    pressure: Flow
    tank: Flow
    a: Flow
    b: Flow
    sensing: Flow
    loss: Power
    rates: ValveSpool
    pa_side: Kink
    pb_side: Kink
    at_side: Kink
    bt_side: Kink
    bypass_side: Kink
    rate_limit: Kink
    play: Kink


class Ports(NamedTuple):
    """The oil at the four ports of a valve."""

    pressure: FluidState
    tank: FluidState
    a: FluidState
    b: FluidState


class Core(NamedTuple):
    """Four edges and their spool: the passages, their loss, the spool's motion, and where they stand."""

    pa: Flow
    pb: Flow
    at: Flow
    bt: Flow
    loss: Power
    edges: Edges
    motion: ValveSpool
    sides: EdgeStands
    rate_limit: Kink
    play: Kink


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
    core = _core(Ports(pressure, tank, a, b), command, state, values)
    past = _bypass(pressure, tank, core, values)
    return FourWayFlows(
        pressure=-core.pa - core.pb - past.flow,
        tank=core.at + core.bt + past.flow,
        a=core.pa - core.at,
        b=core.pb - core.bt,
        loss=core.loss + past.loss,
        rates=core.motion,
        pa_side=core.sides.pa,
        pb_side=core.sides.pb,
        at_side=core.sides.at,
        bt_side=core.sides.bt,
        bypass_side=core.sides.bypass,
        rate_limit=core.rate_limit,
        play=core.play,
    )


def six_way_valve(
    pressure: FluidState,
    tank: FluidState,
    a: FluidState,
    b: FluidState,
    bypass: FluidState,
    onward: FluidState,
    command: SignedFraction,
    state: ValveSpool,
    values: SixWayValve,
) -> SixWayFlows:
    """6/3 proportional valve: as a 4/3 one, and in the middle the pump's flow goes on from bypass to onward."""
    core = _core(Ports(pressure, tank, a, b), command, state, values)
    past = _bypass(bypass, onward, core, values)
    return SixWayFlows(
        pressure=-core.pa - core.pb,
        tank=core.at + core.bt,
        a=core.pa - core.at,
        b=core.pb - core.bt,
        bypass=-past.flow,
        onward=past.flow,
        loss=core.loss + past.loss,
        rates=core.motion,
        pa_side=core.sides.pa,
        pb_side=core.sides.pb,
        at_side=core.sides.at,
        bt_side=core.sides.bt,
        bypass_side=core.sides.bypass,
        rate_limit=core.rate_limit,
        play=core.play,
    )


def load_sensing_valve(
    pressure: FluidState,
    tank: FluidState,
    a: FluidState,
    b: FluidState,
    sensing: FluidState,
    command: SignedFraction,
    state: ValveSpool,
    values: SensingValve,
) -> SensingFlows:
    """4/3 proportional valve with a port for the pressure of its load, which the tank has in the middle."""
    core = _core(Ports(pressure, tank, a, b), command, state, values)
    past = _bypass(pressure, tank, core, values)
    opening = sensing_openings(state.position, core.edges.bypass)
    by_a, by_b = _sensing_passage(a, sensing, opening.a, values), _sensing_passage(b, sensing, opening.b, values)
    by_tank = _sensing_passage(sensing, tank, opening.tank, values)
    return SensingFlows(
        pressure=-core.pa - core.pb - past.flow,
        tank=core.at + core.bt + past.flow + by_tank.flow,
        a=core.pa - core.at - by_a.flow,
        b=core.pb - core.bt - by_b.flow,
        sensing=by_a.flow + by_b.flow - by_tank.flow,
        loss=core.loss + past.loss + by_a.loss + by_b.loss + by_tank.loss,
        rates=core.motion,
        pa_side=core.sides.pa,
        pb_side=core.sides.pb,
        at_side=core.sides.at,
        bt_side=core.sides.bt,
        bypass_side=core.sides.bypass,
        rate_limit=core.rate_limit,
        play=core.play,
    )


def _core(ports: Ports, command: float, state: ValveSpool, values: LappedValve) -> Core:
    """The four edges and the spool of a valve."""
    pressure, tank, a, b = ports.pressure, ports.tank, ports.a, ports.b
    edges, sides = four_edges(state.position, values), four_sides(state.position, values)
    pa, pb = root_passage(pressure, a, edges.pa, values), root_passage(pressure, b, edges.pb, values)
    at, bt = root_passage(a, tank, edges.at, values), root_passage(b, tank, edges.bt, values)
    drops = EdgeDrops(
        pressure.pressure - a.pressure,
        pressure.pressure - b.pressure,
        a.pressure - tank.pressure,
        b.pressure - tank.pressure,
    )
    push = flow_push(edges, drops, values)
    moving = spool_error(command, state.position, push, values)
    return Core(
        pa=pa.flow,
        pb=pb.flow,
        at=at.flow,
        bt=bt.flow,
        loss=pa.loss + pb.loss + at.loss + bt.loss,
        edges=edges,
        motion=spool_motion(moving, state, values),
        sides=sides,
        rate_limit=rate_side(moving, state, values),
        play=error_side(command, state.position, push, values),
    )


def _bypass(upstream: FluidState, downstream: FluidState, core: Core, values: FourWayValve | SixWayValve) -> Passage:
    """Flow over the bypass."""
    drop = upstream.pressure - downstream.pressure
    flow = root_edge_flow(values.bypass_conductance, core.edges.bypass, drop, values.transition_pressure)
    return passage(flow, upstream, downstream)


def _sensing_passage(upstream: FluidState, downstream: FluidState, opening: float, values: SensingValve) -> Passage:
    """Flow over a passage of the load-sensing port."""
    drop = upstream.pressure - downstream.pressure
    flow = root_edge_flow(values.sensing_conductance, opening, drop, values.transition_pressure)
    return passage(flow, upstream, downstream)


FOUR_WAY_VALVE = Component(four_way_valve, symbol="proportional_valve_4_3")
SIX_WAY_VALVE = Component(six_way_valve, symbol="proportional_valve_6_3")
LOAD_SENSING_VALVE = Component(load_sensing_valve, symbol="load_sensing_valve")
