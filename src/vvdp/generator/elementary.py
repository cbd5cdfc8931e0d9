"""Sine, cosine, inverse sine and ln(1 + x) in the language itself, so that their bits are the same on every machine.

C libraries differ in the last digit of these functions, and WebAssembly has none of them. Only sums and products that
are rounded one by one are needed here, no fused ones. Angles are reduced as by Cody and Waite, Software Manual for the
Elementary Functions (1980), sums are ordered as in Sun's fdlibm (1993), and the series are shortened Taylor series
(`simulation.lane_math.shorten_series`).
"""

import math

import numpy as np

PER_QUARTER = 0.6366197723675814
QUARTERS = (1.5707963109016418, 1.5893254712295857e-08, 6.123233932053594e-17, 6.36831716351095e-25)
"""Quarters in a radian, and a quarter of a turn as a sum: of 26 bits each but the last, so that multiples are exact."""
FAR = 2e8
"""Angles up to which the multiples of `QUARTERS` are exact [rad]; those beyond are left to the C library."""
ROUNDING = 1.5 * 2.0**52
"""Added to a number and taken off again, it leaves the nearest whole one."""
SINE = (
    -0.16666666666666666, 0.00833333333333095, -0.0001984126983675979, 2.7557316103105014e-06,
    -2.5051131947374594e-08, 1.5918135932869774e-10,
)  # fmt: skip
"""Of y^3, y^5 ... in sin(y), up to an eighth of a turn."""
COSINE = (
    0.041666666666666664, -0.0013888888888887398, 2.4801587298766363e-05, -2.7557317272036996e-07,
    2.087614632531677e-09, -1.1382636115964061e-11,
)  # fmt: skip
"""Of y^4, y^6 ... in cos(y)."""
ARCSINE = (
    0.028878362746452394, -0.015032162599250314, 0.01751883397953867, 0.005413184483715509, 0.01033337215296726,
    0.011477517005507167, 0.01397138708310213, 0.017352380709839098, 0.022372173467043486, 0.03038194412500875,
    0.04464285714653523, 0.0749999999999834, 0.16666666666666669,
)  # fmt: skip
"""Of x^27, x^25 ... x^3 in asin(x), up to 1/2."""
HALF_PI, HALF_PI_LOW = 1.5707963267948966, 6.123233995736766e-17
"""A quarter of a turn as a sum of two numbers [rad]."""
SPLIT = 2.0**27 + 1.0
"""A number times this, less what that is above the number, has half of its bits."""


def sine(x: float) -> float:
    """The sine of x [rad], within one unit in the last place."""
    if not abs(x) < FAR:
        return far_sine(x)
    return _shifted_sine(x, 0.0)


def cosine(x: float) -> float:
    """The cosine of x [rad], within one unit in the last place."""
    if not abs(x) < FAR:
        return far_cosine(x)
    return _shifted_sine(x, 1.0)


def far_sine(x: float) -> float:
    """The sine of an angle from `FAR` on, by the C library."""
    return math.sin(x)


def far_cosine(x: float) -> float:
    """The cosine of an angle from `FAR` on, by the C library."""
    return math.cos(x)


def _shifted_sine(x: float, quarters: float) -> float:
    """The sine of an angle and 0 or 1 quarters of a turn."""
    n = (x * PER_QUARTER + ROUNDING) - ROUNDING
    h = (x - n * QUARTERS[0]) - n * QUARTERS[1]
    part = n * QUARTERS[2]
    y = h - part
    low = ((h - y) - part) - n * QUARTERS[3]
    quarter = n + quarters
    quarter = quarter - 4.0 * ((0.25 * quarter + ROUNDING) - ROUNDING)
    z = y * y
    if abs(quarter) == 1.0:
        result = _cosine_near(z, y * low)
        return result if quarter > 0.0 else -result
    result = _sine_near(y, low, z)
    return result if quarter == 0.0 else -result


def _sine_near(y: float, low: float, z: float) -> float:
    """The sine of y + low, up to an eighth of a turn; z is the square of y."""
    a, b, c, d, e, f = SINE
    w, v = z * z, z * y
    rest = (b + z * c) + w * ((d + z * e) + w * f)
    return y - ((z * (0.5 * low - v * rest) - low) - v * a)


def _cosine_near(z: float, turned: float) -> float:
    """The cosine of an angle with the square z, plus a small one of which the product with it is `turned`."""
    a, b, c, d, e, f = COSINE
    w, half = z * z, 0.5 * z
    near = 1.0 - half
    rest = (a + z * b) + w * ((c + z * d) + w * (e + z * f))
    return near + (((1.0 - near) - half) + (w * rest - turned))


def arcsine(x: float) -> float:
    """The angle [rad] with the sine x, within one unit in the last place; not a number outside -1 to 1."""
    size = abs(x)
    if size <= 0.5:
        return x + x * _arcsine_rest(x * x)
    z = 0.5 * (1.0 - size)
    s = np.sqrt(z)
    rest = _arcsine_rest(z)
    scaled = s * SPLIT
    high = scaled - (scaled - s)
    low = (z - high * high) / (s + high) if z > 0.0 else z
    quarter = 0.5 * HALF_PI
    found = quarter - ((2.0 * (s * rest) - (HALF_PI_LOW - 2.0 * low)) - (quarter - 2.0 * high))
    return math.copysign(found, x)


def _arcsine_rest(z: float) -> float:
    """asin(x)/x - 1 of a number with the square z."""
    total = 0.0
    for each in ARCSINE:
        total = total * z + each
    return z * total


def log_of_one_plus(x: float) -> float:
    """ln(1 + x), within two units in the last place, by the logarithm of the C library."""
    u = 1.0 + x
    if u == 1.0 or not abs(x) < math.inf:
        return x if x > -1.0 else u - u
    lost = x - (u - 1.0) if x < 1.0 else 1.0 - (u - x)
    found: float = np.log(u)
    return found + lost / u if u > 0.0 else found
