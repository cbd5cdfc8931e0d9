"""Switching valves, three-way and two-way, moved by a command, by pulses of fixed duty ratio, or by a duty ratio."""

from typing import NamedTuple

from vvdp.base.kinds import Area, Flow, Fraction, Kink, Mode, Position, Power
from vvdp.base.rules import refuse
from vvdp.base.select import select
from vvdp.fluid.mixture import FluidState
from vvdp.hydraulics.flow import passage
from vvdp.hydraulics.orifice import Orifice, orifice_flow
from vvdp.hydraulics.ports import Medium
from vvdp.hydraulics.switching_valve import (
    PulseClock,
    PulseTrain,
    SpoolEnds,
    SpoolState,
    SwitchingValve,
    port_areas,
    port_sides,
    pulse_edge,
    pulse_periods,
    pulse_stop,
    pulse_train,
    pulse_value,
    spool_ends,
    spool_rate,
)
from vvdp.network.component import Component


class ThreeWayValve(SwitchingValve, Orifice):
    """Spool and ports of a three-way switching valve."""


class PulsedThreeWayValve(ThreeWayValve, PulseTrain):
    """A three-way switching valve and the pulses that move it."""


class ModulatedThreeWayValve(ThreeWayValve, PulseClock):
    """A three-way switching valve and the frequency at which it is pulsed."""


class TwoWayValve(SwitchingValve, Orifice):
    """Spool and port of a two-way switching valve; `normally_open` is 1 where a command closes it, else 0."""

    normally_open: Fraction = 0.0

    def check(self) -> None:
        if self.normally_open not in (0.0, 1.0):
            refuse(self, "normally_open", "must be 0 or 1")


class PulsedTwoWayValve(TwoWayValve, PulseTrain):
    """A two-way switching valve and the pulses that move it."""


class ModulatedTwoWayValve(TwoWayValve, PulseClock):
    """A two-way switching valve and the frequency at which it is pulsed."""


class ThreeWayFlows(NamedTuple):
    """Flows of a three-way valve into its nodes, its loss, the rates of its spool, the areas and the modes of its ports
    and of the ends of its stroke."""

    pressure: Flow
    first: Flow
    second: Flow
    loss: Power
    rates: SpoolState
    first_area: Area
    second_area: Area
    first_side: Kink
    second_side: Kink
    at_first: Mode
    at_second: Mode


class TwoWayPassage(NamedTuple):
    """Flow through a two-way valve, the rates of its spool, the area and the modes of its port and of its ends."""

    flow: Flow
    loss: Power
    rates: SpoolState
    area: Area
    side: Kink
    at_first: Mode
    at_second: Mode


def switching_valve(
    pressure: FluidState,
    first: FluidState,
    second: FluidState,
    command: Fraction,
    at_first: Mode,
    at_second: Mode,
    state: SpoolState,
    medium: Medium,
    values: ThreeWayValve,
) -> ThreeWayFlows:
    """3/2 valve that joins pressure to first while `command` is 1, and to second while it is 0."""
    return _three_way(pressure, first, second, _spool(command, state, at_first, at_second, values), medium, values)


def pulsed_switching_valve(
    t: float,
    pressure: FluidState,
    first: FluidState,
    second: FluidState,
    at_first: Mode,
    at_second: Mode,
    state: SpoolState,
    medium: Medium,
    values: PulsedThreeWayValve,
) -> ThreeWayFlows:
    """3/2 valve on a pulse train of fixed frequency and duty ratio."""
    spool = _spool(pulse_train(t, values), state, at_first, at_second, values)
    return _three_way(pressure, first, second, spool, medium, values)


def modulated_switching_valve(
    t: float,
    pressure: FluidState,
    first: FluidState,
    second: FluidState,
    duty_ratio: Fraction,
    at_first: Mode,
    at_second: Mode,
    state: SpoolState,
    medium: Medium,
    values: ModulatedThreeWayValve,
) -> ThreeWayFlows:
    """3/2 valve on pulses of fixed frequency, whose duty ratio is held between samples."""
    spool = _spool(pulse_value(t, duty_ratio, values.frequency), state, at_first, at_second, values)
    return _three_way(pressure, first, second, spool, medium, values)


def two_way_valve(
    a: FluidState,
    b: FluidState,
    command: Fraction,
    at_first: Mode,
    at_second: Mode,
    state: SpoolState,
    medium: Medium,
    values: TwoWayValve,
) -> TwoWayPassage:
    """2/2 valve between a and b that `command` 1 opens, or closes where it is normally open."""
    return _two_way(a, b, _spool(command, state, at_first, at_second, values), medium, values)


def pulsed_two_way_valve(
    t: float,
    a: FluidState,
    b: FluidState,
    at_first: Mode,
    at_second: Mode,
    state: SpoolState,
    medium: Medium,
    values: PulsedTwoWayValve,
) -> TwoWayPassage:
    """2/2 valve on a pulse train of fixed frequency and duty ratio."""
    return _two_way(a, b, _spool(pulse_train(t, values), state, at_first, at_second, values), medium, values)


def modulated_two_way_valve(
    t: float,
    a: FluidState,
    b: FluidState,
    duty_ratio: Fraction,
    at_first: Mode,
    at_second: Mode,
    state: SpoolState,
    medium: Medium,
    values: ModulatedTwoWayValve,
) -> TwoWayPassage:
    """2/2 valve on pulses of fixed frequency, whose duty ratio is held between samples."""
    spool = _spool(pulse_value(t, duty_ratio, values.frequency), state, at_first, at_second, values)
    return _two_way(a, b, spool, medium, values)


def modulated_stop(t: float, duty_ratio: Fraction, values: PulseClock) -> float:
    """The next edge [s] of pulses at the duty ratio that holds."""
    return pulse_edge(t, duty_ratio, values.frequency)


class _Spool(NamedTuple):
    """Position of a switching spool, its rates, and the end of the stroke that holds it."""

    position: Position
    rates: SpoolState
    ends: SpoolEnds


def _spool(command: float, state: SpoolState, at_first: float, at_second: float, values: SwitchingValve) -> _Spool:
    """Response of a spool to a command."""
    rates = spool_rate(command, state, at_first, at_second, values)
    return _Spool(state.position, rates, spool_ends(state, at_first, at_second, values))


def _three_way(
    pressure: FluidState, first: FluidState, second: FluidState, spool: _Spool, medium: Medium, values: ThreeWayValve
) -> ThreeWayFlows:
    """Flows of a three-way valve whose spool moves like this."""
    areas, sides = port_areas(spool.position, values), port_sides(spool.position, values)
    drop_1, drop_2 = pressure.pressure - first.pressure, pressure.pressure - second.pressure
    to_first = passage(orifice_flow(areas.first, drop_1, medium.density, values), pressure, first)
    to_second = passage(orifice_flow(areas.second, drop_2, medium.density, values), pressure, second)
    return ThreeWayFlows(
        pressure=-to_first.flow - to_second.flow,
        first=to_first.flow,
        second=to_second.flow,
        loss=to_first.loss + to_second.loss,
        rates=spool.rates,
        first_area=areas.first,
        second_area=areas.second,
        first_side=sides.first,
        second_side=sides.second,
        at_first=spool.ends.first,
        at_second=spool.ends.second,
    )


def _two_way(a: FluidState, b: FluidState, spool: _Spool, medium: Medium, values: TwoWayValve) -> TwoWayPassage:
    """Flow of a two-way valve whose spool moves like this."""
    areas, sides = port_areas(spool.position, values), port_sides(spool.position, values)
    opens = values.normally_open > 0.5
    area, edge = select(opens, areas.second, areas.first), select(opens, sides.second, sides.first)
    flow, loss = passage(orifice_flow(area, a.pressure - b.pressure, medium.density, values), a, b)
    return TwoWayPassage(
        flow=flow,
        loss=loss,
        rates=spool.rates,
        area=area,
        side=edge,
        at_first=spool.ends.first,
        at_second=spool.ends.second,
    )


SWITCHING_VALVE = Component(switching_valve, symbol="switching_valve_3_2")
PULSED_SWITCHING_VALVE = Component(
    pulsed_switching_valve,
    symbol="switching_valve_3_2",
    stop=pulse_stop,
    mark=pulse_periods,
)
MODULATED_SWITCHING_VALVE = Component(
    modulated_switching_valve,
    symbol="switching_valve_3_2",
    stop=modulated_stop,
    mark=pulse_periods,
)
TWO_WAY_VALVE = Component(two_way_valve, symbol="switching_valve_2_2")
PULSED_TWO_WAY_VALVE = Component(
    pulsed_two_way_valve, symbol="switching_valve_2_2", stop=pulse_stop, mark=pulse_periods
)
MODULATED_TWO_WAY_VALVE = Component(
    modulated_two_way_valve, symbol="switching_valve_2_2", stop=modulated_stop, mark=pulse_periods
)
