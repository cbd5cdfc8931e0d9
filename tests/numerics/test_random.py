"""The generator of sampled steps: its recurrence by hand, and that its numbers are what they should be."""

from typing import NamedTuple

import numpy as np
import pytest
from scipy.stats import kstest

from vvdp.numerics.random import (
    FIRST_FACTOR,
    FIRST_MODULUS,
    SECOND_FACTOR,
    SECOND_MODULUS,
    Random,
    normal,
    random_start,
    uniform,
)
from vvdp.simulation.replay import Replay

COUNT = 100_000


class Drawn(NamedTuple):
    uniform: float
    normal: float


def drawn(state, row, settings):
    state, u = uniform(state)
    state, z = normal(state)
    return state, Drawn(u, z)


@pytest.fixture(scope="module")
def replay():
    return Replay(drawn, random_start(0.0), Random(0.0, 0.0), Random(0.0, 0.0))


@pytest.fixture(scope="module")
def numbers(replay):
    return replay(random_start(1.0), np.zeros((COUNT, 2))).shown.T


def test_recurrence_by_hand():
    """From (12345, 67890): 40014 * 12345 = 493972830; 40692 * 67890 = 2762579880 = 615096481 + 2147483399.

    The difference -121123651 lies below 0, so 2147483562 is added: 2026359911; the number is that and a half over it.
    """
    state, u = uniform(Random(12345.0, 67890.0))
    assert state == Random(493972830.0, 615096481.0)
    assert u == pytest.approx((2026359911.0 + 0.5) / 2147483562.0, rel=1e-15)


def test_whole_numbers_stay_exact():
    """Python's integers give the same sequence; all products stay below 2^53."""
    assert max(FIRST_FACTOR * FIRST_MODULUS, SECOND_FACTOR * SECOND_MODULUS) < 2.0**53
    state, a, b = Random(1.0, 2147483398.0), 1, 2147483398
    for _ in range(2000):
        state, _ = uniform(state)
        a, b = 40014 * a % 2147483563, 40692 * b % 2147483399
    assert state == Random(float(a), float(b))


def test_uniform_numbers_are_even(numbers):
    assert kstest(numbers[0], "uniform").pvalue > 1e-3
    assert 0.0 < numbers[0].min() < numbers[0].max() < 1.0


def test_normal_numbers_are_normal(numbers):
    assert kstest(numbers[1], "norm").pvalue > 1e-3
    assert abs(numbers[1].mean()) < 4 / np.sqrt(COUNT)
    assert abs(numbers[1].var() - 1.0) < 4 * np.sqrt(2 / COUNT)


@pytest.mark.parametrize("lag", [1, 2, 7])
def test_numbers_do_not_follow_from_each_other(numbers, lag):
    """A correlation of independent numbers has the deviation 1/sqrt(n)."""
    for column in numbers:
        assert abs(np.corrcoef(column[lag:], column[:-lag])[0, 1]) < 4 / np.sqrt(COUNT)


def test_neighbouring_seeds_do_not_resemble_each_other(replay):
    streams = np.array([replay(random_start(float(s)), np.zeros((2000, 2))).shown[:, 1] for s in range(40)])
    between = np.corrcoef(streams)[np.triu_indices(40, 1)]
    assert np.max(np.abs(between)) < 5 / np.sqrt(2000)
    assert abs(between.mean()) < 4 / np.sqrt(2000 * between.size)
    firsts = np.array([uniform(random_start(float(s)))[1] for s in range(1000)])
    assert kstest(firsts, "uniform").pvalue > 1e-3


def test_a_draw_over_neighbouring_seeds_is_as_good_as_any(replay):
    """The same draw of seeds 0, 1, 2, ...: n times its squared correlation is 1 on average, with a variance of 2.

    Seeds handed straight to generators that are linear fail here: their draws run through a lattice.
    """
    seeds, draws = 200, 1000
    table = np.array([replay(random_start(float(s)), np.zeros((draws, 2))).shown[:, 0] for s in range(seeds)])
    standard = (table - table.mean(axis=0)) / table.std(axis=0)
    correlation = np.mean(standard[1:] * standard[:-1], axis=0)
    assert abs(np.mean(seeds * correlation**2) - 1.0) < 4 * np.sqrt(2 / draws) + 2 / seeds  # last: bias of the mean
