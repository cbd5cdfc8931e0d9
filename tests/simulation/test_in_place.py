"""Powers and exponentials in place: against more digits, in what is special, and in generated code."""

import ctypes
from functools import cache

import numpy as np
import pytest
from llvmlite import ir
from tests.compiled import compiled

from vvdp.base import powers
from vvdp.generator.binding import compile_text, is_fused, load_code
from vvdp.generator.kinds import FLOAT
from vvdp.generator.llvm_writer import write_llvm
from vvdp.generator.unit import Unit
from vvdp.simulation import in_place
from vvdp.simulation.dialect import model_options
from vvdp.simulation.lane_values import DOUBLE, Code, Vector

ULP = 2.0**-52
SPECIAL = [0.0, -0.0, 1.0, -1.0, np.inf, -np.inf, np.nan, 2.0, -2.0, 3.0, -3.0, 0.5, 5e-324, 2.3e-308, 1.7e308, -1e300]
FORMS = [True, False] if is_fused() else [False]
KEPT = []


@cache
def in_code(name, count, fused):
    """A function of `in_place` over whole arrays, compiled for a processor that is `fused` or not."""
    module = ir.Module()
    function = ir.Function(module, ir.FunctionType(DOUBLE, [DOUBLE] * count), "in_place")
    code = Code(ir.IRBuilder(function.append_basic_block()), 1, fused)
    result = getattr(in_place, name)(code, *(Vector(code, argument) for argument in function.args))
    code.builder.ret(result.value)
    KEPT.append(load_code(compile_text(str(module), 3), ["in_place"]))
    call = ctypes.CFUNCTYPE(ctypes.c_double, *[ctypes.c_double] * count)(KEPT[-1].addresses["in_place"])
    return lambda *arrays: np.array([call(*values) for values in zip(*(a.tolist() for a in arrays), strict=True)])


def spread(low, high, count, rng):
    """Numbers spread evenly over their magnitudes."""
    return np.exp(rng.uniform(np.log(low), np.log(high), count))


def error(found, exact):
    return np.max(np.abs((found - exact) / exact)) / ULP


@pytest.mark.parametrize("fused", FORMS)
def test_powers_are_right_to_two_units_in_the_last_place(fused):
    rng, run = np.random.default_rng(4), in_code("power", 2, fused)
    x = np.concatenate([spread(1e-70, 1e70, 20000, rng), spread(0.5, 2.0, 20000, rng)])
    y = rng.uniform(-4.0, 4.0, x.size)
    assert error(run(x, y), np.power(x.astype(np.longdouble), y)) < 2.0


@pytest.mark.parametrize("fused", FORMS)
def test_powers_near_one_keep_what_they_differ_by(fused):
    """Far exponents make them large again: the digits of the logarithm are lost, as many as the result is from 1."""
    rng, run = np.random.default_rng(5), in_code("power", 2, fused)
    near = 1.0 + spread(1e-9, 0.5, 20000, rng) * rng.choice([-1.0, 1.0], 20000)
    for end in (1.0, 10.0, 100.0, 690.0):
        far = rng.uniform(-end, end, near.size) / np.log(near)
        assert error(run(near, far), np.power(near.astype(np.longdouble), far)) < 4.0 * end


@pytest.mark.parametrize("fused", FORMS)
def test_every_interval_of_the_table_is_right(fused):
    """Each mantissa next to an end of one, and each root of 2 next to an end of the other."""
    run, step = in_code("power", 2, fused), 1 << (52 - in_place.LOG_BITS)
    ends = in_place.FIRST + step * np.arange((1 << in_place.LOG_BITS) + 1)
    x = np.concatenate([(ends + near).view(np.float64) for near in (-1, 0, 1)])
    assert error(run(x, np.full(x.size, 0.75)), np.power(x.astype(np.longdouble), 0.75)) < 2.0
    y = (np.arange(-200, 201) + 0.5) / (1 << in_place.EXP_BITS)
    y = np.concatenate([y * (1.0 + near) for near in (-1e-15, 0.0, 1e-15)])
    assert error(run(np.full(y.size, 2.0), y), np.exp2(y.astype(np.longdouble))) < 2.0


@pytest.mark.parametrize("fused", FORMS)
def test_special_powers_are_those_of_the_c_library(fused):
    x, y = (column.ravel() for column in np.meshgrid(SPECIAL, [*SPECIAL, 1e-320, 1e3, 2.0**60, 1e300]))
    with np.errstate(all="ignore"):
        expected = np.power(x, y)
    np.testing.assert_allclose(in_code("power", 2, fused)(x, y), expected, rtol=4.0 * ULP)


@pytest.mark.parametrize("fused", FORMS)
def test_expm1_is_right_to_two_units_in_the_last_place(fused):
    rng, run = np.random.default_rng(6), in_code("expm1", 1, fused)
    x = np.concatenate([spread(1e-300, 700.0, 20000, rng), spread(0.3, 0.4, 2000, rng)])
    x *= rng.choice([-1.0, 1.0], x.size)
    assert error(run(x), np.expm1(x.astype(np.longdouble))) < 2.0
    special = np.array([0.0, -0.0, np.inf, -np.inf, np.nan, 5e-324, 800.0])
    with np.errstate(all="ignore"):
        np.testing.assert_array_equal(run(special), np.expm1(special))


def both(x, k):
    return powers.power(x, k), powers.expm1(x)


def test_generated_code_takes_them_in_place():
    run = compiled(both, 1.0, 1.0)
    for value in np.linspace(0.1, 3.0, 50).tolist():
        assert run(value, -0.4) == pytest.approx((value**-0.4, np.expm1(value)), rel=4.0 * ULP)
    assert run(2, 3) == (8.0, pytest.approx(np.expm1(2.0), rel=4.0 * ULP))
    unit = Unit(model_options())
    unit.add(both, [FLOAT, FLOAT], "both")
    assert "vvdp_reciprocals" in write_llvm(unit.module())
