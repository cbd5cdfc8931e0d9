"""Directional valves: three-way proportional; four-way with closed centre, alone and with a throttle in its return."""

from typing import NamedTuple

from vvdp.base.kinds import Area, Flow, FlowCoefficient, Fraction, Kink, Power, SignedFraction, Time
from vvdp.base.modes import side
from vvdp.base.rules import require_positive
from vvdp.base.select import clip
from vvdp.fluid.mixture import FluidState
from vvdp.hydraulics.directional_valve import (
    DirectionalState,
    DirectionalValve,
    edge_openings,
    edge_sides,
    position_rate,
)
from vvdp.hydraulics.flow import Passage, passage, root_passage
from vvdp.hydraulics.orifice import Orifice, orifice_flow
from vvdp.hydraulics.ports import Medium
from vvdp.hydraulics.series import first_share, series_flow
from vvdp.network.component import Component


class ThrottledDirectionalValve(DirectionalValve):
    """A directional valve whose return goes through a throttle of `return_conductance`, fully open.

    `return_lag` is the time constant with which the throttle's opening follows its command. The transition pressure
    of a return path is that of edge and throttle together.
    """

    return_conductance: FlowCoefficient
    return_lag: Time

    def check(self) -> None:
        require_positive(self, "return_lag")


class ThreeWayProportionalValve(Orifice):
    """Two sharp edges from one chamber, to supply and to tank, each with `full_area` at the end of the stroke."""

    full_area: Area


class ThrottledDirectionalState(NamedTuple):
    """Position of the spool, 1 forward and -1 backward, and opening of the meter-out throttle."""

    position: SignedFraction
    opening: Fraction


class DirectionalFlows(NamedTuple):
    """Flows of a directional valve into its nodes, its loss, the rate of its position and the openings of its edges."""

    pressure: Flow
    tank: Flow
    a: Flow
    b: Flow
    loss: Power
    rates: DirectionalState
    forward: Fraction
    backward: Fraction
    forward_side: Kink
    backward_side: Kink


class ThreeWayProportionalFlows(NamedTuple):
    """Flows of a three-way proportional valve into its nodes, its loss, and on which side of its centre it stands."""

    pressure: Flow
    tank: Flow
    a: Flow
    loss: Power
    centre: Kink


class ThrottledDirectionalLosses(NamedTuple):
    """Losses over the edges and over the meter-out throttle."""

    edges: Power
    return_throttle: Power


class ThrottledDirectionalFlows(NamedTuple):
    """As `DirectionalFlows`, with the losses apart and the rate of the throttle's opening."""

    pressure: Flow
    tank: Flow
    a: Flow
    b: Flow
    losses: ThrottledDirectionalLosses
    rates: ThrottledDirectionalState
    forward: Fraction
    backward: Fraction
    forward_side: Kink
    backward_side: Kink


def directional_valve(
    pressure: FluidState,
    tank: FluidState,
    a: FluidState,
    b: FluidState,
    command: SignedFraction,
    state: DirectionalState,
    values: DirectionalValve,
) -> DirectionalFlows:
    """4/3 valve: forward it joins pressure to a and b to tank, backward pressure to b and a to tank."""
    forward, backward = edge_openings(state.position, values)
    sides = edge_sides(state.position, values)
    to_a, to_b = root_passage(pressure, a, forward, values), root_passage(pressure, b, backward, values)
    from_a, from_b = root_passage(a, tank, backward, values), root_passage(b, tank, forward, values)
    return DirectionalFlows(
        pressure=-to_a.flow - to_b.flow,
        tank=from_a.flow + from_b.flow,
        a=to_a.flow - from_a.flow,
        b=to_b.flow - from_b.flow,
        loss=to_a.loss + to_b.loss + from_a.loss + from_b.loss,
        rates=DirectionalState(position_rate(command, state.position, values)),
        forward=forward,
        backward=backward,
        forward_side=sides.forward,
        backward_side=sides.backward,
    )


def throttled_directional_valve(
    pressure: FluidState,
    tank: FluidState,
    a: FluidState,
    b: FluidState,
    command: SignedFraction,
    return_command: Fraction,
    state: ThrottledDirectionalState,
    values: ThrottledDirectionalValve,
) -> ThrottledDirectionalFlows:
    """4/3 valve whose return is throttled by `return_command` [1]: the edge and the throttle are in series."""
    forward, backward = edge_openings(state.position, values)
    sides = edge_sides(state.position, values)
    throttle = values.return_conductance * clip(state.opening, 0.0, 1.0)
    to_a, to_b = root_passage(pressure, a, forward, values), root_passage(pressure, b, backward, values)
    from_a, from_b = _return(a, tank, backward, throttle, values), _return(b, tank, forward, throttle, values)
    over_a = first_share(values.conductance * backward, throttle) * from_a.loss
    over_b = first_share(values.conductance * forward, throttle) * from_b.loss
    return ThrottledDirectionalFlows(
        pressure=-to_a.flow - to_b.flow,
        tank=from_a.flow + from_b.flow,
        a=to_a.flow - from_a.flow,
        b=to_b.flow - from_b.flow,
        losses=ThrottledDirectionalLosses(
            edges=to_a.loss + to_b.loss + over_a + over_b,
            return_throttle=(from_a.loss - over_a) + (from_b.loss - over_b),
        ),
        rates=ThrottledDirectionalState(
            position_rate(command, state.position, values),
            (clip(return_command, 0.0, 1.0) - state.opening) / values.return_lag,
        ),
        forward=forward,
        backward=backward,
        forward_side=sides.forward,
        backward_side=sides.backward,
    )


def three_way_proportional_valve(
    pressure: FluidState,
    tank: FluidState,
    a: FluidState,
    command: SignedFraction,
    medium: Medium,
    values: ThreeWayProportionalValve,
) -> ThreeWayProportionalFlows:
    """3/3 proportional valve without lag: a `command` above 0 joins pressure to a, one below 0 a to tank."""
    u = clip(command, -1.0, 1.0)
    filling, emptying = values.full_area * clip(u, 0.0, 1.0), values.full_area * clip(-u, 0.0, 1.0)
    drop_in, drop_out = pressure.pressure - a.pressure, a.pressure - tank.pressure
    to_a = passage(orifice_flow(filling, drop_in, medium.density, values), pressure, a)
    to_tank = passage(orifice_flow(emptying, drop_out, medium.density, values), a, tank)
    return ThreeWayProportionalFlows(
        pressure=-to_a.flow,
        tank=to_tank.flow,
        a=to_a.flow - to_tank.flow,
        loss=to_a.loss + to_tank.loss,
        centre=side(u),
    )


def _return(
    upstream: FluidState, downstream: FluidState, opening: float, throttle: float, values: DirectionalValve
) -> Passage:
    """Flow over one edge and the throttle behind it."""
    drop = upstream.pressure - downstream.pressure
    edge = values.conductance * opening
    return passage(series_flow(drop, edge, throttle, values.transition_pressure), upstream, downstream)


DIRECTIONAL_VALVE = Component(directional_valve, symbol="directional_valve")
THROTTLED_DIRECTIONAL_VALVE = Component(throttled_directional_valve, symbol="directional_valve")
THREE_WAY_PROPORTIONAL_VALVE = Component(three_way_proportional_valve, symbol="switching_valve_3_2")
