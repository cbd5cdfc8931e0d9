"""The generator of the campaign against closed forms."""

import numpy as np
import pytest
from tests.campaign.cases import CLASSES, case
from tests.campaign.generator import (
    TURN,
    Course,
    Disc,
    Passages,
    constant,
    course,
    dip,
    disc,
    jam,
    passages,
    ramp,
    rippled,
    rising,
    sampled,
    step,
    stop,
    swing,
    wandering,
    with_faults,
)


@pytest.fixture
def rng():
    return np.random.default_rng(1)


def wheel_of(*edges: float) -> Disc:
    return Disc(np.array(edges), np.array(edges))


@pytest.mark.parametrize(
    ("speed", "until", "angle"),
    [
        (constant(100.0), 2.0, 200.0),
        (ramp(100.0, -100.0, 0.5, 1.5), 2.0, 0.0),
        (step(50.0, 100.0, 1.0, 0.1), 2.0, 50.0 + 100.0 - 50.0 * 0.1 * (1.0 - np.exp(-10.0))),
        (stop(155.0, 1.0, 0.05, 1.5), 2.0, 155.0 * (1.0 + 0.5 * 0.05 + 0.5 * 0.05 + 0.45)),
        (jam(100.0, 1.0), 2.0, 100.0),
        (dip(100.0, 20.0, 1.0, 0.5), 2.0, 200.0 - 0.25 * 80.0),
        (swing(100.0, 10.0, 1.0, 0.0), 1.5, 150.0 + 10.0 * 2.0 / TURN),
    ],
)
def test_motions_come_as_far_as_their_closed_forms(speed, until, angle):
    assert course(speed, until).angle[-1] == pytest.approx(angle, abs=2e-3)  # a jam falls between two points


def test_what_is_turned_through_has_no_direction():
    """100 rad/s to -100 within 1 s: 50 forward, 25 on, 25 and 50 back."""
    motion = course(ramp(100.0, -100.0, 0.5, 1.5), 2.0)
    assert motion.turned[-1] == pytest.approx(150.0, rel=1e-6)


def test_a_ripple_swings_with_the_angle_and_keeps_its_mean():
    """Over whole periods the time goes by 1/sqrt(1 - r^2) of that at the plain speed."""
    r = 0.05
    motion = rippled(course(constant(100.0), 1.0), r, 3.0, 0.4)
    assert motion.speed == pytest.approx(100.0 * (1.0 + r * np.cos(3.0 * motion.angle + 0.4)))
    slope = np.gradient(motion.angle, motion.time)
    assert slope[5:-5] == pytest.approx(motion.speed[5:-5], abs=0.05)
    assert motion.angle[-1] == pytest.approx(100.0 * np.sqrt(1.0 - r * r), abs=2.0 * r / 3.0)


def test_a_walk_has_its_density(rng):
    """Over 0.01 s the speed has moved with variance q t: 4000 of them know it to 1/sqrt(2000) = 2.2 %."""
    motion = course(wandering(constant(100.0), 25.0, 100.0, rng), 40.0)
    moves = np.diff(motion.speed[:: round(0.01 / motion.time[1])])
    assert np.var(moves) == pytest.approx(25.0 * 0.01, rel=4.0 * 0.0224)
    still = course(wandering(jam(100.0, 1.0), 25.0, 100.0, rng), 2.0)
    assert np.all(still.speed[still.time > 1.0] == 0.0)


def test_edges_pass_where_the_wheel_has_them(rng):
    """At 10 rad/s from 0 the edges at 1 and 4 rad, and again a turn on."""
    seen = passages(course(constant(10.0), 1.2), wheel_of(1.0, 4.0), 0.0, rng)
    assert seen.times == pytest.approx([0.1, 0.4, 0.1 * (1.0 + TURN), 0.1 * (4.0 + TURN)])
    assert seen.polarities.tolist() == [1.0, -1.0, 1.0, -1.0]


def test_backwards_the_edges_mirror(rng):
    """theta = 10 t - 10 t^2 crests at 2.5 rad and passes 1 rad at (1 -+ sqrt(0.6))/2 s; what rose falls."""
    seen = passages(course(ramp(10.0, -10.0, 0.0, 1.0), 1.0), wheel_of(1.0, 4.0), 0.0, rng)
    assert seen.polarities.tolist() == [1.0, -1.0]
    assert seen.times == pytest.approx([(1 - 0.6**0.5) / 2, (1 + 0.6**0.5) / 2], abs=1e-6)


def test_jitter_is_an_angle(rng):
    """10 rad/s, 0.02 rad: 2 ms of scatter, known to 1/sqrt(2 n)."""
    exact = passages(course(constant(10.0), 100.0), wheel_of(1.0, 4.0), 0.0, rng)
    seen = passages(course(constant(10.0), 100.0), wheel_of(1.0, 4.0), 0.02, rng)
    n = min(exact.times.size, seen.times.size)
    assert np.std(seen.times[:n] - exact.times[:n]) == pytest.approx(2e-3, rel=4.0 / np.sqrt(2.0 * n))


def test_a_wheel_is_as_uneven_as_asked_for(rng):
    wheel = disc(1000, 0.25, 0.2, rng)
    pitch = TURN / 1000
    assert wheel.meant[1] == pytest.approx(1.25 * pitch)
    off = (wheel.made - wheel.meant) / pitch
    assert np.abs(off).max() == pytest.approx(0.1, abs=0.01) and off.mean() == pytest.approx(0.0, abs=1e-9)


def test_faults_come_as_often_as_asked_for(rng):
    """Of 10 000 edges 30 % missed, 10 % of the others three times: 8400, known to 4 (0.46 sqrt(1e4) + ...) < 300."""
    every = Passages(np.arange(10_000.0), np.where(np.arange(10_000) % 2, -1.0, 1.0))
    seen = with_faults(every, 0.3, 0.1, rng)
    assert seen.times.size == pytest.approx(8400, abs=300) and np.all(np.diff(seen.times) >= 0.0)
    bounced = np.flatnonzero(np.diff(seen.times) < 0.1)
    assert np.all(seen.polarities[bounced] == -seen.polarities[bounced + 1])
    assert rising(every).times.size == 5000


def test_samples_count_what_passed_since_the_last():
    seen = Passages(np.array([0.0012, 0.0031, 0.0034]), np.array([1.0, -1.0, 1.0]))
    rows = sampled(seen, 0.006, 1000.0, 0.0, stamped=True, told=True)
    assert rows[:, 1].tolist() == [0.0, 0.0, 1.0, 0.0, 2.0]
    assert rows[4].tolist() == pytest.approx([0.004, 2.0, 0.0034, 0.0, 1.0])
    middle = sampled(seen, 0.006, 1000.0, 0.0, stamped=False, told=False)
    assert middle[4].tolist() == pytest.approx([0.004, 2.0, 0.0035, 0.001, 0.0])


@pytest.mark.parametrize("name", CLASSES)
def test_a_record_follows_from_its_seed(name):
    one, again, other = case(name, 3), case(name, 3), case(name, 4)
    np.testing.assert_array_equal(one.seen.times, again.seen.times)
    assert one.seen.times.size != other.seen.times.size or one.usual != other.usual
    assert isinstance(one.motion, Course) and np.all(np.diff(one.seen.times) >= 0.0)
