"""Sensor, observer and laws of an axial drive by name: numbers by hand, stages, refusals."""

import math
from dataclasses import replace

import pytest

from vvdp.base.errors import ParameterError
from vvdp.estimation.estimator import Estimate
from vvdp.programs.axial_sensor import AXIAL_SENSOR, AxialSensorTable, sensor_step
from vvdp.programs.axial_stages import HOME, RUN, AxialSequence, Stage, is_known, known_phase, next_stage
from vvdp.programs.chamber_laws import (
    BacksteppingTable,
    ChamberTask,
    PassivityTable,
    backstepping_settings,
    backstepping_step,
    passivity_settings,
    passivity_start,
    passivity_step,
    printed_passivity_step,
)
from vvdp.programs.chamber_observer import (
    ChamberObserverTable,
    WatchedSpool,
    chamber_observer_program_start,
    chamber_observer_program_step,
    chamber_observer_settings,
)
from vvdp.programs.filters import Led, LedReference, smooth_start, smooth_step
from vvdp.sensing.axial_sensor import SpoolPlace, axial_sensor_start

AREA, MASS, STIFFNESS, PRELOAD = 174e-6, 0.5, 2594.0, 211.5
MODULUS, VOLUME = 1.7e9, 60e-6
ATMOSPHERE = 101325.0
HELD = ATMOSPHERE + PRELOAD / AREA
"""Pressure that holds the spool at position 0 [Pa]."""
DRIVE = {
    "area": AREA,
    "moving_mass": MASS,
    "stiffness": STIFFNESS,
    "preload": PRELOAD,
    "oil_volume": VOLUME,
    "discharge_coefficient": 0.62,
    "full_area": 20e-6,
    "supply_pressure": 20e5,
    "density": 876.0,
    "liquid_bulk_modulus": MODULUS,
    "air_fraction": 0.0,
}
GAINS = {"error_rate": 50.0, "position_gain": 55.0, "velocity_gain": 4.0}
LAW = passivity_settings(PassivityTable(**DRIVE, **GAINS, pressure_rate=500.0))
MOVED = ChamberTask(
    reference=0.0,
    reference_velocity=0.1,
    reference_acceleration=0.0,
    reference_jerk=0.0,
    position=0.0,
    velocity=0.1,
    pressure=HELD,
)
"""Where it should be, in balance, at 0.1 m/s."""
FLOW = AREA * 0.1 + VOLUME / MODULUS * STIFFNESS * 0.1 / AREA
"""What follows the spool, and what raises the pressure as the spring asks for: 17.4 and 0.05 ml/s."""


@pytest.mark.parametrize("step", [passivity_step, printed_passivity_step])
def test_flow_and_command_of_a_spool_without_errors(step):
    found = step(0.0, passivity_start(LAW), MOVED, LAW)[1]
    assert found.flow == pytest.approx(FLOW, rel=1e-9)
    assert found.desired_pressure == pytest.approx(HELD, rel=1e-12)
    full = 0.62 * 20e-6 * math.sqrt(2.0 / 876.0 * (20e5 - HELD))
    assert found.command == pytest.approx(FLOW / full, rel=1e-9)
    assert found.storage == pytest.approx(0.0, abs=1e-12)


def test_pressure_error_and_storage():
    """1 bar too much: lambda_3 = 500 1/s V/beta takes 1.76 ml/s out; V p^2/(2 beta) is stored, 0.18 mJ."""
    resting = MOVED._replace(reference_velocity=0.0, velocity=0.0, pressure=HELD + 1e5)
    found = passivity_step(0.0, passivity_start(LAW), resting, LAW)[1]
    acceleration = AREA * 1e5 / MASS
    rate = -(MASS * 50.0 + 4.0) * acceleration / AREA
    fed = VOLUME / MODULUS * rate
    assert found.flow == pytest.approx(fed - 500.0 * VOLUME / MODULUS * 1e5, rel=1e-3)
    assert found.storage == pytest.approx(0.5 * VOLUME * 1e10 / MODULUS, rel=1e-3)


def test_backstepping_by_hand():
    """Without errors: A v and the rate of the pressure, as the others."""
    table = BacksteppingTable(**DRIVE, **GAINS, pressure_weight=3e-12, flow_gain=1e-10)
    found = backstepping_step(0.0, None, MOVED, backstepping_settings(table))[1]
    assert found.flow == pytest.approx(FLOW, rel=1e-9)


@pytest.mark.parametrize("step", [passivity_step, printed_passivity_step])
def test_the_chamber_is_emptied_until_the_spool_is_released(step):
    found = step(0.0, passivity_start(LAW), MOVED._replace(released=0.0), LAW)[1]
    assert (found.command, found.storage) == (-1.0, 0.0)


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"supply_pressure": 1e5}, "supply_pressure"),
        ({"full_area": 0.0}, "full_area"),
        ({"pressure_rate": 0.0}, "pressure_rate"),
        ({"moving_mass": 0.0}, "moving_mass"),
    ],
)
def test_values_that_cannot_be_are_refused(values, words):
    with pytest.raises(ParameterError, match=words):
        PassivityTable(**{**DRIVE, **GAINS, "pressure_rate": 500.0, **values})


def test_backstepping_refuses_a_flow_gain_that_no_weight_mends():
    with pytest.raises(ParameterError, match="flow_gain"):
        BacksteppingTable(**DRIVE, **GAINS, pressure_weight=3e-12, flow_gain=1e-7)


def test_the_sensor_by_hand():
    """5 mm and half a millimetre of pollution: the light of 5.5 mm, 96 % less 2 %/mm times 15.5 mm."""
    table = AxialSensorTable(
        positions=(-0.01, 0.03),
        light=(0.96, 0.16),
        pollution_scale=1e-3,
        pollution_amplitudes=(0.5,),
        pollution_phases=(0.0,),
        noise=0.0,
        seed=1.0,
    )
    sensor = AXIAL_SENSOR.made(table)
    _, seen = sensor_step(0.0, axial_sensor_start(sensor), SpoolPlace(0.0, 5e-3, 0.5 * math.pi), sensor)
    assert seen == pytest.approx((5.5e-3, 0.65), rel=1e-12)


OBSERVER = ChamberObserverTable(
    area=AREA,
    moving_mass=MASS,
    stiffness=STIFFNESS,
    preload=PRELOAD,
    viscous_friction=8.3,
    stop_position=-6.2e-3,
    helix_length=20.32e-3,
    sample_period=1e-3,
    harmonics=2.0,
    sensor_deviation=30e-6,
    position_drift=1e-6,
    velocity_drift=2e-3,
    coefficient_drift=0.6e-6,
    coefficient_deviation=1e-3,
    home_time=20e-3,
    learn_time=30e-3,
)


def watched(samples: int, pressure: float = ATMOSPHERE, deviations: tuple[float, float] = (0.0, 0.0)):
    """What the observer gives over samples at the stop, the sensor off by 0.3 mm times the sine of the angle."""
    settings = chamber_observer_settings(OBSERVER)
    memory, found = chamber_observer_program_start(settings), []
    for k in range(samples):
        t, angle = 1e-3 * k, 140.0e-3 * k
        sight = WatchedSpool(t, -6.2e-3 + 0.3e-3 * math.sin(angle), 0.5, angle, 140.0, pressure, *deviations)
        memory, seen = chamber_observer_program_step(t, memory, sight, settings)
        found.append(seen)
    return found


def test_it_homes_learns_and_releases():
    """Held from the first sample on: 20 ms at the stop, 30 ms of learning, control from 50 ms on."""
    found = watched(120)
    stages = [each.stage for each in found]
    assert [stages.index(stage) for stage in (0.0, 1.0, 2.0)] == pytest.approx([0, 20, 50], abs=1)
    assert [each.released for each in found] == [1.0 if stage == 2.0 else 0.0 for stage in stages]
    assert found[-1].position == pytest.approx(-6.2e-3, abs=1e-12)
    last = 140.0e-3 * 119
    assert found[-1].pollution == pytest.approx(0.3e-3 * math.sin(last), abs=20e-6)


def test_it_does_not_learn_while_the_angle_is_not_known():
    """0.6 rad are too much of the angle, 6 rad/s of the speed are not."""
    found = watched(120, deviations=(0.6, 6.0))
    assert (found[-1].stage, found[-1].known, found[-1].released) == (1.0, 0.0, 0.0)
    found = watched(120, deviations=(0.4, 6.0))
    assert (found[-1].stage, found[-1].known, found[-1].released) == (2.0, 1.0, 1.0)


def test_it_does_not_home_while_the_chamber_lifts_the_spool():
    """(P - P_0) A of 12 bar, 208.8 N, is above the 195.4 N of the spring at its stop."""
    assert watched(60, pressure=ATMOSPHERE + 12e5)[-1].stage == 0.0
    assert watched(60, pressure=ATMOSPHERE + 11e5)[-1].stage == 2.0


def test_the_observer_refuses_a_spool_that_creeps():
    with pytest.raises(ParameterError, match="viscous_friction"):
        replace(OBSERVER, viscous_friction=80.0)


def test_the_reference_rests_until_it_is_released():
    """One sample of 10 ms at four poles of 100 1/s then covers 1 - e^-1 (1 + 1 + 1/2 + 1/6), 1.9 %, of the way."""
    settings = LedReference(filter_rate=100.0)
    memory = smooth_start(settings)
    for k in range(3):
        memory, found = smooth_step(0.01 * k, memory, Led(1.0, 0.0, -2.0), settings)
        assert found == (-2.0, 0.0, 0.0, 0.0)
    memory, found = smooth_step(0.03, memory, Led(1.0, 1.0, -2.0), settings)
    assert found.value == pytest.approx(-2.0 + 3.0 * (1.0 - math.exp(-1.0) * (8.0 / 3.0)), rel=1e-12)


def test_known_time_is_added_up():
    """Known at every other sample of 1 ms from 20 ms on: 300 ms of it are there after 600 ms."""
    stage, sequence = Stage(HOME, 0.0, 1.0), AxialSequence(home_time=0.02, learn_time=0.3)
    for k in range(1, 1000):
        stage = next_stage(stage, 1e-3 * k, 1.0, k % 2 == 0, 1e-3, sequence)
        if stage.number == RUN:
            break
    assert k == pytest.approx(620, abs=2)


def test_slip_is_no_deviation_of_the_angle():
    """0.5 rad are 0.25 rad^2, of which two suspected slips are 0.2056 and 0.0344: 0.1 rad are left, one is new."""
    estimate = Estimate(1.0, 150.0, 0.5, 3.0, 0.0, 0.0, 0.0, 0.0)
    phase = known_phase(estimate, 0.24, 0.2056)
    assert phase.angle_deviation == pytest.approx(0.1)
    assert phase.slip == pytest.approx(0.0344)
    assert is_known(known_phase(estimate._replace(angle_deviation=0.8), 0.5, 0.5))
    assert not is_known(known_phase(estimate._replace(angle_deviation=0.8), 0.0, 0.0))
    assert not is_known(known_phase(estimate._replace(speed=15.0), 0.24, 0.0))
    assert known_phase(estimate, 0.0, 0.24).slip == 0.0
