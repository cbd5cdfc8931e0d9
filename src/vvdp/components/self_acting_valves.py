"""Valves that the pressures at their ports move: check, relief, reducing and flow control valves."""

from typing import NamedTuple

from vvdp.base.kinds import Flow, Fraction, Kink, Length, Mode, Power
from vvdp.base.select import clip, minimum, select
from vvdp.fluid.mixture import FluidState
from vvdp.hydraulics.check_valve import (
    CheckValve,
    check_opening,
    check_side,
)
from vvdp.hydraulics.flow import passage, rated_passage
from vvdp.hydraulics.flow_control_valve import FlowControlValve, controlled_flow, controlled_side
from vvdp.hydraulics.opening import OpeningPassage, OpeningState, lagged_rate
from vvdp.hydraulics.orifice import orifice_flow
from vvdp.hydraulics.pilot_check_valve import PilotCheckValve, closing_drop, lifting_drop
from vvdp.hydraulics.poppet_valve import PoppetValve, lift_range, poppet_area, poppet_side
from vvdp.hydraulics.ports import Medium, Surplus
from vvdp.hydraulics.reducing_valve import (
    ReducingValve,
    reducing_opening,
    reducing_opening_rate,
    reducing_side,
)
from vvdp.hydraulics.relief_valve import (
    LoadReliefValve,
    ReliefValve,
    ShockValve,
    opened_relief_flow,
    relief_flow,
    relief_mode,
    relief_opening,
    relief_opening_rate,
    setting_fall,
)
from vvdp.hydraulics.shuttle_valve import ShuttleValve, ball_position, ball_side
from vvdp.network.component import Component


class LiftState(NamedTuple):
    """Lift of a poppet off its seat."""

    lift: Length


class PoppetPassage(NamedTuple):
    """Flow through a poppet valve, the rate of its lift, and where it is to stand."""

    flow: Flow
    loss: Power
    rates: LiftState
    side: Kink


class FlowControlPassage(NamedTuple):
    """Flow through a flow control valve, and on which side of its balance of drops it is."""

    flow: Flow
    loss: Power
    side: Kink


class ShuttleFlows(NamedTuple):
    """Flows of a shuttle valve into its nodes, its loss, and where its ball stands."""

    a: Flow
    b: Flow
    outlet: Flow
    loss: Power
    side: Kink


def check_valve(a: FluidState, b: FluidState, state: OpeningState, values: CheckValve) -> OpeningPassage:
    """Check valve that opens from a to b; its poppet follows with its opening time, without one at once."""
    return _over_poppet(a, b, a.pressure - b.pressure, state, values)


def check_start(values: CheckValve) -> OpeningState:
    """Start with the poppet on its seat."""
    return OpeningState(values.reverse_opening)


def pilot_check_valve(
    a: FluidState, b: FluidState, pilot: FluidState, state: OpeningState, values: PilotCheckValve
) -> OpeningPassage:
    """Check valve that opens from a to b, and either way when the pilot's pressure exceeds that at a by enough.

    No oil flows at the pilot port.
    """
    lifting = lifting_drop(a.pressure - b.pressure, pilot.pressure - a.pressure, values)
    return _over_poppet(a, b, lifting, state, values)


def pilot_closed_check_valve(
    a: FluidState, b: FluidState, pilot: FluidState, state: OpeningState, values: PilotCheckValve
) -> OpeningPassage:
    """Check valve that opens from a to b unless the pilot's pressure exceeds that at b by enough to hold it close.

    No oil flows at the pilot port.
    """
    lifting = closing_drop(a.pressure - b.pressure, pilot.pressure - b.pressure, values)
    return _over_poppet(a, b, lifting, state, values)


def _over_poppet(
    a: FluidState, b: FluidState, lifting: float, state: OpeningState, values: CheckValve
) -> OpeningPassage:
    """A check valve from a to b whose poppet a pressure lifts."""
    y = select(values.opening_time > 0.0, state.opening, check_opening(lifting, values))
    flow, loss = rated_passage(a, b, y, values)
    rate = lagged_rate(check_opening(lifting, values), state.opening, values.opening_time, values.closing_time)
    return OpeningPassage(flow, loss, OpeningState(rate), check_side(lifting, values))


def relief_valve(
    a: FluidState, b: FluidState, surplus: Surplus, side: Mode, state: OpeningState, values: ReliefValve
) -> OpeningPassage:
    """Relief valve that limits the pressure at a; see `relief_flow` for its three limits.

    An ideal one gives nothing to a side that is under a higher pressure.
    """
    flow, loss = passage(relief_flow(a.pressure, b.pressure, state.opening, surplus, side, values), a, b)
    rates = OpeningState(relief_opening_rate(a.pressure, state.opening, side, values))
    return OpeningPassage(flow, loss, rates, relief_mode(a.pressure, b.pressure, surplus, side, values))


def shock_valve(a: FluidState, b: FluidState, side: Mode, state: OpeningState, values: ShockValve) -> OpeningPassage:
    """Port (crossover) relief valve with pressure override at a, also beside other valves at the same volume.

    `relief_valve` needs the flows of everything else at its volume, so that two of them, each from one side of a
    motor to the other, would wait for each other.
    """
    return _shock(a, b, a.pressure, side, state, values)


def _shock(
    a: FluidState, b: FluidState, felt: float, mode: float, state: OpeningState, values: ShockValve
) -> OpeningPassage:
    """A relief valve with an override from a to b, at the pressure that it feels."""
    static = minimum(relief_opening(felt, mode, values), values.largest_opening)
    y = select(values.opening_time > 0.0, state.opening, static)
    flow, loss = passage(opened_relief_flow(a.pressure - b.pressure, b.pressure, y, values), a, b)
    rate = lagged_rate(static, state.opening, values.opening_time, values.closing_time)
    return OpeningPassage(flow, loss, OpeningState(rate), relief_mode(felt, b.pressure, 0.0, mode, values))


def load_relief_valve(
    a: FluidState, b: FluidState, pilot: FluidState, side: Mode, state: OpeningState, values: LoadReliefValve
) -> OpeningPassage:
    """Relief valve that limits the pressure at a to a margin above that at the pilot, where no oil flows."""
    return _shock(a, b, a.pressure + setting_fall(pilot.pressure, values), side, state, values)


def poppet_valve(a: FluidState, b: FluidState, state: LiftState, medium: Medium, values: PoppetValve) -> PoppetPassage:
    """Poppet on a seat from a to b, held by a spring: a check valve, or with much preload a relief valve."""
    drop = a.pressure - b.pressure
    ends = lift_range(drop, values)
    wanted = clip(state.lift, ends.low, ends.high)
    lift = select(values.opening_time > 0.0, state.lift, wanted)
    flow, loss = passage(orifice_flow(poppet_area(lift, values), drop, medium.density, values), a, b)
    rate = lagged_rate(wanted, state.lift, values.opening_time, values.closing_time)
    return PoppetPassage(flow, loss, LiftState(rate), poppet_side(drop, values))


def reducing_valve(a: FluidState, b: FluidState, state: OpeningState, values: ReducingValve) -> OpeningPassage:
    """Non-relieving pressure-reducing valve from a to b, which closes as the pressure at b rises."""
    y = select(values.opening_time > 0.0, state.opening, reducing_opening(b.pressure, values))
    flow, loss = rated_passage(a, b, y, values)
    rates = OpeningState(reducing_opening_rate(b.pressure, state.opening, values))
    return OpeningPassage(flow, loss, rates, reducing_side(b.pressure, values))


def reducing_start(values: ReducingValve) -> OpeningState:
    """Fully open, as a spring leaves it without pressure."""
    return OpeningState(1.0)


def flow_control_valve(
    a: FluidState, b: FluidState, values: FlowControlValve, opening: Fraction = 1.0
) -> FlowControlPassage:
    """Pressure-compensated flow control valve from a to b whose metering orifice is open by `opening` [1]."""
    drop = a.pressure - b.pressure
    flow, loss = passage(controlled_flow(drop, opening, values), a, b)
    return FlowControlPassage(flow, loss, controlled_side(drop, values))


def shuttle_valve(a: FluidState, b: FluidState, outlet: FluidState, values: ShuttleValve) -> ShuttleFlows:
    """Shuttle valve: its outlet is joined to that of the ends a and b whose pressure is higher."""
    difference = a.pressure - b.pressure
    position = ball_position(difference, values)
    from_a = rated_passage(a, outlet, position, values)
    from_b = rated_passage(b, outlet, 1.0 - position, values)
    return ShuttleFlows(
        a=-from_a.flow,
        b=-from_b.flow,
        outlet=from_a.flow + from_b.flow,
        loss=from_a.loss + from_b.loss,
        side=ball_side(difference, values),
    )


CHECK_VALVE = Component(check_valve, symbol="check_valve", start=check_start)
PILOT_CHECK_VALVE = Component(pilot_check_valve, symbol="pilot_check_valve", start=check_start)
PILOT_CLOSED_CHECK_VALVE = Component(pilot_closed_check_valve, symbol="pilot_closed_check_valve", start=check_start)
RELIEF_VALVE = Component(relief_valve, symbol="relief_valve")
LOAD_RELIEF_VALVE = Component(load_relief_valve, symbol="load_relief_valve")
SHOCK_VALVE = Component(shock_valve, symbol="relief_valve")
POPPET_VALVE = Component(poppet_valve, symbol="poppet_valve")
REDUCING_VALVE = Component(reducing_valve, symbol="reducing_valve", start=reducing_start)
FLOW_CONTROL_VALVE = Component(flow_control_valve, symbol="flow_control_valve")
SHUTTLE_VALVE = Component(shuttle_valve, symbol="shuttle_valve")
