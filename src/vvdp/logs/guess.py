"""Which channels of a log are probably the edges and the pressure: a config to start from."""

import re
from collections.abc import Iterator

import numpy as np

from vvdp.base.errors import ConfigError, ParameterError
from vvdp.base.kinds import PRESSURE_LEVEL
from vvdp.base.units import line_to_si
from vvdp.logs.channel import ChannelInfo, Log
from vvdp.logs.clock import is_time_name
from vvdp.logs.config import Option
from vvdp.logs.edges import plateaus
from vvdp.numerics.tableaus import Array

LOOKED_AT = 100_000
"""Samples of each channel that are looked at."""
WORDS = {
    "sensor.wave": re.compile(r"photo|diode|enc|optic|wheel|sensor|light|licht", re.IGNORECASE),
    "sensor.counts": re.compile(r"count|ctr|zähl", re.IGNORECASE),
    "sensor.edges": re.compile(r"edge|stamp|rising|tau|flank", re.IGNORECASE),
}
LAST_RESORT = 0.1
"""How much speaks for a clock to be a column of edge times: enough where there is nothing else."""
INLET = re.compile(r"inlet|_in\b|p_?in|p_?1\b", re.IGNORECASE)
_SECONDS = ("s", "ms", "us", "µs", "μs", "ns")


def guessed_options(log: Log) -> list[Option]:
    """The channels that hold the edges and the inlet pressure, as far as names, units and first values tell.

    Where nothing does, the first channel is named, for the person to put right.
    """
    channels = log.channels()
    if not channels:
        return []
    first = dict(_first_values(log, channels))
    scored = [(score, key, info) for info in channels for key, score in _scores(info, first.get(info.name))]
    score, key, info = max(scored, key=lambda found: found[0], default=(0.0, "sensor.wave", channels[0]))
    if not score > 0.0:
        key, info = "sensor.wave", channels[0]
    found = [Option(key, "", info.name)]
    pressures = [other for other in channels if other is not info and _is_pressure(other)]
    if pressures and key != "sensor.edges":
        inlet = next((other for other in pressures if INLET.search(other.name)), pressures[0])
        found.append(Option("pressure.channel", "", inlet.name))
    return found


def _first_values(log: Log, channels: tuple[ChannelInfo, ...]) -> Iterator[tuple[str, Array]]:
    for info in channels:
        try:
            for portion in log.portions((info.name,), LOOKED_AT):
                values = portion[info.name].values
                yield info.name, values[np.isfinite(values)]
                break
        except ConfigError:
            continue  # a channel without a clock; its name has to do


def _scores(info: ChannelInfo, values: Array | None) -> Iterator[tuple[str, float]]:
    """How much speaks for each kind of edges."""
    named = {key: 1.0 if words.search(info.name) else 0.0 for key, words in WORDS.items()}
    rising = values is not None and values.size > 2 and bool(np.all(np.diff(values) > 0.0))
    whole = values is not None and values.size > 2 and bool(np.all(values == np.round(values)))
    if is_time_name(info.name):
        yield "sensor.edges", LAST_RESORT
        return
    if info.unit in _SECONDS:
        yield "sensor.edges", named["sensor.edges"] + (0.5 if rising else 0.0)
        return
    if _is_pressure(info):
        return
    stairs = whole and values is not None and bool(np.mean(np.diff(values) >= 0.0) > 0.99) and np.ptp(values) > 2.0
    yield "sensor.counts", named["sensor.counts"] + (1.0 if stairs else 0.0)
    wave = values is not None and not stairs and not rising and plateaus(values) is not None
    yield "sensor.wave", named["sensor.wave"] + (0.8 if wave else 0.0)
    if not info.unit and rising and not stairs:
        yield "sensor.edges", named["sensor.edges"]


def _is_pressure(info: ChannelInfo) -> bool:
    if not info.unit or info.unit == "1":
        return False
    try:
        line_to_si(info.unit, PRESSURE_LEVEL)
    except ParameterError:
        return False
    return True
