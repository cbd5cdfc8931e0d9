"""Which channels of a log are probably the edges and the pressure: a config to start from."""

import re
from collections.abc import Iterator

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.errors import ConfigError, ParameterError
from vvdp.base.kinds import PRESSURE_LEVEL
from vvdp.base.units import line_to_si
from vvdp.logs.channel import ChannelInfo, Log
from vvdp.logs.clock import is_time_name, is_time_unit
from vvdp.logs.source import open_log
from vvdp.offline.config import Option
from vvdp.offline.edges import plateaus

LOOKED_AT = 100_000
"""Samples of each channel that are looked at."""
WORDS = {
    "sensor.wave": re.compile(r"photo|diode|enc|optic|wheel|sensor|light|licht", re.IGNORECASE),
    "sensor.counts": re.compile(r"count|ctr|zähl", re.IGNORECASE),
    "sensor.edges": re.compile(r"edge|stamp|rising|tau|flank", re.IGNORECASE),
}
FALLING = re.compile(r"fall|down|neg|abfall|abw|off\b|aus\b", re.IGNORECASE)
RISING = re.compile(r"ris|up|pos|steig|auf|on\b|ein\b", re.IGNORECASE)
IN_SECONDS = 0.9
"""How much speaks for edge times where a column in seconds rises and is not named as a time: more than for a wave."""
ALTERNATING = 0.9
"""Share of the times of two columns that take turns where one has the rising and the other the falling edges."""
INLET = re.compile(r"inlet|_in\b|p_?in|p_?1\b", re.IGNORECASE)


def guessed_options(log: Log) -> list[Option]:
    """The channels that hold the edges and the inlet pressure, as far as names, units and first values show.

    Where nothing does, the first channel is named, for the person to put right.
    """
    channels = log.channels()
    if not channels:
        return []
    first = dict(_first_values(log, channels))
    scored = [(score, key, info) for info in channels for key, score in _scores(info, first.get(info.name))]
    score, key, info = max(scored, key=lambda found: found[0], default=(0.0, "", channels[0]))
    if not score > 0.0:
        others = [other for other in channels if not is_time_name(_own_name(other))]
        # A clock holds no edges, but a column that is all there is may be named as one.
        key, info = ("sensor.wave", others[0]) if others else ("sensor.edges", channels[0])
    if key == "sensor.edges":
        falling = _partner(info, channels, first)
        if falling is not None and _falls_first(info, falling, first):
            info, falling = falling, info
        return [Option(key, "", info.name), *([Option("sensor.falling", "", falling.name)] if falling else [])]
    found = [Option(key, "", info.name)]
    pressures = [other for other in channels if other is not info and _is_pressure(other)]
    if pressures:
        inlet = next((other for other in pressures if INLET.search(other.name)), pressures[0])
        found.append(Option("pressure.channel", "", inlet.name))
    return found


def channels_of_edges(log: Log) -> tuple[str, ...]:
    """The channels that may hold edges, the likeliest first."""
    first = dict(_first_values(log, log.channels()))
    best = {info.name: max((score for _, score in _scores(info, first.get(info.name))), default=0.0)
            for info in log.channels()}  # fmt: skip
    return tuple(sorted((name for name, score in best.items() if score > 0.0), key=lambda name: -best[name]))


def _own_name(info: ChannelInfo) -> str:
    return info.name.rpartition("/")[2]


def _partner(info: ChannelInfo, channels: tuple[ChannelInfo, ...], first: dict[str, Array]) -> ChannelInfo | None:
    """The column whose times take turns with those of `info`."""
    own = first.get(info.name)
    if own is None:
        return None
    for other in channels:
        times = first.get(other.name)
        if other is info or other.unit != info.unit or times is None or is_time_name(_own_name(other)):
            continue
        if times.size < 3 or not _rises(times) or abs(times.size - own.size) > 1:
            continue
        order = np.argsort(np.concatenate([own, times]), kind="stable")
        if float(np.mean(np.diff((order < own.size).astype(int)) != 0)) > ALTERNATING:
            return other
    return None


def _falls_first(info: ChannelInfo, other: ChannelInfo, first: dict[str, Array]) -> bool:
    """Whether `info` is the column of the falling edges: by the names, else the one that begins later is."""
    names = _own_name(info), _own_name(other)
    told = [bool(FALLING.search(name)) - bool(RISING.search(name)) for name in names]
    if told[0] != told[1]:
        return told[0] > told[1]
    return bool(first[info.name][0] > first[other.name][0])


def _first_values(log: Log, channels: tuple[ChannelInfo, ...]) -> Iterator[tuple[str, Array]]:
    for info in channels:
        try:
            yield info.name, _values(log, info)
        except ConfigError:
            continue  # a channel without a clock
    try:
        with open_log(log.path, rate=1.0) as counted:  # edge times need no clock
            for info in counted.channels():
                if is_time_unit(info.unit) or not info.unit:
                    yield info.name, _values(counted, info)
    except ConfigError:
        return  # the log has a clock


def _values(log: Log, info: ChannelInfo) -> Array:
    for portion in log.portions((info.name,), LOOKED_AT):
        values = portion[info.name].values
        return values[np.isfinite(values)]
    return np.empty(0)


def _rises(values: Array) -> bool:
    return bool(np.all(np.diff(values) > 0.0))


def _scores(info: ChannelInfo, values: Array | None) -> Iterator[tuple[str, float]]:
    """How much speaks for each kind of edges."""
    named = {key: 1.0 if words.search(info.name) else 0.0 for key, words in WORDS.items()}
    rising = values is not None and values.size > 2 and _rises(values)
    whole = values is not None and values.size > 2 and bool(np.all(values == np.round(values)))
    if is_time_name(_own_name(info)):
        return
    if is_time_unit(info.unit):
        yield "sensor.edges", named["sensor.edges"] + (IN_SECONDS if rising else 0.0)
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
