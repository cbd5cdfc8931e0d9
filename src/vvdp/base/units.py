"""The border: text with a unit to SI and back. Nowhere else does a unit other than SI exist.

`known_units` does the arithmetic of the units that files are written in, pint that of all others. What these would
convert silently and wrongly for this field is refused here: a speed is never a frequency, a gauge level is never a
difference, a bare number never has a unit guessed for it.
"""

import math
import re
from functools import cache, lru_cache
from typing import Any

from vvdp.base.errors import ParameterError
from vvdp.base.kinds import PRESSURE_LEVEL, Kind
from vvdp.base.known_units import conversion, known_unit

ATMOSPHERE = 101325.0
"""Standard atmosphere [Pa]: what a gauge pressure in a file is counted from."""

_NUMBER = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*(.*?)\s*\Z", re.DOTALL)
_ABSOLUTE = {"bara": "bar", "psia": "psi"}
_LEVELS = {"barg": "bar", "psig": "psi", **_ABSOLUTE}
"""Units of pressure levels alone, and what they are without the word for where they count from."""
_OFFSET_UNITS = {"degC": "delta_degC", "degF": "delta_degF"}
# Names, products, quotients, and one small power on a name. Pint alone would calculate `m^9^9^9` for hours.
_UNIT_TEXT = re.compile(r"(?:[^\W\d]|[%°*/()\s1]|(?<=[^\W\d])(?:\^|\*\*)[-+]?\d\d?(?:\.\d+)?)+")


@cache
def _registry() -> Any:
    import pint

    registry: Any = pint.UnitRegistry(autoconvert_offset_to_baseunit=False)
    for definition in ("lpm = liter / minute", "gpm = gallon / minute", "rev = 2 * pi * radian"):
        registry.define(definition)
    return registry


def _unit(text: str) -> Any:
    """Pint's unit for what a user wrote (`mm2` and `m^3/s` as well as `mm**2`)."""
    powers = re.sub(r"(?<=[A-Za-z])(\d)", r"**\1", text)
    if not _UNIT_TEXT.fullmatch(powers):
        raise ValueError(f"{text!r} is not a unit")
    return _registry().parse_units(powers.replace("^", "**"))


def is_unit(text: str) -> bool:
    """Whether the text is the name of a unit, such as `bar` or `m^3/s`."""
    if text in _LEVELS or (len(text) <= 40 and known_unit(text) is not None):
        return True
    try:
        return len(text) <= 40 and bool(_unit(text))
    except Exception:  # pint raises many unrelated types on malformed unit text
        return False


def line_to_si(unit: str, kind: Kind) -> tuple[float, float]:
    """Factor and offset with which numbers in `unit` become SI of `kind`: value = number * factor + offset.

    Gauge and absolute levels as in `parse`; no range is checked. Raises ParameterError.
    """
    text = f"1 {unit}".rstrip()
    return _to_si(1.0, unit, text, kind, level=False), _to_si(0.0, unit, text, kind)


def parse(text: object, kind: Kind) -> float:
    """SI value of `text`, a number with a unit of `kind`, range checked. Pressure levels come out absolute [Pa].

    A plain pressure unit (`bar`, `psi`, `MPa`) on a level is gauge; `bara` and `psia` are absolute.
    Raises ParameterError with what was expected.
    """
    number, unit = _split(text, kind)
    value = _to_si(number, unit, text, kind)
    if not math.isfinite(value):
        raise ParameterError(f"{text!r} = {kind.fault(value)}" if unit else str(kind.fault(value)))
    if not kind.low <= value <= kind.high:
        zero, one = (_to_si(number, unit, text, kind) for number in (0.0, 1.0))
        low, high = (f"{(bound - zero) / (one - zero):.6g}" for bound in (kind.low, kind.high))
        raise ParameterError(f"{text!r} is outside {low} to {high} {unit}".rstrip() + f" for {kind.with_article}")
    return value


def parsed_difference(text: object, kind: Kind) -> float:
    """SI value of `text` as a difference of two values of `kind`: `5 bar` is 5e5 Pa, and `5 degC` is 5 K.

    The plausible range of the kind is one of levels and is not checked. Raises ParameterError.
    """
    number, unit = _split(text, kind)
    value = _to_si(number, unit, text, kind, level=False)
    if not math.isfinite(value):
        raise ParameterError(f"{text!r} is not finite; write for example {kind.example!r}")
    return value


def number_and_unit(text: object) -> tuple[float, str]:
    """The number and the unit of a written value, as they stand. Raises ParameterError."""
    match = _NUMBER.match(text) if isinstance(text, str) and len(text) <= 200 else None
    if not match or not math.isfinite(float(match[1])):
        raise ParameterError(f"{text!r} is not a number with a unit, in quotes")
    return float(match[1]), match[2]


def _split(text: object, kind: Kind) -> tuple[float, str]:
    if isinstance(text, bool) or not isinstance(text, int | float | str):
        raise ParameterError(f"{text!r} is not {kind.with_article}; write for example {kind.example!r}")
    if isinstance(text, str) and len(text) > 200:
        raise ParameterError(
            f"a text of {len(text)} characters is not {kind.with_article}; write for example {kind.example!r}"
        )
    try:
        match = _NUMBER.match(text if isinstance(text, str) else repr(float(text)))
    except OverflowError:
        raise ParameterError(
            f"the number is too large for {kind.with_article}; write for example {kind.example!r}"
        ) from None
    if not match:
        raise ParameterError(f"{text!r} is not a number with a unit; write for example {kind.example!r}")
    return float(match[1]), match[2]


def _to_si(number: float, unit: str, text: object, kind: Kind, level: bool = True) -> float:
    if fault := _fault_of_unit(number, unit, kind):
        raise ParameterError(f"{text!r}{fault}")
    if kind.unit == "SI" or not unit:
        return number
    plain = _LEVELS.get(unit, unit)
    if not level:
        plain = _OFFSET_UNITS.get(plain, plain)
    try:
        value = _in_si(number, plain, kind.unit if kind.unit != "1" else "")
    except _OtherDimension:
        raise ParameterError(f"{text!r} is not {kind.with_article}; write for example {kind.example!r}") from None
    except Exception:  # pint raises many unrelated types on malformed unit text
        raise ParameterError(f"{text!r}: unknown unit {plain!r}; write for example {kind.example!r}") from None
    return value + ATMOSPHERE if level and kind is PRESSURE_LEVEL and unit not in _ABSOLUTE else value


def _fault_of_unit(number: float, unit: str, kind: Kind) -> str:
    """End of a message that refuses a number in `unit` as a value of `kind`; empty if it is accepted."""
    example = f"for example {kind.example!r}"
    if kind.unit == "SI":
        return "" if unit == "SI" else f": write the number with the word SI, {example}"
    if not unit:
        return "" if kind.unit == "1" else f" has no unit; {kind.with_article} is written {example}"
    if unit in _LEVELS and kind is not PRESSURE_LEVEL:
        return f": {kind.with_article} has no {unit!r}; write {example}"
    if kind.units and _LEVELS.get(unit, unit) not in kind.units:
        hint = _speed_hint(number, unit) if "rpm" in kind.units else ""
        return f" is not {kind.with_article}; {hint}use one of {', '.join(kind.units)}"
    # An angle, a decibel or turns per minute times minutes have no dimension either.
    if kind.unit == "1" and unit != "%":
        return f" is not {kind.with_article}; write a plain number or %, {example}"
    return ""


class _OtherDimension(ValueError):
    """A unit is not one of the quantity."""


def _in_si(number: float, unit: str, si: str) -> float:
    try:
        known = conversion(unit, si)
    except ValueError:
        raise _OtherDimension from None
    return _in_si_by_pint(number, unit, si) if known is None else (number * known[0] + known[1]) / known[2]


@lru_cache(maxsize=10_000)
def _in_si_by_pint(number: float, unit: str, si: str) -> float:
    """Kept, since the cases of a study read the same values over and over."""
    import pint

    try:
        return float(_registry().Quantity(number, _unit(unit)).to(si).magnitude)
    except pint.DimensionalityError:
        raise _OtherDimension from None


def _speed_hint(number: float, unit: str) -> str:
    if unit in ("Hz", "1/s"):
        return f"write {number * 60:g} rpm or {number:g} rev/s; "
    return ""


def in_unit(value: float, kind: Kind, unit: str) -> float:
    """`value` [SI of `kind`] expressed in `unit`; a pressure level is not shifted to gauge."""
    if unit in ("", "1"):
        return value
    if (known := conversion(kind.unit, unit)) is not None:
        return (value * known[0] + known[1]) / known[2]
    return float(_registry().Quantity(value, _unit(kind.unit)).to(_unit(unit)).magnitude)
