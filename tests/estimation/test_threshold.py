"""A threshold that is off: the laws of its adaptation, the loop closed over an encoder, and the offset as a state.

The encoder is the package's own; where the light is a ramp of 0.49 rad and the threshold 0.65 instead of 0.5, edges are
0.15 * 0.49 rad = 0.0735 rad late or early.
"""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.dense_filter import predict_n, update_n

from vvdp.base.errors import ParameterError
from vvdp.base.params import Params
from vvdp.base.signal import constant
from vvdp.estimation.commensurate import commensurate_clock
from vvdp.estimation.estimator import Estimate
from vvdp.estimation.event_settings import event_filter
from vvdp.estimation.expected_edge import edge_angle_variance
from vvdp.estimation.threshold import (
    EdgeOffset,
    ThresholdAdaptation,
    ThresholdMemory,
    adapted_threshold,
    dither_width,
    edge_offset_estimator,
    edge_offset_start,
    edge_offset_step,
    effective_gain,
    greatest_gain,
    largest_gap,
    residual_deviation,
    threshold_adaptation,
    threshold_start,
    threshold_step,
)
from vvdp.sensing.encoder import (
    INTERPOLATED,
    NO_FAULTS,
    SAMPLED,
    Encoder,
    EncoderMemory,
    Shaft,
    capture_unit,
    encoder_reading,
    encoder_start,
    encoder_step,
)
from vvdp.sensing.photodiode import LightSpot
from vvdp.sensing.reading import Reading
from vvdp.sensing.wheel import edge_angle, edge_below, edge_polarity, equal_wheel
from vvdp.simulation.replay import Replay
from vvdp.simulation.run import simulate
from vvdp.systems.system import load_system

pytestmark = pytest.mark.heavy

RAMP = 0.49
PERIOD = 1e-3
WHEEL = equal_wheel(8)
FILTER = event_filter(WHEEL)
STILL = Reading(0.0, 0.0, 0.0, 0.0, 0.0)
PHASES = 2.0 * np.pi * ((np.arange(200) * 0.6180339887498949) % 1.0)
"""Where the wheel stands at the first sample; evenly spread, for a constant speed has no other randomness."""


class Loop(Params):
    encoder: Encoder
    adaptation: ThresholdAdaptation


class LoopMemory(NamedTuple):
    encoder: EncoderMemory
    adaptation: ThresholdMemory


def loop_step(memory, shaft, settings):
    encoder, reading = encoder_reading(memory.encoder, shaft, memory.adaptation.comparator_threshold, settings.encoder)
    adaptation, shown = threshold_step(memory.adaptation, reading, settings.adaptation)
    return LoopMemory(encoder, adaptation), shown


def ramp_encoder(acquisition=SAMPLED, threshold=0.5):
    return Encoder(
        wheel=WHEEL,
        spot=LightSpot(width=RAMP * 1e-2, track_radius=1e-2, roundness=0.0),
        threshold=constant(threshold),
        hysteresis=0.0,
        noise=0.0,
        counter_bits=32.0,
        acquisition=acquisition,
        faults=NO_FAULTS,
    )


def adaptation(gain, dither=0.0):
    return ThresholdAdaptation(filter=FILTER, gain=gain, ramp_slope=RAMP, lowest=0.02, highest=0.98, dither=dither)


def loop(gain, acquisition=SAMPLED, dither=0.0):
    return Loop(encoder=ramp_encoder(acquisition), adaptation=adaptation(gain, dither))


def loop_start(settings, threshold, phase):
    return LoopMemory(
        encoder_start(settings.encoder, 0.0, phase, 1.0),
        threshold_start(settings.adaptation, threshold, 0.0, phase, 50.0),
    )


def turning(frequency, phase, until):
    t = PERIOD * np.arange(1, round(until / PERIOD) + 1)
    speed = 2.0 * np.pi * frequency
    return np.column_stack([t, phase + speed * t, np.full_like(t, speed)])


@pytest.fixture(scope="module")
def threshold_loop():
    settings = loop(0.05)
    return Replay(loop_step, loop_start(settings, 0.65, 0.0), Shaft(0.0, 0.0, 0.0), settings)


@pytest.fixture(scope="module")
def adapted(threshold_loop):
    """Times from enabling to within 10 % of the error, thresholds over the last second (phases, 1000), blind bands."""
    column = threshold_loop.columns.index("threshold")

    def run(settings, threshold, frequency, until=3.0, phases=PHASES):
        times, last, blind = [], [], []
        for phase in phases:
            rows = turning(frequency, phase, until)
            shown = threshold_loop(loop_start(settings, threshold, phase), rows, settings).shown
            c = shown[:, column]
            near = np.abs(c - 0.5) < 0.1 * abs(threshold - 0.5)
            times.append(PERIOD * (np.argmax(near) - np.argmax(c != threshold)) if near.any() else np.inf)
            last.append(c[-1000:])
            blind.append(shown[-1, column + 2])
        return np.array(times), np.array(last), np.array(blind)

    return run


@pytest.fixture(scope="module")
def threshold_readings():
    """Readings of an encoder with a constant threshold, and the shaft's rows."""
    settings = ramp_encoder()
    replay = Replay(encoder_step, encoder_start(settings, 0.0, 0.0, 1.0), Shaft(0.0, 0.0, 0.0), settings)

    def rows(threshold, frequency, phase, until, acquisition=SAMPLED):
        chosen = ramp_encoder(acquisition, threshold)
        shaft = turning(frequency, phase, until)
        return replay(encoder_start(chosen, 0.0, phase, 1.0), shaft, chosen).shown, shaft

    return rows


OFFSET = EdgeOffset(filter=FILTER, offset_variance=0.04, offset_drift=0.0, threshold=0.65, ramp_slope=RAMP)


@pytest.fixture(scope="module")
def offset_replay():
    return Replay(edge_offset_step, edge_offset_start(OFFSET, 0.0, 0.0, 50.0), STILL, OFFSET)


# The laws


def test_one_edge_by_hand():
    """A rising edge came 0.049 rad before it was expected: 0.65 + 0.1 (+1)(-0.049)/0.49 = 0.64."""
    assert adapted_threshold(0.65, -0.049, 1.0, 0.1, RAMP) == pytest.approx(0.64, rel=1e-14)
    assert adapted_threshold(0.65, 0.049, -1.0, 0.1, RAMP) == pytest.approx(0.64, rel=1e-14)


def two_edges(gain, k1, k2T):
    """What two edges, a rising and a falling one, do to errors of angle and speed (times T) and to the offset."""
    F = np.array([[1.0, 1.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    both = np.eye(3)
    for s in (1.0, -1.0):
        # innovation = -angle error - s offset, errors being estimate less truth
        nu = np.array([-1.0, 0.0, -s])
        K = np.array([k1, k2T, gain * s])
        both = (np.eye(3) + np.outer(K, nu)) @ F @ both
    return np.abs(np.linalg.eigvals(both)).max()


@given(st.floats(0.01, 0.6), st.floats(0.05, 0.9))
def test_greatest_gain_is_the_border_of_stability(k1, share):
    """Against the eigenvalues of two edges; share is k2 T over its greatest value for a filter that is stable alone."""
    k2T = share * k1 * k1
    border = greatest_gain(k1, k2T)
    assert two_edges(0.999 * border, k1, k2T) < 1.0 < two_edges(1.001 * border, k1, k2T)
    assert border < 2.0


@given(st.floats(0.01, 0.3), st.floats(0.05, 0.9))
def test_a_small_gain_takes_the_offset_away_at_the_effective_rate(k1, share):
    """An offset of 1 makes the filter's prior error alternate; the innovation is what is left of it and the offset."""
    k2T, gain = share * k1 * k1, 0.3
    F = np.array([[1.0, 1.0], [0.0, 1.0]])
    K, H = np.array([k1, k2T]), np.array([1.0, 0.0])
    # prior error e of alternating sign: e(next) = F (e - K (H e + s)) = -e
    e = np.linalg.solve(np.eye(2) + F @ (np.eye(2) - np.outer(K, H)), F @ K)
    assert gain * (1.0 + H @ e) == pytest.approx(effective_gain(gain, k1, k2T), rel=1e-9)


def test_without_filter_the_published_limit_is_2():
    assert effective_gain(0.3, 0.0, 0.0) == 0.3
    assert greatest_gain(1e-9, 0.0) == pytest.approx(2.0)


@given(st.floats(0.001, 1.9), st.floats(1e-6, 1.0))
def test_residual_deviation_is_stationary(gain, R):
    """delta <- (1 - gamma) delta + gamma n keeps its variance."""
    V = residual_deviation(gain, R) ** 2
    assert (1.0 - gain) ** 2 * V + gain**2 * R == pytest.approx(V, rel=1e-9)


def test_dither_width_by_hand():
    """At 157.08 rad/s and 1 ms an edge moves 0.15708 rad a sample: 0.15708/0.49 = 0.32057."""
    assert dither_width(157.0796, 1e-3, RAMP) == pytest.approx(0.320571, rel=1e-5)


@given(st.lists(st.floats(0.0, 0.999), min_size=2, max_size=20), st.floats(-3.0, 3.0))
def test_largest_gap_ignores_rotation_and_order(phases, turn):
    a = np.array(phases)
    assert largest_gap(a[::-1] + turn) == pytest.approx(largest_gap(a), abs=1e-9)
    assert 1.0 / a.size - 1e-12 <= largest_gap(a) <= 1.0


@given(st.lists(st.floats(-3.0, 3.0), min_size=1, max_size=40))
def test_largest_gap_is_that_of_the_sorted_phases(phases):
    placed = np.sort(np.array(phases) - np.floor(phases))
    gaps = np.diff([*placed, placed[0] + 1.0])
    assert largest_gap(np.array(phases)) == pytest.approx(gaps.max(), abs=1e-12)


def test_largest_gap_of_known_places():
    assert largest_gap(np.arange(8.0) / 8.0 + 3.3) == pytest.approx(0.125)
    assert largest_gap(np.full(5, 0.7)) == pytest.approx(1.0)
    assert largest_gap(np.array([0.1, 0.4, 0.9])) == pytest.approx(0.5)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"gain": 2.0}, "less than 2, or the adaptation is unstable"),
        ({"ramp_slope": 0.0}, "influence"),
        ({"lowest": 1.0}, "less than highest, 0.98"),
    ],
)
def test_settings_that_cannot_work_are_refused(change, said):
    with pytest.raises(ParameterError, match=said):
        replace(adaptation(0.05), **change)


def test_offset_needs_a_ramp():
    with pytest.raises(ParameterError, match="threshold follows"):
        replace(OFFSET, ramp_slope=0.0)


# The loop closed over an encoder


@pytest.mark.sampled(3)
@pytest.mark.parametrize("threshold", [0.65, 0.35, 0.80])
@pytest.mark.parametrize(("gain", "published_time", "published_spread"), [(0.05, 0.18, 0.009), (0.02, 0.60, 0.004)])
def test_threshold_is_found_in_the_published_time(adapted, threshold, gain, published_time, published_spread):
    """24.7 Hz on 1 kHz. The published times and spreads of 5 seeds, within a factor 1.5; the mean within 1/sqrt(200)
    of the spread, four times over."""
    times, last, _ = adapted(loop(gain), threshold, 24.7)
    assert published_time / 1.5 < np.median(times) < 1.5 * published_time
    assert last.std() < 1.5 * published_spread
    assert abs(last.mean() - 0.5) < 4.0 * last.std() / np.sqrt(PHASES.size)


def test_the_spread_stays_below_that_of_independent_noise(adapted):
    """Rounding to samples goes round within 16 edges at 24.7 Hz, so that it averages better than independent noise."""
    R = (2.0 * np.pi * 24.7 * PERIOD) ** 2 / 12.0
    _, last, _ = adapted(loop(0.05), 0.65, 24.7)
    assert last.std() * RAMP < residual_deviation(0.05, R)


def test_adaptation_stalls_where_edges_march_in_step_with_the_samples(adapted):
    """25.000 Hz on 1 kHz, 5 samples a sector: within a band of 0.32 nothing is seen, and its end is where it happens
    to be. An edge that falls on a sample flickers and has a second place: the band told is smaller there."""
    assert commensurate_clock(8 * 25.0, 1.0 / PERIOD) is not None
    times, last, blind = adapted(loop(0.05), 0.65, 25.0)
    final = last[:, -1]
    band = dither_width(2.0 * np.pi * 25.0, PERIOD, RAMP)
    assert np.isinf(times).mean() > 0.5
    assert final.max() > 0.6
    assert np.all(final < 0.5 + 0.5 * band + 0.01)  # and one step of the law beyond
    assert np.mean(blind > 0.99 * band) > 0.95
    assert np.all(abs(final - 0.5) < blind + 0.01)


def test_the_blind_band_is_small_where_they_do_not(adapted):
    """At 24.7 Hz an edge moves by 0.0607 samples: places 0.06 apart, and 0.06 of 0.317."""
    assert commensurate_clock(8 * 24.7, 1.0 / PERIOD) is None
    _, _, blind = adapted(loop(0.05), 0.65, 24.7, phases=PHASES[:20])
    assert np.all(blind < 0.2 * dither_width(2.0 * np.pi * 24.7, PERIOD, RAMP))


@pytest.mark.parametrize(
    ("acquisition", "dither"), [(SAMPLED, dither_width(2.0 * np.pi * 25.0, PERIOD, RAMP)), (INTERPOLATED, 0.0)]
)
def test_dither_or_interpolation_cures_the_stall(adapted, acquisition, dither):
    """The true threshold is reached from every phase, with the spread of a clock that is not in step."""
    times, last, blind = adapted(loop(0.05, acquisition, dither), 0.65, 25.0)
    assert np.all(times < 0.5)
    assert np.all(np.abs(last.mean(axis=1) - 0.5) < 0.02)
    assert last.std() < 1.5 * 0.009
    assert np.all(blind < 0.04)


def test_dither_takes_the_hidden_angle_away_too(threshold_loop):
    """In step the angle is off for good, evenly within omega dT/2 = 0.0785 rad: 0.039 rad in the median. With the
    dither, which is known and taken out of the edge's time, it is as good as on a clock out of step, 0.0072 rad."""
    errors = {}
    for dither in (0.0, dither_width(2.0 * np.pi * 25.0, PERIOD, RAMP)):
        settings, found = loop(0.02, dither=dither), []
        for phase in PHASES[:100]:
            rows = turning(25.0, phase, 3.0)
            shown = threshold_loop(loop_start(settings, 0.65, phase), rows, settings).shown
            found.append(np.sqrt(np.mean((shown[-1000:, 0] - rows[-1000:, 1]) ** 2)))
        errors[dither > 0.0] = np.array(found)
    assert np.median(errors[False]) == pytest.approx(0.039, abs=4.0 * 0.0785 / (2.0 * np.sqrt(100.0)))
    assert np.max(errors[True]) < 1.5 * 0.0072


def test_usual_settings_have_the_dither_that_the_clock_needs(adapted):
    """The stall is cured without being asked for; edges that are stamped get no dither."""
    usual = threshold_adaptation(FILTER, RAMP, PERIOD, 2.0 * np.pi * 40.0)
    assert usual.dither == dither_width(2.0 * np.pi * 40.0, PERIOD, RAMP)
    assert threshold_adaptation(FILTER, RAMP, 0.0, 250.0).dither == 0.0
    _, last, blind = adapted(Loop(encoder=ramp_encoder(), adaptation=usual), 0.65, 25.0, phases=PHASES[:50])
    assert np.all(np.abs(last.mean(axis=1) - 0.5) < 0.02)
    assert np.all(blind < 0.06)


def test_threshold_is_found_on_the_simulated_valve(threshold_loop):
    """The prototype's shaft, its speed swinging by 4 % with the wave, its wheel with an index, light with a noise of
    5 %. Three periods of the wave in a turn do not show in a sum that alternates four times in a turn."""
    system = load_system("prototype-constant-load", ["run.window=3 s"], until="3 s")
    run = simulate(system.model, system.case, system.stepping)
    spool, wheel = run.state.spool, equal_wheel(8, 0.25)
    encoder = replace(ramp_encoder(), wheel=wheel, noise=0.05)
    usual = threshold_adaptation(event_filter(wheel), RAMP, PERIOD, 2.0 * np.pi * 25.0)
    settings = Loop(encoder=encoder, adaptation=usual)
    column, found = threshold_loop.columns.index("threshold"), []
    for seed in range(20):
        t = 0.05 + 3.71e-5 * seed + PERIOD * np.arange(2900)
        rows = np.column_stack([t, *(np.interp(t, run.times, x) for x in (spool.angle, spool.speed))])
        start = LoopMemory(
            encoder_start(encoder, t[0], rows[0, 1], seed + 1.0),
            threshold_start(usual, 0.65 if seed % 2 else 0.35, t[0], rows[0, 1], 50.0),
        )
        found.append(np.mean(threshold_loop(start, rows, settings).shown[-1500:, column]))
    # Noise of 0.05 leaves 0.05 sqrt(gamma/(2 - gamma)) = 0.005 at an instant
    assert np.mean(found) == pytest.approx(0.5, abs=0.005)
    assert np.all(np.abs(np.array(found) - 0.5) < 0.02)


def test_nothing_is_adapted_before_the_filter_is_associated():
    memory, settings, began = loop_start(loop(0.05), 0.65, 0.3), loop(0.05), None
    for row in turning(24.7, 0.3, 0.2).tolist():
        was = memory.adaptation
        memory, shown = loop_step(memory, Shaft(*row), settings)
        if was.filter.tally.associating == 0.0:
            assert shown.threshold == 0.65
        elif began is None and shown.threshold != 0.65:
            began = row[0]
    assert began is not None


def test_the_comparator_never_gets_a_new_threshold_on_a_ramp(threshold_loop):
    """Half a sector, 0.39 rad, after an edge the next ramp, 0.245 rad before the next edge, has not begun; a sample
    (0.155 rad) later it may have, but by then the threshold has long been there."""
    settings = loop(0.05, dither=0.32)
    rows = turning(24.7, 0.0, 2.0)
    shown = threshold_loop(loop_start(settings, 0.65, 0.0), rows, settings).shown
    c = shown[:, threshold_loop.columns.index("comparator_threshold")]
    # The threshold moves edges by up to 0.16 * 0.49 rad, so that this angle is measured from the true edge.
    place = rows[1:, 1][np.diff(c) != 0.0] % (np.pi / 4.0)
    assert place.size > 300
    assert np.all(place > np.pi / 8.0 - 0.1)
    assert np.all(place < np.pi / 8.0 + 0.155 + 0.1)
    assert shown[-1, threshold_loop.columns.index("estimate.missed_edges")] == 0.0


def test_threshold_stays_within_its_bounds(threshold_loop):
    """A wheel whose bright sectors are narrower looks like a threshold that no adaptation reaches."""
    settings = loop(0.5)
    narrow = replace(settings, adaptation=replace(settings.adaptation, lowest=0.45, highest=0.55))
    c = threshold_loop(loop_start(narrow, 0.55, 0.0), turning(24.7, 0.0, 1.0), narrow).shown[
        :, threshold_loop.columns.index("threshold")
    ]
    assert c.min() >= 0.45
    assert c.max() <= 0.55


def test_compiled_loop_is_the_plain_one(threshold_loop):
    settings = loop(0.05, dither=0.3)
    rows = turning(24.7, 1.0, 0.4)
    found = threshold_loop(loop_start(settings, 0.65, 1.0), rows, settings)
    memory, plain = loop_start(settings, 0.65, 1.0), []
    for row in rows.tolist():
        memory, shown = loop_step(memory, Shaft(*row), settings)
        plain.append([*shown.estimate, *shown[1:]])
    np.testing.assert_allclose(found.shown, plain, rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(found.memory.adaptation.phases, memory.adaptation.phases, rtol=1e-9, atol=1e-9)


# The offset as a third state


def three_states(rows, settings, phase):
    """Angle, speed and offset after each edge by the filter with three states, written out on arrays."""
    f = settings.filter
    x = np.array([phase, 50.0, 0.0])
    P = np.diag([f.angle_variance, f.speed_variance, settings.offset_variance])
    time, number, found = 0.0, edge_below(phase, WHEEL), []
    for t, edges, edge_time, interval, _ in rows[rows[:, 1] > 0.0].tolist():
        h = edge_time - time
        F = np.array([[1.0, h, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
        q = f.acceleration_density
        Q = q * np.array([[h**3 / 3.0, h * h / 2.0, 0.0], [h * h / 2.0, h, 0.0], [0.0, 0.0, 0.0]])
        x, P = predict_n(x, P, F, Q)
        R = edge_angle_variance(x[1], interval, f)
        number += edges
        s = edge_polarity(number)
        H = np.array([1.0, 0.0, -s])
        x, P = update_n(x, P, H, edge_angle(number, WHEEL) - H @ x, R)
        time = edge_time
        found.append([t, x[0], x[1], x[2], P[2, 2]])
    return np.array(found)


def test_two_stages_are_the_filter_with_three_states(threshold_readings):
    """The noise of an edge depends on the speed believed, which the two have in common only where that part of the
    noise is small: stamped edges."""
    phase = 0.3
    rows, _ = threshold_readings(0.65, 24.7, phase, 0.6, capture_unit(1e-7))
    # No manoeuvre: the gate is out of reach, so that both let in the same noise.
    settings = replace(OFFSET, filter=replace(FILTER, manoeuvre_gate=1e5))
    expected = three_states(rows, settings, phase)
    memory, found = edge_offset_start(settings, 0.0, phase, 50.0), []
    for row in rows.tolist():
        memory, shown = edge_offset_step(memory, Reading(*row), settings)
        if row[1] > 0.0:
            estimate = shown.estimate
            ahead = row[0] - memory.filter.time
            found.append(
                [
                    row[0],
                    estimate.angle - ahead * estimate.speed,
                    estimate.speed,
                    shown.offset,
                    shown.offset_deviation**2,
                ]
            )
    np.testing.assert_allclose(found, expected, rtol=1e-8, atol=1e-8)
    assert expected[-1, 3] == pytest.approx(0.0735, abs=1e-3)


def test_offset_is_found_as_published(offset_replay, threshold_readings):
    """0.0719 to 0.0749 for 0.0735 rad at 24.7 Hz; the threshold without offset is 0.5."""
    offset, threshold = offset_replay.columns.index("offset"), offset_replay.columns.index("threshold")
    last = []
    for phase in PHASES[:50]:
        rows, _ = threshold_readings(0.65, 24.7, phase, 1.0)
        shown = offset_replay(edge_offset_start(OFFSET, 0.0, phase, 50.0), rows).shown[-1]
        last.append([shown[offset], shown[threshold]])
    last = np.array(last)
    assert np.all((last[:, 0] > 0.0719) & (last[:, 0] < 0.0749))
    np.testing.assert_allclose(last[:, 1], 0.5, atol=0.0016 / RAMP)


def test_offset_deviation_falls_with_the_edges(offset_replay, threshold_readings):
    """With the offset almost alone in the innovation, n edges leave R_n/n, R_n = R + P11 the innovation's variance."""
    rows, _ = threshold_readings(0.65, 24.7, 0.1, 2.0)
    shown = offset_replay(edge_offset_start(OFFSET, 0.0, 0.1, 50.0), rows).shown
    edges = rows[:, 1].sum()
    R = edge_angle_variance(2.0 * np.pi * 24.7, PERIOD, FILTER)
    assert shown[-1, offset_replay.columns.index("offset_deviation")] == pytest.approx(np.sqrt(R / edges), rel=0.05)


def test_an_offset_hardly_harms_the_filter_but_ruins_the_sector_times(offset_replay, threshold_readings):
    """2 * 0.0735/0.7854 = 18.7 % of a sector's time; the filter's mean error stays below the published 0.003 rad."""
    speed, errors, sectors = 2.0 * np.pi * 24.7, [], []
    without = replace(OFFSET, offset_variance=0.0)
    for phase in PHASES:
        rows, shaft = threshold_readings(0.65, 24.7, phase, 1.0, SAMPLED)
        shown = offset_replay(edge_offset_start(without, 0.0, phase, 50.0), rows, without).shown
        errors.append(np.mean(shown[300:, 0] - shaft[300:, 1]))
    rows, _ = threshold_readings(0.65, 24.7, 0.3, 1.0, capture_unit(1e-7))
    times = np.diff(rows[rows[:, 1] > 0.0, 2])
    sectors = times * speed / (np.pi / 4.0) - 1.0
    assert np.abs(np.mean(errors)) < 0.003
    assert np.abs(errors).max() < 1.5 * 0.003
    np.testing.assert_allclose(np.abs(sectors), 2.0 * 0.15 * RAMP / (np.pi / 4.0), rtol=1e-3)


def test_compiled_offset_filter_is_the_plain_one(offset_replay, threshold_readings):
    rows, _ = threshold_readings(0.65, 24.7, 0.1, 0.3)
    found = offset_replay(edge_offset_start(OFFSET, 0.0, 0.1, 50.0), rows).shown
    memory, plain = edge_offset_start(OFFSET, 0.0, 0.1, 50.0), []
    for row in rows.tolist():
        memory, shown = edge_offset_step(memory, Reading(*row), OFFSET)
        plain.append([*shown.estimate, *shown[1:]])
    np.testing.assert_allclose(found, plain, rtol=1e-12, atol=1e-12)


def test_offset_estimator_shows_the_estimate():
    estimator = edge_offset_estimator(OFFSET, 0.0, 0.1, 50.0)
    _, shown = estimator.step(estimator.memory, STILL, estimator.settings)
    assert isinstance(shown, Estimate)
    assert shown.angle == 0.1
