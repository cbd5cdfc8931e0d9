"""Sines and logarithms in the language: against more digits, with the same bits in every way of running them."""

import math
from fractions import Fraction

import numpy as np
import pytest
from tests.compiled import compiled
from tests.generator.ways import results

from vvdp.generator import elementary
from vvdp.generator.c_single import SHORTER
from vvdp.simulation.lane_math import EIGHTH, HALF_PI, parts, shorten_series


def sine(x):
    return math.sin(x)


def cosine(x):
    return np.cos(x)


def arcsine(x):
    return math.asin(x)


def log_of_one_plus(x):
    return np.log1p(x)


def angles(rng):
    """Of all sizes, and next to multiples of a quarter of a turn, where most digits cancel."""
    near = rng.integers(1, int(elementary.FAR / math.pi), 10000) * (math.pi / 2.0)
    return np.concatenate([rng.uniform(-10.0, 10.0, 10000), rng.uniform(-1.0, 1.0, 10000) * elementary.FAR, near])


def shares(rng):
    return np.concatenate([rng.uniform(-1.0, 1.0, 10000), 1.0 - np.exp(rng.uniform(-36.0, 0.0, 10000))])


def growths(rng):
    sizes = np.exp(rng.uniform(-40.0, 0.0, (2, 10000)))
    return np.concatenate([sizes[0], 1.0 / sizes[0], -sizes[1]])


FUNCTIONS = {sine: (np.sin, angles, 1.0), cosine: (np.cos, angles, 1.0), arcsine: (np.arcsin, shares, 1.0),
             log_of_one_plus: (np.log1p, growths, 2.0)}  # fmt: skip


@pytest.mark.parametrize("function", FUNCTIONS)
def test_is_right_in_the_last_place(function):
    """An exact result takes half a unit; the last sum, and what is added in it, take little more."""
    named, arguments, most = FUNCTIONS[function]
    x, run = arguments(np.random.default_rng(7)), compiled(function, 1.0)
    exact = named(x.astype(np.longdouble))
    found = np.array([run(each) for each in x.tolist()])
    assert np.max(np.abs(found - exact) / np.spacing(np.abs(exact).astype(float))) < most


@pytest.mark.parametrize("function", FUNCTIONS)
def test_special_numbers_are_those_of_numpy(function):
    named, found = FUNCTIONS[function][0], compiled(function, 1.0)
    for x in (0.0, -0.0, 5e-324, -5e-324, 1.0, -1.0, 2.0**-53, 1e300, math.inf, -math.inf, math.nan):
        with np.errstate(all="ignore"):
            expected = float(named(x))
        assert found(x) == pytest.approx(expected, rel=2e-16, nan_ok=True)
        assert math.copysign(1.0, found(x)) == math.copysign(1.0, expected) or math.isnan(expected)


@pytest.mark.parametrize("name", ["sine", "cosine", "arcsine", "log_of_one_plus"])
def test_bits_are_the_same_in_every_way(name):
    """CPython, the printed tree, machine code and C; 0.75 and the rest are on both sides of an eighth of a turn."""
    for x in (0.1, 0.75, -0.99, 0.5, -1e-9):
        found = results(getattr(elementary, name), x)
        assert len(set(found.values())) == 1, (x, found)


def test_a_hand_calculation():
    """A third of half a turn: its sine is the root of 3/4, its cosine 1/2; a sixth of a turn from 1/2 back."""
    third = math.pi / 3.0
    assert elementary.sine(third) == pytest.approx(math.sqrt(0.75), rel=1e-15)
    assert elementary.cosine(third) == pytest.approx(0.5, rel=1e-15)
    assert elementary.arcsine(0.5) == pytest.approx(math.pi / 6.0, rel=1e-15)
    assert elementary.log_of_one_plus(math.e - 1.0) == pytest.approx(1.0, rel=1e-15)


def test_numbers_of_single_precision_keep_its_digits(monkeypatch):
    """The same text in floats, with what stands there for numbers that follow from the digits of a double."""
    assert sum(SHORTER[each] for each in elementary.QUARTERS) == pytest.approx(np.pi / 2.0, abs=1e-15)
    for name in ("ROUNDING", "PER_QUARTER", "HALF_PI", "HALF_PI_LOW", "SPLIT"):
        value = getattr(elementary, name)
        monkeypatch.setattr(elementary, name, np.float32(SHORTER.get(value, value)))
    for name in ("QUARTERS", "SINE", "COSINE", "ARCSINE"):
        values = getattr(elementary, name)
        monkeypatch.setattr(elementary, name, tuple(np.float32(SHORTER.get(each, each)) for each in values))
    angles = np.linspace(-200.0, 200.0, 4001).astype(np.float32)
    for quarters, named in ((0.0, np.sin), (1.0, np.cos)):
        found = np.array([elementary._shifted_sine(each, np.float32(quarters)) for each in angles])
        assert found.dtype == np.float32
        assert np.max(np.abs(found - named(angles.astype(float)))) < 6e-8
    shares = np.linspace(-1.0, 1.0, 2001).astype(np.float32)
    found = np.array([elementary.arcsine(each) for each in shares], np.float64)
    assert np.max(np.abs(found - np.arcsin(shares.astype(float)))) < 1.2e-7


def test_numbers_of_the_series_are_derived():
    quarters = parts(HALF_PI, 3, 26)
    assert elementary.QUARTERS[:3] == tuple(quarters)
    assert Fraction(elementary.QUARTERS[3]) == Fraction(float(Fraction(HALF_PI) - sum(map(Fraction, quarters))))
    assert float(1 / HALF_PI) == elementary.PER_QUARTER
    assert float(Fraction(HALF_PI) - Fraction(elementary.HALF_PI)) == elementary.HALF_PI_LOW
    sines = [Fraction((-1) ** (i + 1), math.factorial(2 * i + 3)) for i in range(12)]
    cosines = [Fraction((-1) ** i, math.factorial(2 * i + 4)) for i in range(12)]
    arcsines = [Fraction(math.comb(2 * i, i), 4**i * (2 * i + 1)) for i in range(1, 60)]
    assert tuple(shorten_series(sines, 6, Fraction(0), EIGHTH)) == elementary.SINE
    assert tuple(shorten_series(cosines, 6, Fraction(0), EIGHTH)) == elementary.COSINE
    assert elementary.ARCSINE[::-1] == tuple(shorten_series(arcsines, 13, Fraction(0), Fraction(1, 4)))
