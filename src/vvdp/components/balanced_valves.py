"""Valves that a balance of pressures opens: sequence, counterbalance, brake, priority, cartridge, compensators."""

from typing import NamedTuple

from vvdp.base.kinds import Flow, Kink, Power
from vvdp.base.select import clip, select
from vvdp.fluid.mixture import FluidState
from vvdp.hydraulics.balanced_valve import (
    BalancedValve,
    CartridgeValve,
    balanced_travel,
    cartridge_lift,
    lift_rate,
    lift_side,
    opening_share,
)
from vvdp.hydraulics.counterbalance_valve import (
    CounterbalanceValve,
    SequenceValve,
    pilot_aid,
    reverse_side,
    two_way_flow,
)
from vvdp.hydraulics.flow import passage, rated_passage
from vvdp.hydraulics.opening import OpeningPassage, OpeningState, lagged_rate
from vvdp.network.component import Component


class TwoWayPassage(NamedTuple):
    """Flow through a valve with a check valve beside it, the rate of its opening, and where both stand."""

    flow: Flow
    loss: Power
    rates: OpeningState
    side: Kink
    reverse: Kink


class PriorityFlows(NamedTuple):
    """Flows of a priority valve into its nodes, its loss, the rate of its travel, and where its spool stands."""

    inlet: Flow
    priority: Flow
    excess: Flow
    loss: Power
    rates: OpeningState
    side: Kink


def sequence_valve(
    a: FluidState, b: FluidState, drain: FluidState, state: OpeningState, values: SequenceValve
) -> TwoWayPassage:
    """Valve that opens from a to b when the pressure at a is far enough above that at its drain, where no oil flows.

    Its check valve lets oil pass from b to a.
    """
    return _two_way(a, b, a.pressure - drain.pressure, state, values)


def counterbalance_valve(
    a: FluidState, b: FluidState, pilot: FluidState, state: OpeningState, values: CounterbalanceValve
) -> TwoWayPassage:
    """Overcentre valve: it holds the load at a until that pressure and the pilot's, where no oil flows, open it to b.

    Its check valve lets oil pass from b to a.
    """
    aid = pilot_aid(pilot.pressure - b.pressure, values)
    return _two_way(a, b, a.pressure - b.pressure + aid, state, values)


def brake_valve(
    a: FluidState, b: FluidState, pilot: FluidState, state: OpeningState, values: SequenceValve
) -> TwoWayPassage:
    """Brake valve of a motor: only the pressure at its pilot, that of the motor's inlet, opens the return from a to b.

    No oil flows at the pilot port. Its check valve lets oil pass from b to a.
    """
    return _two_way(a, b, pilot.pressure - b.pressure, state, values)


def _two_way(a: FluidState, b: FluidState, lifting: float, state: OpeningState, values: SequenceValve) -> TwoWayPassage:
    """A valve from a to b that a pressure above that behind its spring opens."""
    drop = a.pressure - b.pressure
    flow, loss = passage(two_way_flow(drop, balanced_travel(lifting, state.opening, values), values), a, b)
    rates = OpeningState(lift_rate(lifting, state.opening, values))
    return TwoWayPassage(flow, loss, rates, lift_side(lifting, values), reverse_side(drop, values))


def _one_edge(
    a: FluidState, b: FluidState, lifting: float, state: OpeningState, values: BalancedValve
) -> OpeningPassage:
    """A valve between a and b that a pressure above that behind its spring opens, either way."""
    y = balanced_travel(lifting, state.opening, values)
    flow, loss = rated_passage(a, b, y, values)
    rates = OpeningState(lift_rate(lifting, state.opening, values))
    return OpeningPassage(flow, loss, rates, lift_side(lifting, values))


def cartridge_valve(
    a: FluidState, b: FluidState, pilot: FluidState, state: OpeningState, values: CartridgeValve
) -> OpeningPassage:
    """Cartridge (logic) valve: a poppet between a and b that the pressures there lift and that at its back closes.

    No oil flows at the pilot port.
    """
    lifting = cartridge_lift(a.pressure, b.pressure, pilot.pressure, values)
    return _one_edge(a, b, lifting, state, values)


def downstream_compensator(
    a: FluidState, b: FluidState, pilot: FluidState, state: OpeningState, values: BalancedValve
) -> OpeningPassage:
    """Compensator behind a throttle, which opens when its inlet is far enough above its pilot, the largest load.

    No oil flows at the pilot port. Sections that share a pilot share the pump flow in proportion.
    """
    return _one_edge(a, b, a.pressure - pilot.pressure, state, values)


def upstream_compensator(
    a: FluidState, b: FluidState, pilot: FluidState, state: OpeningState, values: BalancedValve
) -> OpeningPassage:
    """Compensator before a throttle, which closes as the drop from its outlet to its pilot, the load, grows.

    No oil flows at the pilot port.
    """
    drop = b.pressure - pilot.pressure
    static = 1.0 - clip(opening_share(drop, values), 0.0, 1.0)
    y = select(values.opening_time > 0.0, state.opening, static)
    flow, loss = rated_passage(a, b, y, values)
    rates = OpeningState(lagged_rate(static, state.opening, values.opening_time))
    return OpeningPassage(flow, loss, rates, lift_side(drop, values))


def upstream_start(values: BalancedValve) -> OpeningState:
    """Fully open, as its spring leaves it without pressure."""
    return OpeningState(1.0)


def priority_valve(
    inlet: FluidState,
    priority: FluidState,
    excess: FluidState,
    pilot: FluidState,
    state: OpeningState,
    values: BalancedValve,
) -> PriorityFlows:
    """Priority valve: what one consumer needs goes there first, the rest to `excess`.

    Its spool leaves the priority port as the pressure there rises above that of the pilot, behind the consumer's
    throttle, where no oil flows. With a fixed throttle it is a three-way flow regulator.
    """
    drop = priority.pressure - pilot.pressure
    y = balanced_travel(drop, state.opening, values)
    first = rated_passage(inlet, priority, 1.0 - y, values)
    rest = rated_passage(inlet, excess, y, values)
    return PriorityFlows(
        inlet=-first.flow - rest.flow,
        priority=first.flow,
        excess=rest.flow,
        loss=first.loss + rest.loss,
        rates=OpeningState(lift_rate(drop, state.opening, values)),
        side=lift_side(drop, values),
    )


SEQUENCE_VALVE = Component(sequence_valve, symbol="sequence_valve")
COUNTERBALANCE_VALVE = Component(counterbalance_valve, symbol="counterbalance_valve")
BRAKE_VALVE = Component(brake_valve, symbol="brake_valve")
CARTRIDGE_VALVE = Component(cartridge_valve, symbol="cartridge_valve")
DOWNSTREAM_COMPENSATOR = Component(downstream_compensator, symbol="downstream_compensator")
UPSTREAM_COMPENSATOR = Component(upstream_compensator, symbol="upstream_compensator", start=upstream_start)
PRIORITY_VALVE = Component(priority_valve, symbol="priority_valve")
