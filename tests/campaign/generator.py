"""Records of an edge sensor, made straight from a motion: no code of the package has a part in them.

A course is a motion on a fine raster; edges pass where the interpolated angle crosses the places of a wheel's edges, in
either direction. SI units throughout.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

TURN = 2.0 * np.pi
RASTER = 2e-5
"""Between two points of a course [s]: on a line between them an acceleration of 3000 rad/s^2 bends by 1.5e-7 rad."""


class Course(NamedTuple):
    """Where the wheel stands and how fast it turns at evenly spaced times, speeds backwards being negative."""

    time: np.ndarray
    angle: np.ndarray
    speed: np.ndarray

    @property
    def turned(self) -> np.ndarray:
        """Angle turned through since the start, whichever way."""
        return np.concatenate([[0.0], np.cumsum(np.abs(np.diff(self.angle)))])


class Disc(NamedTuple):
    """Angles of the edges of a wheel within a turn as it was meant, and as it was made; edges of even number rise."""

    meant: np.ndarray
    made: np.ndarray


class Passages(NamedTuple):
    """When edges passed, and with which polarity: +1 from dark to bright, -1 from bright to dark."""

    times: np.ndarray
    polarities: np.ndarray


def course(speed: Callable[[np.ndarray], np.ndarray], until: float, start: float = 0.0) -> Course:
    """The motion of a `speed` over time; its angle by the trapezoidal rule from `start`."""
    time = np.linspace(0.0, until, round(until / RASTER) + 1)
    w = speed(time)
    angle = start + np.concatenate([[0.0], np.cumsum(0.5 * (w[1:] + w[:-1]) * np.diff(time))])
    return Course(time, angle, w)


def rippled(plain: Course, share: float, per_turn: float, phase: float) -> Course:
    """The course whose speed is the plain one times 1 + share cos(per_turn theta + phase).

    The plain angle u is the integral of d theta/(1 + share cos(...)), tabulated over theta and read backwards.
    """
    low, high = plain.angle.min(), plain.angle.max()
    theta = np.linspace(low - 1.0, high + 1.0, round((high - low + 2.0) * 40.0 * max(per_turn, 1.0)))
    rate = 1.0 / (1.0 + share * np.cos(per_turn * theta + phase))
    u = np.concatenate([[0.0], np.cumsum(0.5 * (rate[1:] + rate[:-1]) * np.diff(theta))])
    u += plain.angle[0] - np.interp(plain.angle[0], theta, u)
    angle = np.interp(plain.angle, u, theta)
    return Course(plain.time, angle, plain.speed * (1.0 + share * np.cos(per_turn * angle + phase)))


def constant(speed: float) -> Callable[[np.ndarray], np.ndarray]:
    return lambda t: np.full_like(t, speed)


def ramp(before: float, after: float, begin: float, end: float) -> Callable[[np.ndarray], np.ndarray]:
    return lambda t: before + (after - before) * np.clip((t - begin) / (end - begin), 0.0, 1.0)


def step(before: float, after: float, at: float, time_constant: float) -> Callable[[np.ndarray], np.ndarray]:
    return lambda t: after + (before - after) * np.exp(-np.clip(t - at, 0.0, None) / time_constant)


def stop(speed: float, at: float, lasting: float, restart: float) -> Callable[[np.ndarray], np.ndarray]:
    """Comes to rest within `lasting`, and as quickly up to speed from `restart` on."""
    return lambda t: speed * (1.0 - np.clip((t - at) / lasting, 0.0, 1.0) + np.clip((t - restart) / lasting, 0.0, 1.0))


def jam(speed: float, at: float) -> Callable[[np.ndarray], np.ndarray]:
    """Stands still at once, for good."""
    return lambda t: np.where(t < at, speed, 0.0)


def dip(speed: float, lowest: float, at: float, lasting: float) -> Callable[[np.ndarray], np.ndarray]:
    """Slows down to `lowest` and recovers, along one wave of a cosine."""
    return lambda t: speed - 0.5 * (speed - lowest) * (1.0 - np.cos(TURN * np.clip((t - at) / lasting + 0.5, 0.0, 1.0)))


def swing(speed: float, amplitude: float, frequency: float, phase: float) -> Callable[[np.ndarray], np.ndarray]:
    return lambda t: speed + amplitude * np.sin(TURN * frequency * t + phase)


def wandering(
    speed: Callable[[np.ndarray], np.ndarray], density: float, usual: float, rng: np.random.Generator
) -> Callable[[np.ndarray], np.ndarray]:
    """A speed with white acceleration of `density` [rad^2/s^3] on top at the `usual` speed, in proportion elsewhere:
    what stands still goes on to stand still."""

    def walk(t: np.ndarray) -> np.ndarray:
        steps = rng.normal(0.0, np.sqrt(density * np.diff(t)))
        return speed(t) * (1.0 + np.concatenate([[0.0], np.cumsum(steps)]) / usual)

    return walk


def disc(sectors: int, index_shift: float, uneven: float, rng: np.random.Generator) -> Disc:
    """A wheel whose edge 1 is moved by a share of a sector, its widths off by up to `uneven` of a sector: every edge by
    half of that either way."""
    pitch = TURN / sectors
    meant = pitch * np.arange(sectors)
    meant[1] += index_shift * pitch
    off = 0.5 * uneven * pitch * rng.uniform(-1.0, 1.0, sectors)
    return Disc(meant, meant + off - off.mean())


def passages(motion: Course, wheel: Disc, jitter: float, rng: np.random.Generator) -> Passages:
    """Every edge that passes, each seen off its place by a normal error of standard deviation `jitter` [rad]."""
    n = wheel.made.size
    first = n * int(np.floor(motion.angle.min() / TURN) - 2)
    last = n * int(np.ceil(motion.angle.max() / TURN) + 2)
    numbers = np.arange(first, last)
    places = TURN * (numbers // n) + wheel.made[numbers % n]
    shortest = np.diff(places).min()
    places = np.sort(places + np.clip(rng.normal(0.0, jitter, places.size), -0.45 * shortest, 0.45 * shortest))
    behind = np.searchsorted(places, motion.angle, side="right")
    at = np.flatnonzero(np.diff(behind))
    times, signs = [], []
    for i in at.tolist():
        a, b = behind[i], behind[i + 1]
        passed = range(a, b) if b > a else range(a - 1, b - 1, -1)
        for k in passed:
            share = (places[k] - motion.angle[i]) / (motion.angle[i + 1] - motion.angle[i])
            times.append(motion.time[i] + share * (motion.time[i + 1] - motion.time[i]))
            signs.append((1.0 if b > a else -1.0) * (1.0 - 2.0 * (numbers[k] % 2)))
    return Passages(np.array(times), np.array(signs))


def with_faults(seen: Passages, missed: float, double: float, rng: np.random.Generator) -> Passages:
    """The edges that are not missed, some of them bouncing: there, back and there again within 4 % of the time to the
    next."""
    kept = rng.random(seen.times.size) >= missed
    times, signs = seen.times[kept], seen.polarities[kept]
    bounces = rng.random(times.size) < double
    room = np.diff(times, append=times[-1:] + np.median(np.diff(times)))[bounces]
    room = np.clip(room, 0.0, np.median(np.diff(times)))
    extra = [times[bounces] + share * room for share in (0.02, 0.04)]
    all_times = np.concatenate([times, *extra])
    all_signs = np.concatenate([signs, -signs[bounces], signs[bounces]])
    order = np.argsort(all_times, kind="stable")
    return Passages(all_times[order], all_signs[order])


def rising(seen: Passages) -> Passages:
    """The edges of one polarity alone."""
    up = seen.polarities > 0.0
    return Passages(seen.times[up], seen.polarities[up])


def sampled(seen: Passages, until: float, rate: float, phase: float, *, stamped: bool, told: bool) -> np.ndarray:
    """Rows (time, edges since the row before, time of the last of them, interval in which it lies, its polarity).

    phase    of the clock, a share of its period
    stamped  a capture unit tells the time of the last edge; else it lies in the middle of the interval
    told     the polarity is known, else it is 0
    """
    period = 1.0 / rate
    ticks = (np.arange(int(until * rate) - 1) + phase) * period
    passed = np.searchsorted(seen.times, ticks, side="right")
    count = np.diff(passed, prepend=0)
    some = count > 0
    last = np.clip(passed - 1, 0, None)
    at = np.where(some, seen.times[last], 0.0) if stamped else np.where(some, ticks - 0.5 * period, 0.0)
    width = np.where(some & (not stamped), period, 0.0)
    sign = np.where(some & told, seen.polarities[last], 0.0)
    return np.column_stack([ticks, count, at, width, sign])
