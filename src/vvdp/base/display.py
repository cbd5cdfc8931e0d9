"""How a value is shown to a user: its unit, its digits, its words. Bar, lpm, rpm and degC are known here alone.

Inside the package every value is SI and every pressure level absolute; files are read by `units`. What leaves for a
screen, a page or a figure passes through this module, so that a quantity looks the same wherever it is met.
"""

import math
from functools import cache
from typing import Any, NamedTuple

from vvdp.base import kinds
from vvdp.base.kinds import Kind
from vvdp.base.signal import Signal
from vvdp.base.units import ATMOSPHERE, in_unit

_BAR = 1e5
MINUS = "\u2212"
NOTHING = "–"
SYMBOLS = {
    "um": "µm",
    "us": "µs",
    "degC": "°C",
    "deg": "°",
    "cc": "cm³",
    "cc/rev": "cm³/rev",
    "l/min": "lpm",
    "lpm/bar^0.5": "lpm/√bar",
}
_RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def unit_symbol(unit: str) -> str:
    """A unit as it is printed: `mm^2` as mm², `N*m` as N m."""
    if unit in SYMBOLS:
        return SYMBOLS[unit]
    base, *powers = unit.replace("*", " ").split("^")
    for power in powers:
        digits = power[: len(power) - len(power.lstrip("-0123456789"))]
        base += digits.translate(_RAISED) + power[len(digits) :] if "." not in power[:3] else f"^{power}"
    return "" if base in ("1", "SI") else base


class DisplayUnit(NamedTuple):
    """The unit in which values of a kind are shown: shown = (SI - datum) / scale."""

    symbol: str
    scale: float
    datum: float

    def from_si(self, value: Any) -> Any:
        """A value or an array [SI] as number in this unit."""
        return (value - self.datum) / self.scale

    @property
    def bracketed_symbol(self) -> str:
        """The symbol as it stands behind a label; nothing where there is no unit."""
        return f" [{self.symbol}]" if self.symbol else ""


@cache
def display_unit(kind: Kind) -> DisplayUnit:
    """The unit in which a column, an axis or a number of a kind is shown. A pressure level is gauge."""
    if kind.name == kinds.PRESSURE_LEVEL.name:
        return DisplayUnit("bar", _BAR, ATMOSPHERE)
    if kind.display_unit == "%":
        return DisplayUnit("%", 0.01, 0.0)
    if kind.unit in ("1", "SI"):
        return DisplayUnit("", 1.0, 0.0)
    zero, one = (in_unit(value, kind, kind.display_unit) for value in (0.0, 1.0))
    scale = 1.0 / (one - zero)
    return DisplayUnit(unit_symbol(kind.display_unit), float(f"{scale:.15g}"), 0.0 - float(f"{zero * scale:.15g}"))


def number(value: float, digits: int = 4) -> str:
    """`value` with `digits` significant digits, no exponent where people write none; a dash where not finite."""
    if not math.isfinite(value):
        return NOTHING
    if value == 0.0:
        return "0"
    size = int(f"{value:.{digits - 1}e}".partition("e")[2])
    if -4 <= size < 6:
        return f"{value:.{max(digits - 1 - size, 0)}f}".replace("-", MINUS)
    mantissa, _, exponent = f"{value:.{digits - 1}e}".partition("e")
    return f"{mantissa}·10{str(int(exponent)).translate(_RAISED)}".replace("-", MINUS)


def fixed_point(value: float, decimals: int) -> str:
    """`value` with `decimals` places after the point; a dash where not finite."""
    if not math.isfinite(value):
        return NOTHING
    text = f"{value:.{decimals}f}"
    return (text.lstrip("-") if float(text) == 0.0 else text).replace("-", MINUS)


def long_time(seconds: float) -> str:
    """A waiting time, in words."""
    for size, unit in ((86400.0, "days"), (3600.0, "h"), (60.0, "min")):
        if seconds >= 2.0 * size:
            return f"{seconds / size:.3g} {unit}"
    return f"{seconds:.0f} s"


def percent(share: float, decimals: int = 1) -> str:
    """A share as percentage."""
    return f"{fixed_point(100.0 * share, decimals)} %"


def plain(value: float, digits: int = 6) -> str:
    """A number as people write it: no trailing zeros."""
    text = number(value, digits)
    mantissa, power, exponent = text.partition("·")
    if "." in mantissa:
        mantissa = mantissa.rstrip("0").rstrip(".")
    return mantissa + power + exponent


def value_and_unit(value: float, kind: Kind, *, digits: int = 6, absolute: bool = False) -> tuple[str, str]:
    """A value [SI] as number and unit; a pressure level is gauge unless `absolute`, a time in s, ms or µs."""
    if kind.name == kinds.PRESSURE_LEVEL.name and absolute:
        return plain(round(value / _BAR, 9), digits), "bar abs."
    if kind is kinds.TIME and value != 0.0 and value < 1.0:
        return (plain(1e3 * value, digits), "ms") if value >= 1e-3 else (plain(1e6 * value, digits), "µs")
    if kind is kinds.TIME:
        return plain(value, digits), "s"
    unit = display_unit(kind)
    return plain(round(unit.from_si(value), 9) if unit.datum else unit.from_si(value), digits), unit.symbol


def with_unit(value: float, kind: Kind, digits: int = 4) -> str:
    """A value [SI] with its unit, as in a sentence."""
    return " ".join(value_and_unit(value, kind, digits=digits)).strip()


def signal_with_unit(value: Signal, kind: Kind, digits: int = 4) -> str:
    """A prescribed value with its unit, and with both ends where it changes over time."""
    if value.is_constant:
        return with_unit(value.base, kind, digits)
    (low, unit), (high, _) = (value_and_unit(bound, kind, digits=digits) for bound in value.extremes)
    return f"{low} to {high} {unit}".strip()


def readable(name: str) -> str:
    """The name of a file, or an argument, as text; bytes of it that are not UTF-8 as backslash escapes."""
    return name.encode("utf-8", "surrogateescape").decode("utf-8", "backslashreplace")


def value_text(value: float, kind: Kind) -> str:
    """A value [SI] with its unit as in a message; a pressure level both gauge and absolute."""
    if kind.name == kinds.PRESSURE_LEVEL.name:
        return f"{(value - ATMOSPHERE) / _BAR:.6g} bar ({value / _BAR:.6g} bara)"
    if kind.unit in ("1", "SI"):
        return f"{value:.6g}" + (" SI" if kind.unit == "SI" else "")
    return f"{in_unit(value, kind, kind.display_unit):.6g} {kind.display_unit}"


def key_suffix(kind: Kind) -> str:
    """The end of a key of a result that makes its unit plain: `_m3_s` for m^3/s; nothing without a unit."""
    if kind.unit in ("1", "SI"):
        return ""
    return "_" + kind.unit.translate(str.maketrans("/*", "__", "^()."))
