"""The periodic observers of the axial position: against whole matrices, expm and SciPy's Riccati equations; what they
hold at a prescribed motion; the stop, the lost sensor, the frozen pollution, the duty ratio of the pressure wave."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import expm
from tests.dense_filter import predict_n, update_n

from vvdp.estimation.axial_filter import AxialSeen, DutySight, Phase, PollutionModel
from vvdp.estimation.chamber_observer import (
    ChamberObserver,
    SpringDrive,
    chamber_observer_start,
    chamber_observer_step,
    driving_acceleration,
    oscillator_step,
)
from vvdp.estimation.gerotor_observer import GerotorObserver, gerotor_observer_start, gerotor_observer_step
from vvdp.estimation.noise_basis import fourier_basis
from vvdp.numerics.kalman import covariance_of
from vvdp.simulation.replay import Replay

STROKE, PERIOD = 20.32e-3, 1e-3
DRIVE = SpringDrive(moving_mass=0.5, stiffness=2594.0, preload=211.5, viscous_friction=8.3, area=1.74e-4)
POLLUTION = PollutionModel(
    basis=fourier_basis(5),
    sensor_deviation=30e-6,
    coefficient_drift=0.6e-6,
    coefficient_deviation=1e-3,
    helix_length=STROKE,
    duty_deviation=0.01,
)
CHAMBER = ChamberObserver(
    drive=DRIVE,
    pollution=POLLUTION,
    sample_period=PERIOD,
    position_drift=1e-6,
    velocity_drift=2e-3,
    position_deviation=1e-3,
    velocity_deviation=0.01,
    stop_position=-6.2e-3,
)
GEROTOR = GerotorObserver(
    area=5.067e-4,
    pollution=POLLUTION,
    sample_period=PERIOD,
    position_drift=3e-6,
    position_deviation=1e-3,
    stop_position=0.0,
)
SIZES = 1e-3 / 1.6 * np.array([1.0, 0.55, 0.30, 0.15, 0.08])
PHASES = np.array([0.3, 1.1, -0.7, 2.0, 0.5])
DRIVES = {
    "chamber": (chamber_observer_step, chamber_observer_start, CHAMBER),
    "gerotor": (gerotor_observer_step, gerotor_observer_start, GEROTOR),
}


def pollution_at(angle):
    """The pollution of the specification, 1 mm scale [m]."""
    return np.sin(np.multiply.outer(angle, np.arange(1, 6)) + PHASES) @ SIZES


def rows_of(times, optical, angle, **seen):
    """Rows for a replay; what is not named is quiet."""
    columns = {"speed": 0.0, "angle_deviation": 0.0, "pressure": 101325.0, "flow": 0.0, "held": 0.0, "margin": 1.0}
    columns |= {"duty_ratio": np.nan, "age": 0.0, "deviation": 0.0} | seen
    order = ("speed", "angle_deviation", "pressure", "flow", "held", "margin", "duty_ratio", "age", "deviation")
    rest = [np.broadcast_to(columns[name], np.shape(times)) for name in order]
    return np.column_stack([times, optical, angle, *rest])


def seen_of(row):
    r = [float(value) for value in row]
    return AxialSeen(r[0], r[1], Phase(*r[2:5]), *r[5:9], DutySight(*r[9:]))


@pytest.fixture(scope="module", params=sorted(DRIVES))
def drive(request):
    return request.param


@pytest.fixture(scope="module")
def observers():
    """observers(drive, settings, rows, position) runs an observer, compiled; what it shows, by name, and its memory."""
    known = {}

    def run(name, settings, rows, position=0.0):
        step, start, example = DRIVES[name]
        if name not in known:
            known[name] = Replay(step, start(example, 0.0), seen_of(rows[0]), example)
        done = known[name](start(settings, position), rows, settings)
        return dict(zip(known[name].columns, done.shown.T, strict=True)), done.memory

    return run


def spring_pressure(position):
    """Chamber pressure, absolute, that holds the spool at rest [Pa]."""
    return 101325.0 + (DRIVE.preload + DRIVE.stiffness * position) / DRIVE.area


# The transition


@pytest.mark.parametrize("friction", [0.0, 8.3, 60.0])
@pytest.mark.parametrize("duration", [1e-4, 1e-3, 2e-2])
def test_transition_is_the_matrix_exponential(friction, duration):
    """Of (x, v, acceleration, its slope): what a line between two samples adds stands in its last two columns."""
    drive = replace(DRIVE, viscous_friction=friction)
    M = drive.moving_mass
    A = np.zeros((4, 4))
    A[0, 1], A[1, :3], A[2, 3] = 1.0, (-drive.stiffness / M, -friction / M, 1.0), 1.0
    exact = expm(A * duration)
    step = oscillator_step(duration, drive)
    np.testing.assert_allclose([step.position, step.velocity], exact[:2, :2], rtol=1e-11)
    np.testing.assert_allclose(step.constant, exact[:2, 2], rtol=1e-10)
    np.testing.assert_allclose(np.array(step.growing) * duration, exact[:2, 3], rtol=1e-7)


def test_driving_acceleration_by_hand():
    """12.155 bar gauge carry the preload: 1.74e-4 m^2 x 12.155e5 Pa = 211.5 N; 1 bar more gives 17.4 N on 0.5 kg."""
    assert driving_acceleration(spring_pressure(0.0), DRIVE) == pytest.approx(0.0, abs=1e-9)
    assert driving_acceleration(spring_pressure(0.0) + 1e5, DRIVE) == pytest.approx(34.8)


# Against whole matrices


def dense_run(name, settings, rows):
    """The same filter with whole matrices; the held, lost and frozen samples as they stand in the rows."""
    m = {"chamber": 2, "gerotor": 1}[name]
    pollution, n = settings.pollution, m + 10
    deviations = [settings.position_deviation, *([settings.velocity_deviation] if m == 2 else [])]
    mean, P = np.zeros(n), np.diag([d * d for d in deviations] + [pollution.coefficient_deviation**2] * 10)
    A = np.zeros((m + 2, m + 2))
    Q, before, turn, shown = np.zeros((n, n)), 0.0, 0, []
    if m == 2:
        M = settings.drive.moving_mass
        A[:2, :3] = [[0.0, 1.0, 0.0], [-settings.drive.stiffness / M, -settings.drive.viscous_friction / M, 1.0]]
        Q[:2, :2] = np.diag([settings.position_drift**2, settings.velocity_drift**2])
    else:
        A[0, 1], Q[0, 0] = 1.0, settings.position_drift**2
    A[m, m + 1] = 1.0
    whole, both = np.eye(n), expm(A * PERIOD)
    whole[:m, :m] = both[:m, :m]
    for row in rows:
        _, y, angle, _, _, pressure, flow, held, margin = row[:9]
        u = driving_acceleration(pressure, settings.drive) if m == 2 else flow / settings.area
        if held:
            mean[:m], P[:m], P[:, :m] = 0.0, 0.0, 0.0
            mean[0] = settings.stop_position
        else:
            mean, P = predict_n(mean, P, whole, Q)
            mean[:m] += both[:m, m] * before + both[:m, m + 1] * (u - before) / PERIOD
        frozen = margin < 1e-3 and not held
        if not frozen:
            P[m + turn, m + turn] += 10.0 * pollution.coefficient_drift**2
            turn = (turn + 1) % 10
        H = np.zeros(n)
        H[0], H[m::2], H[m + 1 :: 2] = 1.0, np.cos(np.arange(1, 6) * angle), np.sin(np.arange(1, 6) * angle)
        if np.isfinite(y):
            R, nu = pollution.sensor_deviation**2, y - H @ mean
            if frozen:
                gain = P @ H / (H @ P @ H + R)
                gain[m:] = 0.0
                left = np.eye(n) - np.outer(gain, H)
                mean, P = mean + gain * nu, left @ P @ left.T + R * np.outer(gain, gain)
            else:
                mean, P = update_n(mean, P, H, nu, R)
        before = u
        shown.append([mean[0], np.sqrt(P[0, 0])])
    return np.array(shown), mean, P


def test_step_is_the_filter_with_whole_matrices(drive, observers):
    """Learning at the stop, free motion, a lost sensor, a frozen pollution, and free again."""
    t = np.arange(1200) * PERIOD
    rng = np.random.default_rng(3)
    angle = 2.0 * np.pi * (20.0 * t + 0.5 * t * t)
    x = 1e-3 * np.sin(9.0 * t)
    flow = GEROTOR.area * 9e-3 * np.cos(9.0 * t)
    optical = x + pollution_at(angle) + 30e-6 * rng.normal(size=t.size)
    optical[600:660] = np.nan
    margin = np.where((t > 0.8) & (t < 0.9), 5e-4, 1.0)
    held = np.where(t < 0.2, 1.0, 0.0)
    rows = rows_of(t, optical, angle, pressure=spring_pressure(x), flow=flow, held=held, margin=margin)
    settings = replace(DRIVES[drive][2], stop_position=x[0])
    shown, memory = observers(drive, settings, rows)
    expected, mean, P = dense_run(drive, settings, rows)
    scale = np.sqrt(np.diag(P))
    np.testing.assert_allclose(shown["position"], expected[:, 0], atol=1e-8 * STROKE)
    np.testing.assert_allclose(shown["position_deviation"], expected[:, 1], rtol=1e-6, atol=1e-12)
    np.testing.assert_allclose(memory.mean / scale, mean / scale, rtol=1e-6, atol=1e-6)
    np.testing.assert_allclose(
        covariance_of(memory.factors) / np.outer(scale, scale), P / np.outer(scale, scale), atol=1e-7
    )
    assert shown["lost"].sum() == 60.0
    assert shown["frozen"].sum() == np.sum((margin < 1e-3) & (held == 0.0))
    steps, _, _ = DRIVES[drive]
    memory = DRIVES[drive][1](settings, 0.0)
    for row in rows[:40]:
        memory, plain = steps(memory, seen_of(row), settings)
    assert plain.position == pytest.approx(shown["position"][39], rel=1e-12, abs=1e-15)
