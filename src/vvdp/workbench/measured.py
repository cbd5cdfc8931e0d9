"""Measured logs of the folder: their channels, in the units of the scopes."""

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.display import display_unit
from vvdp.base.errors import ParameterError, unusable
from vvdp.base.kinds import (
    AREA,
    FLOW,
    FORCE,
    FREQUENCY,
    POSITION,
    POWER,
    PRESSURE_LEVEL,
    SIGNED_FRACTION,
    SPEED,
    TEMPERATURE,
    TORQUE,
    VELOCITY,
    Kind,
)
from vvdp.base.units import line_to_si
from vvdp.logs.channel import Log
from vvdp.logs.quantity import to_si
from vvdp.logs.source import open_log
from vvdp.report.interactive import Placed

KINDS = (
    PRESSURE_LEVEL, FLOW, SPEED, FREQUENCY, POSITION, VELOCITY, AREA, FORCE, TORQUE, POWER, TEMPERATURE,
    SIGNED_FRACTION,
)  # fmt: skip
"""Quantities that a channel can have; the first that fits its unit is taken."""
MOST_SAMPLES = 2_000_000
"""So many samples of a channel are laid over a scope."""
PORTION = 262_144


class Channel(NamedTuple):
    """A channel over the time of its log [s], in the unit in which the scopes show it."""

    name: str
    unit: str
    times: Array
    values: Array
    remarks: tuple[str, ...] = ()

    def describe(self, columns: Placed) -> dict[str, Any]:
        """Description of the channel for the page, with the places of its columns."""
        places = {"x": columns.place(self.times), "y": columns.place(self.values)}
        return {"label": self.name, "unit": self.unit, "remarks": list(self.remarks), **places}


def channels(path: Path) -> dict[str, Any]:
    """The channels of a log that a scope could show, with their units. Raises ConfigError where it cannot be read."""
    with open_log(path) as log:
        known = [each for each in log.channels() if not each.unit or _kind(each.unit) is not None]
    return {"channels": [{"name": each.name, "unit": each.unit} for each in known]}


def measured_channel(path: Path, name: str, unit: str | None = None) -> Channel:
    """A channel of a log; `unit` is for one that has none written.

    Raises ConfigError where the log cannot be read, has no such channel or clock, or is too long.
    """
    with open_log(path) as log:
        info = log.channel(name)
        written = unit or info.unit
        if not written:
            raise unusable(path, f"channel {info.name!r} has no unit; enter one, such as bar or L/min")
        if (kind := _kind(written)) is None:
            raise unusable(path, f"channel {info.name!r} is in {written!r}, which no scope shows")
        times, values = _read(log, info.name)
        shown = display_unit(kind)
        si = to_si(path, info, kind, unit)(values)
        return Channel(info.name, shown.symbol, times, np.asarray(shown.from_si(si)), log.remarks)


def _kind(unit: str) -> Kind | None:
    """Quantity that is measured in a unit; None if no scope shows it."""
    for kind in KINDS:
        try:
            line_to_si(unit, kind)
        except ParameterError:
            continue
        return kind
    return None


def _read(log: Log, name: str) -> tuple[Array, Array]:
    """All samples of a channel. Raises ConfigError where there are too many, or none."""
    times, values, count = list[Array](), list[Array](), 0
    for portions in log.portions([name], PORTION):
        part = portions[name]
        times.append(part.times)
        values.append(part.values)
        count += part.values.size
        if count > MOST_SAMPLES:
            raise unusable(log.path, f"channel {name!r} has more than {MOST_SAMPLES} samples; cut the log")
    if not count:
        raise unusable(log.path, f"channel {name!r} has no samples")
    return np.concatenate(times), np.concatenate(values).astype(float)
