"""A switching circuit with conditions, a controller and a display: what the tests of runs, batches and books share."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any, NamedTuple

import pytest

from vvdp.base.conservation import Books, Nothing, Stored
from vvdp.base.kinds import (
    Area,
    Count,
    Energy,
    Flow,
    Fraction,
    Frequency,
    Kink,
    Mode,
    Pressure,
    PressureSignal,
    PressureTime,
    Ratio,
    Volume,
)
from vvdp.base.params import Params
from vvdp.base.select import clip
from vvdp.base.signal import constant, signal_stop, signal_value
from vvdp.fluid.mixture import fluid_state
from vvdp.fluid.oil import Oil
from vvdp.hydraulics.flow import passage
from vvdp.hydraulics.orifice import Orifice, orifice_flow
from vvdp.hydraulics.switching_valve import (
    SpoolState,
    SwitchingValve,
    port_areas,
    port_sides,
    pulse_stop,
    pulse_train,
    spool_ends,
    spool_rate,
)
from vvdp.hydraulics.volume import closed_volume_contents, closed_volume_rate
from vvdp.simulation.model import Case, Model, Program, initial_case

BAR, LPM = 1e5, 1e-3 / 60.0


class Supplied(NamedTuple):
    pump: Energy


class Spent(NamedTuple):
    to_load: Energy
    to_tank: Energy
    load: Energy


class Totals(NamedTuple):
    load_pressure: PressureTime


class State(NamedTuple):
    inlet_pressure: Pressure
    load_pressure: Pressure
    spool: SpoolState
    books: Books


class Outputs(NamedTuple):
    load_flow: Flow
    tank_flow: Flow


class Train(NamedTuple):
    frequency: Frequency
    duty_ratio: Fraction


class Held(NamedTuple):
    tank_pressure: Pressure


class Shown(NamedTuple):
    mean: Pressure
    samples: Count


class Modes(NamedTuple):
    first_side: Kink
    second_side: Kink
    at_first: Mode
    at_second: Mode


class Command(NamedTuple):
    held: Held
    modes: Modes
    controller: Train
    display: Shown


class Values(Params):
    oil: Oil
    pump_flow: Flow
    inlet_volume: Volume
    valve: SwitchingValve
    load_volume: Volume
    load_area: Area
    orifice: Orifice
    tank_pressure: PressureSignal


class Controller(Params):
    frequency: Frequency
    reference: Pressure
    gain: Ratio


class Reading(NamedTuple):
    load_pressure: Pressure


class Integral(NamedTuple):
    duty_ratio: Fraction


class Mean(NamedTuple):
    mean: Pressure
    samples: Count


def start(p: Values) -> State:
    tank = p.tank_pressure.base
    books = Books(Supplied(0.0), Spent(0.0, 0.0, 0.0), 0.0, 0.0, Totals(0.0))
    return State(tank, tank, SpoolState(0.0, 0.0), books)


def conditions(t: float, p: Values) -> Held:
    return Held(signal_value(t, p.tank_pressure))


def circuit(t: float, s: State, u: Command, p: Values) -> tuple[State, Outputs, Modes]:
    reference = fluid_state(p.oil.reference_pressure, p.oil)
    tank, rho = fluid_state(u.held.tank_pressure, p.oil), p.oil.density
    inlet, load = fluid_state(s.inlet_pressure, p.oil), fluid_state(s.load_pressure, p.oil)
    areas, sides = port_areas(s.spool.position, p.valve), port_sides(s.spool.position, p.valve)
    ends = spool_ends(s.spool, u.modes.at_first, u.modes.at_second, p.valve)
    to_load = passage(orifice_flow(areas.first, s.inlet_pressure - s.load_pressure, rho, p.orifice), inlet, load)
    to_tank = passage(orifice_flow(areas.second, s.inlet_pressure - u.held.tank_pressure, rho, p.orifice), inlet, tank)
    out = passage(orifice_flow(p.load_area, s.load_pressure - u.held.tank_pressure, rho, p.orifice), load, tank)
    returned = to_tank.flow + out.flow
    rates = State(
        inlet_pressure=closed_volume_rate(p.pump_flow - to_load.flow - to_tank.flow, 0.0, p.inlet_volume, inlet),
        load_pressure=closed_volume_rate(to_load.flow - out.flow, 0.0, p.load_volume, load),
        spool=spool_rate(pulse_train(t, u.controller), s.spool, u.modes.at_first, u.modes.at_second, p.valve),
        books=Books(
            supplied=Supplied(
                p.pump_flow * (inlet.enthalpy - reference.enthalpy) - returned * (tank.enthalpy - reference.enthalpy)
            ),
            spent=Spent(to_load.loss, to_tank.loss, out.loss),
            taken_in=p.pump_flow,
            given_out=returned,
            totals=Totals(s.load_pressure),
        ),
    )
    modes = Modes(sides.first, sides.second, ends.first, ends.second)
    return rates, Outputs(to_load.flow, to_tank.flow), modes


def stored(s: State, p: Values) -> Stored:
    inlet = closed_volume_contents(fluid_state(s.inlet_pressure, p.oil), p.inlet_volume, p.oil)
    load = closed_volume_contents(fluid_state(s.load_pressure, p.oil), p.load_volume, p.oil)
    return Stored(inlet.energy + load.energy, inlet.volume + load.volume)


def periods(t: float, s: State, u: Command, p: Values) -> float:
    return t * u.controller.frequency


def edges(t: float, u: Command, p: Values) -> float:
    later, corner = pulse_stop(t, u.controller), signal_stop(t, p.tank_pressure)
    return min(later, corner)


def sense(t: float, s: State, o: Outputs, p: Values) -> Reading:
    return Reading(s.load_pressure)


def control(t: float, memory: Integral, r: Reading, settings: Controller) -> tuple[Integral, Train]:
    duty = clip(memory.duty_ratio + settings.gain * (settings.reference - r.load_pressure) / 1e7, 0.0, 1.0)
    return Integral(duty), Train(settings.frequency, duty)


def display(t: float, memory: Mean, r: Reading, settings: Nothing) -> tuple[Mean, Shown]:
    samples = memory.samples + 1.0
    mean = memory.mean + (r.load_pressure - memory.mean) / samples
    return Mean(mean, samples), Shown(mean, samples)


def half_duty(settings: Controller) -> Integral:
    return Integral(0.5)


def blank_mean(settings: Nothing) -> Mean:
    return Mean(0.0, 0.0)


CONTROLLER = Program(sense, control, Train(75.0, 0.5), half_duty, period=1.0 / 75.0, latency=1e-3)
DISPLAY = Program(sense, display, Shown(0.0, 0.0), blank_mean, period=2.3e-3, phase=1e-3)
MODEL = Model(circuit, stored, start, conditions, {"controller": CONTROLLER, "display": DISPLAY}, periods, edges)


def values(**changes: Any) -> Values:
    """The circuit with its usual numbers, but for `changes`."""
    oil = Oil(
        density=870.0,
        thermal_expansion=7e-4,
        viscosity_40=46e-6,
        viscosity_100=6.8e-6,
        liquid_bulk_modulus=1.4e9,
        air_fraction=0.01,
        polytropic_exponent=1.4,
        reference_pressure=101325.0,
    )
    usual = Values(
        oil=oil,
        pump_flow=20.0 * LPM,
        inlet_volume=20e-6,
        valve=SwitchingValve(natural_frequency=400.0, damping_ratio=0.7, stroke=1e-3, lap=-2e-4, full_area=2e-5),
        load_volume=1e-3,
        load_area=5e-6,
        orifice=Orifice(discharge_coefficient=0.61, transition_pressure=1e4),
        tank_pressure=constant(101325.0),
    )
    return replace(usual, **changes)


def switching_case(reference: float = 15.0 * BAR, frequency: float = 75.0, **changes: Any) -> Case:
    """A case of the switching circuit, its controller on the way to `reference` [Pa, absolute]."""
    settings = {"controller": Controller(frequency=frequency, reference=reference, gain=0.05)}
    return initial_case(MODEL, Command, values(**changes), settings)


@pytest.fixture(scope="session")
def switching() -> tuple[Model, Callable[..., Case]]:
    """Model of the switching circuit, and what makes cases of it."""
    return MODEL, switching_case
