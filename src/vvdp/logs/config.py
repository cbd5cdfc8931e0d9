"""What an estimation from a log needs to know: which channel holds the edges, the wheel, the filter, the output.

    [sensor]
    wave = "photodiode"          # or counts = "counter", or edges = "edge_time" (with falling = "other" if apart)
    sectors = 8

Everything else has a default; `config_text` writes every key with a comment. Options of the command line are laid over
the file. All faults are collected and reported together, each with file and line or with its option.
"""

import dataclasses
import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from vvdp.base.errors import ConfigError, Fault, ParameterError
from vvdp.base.kinds import DUTY_RATIO, FRACTION, FREQUENCY, PRESSURE_DIFFERENCE, PRESSURE_LEVEL, TIME, Kind
from vvdp.base.params import field_kinds
from vvdp.base.tables import Table, nearest, read_table
from vvdp.base.units import in_unit, line_to_si, parsed
from vvdp.estimation.event_filter import EventFilter, event_filter
from vvdp.estimation.fusion import LAG
from vvdp.estimation.pressure_edges import PressureEdges, pressure_edges
from vvdp.logs.channel import ChannelInfo
from vvdp.logs.clock import ClockChoice
from vvdp.sensing.wheel import CodeWheel, equal_wheel, sector_widths, wheel_of_widths

LOG_TIME = Kind("time on the clock of the log", "s", -1e12, 1e12, "2.5 s")
MOST_SECTORS = 1024
DEFAULT_SECTORS = 8
DEFAULT_SECTIONS = 3


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
    """All that an estimation from a log is told."""

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
KEYS: Mapping[str, tuple[str, ...]] = {
    "log": ("time", "time_unit", "sample_rate", "from", "until"),
    "sensor": (*SOURCES, "falling", "sectors", "index_shift", "widths", "inverted"),
    "threshold": ("level", "hysteresis", "interpolated"),
    "filter": ("fit", *FILTER_KINDS),
    "valve": ("sections",),
    "pressure": ("channel", "unit", "fuse", "level_share", "hysteresis", "least_swing", "level_time", *WAVE_KINDS),
    "output": ("rate", "smooth"),
}

T = TypeVar("T")


def load_estimation(path: Path | None, options: Sequence[Option] = ()) -> Estimation:
    """The estimation that a file and the options over it ask for. Raises ConfigError with everything wrong."""
    table = read_table(path) if path is not None else Table("", {}, {})
    given = _Given(table, options)
    found = _estimation(given)
    if given.faults:
        raise ConfigError(sorted(given.faults, key=lambda fault: fault.line))
    assert found is not None
    return found


class _Given:
    """The keys of a file with the options laid over them, and the faults found so far."""

    def __init__(self, table: Table, options: Sequence[Option]) -> None:
        self.table, self.faults = table, list[Fault]()
        self.values: dict[str, Any] = {}
        self.options: dict[str, str] = {}
        for name, content in table.content.items():
            if name not in KEYS:
                self.fault(name, f"unknown table{nearest(name, list(KEYS))}")
            elif not isinstance(content, Mapping):
                self.fault(name, f"{content!r}; expected a table, [{name}]")
            else:
                self._take(name, content)
        if any(option.key.partition(".")[2] in SOURCES for option in options):  # an option chooses the sensor anew
            for key in (*SOURCES, "falling"):
                self.values.pop(f"sensor.{key}", None)
        for option in options:
            self.values[option.key] = option.value
            self.options[option.key] = option.name

    def _take(self, name: str, content: Mapping[str, Any]) -> None:
        for key, value in content.items():
            if key in KEYS[name]:
                self.values[f"{name}.{key}"] = value
            else:
                self.fault(f"{name}.{key}", f"unknown key{nearest(key, list(KEYS[name]))}")

    def fault(self, key: str, message: str) -> None:
        if key in self.options:
            self.faults.append(Fault(self.options[key], 0, "", message))
        else:
            line = self.table.lines.get(key) or self.table.lines.get(key.partition(".")[0]) or 0
            self.faults.append(Fault(self.table.place or "options", line, key, message))

    def place(self, key: str) -> str:
        """How a message calls a key."""
        return self.options.get(key, key)

    def quantity(self, key: str, kind: Kind, default: T) -> float | T:
        if key not in self.values:
            return default
        try:
            return parsed(self.values[key], kind)
        except ParameterError as problem:
            self.fault(key, str(problem))
            return default

    def above_zero(self, key: str, kind: Kind, default: T) -> float | T:
        value = self.quantity(key, kind, default)
        if isinstance(value, float) and key in self.values and not value > 0.0:
            self.fault(key, f"{self.values[key]!r}; expected {kind.named} above zero, for example {kind.example!r}")
            return default
        return value

    def text(self, key: str) -> str | None:
        value = self.values.get(key)
        if value is not None and not (isinstance(value, str) and value.strip()):
            self.fault(key, f"{value!r}; expected a name in quotes")
            return None
        return value

    def flag(self, key: str, default: bool) -> bool:
        value = self.values.get(key, default)
        if not isinstance(value, bool):
            self.fault(key, f"{value!r}; expected true or false")
            return default
        return value

    def whole(self, key: str, default: int, low: int, high: int) -> int:
        value = self.values.get(key, default)
        if isinstance(value, bool) or not isinstance(value, int) or not low <= value <= high:
            self.fault(key, f"{value!r}; expected a whole number from {low} to {high}")
            return default
        return value


def _estimation(given: _Given) -> Estimation | None:
    source, wheel = _source(given), _wheel(given)
    changes = {name: given.quantity(f"filter.{name}", kind, None) for name, kind in FILTER_KINDS.items()}
    known = {name: value for name, value in changes.items() if value is not None}
    found = _filter(given, wheel, known)
    sections = given.whole("valve.sections", DEFAULT_SECTIONS, 1, 100)
    begin, end = given.quantity("log.from", LOG_TIME, None), given.quantity("log.until", LOG_TIME, None)
    if begin is not None and end is not None and not begin < end:
        given.fault("log.until", f"{end:g} s is not after {given.place('log.from')}, {begin:g} s")
    time, time_unit = given.text("log.time"), given.text("log.time_unit")
    rate = given.above_zero("log.sample_rate", FREQUENCY, None)
    if time is not None and rate is not None:
        given.fault("log.sample_rate", f"a rate and the clock {time!r} are given; expected one of them")
    if time_unit is not None:
        try:
            ClockChoice(unit=time_unit).check()
        except ParameterError as problem:
            given.fault("log.time_unit", str(problem))
    pressure = _pressure(given)
    output_rate = given.above_zero("output.rate", FREQUENCY, None)
    smooth, fit = given.flag("output.smooth", False), given.flag("filter.fit", False)
    if source is None or found is None:
        return None
    return Estimation(
        source=source,
        filter=found,
        sections=sections,
        time=time,
        time_unit=time_unit,
        sample_rate=rate,
        begin=begin,
        end=end,
        pressure=pressure,
        output_rate=output_rate,
        smooth=smooth,
        fit=fit,
    )


def _source(given: _Given) -> Wave | Counts | Stamps | None:
    present = [key for key in SOURCES if f"sensor.{key}" in given.values]
    comparator = _comparator(given)
    if len(present) > 1:
        names = " and ".join(given.place(f"sensor.{key}") for key in present)
        given.fault(f"sensor.{present[1]}", f"{names} are given; expected one of them")
        return None
    falling = given.text("sensor.falling")
    if falling is not None and present != ["edges"]:
        given.fault("sensor.falling", "belongs to edges, the column of the rising ones")
    if not present:
        given.fault(
            "sensor",
            "no channel is named that holds the edges; give --wave, --counts or --edges with a column, or in a file "
            "[sensor] with wave, counts or edges",
        )
        return None
    if present != ["wave"]:
        for key in ("sensor.inverted", *(f"threshold.{key}" for key in KEYS["threshold"])):
            if key in given.values:
                given.fault(key, f"belongs to a wave, not to {present[0]}")
    channel = given.text(f"sensor.{present[0]}")
    if channel is None or comparator is None:
        return None
    if present == ["wave"]:
        return Wave(channel, comparator)
    if present == ["counts"]:
        return Counts(channel)
    if falling == channel:
        given.fault("sensor.falling", f"{falling!r} is the column of the rising edges as well; leave falling out")
    return Stamps(channel, falling or "")


def _comparator(given: _Given) -> Comparator | None:
    level = given.values.get("threshold.level", "automatic")
    if isinstance(level, bool) or not (level == "automatic" or isinstance(level, int | float)):
        given.fault("threshold.level", f'{level!r}; expected "automatic" or a number in the unit of the channel')
        return None
    if level != "automatic" and not np.isfinite(level):
        given.fault("threshold.level", f"{level!r} is not finite")
        return None
    hysteresis = given.quantity("threshold.hysteresis", FRACTION, 0.25)
    if not 0.0 <= hysteresis <= 0.9:
        given.fault("threshold.hysteresis", f"{hysteresis:g} of the swing; expected 0 to 0.9, or no edge is ever seen")
    return Comparator(
        None if level == "automatic" else float(level),
        float(hysteresis),
        given.flag("threshold.interpolated", True),
        given.flag("sensor.inverted", False),
    )


def _wheel(given: _Given) -> CodeWheel | None:
    widths = given.values.get("sensor.widths")
    try:
        if widths is not None:
            for other in ("sensor.sectors", "sensor.index_shift"):
                if other in given.values:
                    given.fault(other, "contradicts sensor.widths, which has sectors and index; expected one of them")
            if not isinstance(widths, list) or not all(isinstance(w, int | float) for w in widths):
                raise ParameterError(f"{widths!r}; expected numbers, one for each sector, the first one bright")
            return wheel_of_widths([float(w) for w in widths])
        sectors = given.whole("sensor.sectors", DEFAULT_SECTORS, 2, MOST_SECTORS)
    except ParameterError as problem:
        given.fault("sensor.widths", str(problem))
        return None
    shift = given.values.get("sensor.index_shift", 0.0)
    if isinstance(shift, bool) or not isinstance(shift, int | float):
        given.fault("sensor.index_shift", f"{shift!r}; expected a share of a sector from -0.9 to 0.9")
        return None
    try:
        return equal_wheel(sectors, float(shift))
    except ParameterError as problem:
        given.fault("sensor.sectors" if sectors % 2 else "sensor.index_shift", str(problem))
        return None


def _filter(given: _Given, wheel: CodeWheel | None, changes: Mapping[str, Any]) -> EventFilter | None:
    usual = event_filter(wheel if wheel is not None else equal_wheel(DEFAULT_SECTORS))
    try:
        found = dataclasses.replace(usual, **changes)
    except ParameterError as problem:
        given.fault("filter", str(problem))
        return None
    return found if wheel is not None else None


def _pressure(given: _Given) -> InletPressure | None:
    usual = pressure_edges()
    values = {
        "level_share": given.quantity("pressure.level_share", FRACTION, usual.level_share),
        "hysteresis": given.quantity("pressure.hysteresis", FRACTION, usual.hysteresis),
        "least_swing": given.quantity("pressure.least_swing", PRESSURE_DIFFERENCE, usual.least_swing),
        "level_time": given.quantity("pressure.level_time", TIME, usual.level_time),
    }
    unit = given.text("pressure.unit")
    if unit is not None:
        try:
            line_to_si(unit, PRESSURE_LEVEL)
        except ParameterError as problem:
            given.fault("pressure.unit", str(problem))
    wave = {key: given.quantity(f"pressure.{key}", kind, 0.0) for key, kind in WAVE_KINDS.items()}
    channel = given.text("pressure.channel")
    if channel is None:
        if extra := [key for key in given.values if key.startswith("pressure.") and key != "pressure.channel"]:
            given.fault(extra[0], "belongs to pressure.channel, which is missing")
        return None
    try:
        return InletPressure(channel, unit or "", PressureEdges(**values), given.flag("pressure.fuse", False), **wave)
    except ParameterError as problem:
        given.fault("pressure", str(problem))
        return None


def source_channels(wanted: Estimation) -> tuple[str, ...]:
    """The channels that hold the edges."""
    source = wanted.source
    if isinstance(source, Stamps) and source.falling:
        return source.channel, source.falling
    return (source.channel,)


def config_text(wanted: Estimation, channels: Sequence[ChannelInfo] = (), place: str = "") -> str:
    """The TOML text of an estimation with every key and a comment to each; `channels` are listed at the top."""
    return "\n".join(_config_lines(wanted, channels, place)) + "\n"


def _config_lines(wanted: Estimation, channels: Sequence[ChannelInfo], place: str) -> Iterator[str]:
    yield f"# Angle and speed from {_comment(place) or 'a log'}: vvdp estimate LOG --config THIS-FILE"
    if channels:
        yield "# Channels of the log:"
        for info in channels:
            samples = "" if info.samples is None else f", {info.samples} samples"
            yield f"#   {_comment(info.name)}{f' [{_comment(info.unit)}]' if info.unit else ''}{samples}"
    yield ""
    yield "[log]"
    yield from _optional(
        "time", _text(wanted.time), '"time"', "the channel that is the clock, where the log does not say"
    )
    yield from _optional("time_unit", _text(wanted.time_unit), '"s"', "where the log has none")
    yield from _optional("sample_rate", _amount(wanted.sample_rate, "Hz"), '"10 kHz"', "of channels without a clock")
    yield from _optional("from", _amount(wanted.begin, "s"), '"0 s"', "use the log from here")
    yield from _optional("until", _amount(wanted.end, "s"), '"10 s"', "to here")
    yield ""
    yield "[sensor]"
    yield from _source_lines(wanted.source)
    yield from _wheel_lines(wanted.wheel)
    wave = wanted.source if isinstance(wanted.source, Wave) else None
    if wave is not None:
        c = wave.comparator
        yield f"inverted = {_flag(c.inverted)}".ljust(30) + "# true: a bright sector gives the lower value"
        yield ""
        yield "[threshold]"
        level = '"automatic"' if c.level is None else _number(c.level)
        yield f"level = {level}".ljust(30) + "# midway between the plateaus, or a number in the unit of the channel"
        yield f"hysteresis = {_number(c.hysteresis)}".ljust(30) + "# whole band, as a share of the swing"
        yield f"interpolated = {_flag(c.interpolated)}".ljust(30) + "# crossing times between the samples"
    yield ""
    yield "[filter]"
    yield f"fit = {_flag(wanted.fit)}".ljust(46) + "# true: the next two are fitted to the beginning of the log"
    for name, kind in FILTER_KINDS.items():
        value = getattr(wanted.filter, name)
        shown = _number(value) if kind.unit == "1" else f'"{_digits(value)} {kind.unit}"'
        yield f"{name} = {shown}".ljust(46) + f"# {FILTER_WORDS.get(name, kind.name)}"
    yield ""
    yield "[valve]"
    yield f"sections = {wanted.sections}".ljust(30) + "# PWM periods in a turn of the spool"
    yield ""
    yield from _pressure_lines(wanted.pressure)
    yield "[output]"
    yield from _optional(
        "rate", _amount(wanted.output_rate, "Hz"), '"1 kHz"', "by default 1 kHz, or the sample rate where that is less"
    )
    yield f"smooth = {_flag(wanted.smooth)}".ljust(30) + "# also what the whole log tells about each instant"


FILTER_WORDS = {
    "acceleration_density": "how fast the speed may wander; larger follows quicker and is noisier",
    "edge_variance": "of an edge's angle: threshold, dirt, sectors",
    "lowest_speed": "floor of the speed in the noise of sampling",
    "angle_variance": "at the start",
    "speed_variance": "at the start",
    "association_speed_deviation": "edges are counted until the speed is known this well",
    "manoeuvre_density": "in place of acceleration_density while the speed changes",
    "manoeuvre_gate": "sum of innovations from which it does",
    "manoeuvre_edges": "fading over so many edges",
    "index_turns": "turns that have to agree about the index; 0 where there is none",
}


def _source_lines(source: Wave | Counts | Stamps) -> Iterator[str]:
    match source:
        case Wave():
            yield f"wave = {_text(source.channel)}".ljust(30) + "# the photodiode's wave; or counts, or edges"
        case Counts():
            yield f"counts = {_text(source.channel)}".ljust(30) + "# a counter of edges; or wave, or edges"
        case Stamps():
            yield f"edges = {_text(source.channel)}".ljust(30) + "# times of edges; or wave, or counts"
            yield from _optional("falling", _text(source.falling or None), '"falling"', "falling edges, if apart")


def _wheel_lines(wheel: CodeWheel) -> Iterator[str]:
    sectors, pitch = len(wheel.edges), 2.0 * np.pi / len(wheel.edges)
    shift = float(np.clip(round(wheel.edges[1] / pitch - 1.0, 12), -0.9, 0.9))
    if wheel.edges[0] == 0.0 and np.allclose(equal_wheel(sectors, shift).edges, wheel.edges):
        yield f"sectors = {sectors}".ljust(30) + "# bright and dark ones together"
        yield f"index_shift = {_number(shift + 0.0)}".ljust(30) + "# of the edge after angle 0, in sectors; 0: no index"
    else:
        widths = ", ".join(_number(w / pitch) for w in sector_widths(wheel))
        yield f"widths = [{widths}]  # of the sectors, the first one bright"


def _pressure_lines(pressure: InletPressure | None) -> Iterator[str]:
    off = "" if pressure is not None else "# "
    usual = pressure.edges if pressure is not None else pressure_edges()
    yield f"{off}[pressure]"
    name, unit = (pressure.channel, pressure.unit) if pressure is not None else ("inlet pressure", "")
    yield f"{off}channel = {_text(name)}".ljust(30) + "# of the inlet pressure, for the duty ratio"
    if unit or pressure is None:
        yield f"{off}unit = {_text(unit or 'bar')}".ljust(30) + "# where the log has none; plain units are gauge"
    else:
        yield '# unit = "bar"'.ljust(30) + "# where the log has none; plain units are gauge"
    fuse = _flag(pressure is not None and pressure.fused)
    yield f"{off}fuse = {fuse}".ljust(30) + "# true: its edges also tell the angle, where the encoder is silent"
    yield f"{off}level_share = {_number(usual.level_share)}".ljust(30) + "# where the crossing level lies in the swing"
    yield f"{off}hysteresis = {_number(usual.hysteresis)}".ljust(30) + "# of the swing, beyond the level"
    swing = in_unit(usual.least_swing, PRESSURE_DIFFERENCE, "bar")
    yield f'{off}least_swing = "{_digits(swing)} bar"'.ljust(30) + "# below it nothing switches"
    yield f'{off}level_time = "{_digits(1e3 * usual.level_time)} ms"'.ljust(30) + "# in which the plateaus are followed"
    known = pressure if pressure is not None else InletPressure("", "", usual)
    yield f"{off}duty_excess = {_number(known.duty_excess)}".ljust(30) + "# of the wave's duty ratio over the spool's"
    yield f'{off}lag = "{_digits(1e3 * known.lag)} ms"'.ljust(30) + "# of the wave, with `fuse`"
    deviation = _digits(1e3 * known.lag_deviation)
    yield f'{off}lag_deviation = "{deviation} ms"'.ljust(30) + "# with `fuse`; above 0 the lag is estimated too"
    yield ""


def _optional(key: str, value: str | None, example: str, words: str) -> Iterator[str]:
    yield (f"# {key} = {example}" if value is None else f"{key} = {value}").ljust(30) + f"# {words}"


def _text(value: str | None) -> str | None:
    # JSON leaves the one control character raw that TOML forbids beyond those below the blank.
    return None if value is None else json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")


def _amount(value: float | None, unit: str) -> str | None:
    return None if value is None else f'"{_digits(value)} {unit}"'


def _digits(value: float) -> str:
    short = f"{value:.6g}"
    return short if float(short) == value else repr(float(value))


def _number(value: float) -> str:
    text = _digits(value)
    return text if any(c in text for c in ".en") else f"{text}.0"


def _flag(value: bool) -> str:
    return "true" if value else "false"


def _comment(value: str) -> str:
    return "".join(c if c.isprintable() else "?" for c in value)
