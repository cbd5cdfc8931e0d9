"""Two-port valves that a command moves: proportional, metering, compensated, unloading, dump; throttles in series."""

from typing import NamedTuple

from vvdp.base.kinds import Flow, FlowCoefficient, Fraction, Kink, Power, PressureDifference
from vvdp.base.params import Params
from vvdp.base.rules import require_positive
from vvdp.base.select import clip
from vvdp.fluid.mixture import FluidState
from vvdp.hydraulics.characteristic import Characteristic, dead_band_side, flow_share
from vvdp.hydraulics.compensated_throttle import (
    CompensatedThrottle,
    compensator_rate,
    compensator_side,
    metering_share,
)
from vvdp.hydraulics.flow import passage
from vvdp.hydraulics.opening import OpeningPassage, OpeningState
from vvdp.hydraulics.proportional_valve import ProportionalValve, opening_rate, proportional_flow
from vvdp.hydraulics.seat_valve import SeatValve, seat_flow, seat_rate
from vvdp.hydraulics.series import first_share, series_flow
from vvdp.network.component import Component


class MeteringValve(ProportionalValve, Characteristic):
    """A proportional valve with a dead band whose flow grows linearly or progressively beyond it."""


class SeriesThrottles(Params):
    """Conductances fully open; the flow turns linear in the drop over both below about `transition_pressure`."""

    first_conductance: FlowCoefficient
    second_conductance: FlowCoefficient
    transition_pressure: PressureDifference

    def check(self) -> None:
        require_positive(self, "transition_pressure")


class ValvePassage(NamedTuple):
    """Flow through a controlled valve, and the rate of its opening."""

    flow: Flow
    loss: Power
    rates: OpeningState


class SeriesLosses(NamedTuple):
    """Losses over the first and over the second of two restrictions in series."""

    first: Power
    second: Power


class SeriesPassage(NamedTuple):
    """Flow through two restrictions in series."""

    flow: Flow
    losses: SeriesLosses


class CompensatedLosses(NamedTuple):
    """Losses over a metering throttle, and over the compensator before it."""

    metering: Power
    compensator: Power


class CompensatedPassage(NamedTuple):
    """Flow through a compensated throttle, the rate of its compensator, and where that stands."""

    flow: Flow
    losses: CompensatedLosses
    rates: OpeningState
    side: Kink


def proportional_valve(
    a: FluidState, b: FluidState, command: Fraction, state: OpeningState, values: ProportionalValve
) -> ValvePassage:
    """Proportional valve between a and b; its opening follows `command` [1]."""
    flow, loss = passage(proportional_flow(a.pressure - b.pressure, state.opening, values), a, b)
    return ValvePassage(flow, loss, OpeningState(opening_rate(command, state.opening, values)))


def metering_valve(
    a: FluidState, b: FluidState, command: Fraction, state: OpeningState, values: MeteringValve
) -> OpeningPassage:
    """Proportional valve with dead band and rangeability; the position of its spool follows `command` [1]."""
    share = flow_share(state.opening, values)
    flow, loss = passage(proportional_flow(a.pressure - b.pressure, share, values), a, b)
    rates = OpeningState(opening_rate(command, state.opening, values))
    return OpeningPassage(flow, loss, rates, dead_band_side(state.opening, values))


def unloading_valve(
    a: FluidState, b: FluidState, unloaded: Fraction, state: OpeningState, values: SeatValve
) -> ValvePassage:
    """Valve that lets a pump's flow at a go to the tank at b while `unloaded` is 1; see `unloading_step`."""
    flow, loss = passage(seat_flow(a.pressure - b.pressure, state.opening, values), a, b)
    return ValvePassage(flow, loss, OpeningState(seat_rate(unloaded, state.opening, values)))


def dump_valve(a: FluidState, b: FluidState, command: Fraction, state: OpeningState, values: SeatValve) -> ValvePassage:
    """Valve between a and b that a command of 1 holds closed and that opens without one."""
    flow, loss = passage(seat_flow(a.pressure - b.pressure, state.opening, values), a, b)
    return ValvePassage(flow, loss, OpeningState(seat_rate(1.0 - command, state.opening, values)))


def dump_start(values: SeatValve) -> OpeningState:
    """Open, as without a command."""
    return OpeningState(1.0)


def series_throttles(
    a: FluidState, b: FluidState, first_opening: Fraction, second_opening: Fraction, values: SeriesThrottles
) -> SeriesPassage:
    """Two throttles one after the other between a and b, without a volume between them.

    The loss is divided as the drop is.
    """
    first = values.first_conductance * clip(first_opening, 0.0, 1.0)
    second = values.second_conductance * clip(second_opening, 0.0, 1.0)
    flow, loss = passage(series_flow(a.pressure - b.pressure, first, second, values.transition_pressure), a, b)
    share = first_share(first, second)
    return SeriesPassage(flow, SeriesLosses(share * loss, (1.0 - share) * loss))


def compensated_throttle(
    a: FluidState, b: FluidState, command: Fraction, state: OpeningState, values: CompensatedThrottle
) -> CompensatedPassage:
    """Throttle open by `command` [1] behind a pressure compensator, from a to b, without a volume between them."""
    opening, lift = clip(command, 0.0, 1.0), clip(state.opening, 0.0, 1.0)
    drop = a.pressure - b.pressure
    first, second = values.compensator_conductance * lift, values.conductance * opening
    flow, loss = passage(series_flow(drop, first, second, values.transition_pressure), a, b)
    share = metering_share(opening, lift, values)
    rates = OpeningState(compensator_rate(share * drop, state.opening, values))
    losses = CompensatedLosses(share * loss, (1.0 - share) * loss)
    return CompensatedPassage(flow, losses, rates, compensator_side(share * drop, values))


def compensated_start(values: CompensatedThrottle) -> OpeningState:
    """Fully open, as its spring leaves the compensator without pressure."""
    return OpeningState(1.0)


PROPORTIONAL_VALVE = Component(proportional_valve, symbol="proportional_valve")
METERING_VALVE = Component(metering_valve, symbol="proportional_valve")
UNLOADING_VALVE = Component(unloading_valve, symbol="unloading_valve")
DUMP_VALVE = Component(dump_valve, symbol="switching_valve_2_2", start=dump_start)
SERIES_THROTTLES = Component(series_throttles, symbol="two_orifices")
COMPENSATED_THROTTLE = Component(compensated_throttle, symbol="flow_control_valve", start=compensated_start)
