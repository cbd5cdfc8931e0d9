"""From records of known motions to angle and speed, and what is said of records with something wrong."""

import json
import signal

import h5py
import numpy as np
import pytest
from scipy.stats import chi2
from tests.offline.records import titles
from tests.words import wording

import vvdp.offline.estimate as estimating
from vvdp.base.errors import ConfigError
from vvdp.base.files import list_all
from vvdp.estimation.event_memory import event_filter_start
from vvdp.estimation.event_settings import event_filter
from vvdp.estimation.fusion import FusionReading, fusion, fusion_start
from vvdp.estimation.pressure_edges import pressure_edges
from vvdp.numerics.kalman import AngleSpeed, predict
from vvdp.offline import passes, pressure_chain, second_pass
from vvdp.offline.bridging import bridged_time
from vvdp.offline.config import load_estimation
from vvdp.offline.edges import Edges
from vvdp.offline.estimate_result import ROWS_IN_CHUNK, Store
from vvdp.offline.offline_filter import OfflineFilter, Waves, fused_step, tracked_step
from vvdp.offline.pressure_chain import PressureChain
from vvdp.offline.second_pass import SecondPass
from vvdp.offline.sums import Tally
from vvdp.results.result import Grade
from vvdp.results.store import read_meta, read_result
from vvdp.sensing.reading import Reading
from vvdp.sensing.wheel import TURN, equal_wheel
from vvdp.simulation.replay import Replay
from vvdp.simulation.values import flat

pytestmark = pytest.mark.heavy

SPEED = TURN * 24.7
PITCH = TURN / 8.0
INDEXED = equal_wheel(8, 0.25)
JITTER = 0.03  # rad


def angles_of(numbers, wheel):
    numbers = np.asarray(numbers)
    return TURN * np.floor(numbers / len(wheel.edges)) + np.array(wheel.edges)[np.mod(numbers, len(wheel.edges))]


def passing_times(count, wheel=None, first=0, jitter=0.0, seed=0, speed=SPEED, start=0.25):
    """Times at which edges `first` and on pass at a constant speed; the wheel stands at 0 at time `start` [s]."""
    wheel = equal_wheel(8) if wheel is None else wheel
    angles = angles_of(np.arange(first, first + count), wheel)
    return start + (angles + np.random.default_rng(seed).normal(0.0, jitter, count)) / speed


def times_with_a_stop(count, pause, hard=2000.0):
    """Times at which edges pass of a spool that is braked to a stop after `count` of them and driven again, both
    `hard` [rad/s^2], and stands for `pause` [s] in between; with the times at which it stops and starts."""
    begin = PITCH * (count - 0.6)  # so that it does not stop at an edge
    braked = SPEED**2 / (2.0 * hard)
    stops = 0.25 + begin / SPEED + SPEED / hard
    starts = stops + pause
    angles = PITCH * np.arange(int(2 * count + 2.0 * braked / PITCH))
    before, after = angles[angles <= begin + braked], angles[angles > begin + braked] - begin - braked
    past = np.fmax(before - begin, 0.0)
    down = 0.25 + np.fmin(before, begin) / SPEED + (SPEED - np.sqrt(SPEED**2 - 2.0 * hard * past)) / hard
    up = starts + np.sqrt(2.0 * np.fmin(after, braked) / hard) + np.fmax(after - braked, 0.0) / SPEED
    return down, up, stops, starts


def brightness(angles, wheel, spot=0.49):
    """Brightness 0 to 1 at angles [rad]: straight ramps `spot` wide about each edge."""
    edges = np.array(wheel.edges)
    away = np.mod(angles[:, None] - edges + np.pi, TURN) - np.pi
    near = np.argmin(np.abs(away), axis=1)
    sign = np.where(near % 2 == 0, 1.0, -1.0)
    return np.clip(0.5 + sign * away[np.arange(angles.size), near] / spot, 0.0, 1.0)


def stamped(times):
    return {"edge": (times, "s")}


# The estimate itself


def test_exact_stamps_give_the_exact_speed(estimated):
    kept = estimated(stamped(passing_times(1000)), sensor__edges="edge")
    found = kept.summary
    assert found["spool_speed_mean_rad_s"] == pytest.approx(SPEED, rel=1e-9)
    assert found["spool_speed_std_rad_s"] < 1e-6 * SPEED
    assert (found["edges"], found["missed_edges"], found["double_edges"], found["pieces"]) == (1000, 0, 0, 1)
    assert found["pwm_frequency_mean_Hz"] == pytest.approx(74.1)  # three sections
    t, angle = kept.column("time"), kept.column("angle")
    assert np.allclose(np.diff(t), 1e-3, rtol=0.0, atol=1e-9)
    assert t[0] == pytest.approx(0.25) and np.allclose(t * 1000.0, np.round(t * 1000.0))
    settled = t > 0.5
    assert np.allclose(angle[settled], SPEED * (t[settled] - 0.25), atol=1e-6)
    assert np.allclose(kept.column("angle_in_turn"), np.mod(angle, TURN))
    assert np.allclose(kept.column("pwm_frequency"), kept.column("speed") * 3.0 / TURN)


def test_noise_as_large_as_the_settings_say_gives_innovations_as_expected(estimated):
    # Gaussian edges of variance R_2, no process noise: the mean of n squared innovations is chi^2_n / n, a little
    # smaller because the filter allows for an acceleration that is not there: P/(P + R) = 8 % at most.
    kept = estimated(
        stamped(passing_times(4000, jitter=JITTER)), sensor__edges="edge", filter__edge_variance=f"{JITTER**2} rad^2"
    )
    n = kept.summary["nis_edges"]
    low, high = chi2.ppf([1e-4, 1.0 - 1e-4], n) / n
    assert 0.92 * low < kept.summary["nis_mean"] < high
    assert not titles(kept)
    t = kept.column("time")
    late = t > 0.5
    error = kept.column("angle") - SPEED * (t - 0.25)
    assert np.std(error[late]) < 1.2 * np.mean(kept.column("angle_deviation")[late])
    assert np.mean(np.abs(error[late]) < 2.0 * kept.column("angle_deviation")[late]) > 0.9


def test_a_wave_with_an_index_gives_the_absolute_angle(estimated):
    t = np.arange(0.0, 4.0, 1e-4)
    true = 2.3 + SPEED * t
    v = 0.5 + 3.0 * brightness(true, INDEXED) + np.random.default_rng(1).normal(0.0, 0.02, t.size)
    kept = estimated({"time": (t, "s"), "diode": (v, "V")}, sensor__wave="diode", sensor__index_shift=0.25)
    assert kept.summary["index_found"] is True
    assert kept.summary["threshold"] == pytest.approx(2.0, abs=0.02)
    rows = kept.column("time")
    late = rows > 0.3
    error = np.mod(kept.column("angle") - 2.3 - SPEED * rows + np.pi, TURN) - np.pi
    # the threshold's 0.02 V of 3 V on a ramp of 0.49 rad: 3 mrad, which alternates
    assert np.max(np.abs(error[late])) < 0.01
    assert kept.summary["spool_speed_mean_rad_s"] == pytest.approx(SPEED, rel=1e-4)


def test_a_counter_gives_the_speed_with_the_noise_of_its_sampling(estimated):
    t = np.arange(0.0, 5.0, 1e-3)
    counts = np.floor((0.4 + SPEED * t) / PITCH)
    kept = estimated({"time": (t, "s"), "n": (counts, "")}, sensor__counts="n")
    assert kept.summary["edges"] == counts[-1]
    assert kept.summary["spool_speed_mean_rad_s"] == pytest.approx(SPEED, rel=1e-3)
    assert not kept.summary["commensurate"] and wording.estimate.wrong_sectors not in titles(kept)


def test_small_portions_give_the_same_as_large_ones(estimated, monkeypatch):
    t = np.arange(0.0, 3.0, 2e-4)
    v = brightness(0.7 + SPEED * t, INDEXED) + np.random.default_rng(2).normal(0.0, 0.01, t.size)
    channels = {"time": (t, "s"), "diode": (v, "V")}
    keys = {"sensor__wave": "diode", "sensor__index_shift": 0.25, "threshold__level": 0.5}
    whole = estimated(channels, **keys)
    monkeypatch.setattr(passes, "SAMPLES_AT_ONCE", 1009)
    parts = estimated(channels, **keys)
    for name in ("time", "angle", "speed", "piece", "edges/time", "edges/number"):
        assert np.allclose(parts.column(name), whole.column(name), rtol=1e-3, atol=1e-3), name
    assert parts.size("time") == whole.size("time")


def test_the_smoother_is_better_than_the_filter(estimated):
    rng = np.random.default_rng(4)
    # a random walk of the speed as the filter assumes it, q = 25 rad^2/s^3, finely integrated
    t = np.arange(0.0, 20.0, 1e-4)
    speed = SPEED + np.cumsum(rng.normal(0.0, np.sqrt(25.0 * 1e-4), t.size))
    angle = np.cumsum(speed) * 1e-4
    edges = np.arange(1, int(angle[-1] / PITCH)) * PITCH
    times = np.interp(edges + rng.normal(0.0, JITTER, edges.size), angle, t)
    kept = estimated(
        stamped(np.sort(times)),
        sensor__edges="edge",
        output__smooth=True,
        filter__acceleration_density="25 rad^2/s^3",
        filter__edge_variance=f"{JITTER**2} rad^2",
    )
    rows = kept.column("time")
    late = (rows > 1.0) & (rows < 19.0)
    true = np.interp(rows, t, speed)
    filtered, smoothed = kept.column("speed") - true, kept.column("smoothed_speed") - true
    assert np.std(smoothed[late]) < 0.8 * np.std(filtered[late])
    ratio = np.std(smoothed[late]) / np.mean(kept.column("smoothed_speed_deviation")[late])
    assert 0.8 < ratio < 1.2  # its own deviation is honest
    assert np.isfinite(smoothed[late]).all()


# What may be wrong with a record


def test_missed_edges_are_counted_one_by_one(estimated):
    times = passing_times(2000, jitter=0.01)
    lost = np.random.default_rng(5).choice(np.arange(50, 1950), 40, replace=False)
    kept = estimated(stamped(np.delete(times, lost)), sensor__edges="edge")
    assert kept.summary["missed_edges"] == 40
    assert kept.summary["edges"] == 1960
    assert wording.estimate.missed_edges in titles(kept)
    assert kept.summary["spool_speed_mean_rad_s"] == pytest.approx(SPEED, rel=1e-3)
    rows = kept.column("time")
    late = rows > 0.5
    assert np.max(np.abs(kept.column("angle") - SPEED * (rows - 0.25))[late]) < 0.5 * PITCH


def test_double_edges_are_taken_out(estimated):
    times = passing_times(1000, jitter=0.01)
    kept = estimated(stamped(np.sort(np.concatenate([times, times[100:900:40] + 1e-4]))), sensor__edges="edge")
    assert kept.summary["double_edges"] == 20
    assert kept.summary["missed_edges"] == 0
    assert kept.summary["spool_speed_mean_rad_s"] == pytest.approx(SPEED, rel=1e-4)


def test_through_a_pause_the_spool_is_said_to_stand_where_it_is(estimated):
    # A spool at 155 rad/s that stopped and started within one sector would do what no drive can: see lost_sensor.
    before, after, _, starts = times_with_a_stop(400, 5.0)
    kept = estimated(stamped(np.concatenate([before, after])), sensor__edges="edge")
    assert kept.summary["pieces"] == 2 and wording.estimate.pauses in titles(kept)
    t, angle = kept.column("time"), kept.column("angle")
    assert np.allclose(np.diff(t), 1e-3, atol=1e-9)
    inside = (t > before[-1] + 1.0) & (t < starts - 2e-3)
    assert kept.summary["lost_sensor_s"] == 0.0
    assert np.all(kept.column("standstill")[inside] > 0.5) and np.isfinite(angle).all()
    assert np.ptp(angle[inside]) == 0.0 and np.all(np.abs(kept.column("speed")[inside]) < 1.0)
    known = angle[np.isfinite(angle)]
    assert known[-1] > known[0] + TURN * 90  # the unwrapped angle never falls back
    assert set(np.unique(kept.column("piece"))) == {1.0, 2.0}


@pytest.mark.parametrize("fit", [None, True])
def test_where_a_spool_stops_it_may_have_turned_back(estimated, fit):
    """Also with fitted settings, with which the record is cut there; not where the sensor was lost at full speed."""
    before, after, *_ = times_with_a_stop(400, 2.0)
    kept = estimated(stamped(np.concatenate([before, after])), sensor__edges="edge", filter__fit=fit)
    assert wording.estimate.turned_back in titles(kept)
    times = passing_times(800)
    lost = np.concatenate([times[:400], times[400:] + 2.0])
    assert wording.estimate.turned_back not in titles(estimated(stamped(lost), sensor__edges="edge", filter__fit=fit))


@pytest.mark.sampled(5)
@pytest.mark.parametrize("late", [1.0, 20.0, 1e5, 1e9, 1e300])
@pytest.mark.parametrize("lonely", [1, 2])
def test_edges_long_after_the_last_change_nothing(estimated, late, lonely):
    times = passing_times(400)
    alone = estimated(stamped(times), sensor__edges="edge")
    kept = estimated(stamped(np.append(times, times[-1] + late * np.arange(1, lonely + 1))), sensor__edges="edge")
    assert kept.summary["pieces"] == 1 and kept.summary["missed_edges"] == kept.summary["double_edges"] == 0
    n = alone.size("time")
    assert np.array_equal(kept.column("speed")[:n], alone.column("speed"))
    bridge = bridged_time(PITCH / SPEED, event_filter(equal_wheel(8)))
    assert kept.column("time")[-1] < times[-1] + bridge + 2e-3
    assert kept.summary["duration_s"] == pytest.approx(times[-1] - times[0], rel=1e-12)
    assert kept.summary["edges"] == 400 + lonely and wording.estimate.edges_left_out in titles(kept)
    assert any(f"{times[-1] + late:.6g}" in finding.text for finding in kept.findings)


@pytest.mark.parametrize("early", [1.0, 5.0, 1e4])
def test_an_edge_long_before_the_first_changes_nothing(estimated, early):
    times = passing_times(400)
    alone = estimated(stamped(times), sensor__edges="edge")
    kept = estimated(stamped(np.append(times[0] - early, times)), sensor__edges="edge")
    assert kept.summary["double_edges"] == 0
    assert np.array_equal(kept.column("time"), alone.column("time"))
    assert np.array_equal(kept.column("speed"), alone.column("speed"))


def test_slow_edges_after_a_pause_are_a_piece_of_their_own(estimated):
    # From the first silence on everything is slow; judged by what comes after, it would be no silence.
    times = passing_times(400)
    kept = estimated(stamped(np.append(times, times[-1] + 0.8 * np.arange(1, 60))), sensor__edges="edge")
    assert kept.summary["pieces"] == 2 and kept.summary["missed_edges"] == kept.summary["double_edges"] == 0
    slow = kept.column("speed")[kept.column("piece") == 2.0]
    assert np.median(slow[-10_000:]) == pytest.approx(PITCH / 0.8, rel=0.1)


def test_one_wild_time_in_the_midst_leaves_the_rest_alone(estimated):
    times = passing_times(800)
    wild = times.copy()
    wild[500] = 1e4
    kept = estimated(stamped(wild), sensor__edges="edge")
    found, t = kept.summary, kept.column("time")
    first = kept.column("piece") == 1.0
    turning = np.where(first, (t > 0.5) & (t < times[499]), t > times[501] + 0.3)
    assert np.allclose(kept.column("speed")[turning], SPEED, rtol=0.01)
    assert found["spool_speed_max_rad_s"] == pytest.approx(SPEED, rel=0.01)
    assert found["duration_s"] == pytest.approx(times[-1] - times[0], abs=0.02)


def test_the_cut_does_not_depend_on_the_portions(estimated, monkeypatch):
    times = passing_times(300)
    pauses = np.concatenate([times, times[-1] + 0.7 + times[:9], times[-1] + 2.2 + times[:2], times[-1] + 3.5 + times])
    whole = estimated(stamped(pauses), sensor__edges="edge")
    for portion in (7, 50, 301):
        monkeypatch.setattr(passes, "SAMPLES_AT_ONCE", portion)
        parts = estimated(stamped(pauses), sensor__edges="edge")
        assert np.array_equal(parts.column("time"), whole.column("time"))
        assert np.allclose(parts.column("angle"), whole.column("angle"), rtol=0.0, atol=1e-9, equal_nan=True)


def test_the_share_of_the_time_with_an_estimate_is_told(estimated):
    times = passing_times(800)
    full = estimated(stamped(times), sensor__edges="edge").summary
    assert full["estimated_share"] == pytest.approx(1.0, abs=1e-3)
    before, after, stops, starts = times_with_a_stop(400, 5.0)
    kept = estimated(stamped(np.concatenate([before, after])), sensor__edges="edge")
    found, speed = kept.summary, kept.column("speed")
    assert found["duration_s"] == pytest.approx(after[-1] - before[0])
    assert found["estimated_share"] == pytest.approx(1.0, abs=1e-3)  # through the silence it stands
    # the mean is over the rows that the filter gives: between two pieces the last one is only held
    usual = np.median(np.diff(before)[-16:])
    rows, bridge = kept.column("time"), bridged_time(usual, event_filter(equal_wheel(8)))
    settled = (rows >= before[16]) & ((rows <= before[-1] + bridge) | (rows >= after[16]))
    assert found["spool_speed_mean_rad_s"] == pytest.approx(np.mean(speed[settled]), rel=0.02)
    assert found["standstill_time_s"] == pytest.approx(starts - stops, abs=0.1)


def test_edge_times_that_are_no_numbers_are_told(estimated):
    times = passing_times(400)
    times[[100, 101, 200]] = np.nan
    times[300] = np.inf
    kept = estimated(stamped(times), sensor__edges="edge")
    assert kept.summary["not_numbers"] == 4 and wording.estimate.no_numbers in titles(kept)


def test_time_that_runs_backwards_cuts_the_record(estimated):
    one, two = passing_times(300), passing_times(300, start=0.1)
    kept = estimated(stamped(np.concatenate([one, two])), sensor__edges="edge")
    assert kept.summary["backward_times"] == 1 and kept.summary["pieces"] == 2
    assert wording.estimate.time_backwards in titles(kept) and wording.estimate.pauses not in titles(kept)
    t, piece = kept.column("time"), kept.column("piece")
    assert t[piece == 2.0][0] < t[piece == 1.0][-1]
    assert kept.summary["spool_speed_mean_rad_s"] == pytest.approx(SPEED, rel=1e-6)
    waves = np.arange(0.0, 1.5, 1e-3)
    both = np.concatenate([waves, waves])
    kept = estimated({"time": (both, "s"), "n": (np.floor(SPEED * np.arange(both.size) * 1e-3 / PITCH), "")},
                     sensor__counts="n")  # fmt: skip
    assert kept.summary["backward_times"] == 1 and kept.summary["pieces"] == 2


def test_gaps_and_values_that_are_no_numbers_are_told(estimated):
    t = np.arange(0.0, 3.0, 2e-4)
    v = brightness(0.7 + SPEED * t, INDEXED)
    v[5000:5003] = np.nan
    present = (t < 1.5) | (t > 1.53)
    kept = estimated({"time": (t[present], "s"), "diode": (v[present], "V")}, sensor__wave="diode",
                     sensor__index_shift=0.25)  # fmt: skip
    assert kept.summary["gaps"] == 1 and kept.summary["not_numbers"] == 3
    assert {wording.estimate.gaps, wording.estimate.no_numbers} <= titles(kept)
    assert kept.summary["pieces"] == 1  # 30 ms are bridged
    # At 24.7 Hz 5.06 ms a sector: 0.03 s hold about six edges, of which those within are gone.
    assert 4 <= kept.summary["missed_edges"] <= 7
    rows = kept.column("time")
    error = np.mod(kept.column("angle") - 0.7 - SPEED * rows + np.pi, TURN) - np.pi
    assert np.max(np.abs(error[rows > 0.3])) < 0.05


@pytest.mark.parametrize(("level", "inverted"), [(1.4, False), (2.5, False), (2.4, True)])
def test_a_threshold_that_is_off_is_found_and_a_better_one_named(estimated, level, inverted):
    t = np.arange(0.0, 3.0, 1e-4)
    bright = brightness(0.3 + SPEED * t, equal_wheel(8))
    v = 0.5 + 3.0 * (1.0 - bright if inverted else bright)
    kept = estimated({"time": (t, "s"), "diode": (v, "V")}, sensor__wave="diode", threshold__level=level,
                     sensor__inverted=inverted)  # fmt: skip
    # A ramp of 0.49 rad over 3 V: edges are off by (level - 2) 0.49/3, late where too high, and not inverted.
    expected = (level - 2.0) * 0.49 / 3.0 * (-1.0 if inverted else 1.0)
    assert kept.summary["threshold_bias_rad"] == pytest.approx(expected, rel=0.1)
    assert kept.summary["threshold_suggested"] == pytest.approx(2.0, abs=0.06)
    assert wording.estimate.threshold_off in titles(kept)
    assert wording.estimate.elsewhere not in titles(kept)


def test_edges_that_lie_elsewhere_are_found_on_the_wheel(estimated):
    moved = np.array(equal_wheel(8).edges)
    moved[3] += 0.06
    numbers = np.arange(4000)
    true = TURN * (numbers // 8) + moved[numbers % 8] + np.random.default_rng(6).normal(0.0, JITTER, numbers.size)
    kept = estimated(stamped(0.1 + true / SPEED), sensor__edges="edge")
    offsets = kept.result.tables["wheel-edges"]["offset_rad"]
    # The mean of all offsets cannot be seen: 0.06 (1 - 1/8) = 0.0525 at edge 3, -0.0075 elsewhere. The filter follows
    # a part K = P/S of it, below 8 %.
    assert offsets[3] == pytest.approx(0.0525, rel=0.1)
    assert np.delete(offsets, 3) == pytest.approx(np.full(7, -0.0075), abs=4.0 * JITTER / np.sqrt(500))
    (finding,) = [f for f in kept.findings if f.title == wording.estimate.elsewhere]
    # 0.0525 rad are 3.01 degrees; see above for the 10 %
    lies = float(finding.text.removeprefix("Edge 3 lies ").partition(" \u00b0 beyond its place")[0])
    assert lies == pytest.approx(np.degrees(0.0525), rel=0.1) and wording.estimate.stands_alone in finding.text


def test_an_eccentric_wheel_is_called_one(estimated):
    numbers = np.arange(4000)
    nominal = numbers * PITCH
    true = nominal + 0.05 * np.sin(nominal) + np.random.default_rng(7).normal(0.0, 0.01, numbers.size)
    kept = estimated(stamped(0.1 + true / SPEED), sensor__edges="edge")
    (finding,) = [f for f in kept.findings if f.title == wording.estimate.elsewhere]
    assert "eccentric" in finding.text


def test_a_wrong_number_of_sectors_is_suspected(estimated):
    widths = np.array([1.0, 1.1, 0.9, 1.05, 1.0, 0.95, 1.1, 0.9, 1.0, 1.0])  # ten sectors, not quite equal
    places = np.concatenate([[0.0], np.cumsum(widths)[:-1]]) * TURN / np.sum(widths)
    numbers = np.arange(3000)
    true = TURN * (numbers // 10) + places[numbers % 10]
    kept = estimated(stamped(0.1 + true / SPEED), sensor__edges="edge", sensor__sectors=8)
    (finding,) = [f for f in kept.findings if f.title == wording.estimate.wrong_sectors]
    assert wording.estimate.repeat_after.format(count=10) in finding.text
    right = estimated(stamped(0.1 + true / SPEED), sensor__edges="edge", sensor__sectors=10)
    assert wording.estimate.wrong_sectors not in titles(right)


def test_an_index_that_is_not_there_is_missed(estimated):
    times = passing_times(800, jitter=JITTER)
    kept = estimated(stamped(times), sensor__edges="edge", sensor__index_shift=0.25)
    assert kept.summary["index_found"] is False and wording.estimate.index_not_found in titles(kept)
    kept = estimated(stamped(passing_times(800, INDEXED, jitter=0.02)), sensor__edges="edge", sensor__index_shift=0.25)
    assert kept.summary["index_found"] is True and wording.estimate.index_not_found not in titles(kept)


def test_edges_in_step_with_the_clock_are_told(estimated):
    t = np.arange(5000) / 1000.0
    counts = np.floor((0.1 + TURN * 25.0 * t) / PITCH + 1e-9)
    kept = estimated({"time": (t, "s"), "n": (counts, "")}, sensor__counts="n")
    assert kept.summary["commensurate"] is True and wording.estimate.in_step in titles(kept)


SETTINGS = wording.estimate.settings_do_not_fit


def test_settings_that_do_not_fit_are_told_with_better_ones(estimated):
    # A speed error of 0.1 % is not worth a word, whatever the deviations say; edges that scatter more than stated are.
    quiet = estimated(stamped(passing_times(3000, jitter=0.01)), sensor__edges="edge")
    assert SETTINGS not in titles(quiet) and quiet.summary["settings_fit"] is True
    loud = estimated(stamped(passing_times(3000, jitter=0.1)), sensor__edges="edge")
    (finding,) = [f for f in loud.findings if f.title == SETTINGS]
    named = float(finding.remedy.partition('edge_variance = "')[2].split()[0])
    # n - 2 squares: a standard error of sqrt(2/n) = 2.6 %, four times that
    assert named == pytest.approx(0.1**2, rel=0.11)
    assert named == pytest.approx(loud.summary["edge_variance_fitted_rad2"], rel=5e-3)


def swinging_times(amplitude, frequency, duration=10.0, jitter=0.02, seed=7):
    """Times of edges at 120 rad/s and a sine on it [rad/s, Hz]."""
    t = np.arange(0.0, duration, 1e-4)
    swing = amplitude / (TURN * frequency)
    angle = 120.0 * t + swing * (1.0 - np.cos(TURN * frequency * t))
    numbers = np.arange(1, int(angle[-1] / PITCH))
    return np.interp(numbers * PITCH + np.random.default_rng(seed).normal(0.0, jitter, numbers.size), angle, t)


@pytest.mark.sampled(3)
@pytest.mark.parametrize(("amplitude", "frequency"), [(3.0, 2.0), (6.0, 2.0), (15.0, 0.5)])
def test_a_speed_that_changes_asks_for_other_settings_and_no_other_wheel(estimated, amplitude, frequency):
    times = swinging_times(amplitude, frequency)
    kept = estimated(stamped(times), sensor__edges="edge")
    assert titles(kept) == {SETTINGS} and kept.summary["settings_fit"] is False
    fitted = estimated(stamped(times), sensor__edges="edge", filter__fit=True)
    assert not titles(fitted) and fitted.summary["settings_fit"] is True
    used = [fitted.summary[key] for key in ("acceleration_density_rad2_s3", "edge_variance_rad2")]
    assert used == pytest.approx(
        [kept.summary[key] for key in ("acceleration_density_fitted_rad2_s3", "edge_variance_fitted_rad2")], rel=0.02
    )
    # they stand in the config that is written, which gives the same again
    assert "fit = false" in fitted.config and f'edge_variance = "{used[1]!r} rad^2"' in fitted.config
    assert fitted.summary["spool_speed_mean_rad_s"] == pytest.approx(120.0, abs=0.05 + 0.02 * amplitude)

    def error(found):
        t = found.column("time")
        true = 120.0 + amplitude * np.sin(TURN * frequency * t)
        return float(np.sqrt(np.mean((found.column("speed") - true)[t > 0.5] ** 2)))

    assert error(fitted) < 0.6 * error(kept)
    # the error that is stated is that of a random course; a sine is none, but not far from it
    assert error(fitted) == pytest.approx(fitted.summary["speed_deviation_mean_rad_s"], rel=0.4)


def test_a_fit_to_exact_edges_stands_its_own_test(estimated):
    kept = estimated(stamped(np.round(passing_times(1500), 9)), sensor__edges="edge", filter__fit=True)
    assert not titles(kept) and kept.summary["missed_edges"] == 0
    assert kept.summary["spool_speed_mean_rad_s"] == pytest.approx(SPEED, rel=1e-9)


def test_settings_are_not_fitted_to_numbers_in_doubt(estimated):
    times = passing_times(1200, jitter=0.02)
    half = times[np.random.default_rng(3).random(times.size) > 0.5]
    kept = estimated(stamped(half), sensor__edges="edge", filter__fit=True)
    assert kept.summary["edge_variance_rad2"] == 3.47e-3
    assert wording.estimate.missed_edges in titles(kept) and not titles(kept) & {
        SETTINGS,
        wording.estimate.wrong_sectors,
    }
    short = estimated(stamped(times[:40]), sensor__edges="edge", filter__fit=True)
    assert short.summary["edge_variance_rad2"] == 3.47e-3 and wording.estimate.taken_for_granted in titles(short)


def test_the_fit_is_made_of_the_beginning_of_a_wave_too(estimated, monkeypatch):
    monkeypatch.setattr(estimating, "FITTED_EDGES", 300)
    monkeypatch.setattr(passes, "SAMPLES_AT_FIRST", 5000)
    t = np.arange(0.0, 4.0, 1e-4)
    v = brightness(2.3 + SPEED * t, equal_wheel(8)) + np.random.default_rng(1).normal(0.0, 0.01, t.size)
    kept = estimated({"time": (t, "s"), "diode": (v, "V")}, sensor__wave="diode", filter__fit=True)
    assert kept.summary["edges"] > 700 and kept.summary["samples"] == t.size
    assert kept.summary["edge_variance_rad2"] < 1e-4


def test_an_index_that_a_wave_does_not_have_is_not_found_and_no_threshold_named(estimated):
    t = np.arange(0.0, 4.0, 1e-4)
    v = 0.3 + 3.9 * brightness(0.3 + 155.0 * t, equal_wheel(8)) + np.random.default_rng(1).normal(0.0, 0.05, t.size)
    channels = {"time": (t, "s"), "diode": (v, "V")}
    kept = estimated(channels, sensor__wave="diode", sensor__index_shift=0.25)
    assert kept.summary["index_found"] is False and kept.summary["threshold_suggested"] is None
    assert wording.estimate.index_not_found in titles(kept) and not titles(kept) & {
        wording.estimate.threshold_off,
        SETTINGS,
    }
    right = estimated(channels, sensor__wave="diode")
    assert right.summary["threshold_suggested"] == pytest.approx(2.25, abs=0.02)


def test_a_threshold_outside_of_the_swing_is_not_named(estimated):
    # Bright sectors a tenth wider than their share: no threshold of this steep wave makes them alike.
    t = np.arange(0.0, 4.0, 1e-4)
    angle = 0.3 + 50.0 * t
    wide = np.mod(angle, 2.0 * PITCH) < 1.1 * PITCH
    v = np.convolve(np.where(wide, 4.0, 0.3), np.ones(3) / 3.0, "same")
    kept = estimated({"time": (t, "s"), "diode": (v, "V")}, sensor__wave="diode")
    # half of that at either edge; the filter follows 8 % of each, which the next one sees on top
    assert -kept.summary["threshold_bias_rad"] == pytest.approx(0.05 * PITCH, rel=0.15)
    assert kept.summary["threshold_suggested"] is None
    (finding,) = [f for f in kept.findings if f.title == wording.estimate.threshold_off]
    assert "threshold.level" not in finding.remedy


def test_of_an_eccentric_wheel_the_wheel_is_told_first(estimated):
    numbers = np.arange(1.0, 1200.0)
    times = (numbers * PITCH + 0.1 * np.sin(numbers * PITCH)) / 100.0
    kept = estimated(stamped(times), sensor__edges="edge")
    assert kept.findings[0].title == wording.estimate.elsewhere and SETTINGS not in titles(kept)


def test_a_clock_in_place_of_edges_is_told(estimated):
    t = np.arange(5000) * 1e-4
    v = np.sin(SPEED * 4.0 * t)
    kept = estimated({"time": (t, "s"), "diode": (v, "V")}, sensor__edges="time")
    assert kept.findings[0].title == wording.estimate.even_clock and kept.findings[0].grade is Grade.BAD
    assert "0.0001 s apart" in kept.findings[0].text and "'diode'" in kept.findings[0].remedy
    assert wording.estimate.even_clock not in titles(estimated(stamped(t[::50]), sensor__edges="edge"))


@pytest.mark.parametrize(
    ("count", "words"),
    [(1, wording.estimate.edge_did.format(count=1)), (2, wording.estimate.edges_did.format(count=2))],
)
def test_one_is_one(estimated, count, words):
    times = np.delete(passing_times(400, jitter=0.01), np.arange(200, 200 + 40 * count, 40))
    (finding,) = [
        f for f in estimated(stamped(times), sensor__edges="edge").findings if f.title == wording.estimate.missed_edges
    ]
    assert finding.text.startswith(words)


def test_a_time_range_is_kept_to(estimated):
    kept = estimated(stamped(passing_times(1000)), sensor__edges="edge", log__from="1 s", log__until="3 s")
    t = kept.column("time")
    assert t[0] >= 1.0 and t[-1] <= 3.0
    assert kept.summary["edges"] == pytest.approx(2.0 * 24.7 * 8, abs=1)


@pytest.mark.parametrize("portion", [1_000_000, 3_000, 700])
def test_a_time_range_holds_for_each_of_several_records(estimated, monkeypatch, portion):
    """Of two records of 2 s, 1 s of each: at 24.7 turns of 8 sectors, 197.6 edges each, less those at the ends."""
    monkeypatch.setattr(passes, "SAMPLES_AT_ONCE", portion)
    t = np.arange(0.0, 2.0, 1e-3)
    counts = np.floor((0.1 + SPEED * t) / PITCH)
    channels = {"time": (np.tile(t, 2), "s"), "n": (np.tile(counts, 2), "")}
    found = estimated(channels, sensor__counts="n", log__until="1 s").summary
    assert found["edges"] == pytest.approx(2.0 * 197.6, abs=2)
    assert (found["backward_times"], found["pieces"]) == (1, 2)
    assert found["duration_s"] == pytest.approx(2.0, abs=2e-3)


def test_edge_times_in_other_units(estimated):
    kept = estimated({"edge": (1e3 * passing_times(400), "ms")}, sensor__edges="edge")
    assert kept.summary["spool_speed_mean_rad_s"] == pytest.approx(SPEED, rel=1e-7)


@pytest.mark.parametrize(("unit", "factor"), [("ms", 1e3), ("sec", 1.0), ("min", 1.0 / 60.0)])
def test_each_column_of_edge_times_has_its_own_unit(estimated, unit, factor):
    times = passing_times(400)
    kept = estimated({"rise": (times[0::2], "s"), "fall": (factor * times[1::2], unit)}, sensor__edges="rise",
                     sensor__falling="fall")  # fmt: skip
    assert kept.summary["spool_speed_mean_rad_s"] == pytest.approx(SPEED, rel=1e-7)
    assert kept.summary["edges"] == 400 and kept.summary["pieces"] == 1


def test_the_unit_of_edge_times_is_for_those_that_have_none(estimated):
    kept = estimated({"edge": (1e3 * passing_times(400), "")}, sensor__edges="edge", log__time_unit="ms")
    assert kept.summary["spool_speed_mean_rad_s"] == pytest.approx(SPEED, rel=1e-7)
    with pytest.raises(
        ConfigError, match=wording.estimate.contradicts_unit.format(channel="edge", unit="s", other="ms")
    ):
        estimated(stamped(passing_times(400)), sensor__edges="edge", log__time_unit="ms")


# Which edge is the first


@pytest.mark.parametrize("start", [0.3, 4.5])
def test_of_two_sectors_the_polarity_tells_the_index(estimated, start):
    """The angle is absolute, though there is one candidate and none to compare it with. At 0.3 the spot is on the
    bright sector, so the first edge falls, edge 1; at 4.5, beyond 1.3 pi = 4.08, it is on the dark one."""
    wheel = equal_wheel(2, 0.3)
    t = np.arange(0.0, 3.0, 1e-4)
    v = brightness(start + SPEED * t, wheel, 0.2) + np.random.default_rng(1).normal(0.0, 0.01, t.size)
    kept = estimated({"time": (t, "s"), "diode": (v, "V")}, sensor__wave="diode", sensor__sectors=2,
                     sensor__index_shift=0.3)  # fmt: skip
    assert kept.summary["index_found"] is True
    rows = kept.column("time")
    error = np.mod(kept.column("angle") - start - SPEED * rows + np.pi, TURN) - np.pi
    assert np.max(np.abs(error[rows > 1.0])) < 0.02


def test_a_wheel_with_an_index_that_is_sampled_too_slowly_is_none(estimated):
    # 160 sectors a second at 60 Hz: a sample has 2 or 3 of them, so no stretch of 16 has the 8 edges of a turn
    t = np.arange(0.0, 60.0, 1.0 / 60.0)
    counts = np.floor((TURN * 20.0 * t + 0.2 + 0.3 * np.sin(0.5 * t)) / PITCH)
    kept = estimated({"time": (t, "s"), "n": (counts, "")}, sensor__counts="n", sensor__index_shift=0.3)
    assert kept.summary["index_found"] is False and wording.estimate.index_not_found in titles(kept)
    assert kept.summary["spool_speed_mean_rad_s"] == pytest.approx(TURN * 20.0, rel=0.01)


# Pressure


def pressure_of(angles, duty=0.4):
    share = np.mod(3.0 * angles / TURN, 1.0)
    return 5.0 + 95.0 * np.clip(np.minimum(share, duty - share) / 0.04 + 0.5, 0.0, 1.0)  # noqa: TID251


@pytest.mark.parametrize("excess", [0.0, 0.08])
def test_the_pressure_gives_the_duty_ratio_and_folds_onto_the_turn(estimated, excess):
    t = np.arange(0.0, 3.0, 1e-4)
    true = 0.3 + SPEED * t
    kept = estimated(
        {"time": (t, "s"), "diode": (brightness(true, INDEXED), "V"), "inlet": (pressure_of(true), "bar")},
        sensor__wave="diode",
        sensor__index_shift=0.25,
        pressure__channel="inlet",
        pressure__duty_excess=excess,
    )
    # Crossings of one half lie `duty` of a period apart; a level off by 5 % of the swing moves each by 0.05 x 0.04.
    assert kept.summary["duty_ratio_mean"] == pytest.approx(0.4 - excess, abs=4e-3)
    watched = 4.0 * pressure_edges().level_time  # before its plateaus are believed
    assert kept.summary["pressure_pulses"] == pytest.approx((3.0 - watched) * 74.1, abs=3)
    assert kept.summary["pressure_max_inlet_Pa"] == pytest.approx(100e5, rel=1e-3)
    fold = kept.result.tables["pressure-fold"]
    angle, mean = fold["angle_rad"], fold["pressure_Pa"]
    assert np.allclose((mean - 101325.0) / 1e5, pressure_of(angle), atol=8.0)
    assert np.nanmax(kept.column("inlet_pressure")) <= 100e5 + 101326.0


@pytest.mark.parametrize("portion", [1_000_000, 7_000])
def test_the_pressure_is_cut_where_time_runs_backwards(estimated, monkeypatch, portion):
    """Three records in one file: each pressure belongs to the angle of its own record."""
    monkeypatch.setattr(passes, "SAMPLES_AT_ONCE", portion)
    t = np.arange(0.0, 2.0, 2e-4)
    angles = np.concatenate([start + SPEED * t for start in (0.3, 2.1, 1.2)])
    kept = estimated(
        {
            "time": (np.tile(t, 3), "s"),
            "diode": (brightness(angles, INDEXED), "V"),
            "inlet": (pressure_of(angles), "bar"),
        },
        sensor__wave="diode",
        sensor__index_shift=0.25,
        pressure__channel="inlet",
    )
    assert kept.summary["backward_times"] == 2 and kept.summary["index_found"]
    assert kept.summary["duty_ratio_mean"] == pytest.approx(0.4, abs=4e-3)
    watched = 4.0 * pressure_edges().level_time  # of each record, before its plateaus are believed
    assert kept.summary["pressure_pulses"] == pytest.approx(3 * (2.0 - watched) * 74.1, abs=9)
    fold = kept.result.tables["pressure-fold"]
    angle, low, high = (fold[key] for key in ("angle_rad", "pressure_low_Pa", "pressure_high_Pa"))
    flat_part = np.abs(np.mod(3.0 * angle / TURN, 1.0) - 0.2) < 0.12  # up, and far from either edge
    assert np.allclose((low[flat_part] - 101325.0) / 1e5, 100.0, atol=1.0)
    down = np.abs(np.mod(3.0 * angle / TURN, 1.0) - 0.7) < 0.22
    assert np.allclose((high[down] - 101325.0) / 1e5, 5.0, atol=1.0)


@pytest.mark.parametrize("rate", [1e2, 5e4])
def test_the_clock_of_the_wave_is_not_that_of_the_pressure(estimated, rate):
    """2 s at 5 kHz, 395 edges; by the pressure's clock at 50 kHz each interval would be a gap, 10 of the usual ones."""
    t, tp = np.arange(10_000) / 5e3, np.arange(2 * int(rate)) / rate
    wave = brightness(0.3 + SPEED * t, equal_wheel(8))
    found = estimated(
        {"diode": (wave, "V", 5e3), "inlet": (pressure_of(0.3 + SPEED * tp), "bar", rate)},
        sensor__wave="diode",
        pressure__channel="inlet",
        pressure__fuse=True,
    ).summary
    assert found["sample_rate_Hz"] == pytest.approx(5e3) and found["output_rate_Hz"] == 1e3
    assert found["gaps"] == 0 and found["missed_edges"] == 0
    assert found["edges"] == pytest.approx(2.0 * 24.7 * 8, abs=2)


def test_a_time_range_holds_for_the_pressure(estimated):
    """0 bar before 1 s and after 2 s, 100 bar between: of the range 1.2 s to 1.8 s the mean is 100 bar gauge."""
    t = np.arange(0.0, 3.0, 2e-4)
    inlet = np.where((t > 1.0) & (t < 2.0), 100.0, 0.0)
    found = estimated(
        {"time": (t, "s"), "diode": (brightness(0.3 + SPEED * t, equal_wheel(8)), "V"), "inlet": (inlet, "bar")},
        sensor__wave="diode",
        pressure__channel="inlet",
        log__from="1.2 s",
        log__until="1.8 s",
    ).summary
    for which in ("mean", "min", "max"):
        assert found[f"pressure_{which}_inlet_Pa"] == pytest.approx(100e5, rel=1e-12)


@pytest.mark.sampled(3)
@pytest.mark.parametrize("portion", [1_000_000, 2_000, 501])
@pytest.mark.parametrize(("rate", "duration"), [(500.0, 2.0), (500.0, 8.0), (5e3, 4.0)])
def test_every_row_has_the_pressure_that_the_log_has_there(estimated, monkeypatch, portion, rate, duration):
    """A wave of 4 s and a pressure that begins 50 ms later and ends sooner or later: the parts of a portion lie apart
    in time. The pressure rises by 1 bar a second, so between its samples a row has 1 bar + 1 bar/s t as well."""
    monkeypatch.setattr(passes, "SAMPLES_AT_ONCE", portion)
    t, tp = np.arange(20_000) / 5e3, 0.05 + np.arange(int(rate * duration)) / rate
    kept = estimated(
        {
            "a/time": (t, "s"),
            "a/diode": (brightness(0.3 + SPEED * t, equal_wheel(8)), "V"),
            "b/time": (tp, "s"),
            "b/inlet": (1.0 + tp, "bar"),
        },
        sensor__wave="a/diode",
        pressure__channel="b/inlet",
    )
    rows, found = kept.column("time"), kept.column("inlet_pressure")
    assert found.size == rows.size
    inside = (rows > tp[0] + 1e-9) & (rows < tp[-1] - 1e-9)
    assert np.allclose(found[inside], (1.0 + rows[inside]) * 1e5 + 101325.0, rtol=1e-9)
    assert np.isnan(found[(rows < tp[0] - 1e-9) | (rows > tp[-1] + 1e-9)]).all()
    # each sample is folded once: all those between the first and the last row
    covered = tp[(tp >= rows[0]) & (tp <= rows[-1])]
    assert kept.summary["pressure_max_inlet_Pa"] == pytest.approx((1.0 + covered[-1]) * 1e5, rel=1e-9)
    low = kept.summary["pressure_min_inlet_Pa"]
    mean = np.mean(tp[tp <= rows[-1] + 1e-9])
    assert low == pytest.approx((1.0 + tp[0]) * 1e5, rel=1e-9)
    assert kept.summary["pressure_mean_inlet_Pa"] == pytest.approx((1.0 + mean) * 1e5, rel=1e-9)


@pytest.mark.parametrize("duration", [2, 8])
def test_rows_without_a_pressure_are_not_held_for_ever(estimated, monkeypatch, duration):
    """With room for 500 rows or samples and a pressure that lags or leads, some of it is lost, but each row is written,
    and once. By the end it is 2 s behind or 4 s ahead, 2000 rows or samples."""
    monkeypatch.setattr(passes, "SAMPLES_AT_ONCE", 1_000)
    monkeypatch.setattr(pressure_chain, "LONGEST", 500)
    held = []
    meet = PressureChain.meet

    def watched(chain, **given):
        meet(chain, **given)
        held.extend((chain.row_times.size, chain.waiting.values.size))

    monkeypatch.setattr(PressureChain, "meet", watched)
    t, tp = np.arange(20_000) / 5e3, np.arange(500 * duration) / 500.0
    channels = {"diode": (brightness(0.3 + SPEED * t, equal_wheel(8)), "V", 5e3), "inlet": (1.0 + tp, "bar", 500.0)}
    kept = estimated(channels, sensor__wave="diode", pressure__channel="inlet")
    rows, found = kept.column("time"), kept.column("inlet_pressure")
    assert max(held) == 500 and found.size == rows.size and np.isnan(found[rows > duration]).all()
    known = np.isfinite(found)
    assert known.sum() > 250 and np.allclose(found[known], (1.0 + rows[known]) * 1e5 + 101325.0, rtol=1e-9)


@pytest.mark.parametrize(("written", "given", "pascals"), [("", "bar", 3.5e5), ("bar", "bara", 3.5e5 - 101325.0)])
def test_the_unit_of_the_pressure_may_be_given(estimated, written, given, pascals):
    t = np.arange(0.0, 1.0, 2e-4)
    wave = brightness(0.3 + SPEED * t, equal_wheel(8))
    channels = {"time": (t, "s"), "diode": (wave, "V"), "inlet": (np.full(t.size, 3.5), written)}
    keys = {"sensor__wave": "diode", "pressure__channel": "inlet"}
    found = estimated(channels, **keys, pressure__unit=given).summary
    assert found["pressure_mean_inlet_Pa"] == pytest.approx(pascals, rel=1e-11)
    with pytest.raises(ConfigError, match="not in 'psi'" if written else "name it in .pressure. unit"):
        estimated(channels, **keys, **({"pressure__unit": "psi"} if written else {}))


def test_rows_are_written_by_whole_chunks(tmp_path):
    """What comes in portions of any size is what was given, whether a chunk is full or not."""
    values = np.random.default_rng(1).normal(size=3 * ROWS_IN_CHUNK + 17)
    with Store(tmp_path / "a.h5") as store:
        store.columns("edges", {"x": ("1", "x")})
        for part in np.split(values, [0, 10, ROWS_IN_CHUNK - 10, ROWS_IN_CHUNK, 3 * ROWS_IN_CHUNK + 1]):
            store.append("edges", {"x": part})
            assert store.file["edges/x"].shape[0] % ROWS_IN_CHUNK == 0
    with h5py.File(tmp_path / "a.h5") as file:
        assert np.array_equal(file["edges/x"][:], values)


@pytest.mark.parametrize("portion", [1_000_000, 2_000])
def test_the_pressure_carries_the_angle_where_the_encoder_is_late(estimated, monkeypatch, portion):
    monkeypatch.setattr(passes, "SAMPLES_AT_ONCE", portion)
    t = np.arange(0.0, 6.0, 2e-4)
    speed = SPEED * (1.0 + 0.02 * np.sin(TURN * 0.5 * t))
    true = 0.3 + np.cumsum(speed) * 2e-4
    v = brightness(true, INDEXED)
    v[(t > 3.0) & (t < 4.5)] = 0.0
    channels = {"time": (t, "s"), "diode": (v, "V"), "inlet": (pressure_of(true), "bar")}
    keys = {"sensor__wave": "diode", "sensor__index_shift": 0.25, "pressure__channel": "inlet",
            "pressure__duty_excess": 0.08, "pressure__lag": "0.1 ms",
            "filter__acceleration_density": "25 rad^2/s^3", "threshold__level": 0.5}  # fmt: skip
    alone = estimated(channels, **keys)
    assert alone.summary["pieces"] == 2
    fused = estimated(channels, **keys, pressure__fuse=True)
    assert fused.summary["pieces"] == 1
    rows = fused.column("time")
    silent = (rows > 3.1) & (rows < 4.4)
    error = np.mod(fused.column("angle") - np.interp(rows, t, true) + np.pi, TURN) - np.pi
    assert np.max(np.abs(error[silent])) < 0.15
    # Alone, a sensor that falls silent looks like a spool that stands, but none can stop from 155 rad/s in a sector.
    t_alone = alone.column("time")
    late = (t_alone > 3.9) & (t_alone < 4.4)
    assert np.all(alone.column("standstill")[late] < 0.01)
    off = alone.column("speed")[late] - np.interp(t_alone[late], t, speed)
    assert np.max(np.abs(off) / alone.column("speed_deviation")[late]) < 4.0
    assert alone.summary["lost_sensor_s"] == pytest.approx(1.5, abs=0.01)
    assert np.nanmean(fused.column("pressure_duty_ratio")[silent]) == pytest.approx(0.4 - 0.08, abs=0.03)
    assert np.all(fused.column("pressure_lag")[silent] == 1e-4)  # taken as known


# What cannot be estimated, and what is kept


@pytest.mark.parametrize(
    ("channels", "keys", "piece"),
    [
        ({"edge": (np.empty(0), "s")}, {"sensor__edges": "edge"}, wording.estimate.no_samples),
        (
            {"edge": (np.array([0.1, 0.2]), "s")},
            {"sensor__edges": "edge"},
            wording.estimate.edges_found.format(count=2),
        ),
        (
            {"edge": (passing_times(90)[::-1], "s")},
            {"sensor__edges": "edge"},
            wording.estimate.backwards_times.format(count=89),
        ),
        ({"edge": (1e6 * passing_times(90), "s")}, {"sensor__edges": "edge"}, wording.estimate.look_at_unit),
        ({"edge": (passing_times(9), "s")}, {"sensor__edges": "edge", "log__from": "9 s"}, wording.estimate.time_range),
        (
            {"edge": (passing_times(9), "V")},
            {"sensor__edges": "edge"},
            wording.estimate.edge_unit.format(channel="edge", unit="V"),
        ),
        ({"edge": (passing_times(9), "s")}, {"sensor__edges": "egde"}, wording.files.did_you_mean.format(name="edge")),
        (
            {"time": (np.arange(900.0), "s"), "w": (np.ones(900), "V")},
            {"sensor__wave": "w"},
            wording.estimate.no_threshold,
        ),
        (
            {"edge": (passing_times(9), "s")},
            {"sensor__edges": "edge", "pressure__channel": "edge"},
            wording.estimate.needs_clock,
        ),
        (
            {"edge": (passing_times(9), "s")},
            {"sensor__edges": "edge", "log__time": "edge"},
            wording.estimate.clock_themselves,
        ),
        (
            {"time": (np.arange(9.0), "s"), "w": (np.ones(9), "V"), "p": (np.ones(9), "kg")},
            {"sensor__wave": "w", "pressure__channel": "p"},
            "is in 'kg': .* is not a pressure level",
        ),
    ],
)
def test_what_cannot_be_estimated_is_refused(estimated, channels, keys, piece):
    with pytest.raises(ConfigError, match=piece):
        estimated(channels, **keys)


def test_an_interruption_keeps_what_was_reached(estimated, monkeypatch):
    monkeypatch.setattr(passes, "SAMPLES_AT_ONCE", 2000)

    def stop(done):
        if done > 0.4:
            raise KeyboardInterrupt

    t = np.arange(0.0, 10.0, 1e-3)
    channels = {"time": (t, "s"), "n": (np.floor(SPEED * t / PITCH), "")}
    kept = estimated(channels, progress=stop, sensor__counts="n")
    assert kept.summary["finished"] is False and "Interrupted" in titles(kept)
    assert 3.0 < kept.column("time")[-1] < 8.0


def test_ctrl_c_is_heeded_in_the_midst_of_a_portion(estimated, monkeypatch):
    # 2000 edges 50 s apart: one portion, 100 million rows.
    write, count = passes.FilteringPass.write, []

    def pressed(run, filtered):
        write(run, filtered)
        count.append(filtered.rows["time"].size)
        if sum(count) > 100_000:
            signal.raise_signal(signal.SIGINT)

    monkeypatch.setattr(passes.FilteringPass, "write", pressed)
    kept = estimated(stamped(50.0 * np.arange(2000)), sensor__edges="edge")
    assert kept.summary["finished"] is False and "Interrupted" in titles(kept)
    assert 100_000 < kept.size("time") < 500_000
    assert kept.summary["duration_s"] == pytest.approx(kept.column("time")[-1], abs=51.0)


@pytest.mark.thorough
@pytest.mark.parametrize("by", ["progress", "Ctrl-C"])
def test_an_interruption_of_the_second_pass_keeps_all_but_what_it_had_to_come(estimated, monkeypatch, by):
    """20 s in pieces of 200 edges, 1.01 s each; after some of them it is stopped."""
    monkeypatch.setattr(second_pass, "SMOOTHED_EDGES", 200)
    shares = []
    smoothed = SecondPass._write

    def stop(done):
        shares.append(done)
        if by == "progress" and done > 0.7:
            raise KeyboardInterrupt

    def pressed(run, *given):
        smoothed(run, *given)
        if by == "Ctrl-C" and shares[-1] > 0.6:
            signal.raise_signal(signal.SIGINT)

    monkeypatch.setattr(SecondPass, "_write", pressed)
    kept = estimated(stamped(passing_times(4000)), progress=stop, sensor__edges="edge", output__smooth=True)
    assert kept.summary["finished"] is False and kept.summary["edges"] == 4000
    assert shares == sorted(shares) and 0.5 in shares and 0.6 < shares[-1] < 0.9
    (finding,) = [f for f in kept.findings if f.title == "Interrupted"]
    assert (
        wording.estimate.smoothed_nan.format(piece=1) in finding.text and wording.estimate.second_pass in finding.text
    )
    until = float(finding.text.partition("from ")[2].split()[0])
    t, speed, angle = (kept.column(name) for name in ("time", "smoothed_speed", "smoothed_angle"))
    assert 4.0 < until < 18.0
    assert np.isfinite(speed[t < until - 1e-6]).all() and np.isnan(speed[t > until - 1e-6]).all()
    assert np.allclose(angle[t < until - 1e-6], SPEED * (t[t < until - 1e-6] - 0.25), atol=1e-6)


def test_ctrl_c_after_the_passes_changes_nothing(estimated, monkeypatch):
    summary = estimating.summary

    def pressed(*given):
        signal.raise_signal(signal.SIGINT)
        return summary(*given)

    monkeypatch.setattr(estimating, "summary", pressed)
    try:
        kept = estimated(stamped(passing_times(300)), sensor__edges="edge")
    except KeyboardInterrupt:
        pytest.fail("nothing was kept")
    assert kept.summary["finished"] is True and kept.summary["edges"] == 300 and not titles(kept)


def test_the_means_follow_from_the_rows_that_count(estimated):
    """From the 17th edge of 300 on, two turns of 8 sectors; the record of 2 s has one piece."""
    times = passing_times(300)
    kept = estimated(stamped(times), sensor__edges="edge")
    counts, speed = kept.column("settled") > 0.0, kept.column("speed")
    assert np.array_equal(counts, kept.column("time") >= times[16])
    assert kept.summary["spool_speed_mean_rad_s"] == pytest.approx(np.mean(speed[counts]), rel=1e-12)
    assert kept.summary["spool_speed_max_rad_s"] == np.max(speed[counts])
    mean = np.mean(kept.column("edges/normalised_innovation")[kept.column("edges/settled") > 0.0] ** 2)
    assert kept.summary["nis_mean"] == pytest.approx(mean, rel=1e-12)


def test_the_share_of_pulses_by_hand():
    """Of a period of 120 degrees: 30 degrees are a quarter; a falling edge without a rising one is none, nor is a pulse
    of more than a period. The last edge rises at 300 degrees."""
    degrees = np.array([10.0, 30.0, 60.0, 100.0, 130.0, 270.0, 300.0])
    rising = np.array([False, True, False, False, True, False, True])
    shares, last = pressure_chain.pulse_shares(np.radians(degrees), rising, np.nan, 3)
    assert shares == pytest.approx([0.25]) and last == pytest.approx(np.radians(300.0))


def test_all_that_is_kept_has_units_and_names(estimated, tmp_path):
    kept = estimated(stamped(passing_times(300)), sensor__edges="edge")
    with h5py.File(kept.directory / "result.h5") as file:

        def check(name, item):
            if isinstance(item, h5py.Dataset):
                assert item.attrs["units"] and item.attrs["long_name"], name

        file.visititems(check)
    assert len(read_meta(kept.directory)["log_sha256"]) == 64
    json.dumps(kept.summary, allow_nan=False)
    again = load_estimation(kept.directory / "estimate.toml")
    assert again.source.channel == "edge"


def test_a_damaged_result_is_refused(estimated):
    kept = estimated(stamped(passing_times(300)), sensor__edges="edge")
    (kept.directory / "result.json").write_text("[")
    list_all(kept.directory)
    with pytest.raises(ConfigError, match=wording.files.is_damaged):
        read_result(kept.directory)
    (kept.directory / "result.json").unlink()
    list_all(kept.directory)
    with pytest.raises(ConfigError, match=r"result\.json missing"):
        read_result(kept.directory)


# The steps


def test_bridged_time_is_where_three_deviations_reach_half_a_sector():
    settings = event_filter(equal_wheel(8))
    T = PITCH / SPEED
    h = bridged_time(T, settings)
    # The steady state by brute force: predict and correct until nothing changes.
    P = AngleSpeed(0.0, 0.0, 1.0, 0.0, 1.0)
    for _ in range(20_000):
        M = predict(P, T, settings.acceleration_density)
        S = M.angle_variance + settings.edge_variance
        k1, k2 = M.angle_variance / S, M.covariance / S
        P = AngleSpeed(0.0, 0.0, (1 - k1) * M.angle_variance, (1 - k1) * M.covariance,
                       M.speed_variance - k2 * M.covariance)  # fmt: skip
    reached = 3.0 * np.sqrt(predict(P, h, settings.acceleration_density).angle_variance)
    assert reached == pytest.approx(0.5 * PITCH, rel=0.02)  # the closed form is that of continuous measurements


def test_edges_of_the_pressure_end_with_their_clock():
    """Heard after the last row of one clock, at 3 s, they say nothing of 3 s on the next."""
    settings = event_filter(equal_wheel(8))
    one, two = (Edges(t, 0.0 * t, 0.0 * t, 0.0 * t + 1.0) for t in (passing_times(200), passing_times(1200)))
    told = []
    for heard in (np.empty(0), np.array([3.0, 3.006, 3.0135])):
        tracker = OfflineFilter(settings, Tally(8, rate=1000.0), 3, fusion(settings))
        tracker.add_pressure_edges(Waves(heard + 1e-3, heard, 0.0 * heard + 1e-4, np.resize([1.0, -1.0], heard.size)))
        for edges in (one, two):
            told.append([tracked.rows["pressure_phase"] for tracked in tracker.push(edges, edges.times[-1], last=True)])
    assert np.array_equal(np.concatenate(told[1]), np.concatenate(told[3]), equal_nan=True)


def test_plain_python_and_replay_agree():
    settings = event_filter(INDEXED)
    rng = np.random.default_rng(8)
    times = np.cumsum(rng.uniform(4e-3, 6e-3, 200))
    rows = np.column_stack([times, rng.integers(0, 3, 200), times - 5e-4, np.full(200, 1e-3), rng.integers(-1, 2, 200)])
    cases = [
        (tracked_step, event_filter_start(settings, 0.0, 0.0, 150.0), Reading(*[0.0] * 5), settings, rows),
        (
            fused_step,
            fusion_start(fusion(settings), 0.0, 0.0, 150.0),
            FusionReading(Reading(*[0.0] * 5), *[0.0] * 5),
            fusion(settings),
            np.column_stack([rows, rng.integers(0, 2, 200), times - 1e-3, np.full(200, 1e-4),
                             rng.choice([-1.0, 1.0], 200), np.full(200, np.nan)]),
        ),
    ]  # fmt: skip
    for step, memory, example, given, numbers in cases:
        compiled = Replay(step, memory, example, given)(memory, numbers).shown
        for row, shown in zip(numbers.tolist(), compiled, strict=True):
            reading = Reading(*row) if step is tracked_step else FusionReading(Reading(*row[:5]), *row[5:])
            memory, plain = step(memory, reading, given)
            assert np.allclose(flat(plain), shown, rtol=1e-9, atol=1e-9, equal_nan=True)


def test_a_pressure_that_is_cut_off_and_has_holes_is_told(estimated):
    """A sensor that ends at 60 bar, and two samples that were lost."""
    t = np.delete(np.arange(0.0, 3.0, 2e-4), [7000, 7001])
    angle = 0.3 + SPEED * t
    pressure = np.fmin(pressure_of(angle) + 0.5 * np.sin(7.0 * t), 60.0)
    channels = {"time": (t, "s"), "diode": (brightness(angle, equal_wheel(8)), "V"), "inlet": (pressure, "bar")}
    kept = estimated(channels, sensor__wave="diode", pressure__channel="inlet")
    (told,) = [each for each in kept.findings if each.title == wording.estimate.record_of_pressure]
    assert wording.estimate.gap.format(begin="1.3998 s", end="1.4004 s", row=7000, samples=2) in told.text
    assert wording.estimate.saturated in told.text
    whole = np.arange(0.0, 3.0, 2e-4)
    sound = pressure_of(0.3 + SPEED * whole) + 0.5 * np.sin(7.0 * whole)
    diode = brightness(0.3 + SPEED * whole, equal_wheel(8))
    channels = {"time": (whole, "s"), "diode": (diode, "V"), "inlet": (sound, "bar")}
    assert wording.estimate.record_of_pressure not in titles(
        estimated(channels, sensor__wave="diode", pressure__channel="inlet")
    )


def crankshaft(teeth=36, turns=40, ripple=0.0):
    """Times of both edges of each tooth of a wheel that lacks one, at 15 turns a second."""
    pitch = TURN / teeth
    begins = np.arange(teeth - 1) * pitch
    wheel = np.sort(np.concatenate([begins, begins + 0.5 * pitch]))
    angles = (wheel + TURN * np.arange(turns)[:, None]).ravel()
    return (angles + 0.5 * ripple * np.sin(2.0 * angles)) / (15.0 * TURN)


@pytest.mark.sampled(4)
@pytest.mark.parametrize(("teeth", "first"), [(36, 0), (36, 33), (60, 7), (24, 47)])
def test_a_wheel_that_lacks_a_tooth_is_known_by_its_gap(estimated, teeth, first):
    """The gap is no missed edge but the index, wherever the record begins, and the angle is that of the wheel."""
    times = crankshaft(teeth)[first:] + np.random.default_rng(1).normal(0.0, 1e-6, crankshaft(teeth).size - first)
    widths = [1.0] * (2 * teeth - 3) + [3.0]
    kept = estimated(stamped(times), sensor__edges="edge", sensor__widths=widths, filter__edge_variance="1e-5 rad^2")
    found = kept.summary
    assert (
        found["index_found"] is True
        and found["missed_edges"] == 0
        and not titles(kept) & {wording.estimate.index_not_found}
    )
    assert found["spool_speed_mean_rad_s"] == pytest.approx(15.0 * TURN, rel=1e-4)
    rows, angle = kept.column("time"), kept.column("angle")
    late = rows > times[4 * teeth]
    off = (angle - 15.0 * TURN * rows)[late]
    assert np.max(np.abs(np.mod(off + np.pi, TURN) - np.pi)) < 2e-3
