"""What a silence says: against particles, where it says nothing, in other units of time, by hand; a jam is seen."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import betabinom, norm

from vvdp.estimation import silence as module
from vvdp.estimation.association import BURSTY, UNWATCHED, missed_in_a_row
from vvdp.estimation.between_edges import inflate, silence_until
from vvdp.estimation.event_memory import event_filter_start
from vvdp.estimation.event_settings import event_filter
from vvdp.estimation.silence import (
    DROPOUTS,
    LATE,
    STARTED,
    STARTS,
    SURE,
    Silence,
    after_silence,
    is_late,
    start_speed,
    turned_back,
)
from vvdp.numerics.kalman import AngleSpeed, predict
from vvdp.sensing.wheel import equal_wheel

WIDTH = np.pi / 4.0
CRUISE = AngleSpeed(0.0, 155.0, 2.6e-4, 4e-4, 0.03)
"""The belief at an edge at angle 0 of a wheel of eight sectors, at 24.7 turns a second."""


def silence_of(duration, **changes):
    usual = {
        "duration": duration,
        "last_edge": 0.0,
        "next_edge": WIDTH,
        "edge_variance": 3.47e-3,
        "irregular": 0.01,
        "watched": 64.0,
        "stop_rate": 0.01,
        "start_variance": 1000.0,
    }
    return Silence(**{**usual, **changes})


def beliefs_after(duration, belief=CRUISE):
    """Cruise and manoeuvre after a time, with the published densities."""
    cruise = predict(belief, duration, 0.25)
    return cruise, inflate(cruise, duration, 2e4)


def heard_after(duration, belief=CRUISE, **changes):
    return after_silence(*beliefs_after(duration, belief), silence_of(duration, **changes))


def draws(rng, belief, count):
    P = [[belief.angle_variance, belief.covariance], [belief.covariance, belief.speed_variance]]
    return rng.multivariate_normal(belief[:2], P, count, check_valid="raise").T


def particles(cruise, manoeuvre, silence, seed, count=100_000):
    """The hypotheses by particles: angle, speed and weight of those that go on, and of those that halt.

    Each is drawn as it was before the silence, and kept where no edge would have come.
    """
    rng, s, width = np.random.default_rng(seed), silence, silence.next_edge - silence.last_edge
    one, changed = np.full(count, 1.0 / count), s.stop_rate * s.duration
    noise = np.sqrt(s.edge_variance) * rng.normal(size=count)

    angle, speed = draws(rng, cruise, count)
    n = min(s.watched, BURSTY) + UNWATCHED
    passed = max(1, int(np.ceil((cruise.angle - s.next_edge) / width)))
    a = max(s.irregular, 1e-3) * n
    row = betabinom.pmf(passed, passed, a, n - a)
    still = rng.random(count) * s.duration * cruise.speed < width  # stopped before the edge was due
    back = (speed < 0.0) @ one
    fast, wild = draws(rng, manoeuvre, count)
    stopped = changed * (still @ one) + back + changed * ((wild < 0.0) @ one)
    seen = angle + noise
    on = [
        (angle, speed, one * ((seen > s.last_edge) & (seen < s.next_edge))),
        (angle, speed, one * max(row, DROPOUTS * stopped) * (seen > s.next_edge)),
        (fast, wild, one * changed * ((fast + noise > s.last_edge) & (fast + noise < s.next_edge))),
    ]
    somewhere = s.last_edge + width * rng.random(count)
    begun = rng.random(count) < s.stop_rate * STARTED
    moving = begun * np.sqrt(s.start_variance) * rng.normal(size=count)
    usual = cruise.speed + 2.0 * np.sqrt(cruise.speed_variance)
    slowly = usual * rng.random(count)  # kept where a sector takes it longer than the silence
    allowed = slowly * s.duration < width
    share = min(1.0, width / s.duration / cruise.speed) / (allowed @ one)
    halt = [(somewhere, moving, one * stopped), (somewhere, slowly, one * stopped * allowed * share)]
    return tuple(np.concatenate(group, axis=1) for group in ([np.stack(x) for x in on], [np.stack(x) for x in halt]))


@pytest.mark.parametrize("sectors", [0.7, 1.0, 1.1, 1.25, 1.6, 2.5, 6.0, 40.0])
def test_against_particles(sectors):
    """Mean of those that halt where that is sure, else of the others; scatter of all about it; 100 000 particles for
    each hypothesis."""
    belief = CRUISE._replace(angle_variance=4e-3, speed_variance=4.0)
    duration = sectors * WIDTH / 155.0
    cruise, manoeuvre = beliefs_after(duration, belief)
    silence = silence_of(duration, stop_rate=0.3)
    heard = after_silence(cruise, manoeuvre, silence)
    on, halt = particles(cruise, manoeuvre, silence, seed=int(10 * sectors))
    both = np.concatenate([on, halt], axis=1)
    whole, halts = both[2].sum(), halt[2].sum()
    shown = halt if halts > SURE * whole else on
    mean = shown[:2] @ shown[2] / shown[2].sum()
    square = (both[:2] - mean[:, None]) ** 2 @ both[2] / whole
    assert heard.halt == pytest.approx(halts / whole, rel=0.03, abs=1e-6)
    assert heard.angle == pytest.approx(mean[0], abs=0.005 * WIDTH)
    assert heard.speed == pytest.approx(mean[1], rel=0.01, abs=0.1)
    assert [heard.angle_variance, heard.speed_variance] == pytest.approx(square, rel=0.03)


def test_long_before_the_edge_nothing_is_said_but_that_it_may_have_stopped():
    """A third of a sector on: the mean stays; a wheel that stopped or turns slowly, lambda h of each, adds
    lambda h (1 + 1/3) omega^2 = 0.01 x 0.001689 x 4/3 x 155^2 = 0.541 rad^2/s^2, and a manoeuvre lambda h x 2e4 h.
    """
    duration = WIDTH / 3.0 / 155.0
    cruise, _ = beliefs_after(duration)
    heard = heard_after(duration)
    assert (heard.angle, heard.speed) == pytest.approx(cruise[:2], rel=1e-6)
    more = heard.speed_variance - cruise.speed_variance
    assert more == pytest.approx(0.541 + 0.01 * duration * 2e4 * duration, rel=5e-3)
    assert heard.standstill == pytest.approx(0.01 * duration, rel=1e-3)
    assert not is_late(cruise, silence_of(duration))
    nothing = heard_after(duration, stop_rate=1e-12)
    assert nothing[:4] == pytest.approx((*cruise[:3], cruise.speed_variance), rel=1e-4)


def test_late_by_so_many_deviations():
    """Where the angle is known to 0.06 rad the edge is late LATE x 0.06 rad behind it; where it is known to half a
    sector, 0.4 rad, at best, a silence is always heard."""
    known, silence = AngleSpeed(0.0, 155.0, 0.06**2, 0.0, 1.0), silence_of(1e-3, edge_variance=0.0)
    for over, late in ((-0.1, False), (0.059 * LATE, False), (0.061 * LATE, True), (0.4, True)):
        assert is_late(known._replace(angle=WIDTH + over), silence) is late
    assert is_late(known._replace(angle=0.1, angle_variance=0.16), silence)


def test_half_of_a_belief_at_the_edge_by_hand():
    """The edge is due now, to 0.1 rad, and one in five is missed: 1/2 goes on below it, 1/2 x 1/5 above. The mean lies
    0.1 sqrt(2/pi) (1/5 - 1)/(1/5 + 1) = -0.0532 rad from the edge; a wheel that cannot stop does not.
    """
    belief = AngleSpeed(WIDTH, 155.0, 0.01, 0.0, 1.0)
    silence = silence_of(WIDTH / 155.0, edge_variance=0.0, irregular=0.2, stop_rate=1e-15)
    heard = after_silence(belief, belief, silence)
    assert heard.angle - WIDTH == pytest.approx(-0.05319, abs=1e-5)
    assert heard.angle_variance == pytest.approx(0.01 - 0.05319**2, rel=1e-3)
    assert heard.speed == 155.0 and heard.standstill < 1e-12


@given(st.floats(0.05, 60.0), st.floats(-4.0, 0.0), st.floats(1e-4, 0.4), st.floats(20.0, 300.0))
def test_shares_are_shares(sectors, exponent, irregular, speed):
    """Halt and standstill are probabilities, those of missed edges what is left at most, and deviations are real."""
    belief = CRUISE._replace(speed=speed)
    heard = heard_after(sectors * WIDTH / speed, belief, irregular=irregular, stop_rate=10.0**exponent)
    assert 0.0 <= heard.backward <= heard.standstill <= heard.halt <= 1.0
    assert np.exp(heard.missing_odds) * heard.halt <= 1.0 - heard.halt + 1e-12
    assert heard.angle_variance > 0.0 and heard.speed_variance > 0.0
    assert 0.0 <= heard.speed < 1.1 * speed


@pytest.mark.parametrize("sectors", [0.8, 1.2, 3.0, 20.0])
def test_unit_of_time_is_free(sectors, monkeypatch):
    """Time in units c times as short, angles as they are: probabilities and angles stay, speeds are divided by c."""
    duration, c = sectors * WIDTH / 155.0, 1000.0
    cruise, manoeuvre = beliefs_after(duration)
    heard = after_silence(cruise, manoeuvre, silence_of(duration))
    slow = (AngleSpeed(b[0], b[1] / c, b[2], b[3] / c, b[4] / c**2) for b in (cruise, manoeuvre))
    monkeypatch.setattr(module, "STARTED", c * STARTED)
    again = after_silence(*slow, silence_of(c * duration, stop_rate=0.01 / c, start_variance=1000.0 / c**2))
    scale = np.array([1.0, c, 1.0, c * c, 1.0, 1.0, 1.0, 1.0])
    np.testing.assert_allclose(np.array(again) * scale, heard, rtol=1e-9)


def test_a_jam_is_told_within_three_sectors():
    """One edge may be missed, p_1 = 1/1000 of them where hardly any ever was, against lambda T = 5e-5 of stops and less
    of slow passages; two, 2.7e-5, hardly; so the wheel stands after between two and three sectors."""
    heard = {k: heard_after(k * WIDTH / 155.0, irregular=1e-3) for k in (0.9, 1.5, 3.0, 10.0, 400.0)}
    assert heard[0.9].standstill < 1e-4 and heard[1.5].standstill < 0.1
    assert heard[3.0].standstill > 0.5 and heard[10.0].standstill > 0.85
    assert heard[400.0].standstill == pytest.approx(1.0 / (1.0 + DROPOUTS), abs=0.005)
    assert [heard[k].speed for k in (0.9, 1.5)] == pytest.approx([155.0, 155.0], rel=2e-3)
    assert heard[10.0].speed < 3.0 and 0.0 < heard[10.0].angle < WIDTH
    assert missed_in_a_row(1e-3, 64.0, 2.0) == pytest.approx(2.7e-5, rel=0.02)


def test_many_edges_missed_of_late_make_a_jam_seen_later():
    """A third of the edges missed: three in a row are common, and the wheel is not thought to stand after four."""
    few, many = (heard_after(4.0 * WIDTH / 155.0, irregular=p) for p in (1e-3, 0.33))
    assert few.standstill > 0.5 > 0.01 > many.standstill


def test_just_after_an_edge_nothing_creeps_faster_than_the_wheel_went():
    """A sector narrower than the noise of its edges is listened to at once; nothing slow is faster than 155 rad/s."""
    narrow = 2.0 * np.pi / 60.0
    cruise, manoeuvre = beliefs_after(1e-6)
    silence = silence_of(1e-6, next_edge=narrow)
    assert is_late(cruise, silence)
    assert after_silence(cruise, manoeuvre, silence).speed_variance < 1.5 * cruise.speed_variance


def test_speed_at_a_start_by_hand():
    """A sector of 0.8 rad in 0.4 s, 2 rad/s; it stood with 1/4, then 3 +- 3, else evenly within 0 to 4:
    mean 0.25 x 3 + 0.75 x 2 = 2.25, square 0.25 x 18 + 0.75 x 16/3 = 8.5, variance 8.5 - 2.25^2 = 3.4375.
    """
    silence = silence_of(0.4, next_edge=0.8, start_variance=9.0)
    assert start_speed(silence, 0.25) == pytest.approx((2.25, 3.4375))


def test_a_wheel_that_turned_back_has_turned_through_anything_up_to_two_sectors():
    """It turned at x, even within the sector, and passes the last edge after 2 x: w +- w, where w is counted."""
    turned = 2.0 * WIDTH * np.linspace(0.0, 1.0, 100_001)
    found = turned_back(1.0, 0.0, silence_of(0.1))
    assert found == pytest.approx(WIDTH**2 / 3.0) and found == pytest.approx(np.mean((turned - WIDTH) ** 2), rel=1e-4)
    # STARTS p/(STARTS p + (1 - p) r) exceeds 1/20 where the edge was expected at a rate below 19 STARTS p/(1 - p).
    limit = 19.0 * STARTS * 0.1 / 0.9
    assert turned_back(0.1, 0.99 * limit, silence_of(0.1)) > 0.0 == turned_back(0.1, 1.01 * limit, silence_of(0.1))


@pytest.mark.parametrize(("duration", "is_possible"), [(8e-3, False), (40e-3, True)])
def test_turning_back_takes_a_deceleration(duration, is_possible):
    """2e4 rad^2/s^3 change a speed by sqrt(2e4 x 8 ms) = 12.6 rad/s, an eleventh of 138 rad/s; by 28 in 40 ms, a fifth.

    Beyond seven deviations (1e-12) an edge that is late says that the wheel slows down, not that it turned back.
    """
    settings = event_filter(equal_wheel(8))
    memory = event_filter_start(settings, 0.0, 0.0, 138.0)._replace(belief=AngleSpeed(0.0, 138.0, 2.6e-4, 0.0, 1.0))
    silence = silence_until(memory, duration, 1.0, settings)
    share = norm.cdf(-138.0 / np.sqrt(1.0 + 2e4 * duration))
    assert silence.reversal == pytest.approx(share, rel=1e-6, abs=1e-15)
    assert (turned_back(1.0, 0.0, silence) > 0.0) == is_possible
    assert turned_back(1.0, 0.0, silence._replace(irregular=0.05)) > 0.0  # a late edge may hide one that was missed


@pytest.mark.parametrize("irregular", [0.001, 0.05, 0.4])
@pytest.mark.parametrize("watched", [0.0, 7.0, 64.0])
def test_missed_in_a_row_is_a_beta_binomial(irregular, watched):
    n = min(watched, BURSTY) + UNWATCHED
    for edges in (0, 1, 2, 9, 32):
        exact = betabinom.pmf(edges, edges, irregular * n, (1.0 - irregular) * n)
        assert missed_in_a_row(irregular, watched, float(edges)) == pytest.approx(exact, rel=1e-9)
    assert missed_in_a_row(irregular, watched, 1e9) == missed_in_a_row(irregular, watched, 32.0)


def test_missed_in_a_row_by_hand():
    """p = 0.2 of 5 edges, a = 1: 1/5 x 2/6 x 3/7 = 1/35; surely independent edges would be 1/125."""
    assert missed_in_a_row(0.2, 0.0, 3.0) == pytest.approx(1.0 / 35.0)
