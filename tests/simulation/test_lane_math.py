"""Functions of vectors: against the C library's in more digits, in what is special, and in every form they take."""

import ctypes
import math
from fractions import Fraction
from functools import cache

import numpy as np
import pytest
from llvmlite import ir

from vvdp.generator.binding import compile_text, is_fused, load_code
from vvdp.simulation.lane_math import FUNCTIONS, parts, shorten_series
from vvdp.simulation.lane_values import DOUBLE, Code, Vector
from vvdp.simulation.symbols import Op
from vvdp.simulation.trace import PLAIN

ULP = 2.0**-52
SPECIAL = [0.0, -0.0, 1.0, -1.0, np.inf, -np.inf, np.nan, 2.0, -2.0, 3.0, -3.0, 0.5, 5e-324, 2.3e-308, 1.7e308, -1e300]
FORMS = [(8, True), (4, True), (4, False)] if is_fused() else [(4, False)]
KEPT = []


@cache
def lane_function(op, width, fused):
    """The function of `op` over whole vectors, as Python calls it: arrays in, array out."""
    module, place = ir.Module(), ir.PointerType(DOUBLE)
    count = 2 if op is Op.POWER else 1
    function = ir.Function(module, ir.FunctionType(ir.VoidType(), [place] * (count + 1)), "lanes")
    code = Code(ir.IRBuilder(function.append_basic_block()), width, fused)
    kind = ir.PointerType(ir.VectorType(DOUBLE, width))
    places = [code.builder.bitcast(argument, kind) for argument in function.args]
    values = [Vector(code, code.builder.load(at, align=8)) for at in places[:-1]]
    code.builder.store(FUNCTIONS[op](code, *values).value, places[-1], align=8)
    code.builder.ret_void()
    KEPT.append(load_code(compile_text(str(module), 3), ["lanes"]))
    call = ctypes.CFUNCTYPE(None, *[ctypes.c_void_p] * (count + 1))(KEPT[-1].addresses["lanes"])

    def run(*arrays):
        size = -(-arrays[0].size // width) * width
        padded = [np.ascontiguousarray(np.resize(array, size), float) for array in arrays]
        result = np.empty(size)
        for i in range(0, size, width):
            call(*(8 * i + array.ctypes.data for array in (*padded, result)))
        return result[: arrays[0].size]

    return run


def both_signs(low, high, count, rng):
    """Numbers spread evenly over their magnitudes, of either sign."""
    return np.exp(rng.uniform(np.log(low), np.log(high), count)) * rng.choice([-1.0, 1.0], count)


def arguments(op, rng, count=20000):
    near_one = 1.0 + both_signs(1e-15, 0.3, count, rng)
    return {
        Op.EXP: np.concatenate([both_signs(1e-10, 700.0, count, rng), rng.uniform(-2.0, 2.0, count)]),
        Op.EXPM1: np.concatenate([both_signs(1e-18, 700.0, count, rng), rng.uniform(-2.0, 2.0, count)]),
        Op.LOG: np.concatenate([abs(both_signs(1e-307, 1e307, count, rng)), near_one]),
        Op.LOG1P: np.concatenate([abs(both_signs(1e-18, 1e307, count, rng)), rng.uniform(-1.0, 2.0, count)]),
        Op.SIN: both_signs(1e-12, 8e4, count, rng),
        Op.COS: both_signs(1e-12, 8e4, count, rng),
        Op.TAN: both_signs(1e-12, 8e4, count, rng),
        Op.TANH: both_signs(1e-12, 30.0, count, rng),
        Op.ATAN: both_signs(1e-12, 1e12, count, rng),
    }[op]


@pytest.mark.parametrize(("width", "fused"), FORMS)
@pytest.mark.parametrize("op", [op for op in FUNCTIONS if op is not Op.POWER])
def test_functions_are_right_to_a_few_units_in_the_last_place(op, width, fused):
    x = arguments(op, np.random.default_rng(3))
    exact = PLAIN[op](x.astype(np.longdouble))
    error = np.abs((lane_function(op, width, fused)(x) - exact) / exact)
    assert np.max(error) < 2.0 * ULP


@pytest.mark.parametrize(("width", "fused"), FORMS)
def test_powers_are_right_to_a_few_units_in_the_last_place(width, fused):
    rng, run = np.random.default_rng(4), lane_function(Op.POWER, width, fused)
    x = abs(both_signs(1e-30, 1e30, 40000, rng))
    y = rng.uniform(-9.0, 9.0, x.size)
    exact = np.power(x.astype(np.longdouble), y)
    assert np.max(np.abs((run(x, y) - exact) / exact)) < 1.5 * ULP
    near = 1.0 + both_signs(1e-9, 0.5, x.size, rng)
    for end, ulps in ((10.0, 1.5), (100.0, 4.0), (700.0, 30.0)):  # large exponents, up to the ends of the range
        far = rng.uniform(-end, end, x.size) / np.log(near)
        exact = np.power(near.astype(np.longdouble), far)
        assert np.max(np.abs((run(near, far) - exact) / exact)) < ulps * ULP


@pytest.mark.parametrize(("width", "fused"), FORMS)
@pytest.mark.parametrize("op", FUNCTIONS)
def test_special_numbers_go_where_the_c_library_takes_them(op, width, fused):
    if op is Op.POWER:
        values = [np.ravel(grid) for grid in np.meshgrid(SPECIAL, SPECIAL)]
    else:
        values = [np.array([*SPECIAL, 1e10, -1e10, 709.9, 745.2, -745.2])]
    with np.errstate(all="ignore"):
        expected = PLAIN[op](*values)
    found = lane_function(op, width, fused)(*values)
    assert np.allclose(found, expected, rtol=4.0 * ULP, atol=0.0, equal_nan=True), (*values, found, expected)


def test_a_number_in_parts_adds_up():
    from decimal import Decimal

    third = Decimal(1) / 3
    assert parts(third, 1, 53) == [1.0 / 3.0]
    assert abs(sum(map(Decimal, parts(third, 2, 32))) - third) < Decimal(2) ** -60
    assert parts(third, 1, 32)[0] * 1000001.0 == 1000001 * int(parts(third, 1, 32)[0] * 2**33) / 2**33


def test_a_shortened_series_is_better_than_one_cut_off():
    exact = [Fraction(1, math.factorial(i)) for i in range(16)]
    x = np.linspace(-0.5, 0.5, 101)

    def error(series):
        return np.max(np.abs(np.polynomial.polynomial.polyval(x, series) - np.exp(x)))

    best = shorten_series(exact, 6, Fraction(-1, 2), Fraction(1, 2))
    assert len(best) == 6
    assert error(best) < error([float(c) for c in exact[:6]]) / 16.0
    assert error(best) == pytest.approx(0.5**6 / math.factorial(6) / 2**5, rel=0.1)  # that of a Chebyshev polynomial
