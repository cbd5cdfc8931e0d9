"""Units that system files are written in, without pint: products and small powers of known names.

Loading pint and its registry takes longer than a short run; it is asked only about units that are not known here.
"""

import math
import re
from fractions import Fraction
from functools import lru_cache
from typing import NamedTuple


class Unit(NamedTuple):
    """A unit: its size in the unit of its dimension in SI, the powers of kg, m, s and K in that, and where its zero is.

    The radian has no dimension.
    """

    size: float
    powers: tuple[Fraction, ...]
    zero: float = 0.0  # of the scale, in SI


def _unit(size: float, *powers: int) -> Unit:
    """One of so many kg, m, s, K."""
    return Unit(size, tuple(map(Fraction, (*powers, 0, 0, 0, 0)[:4])))


_ONE = _unit(1.0)
_INCH, _POUND_FORCE = 0.0254, 0.45359237 * 9.80665
# Small lengths to a power, as pint has it: so both give the same bits for what files are mostly written in.
_LITRE, _STOKES = 0.1**3, 0.01**2
_PREFIXED = {
    "g": _unit(1e-3, 1),
    "m": _unit(1.0, 0, 1),
    "s": _unit(1.0, 0, 0, 1),
    "K": _unit(1.0, 0, 0, 0, 1),
    "N": _unit(1.0, 1, 1, -2),
    "Pa": _unit(1.0, 1, -1, -2),
    "bar": _unit(1e5, 1, -1, -2),
    "J": _unit(1.0, 1, 2, -2),
    "W": _unit(1.0, 1, 2, -3),
    "Hz": _unit(1.0, 0, 0, -1),
    "l": _unit(_LITRE, 0, 3),
    "L": _unit(_LITRE, 0, 3),
    "St": _unit(_STOKES, 0, 2, -1),
    "P": _unit(0.1, 1, -1, -1),
    "rad": _unit(1.0),
}
_PREFIXES = {"": 1.0, "n": 1e-9, "u": 1e-6, "µ": 1e-6, "m": 1e-3, "c": 1e-2, "k": 1e3, "M": 1e6, "G": 1e9}
_PLAIN = {
    "min": _unit(60.0, 0, 0, 1),
    "h": _unit(3600.0, 0, 0, 1),
    "lpm": _unit(_LITRE / 60.0, 0, 3, -1),
    "gpm": _unit(231.0 * _INCH**3 / 60.0, 0, 3, -1),
    "cc": _unit(0.01**3, 0, 3),
    "in": _unit(_INCH, 0, 1),
    "ft": _unit(12.0 * _INCH, 0, 1),
    "psi": _unit(_POUND_FORCE / _INCH**2, 1, -1, -2),
    "lbf": _unit(_POUND_FORCE, 1, 1, -2),
    "deg": _unit(math.pi / 180.0),
    "rev": _unit(2.0 * math.pi),
    "rpm": _unit(2.0 * math.pi / 60.0, 0, 0, -1),
    "delta_degC": _unit(1.0, 0, 0, 0, 1),
    "delta_degF": _unit(5.0 / 9.0, 0, 0, 0, 1),
    "%": _unit(0.01),
}
KNOWN = {
    prefix + name: Unit(factor * unit.size, unit.powers)
    for prefix, factor in _PREFIXES.items()
    for name, unit in _PREFIXED.items()
} | _PLAIN
"""Units by name, those with prefixes too. Where a prefix and a name spell another unit (`min`), that one counts."""
SCALES = {
    "degC": Unit(1.0, KNOWN["K"].powers, 273.15),
    "degF": Unit(5.0 / 9.0, KNOWN["K"].powers, 459.67 * 5.0 / 9.0),
}
"""Units whose zero is not that of SI: they stand alone."""
_TOKEN = re.compile(
    r"(?P<name>[^\W\d_]+(?:_[^\W\d_]+)?)(?:(?:\^|\*\*)(?P<power>[-+]?\d\d?(?:\.\d+)?)|(?P<digit>\d))?|(?P<sign>[*/()%1])"
)
LONGEST = 60
"""Characters of a text that is looked at."""


@lru_cache(maxsize=10_000)
def known_unit(text: str) -> Unit | None:
    """The unit of a text such as `m^3/s`; None where it is not made of known ones, or not well formed."""
    if text in SCALES:
        return SCALES[text]
    tokens, place = list[re.Match[str]](), 0
    while place < len(text):
        match = _TOKEN.match(text, place)
        if match is None or place > LONGEST:
            return None
        tokens.append(match)
        place = match.end()
    tokens.reverse()
    try:
        found = _product(tokens)
    except OverflowError:
        return None
    return None if tokens else found


def _product(tokens: list[re.Match[str]]) -> Unit | None:
    """The product of the last `tokens`, in reverse order, which are taken off; None where there is none."""
    found = _factor(tokens)
    while found is not None and tokens and tokens[-1]["sign"] in ("*", "/"):
        power = Fraction(1 if tokens.pop()["sign"] == "*" else -1)
        factor = _factor(tokens)
        found = None if factor is None else _times(found, _power(factor, power))
    return found


def _factor(tokens: list[re.Match[str]]) -> Unit | None:
    if not tokens:
        return None
    token = tokens.pop()
    if token["sign"] == "1":
        return _ONE
    if token["sign"] == "(":
        inner = _product(tokens)
        return inner if tokens and tokens.pop()["sign"] == ")" else None
    unit = KNOWN.get(token["name"] or token["sign"])
    return None if unit is None else _power(unit, Fraction(token["power"] or token["digit"] or 1))


def _times(one: Unit, other: Unit) -> Unit:
    powers = tuple(a + b for a, b in zip(one.powers, other.powers, strict=True))
    return Unit(one.size * other.size, powers)


def _power(unit: Unit, power: Fraction) -> Unit:
    return Unit(unit.size ** float(power), tuple(each * power for each in unit.powers))


@lru_cache(maxsize=10_000)
def conversion(unit: str, other: str) -> tuple[float, float, float] | None:
    """Numbers a, b, c such that a value x in `unit` is (x a + b) / c in `other`; None where a unit is not known.

    Without a name a unit is 1. Raises ValueError where the two are of different dimensions.
    """
    one, two = known_unit(unit), known_unit(other) if other else _ONE
    if one is None or two is None:
        return None
    if one.powers != two.powers:
        raise ValueError(f"{unit} is not {other}")
    if one.zero == two.zero:
        return one.size / two.size, 0.0, 1.0
    return one.size, one.zero - two.zero, two.size
