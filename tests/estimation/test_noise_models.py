"""What the pollution is modelled with: the bases, the signal generator, the clock; and the filters that are cheaper."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.linalg import expm, solve_discrete_are

from vvdp.base.errors import ParameterError
from vvdp.estimation.axial_filter import AxialSeen, DutySight, Phase, PollutionModel
from vvdp.estimation.chamber_observer import (
    ChamberObserver,
    SpringDrive,
    chamber_observer_start,
    chamber_observer_step,
)
from vvdp.estimation.gain_table import learn_gain, tabulated_observer_step, tabulated_start
from vvdp.estimation.gerotor_observer import GerotorObserver
from vvdp.estimation.noise_basis import (
    NoiseBasis,
    basis_slope,
    bump_mean,
    fourier_basis,
    function_count,
    gaussian_basis,
    write_basis,
)
from vvdp.estimation.pressure_observer import (
    PressureObserver,
    exponential_step,
    pressure_observer_start,
    pressure_observer_step,
)
from vvdp.estimation.signal_generator import (
    GeneratorDesign,
    LumpedMemory,
    LumpedObserver,
    generator_observer,
    generator_observer_step,
    generator_start,
    lumped_observer_step,
    samples_in_period,
    signal_generator,
)

STROKE, PERIOD = 20.32e-3, 1e-3
PAGE = " ".join((Path(__file__).parents[2] / "docs/models/axial-observer.md").read_text("utf-8").split())
POLLUTION = PollutionModel(
    basis=fourier_basis(5),
    sensor_deviation=30e-6,
    coefficient_drift=0.6e-6,
    coefficient_deviation=1e-3,
    helix_length=STROKE,
    duty_deviation=0.01,
)
GEROTOR = GerotorObserver(
    area=5.067e-4,
    pollution=POLLUTION,
    sample_period=PERIOD,
    position_drift=3e-6,
    position_deviation=1e-3,
    stop_position=0.0,
)
CHAMBER = ChamberObserver(
    drive=SpringDrive(moving_mass=0.5, stiffness=2594.0, preload=211.5, viscous_friction=0.0, area=1.74e-4),
    pollution=POLLUTION,
    sample_period=PERIOD,
    position_drift=1e-6,
    velocity_drift=2e-3,
    position_deviation=1e-3,
    velocity_deviation=0.01,
    stop_position=0.0,
)
PRESSURE = PressureObserver(
    drive=CHAMBER.drive,
    pollution=POLLUTION,
    sample_period=PERIOD,
    chamber_volume=60e-6,
    bulk_modulus=1.2e8,
    position_drift=1e-6,
    velocity_drift=2e-3,
    pressure_drift=1e3,
    pressure_deviation=1e3,
    position_deviation=1e-3,
    velocity_deviation=0.01,
    stop_position=0.0,
)
DESIGN = GeneratorDesign(
    area=5.067e-4,
    sample_period=2e-3,
    noise_period=0.04,
    sensor_deviation=30e-6,
    position_drift=3e-6,
    generator_drift=3e-6,
)
SIZES = 1e-3 / 1.6 * np.array([1.0, 0.55, 0.30, 0.15, 0.08])
PHASES = np.array([0.3, 1.1, -0.7, 2.0, 0.5])
REST = 101325.0 + 211.5 / 1.74e-4


def pollution_at(angle):
    return np.sin(np.multiply.outer(angle, np.arange(1, 6)) + PHASES) @ SIZES


def run(step, memory, settings, rows):
    """Positions that a step shows in plain Python at rows of (time, optical, angle, pressure, flow), and the last
    estimate and memory."""
    positions = []
    for time, optical, angle, pressure, flow in rows:
        seen = AxialSeen(
            float(time), float(optical), Phase(float(angle), 0.0, 0.0), float(pressure), float(flow), 0.0, 1.0,
            DutySight(np.nan, 0.0, 0.0),
        )  # fmt: skip
        memory, estimate = step(memory, seen, settings)
        positions.append(estimate.position)
    return np.array(positions), estimate, memory


def values(basis, phases):
    rows = np.zeros((len(phases), function_count(basis) + 1))
    rows[:, 0] = 1.0
    for phase, row in zip(phases, rows, strict=True):
        write_basis(float(phase), basis, row, 1)
    return rows


# Bases


def test_fourier_basis_by_definition():
    angles = np.linspace(-40.0, 40.0, 101)
    found = values(fourier_basis(5), angles)[:, 1:]
    for h in range(1, 6):
        np.testing.assert_allclose(found[:, 2 * h - 2], np.cos(h * angles), atol=1e-13)
        np.testing.assert_allclose(found[:, 2 * h - 1], np.sin(h * angles), atol=1e-13)


@pytest.mark.parametrize("width", [0.2, 1.0, 2.5])
def test_bells_have_mean_zero(width):
    """The mean of one bell, by quadrature and in closed form; and of every function, over a turn, also far away."""
    mean = quad(lambda z: np.exp(-((z / width) ** 2)), -np.pi, np.pi)[0] / (2.0 * np.pi)
    assert bump_mean(width) == pytest.approx(mean, rel=1e-10)
    phases = 100.0 + np.arange(20_000) / 20_000 * 2.0 * np.pi
    found = values(gaussian_basis(6, width), phases)
    assert found.shape[1] == 7
    np.testing.assert_allclose(found[:, 1:].mean(axis=0), 0.0, atol=1e-7)
    assert np.max(found[:, 2]) == pytest.approx(1.0 - mean, abs=1e-6)


@pytest.mark.parametrize("basis", [fourier_basis(3), gaussian_basis(5, 0.9), NoiseBasis(harmonics=2.0, bumps=4.0)])
def test_slope_is_the_difference_quotient(basis):
    rng = np.random.default_rng(2)
    mean = np.concatenate([[0.0], rng.normal(size=function_count(basis))])
    for phase in rng.uniform(-9.0, 9.0, 20):
        before, row, after = values(basis, [phase - 1e-6, phase, phase + 1e-6])
        assert basis_slope(phase, basis, mean, row, 1) == pytest.approx((after - before) @ mean / 2e-6, abs=1e-7)


def condition(rows):
    return np.linalg.cond(rows.T @ rows)


def test_gaussian_basis_competes_with_the_position():
    """The printed bells, 6 of them, do not close over the turn and have a mean: with the position as a constant beside
    them the Grammian's condition is 1.1e3 (c = 1/6 of the period) or 4.2e2 (1/12), for Fourier functions 2."""
    turn = 2.0 * np.pi
    phases = np.arange(20_000) / 20_000 * turn
    for share, printed in ((1.0 / 6.0, 1.1e3), (1.0 / 12.0, 4.2e2)):
        bells = [np.exp(-(((phases - (i + 0.5) / 6.0 * turn) / (share * turn)) ** 2)) for i in range(6)]
        assert condition(np.column_stack([np.ones_like(phases), *bells])) == pytest.approx(printed, rel=0.01)
    assert condition(values(fourier_basis(3), phases)) == pytest.approx(2.0, rel=1e-9)


def test_all_bells_without_their_means_are_one_too_many():
    """Bells that close over the turn add up to nearly a constant: without their means, to nearly nothing. One less, and
    the condition falls from 6e8 (c = 1/6) or 5.3e2 (1/12) to 2.8e2 and 63 for six functions."""
    phases = np.arange(20_000) / 20_000 * 2.0 * np.pi
    for share, all_bells, one_less in ((1.0 / 6.0, 5.8e8, 289.0), (1.0 / 12.0, 531.0, 57.3)):
        width = 2.0 * np.pi * share
        five = values(gaussian_basis(5, width), phases)
        sixth = np.exp(-(((np.mod(phases - 5.0 / 6.0 * 2.0 * np.pi + np.pi, 2.0 * np.pi) - np.pi) / width) ** 2))
        assert condition(five) == pytest.approx(one_less, rel=0.01)
        if share > 0.1:
            assert f"{all_bells:.1e}".replace("e+0", "e") in PAGE
            assert f"{one_less:.1e}".replace("e+0", "e") in PAGE
        assert condition(np.column_stack([five, sixth - sixth.mean()])) == pytest.approx(all_bells, rel=0.02)


def test_bases_that_are_none_are_refused():
    for harmonics, bumps in ((0.0, 0.0), (0.0, 1.0), (2.5, 0.0), (2.0, 1.0)):
        with pytest.raises(ParameterError, match="at least 1 harmonic or 2 bumps"):
            NoiseBasis(harmonics=harmonics, bumps=bumps)
    with pytest.raises(ParameterError, match="half a revolution"):
        NoiseBasis(harmonics=0.0, bumps=6.0, bump_width=3.2)


# Signal generator


@pytest.mark.parametrize("samples", [4, 5, 20, 21])
def test_signal_generator_and_its_observability(samples):
    """Eigenvalues: all N-th roots of 1 but 1. With the position, det of the N rows C A^k is (-1)^(N-1) N, their
    condition sqrt(N); the last row that is printed, C A^N, is the first again."""
    A, C = signal_generator(samples)
    assert A.shape == (samples - 1, samples - 1)
    roots = np.exp(2j * np.pi * np.arange(1, samples) / samples)
    np.testing.assert_allclose(np.poly(A), np.real(np.poly(roots)), atol=1e-9)
    whole, row = np.eye(samples), np.concatenate([[1.0], C])
    whole[1:, 1:] = A
    rows = []
    for _ in range(samples):
        rows.append(row)
        row = row @ whole
    assert np.linalg.det(rows) == pytest.approx((-1.0) ** (samples - 1) * samples, rel=1e-9)
    assert np.linalg.cond(rows) == pytest.approx(np.sqrt(samples), rel=1e-9)
    printed = [*rows[:-1], row]
    assert np.array_equal(printed[-1], rows[0])
    assert abs(np.linalg.det(printed)) < 1e-9
    signal = np.random.default_rng(1).normal(size=samples)
    signal -= signal.mean()
    state, shown = signal[:-1], []
    for _ in range(2 * samples):
        shown.append(C @ state)
        state = A @ state
    np.testing.assert_allclose(shown, np.tile(signal, 2), atol=1e-12)


def test_generator_gain_is_that_of_the_riccati_equation():
    """Against SciPy's solution in SI and against ten thousand steps of the filter with whole matrices."""
    settings = generator_observer(DESIGN)
    N = len(settings.gain)
    assert N == 20
    A, C = np.eye(N), np.ones(N)
    A[1:, 1:], C[1:] = signal_generator(N)
    Q, R = np.diag([9e-12] + [0.0] * (N - 2) + [9e-12]), 9e-10
    prior = solve_discrete_are(A.T, C[:, None], 1e12 * Q, np.array([[1e12 * R]])) / 1e12
    np.testing.assert_allclose(settings.gain, prior @ C / (C @ prior @ C + R), atol=1e-9)
    P = np.diag(np.full(N, 1e-8))
    for _ in range(10_000):
        K = P @ C / (C @ P @ C + R)
        after = P - np.outer(K, C @ P)
        P = A @ after @ A.T + Q
    np.testing.assert_allclose(settings.gain, K, atol=1e-8)
    assert settings.position_deviation == pytest.approx(np.sqrt(after[0, 0]), rel=1e-6)


def test_generator_learns_each_sample_of_the_period_by_itself():
    """Halving time of the slowest part of its error: 0.9 s with 20 states, 20 s with 100."""
    for design, told in ((DESIGN, "0.9 s"), (replace(DESIGN, sample_period=1e-3, noise_period=0.1), "20 s")):
        gain = np.array(generator_observer(design).gain)
        A, C = np.eye(gain.size), np.ones(gain.size)
        A[1:, 1:], C[1:] = signal_generator(gain.size)
        slowest = np.max(np.abs(np.linalg.eigvals((np.eye(gain.size) - np.outer(gain, C)) @ A)))
        halving = design.sample_period * np.log(0.5) / np.log(slowest)
        assert halving == pytest.approx(float(told[:-2]), rel=0.05)
        assert f"in about {told}" in PAGE


def test_generator_separates_what_the_lumped_filter_does_not():
    """A spool at rest, 25 Hz, 2 ms: the generator's error dies out, as slowly as its gains are small; the filter of
    first order keeps what its gain lets through of each harmonic."""
    t = np.arange(3000) * 2e-3
    optical = 5e-3 + pollution_at(2.0 * np.pi * 25.0 * t)
    rows = np.column_stack([t, optical, 0.0 * t, 0.0 * t, 0.0 * t])
    settings = generator_observer(DESIGN)
    found, estimate, _ = run(generator_observer_step, generator_start(settings, 5e-3), settings, rows)
    assert np.max(np.abs(found - 5e-3)[2900:]) < 5e-6
    assert estimate.pollution == pytest.approx(optical[-1] - 5e-3, abs=5e-6)
    lumped = LumpedObserver(area=DESIGN.area, sample_period=2e-3, bandwidth=60.0)
    found, _, _ = run(lumped_observer_step, LumpedMemory(5e-3, 0.0), lumped, rows)
    share = 1.0 - np.exp(-0.12)
    through = share / np.abs(1.0 - (1.0 - share) * np.exp(-2j * np.pi * 25.0 * 2e-3 * np.arange(1, 6)))
    expected = np.sqrt(0.5 * np.sum((through * SIZES) ** 2.0))
    assert np.std(found[2000:]) == pytest.approx(expected, rel=1e-3)


@pytest.mark.parametrize(("turns", "is_known"), [(25.0, True), (25.001, True), (25.5, False), (0.0, True)])
def test_generator_knows_its_deviation_at_its_own_period_only(turns, is_known):
    """25 turns a second are 20 samples of 2 ms; 2 % of another speed are 2.5 rad after 20 turns."""
    settings = generator_observer(DESIGN)
    memory = generator_start(settings, 5e-3)
    phase = Phase(0.0, 2.0 * np.pi * turns, 0.0)
    seen = AxialSeen(0.0, 5e-3, phase, REST, 0.0, 0.0, 1.0, DutySight(np.nan, 0.0, 0.0))
    _, estimate = generator_observer_step(memory, seen, settings)
    assert (estimate.position_deviation == settings.position_deviation) == is_known
    assert np.isnan(estimate.position_deviation) != is_known


def test_period_that_is_no_whole_number_of_samples_is_refused():
    assert samples_in_period(0.04, 2e-3) == 20
    with pytest.raises(ParameterError, match=r"0\.0444 s has 44\.4 samples of 0\.001 s.*every 0\.00100909 s"):
        samples_in_period(0.0444, 1e-3)
    with pytest.raises(ParameterError, match="at least 2"):
        samples_in_period(1e-3, 1e-3)
    with pytest.raises(ParameterError, match="must be greater than 0"):
        samples_in_period(1e-3, 0.0)
    with pytest.raises(ParameterError, match="a gain falls to 0"):
        replace(DESIGN, generator_drift=0.0)


# Measured pressure


@pytest.mark.parametrize("duration", [1e-4, 1e-3, 4e-3])
def test_series_is_the_matrix_exponential(duration):
    A = np.array([[0.0, 1.0, 0.0], [-5188.0, -16.6, 3.48e-4], [0.0, -3.48e8, 0.0]])
    both = np.zeros((6, 6))
    both[:3, :3], both[:3, 3:] = A, np.eye(3)
    exact = expm(both * duration)
    F, G = exponential_step(A, duration)
    scale = np.outer([1.0, 300.0, 1e9], 1.0 / np.array([1.0, 300.0, 1e9]))
    np.testing.assert_allclose(F / scale, exact[:3, :3] / scale, atol=1e-9)
    np.testing.assert_allclose(G / scale / duration, exact[:3, 3:] / scale / duration, atol=1e-9)


@pytest.mark.thorough
def test_measured_pressure_keeps_the_position_at_the_resonance():
    """At 11.464 Hz: what is believed without the flow is worth a third of a millimetre, with it a few hundredths."""
    t = np.arange(4000) * PERIOD
    angle = np.sqrt(2594.0 / 0.5) * t
    rng = np.random.default_rng(6)
    optical = pollution_at(angle) + 20e-6 * rng.normal(size=t.size)
    rows = np.column_stack([t, optical, angle, np.full(t.size, REST), 0.0 * t])
    _, without, _ = run(chamber_observer_step, chamber_observer_start(CHAMBER, 0.0), CHAMBER, rows)
    found, with_flow, memory = run(pressure_observer_step, pressure_observer_start(PRESSURE, 0.0, REST), PRESSURE, rows)
    assert without.position_deviation > 5.0 * with_flow.position_deviation
    assert with_flow.position_deviation < 40e-6
    assert np.std(found[3000:]) < 40e-6
    assert memory.mean[2] == pytest.approx(REST - 101325.0, abs=2e3)


def test_flow_moves_the_spool_without_an_optical_sensor():
    """1 cm^3/s on 1.74 cm^2 is 5.7 mm/s; the pressure rises with the spring, and both are all that is seen."""
    t = np.arange(200) * PERIOD
    flow, x = np.full(t.size, 1e-6), 1e-6 / 1.74e-4 * t
    # The oil takes a share of the flow: dP V/beta, with dP = K dx/A.
    x *= 1.0 / (1.0 + 2594.0 * 60e-6 / (1.2e8 * 1.74e-4**2))
    rows = np.column_stack([t, np.full(t.size, np.nan), 0.0 * t, REST + 2594.0 * x / 1.74e-4, flow])
    settings = replace(PRESSURE, position_deviation=1e-6, velocity_deviation=1e-4)
    found, estimate, _ = run(pressure_observer_step, pressure_observer_start(settings, 0.0, REST), settings, rows)
    assert found[-1] == pytest.approx(x[-1], rel=0.05)
    assert estimate.velocity == pytest.approx(x[-1] / t[-1], rel=0.3)


def test_too_slow_a_sample_for_stiff_oil_is_refused():
    with pytest.raises(ParameterError, match=r"2 ms must be at most 1\.49006 ms: spool and oil swing with 1342 1/s"):
        replace(PRESSURE, sample_period=2e-3, bulk_modulus=1.78e9)
    with pytest.raises(ParameterError, match="must be greater than 0"):
        replace(PRESSURE, pressure_drift=0.0)


# Tabulated gain


def test_tabulated_gain_does_what_the_filter_does_once_it_has_settled():
    t = np.arange(3000) * PERIOD
    speed = 2.0 * np.pi * 22.5
    rng = np.random.default_rng(9)
    x = 1e-3 * np.sin(8.0 * t)
    optical = x + pollution_at(speed * t) + 20e-6 * rng.normal(size=t.size)
    acceleration = -64.0 * x
    pressure = REST + (2594.0 * x + 0.5 * acceleration) / 1.74e-4
    rows = np.column_stack([t, optical, speed * t, pressure, 0.0 * t])
    table = learn_gain(CHAMBER, speed, turns=60)
    found, estimate, _ = run(tabulated_observer_step, tabulated_start(table, 0.0), table, rows)
    whole, settled, _ = run(chamber_observer_step, chamber_observer_start(CHAMBER, 0.0), CHAMBER, rows)
    assert np.std((found - whole)[2000:]) < 0.15 * np.std((whole - x)[2000:])
    assert estimate.position_deviation == pytest.approx(settled.position_deviation, rel=0.05)
    assert estimate.velocity_deviation == pytest.approx(settled.velocity_deviation, rel=0.05)


@pytest.mark.parametrize(
    ("speed", "message"), [(0.0, "0 rpm must give at least 20 samples"), (2.0 * np.pi * 60.0, "it gives 16.67")]
)
def test_gain_without_enough_samples_in_a_turn_is_refused(speed, message):
    with pytest.raises(ParameterError, match=message):
        learn_gain(CHAMBER, speed)
