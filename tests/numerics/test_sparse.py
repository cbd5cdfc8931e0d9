"""Sparse patterns: columns that share no row, and elimination against NumPy's."""

import numpy as np
import pytest

from vvdp.numerics.sparse import column_groups, pattern
from vvdp.simulation.stiff import factorise, fastest_rate, solve


def random_pattern(rng, n, m):
    depends = rng.random((n, m)) < 0.2
    depends[:m] |= rng.random((m, m)) < 0.1
    return depends


def chain(m):
    """Each state with its neighbours, and a book for each."""
    band = np.abs(np.subtract.outer(np.arange(m), np.arange(m))) <= 1
    return np.vstack([band, np.eye(m, dtype=bool)])


@pytest.mark.parametrize("seed", range(5))
def test_columns_of_a_group_share_no_row(seed):
    depends = random_pattern(np.random.default_rng(seed), 30, 12)
    group = column_groups(depends)
    for number in range(group.max() + 1):
        assert depends[:, group == number].sum(axis=1).max() <= 1


def test_a_chain_of_any_length_needs_three_groups_and_work_in_proportion():
    short, long = pattern(chain(16)), pattern(chain(128))
    assert short.first.size - 1 == long.first.size - 1 == 3
    assert len(long.steps) < 8.5 * len(short.steps) and len(long.upper) == 127


@pytest.mark.parametrize("seed", range(8))
def test_elimination_solves_as_numpy_does(seed):
    rng = np.random.default_rng(seed)
    depends = random_pattern(rng, 20, 11)
    found = pattern(depends)
    full = np.where(depends, rng.uniform(-1.0, 1.0, depends.shape), 0.0)
    jacobian = full[found.rows, found.columns]
    factors, x = np.zeros(11 + 2 * len(found.lower)), rng.uniform(-1.0, 1.0, 11)
    expected = np.linalg.solve(12.0 * np.eye(11) - full[:11], x)
    factorise(found, jacobian, 12.0, factors)
    solve(found, factors, x)
    assert x == pytest.approx(expected, rel=1e-11)


@pytest.mark.parametrize(
    ("full", "fastest"),
    [
        ([[-3.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -25.0, 0.0]], 5.0),  # a decay beside an oscillation of 5 rad/s
        ([[-4.0, 4.0], [4.0, -4.0]], 8.0),  # two volumes that even out: their difference decays at twice the rate
        ([[-1.0, 0.0], [1e6, -2.0]], 2.0),  # what feeds one way only
    ],
)
def test_the_fastest_rate_by_hand_in_any_units(full, fastest):
    full = np.array(full)
    found, sums, units = pattern(full != 0.0), np.zeros(len(full)), np.array([1.0, 1e5, 1e-3])[: len(full)]
    for jacobian in (full, full * units[:, None] / units):
        entries = jacobian[found.rows, found.columns]
        assert fastest_rate(found, entries, sums) == pytest.approx(fastest, rel=1e-14)


def test_the_fastest_rate_is_no_lower_than_any_eigenvalue_of_a_chain():
    """Of n equal volumes in a row: 4 sin(pi (n - 1) / (2 n))^2, below the bound of 4."""
    n = 12
    full = np.diag([-1.0, *[-2.0] * (n - 2), -1.0]) + np.eye(n, k=1) + np.eye(n, k=-1)
    found = pattern(full != 0.0)
    bound = fastest_rate(found, full[found.rows, found.columns], np.zeros(n))
    largest = 4.0 * np.sin(np.pi * (n - 1) / (2 * n)) ** 2
    assert np.abs(np.linalg.eigvals(full)).max() == pytest.approx(largest, rel=1e-12)
    assert largest <= bound <= 1.02 * largest
