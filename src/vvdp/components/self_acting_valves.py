"""Valves that the pressures at their ports move: check, relief, reducing and flow control valves."""

from typing import NamedTuple

from vvdp.base.kinds import Flow, Fraction, Kink, Mode, Power
from vvdp.base.select import clip, select
from vvdp.fluid.mixture import FluidState
from vvdp.hydraulics.check_valve import (
    CheckState,
    CheckValve,
    check_opening,
    check_opening_rate,
    check_side,
    poppet_flow,
)
from vvdp.hydraulics.counterbalance_valve import (
    CounterbalanceValve,
    SequenceValve,
    lift_rate,
    lift_side,
    opening_share,
    pilot_aid,
    reverse_side,
    two_way_flow,
)
from vvdp.hydraulics.flow import passage
from vvdp.hydraulics.flow_control_valve import FlowControlValve, controlled_flow, controlled_side
from vvdp.hydraulics.pilot_check_valve import PilotCheckValve, lifting_drop
from vvdp.hydraulics.ports import Surplus
from vvdp.hydraulics.proportional_valve import OpeningState
from vvdp.hydraulics.reducing_valve import (
    ReducingValve,
    reducing_flow,
    reducing_opening,
    reducing_opening_rate,
    reducing_side,
)
from vvdp.hydraulics.relief_valve import (
    LoadReliefValve,
    ReliefState,
    ReliefValve,
    ShockValve,
    opened_relief_flow,
    relief_flow,
    relief_mode,
    relief_opening,
    relief_opening_rate,
    setting_fall,
    throttled_relief_flow,
)
from vvdp.hydraulics.shuttle_valve import ShuttleValve, ball_position, ball_side, seat_flow
from vvdp.network.component import Component


class CheckPassage(NamedTuple):
    """What goes through a check valve, the rate of its poppet, and where that stands."""

    flow: Flow
    loss: Power
    rates: CheckState
    side: Kink


class PilotCheckFlows(NamedTuple):
    """Flows of a pilot-operated check valve into its nodes, its loss, the rate of its poppet, and where that stands."""

    a: Flow
    b: Flow
    loss: Power
    rates: CheckState
    side: Kink


class ReliefPassage(NamedTuple):
    """What goes over a relief valve, the rate of its opening, and whether it is open."""

    flow: Flow
    loss: Power
    rates: ReliefState
    mode: Mode


class LoadReliefFlows(NamedTuple):
    """Flows of a relief valve that follows a load into its nodes, its loss, the rate of its opening, and its mode."""

    a: Flow
    b: Flow
    loss: Power
    rates: ReliefState
    mode: Mode


class ReducingPassage(NamedTuple):
    """What goes through a reducing valve, the rate of its opening, and where that stands."""

    flow: Flow
    loss: Power
    rates: OpeningState
    side: Kink


class FlowControlPassage(NamedTuple):
    """What goes through a flow control valve, and on which side of the drops that it balances."""

    flow: Flow
    loss: Power
    side: Kink


class SequenceFlows(NamedTuple):
    """Flows of a sequence or counterbalance valve into its nodes, its loss, the rate of its opening, and where its
    poppet and its check valve stand."""

    a: Flow
    b: Flow
    loss: Power
    rates: OpeningState
    side: Kink
    reverse: Kink


class ShuttleFlows(NamedTuple):
    """Flows of a shuttle valve into its nodes, its loss, and where its ball stands."""

    a: Flow
    b: Flow
    outlet: Flow
    loss: Power
    side: Kink


def check_valve(a: FluidState, b: FluidState, state: CheckState, values: CheckValve) -> CheckPassage:
    """Check valve that opens from a to b; its poppet follows with its opening time, without one at once."""
    drop = a.pressure - b.pressure
    y = select(values.opening_time > 0.0, state.opening, check_opening(drop, values))
    flow, loss = passage(poppet_flow(drop, y, values), a, b)
    rates = CheckState(check_opening_rate(drop, state.opening, values))
    return CheckPassage(flow, loss, rates, check_side(drop, values))


def check_start(values: CheckValve) -> CheckState:
    """On its seat."""
    return CheckState(values.reverse_opening)


def pilot_check_valve(
    a: FluidState, b: FluidState, pilot: FluidState, state: CheckState, values: PilotCheckValve
) -> PilotCheckFlows:
    """Check valve that opens from a to b, and either way when the pilot's pressure exceeds that at a by enough.

    No oil flows at the pilot port.
    """
    drop = a.pressure - b.pressure
    lifting = lifting_drop(drop, pilot.pressure - a.pressure, values)
    y = select(values.opening_time > 0.0, state.opening, check_opening(lifting, values))
    flow, loss = passage(poppet_flow(drop, y, values), a, b)
    rates = CheckState(check_opening_rate(lifting, state.opening, values))
    return PilotCheckFlows(-flow, flow, loss, rates, check_side(lifting, values))


def pilot_check_start(values: PilotCheckValve) -> CheckState:
    """On its seat."""
    return CheckState(values.reverse_opening)


def relief_valve(
    a: FluidState, b: FluidState, surplus: Surplus, mode: Mode, state: ReliefState, values: ReliefValve
) -> ReliefPassage:
    """Relief valve that limits the pressure at a; see `relief_flow` for its three limits.

    An ideal one gives nothing to a side that is under a higher pressure.
    """
    flow, loss = passage(relief_flow(a.pressure, b.pressure, state.opening, surplus, mode, values), a, b)
    rates = ReliefState(relief_opening_rate(a.pressure, state.opening, mode, values))
    return ReliefPassage(flow, loss, rates, relief_mode(a.pressure, b.pressure, surplus, mode, values))


def shock_valve(a: FluidState, b: FluidState, mode: Mode, state: ReliefState, values: ShockValve) -> ReliefPassage:
    """Relief valve with an override that limits the pressure at a, also where others do at the same volume.

    `relief_valve` needs the flows of everything else at its volume, so that two of them, each from one side of a
    motor to the other, would wait for each other.
    """
    flow, loss = passage(throttled_relief_flow(a.pressure, b.pressure, state.opening, mode, values), a, b)
    rates = ReliefState(relief_opening_rate(a.pressure, state.opening, mode, values))
    return ReliefPassage(flow, loss, rates, relief_mode(a.pressure, b.pressure, 0.0, mode, values))


def load_relief_valve(
    a: FluidState, b: FluidState, pilot: FluidState, mode: Mode, state: ReliefState, values: LoadReliefValve
) -> LoadReliefFlows:
    """Relief valve that limits the pressure at a to a margin above that at the pilot, where no oil flows."""
    felt = a.pressure + setting_fall(pilot.pressure, values)
    y = select(values.opening_time > 0.0, state.opening, relief_opening(felt, mode, values))
    flow, loss = passage(opened_relief_flow(a.pressure - b.pressure, b.pressure, y, values), a, b)
    rates = ReliefState(relief_opening_rate(felt, state.opening, mode, values))
    return LoadReliefFlows(-flow, flow, loss, rates, relief_mode(felt, b.pressure, 0.0, mode, values))


def reducing_valve(a: FluidState, b: FluidState, state: OpeningState, values: ReducingValve) -> ReducingPassage:
    """Reducing valve from a to b, which shuts as the pressure at b rises; it opens no way from b to a tank."""
    y = select(values.opening_time > 0.0, state.opening, reducing_opening(b.pressure, values))
    flow, loss = passage(reducing_flow(a.pressure - b.pressure, y, values), a, b)
    rates = OpeningState(reducing_opening_rate(b.pressure, state.opening, values))
    return ReducingPassage(flow, loss, rates, reducing_side(b.pressure, values))


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


def sequence_valve(
    a: FluidState, b: FluidState, drain: FluidState, state: OpeningState, values: SequenceValve
) -> SequenceFlows:
    """Valve that opens from a to b when the pressure at a is far enough above that at its drain, where no oil flows.

    Its check valve lets oil pass from b to a.
    """
    return _sequence_flows(a, b, a.pressure - drain.pressure, state, values)


def counterbalance_valve(
    a: FluidState, b: FluidState, pilot: FluidState, state: OpeningState, values: CounterbalanceValve
) -> SequenceFlows:
    """Overcentre valve: it holds the load at a until that pressure and the pilot's, where no oil flows, open it to b.

    Its check valve lets oil pass from b to a.
    """
    aid = pilot_aid(pilot.pressure - b.pressure, values)
    return _sequence_flows(a, b, a.pressure - b.pressure + aid, state, values)


def _sequence_flows(
    a: FluidState, b: FluidState, lifting: float, state: OpeningState, values: SequenceValve
) -> SequenceFlows:
    """A valve from a to b that a pressure above that behind its spring opens."""
    y = select(values.opening_time > 0.0, state.opening, clip(opening_share(lifting, values), 0.0, 1.0))
    drop = a.pressure - b.pressure
    flow, loss = passage(two_way_flow(drop, y, values), a, b)
    return SequenceFlows(
        a=-flow,
        b=flow,
        loss=loss,
        rates=OpeningState(lift_rate(lifting, state.opening, values)),
        side=lift_side(lifting, values),
        reverse=reverse_side(drop, values),
    )


def shuttle_valve(a: FluidState, b: FluidState, outlet: FluidState, values: ShuttleValve) -> ShuttleFlows:
    """Shuttle valve: its outlet is joined to that of the ends a and b whose pressure is higher."""
    difference = a.pressure - b.pressure
    position = ball_position(difference, values)
    from_a = passage(seat_flow(a.pressure - outlet.pressure, position, values), a, outlet)
    from_b = passage(seat_flow(b.pressure - outlet.pressure, 1.0 - position, values), b, outlet)
    return ShuttleFlows(
        a=-from_a.flow,
        b=-from_b.flow,
        outlet=from_a.flow + from_b.flow,
        loss=from_a.loss + from_b.loss,
        side=ball_side(difference, values),
    )


CHECK_VALVE = Component(check_valve, symbol="check_valve", start=check_start)
PILOT_CHECK_VALVE = Component(pilot_check_valve, symbol="pilot_check_valve", start=pilot_check_start)
RELIEF_VALVE = Component(relief_valve, symbol="relief_valve")
LOAD_RELIEF_VALVE = Component(load_relief_valve, symbol="relief_valve")
SHOCK_VALVE = Component(shock_valve, symbol="relief_valve")
REDUCING_VALVE = Component(reducing_valve, symbol="reducing_valve", start=reducing_start)
FLOW_CONTROL_VALVE = Component(flow_control_valve, symbol="flow_control_valve")
SEQUENCE_VALVE = Component(sequence_valve, symbol="sequence_valve")
COUNTERBALANCE_VALVE = Component(counterbalance_valve, symbol="counterbalance_valve")
SHUTTLE_VALVE = Component(shuttle_valve, symbol="shuttle_valve")
