"""What an estimation from a log needs to know: which channel holds the edges, the wheel, the filter, the output.

    [sensor]
    wave = "photodiode"          # or counts = "counter", or edges = "edge_time" (with falling = "other" if apart)
    sectors = 8

Everything else has a default; `config_text` writes every key with a comment. Options of the command line are laid over
the file. All faults are collected and reported together, each with file and line or with its option.
"""

import dataclasses
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from vvdp.base.errors import ConfigError, Fault, ParameterError
from vvdp.base.kinds import DUTY_RATIO, FRACTION, FREQUENCY, PRESSURE_LEVEL, TIME, Kind
from vvdp.base.params import field_kinds
from vvdp.base.rules import POSITIVE
from vvdp.base.tables import Table, read_flag, read_table, read_text, read_values, read_whole, refuse_unknown
from vvdp.base.units import line_to_si, parse
from vvdp.estimation.event_settings import EventFilter, event_filter
from vvdp.estimation.fusion import LAG
from vvdp.estimation.pressure_edges import PressureEdges, pressure_edges
from vvdp.logs.clock import ClockChoice
from vvdp.sensing.wheel import CodeWheel, equal_wheel, wheel_of_widths

DECELERATION = Kind("angular acceleration", "rad/s^2", 0.0, 1e9, "3000 rad/s^2")
LOG_TIME = Kind("time on the clock of the log", "s", -1e12, 1e12, "2.5 s")
MOST_SECTORS = 1024
DEFAULT_SECTORS = 8
DEFAULT_SECTIONS = 3

Reader: TypeAlias = Callable[[Any], Any]


@dataclass(frozen=True)
class Comparator:
    """How a wave becomes edges. `hysteresis` is the whole band around the threshold, as a share of the swing."""

    level: float | None  # in the unit of the channel; None: midway between the plateaus, found from the wave
    hysteresis: float
    interpolated: bool  # crossing times between the samples; else an edge lies anywhere in its sampling interval
    inverted: bool  # a bright sector gives the lower voltage


@dataclass(frozen=True)
class Wave:
    """Edges are where a photodiode's wave crosses a threshold."""

    channel: str
    comparator: Comparator


@dataclass(frozen=True)
class Counts:
    """Edges are steps of a counter; their polarity is unknown."""

    channel: str


@dataclass(frozen=True)
class Stamps:
    """Edges stand in a column of times; with `falling`, the rising ones in one column and the falling in another."""

    channel: str
    falling: str = ""


@dataclass(frozen=True)
class InletPressure:
    """The channel of the inlet pressure, and how its edges are found."""

    channel: str
    unit: str  # "": that of the channel
    edges: PressureEdges
    fused: bool = False  # the wave's edges are measurements of the angle as well
    duty_excess: float = 0.0  # by which the wave's duty ratio is larger than the spool's
    lag: float = 0.0  # of the wave, s
    lag_deviation: float = 0.0  # s; 0: the lag is known


@dataclass(frozen=True)
class Estimation:
    """All options of an estimation from a log."""

    source: Wave | Counts | Stamps
    filter: EventFilter
    sections: int
    time: str | None = None
    time_unit: str | None = None
    sample_rate: float | None = None
    begin: float | None = None
    end: float | None = None
    pressure: InletPressure | None = None
    output_rate: float | None = None
    smooth: bool = False
    fit: bool = False  # take acceleration_density and edge_variance from the log
    largest_deceleration: float | None = None  # of the spool by drive and friction, rad/s^2; None: from its speed
    sections_given: bool = False  # the PWM periods of a valve
    sectors_assumed: bool = False  # neither sectors nor widths were given

    @property
    def is_of_valve(self) -> bool:
        """Whether the shaft is known to be the spool of a rotary valve: by its sections or its inlet pressure."""
        return self.sections_given or self.pressure is not None

    @property
    def wheel(self) -> CodeWheel:
        """The code wheel of the filter's settings."""
        return self.filter.wheel


@dataclass(frozen=True)
class Option:
    """A value given on the command line; it replaces the `key` of the file."""

    key: str  # table.key
    name: str  # as the person wrote it, --sectors
    value: Any


SOURCES = ("wave", "counts", "edges")
FILTER_KINDS = {name: kind for name, kind in field_kinds(EventFilter).items() if kind is not None}
WAVE_KINDS = {"duty_excess": DUTY_RATIO, "lag": LAG, "lag_deviation": TIME}
"""What is known of the pressure's wave against the spool."""


def source_channels(wanted: Estimation) -> tuple[str, ...]:
    """The channels that hold the edges."""
    source = wanted.source
    if isinstance(source, Stamps) and source.falling:
        return source.channel, source.falling
    return (source.channel,)


def load_estimation(path: Path | None, options: Sequence[Option] = ()) -> Estimation:
    """The estimation that a file and the options over it ask for. Raises ConfigError with everything wrong."""
    given = _read(read_table(path) if path is not None else Table("options", {}, {}), options)
    found = _estimation(given)
    if given.faults:
        named = [Fault(given.names[fault.key], 0, "", fault.message) if fault.key in given.names else fault
                 for fault in given.faults]  # fmt: skip
        raise ConfigError(sorted(named, key=lambda fault: fault.line))
    assert found is not None
    return found


@dataclass(frozen=True)
class _Given:
    """What a file gives with the options laid over it: entries and, of the sound ones, values by table and key; the
    faults found so far, and the names of the options."""

    table: Table
    names: Mapping[str, str]
    entries: Mapping[str, Mapping[str, object]]
    values: Mapping[str, dict[str, Any]]
    faults: list[Fault]

    def fault(self, key: str, message: str) -> None:
        line = self.table.lines.get(key) or self.table.lines.get(key.partition(".")[0]) or 0
        self.faults.append(Fault(self.table.place, line, key, message))

    def place(self, key: str) -> str:
        """How a message calls a key."""
        return self.names.get(key, key)

    def pick(self, table: str, keys: Iterable[str]) -> dict[str, Any]:
        """The values under those of `keys` that a table gives."""
        return {key: self.values[table][key] for key in keys if key in self.values[table]}


def _read(table: Table, options: Sequence[Option]) -> _Given:
    names, faults = {option.key: option.name for option in options}, list[Fault]()
    entries = {name: _entries(table, name, options) for name in READERS}
    values = {name: read_values(READERS[name], entries[name], name, table, faults) for name in READERS}
    given = _Given(table, names, entries, values, faults)
    refuse_unknown(table.content, READERS, "", table, faults)
    for name, content in table.content.items():
        if name in READERS and not isinstance(content, Mapping):
            given.fault(name, f"{content!r}; expected a table, [{name}]")
    return given


def _entries(table: Table, name: str, options: Sequence[Option]) -> dict[str, Any]:
    """What is given of a table; an option that names a channel of edges chooses the sensor again."""
    content = table.content.get(name, {})
    entries = dict(content) if isinstance(content, Mapping) else {}
    own = {option.key.partition(".")[2]: option.value for option in options if option.key.startswith(f"{name}.")}
    if name == "sensor" and any(key in own for key in SOURCES):
        entries = {key: value for key, value in entries.items() if key not in (*SOURCES, "falling")}
    return entries | own


def _rate(entry: Any) -> float:
    value = parse(entry, FREQUENCY)
    if not value > 0.0:
        raise ParameterError(f"{entry!r} {POSITIVE}")
    return value


def _time_unit(entry: Any) -> str:
    unit = read_text(entry)
    ClockChoice(unit=unit).check()
    return unit


def _pressure_unit(entry: Any) -> str:
    unit = read_text(entry)
    line_to_si(unit, PRESSURE_LEVEL)
    return unit


def _index_shift(entry: Any) -> float:
    if isinstance(entry, bool) or not isinstance(entry, int | float):
        raise ParameterError(f"{entry!r}; expected a share of a sector from -0.9 to 0.9")
    return float(entry)


def _widths(entry: Any) -> CodeWheel:
    if not isinstance(entry, list) or not all(isinstance(width, int | float) for width in entry):
        raise ParameterError(f"{entry!r}; expected numbers, one for each sector, the first one bright")
    return wheel_of_widths([float(width) for width in entry])


def _level(entry: Any) -> float | None:
    if isinstance(entry, bool) or not (entry == "automatic" or isinstance(entry, int | float)):
        raise ParameterError(f'{entry!r}; expected "automatic" or a number in the unit of the channel')
    if entry != "automatic" and not np.isfinite(entry):
        raise ParameterError(f"{entry!r} is not finite")
    return None if entry == "automatic" else float(entry)


def _hysteresis(entry: Any) -> float:
    value = parse(entry, FRACTION)
    if not 0.0 <= value <= 0.9:
        raise ParameterError(f"{value:g} of the swing; expected 0 to 0.9, or no edge is ever seen")
    return value


def _quantities(kinds: Mapping[str, Kind]) -> dict[str, Reader]:
    return {name: partial(parse, kind=kind) for name, kind in kinds.items()}


PRESSURE_KINDS = {name: kind for name, kind in field_kinds(PressureEdges).items() if kind is not None}
READERS: Mapping[str, Mapping[str, Reader]] = {
    "log": {
        "time": read_text,
        "time_unit": _time_unit,
        "sample_rate": _rate,
        **_quantities({"from": LOG_TIME, "until": LOG_TIME}),
    },
    "sensor": {
        **dict.fromkeys((*SOURCES, "falling"), read_text),
        "sectors": partial(read_whole, low=2, high=MOST_SECTORS),
        "index_shift": _index_shift,
        "widths": _widths,
        "inverted": read_flag,
    },
    "threshold": {"level": _level, "hysteresis": _hysteresis, "interpolated": read_flag},
    "filter": {"fit": read_flag, **_quantities(FILTER_KINDS)},
    "valve": {
        "sections": partial(read_whole, low=1, high=100),
        **_quantities({"largest_deceleration": DECELERATION}),
    },
    "pressure": {
        "channel": read_text,
        "unit": _pressure_unit,
        "fuse": read_flag,
        **_quantities(PRESSURE_KINDS | WAVE_KINDS),
    },
    "output": {"rate": _rate, "smooth": read_flag},
}
"""The tables of a file with their keys, and what reads each."""


def _estimation(given: _Given) -> Estimation | None:
    log, output = given.values["log"], given.values["output"]
    source, wheel = _source(given), _wheel(given)
    chosen = _filter(given, wheel)
    begin, end = log.get("from"), log.get("until")
    if begin is not None and end is not None and not begin < end:
        given.fault("log.until", f"{end:g} s is not after {given.place('log.from')}, {begin:g} s")
    if {"time", "sample_rate"} <= log.keys():
        given.fault("log.sample_rate", f"a rate and the clock {log['time']!r} are given; expected one of them")
    pressure = _pressure(given)
    if source is None or chosen is None:
        return None
    return Estimation(
        source=source,
        filter=chosen,
        sections=given.values["valve"].get("sections", DEFAULT_SECTIONS),
        sections_given="sections" in given.values["valve"],
        **given.pick("log", ("time", "time_unit", "sample_rate")),
        begin=begin,
        end=end,
        pressure=pressure,
        output_rate=output.get("rate"),
        smooth=output.get("smooth", False),
        fit=given.values["filter"].get("fit", False),
        largest_deceleration=given.values["valve"].get("largest_deceleration"),
        sectors_assumed=not {"sectors", "widths"} & given.entries["sensor"].keys(),
    )


def _source(given: _Given) -> Wave | Counts | Stamps | None:
    sensor, values = given.entries["sensor"], given.values["sensor"]
    present = [key for key in SOURCES if key in sensor]
    if len(present) > 1:
        names = " and ".join(given.place(f"sensor.{key}") for key in present)
        given.fault(f"sensor.{present[1]}", f"{names} are given; expected one of them")
        return None
    if not present:
        given.fault(
            "sensor",
            "no channel is named that holds the edges; give --wave, --counts or --edges with a column, or in a file "
            "[sensor] with wave, counts or edges",
        )
    kind = present[0] if present else ""
    _refuse_strangers(given, kind)
    channel, falling = values.get(kind), values.get("falling", "")
    if channel is None:
        return None
    if kind == "edges" and falling == channel:
        given.fault("sensor.falling", f"{falling!r} is the column of the rising edges as well; leave falling out")
    if kind == "wave":
        return Wave(channel, _comparator(given))
    return Counts(channel) if kind == "counts" else Stamps(channel, falling)


def _refuse_strangers(given: _Given, source: str) -> None:
    """Refuses keys that belong to another source of edges."""
    if source != "edges" and "falling" in given.entries["sensor"]:
        given.fault("sensor.falling", "belongs to edges, the column of the rising ones")
    of_waves = [*(["sensor.inverted"] if "inverted" in given.entries["sensor"] else []),
                *(f"threshold.{key}" for key in READERS["threshold"] if key in given.entries["threshold"])]  # fmt: skip
    for key in of_waves if source in ("counts", "edges") else ():
        given.fault(key, f"belongs to a wave, not to {source}")


def _comparator(given: _Given) -> Comparator:
    usual = {"level": None, "hysteresis": 0.25, "interpolated": True, "inverted": False}
    return Comparator(**usual | given.values["threshold"] | given.pick("sensor", ("inverted",)))


def _wheel(given: _Given) -> CodeWheel | None:
    sensor, entries = given.values["sensor"], given.entries["sensor"]
    if "widths" in entries:
        for other in ("sectors", "index_shift"):
            if other in entries:
                text = "contradicts sensor.widths, which has sectors and index; expected one of them"
                given.fault(f"sensor.{other}", text)
        wheel: CodeWheel | None = sensor.get("widths")
        return wheel
    sectors = sensor.get("sectors", DEFAULT_SECTORS)
    try:
        return equal_wheel(sectors, sensor.get("index_shift", 0.0))
    except ParameterError as problem:
        given.fault("sensor.sectors" if sectors % 2 else "sensor.index_shift", str(problem))
        return None


def _filter(given: _Given, wheel: CodeWheel | None) -> EventFilter | None:
    wheel_or_usual = wheel or equal_wheel(DEFAULT_SECTORS)
    usual = event_filter(wheel_or_usual)
    finer = DEFAULT_SECTORS / len(wheel_or_usual.edges)  # edges scatter by a share of their sector
    changes = {"edge_variance": usual.edge_variance * finer * finer} | given.pick("filter", FILTER_KINDS)
    try:
        chosen = dataclasses.replace(usual, **changes)
    except ParameterError as problem:
        given.fault("filter", str(problem))
        return None
    return chosen if wheel is not None else None


def _pressure(given: _Given) -> InletPressure | None:
    entries, values = given.entries["pressure"], given.values["pressure"]
    if "channel" not in entries and entries:
        given.fault(f"pressure.{next(iter(entries))}", "belongs to pressure.channel, which is missing")
    if "channel" not in values:
        return None
    try:
        return InletPressure(
            channel=values["channel"],
            unit=values.get("unit", ""),
            edges=dataclasses.replace(pressure_edges(), **given.pick("pressure", PRESSURE_KINDS)),
            fused=values.get("fuse", False),
            **given.pick("pressure", WAVE_KINDS),
        )
    except ParameterError as problem:
        given.fault("pressure", str(problem))
        return None
