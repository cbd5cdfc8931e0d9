"""Readings of a coarse encoder, straight from its definition: no code of the package has a part in them.

And the event filter, compiled, to be run over them.
"""

import numpy as np
import pytest

from vvdp.estimation.event_filter import event_filter_estimator
from vvdp.estimation.event_settings import event_filter
from vvdp.sensing.reading import Reading
from vvdp.sensing.wheel import equal_wheel
from vvdp.simulation.replay import Replay

PERIOD = 1e-3


@pytest.fixture(scope="session")
def sampled_edges():
    """Rows of readings at `times` of a wheel that stands at `angles`, known by the samples alone.

    `crossing(angle)`, where it is given, is the time at which the angle is passed: a capture unit stamps the edges.
    """

    def rows(edges, times, angles, crossing=None, period=PERIOD):
        n, turn = len(edges), 2.0 * np.pi
        turns = np.floor(angles / turn)
        numbers = n * turns + np.searchsorted(edges, angles - turn * turns, side="right") - 1.0
        passed = np.diff(numbers, prepend=numbers[0])
        at, interval = times - 0.5 * period, np.full_like(times, period)
        if crossing is not None:
            at = crossing(turn * (numbers // n) + np.asarray(edges)[(numbers % n).astype(int)])
            interval = np.zeros_like(times)
        polarity = np.where(passed > 0.0, 1.0 - 2.0 * (numbers % 2.0), 0.0)
        return np.column_stack([times, passed, at, interval, polarity])

    return rows


@pytest.fixture(scope="session")
def stepped():
    """What an estimator shows at each row, shape (rows, 7), stepped in plain Python; and its last memory."""

    def run(estimator, rows):
        memory, shown = estimator.memory, []
        for row in rows.tolist():
            memory, estimate = estimator.step(memory, Reading(*row), estimator.settings)
            shown.append(estimate)
        return np.array(shown), memory

    return run


class EdgeTimes:
    """When the edges of a wheel pass, and how an acquisition tells of it; vectorised, for many seeds."""

    @staticmethod
    def angles(edges, first, count):
        """Numbers and unwrapped angles of `count` edges from number `first`."""
        numbers = first + np.arange(count)
        return numbers, 2.0 * np.pi * (numbers // len(edges)) + np.asarray(edges)[numbers % len(edges)]

    @staticmethod
    def triangular(rng, count, half_width):
        return half_width * (rng.random(count) + rng.random(count) - 1.0)

    @staticmethod
    def passed(angle, targets, end):
        """Times at which the rising function `angle` of time reaches `targets`: bisection to 1e-14 s."""
        low, high = np.zeros(targets.size), np.full(targets.size, end)
        for _ in range(48):
            middle = 0.5 * (low + high)
            before = angle(middle) < targets
            low, high = np.where(before, middle, low), np.where(before, high, middle)
        return 0.5 * (low + high)

    @staticmethod
    def clocked(times, polarity, phase, duration, period=PERIOD):
        """Rows of a clock of fixed rate that first ticks at `phase` periods; several edges may fall into one."""
        ticks = (phase + np.arange(int(duration / period))) * period
        order = np.argsort(times, kind="stable")
        times, polarity = times[order], polarity[order]
        tick = np.searchsorted(ticks, times)
        kept = tick < ticks.size
        count = np.bincount(tick[kept], minlength=ticks.size).astype(float)
        last = np.zeros(ticks.size)
        last[tick[kept]] = polarity[kept]
        return np.column_stack([ticks, count, ticks - 0.5 * period, np.full(ticks.size, period), last])

    @staticmethod
    def scattered(times, polarity, rng, duration, period=PERIOD):
        """Rows whose delays are even and independent in a period, among empty ones on a grid of one period."""
        seen = times + period * rng.random(times.size)
        grid = period * np.arange(1, round(duration / period) + 1)
        ones, none = np.ones(seen.size), 0.0 * grid
        rows = np.vstack(
            [
                np.column_stack([seen, ones, seen - 0.5 * period, period * ones, polarity]),
                np.column_stack([grid, none, none, none, none]),
            ]
        )
        rows = rows[np.argsort(rows[:, 0], kind="stable")]
        return rows[rows[:, 0] <= duration + 1e-9]


@pytest.fixture(scope="session")
def edge_times():
    return EdgeTimes


@pytest.fixture(scope="session")
def filtered():
    """What the event filter shows over rows, compiled once for all wheels of eight sectors; and its last memory."""
    wheel = equal_wheel(8)
    example = event_filter_estimator(event_filter(wheel))
    replay = Replay(example.step, example.memory, Reading(0.0, 0.0, 0.0, 0.0, 0.0), example.settings)

    def run(settings, rows, **start):
        memory = event_filter_estimator(settings, **start).memory
        done = replay(memory, rows, settings)
        return done.shown, done.memory

    return run
