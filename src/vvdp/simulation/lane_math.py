"""Powers, exponentials, logarithms and sines of vectors, within two units in the last place of the exact value.

Arguments are reduced exactly or to twice the digits, and what remains is small enough for a Taylor series. Powers lose
more digits far from 1: four units at e^100, twenty at e^700. Zeros come out without their sign.
"""

import math
from collections.abc import Callable
from decimal import Decimal, localcontext

import numpy as np

from vvdp.simulation.lane_values import ROUNDING, Code, Mask, Vector
from vvdp.simulation.symbols import Op

LN2 = Decimal("0.6931471805599453094172321214581765680755001343602552541206800095")
HALF_PI = Decimal("1.5707963267948966192313216916397514420985846996875529104874722962")
WHOLE, SHORT = 53, 32
"""Bits of a number, and so few of one that its product with an exponent is exact."""


def parts(value: Decimal, count: int, bits: int) -> list[float]:
    """Numbers of so many bits each whose sum is `value`."""
    found: list[float] = []
    with localcontext(prec=80):
        for _ in range(count):
            fraction, exponent = math.frexp(float(value))
            found.append(math.ldexp(math.trunc(math.ldexp(fraction, bits)), exponent - bits))
            value -= Decimal(found[-1])
    return found


LN2_HIGH, LN2_LOW = parts(LN2, 2, SHORT)
PER_LN2 = parts(2 / LN2, 2, WHOLE)
EXP_SERIES = [1.0 / math.factorial(i + 2) for i in range(12)]
EXP2_SERIES = [float(LN2**i) / math.factorial(i) for i in range(1, 15)]
LOG_SERIES = [2.0 / (2 * i + 3) for i in range(11)]
ATANH_SERIES = [1.0 / (2 * i + 3) for i in range(12)]
SIN_SERIES = [(-1.0) ** (i + 1) / math.factorial(2 * i + 3) for i in range(8)]
COS_SERIES = [(-1.0) ** i / math.factorial(2 * i) for i in range(9)]
FAR = {True: 1e9, False: 1e5}
"""Angles up to which a sine's reduction is exact enough, with a fused product and without [rad]."""
HUGE = 2.0**900
"""An exponent of which the halves can still be scaled; all above give 0, 1 or infinity."""
ONE = int(np.float64(1.0).view(np.int64))
ROOT_HALF = int(np.float64(math.sqrt(0.5)).view(np.int64))
ROUNDING_BITS = int(np.float64(ROUNDING).view(np.int64))


def power(code: Code, x: Vector, y: Vector) -> Vector:
    """`x ** y` as pow(x, y) of the C library has it."""
    size = abs(x)
    high, low = _log2(code, size)
    e, rest = code.product(y, high)
    inside = abs(e) < 1100.0
    result = _exp2(code, _between(e, -1100.0, 1100.0), inside.select(rest + y * low, 0.0))
    usual = (x > 0.0) & (x < math.inf) & (abs(y) < HUGE)
    with code.where_any(~usual, result) as held:
        held[0] = _odd_power(code, x, y, result)
    return held[0]


def _odd_power(code: Code, x: Vector, y: Vector, result: Vector) -> Vector:
    """A power of which the base is zero, negative, infinite or no number, or the exponent is no finite number."""
    size, floor = abs(x), code.call("floor", y)
    grows = (size.equals(math.inf) & (y > 0.0)) | (size.equals(0.0) & (y < 0.0))
    result = (size.equals(math.inf) | size.equals(0.0)).select(grows.select(math.inf, 0.0), result)
    half = 0.5 * y
    is_odd = floor.equals(y) & ~code.call("floor", half).equals(half)
    sign = code.call("copysign", 1.0, x)
    result = (is_odd & (sign < 0.0)).select(-result, result)
    result = ((x < 0.0) & ~floor.equals(y) & ~size.equals(math.inf)).select(math.nan, result)
    result = (x.equals(x) & y.equals(y)).select(result, math.nan)
    is_one = y.equals(0.0) | x.equals(1.0) | (size.equals(1.0) & (abs(y) > 0.5 * HUGE))
    return is_one.select(1.0, result)


def _log2(code: Code, x: Vector) -> tuple[Vector, Vector]:
    """The binary logarithm of a number above zero, as a sum of two."""
    k, m = _split(code, x)
    f = m - 1.0
    g = f + 2.0
    inverse = 1.0 / g
    s = f * inverse
    p, lost = code.product(s, g)
    s_low = inverse * (((f - p) - lost) - s * (f - (g - 2.0)))
    z, z_low = code.product(s, s)
    series = z * code.polynomial(z, ATANH_SERIES) + z_low * (1.0 / 3.0)
    u = s * series + s_low
    high, low = code.product(s, code.vector(PER_LN2[0]))
    low = low + (u * PER_LN2[0] + s * PER_LN2[1])
    rough = k + high
    low = ((k - rough) + high) + low
    total = rough + low
    return total, low - (total - rough)


def _exp2(code: Code, e: Vector, rest: Vector) -> Vector:
    """2 to the power of a sum of two."""
    shifted = e + ROUNDING
    r = (e - (shifted - ROUNDING)) + rest
    return _scaled(code, 1.0 + r * code.polynomial(r, EXP2_SERIES), shifted)


def exp(code: Code, x: Vector) -> Vector:
    p, shifted = _exp_rest(code, _between(x, -750.0, 750.0))
    return _scaled(code, 1.0 + p, shifted)


def expm1(code: Code, x: Vector) -> Vector:
    p, shifted = _exp_rest(code, _between(x, -50.0, 750.0))
    n = shifted - ROUNDING
    inverse = _power_of_2(code, ROUNDING - _between(n, -100.0, 100.0))
    return _scaled(code, p + (1.0 - inverse), shifted)


def _exp_rest(code: Code, x: Vector) -> tuple[Vector, Vector]:
    """With x = n ln 2 + r: e^r - 1, and n plus `ROUNDING`."""
    shifted = code.multiply_add(x, float(1 / LN2), ROUNDING)
    n = shifted - ROUNDING
    r = code.multiply_add(-n, LN2_LOW, code.multiply_add(-n, LN2_HIGH, x))
    return code.multiply_add(r * r, code.polynomial(r, EXP_SERIES), r), shifted


def log(code: Code, x: Vector) -> Vector:
    k, m = _split(code, x)
    return _log_ends(_log_sum(code, k, m - 1.0), x, x)


def log1p(code: Code, x: Vector) -> Vector:
    u = x + 1.0
    back = u - 1.0
    lost = (1.0 - (u - back)) + (x - back)
    k, m = _split(code, u)
    rest = lost * _power_of_2(code, ROUNDING - _between(k, -100.0, 100.0))
    return _log_ends(_log_sum(code, k, (m - 1.0) + rest), u, x)


def _log_sum(code: Code, k: Vector, f: Vector) -> Vector:
    """k ln 2 + ln(1 + f)"""
    s = f / (f + 2.0)
    z, half = s * s, 0.5 * f * f
    tail = code.multiply_add(s, half + z * code.polynomial(z, LOG_SERIES), k * LN2_LOW)
    return k * LN2_HIGH - ((half - tail) - f)


def _log_ends(result: Vector, argument: Vector, given: Vector) -> Vector:
    """The logarithm of all numbers, where `result` is that of those above zero."""
    result = (argument > 0.0).select(result, argument.equals(0.0).select(-math.inf, math.nan))
    return (given < math.inf).select(result, (argument > 0.0).select(given, math.nan))


def sin(code: Code, x: Vector) -> Vector:
    return _with_far(code, "sin", x, _turned(code, x, 0))


def cos(code: Code, x: Vector) -> Vector:
    return _with_far(code, "cos", x, _turned(code, x, 1))


def tan(code: Code, x: Vector) -> Vector:
    return _with_far(code, "tan", x, _turned(code, x, 0) / _turned(code, x, 1))


def _with_far(code: Code, name: str, x: Vector, near: Vector) -> Vector:
    """The result for angles `near` zero, and that of the C library's function `name` for those far away."""
    with code.where_any(~(abs(x) < FAR[code.fused]), near) as held:
        held[0] = code.scalar(name, x)
    return held[0]


def _turned(code: Code, x: Vector, quarters: int) -> Vector:
    """The sine of an angle and so many quarters of a turn."""
    shifted = code.multiply_add(x, float(1 / HALF_PI), ROUNDING)
    n, r = shifted - ROUNDING, x
    for part in parts(HALF_PI, 3, WHOLE) if code.fused else parts(HALF_PI, 4, SHORT):
        r = code.multiply_add(-n, part, r)
    z, build = r * r, code.builder
    odd = code.multiply_add(r * z, code.polynomial(z, SIN_SERIES), r)
    even = code.polynomial(z, COS_SERIES)
    quarter = build.add(shifted.bits, code.whole(quarters))
    is_even = Mask(code, build.icmp_unsigned("!=", build.and_(quarter, code.whole(1)), code.whole(0)))
    sign = build.shl(build.and_(quarter, code.whole(2)), code.whole(62))
    return code.floats(build.xor(is_even.select(even, odd).bits, sign))


def tanh(code: Code, x: Vector) -> Vector:
    e = expm1(code, -2.0 * abs(x))
    return code.call("copysign", e / (e + 2.0), x)


def atan(code: Code, x: Vector) -> Vector:
    return code.scalar("atan", x)


def _between(x: Vector, low: float, high: float) -> Vector:
    """`x` held between two numbers; NaN stays."""
    x = (x < low).select(low, x)
    return (x > high).select(high, x)


def _split(code: Code, x: Vector) -> tuple[Vector, Vector]:
    """k and m with x = 2^k m, m between the roots of 1/2 and 2, of a number above zero."""
    is_tiny = x < 2.0**-1022
    bits = is_tiny.select(x * 2.0**54, x).bits
    build = code.builder
    exponent = build.ashr(build.sub(bits, code.whole(ROOT_HALF)), code.whole(52))
    m = code.floats(build.sub(bits, build.shl(exponent, code.whole(52))))
    k = code.floats(build.add(exponent, code.whole(ROUNDING_BITS))) - is_tiny.select(ROUNDING + 54.0, ROUNDING)
    return k, m


def _power_of_2(code: Code, shifted: Vector) -> Vector:
    """2^n of n plus `ROUNDING`, n above -1023 and below 1024."""
    build = code.builder
    return code.floats(build.add(build.shl(shifted.bits, code.whole(52)), code.whole(ONE)))


def _scaled(code: Code, x: Vector, shifted: Vector) -> Vector:
    """x 2^n of n plus `ROUNDING`, in two steps, since 2^n itself may be out of range."""
    build = code.builder
    n = build.sub(shifted.bits, code.whole(ROUNDING_BITS))
    half = build.ashr(n, code.whole(1))
    for part in (half, build.sub(n, half)):
        x = x * code.floats(build.add(build.shl(part, code.whole(52)), code.whole(ONE)))
    return x


FUNCTIONS: dict[Op, Callable[..., Vector]] = {
    Op.POWER: power,
    Op.EXP: exp,
    Op.EXPM1: expm1,
    Op.LOG: log,
    Op.LOG1P: log1p,
    Op.SIN: sin,
    Op.COS: cos,
    Op.TAN: tan,
    Op.TANH: tanh,
    Op.ATAN: atan,
}
"""What each operation that no processor has is made of."""
