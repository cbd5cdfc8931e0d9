"""A silence between two edges: did the spool stand, or was the sensor lost?"""

import numpy as np
import pytest
from tests.words import wording

from vvdp.offline.beginning import PACE
from vvdp.offline.lost_sensor import PRIOR, SPOOL_TIME, Silence, lost_probability, settled_rows

TURN = 2.0 * np.pi
PITCH = TURN / 8.0


def steady(speed, count=8):
    return np.full(count, speed)


def test_the_probability_by_hand():
    """From 200 rad/s within pi/4 takes 4e4/(pi/2) = 25465 rad/s^2, 3.565 times the 200/0.028 that a spool can do: twice
    3.565^2/2 - 1 = 11.7. From 100 rad/s 6366, 1.150 times 155/0.028: 1.150^2 - 1 = 0.322, so 0.580. With 6366 possible
    it is twice 1/2 - 1 = 0: one half."""
    for speed, pace, about in ((200.0, 200.0, 0.99999), (100.0, PACE, 0.580)):
        found = lost_probability(steady(speed), steady(speed), PITCH)
        odds = (speed**2 / (2.0 * PITCH) * SPOOL_TIME / pace) ** 2 - 1.0
        assert found == pytest.approx(1.0 / (1.0 + np.exp(-odds)), rel=1e-12)
        assert found == pytest.approx(about, abs=1e-3)
    assert lost_probability(steady(100.0), steady(100.0), PITCH, hardest=6366.2) == pytest.approx(0.5, abs=1e-4)
    assert lost_probability(steady(1.0), steady(1.0), PITCH) == pytest.approx(1.0 / (1.0 + np.exp(-PRIOR)), abs=1e-4)


def test_a_spool_that_changes_its_speed_towards_the_silence_stops():
    """Braked evenly the speed at edges goes with the root of their distance."""
    stops = 300.0 * np.sqrt(np.arange(8) + 0.5)
    for pair in ((stops, steady(800.0)), (steady(800.0), stops), (-stops, -steady(800.0))):
        assert lost_probability(*pair, PITCH) == 0.0


def test_it_is_likelier_the_faster_the_spool_and_the_finer_the_wheel():
    speeds = [lost_probability(steady(v), steady(v), PITCH) for v in np.linspace(10.0, 300.0, 30)]
    wheels = [lost_probability(steady(60.0), steady(60.0), TURN / n) for n in range(4, 61, 4)]
    assert np.all(np.diff(speeds) >= 0.0) and np.all(np.diff(wheels) >= 0.0)
    assert speeds[-1] == pytest.approx(1.0, abs=1e-6) and wheels[-1] == pytest.approx(1.0, abs=1e-3)


def silence_of(begin, end, before, after, lost, angle=0.0, error=0.0):
    return Silence(
        begin=begin,
        end=end,
        angle=angle,
        before=before,
        after=after,
        error=error,
        piece=1.0,
        lost=lost,
        turns=0.0,
        until=np.inf,
    )


def rows_of(count):
    names = ("angle", "angle_in_turn", "speed", "angle_deviation", "speed_deviation", "pwm_frequency", "standstill")
    return {name: np.zeros(count) for name in names}


def test_the_rows_of_a_lost_sensor_are_those_of_a_spool_that_turns_on():
    """From 90 to 110 rad/s within 2 s: 200 rad; of both ends the deviation is what the edges tell, and the rest."""
    silence = silence_of(1.0, 3.0, 90.0, 110.0, 0.99, angle=50.0, error=0.5)
    assert silence.travel == 200.0
    time = np.array([1.0, 2.0, 3.0])
    found = settled_rows(time, rows_of(3), silence, 3)
    assert found["angle"] == pytest.approx([50.0, 50.0 + 95.0, 250.0], rel=1e-12)
    assert found["speed"] == pytest.approx([90.0, 100.0, 110.0], rel=1e-12)
    # 3 % of 100 in the middle, none at the ends
    wander = np.array([0.0, 3.0, 0.0])
    assert found["speed_deviation"] ** 2 == pytest.approx(wander**2 + 0.25 + 0.01 * found["speed"] ** 2, rel=1e-12)
    assert found["standstill"] == pytest.approx(0.01, rel=1e-12)
    assert found["pwm_frequency"][1] == pytest.approx(300.0 / TURN, rel=1e-12)


def test_a_spool_that_probably_stands_keeps_its_rows_and_some_doubt():
    """With probability 1/4 it turns on at 20 rad/s: half of that is the deviation."""
    silence = silence_of(0.0, 2.0, 20.0, 20.0, 0.25)
    found = settled_rows(np.array([1e-9]), rows_of(1), silence, 3)
    assert found.keys() == {"speed_deviation", "angle_deviation"}
    assert found["speed_deviation"] == pytest.approx(10.0, rel=1e-6)


def test_rows_without_an_estimate_stay_so():
    rows = rows_of(2) | {"angle": np.array([0.0, np.nan])}
    found = settled_rows(np.array([1.0, 2.0]), rows, silence_of(0.0, 4.0, 9.0, 9.0, 0.9), 3)
    assert np.isfinite(found["speed"][0]) and np.isnan(found["speed"][1])


SPEED = 155.0


def silent_log(lasts, turns=100, backward=False):
    """Edges at a constant speed on a wheel with an index, and none from 2 s on for a time [s]."""
    places = np.arange(8) * PITCH
    places[1] += 0.25 * PITCH
    angles = (TURN * np.arange(turns)[:, None] + places).ravel()
    times = 0.1 + (angles if not backward else angles[-1] - angles[::-1]) / SPEED
    kept = (times < 2.0) | (times > 2.0 + lasts)
    return {"edge": (times[kept], "s")}, angles


@pytest.mark.sampled(3)
@pytest.mark.parametrize("lasts", [0.6, 0.25])
@pytest.mark.parametrize("fit", [None, True])
def test_a_lost_sensor_is_no_standstill(estimated, lasts, fit):
    """The rows go on at the speed, the angle keeps its turns, and no time counts as a standstill."""
    log, angles = silent_log(lasts)
    kept = estimated(log, sensor__edges="edge", sensor__index_shift=0.25, filter__fit=fit, output__smooth=True)
    assert kept.summary["standstill_time_s"] == 0.0
    t = kept.column("time")
    settled = t > 0.5
    assert np.allclose(kept.column("speed")[settled], SPEED, rtol=0.01)
    off = kept.column("angle")[settled] - SPEED * (t[settled] - 0.1)
    assert np.ptp(off) < 0.2
    edge = kept.column("edges/angle")
    assert edge[-1] - edge[0] == pytest.approx(angles[-1] - angles[0], abs=1e-9)
    number = kept.column("edges/number")
    assert number[-1] - number[0] == angles.size - 1.0
    if lasts > 0.5:
        assert kept.summary["lost_sensor_s"] == pytest.approx(lasts, abs=2.0 * PITCH / SPEED)
        assert wording.estimate.lost_sensor in {finding.title for finding in kept.findings}


def test_a_stop_that_the_drive_can_make_is_a_standstill_again(estimated):
    log, _ = silent_log(0.6)
    kept = estimated(log, sensor__edges="edge", sensor__index_shift=0.25, valve__largest_deceleration="100000 rad/s^2")
    assert kept.summary["lost_sensor_s"] == 0.0
    assert kept.summary["standstill_time_s"] == pytest.approx(0.55, abs=0.06)
    stands = kept.column("standstill") > 0.5
    assert np.all(kept.column("speed_deviation")[stands] > 0.3 * SPEED)  # a share of 0.27 that it was lost
    assert 'largest_deceleration = "100000 rad/s^2"' in kept.config


def test_backwards_the_angle_falls_through_the_silence(estimated):
    log, angles = silent_log(0.6, backward=True)
    kept = estimated(log, sensor__edges="edge", sensor__index_shift=0.25)
    assert kept.summary["lost_sensor_s"] == pytest.approx(0.6, abs=2.0 * PITCH / SPEED)
    edge = kept.column("edges/angle")
    assert edge[-1] - edge[0] == pytest.approx(angles[0] - angles[-1], abs=1e-9)
    t = kept.column("time")
    assert np.allclose(kept.column("speed")[t > 0.5], -SPEED, rtol=0.01)
