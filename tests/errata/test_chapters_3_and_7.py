"""Misprints of chapter 3 and section 7.3 of wang2017: each number of a row worked out anew."""

from dataclasses import replace

import numpy as np
import pint
import pytest
from scipy.integrate import quad

from vvdp.estimation.event_filter import event_filter_estimator
from vvdp.estimation.event_settings import event_filter
from vvdp.numerics.kalman import AngleSpeed, predict, update
from vvdp.sensing.photodiode import LightSpot, photodiode_signal, ramp_width
from vvdp.sensing.reading import Reading
from vvdp.sensing.wheel import equal_wheel
from vvdp.simulation.run import simulate
from vvdp.systems.system import load_system

WHEEL, SECTOR, PITCH, SAMPLE = equal_wheel(8), np.pi / 4.0, 2.0 * np.pi / 3.0, 1e-3
SPOT = LightSpot(width=5e-3, track_radius=8e-3 / SECTOR, roundness=0.0)
OMEGA = 2.0 * np.pi * 25.0
PUBLISHED = event_filter(WHEEL)


def triangle(x: float) -> float:
    """Density of a symmetric triangle from -1 to 1."""
    return max(1.0 - abs(x), 0.0)


def moment(order: int) -> float:
    return 2.0 * quad(lambda x: x**order * triangle(x), 0.0, 1.0)[0]


def test_triangle_has_a_sixth(told):
    """Half of 1.5 ms at 25 Hz is 0.1178 rad: a^2/6 = 2.31e-3, a^2/4 = 3.47e-3; with the sampling 4.37e-3, 5.53e-3."""
    a = 0.5 * OMEGA * 1.5e-3
    assert moment(2) == pytest.approx(1.0 / 6.0, rel=1e-9)
    sampling = (0.5 * OMEGA * SAMPLE) ** 2 / 3.0
    assert f"{1e3 * a * a * moment(2):.2f}e-3 rad^2" in told
    assert f"{1e3 * (sampling + a * a * moment(2)):.2f}e-3" in told
    assert f"{1e3 * (sampling + a * a / 4.0):.2f}e-3" in told


def test_a_triangle_is_not_normal(told):
    """Fourth moment over the square of the second: 12/5, for a normal density 3. It ends at 2.45 deviations."""
    assert moment(0) == pytest.approx(1.0, rel=1e-9)
    assert f"{moment(4) / moment(2) ** 2:.1f}" in told
    assert f"{1.0 / np.sqrt(moment(2)):.2f} deviations" in told


def test_noise_of_single_events_has_no_dirac():
    """E[n_j n_k] is R times the delta of Kronecker, in rad^2; the delta of Dirac over time would make it rad^2/s."""
    unit = pint.UnitRegistry(autoconvert_offset_to_baseunit=True)
    time = 1.0 * unit("1/s")
    assert (unit("rad^2") * time).dimensionality != unit("rad^2").dimensionality
    rng = np.random.default_rng(1)
    n = rng.uniform(-0.5, 0.5, (4000, 3))
    product = n.T @ n / 4000.0
    assert product == pytest.approx(np.eye(3) / 12.0, abs=4.0 / 12.0 / np.sqrt(4000.0))


def test_density_of_an_acceleration_goes_with_the_cube_of_time():
    """The same motion with the time in milliseconds: q in rad^2/ms^3 is a billionth, and nothing else fits."""
    seconds = predict(AngleSpeed(0.1, 157.0, 2e-3, 3e-3, 0.4), 5e-3, 0.25)
    for power, same in ((3, True), (2, False), (4, False)):
        k = 1e3
        milli = predict(AngleSpeed(0.1, 157.0 / k, 2e-3, 3e-3 / k, 0.4 / k**2), 5e-3 * k, 0.25 / k**power)
        back = (milli.angle, milli.speed * k, milli.angle_variance, milli.covariance * k, milli.speed_variance * k**2)
        assert (back == pytest.approx(tuple(seconds), rel=1e-12)) is same


def test_updates_begin_at_the_last_edge():
    """With diag(p, p) put back at each event the deviation of the speed stays where the first edge leaves it."""
    start, R, lag = AngleSpeed(0.0, 50.0, 1000.0, 0.0, 1000.0), 5.53e-3, SECTOR / OMEGA
    kept, forgotten = start, start
    for number in range(1, 101):
        kept = predict(kept, lag, 0.25)
        kept = update(kept, number * SECTOR - kept.angle, R)
        forgotten = forgotten._replace(angle_variance=1000.0, covariance=0.0, speed_variance=1000.0)
        forgotten = predict(forgotten, lag, 0.25)
        forgotten = update(forgotten, number * SECTOR - forgotten.angle, R)
    assert np.sqrt(kept.speed_variance) < 0.2
    assert np.sqrt(forgotten.speed_variance) > 30.0


def test_prediction_ends_at_the_edge(told):
    """The speed known, edges in the middle of their samples: carried on to t_(k-1) only, the angle is behind by half a
    sample's turn whenever an edge is compared with it."""
    behind = []
    for number in range(1, 50):
        edge = number * SECTOR / OMEGA
        at_sample = predict(AngleSpeed(0.0, OMEGA, 0.0, 0.0, 0.0), edge - 0.5 * SAMPLE, 0.0)
        at_edge = predict(AngleSpeed(0.0, OMEGA, 0.0, 0.0, 0.0), edge, 0.0)
        assert at_edge.angle == pytest.approx(number * SECTOR, rel=1e-12)
        behind.append(number * SECTOR - at_sample.angle)
    assert np.ptp(behind) < 1e-12
    assert f"{behind[0]:.4f} rad" in told


def test_a_low_threshold_delays_falling_edges_alone():
    """Where the light passes the threshold, before and behind a rising and a falling edge."""
    angles = np.linspace(-0.4 * SECTOR, 1.4 * SECTOR, 20001)
    light = np.array([photodiode_signal(angle, WHEEL, SPOT) for angle in angles])

    def crossings(threshold):
        change = np.flatnonzero(np.diff(light > threshold))
        return angles[change] + 0.5 * (angles[1] - angles[0])

    for threshold, sign in ((0.35, 1.0), (0.65, -1.0)):
        rising, falling = crossings(threshold) - crossings(0.5)
        late = sign * 0.15 * ramp_width(SPOT)
        assert rising == pytest.approx(-late, abs=2e-4)
        assert falling == pytest.approx(late, abs=2e-4)


def test_time_of_a_sector(told):
    assert f"{1e3 / (8.0 * 40.0):.3f} ms" in told


def test_time_of_a_light_transition(told):
    """5 mm of spot on sectors of 8 mm: five eighths of a sector's 5 ms; 80 % of that from 10 to 90 %."""
    whole = ramp_width(SPOT) / OMEGA
    assert whole == pytest.approx(5.0 / 8.0 * SECTOR / OMEGA, rel=1e-12)
    assert f"{1e3 * whole:.1f} ms" in told
    assert f"{0.8e3 * whole:.1f} ms from 10 to 90 %" in told


def test_bound_of_the_noise(told):
    """0.0785 rad of the sampling and 0.1178 of 1.5 ms; three deviations of R; half of 2.9 ms at 40 Hz."""
    assert f"{0.5 * OMEGA * (SAMPLE + 1.5e-3):.3f} rad" in told
    assert f"{3.0 * np.sqrt(5.53e-3):.3f} rad" in told
    assert f"{0.5 * 2.9e-3 * 2.0 * np.pi * 40.0:.3f} rad" in told


def test_spool_does_not_turn_at_a_constant_speed(told):
    """The idealised machine for 1.5 s; its spool's edges, sampled at 1 kHz without noise, go through the filter."""
    chosen = ["run.window=1.4 s", "run.window_interval=0.1 ms"]
    system = load_system("prototype-constant-load", chosen, until="1.5 s")
    run = simulate(system.model, system.case, system.stepping)
    late = run.times > 0.2
    time, angle, speed = run.times[late], run.state.spool.angle[late], run.state.spool.speed[late]
    number = np.arange(np.ceil(angle[0] / SECTOR), np.floor(angle[-1] / SECTOR) + 1.0)
    ticks = np.arange(0.201, 1.4999, SAMPLE)
    rows = np.zeros((ticks.size, 5))
    rows[:, 0], rows[:, 2], rows[:, 3] = ticks - 0.2, ticks - 0.2 - 0.5 * SAMPLE, SAMPLE
    seen = np.searchsorted(ticks, np.interp(number * SECTOR, angle, time))
    rows[seen[seen < ticks.size], 1] = 1.0
    rows[seen[seen < ticks.size], 4] = (1.0 - 2.0 * (number % 2.0))[seen < ticks.size]
    filtering = event_filter_estimator(replace(PUBLISHED, stop_rate=0.0), speed=float(speed.mean()))
    memory, shown = filtering.memory, []
    for row in rows.tolist():
        memory, estimate = filtering.step(memory, Reading(*row), filtering.settings)
        shown.append((estimate.speed, estimate.speed_deviation))
    found, half = np.array(shown), ticks > 0.7
    settled = speed[time > 0.7]
    error = found[half, 0] - np.interp(ticks[half], time, speed)
    assert f"{settled.min():.0f} to {settled.max():.0f} rad/s" in told
    assert f"{np.sqrt(np.mean(error**2)):.1f} rad/s" in told
    assert f"{np.mean(found[half, 1]):.2f} rad/s" in told


def test_time_of_one_sector_with_a_wrong_threshold(told):
    """0.15 of a ramp of 0.49 rad at both ends of a sector of pi/4, in opposite directions."""
    delta = 0.15 * 0.49
    assert f"delta = {delta:.4f}$" in told
    assert f"{100.0 * 2.0 * delta / SECTOR:.1f} %" in told


def after_the_start(run):
    """Times after 0.6 s, angle and speed of the spool, and inlet pressure then."""
    late = run.times > 0.6
    spool = run.state.spool
    return run.times[late], spool.angle[late], spool.speed[late], run.state.inlet[late]


def test_duty_ratio_is_a_share_of_angle(told):
    """Close below the relief setting the load takes little, and the spool slows down while its port is open."""
    chosen = ["operation.duty_ratio=0.7", "load.pressure=116 bar", "run.window=0.5 s"]
    system = load_system("prototype-constant-load", chosen, until="1 s")
    time, angle, speed, _ = after_the_start(simulate(system.model, system.case, system.stepping))
    period = np.arange(np.ceil(angle[0] / PITCH + 0.5), np.floor(angle[-1] / PITCH - 1.0))
    rise, fall = (np.interp((period + side * 0.35) * PITCH, angle, time) for side in (-1.0, 1.0))
    ends = np.interp(fall, time, speed)
    assert f"swing of the speed of {100.0 * np.ptp(speed) / speed.mean():.0f} %" in told
    assert f"{np.mean((fall - rise) * ends / PITCH):.3f} of 0.700" in told


def test_wave_is_longer_than_the_duty_ratio(told):
    """The inlet pressure above 57 bar, between plateaus of 7 and 107 bar, as a share of the angle."""
    system = load_system("prototype-constant-load", ["run.window=0.5 s", "run.window_interval=5 us"], until="1 s")
    _, angle, _, pressure = after_the_start(simulate(system.model, system.case, system.stepping))
    above = pressure > 57e5 + 101325.0
    crossed = np.flatnonzero(above[1:] != above[:-1])
    share = (57e5 + 101325.0 - pressure[crossed]) / (pressure[crossed + 1] - pressure[crossed])
    at = angle[crossed] + share * (angle[crossed + 1] - angle[crossed])
    rising = above[crossed + 1]
    first = int(np.flatnonzero(rising)[0])
    whole = (at.size - first) // 2 * 2
    pulses = at[first : first + whole].reshape(-1, 2)
    assert f"simulated {np.mean(np.diff(pulses)) / PITCH - 0.5:.3f}" in told
