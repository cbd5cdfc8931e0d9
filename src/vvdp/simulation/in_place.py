"""Powers and exponentials as instructions in the midst of compiled code.

A call of the C library makes the code around it save all it has in hand, and nothing is calculated beside it. Here
tables stand for most of an argument, and a short series for the rest; what is rare goes to the library all the same.
Powers are within two units in the last place of the exact value for exponents up to 4, whatever the base; large
exponents of bases near 1 lose four units for each factor of e. Zeros come out without their sign.
"""

import math
import struct
from collections.abc import Sequence
from decimal import Decimal, localcontext
from fractions import Fraction
from typing import Any

from llvmlite import ir

from vvdp.simulation.lane_math import EXP_SERIES, LN2, shorten_series
from vvdp.simulation.lane_values import DOUBLE, INTEGER, Code, Vector

LOG_BITS, EXP_BITS = 7, 6
"""Binary digits of an argument that the tables take."""
FIRST = 0x3FE6955500000000
"""Bits of the lowest mantissa, about the root of 1/2: one of the table's intervals has 1 in its middle."""
SHORT = 20
"""Binary digits of a table's reciprocals: so few that their product with half a number is exact."""
SMALL = 0.35
"""Arguments of `expm1` up to which one series does."""


def _logarithms() -> tuple[list[float], list[float]]:
    """Of each interval of mantissas: one over a number in its middle, and that number's binary logarithm."""
    reciprocals, logarithms = list[float](), list[float]()
    step = 1 << (52 - LOG_BITS)
    for i in range(1 << LOG_BITS):
        low, high = (struct.unpack("<d", struct.pack("<q", FIRST + step * (i + end)))[0] for end in (0, 1))
        reciprocal = 1.0 if low < 1.0 < high else round(2.0 / (low + high) * 2.0**SHORT) / 2.0**SHORT
        with localcontext(prec=40):
            logarithms.append(float(-Decimal(reciprocal).ln() / LN2))
        reciprocals.append(reciprocal)
    return reciprocals, logarithms


def _roots() -> list[float]:
    """2 to the power of each fraction i/n, n the size of the table."""
    with localcontext(prec=40):
        return [float((LN2 * i / (1 << EXP_BITS)).exp()) for i in range(1 << EXP_BITS)]


RECIPROCALS, LOGARITHMS = _logarithms()
ROOTS = _roots()
REST, PART = Fraction(43, 10000), Fraction(1, 2 << EXP_BITS)
"""How far a mantissa times its reciprocal is from 1 at most, and an exponent from the table's."""
LOG2_SERIES = shorten_series([Fraction((-1) ** i, i + 1) / Fraction(LN2) for i in range(14)], 6, -REST, REST)
EXP2_SERIES = shorten_series([Fraction(LN2) ** i / math.factorial(i) for i in range(1, 14)], 5, -PART, PART)
ROUNDING = 1.5 * 2.0 ** (52 - EXP_BITS)
"""Added to a number, it leaves that in steps of the table in the last bits."""


def power(code: Code, x: Vector, y: Vector) -> Vector:
    """`x ** y` as pow(x, y) of the C library has it, of one number each."""
    high, low = _log2(code, x)
    e, lost = code.product(y, high)
    shifted = e + ROUNDING
    rest = code.multiply_add(y, low, lost) + (e - (shifted - ROUNDING))
    usual = (x > 2.0**-1022) & (x < math.inf) & (abs(e) < 1000.0)
    if not code.fused:
        usual = usual & (abs(y) < 2.0**900)  # above, the product cannot be split
    with code.where_any(~usual, _exp2(code, shifted, rest)) as held:
        held[0] = code.call("pow", x, y)
    return held[0]


def expm1(code: Code, x: Vector) -> Vector:
    """`e ** x - 1`, of one number."""
    near = code.multiply_add(x * x, code.polynomial(x, EXP_SERIES), x)
    with code.where_any(~(abs(x) < SMALL), near) as held:
        held[0] = code.scalar("expm1", x)
    return held[0]


def _log2(code: Code, x: Vector) -> tuple[Vector, Vector]:
    """The binary logarithm as a sum of two: the second has what the first's last digit cannot show."""
    build = code.builder
    above = build.sub(x.bits, code.whole(FIRST))
    exponent = build.ashr(above, code.whole(52))
    place = build.and_(build.lshr(above, code.whole(52 - LOG_BITS)), code.whole((1 << LOG_BITS) - 1))
    m = code.floats(build.sub(x.bits, build.shl(exponent, code.whole(52))))
    k = Vector(code, build.sitofp(exponent, DOUBLE))
    r = _scaled_to_one(code, m, _entry(code, "reciprocals", RECIPROCALS, place))
    logarithm = _entry(code, "logarithms", LOGARITHMS, place)
    rough = k + logarithm
    series = code.polynomial(r, LOG2_SERIES)
    high = code.multiply_add(r, series, rough)
    low = code.multiply_add(r, series, rough - high) + ((k - rough) + logarithm)
    return high, low


def _scaled_to_one(code: Code, m: Vector, reciprocal: Vector) -> Vector:
    """`m reciprocal - 1`, rounded once."""
    if code.fused:
        return code.multiply_add(m, reciprocal, -1.0)
    high = code.floats(code.builder.and_(m.bits, code.whole(-1 << 32)))
    return (high * reciprocal - 1.0) + (m - high) * reciprocal


def _exp2(code: Code, shifted: Vector, rest: Vector) -> Vector:
    """2 to the power of n/64 + rest, of n/64 plus `ROUNDING`, where that is in range."""
    build, size = code.builder, 1 << EXP_BITS
    root = _entry(code, "roots", ROOTS, build.and_(shifted.bits, code.whole(size - 1)))
    result = code.multiply_add(root, rest * code.polynomial(rest, EXP2_SERIES), root)
    whole = build.and_(shifted.bits, code.whole(-size))
    return code.floats(build.add(result.bits, build.shl(whole, code.whole(52 - EXP_BITS))))


def _entry(code: Code, name: str, values: Sequence[float], place: Any) -> Vector:
    """The number at a place of a table that is kept beside the code."""
    module, kind, name = code.builder.module, ir.ArrayType(DOUBLE, len(values)), f"vvdp_{name}"
    if name not in module.globals:
        table = ir.GlobalVariable(module, kind, name)
        table.linkage, table.global_constant, table.unnamed_addr = "internal", True, True
        table.initializer = ir.Constant(kind, list(values))
    at = code.builder.gep(module.globals[name], [ir.Constant(INTEGER, 0), place], inbounds=True)
    return Vector(code, code.builder.load(at))
