"""The checked tier: what would go wrong unseen ends the run, with file, line and reason."""

import numpy as np
import pytest
from tests.generator.programs import CASES, ROW
from tests.generator.ways import module_of, run, ways_of

from vvdp.generator.library import Failure
from vvdp.generator.unit import Options

CHECKED = Options(checked=True)


def index(row, i):
    return row[i]


def store(row, i):
    row[i] = 1.0


def section(row, i):
    return row[1:i].sum()


def divide(x, y):
    return x / y


def divide_whole(a, b):
    return a // b


def product(a, b):
    return a * b


def difference(a, b):
    return a - b


def cut(x):
    return int(x)


def uneven(row, other):
    return (row + other).sum()


def assertion(x):
    assert x > 0.0
    return x


def raises(x):
    if x < 0.0:
        raise ValueError(f"{x} is negative")
    return np.sqrt(x)


def inner_failure(row, i):
    total = 0.0
    for _ in range(3):
        total += index(row, i)
    return total


FAILING = [
    (index, (ROW, 4), "an index behind the end of an array"),
    (index, (ROW, -1), "an index below 0"),
    (inner_failure, (ROW, 9), "an index behind the end of an array (in index)"),
    (store, (ROW, 7), "an index behind the end of an array"),
    (section, (ROW, 5), "a slice that is not within its array"),
    (divide, (1.0, 0.0), "a division by zero"),
    (divide_whole, (1, 0), "a division by zero"),
    (product, (2**40, 2**40), "a whole number of more than 64 bits"),
    (difference, (-(2**63), 1), "a whole number of more than 64 bits"),
    (cut, (1e19,), "a number that no whole number of 64 bits can hold"),
    (cut, (float("nan"),), "a number that no whole number of 64 bits can hold"),
    (uneven, (ROW, np.ones(3)), "arrays of different lengths"),
    (assertion, (-1.0,), "assert x > 0.0"),
]


@pytest.mark.parametrize(("function", "values", "reason"), FAILING, ids=[f"{f.__name__}-{r}" for f, _, r in FAILING])
def test_a_check_ends_the_run_with_file_and_line(function, values, reason):
    for name, way in ways_of(module_of(function, values, CHECKED)).items():
        with pytest.raises(Failure, match=rf"test_checked\.py:\d+: {reason.split(' (')[0]}") as caught:
            way(*values)
        assert reason.split("(")[-1].rstrip(")") in str(caught.value), name


@pytest.mark.parametrize(("function", "values"), [(index, (ROW, 3)), (product, (-3, 2**61)), (section, (ROW, 4))])
def test_what_is_right_passes(function, values):
    module = module_of(function, values, CHECKED)
    assert {str(run(way, values)) for way in ways_of(module).values()} == {str(run(function, values))}


def test_raise_ends_the_run_without_checks_too():
    for way in ways_of(module_of(raises, (1.0,))).values():
        assert way(4.0) == 2.0
        with pytest.raises(Failure, match=r"test_checked\.py:\d+: ValueError"):
            way(-1.0)


def test_uninitialised_numbers_are_not_numbers():
    for way in ways_of(module_of(unset, (3,), CHECKED)).values():
        assert np.isnan(way(3))


def unset(n):
    return np.empty(n).sum()


UNFIT = ("floor_division", "true_division", "sums", "shifts", "whole_sums", "powers")
"""Shown at arguments that a check refuses."""
FIT = [case for case in CASES if case[0].__name__ not in UNFIT]


@pytest.mark.parametrize(
    ("function", "cases"),
    [c for c in CASES if c[0].__name__ not in UNFIT],
    ids=lambda value: getattr(value, "__name__", ""),
)
def test_checks_change_no_bit(function, cases):
    way = ways_of(module_of(function, cases[0], CHECKED))["level 2"]
    for values in cases:
        assert run(way, values) == run(function, values)
