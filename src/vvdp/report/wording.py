"""How numbers are put into words."""

import math

from vvdp.base.kinds import PRESSURE_LEVEL, TIME, Kind
from vvdp.base.signal import Signal
from vvdp.base.units import ATMOSPHERE, in_unit

MINUS = "\u2212"
UNITS = {
    "cc/rev": "cm³/rev",
    "cc": "cm³",
    "um": "µm",
    "us": "µs",
    "degC": "°C",
    "deg": "°",
    "mm^2": "mm²",
    "m^2": "m²",
    "kg/m^3": "kg/m³",
    "m^3/(s*Pa)": "m³/(s Pa)",
    "Pa*s^2/m^6": "Pa s²/m⁶",
    "N*m": "N m",
    "N*m*s": "N m s",
    "N*s/m": "N s/m",
    "Pa*s": "Pa s",
    "kg*m^2": "kg m²",
    "m^3/s": "m³/s",
    "m^3/rad": "m³/rad",
    "m^2/s": "m²/s",
}


def number(value: float, digits: int = 4) -> str:
    """`value` with `digits` significant digits, without an exponent where people write none."""
    if not math.isfinite(value):
        return "–"
    if value == 0.0:
        return "0"
    size = int(f"{value:.{digits - 1}e}".partition("e")[2])
    if -4 <= size < 6:
        return f"{value:.{max(digits - 1 - size, 0)}f}".replace("-", MINUS)
    mantissa, _, exponent = f"{value:.{digits - 1}e}".partition("e")
    power = str(int(exponent)).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))
    return f"{mantissa}·10{power}".replace("-", MINUS)


def fixed(value: float, decimals: int) -> str:
    """`value` with `decimals` places after the point; a dash where there is none."""
    if not math.isfinite(value):
        return "–"
    text = f"{value:.{decimals}f}"
    return (text.lstrip("-") if float(text) == 0.0 else text).replace("-", MINUS)


def percent(share: float, decimals: int = 1) -> str:
    """A share as percentage."""
    return f"{fixed(100.0 * share, decimals)} %"


def unit_shown(unit: str) -> str:
    """A unit as it is printed."""
    return UNITS.get(unit, unit)


def plain(value: float, digits: int = 6) -> str:
    """A parameter's number as it was written: no trailing zeros."""
    text = number(value, digits)
    mantissa, power, exponent = text.partition("·")
    if "." in mantissa:
        mantissa = mantissa.rstrip("0").rstrip(".")
    return mantissa + power + exponent


def shown(value: float, kind: Kind, *, absolute: bool = False) -> tuple[str, str]:
    """A value [SI] as number and unit; a pressure level is gauge unless `absolute`."""
    if kind is PRESSURE_LEVEL:
        return plain(round((value - (0.0 if absolute else ATMOSPHERE)) / 1e5, 9)), "bar abs." if absolute else "bar"
    if kind is TIME:
        return _time(value)
    if kind.unit in ("1", "SI"):
        return plain(value), "SI" if kind.unit == "SI" else ""
    return plain(in_unit(value, kind, kind.shown)), unit_shown(kind.shown)


def _time(seconds: float) -> tuple[str, str]:
    if seconds == 0.0 or seconds >= 1.0:
        return plain(seconds), "s"
    return (plain(1e3 * seconds), "ms") if seconds >= 1e-3 else (plain(1e6 * seconds), "µs")


def rounded_signal(value: Signal, kind: Kind, digits: int = 4) -> str:
    """A prescribed value as it stands in a drawing: rounded, and with both ends where it changes over time."""
    if value.is_constant:
        return rounded(value.base, kind, digits)
    (a, unit), (b, _) = (_rounded(bound, kind, digits) for bound in value.extremes)
    return f"{a} to {b} {unit}".strip()


def rounded(value: float, kind: Kind, digits: int = 4) -> str:
    """A parameter as it stands in a drawing: rounded, with its unit."""
    return " ".join(_rounded(value, kind, digits)).strip()


def _rounded(value: float, kind: Kind, digits: int) -> tuple[str, str]:
    if kind is PRESSURE_LEVEL:
        return plain(round((value - ATMOSPHERE) / 1e5, 6), digits), "bar"
    if kind.unit in ("1", "SI"):
        return plain(value, digits), ""
    return plain(in_unit(value, kind, kind.shown), digits), unit_shown(kind.shown)
