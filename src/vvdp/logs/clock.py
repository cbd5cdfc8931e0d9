"""Clocks: which channel of a file is the time, in what unit, and how it becomes seconds."""

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.errors import ConfigError, ParameterError, unusable
from vvdp.base.kinds import FREQUENCY
from vvdp.base.rules import require_positive_value
from vvdp.base.units import is_unit

# Factor and divisor apart: 5 ms is 5 / 1000, rounded once, and not 5 * 0.001.
_SECONDS = {
    **dict.fromkeys(("s", "sec", "secs", "second", "seconds", "Sekunden"), (1.0, 1.0)),
    **dict.fromkeys(("ms", "msec", "millisecond", "milliseconds"), (1.0, 1e3)),
    **dict.fromkeys(("us", "µs", "μs", "usec", "microsecond", "microseconds"), (1.0, 1e6)),
    **dict.fromkeys(("ns", "nsec", "nanosecond", "nanoseconds"), (1.0, 1e9)),
    **dict.fromkeys(("min", "minute", "minutes"), (60.0, 1.0)),
    **dict.fromkeys(("h", "hour", "hours"), (3600.0, 1.0)),
}
_TIME_NAMES = frozenset(
    ("t", "time", "times", "timestamp", "timestamps", "datetime", "date time", "date_time", "elapsed", "elapsed time",
     "elapsed_time", "x_value", "zeit", "zeitstempel", "uhrzeit", "temps", "tiempo")
)  # fmt: skip
_WITH_SUFFIX = re.compile(r"(.+)_(s|ms|us|ns|min)", re.IGNORECASE)
_BRACKETED = re.compile(r"(.*\S)\s*\[([^\[\]]*)\]", re.DOTALL)
_IN_PARENTHESES = re.compile(r"(.*\S)\s*\(([^()]*)\)", re.DOTALL)
_SINCE = re.compile(r"(\w+) since .+", re.DOTALL)


@dataclass(frozen=True)
class ClockChoice:
    """Options of the user for the clock: its channel, or a sample rate [Hz] instead; the unit if the file has none."""

    time: str | None = None
    rate: float | None = None
    unit: str | None = None

    def check(self) -> None:
        """Raises ParameterError for a choice that contradicts itself."""
        if self.rate is not None:
            require_positive_value("sample rate", self.rate, FREQUENCY)
            if self.time is not None:
                raise ParameterError(f"both a time channel ({self.time!r}) and a sample rate ({self.rate:g} Hz)")
        if self.unit is not None and self.unit not in _SECONDS:
            raise ParameterError(f"time unit {self.unit!r}; use one of {', '.join(_SECONDS)}")

    def refuse_rate(self, path: Path, clock: str) -> None:
        """Raises ConfigError where a sample rate is given although the file has a clock."""
        if self.rate is not None:
            raise unusable(path, f"has a clock ({clock}); a sample rate of {self.rate:g} Hz contradicts it")

    def unit_of(self, path: Path, name: str, written: str) -> tuple[str, str | None]:
        """The unit of the time channel `name`, and a note where it had to be taken for granted."""
        if match := _SINCE.fullmatch(written):
            written = match[1]
        if written:
            if written not in _SECONDS:
                raise unusable(path, f"time channel {name!r} is in {written!r}; expected one of {', '.join(_SECONDS)}")
            if self.unit is not None and _SECONDS[self.unit] != _SECONDS[written]:
                raise unusable(path, f"time channel {name!r} is in {written!r}, which contradicts {self.unit!r}")
            return written, None
        if self.unit is not None:
            return self.unit, None
        return "s", f"time channel {name!r} has no unit; taken as s"


def no_clock(path: Path, what: str, names: str) -> ConfigError:
    """The error for numbers without a known time."""
    return unusable(path, f"{what} has no clock; name the time channel, or give the sample rate; channels are {names}")


def seconds(values: Array, unit: str) -> Array:
    """Times in `unit` as seconds."""
    factor, divisor = _SECONDS[unit]
    if factor != 1.0:
        return values * factor
    return values / divisor if divisor != 1.0 else values


def seconds_between(instants: Any, origin: Any) -> Array:
    """Seconds from `origin` to each of `instants` (NumPy date-times), to the nanosecond; NaN where there is none."""
    elapsed = instants.astype("datetime64[ns]") - np.datetime64(origin, "ns")
    found: Array = elapsed.astype(np.int64) / 1e9
    found[np.isnat(instants)] = np.nan
    return found


def is_time_name(name: str) -> bool:
    """Whether a channel of this name is a time by its name: `Time`, `t`, `timestamp`, `t_ms`."""
    plain = name.strip().lower()
    if match := _WITH_SUFFIX.fullmatch(plain):
        return match[1] in _TIME_NAMES or plain in _TIME_NAMES
    return plain in _TIME_NAMES


def is_time(name: str, unit: str) -> bool:
    """Whether a channel is a time by its name or its unit."""
    return is_time_name(name) or is_time_unit(unit)


def is_time_unit(unit: str) -> bool:
    """Whether times may be written in this unit."""
    return unit in _SECONDS or _SINCE.fullmatch(unit) is not None


def heading(text: str) -> tuple[str, str]:
    """Name and unit of a column headed `name [unit]` or `name (unit)`; a time may also be `t_ms`.

    What stands in brackets is the unit; in parentheses only what is one, since `pressure (left)` is a name.
    """
    text = text.strip()
    if (match := _BRACKETED.fullmatch(text)) and not (match[2].isdigit() and match[2] != "1"):
        return match[1], match[2].strip()
    if (match := _IN_PARENTHESES.fullmatch(text)) and is_written_unit(match[2]):
        return match[1], match[2].strip()
    if is_time_name(text) and (match := _WITH_SUFFIX.fullmatch(text)):
        return text, match[2].lower()
    return text, ""


def is_written_unit(text: str) -> bool:
    """Whether the text is a unit, or one of the signs for having none."""
    plain = text.strip().strip("[]()").strip()
    return plain in ("", "-", "1", "%") or plain in _SECONDS or is_unit(plain)
