"""Logs whose wheel is not quite the one that was described: the best reading is taken, and said first."""

from pathlib import Path

import numpy as np
import pytest
from tests.offline.records import TURN, Motion, crossings, even_edges, titles, wave_of
from tests.words import wording

from vvdp.offline.alignment import CLEARLY, RATHER, sectors_passed
from vvdp.offline.edges import Edges
from vvdp.offline.facts import ALIAS_SAMPLES
from vvdp.offline.hypotheses import LOOKED_AT, TURNS, Sectors, hypotheses, judge
from vvdp.offline.passages import AROUND, WINDOWS, slow_passages
from vvdp.offline.pattern_fit import CLEAR
from vvdp.results.result import Grade
from vvdp.sensing.wheel import equal_wheel

pytestmark = pytest.mark.thorough

SPEED = 155.0
LOGGED_SHIFT = {"sensor__edges": "edge", "sensor__index_shift": 0.25}


def steady(speed=SPEED, until=4.0):
    return Motion(lambda t: speed, until)


def edge_log(motion, edges, only=0):
    """The channel of edge times, of all or of one kind only."""
    times, signs = crossings(motion, edges)
    return {"edge": (times[signs == only] if only else times, "s")}


def wave_log(motion, edges, rate=5e3, inverted=False, ramp=0.3):
    t = np.arange(0.0, motion.times[-1], 1.0 / rate)
    wave = wave_of(motion.angle_at(t), edges, ramp)
    noise = np.random.default_rng(1).normal(0.0, 0.01, t.size)
    return {"time": (t, "s"), "diode": (5.0 * (1.0 - wave if inverted else wave) + noise, "V")}


def first_warning(kept):
    return next(each for each in kept.findings if each.grade is not Grade.PLAIN)


def speed_of(kept):
    return kept.summary["spool_speed_mean_rad_s"]


# How many edges pass in a turn


@pytest.mark.parametrize(
    ("sectors", "moved", "only", "title", "taken"),
    [
        (8, 2, 1, wording.estimate.one_kind, 4),
        (4, 1, 0, wording.estimate.another_number, 4),
        (16, 1, 0, wording.estimate.another_number, 16),
    ],
)
def test_another_number_of_edges_in_a_turn_is_taken_and_said_first(estimated, sectors, moved, only, title, taken):
    kept = estimated(edge_log(steady(), even_edges(sectors, moved, 0.25), only), **LOGGED_SHIFT)
    assert speed_of(kept) == pytest.approx(SPEED, rel=1e-3)
    assert kept.summary["sectors"] == taken and kept.summary["index_found"] is True
    assert (
        first_warning(kept).title == title
        and wording.estimate.edges_in_a_turn.format(edges=taken, expected=8) in first_warning(kept).text
    )
    again = estimated(edge_log(steady(), even_edges(sectors, moved, 0.25), only), **of_config(kept))
    assert speed_of(again) == pytest.approx(SPEED, rel=1e-3) and title not in titles(again)


def of_config(kept):
    """Keys of the wheel in the config that was written."""
    lines = [line.partition("#")[0].partition(" = ") for line in kept.config.splitlines()]
    keys = {key: float(value) for key, _, value in lines if key in ("sectors", "index_shift")}
    widths = {key: [float(w) for w in value.strip(" []").split(",")] for key, _, value in lines if key == "widths"}
    keys |= {"sectors": int(keys["sectors"])} if "sectors" in keys else {}
    return {"sensor__edges": "edge", **{f"sensor__{key}": value for key, value in (keys | widths).items()}}


def test_an_odd_number_of_edges_in_a_turn_is_said(estimated):
    # 6 sectors, rising edges alone: 3 in a turn. No wheel has that many, so the filter sees half the speed.
    kept = estimated(edge_log(steady(), even_edges(6, 2, 0.25), 1), sensor__sectors=6, **LOGGED_SHIFT)
    found = first_warning(kept)
    assert found.title == wording.estimate.one_kind and wording.estimate.speed_is_times.format(factor=2) in found.text
    assert kept.summary["index_found"] is False


@pytest.mark.parametrize("sectors", [8, 16])
def test_a_wheel_without_the_index_that_was_told_says_that_nothing_confirms_the_speed(estimated, sectors):
    kept = estimated(edge_log(steady(), even_edges(sectors)), **LOGGED_SHIFT)
    assert kept.summary["index_found"] is False
    found = first_warning(kept)
    assert found.title == wording.estimate.index_not_found and wording.estimate.twice_or_half in found.text
    # the even wheel is taken, so no edge of it seems out of place
    assert wording.estimate.elsewhere not in titles(kept)
    assert kept.summary["spool_speed_std_rad_s"] < 0.1


def test_the_default_number_of_sectors_is_said_first_and_written(estimated):
    log = edge_log(steady(), even_edges(8), 1)
    kept = estimated(log, sensor__edges="edge", sensor__sectors=None)
    assert kept.summary["sectors_assumed"] is True and kept.summary["sectors"] == 8
    found = first_warning(kept)
    assert found.title == wording.estimate.assumed_title and wording.estimate.rising_alone.format(count=4) in found.text
    assert "# sectors = 8" in kept.config and "assumed" in kept.config
    given = estimated(log, sensor__edges="edge", sensor__sectors=8)
    assert given.summary["sectors_assumed"] is False and wording.estimate.assumed_title not in titles(given)
    assert wording.estimate.granted in given.result.findings[-1].text
    # an index that fits confirms them
    shown = estimated(edge_log(steady(), even_edges(8, 1, 0.25)), sensor__sectors=None, **LOGGED_SHIFT)
    assert shown.summary["sectors_assumed"] is True and not titles(shown)


# Polarity and direction


@pytest.mark.parametrize(
    ("moved", "shift", "speed", "inverted", "polarity", "direction"),
    [
        (1, 0.25, SPEED, False, 1, 1),
        (1, 0.25, SPEED, True, -1, 1),
        (2, 0.25, SPEED, False, -1, 1),  # the index on a rising edge
        (1, 0.25, -SPEED, False, 1, -1),
        (1, -0.25, SPEED, False, -1, -1),  # as an inverted wave and a wheel that turns backwards would be
        (2, -0.25, SPEED, False, 1, -1),
    ],
)
def test_the_index_tells_polarity_and_direction(estimated, moved, shift, speed, inverted, polarity, direction):
    motion = steady(speed)
    log = wave_log(motion, even_edges(8, moved, shift), inverted=inverted)
    kept = estimated(log, sensor__wave="diode", sensor__index_shift=0.25)
    found = kept.summary
    assert (found["index_found"], found["polarity"], found["direction"]) == (True, polarity, direction)
    assert found["spool_speed_mean_rad_s"] == pytest.approx(direction * SPEED, rel=1e-3)
    assert found["spool_speed_max_rad_s"] - found["spool_speed_min_rad_s"] < 1.0 and found["nis_mean"] < 0.05
    assert found["pwm_frequency_mean_Hz"] == pytest.approx(3.0 * SPEED / TURN, rel=1e-3)
    said = [title for title in titles(kept) if title in (wording.estimate.inverted, wording.estimate.turns_backwards)]
    assert len(said) == (polarity < 0) + (direction < 0)
    assert not said or first_warning(kept).title in said
    if inverted:
        assert "inverted = true" in kept.config


def test_a_spool_that_turns_backwards_has_its_true_angle(estimated):
    motion = steady(-SPEED)
    kept = estimated(
        wave_log(motion, even_edges(8, 1, 0.25)), sensor__wave="diode", sensor__index_shift=0.25, output__smooth=True
    )
    t = kept.column("time")
    late = (t > 0.5) & (t < 3.9)
    for angle, speed in (("angle", "speed"), ("smoothed_angle", "smoothed_speed")):
        error = np.mod(kept.column(angle) - motion.angle_at(t) + np.pi, TURN) - np.pi
        assert np.max(np.abs(error[late])) < 0.02
        assert np.max(np.abs(kept.column(speed)[late] + SPEED)) < 1.0
    edge, number = kept.column("edges/angle"), kept.column("edges/number")
    assert (np.diff(number) == -1.0).all() and (np.diff(edge) < 0.0).all()
    assert np.array_equal(kept.column("edges/polarity"), np.where(number % 2 == 0, 1.0, -1.0))


def test_columns_of_rising_and_falling_edges_are_exchanged(estimated):
    times, signs = crossings(steady(), even_edges(8, 2, 0.25))
    log = {"up": (times[signs > 0], "s"), "down": (times[signs < 0], "s")}
    kept = estimated(log, sensor__edges="up", sensor__falling="down", sensor__index_shift=0.25)
    assert kept.summary["polarity"] == -1 and kept.summary["index_found"] is True
    assert wording.estimate.exchange in first_warning(kept).remedy
    assert 'edges = "down"' in kept.config and 'falling = "up"' in kept.config


def test_what_an_even_wheel_does_not_tell_is_null(estimated):
    found = estimated(wave_log(steady(), even_edges(8)), sensor__wave="diode").summary
    assert (found["polarity"], found["direction"], found["index_found"]) == (None, None, None)
    found = estimated(edge_log(steady(), even_edges(8, 1, 0.25)), **LOGGED_SHIFT).summary
    assert (found["polarity"], found["direction"]) == (None, 1)  # no polarity was logged


def edges_of(motion, places, jitter, missed, rng, polarity_known):
    times, signs = crossings(motion, places)
    times = np.sort(times + rng.normal(0.0, jitter * TURN / len(places) / SPEED, times.size))
    seen = rng.random(times.size) >= missed
    known = signs if polarity_known else 0 * signs
    return Edges(*(column[seen].astype(float) for column in (times, 0 * times, known, np.ones(times.size))))


@pytest.mark.parametrize("sectors", [6, 8, 24])
@pytest.mark.parametrize(("jitter", "missed"), [(0.0, 0.0), (0.05, 0.0), (0.03, 0.3)])
def test_jitter_and_missed_edges_mislead_nobody(sectors, jitter, missed):
    """Of 4 draws each, with polarities or without: what is told is right, and where edges are sharp it is told."""
    wheel = equal_wheel(sectors, 0.25)
    for seed in range(4):
        rng = np.random.default_rng([seed, sectors])
        moved, direction = [(1, 1.0), (2, 1.0), (1, -1.0), (2, -1.0)][seed]
        motion = steady(direction * SPEED, 3.0)
        for known in (True, False):
            found = judge(edges_of(motion, even_edges(sectors, moved, 0.25), jitter, missed, rng, known), wheel)
            assert found.likeliest.sectors is Sectors.AS_TOLD
            assert np.isnan(found.direction) or found.direction == direction
            # seen backwards, an index on a rising edge lies on a falling one, as told
            assert np.isnan(found.polarity) or found.polarity == (1.0 if moved == 1 else -1.0)
            if jitter < 0.05 and not missed:
                assert found.direction == direction and np.isnan(found.polarity) != known


def test_a_ripple_of_the_turn_is_not_taken_for_an_index():
    wheel = equal_wheel(8, 0.25)
    for order in (1, 2, 3, 4, 7):
        motion = steady()
        motion.angles = motion.angles + 0.05 / order * np.sin(order * motion.angles)
        times, _ = crossings(motion, even_edges(8))
        nothing = np.zeros(times.size)
        found = judge(Edges(times, nothing, nothing, nothing + 1.0), wheel)
        assert found.index_shows is not True and found.likeliest.sectors is Sectors.AS_TOLD
        times, _ = crossings(motion, even_edges(8, 1, 0.25))
        nothing = np.zeros(times.size)
        found = judge(Edges(times, nothing, nothing, nothing + 1.0), wheel)
        assert found.index_shows is True and found.direction == 1.0


def test_what_is_tried():
    """As told, half, double in two directions, and of the polarities of a log in both; one kind only where there are
    none; and the even wheel."""
    wheel = equal_wheel(8, 0.25)
    assert len(list(hypotheses(wheel, polarity_known=True))) == 3 * 4 + 1
    # the falling edges alone have the index, the rising ones are even
    assert len(list(hypotheses(wheel, polarity_known=False))) == 4 * 2 + 1
    kinds = [each for each in hypotheses(equal_wheel(6, 0.25), polarity_known=False) if each.sectors is Sectors.HALF]
    assert not kinds  # no wheel has 3 sectors


# Samples that are too few


def test_an_alias_is_said_first(estimated):
    # 197.4 edges/s are a wave of 98.7 Hz, at 120 Hz seen as 21.3 Hz: 42.6 edges/s, 33.5 rad/s
    kept = estimated(wave_log(steady(until=8.0), even_edges(8), rate=120.0, ramp=0.02), sensor__wave="diode")
    assert speed_of(kept) == pytest.approx(120.0 * TURN / 4.0 - SPEED, rel=0.03)
    found = first_warning(kept)
    assert found.title == wording.estimate.alias
    named = [float(word.strip(",")) for word in found.text.split() if word[0].isdigit()]
    assert any(each == pytest.approx(SPEED * 60.0 / TURN, rel=0.01) for each in named)  # the true one, in rpm
    fine = estimated(wave_log(steady(), even_edges(8)), sensor__wave="diode")
    assert wording.estimate.alias not in titles(fine)


@pytest.mark.parametrize("rate", [150.0, 250.0, 400.0])
def test_two_samples_in_a_sector_are_called_too_few(estimated, rate):
    from vvdp.base.errors import ConfigError

    with pytest.raises(ConfigError, match=wording.estimate.too_few_samples):
        estimated(wave_log(steady(until=6.0), even_edges(8), rate=rate, ramp=0.49), sensor__wave="diode")


# Times in ticks


def test_edge_times_in_ticks_are_taken_for_what_they_are(estimated):
    # 25 turns a second in ticks of 1 ms: every edge at the same place in its tick
    times, _ = crossings(steady(25.0 * TURN, 6.0), even_edges(8))
    kept = estimated({"edge": (np.ceil(times * 1e3 - 1e-6) / 1e3, "s")}, sensor__edges="edge")
    assert kept.summary["commensurate"] is True and wording.estimate.in_step in titles(kept)
    assert wording.estimate.elsewhere not in titles(kept)
    variance = kept.column("edges/variance")[-1]
    assert variance == pytest.approx((25.0 * TURN * 1e-3) ** 2 / 12.0 + 3.47e-3, rel=1e-3)
    fine = estimated({"edge": (np.round(times, 7), "s")}, sensor__edges="edge")
    assert fine.summary["commensurate"] is False
    assert fine.column("edges/variance")[-1] == pytest.approx(3.47e-3, rel=1e-6)


@pytest.mark.parametrize(("tick", "seen"), [(1e-3, 1e-3), (5e-4, 5e-4), (2e-3, 2e-3), (1e-9, 0.0)])
def test_the_tick_is_the_common_measure_of_the_times(tick, seen):
    from vvdp.offline.beginning import clock_tick

    times, _ = crossings(steady(151.3, 2.0), even_edges(8))
    assert clock_tick(np.round(times / tick) * tick, 5e-3) == pytest.approx(seen, rel=1e-9)


# Standing still, and turning back


def reversing(index, until=5.0):
    motion = Motion(lambda t: np.clip(100.0 - 100.0 * (t - 1.3), -100.0, 100.0), until)
    return motion, even_edges(8, 1 if index else None, 0.25)


@pytest.mark.parametrize("with_polarity", [True, False])
def test_a_reversal_is_told_by_the_mirrored_index(estimated, with_polarity):
    motion, edges = reversing(index=True)
    if with_polarity:
        kept = estimated(wave_log(motion, edges), sensor__wave="diode", sensor__index_shift=0.25)
    else:
        kept = estimated(edge_log(motion, edges), **LOGGED_SHIFT)
    (found,) = [each for each in kept.findings if each.title == wording.estimate.reversed]
    assert (
        wording.estimate.at_about.format(time="2.3 s") in found.text
        and kept.summary["direction"] is None
        and kept.summary["pieces"] == 2
    )
    assert wording.estimate.pauses not in titles(kept)
    t = kept.column("time")
    settled = ((t > 0.5) & (t < 1.3)) | ((t > 3.6) & (t < 4.9))
    error = kept.column("angle") - motion.angle_at(t)
    whole = TURN * np.round(np.median(error[settled]) / TURN)
    assert np.max(np.abs(error[settled] - whole)) < 0.1  # the same turn before and after
    assert np.max(np.abs(kept.column("speed") - motion.speed_at(t))[settled]) < 2.0


def test_without_an_index_a_slow_passage_is_said(estimated):
    kept = estimated(edge_log(*reversing(index=False)), sensor__edges="edge")
    (found,) = [each for each in kept.findings if each.title == wording.estimate.turned_back]
    assert wording.estimate.at_about.format(time="2.3 s") in found.text and wording.estimate.cannot_tell in found.text
    steadily = Motion(lambda t: 100.0 - 12.0 * t, 5.0)  # slows down, and does not turn
    assert wording.estimate.turned_back not in titles(
        estimated(edge_log(steadily, even_edges(8)), sensor__edges="edge")
    )


@pytest.mark.parametrize("portion", [1_000_000, 700])
def test_a_reversal_does_not_depend_on_the_portions(estimated, monkeypatch, portion):
    from vvdp.offline import passes

    monkeypatch.setattr(passes, "SAMPLES_AT_ONCE", portion)
    motion, edges = reversing(index=True)
    kept = estimated(wave_log(motion, edges, 2e3), sensor__wave="diode", sensor__index_shift=0.25)
    assert wording.estimate.reversed in titles(kept) and kept.summary["edges"] == pytest.approx(509, abs=2)
    t = kept.column("time")
    assert np.allclose(np.diff(t), 1e-3) and t.size == pytest.approx(4990, abs=12)


def test_a_standstill_is_told_with_its_time(estimated):
    def speed(t):
        return SPEED * np.clip(np.where(t < 4.0, 1.0 - (t - 2.0) / 0.05, (t - 4.0) / 0.05), 0.0, 1.0)

    motion = Motion(speed, 6.0)
    kept = estimated(edge_log(motion, even_edges(8, 1, 0.25)), **LOGGED_SHIFT)
    (found,) = [each for each in kept.findings if each.title == "Standstill"]
    assert kept.summary["standstill_time_s"] == pytest.approx(1.96, abs=0.1)
    begin, end = (float(word) for word in found.text.split() if word[0].isdigit())
    assert begin == pytest.approx(2.06, abs=0.05) and end == pytest.approx(4.01, abs=0.03)
    # it goes on from where it stood, not from where it would have been
    t = kept.column("time")
    error = kept.column("angle") - motion.angle_at(t)
    assert abs(np.median(error[t > 5.0]) - np.median(error[(t > 1.0) & (t < 1.9)])) < 0.1
    assert estimated(edge_log(steady(), even_edges(8)), sensor__edges="edge").summary["standstill_time_s"] == 0.0


def test_the_root_mean_square_of_the_deviations(estimated):
    kept = estimated(edge_log(steady(), even_edges(8)), sensor__edges="edge")
    t = kept.column("time")
    # from the end of two turns on, 16 edges
    settled = t >= kept.column("edges/time")[16]
    expected = np.sqrt(np.mean(kept.column("speed_deviation")[settled] ** 2))
    assert kept.summary["speed_deviation_rms_rad_s"] == pytest.approx(expected, rel=1e-9)


# What they rest on


def test_sectors_are_counted_over_missed_edges():
    """Two fifths of the edges missing, without polarities and with: the time tells how many sectors passed."""
    times, signs = crossings(steady(until=3.0), even_edges(8, 1, 0.25))
    for seed in range(3):
        seen = np.flatnonzero(np.random.default_rng(seed).random(times.size) > 0.4)
        for known in (0.0, 1.0):
            edges = Edges(times[seen], 0.0 * seen, known * signs[seen], np.ones(seen.size))
            true = np.diff(seen)
            begin = int(np.argmax(true == 1))  # longer times before may be those of a wheel that starts
            assert np.array_equal(sectors_passed(edges, 1.0, 48)[begin:], true[begin:])


def test_a_wheel_that_starts_from_rest_has_not_missed_its_first_edges():
    # a constant acceleration: edge k at sqrt(2 k pitch/a), the first times 1, 0.41, 0.32, ... of each other
    times = np.sqrt(np.arange(1.0, 80.0))
    nothing = np.zeros(times.size)
    assert (sectors_passed(Edges(times, nothing, nothing, nothing + 1.0), 1.0) == 1.0).all()


def test_a_slow_passage_by_hand():
    steps = np.ones(60)
    assert slow_passages(steps) == []
    steps[30] = 7.5  # two of them 8.5, on average 4.25 times the others
    assert slow_passages(steps) == [30]
    assert slow_passages(np.concatenate([np.ones(30), np.full(30, 9.0)])) == []  # slow from there on is no passage
    missed = np.random.default_rng(0).geometric(0.55, 20_000).astype(float)  # 45 % of the edges
    assert len(slow_passages(missed)) <= 20  # once in a thousand edges at most


def test_the_guide_has_the_numbers_that_are_used():
    text = (Path(__file__).parents[2] / "docs" / "logs.md").read_text("utf-8")
    (five, long), (two, longer) = WINDOWS
    for words in (
        f"Of the first {TURNS} turns of the finest wheel, {LOOKED_AT} edges at most",
        f"where ln L is higher by {CLEAR:g},",
        f"are {long:g} or {longer:g} times as long\nas the {AROUND} before and the {AROUND} after them",
        f"a wave has fewer than {ALIAS_SAMPLES:g} samples for each sector",
    ):
        assert words in text, words
    assert (five, two) == (5, 2) and (CLEARLY, RATHER) == (0.5, 0.75)
