"""Both axial drives as parts of a network: where they come to rest, how they swing, what they take, two oils apart."""

from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np
import pytest

from vvdp.base.signal import Signal, constant, step, table
from vvdp.components.directional_valves import THREE_WAY_PROPORTIONAL_VALVE, ThreeWayProportionalValve
from vvdp.components.gerotor_drives import CALIBRATED_GEROTOR_DRIVE, GEROTOR_DRIVE
from vvdp.components.library import UsualOil
from vvdp.components.resistances import ORIFICE
from vvdp.components.rods import END_STOP, PLUNGER, ROD_FRICTION, SPRING
from vvdp.fluid.mixture import fluid_state
from vvdp.fluid.oil import Oil
from vvdp.hydraulics.chamber_drive import holding_pressure, oil_stiffness, static_reach
from vvdp.hydraulics.cylinder import Plunger
from vvdp.hydraulics.friction import RodFriction
from vvdp.hydraulics.gerotor_drive import GerotorCalibration, GerotorDrive, GerotorMap, GerotorState
from vvdp.hydraulics.orifice import Orifice
from vvdp.hydraulics.rod import EndStop, Spring
from vvdp.network.build import Circuit, build
from vvdp.network.network import Network
from vvdp.network.nodes import Chamber
from vvdp.simulation.balance import balance, balance_between
from vvdp.simulation.run import Run, Stepping, simulate
from vvdp.simulation.values import flat, rebuild

PSI, ATMOSPHERE = 6894.757, 101325.0
MASS, AREA, K, FRICTION, VOLUME = 0.5, 1.74e-4, 2594.0, 8.3, 60e-6
LOWER, UPPER = -6.2e-3, 27e-3
PILOT_OIL = UsualOil(air_fraction=0.1 / 1.1, liquid_bulk_modulus=1.7e9)


@dataclass(frozen=True)
class ChamberDrive:
    """A chamber against a spring, with its valve and an oil of its own, and where it starts [Pa absolute, m]."""

    piston: Plunger
    spring: Spring
    friction: RodFriction
    stops: EndStop
    valve: ThreeWayProportionalValve
    chamber: Chamber
    oil: Oil
    pressure: float
    position: float


def chamber_drive(position: float, pressure: float) -> ChamberDrive:
    return ChamberDrive(
        piston=Plunger(area_a=AREA, moving_mass=MASS),
        spring=Spring(stiffness=K, preload=211.5, rest_position=0.0),
        friction=RodFriction(
            viscous_friction=FRICTION,
            coulomb_friction=0.0,
            breakaway_friction=0.0,
            stribeck_velocity=0.02,
            coulomb_velocity=1e-3,
        ),
        stops=EndStop(lower_end=LOWER, upper_end=UPPER, stop_stiffness=2e7, stop_damping=10.0),
        valve=ThreeWayProportionalValve(discharge_coefficient=0.62, transition_pressure=1e3, full_area=20e-6),
        chamber=Chamber(volume=VOLUME),
        oil=PILOT_OIL,
        pressure=pressure,
        position=position,
    )


def held_drive(position: float) -> ChamberDrive:
    """A drive whose chamber's pressure holds the spool where it is."""
    drive = chamber_drive(position, ATMOSPHERE)
    return chamber_drive(position, holding_pressure(position, ATMOSPHERE, drive.piston, drive.spring))


def two_oils(drive: ChamberDrive, psi: float, command: Signal) -> Circuit:
    """A chamber drive beside a main circuit of another oil: a volume that empties through an orifice."""
    net = Network(UsualOil())
    net.tank("tank")
    net.volume("line", Chamber(volume=1e-4), start=5e6)
    net.add("outlet", ORIFICE, Orifice(), a="line", b="tank", area=1e-7)
    net.pressure_source("pilot_supply", constant(ATMOSPHERE + psi * PSI), oil=drive.oil)
    net.tank("pilot_tank", constant(ATMOSPHERE), oil=drive.oil)
    net.volume("pilot_chamber", drive.chamber, start=drive.pressure, oil=drive.oil)
    net.rod("slide", position=drive.position)
    valve = {"pressure": "pilot_supply", "tank": "pilot_tank", "a": "pilot_chamber"}
    net.add("pilot_valve", THREE_WAY_PROPORTIONAL_VALVE, drive.valve, **valve, command=command)
    net.add("axial_piston", PLUNGER, drive.piston, a="pilot_chamber", rod="slide")
    net.add("axial_spring", SPRING, drive.spring, rod="slide")
    net.add("axial_friction", ROD_FRICTION, drive.friction, rod="slide")
    net.add("axial_stops", END_STOP, drive.stops, rod="slide")
    return build(net)


def run_of(circuit: Circuit, until: float, tolerance: float = 1e-6, interval: float = 1e-3) -> Run:
    stepping = Stepping(until=until, relative_tolerance=tolerance, record_interval=interval)
    return simulate(circuit.model, circuit.case, stepping)


@cache
def driven() -> Run:
    """The chamber filled in steps, let out again and shut, at 250 psi."""
    times, levels = (
        [0.0, 0.02, 0.02, 0.25, 0.25, 0.4, 0.4, 0.45, 0.45],
        [0.0, 0.0, 0.15, 0.15, 0.0, 0.0, -0.1, -0.1, 0.0],
    )
    return run_of(two_oils(chamber_drive(LOWER, ATMOSPHERE), 250.0, table(times, levels)), 0.6)


def jacobian(circuit: Circuit) -> np.ndarray:
    """Of the rates over the state, books left out, at the start, by central differences."""
    case = circuit.case
    y = flat(case.state)
    own = len(y) - len(flat(case.state.books))

    def rates(numbers: np.ndarray) -> Any:
        state = rebuild(case.state, iter(numbers.tolist()))
        return flat(circuit.model.circuit(0.0, state, case.command, case.params)[0])[:own]

    columns = []
    for i in range(own):
        move = np.zeros_like(y)
        move[i] = max(1e-6 * abs(y[i]), 1e-9)
        columns.append((rates(y + move) - rates(y - move)) / (2.0 * move[i]))
    return np.array(columns).T


# The chamber drive


def test_energy_and_each_oil_balance_in_a_driven_run():
    run = driven()
    books = balance(run)
    assert books.is_trusted
    assert abs(books.energy_residual) < 1e-7
    assert len(books.oils) == 2
    main, pilot = books.oils
    assert abs(main.residual) < 1e-7
    assert abs(pilot.residual) < 1e-7
    assert run.final_state.books.taken_in._fields == ("oil", "pilot_supply_oil")
    assert main.taken_in == 0.0
    assert main.given_out == pytest.approx(-main.stored, rel=1e-6)
    assert pilot.taken_in > 1e-6


def test_one_oil_cannot_make_up_for_the_other():
    """What is lost of one and gained by the other shows, though the sum would balance."""
    run = driven()
    final = run.final_state
    moved = 1e-8
    given = final.books.given_out
    wrong = given._replace(oil=given.oil + moved, pilot_supply_oil=given.pilot_supply_oil - moved)
    state = flat(final._replace(books=final.books._replace(given_out=wrong)))
    books = balance_between(run.model, run.case, run.initial, state)
    assert abs(sum(o.taken_in - o.given_out - o.stored for o in books.oils)) < 1e-12
    assert abs(books.mass_residual) > 1e-5
    assert not books.is_closed


def test_pilot_power_goes_where_it_can():
    """Supply less what the tank gets: throttled, friction, stops, and what spring and oil hold."""
    run = driven()
    spent, supplied = run.final_state.books.spent, run.final_state.books.supplied
    assert {"pilot_valve", "axial_friction", "axial_stops"} <= set(spent._fields)
    assert supplied.pilot_supply > 0.0
    assert min(spent.pilot_valve, spent.axial_friction, spent.axial_stops) > 0.0


@pytest.mark.parametrize(("psi", "reach"), [(190.0, 6.34e-3), (220.0, 20.2e-3), (230.0, 24.8e-3), (250.0, UPPER)])
def test_open_to_the_supply_the_spool_ends_at_its_reach(psi, reach):
    """250 psi would hold 34.1 mm; the stop ends the stroke, beyond the 26.4 mm of full use."""
    run = run_of(two_oils(held_drive(3e-3), psi, constant(0.3)), 2.0)
    end = run.state.slide.position[-1]
    assert end == pytest.approx(reach, abs=0.06e-3)
    drive = held_drive(3e-3)
    expected = min(static_reach(ATMOSPHERE + psi * PSI, ATMOSPHERE, drive.piston, drive.spring), UPPER)
    assert end == pytest.approx(expected, abs=1e-5)


@pytest.mark.parametrize(
    ("position", "time"), [(1e-3, 3.3e-3), (5e-3, 6.3e-3), (10e-3, 8.5e-3), (20.32e-3, 11.3e-3), (26.4e-3, 12.6e-3)]
)
def test_without_current_the_spring_takes_the_spool_below_duty_ratio_0(position, time):
    """From any position within 20 ms; it is at its stop 1.6 to 4.4 ms later, and stays there."""
    run = run_of(two_oils(held_drive(position), 250.0, step(0.0, -1.0, 0.01)), 0.2, interval=1e-4)
    below = run.times[np.argmax(run.state.slide.position < 0.0)] - 0.01
    assert below == pytest.approx(time, abs=0.2e-3)
    assert run.state.slide.position[-1] == pytest.approx(LOWER, abs=2e-5)


@pytest.mark.parametrize(("air", "time"), [(0.01, 11.7e-3), (0.3 / 1.3, 14.3e-3)])
def test_air_hardly_delays_that(air, time):
    """1 % of the mixture, and 30 % per oil: the chamber has to let out what the oil was compressed by."""
    drive = replace(held_drive(26.4e-3), oil=replace(PILOT_OIL, air_fraction=air))
    run = run_of(two_oils(drive, 250.0, step(0.0, -1.0, 0.01)), 0.1, interval=1e-4)
    assert run.times[np.argmax(run.state.slide.position < 0.0)] - 0.01 == pytest.approx(time, abs=0.2e-3)


def test_rod_swings_on_its_spring_at_11_464_hz():
    """With the pressure held: -b/2M +- i sqrt(K/M - (b/2M)^2)."""
    net = Network(PILOT_OIL)
    drive = held_drive(2e-3)
    net.pressure_source("chamber", drive.pressure)
    net.rod("slide", position=2e-3)
    net.add("piston", PLUNGER, drive.piston, a="chamber", rod="slide")
    net.add("spring", SPRING, drive.spring, rod="slide")
    net.add("friction", ROD_FRICTION, drive.friction, rod="slide")
    found = np.linalg.eigvals(jacobian(build(net)))
    assert found.real == pytest.approx(-FRICTION / (2.0 * MASS), rel=1e-6)
    assert np.abs(found) / (2.0 * np.pi) == pytest.approx(11.464, abs=1e-3)


def test_shut_chamber_is_a_spring_beside_the_spring():
    """Eigenvalues of P, x, v with the valve shut: 0 and those of the stiffness K + beta A^2/V."""
    drive = held_drive(5e-3)
    matrix = jacobian(two_oils(drive, 190.0, constant(0.0)))[1:, 1:]
    beta = fluid_state(drive.pressure, PILOT_OIL).bulk_modulus
    whole = K + oil_stiffness(VOLUME + AREA * 5e-3, beta, drive.piston)
    found = sorted(np.linalg.eigvals(matrix), key=abs)
    assert abs(found[0]) < 1e-3
    assert abs(found[1]) == pytest.approx(np.sqrt(whole / MASS), rel=1e-5)
    assert found[1].real == pytest.approx(-FRICTION / (2.0 * MASS), rel=1e-4)


# The gerotor drive

DRIVE = GerotorDrive(
    area=5.067e-4, lag=10e-3, conductance=1.1e-10, viscous_friction=FRICTION, lower_end=LOWER, upper_end=UPPER
)
MAP = GerotorMap(largest_flow=3e-5, forward_dead_band=0.06, backward_dead_band=0.08, backward_gain=0.9)
ROWS = GerotorCalibration(commands=(-1.0, -0.08, 0.06, 1.0), flows=(-2.7e-5, 0.0, 0.0, 3e-5))


def gerotor_run(command: Signal, until: float, characteristic: Any = MAP) -> Run:
    net = Network(UsualOil())
    component = GEROTOR_DRIVE if isinstance(characteristic, GerotorMap) else CALIBRATED_GEROTOR_DRIVE
    net.add("gerotor", component, DRIVE, characteristic, start=GerotorState(0.0, 0.0), command=command)
    return run_of(build(net), until, tolerance=1e-9)


@pytest.mark.parametrize("command", [0.06, -0.08, 0.03])
def test_nothing_moves_within_the_dead_band(command):
    run = gerotor_run(constant(command), 0.2)
    assert np.max(np.abs(run.state.gerotor.position)) == 0.0


def test_step_of_the_command_follows_with_the_lag():
    """Q = Q_0 (1 - e^(-t/tau)), x = (Q_0/A) (t - tau (1 - e^(-t/tau))), with Q_0 of the map: half of the largest."""
    run = gerotor_run(constant(0.53), 0.2)
    t, tau, settled = run.times, DRIVE.lag, 1.5e-5
    gone = -np.expm1(-t / tau)
    assert run.state.gerotor.flow == pytest.approx(settled * gone, abs=1e-12)
    assert run.state.gerotor.position == pytest.approx(settled / DRIVE.area * (t - tau * gone), abs=1e-9)


@pytest.mark.parametrize("characteristic", [MAP, ROWS])
def test_ends_hold_the_spool_and_let_it_go(characteristic):
    """At an end the position is exactly that of the end, while the pump slips; back it goes 0.9 times as fast."""
    run = gerotor_run(table([0.0, 0.6, 0.6], [1.0, 1.0, -1.0]), 1.5, characteristic)
    x = run.state.gerotor.position
    held = (run.times > 0.5) & (run.times < 0.6)
    assert x[held] == pytest.approx(UPPER, abs=1e-9)
    assert np.max(x) < UPPER + 1e-9
    assert np.min(x) > LOWER - 1e-9
    assert x[-1] == pytest.approx(LOWER, abs=1e-9)
    back = (run.times > 0.7) & (run.times < 0.8)
    assert np.gradient(x[back], run.times[back]) == pytest.approx(-0.9 * 3e-5 / DRIVE.area, rel=2e-3)


def test_gerotor_takes_what_its_passages_and_the_friction_lose():
    run = gerotor_run(constant(1.0), 0.3)
    books = balance(run)
    assert books.is_trusted
    assert abs(books.energy_residual) < 1e-9
    t, tau = 0.3, DRIVE.lag
    squares = t - 2.0 * tau * -np.expm1(-t / tau) + 0.5 * tau * -np.expm1(-2.0 * t / tau)
    lost = 3e-5**2 * squares * (1.0 / DRIVE.conductance + FRICTION / DRIVE.area**2)
    assert run.final_state.books.supplied.gerotor == pytest.approx(lost, rel=1e-6)
