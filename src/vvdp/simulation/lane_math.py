"""Powers, exponentials, logarithms and sines of vectors, within two units in the last place of the exact value.

Arguments are reduced exactly or to twice the digits, and what remains is small enough for a short series. Powers lose
more digits far from 1: four units at e^100, twenty at e^700. Zeros come out without their sign.
"""

import math
from collections.abc import Callable
from decimal import Decimal, localcontext
from fractions import Fraction
from math import factorial

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


def shorten_series(series: list[Fraction], terms: int, low: Fraction, high: Fraction) -> list[float]:
    """`sum(c[i] x^i)` with so many terms, next to the best between `low` and `high`.

    Each highest term is replaced by what the Chebyshev polynomial of its degree leaves of it.
    """
    slope, shift = 2 / (high - low), -(high + low) / (high - low)
    cosines = [[Fraction(1)], [shift, slope]]
    while len(cosines) < len(series):
        ahead = [2 * shift * c for c in cosines[-1]] + [Fraction(0)]
        for i, c in enumerate(cosines[-1]):
            ahead[i + 1] += 2 * slope * c
        for i, c in enumerate(cosines[-2]):
            ahead[i] -= c
        cosines.append(ahead)
    while len(series) > terms:
        top = series[-1] / cosines[len(series) - 1][-1]
        series = [c - top * d for c, d in zip(series, cosines[len(series) - 1], strict=True)][:-1]
    return [float(c) for c in series]


LN2_HIGH, LN2_LOW = parts(LN2, 2, SHORT)
PER_LN2 = parts(2 / LN2, 2, WHOLE)
EIGHTH = Fraction(HALF_PI / 2) ** 2
"""The square of an eighth of a turn [rad2]."""
SPREAD = Fraction(1, 33)
"""Above ((m - 1)/(m + 1))^2 for all m between the roots of 1/2 and 2."""
EXP_SERIES = shorten_series([Fraction(1, factorial(i + 2)) for i in range(16)], 11, -Fraction(7, 20), Fraction(7, 20))
EXP2_SERIES = shorten_series(
    [Fraction(LN2) ** i / factorial(i) for i in range(1, 18)], 12, -Fraction(1, 2), Fraction(1, 2)
)
LOG_SERIES = shorten_series([Fraction(2, 2 * i + 3) for i in range(16)], 8, Fraction(0), SPREAD)
ATANH_SERIES = shorten_series([Fraction(1, 2 * i + 3) for i in range(16)], 8, Fraction(0), SPREAD)
SIN_SERIES = shorten_series(
    [Fraction((-1) ** (i + 1), factorial(2 * i + 3)) for i in range(10)], 7, Fraction(0), EIGHTH
)
COS_SERIES = shorten_series([Fraction((-1) ** i, factorial(2 * i)) for i in range(11)], 8, Fraction(0), EIGHTH)
FAR = {True: 1e9, False: 1e5}
"""Angles up to which a sine's reduction is exact enough, with a fused product and without [rad]."""
HUGE = 2.0**900
"""An exponent of which the halves can still be scaled; all above give 0, 1 or infinity."""
ONE = int(np.float64(1.0).view(np.int64))
ROOT_HALF = int(np.float64(math.sqrt(0.5)).view(np.int64))
ROUNDING_BITS = int(np.float64(ROUNDING).view(np.int64))


def power(code: Code, x: Vector, y: Vector) -> Vector:
    """`x ** y` as pow(x, y) of the C library has it."""
    high, low = _log2(code, *_split(code, x))
    e, rest = code.product(y, high)
    result = _exp2(code, e, code.multiply_add(y, low, rest), _scale_in_range)
    usual = (x > 2.0**-1022) & (x < math.inf) & (abs(e) < 1000.0) & (abs(y) < HUGE)
    is_zero = x.equals(0.0) & (y > 0.0)  # as often as a port is closed
    with code.where_any(~(usual | is_zero), is_zero.select(0.0, result)) as held:
        held[0] = _any_power(code, x, y)
    return held[0]


def _any_power(code: Code, x: Vector, y: Vector) -> Vector:
    """The same for numbers of every kind, and results out of range."""
    size, floor = abs(x), code.call("floor", y)
    high, low = _log2(code, *_split_tiny(code, size))
    e, rest = code.product(y, high)
    rest = (abs(e) < 1100.0).select(rest + y * low, 0.0)
    result = _exp2(code, _between(e, -1100.0, 1100.0), rest, _scale_in_two_steps)
    grows = (size.equals(math.inf) & (y > 0.0)) | (size.equals(0.0) & (y < 0.0))
    result = (size.equals(math.inf) | size.equals(0.0)).select(grows.select(math.inf, 0.0), result)
    half = 0.5 * y
    is_odd = floor.equals(y) & ~code.call("floor", half).equals(half)
    result = (is_odd & (code.call("copysign", 1.0, x) < 0.0)).select(-result, result)
    result = ((x < 0.0) & ~floor.equals(y) & ~size.equals(math.inf)).select(math.nan, result)
    result = (x.equals(x) & y.equals(y)).select(result, math.nan)
    is_one = y.equals(0.0) | x.equals(1.0) | (size.equals(1.0) & (abs(y) > 0.5 * HUGE))
    return is_one.select(1.0, result)


def _log2(code: Code, k: Vector, m: Vector) -> tuple[Vector, Vector]:
    """The binary logarithm of 2^k m, as a sum of two. Little has to wait for the series, which takes longest."""
    f = m - 1.0
    g = m + 1.0
    s = f / g
    p, lost = code.product(s, g)
    s_low = (((f - p) - lost) - s * (f - (g - 2.0))) / g
    z, z_low = code.product(s, s)
    high, low = code.product(s, code.vector(PER_LN2[0]))
    rough = k + high
    small = low + (s * PER_LN2[1] + s_low * PER_LN2[0]) + high * z_low * (1.0 / 3.0)
    low = code.multiply_add(high * z, code.polynomial(z, ATANH_SERIES), ((k - rough) + high) + small)
    total = rough + low
    return total, low - (total - rough)


def _exp2(code: Code, e: Vector, rest: Vector, scaled: Callable[[Code, Vector, Vector], Vector]) -> Vector:
    """2 to the power of a sum of two."""
    shifted = e + ROUNDING
    r = (e - (shifted - ROUNDING)) + rest
    return scaled(code, code.multiply_add(r, code.polynomial(r, EXP2_SERIES), 1.0), shifted)


def exp(code: Code, x: Vector) -> Vector:
    """e to the power of x."""
    p, shifted = _exp_rest(code, _between(x, -750.0, 750.0))
    return _scale_in_two_steps(code, 1.0 + p, shifted)


def expm1(code: Code, x: Vector) -> Vector:
    """e to the power of x, less 1, without cancellation close to zero."""
    p, shifted = _exp_rest(code, _between(x, -50.0, 750.0))
    n = shifted - ROUNDING
    inverse = _power_of_2(code, ROUNDING - _between(n, -100.0, 100.0))
    return _scale_in_two_steps(code, p + (1.0 - inverse), shifted)


def _exp_rest(code: Code, x: Vector) -> tuple[Vector, Vector]:
    """With x = n ln 2 + r: e^r - 1, and n plus `ROUNDING`."""
    shifted = code.multiply_add(x, float(1 / LN2), ROUNDING)
    n = shifted - ROUNDING
    r = code.multiply_add(-n, LN2_LOW, code.multiply_add(-n, LN2_HIGH, x))
    return code.multiply_add(r * r, code.polynomial(r, EXP_SERIES), r), shifted


def log(code: Code, x: Vector) -> Vector:
    """The natural logarithm; NaN below zero."""
    k, m = _split_tiny(code, x)
    return _log_ends(_log_sum(code, k, m - 1.0), x, x)


def log1p(code: Code, x: Vector) -> Vector:
    """ln(1 + x), without cancellation close to zero."""
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
    """The sine of x [rad]."""
    return _with_far(code, "sin", x, _sine_of_quarters(code, x, 0))


def cos(code: Code, x: Vector) -> Vector:
    """The cosine of x [rad]."""
    return _with_far(code, "cos", x, _sine_of_quarters(code, x, 1))


def tan(code: Code, x: Vector) -> Vector:
    """The tangent of x [rad]."""
    return _with_far(code, "tan", x, _sine_of_quarters(code, x, 0) / _sine_of_quarters(code, x, 1))


def _with_far(code: Code, name: str, x: Vector, near: Vector) -> Vector:
    """The result for angles `near` zero, and that of the C library's function `name` for those far away."""
    with code.where_any(~(abs(x) < FAR[code.fused]), near) as held:
        held[0] = code.scalar(name, x)
    return held[0]


def _sine_of_quarters(code: Code, x: Vector, quarters: int) -> Vector:
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
    """The hyperbolic tangent."""
    e = expm1(code, -2.0 * abs(x))
    return code.call("copysign", e / (e + 2.0), x)


def atan(code: Code, x: Vector) -> Vector:
    """The angle [rad] with the tangent x; each lane by the C library."""
    return code.scalar("atan", x)


def _between(x: Vector, low: float, high: float) -> Vector:
    """`x` held between two numbers; NaN stays."""
    x = (x < low).select(low, x)
    return (x > high).select(high, x)


def _split(code: Code, x: Vector) -> tuple[Vector, Vector]:
    """k and m with x = 2^k m, m between the roots of 1/2 and 2, of a number above 2^-1022."""
    build, bits = code.builder, x.bits
    exponent = build.ashr(build.sub(bits, code.whole(ROOT_HALF)), code.whole(52))
    m = code.floats(build.sub(bits, build.shl(exponent, code.whole(52))))
    return code.floats(build.add(exponent, code.whole(ROUNDING_BITS))) - ROUNDING, m


def _split_tiny(code: Code, x: Vector) -> tuple[Vector, Vector]:
    """The same of any number above zero."""
    is_tiny = x < 2.0**-1022
    k, m = _split(code, is_tiny.select(x * 2.0**54, x))
    return k - is_tiny.select(54.0, 0.0), m


def _power_of_2(code: Code, shifted: Vector) -> Vector:
    """2^n of n plus `ROUNDING`, n above -1023 and below 1024."""
    build = code.builder
    return code.floats(build.add(build.shl(shifted.bits, code.whole(52)), code.whole(ONE)))


def _scale_in_range(code: Code, x: Vector, shifted: Vector) -> Vector:
    """x 2^n of n plus `ROUNDING`, where that is in range: the exponent moved."""
    build = code.builder
    return code.floats(build.add(x.bits, build.shl(shifted.bits, code.whole(52))))


def _scale_in_two_steps(code: Code, x: Vector, shifted: Vector) -> Vector:
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
"""Code of each operation that no processor has."""
