"""The settings of an estimation as a TOML file: every key, with a comment to each."""

import json
from collections.abc import Iterator, Sequence

import numpy as np

from vvdp.base.kinds import PRESSURE_DIFFERENCE
from vvdp.base.units import in_unit
from vvdp.estimation.pressure_edges import pressure_edges
from vvdp.logs.channel import ChannelInfo
from vvdp.offline.config import (
    DEFAULT_SECTORS,
    FILTER_KINDS,
    Comparator,
    Counts,
    Estimation,
    InletPressure,
    Stamps,
    Wave,
)
from vvdp.sensing.wheel import CodeWheel, equal_wheel, sector_widths


def config_text(wanted: Estimation, channels: Sequence[ChannelInfo] = (), place: str = "") -> str:
    """The TOML text of an estimation with every key and a comment to each; `channels` are listed at the top."""
    return "\n".join(_lines(wanted, channels, place)) + "\n"


def _lines(wanted: Estimation, channels: Sequence[ChannelInfo], place: str) -> Iterator[str]:
    yield f"# Angle and speed from {_comment(place) or 'a log'}: vvdp estimate LOG --config THIS-FILE"
    if channels:
        yield "# Channels of the log:"
        for info in channels:
            samples = "" if info.samples is None else f", {info.samples} samples"
            yield f"#   {_comment(info.name)}{f' [{_comment(info.unit)}]' if info.unit else ''}{samples}"
    yield ""
    yield from _log_lines(wanted)
    yield ""
    yield "[sensor]"
    yield from _source_lines(wanted.source)
    yield from _wheel_lines(wanted.wheel, assumed=wanted.sectors_assumed)
    if isinstance(wanted.source, Wave):
        yield from _threshold_lines(wanted.source.comparator)
    yield ""
    yield from _filter_lines(wanted)
    yield ""
    yield from _valve_lines(wanted)
    yield ""
    yield from _pressure_lines(wanted.pressure)
    yield from _output_lines(wanted)


def _log_lines(wanted: Estimation) -> Iterator[str]:
    yield "[log]"
    yield _line("time", _text(wanted.time), "the channel that is the clock, where the log does not say", '"time"')
    yield _line("time_unit", _text(wanted.time_unit), "where the log has none", '"s"')
    yield _line("sample_rate", _amount(wanted.sample_rate, "Hz"), "of channels without a clock", '"10 kHz"')
    yield _line("from", _amount(wanted.begin, "s"), "use the log from here", '"0 s"')
    yield _line("until", _amount(wanted.end, "s"), "to here", '"10 s"')


def _source_lines(source: Wave | Counts | Stamps) -> Iterator[str]:
    match source:
        case Wave():
            yield _line("wave", _text(source.channel), "the photodiode's wave; or counts, or edges")
        case Counts():
            yield _line("counts", _text(source.channel), "a counter of edges; or wave, or edges")
        case Stamps():
            yield _line("edges", _text(source.channel), "times of edges; or wave, or counts")
            yield _line("falling", _text(source.falling or None), "falling edges, if apart", '"falling"')


def _wheel_lines(wheel: CodeWheel, *, assumed: bool) -> Iterator[str]:
    sectors, pitch = len(wheel.edges), 2.0 * np.pi / len(wheel.edges)
    shift = float(np.clip(round(wheel.edges[1] / pitch - 1.0, 12), -0.9, 0.9))
    if wheel.edges[0] == 0.0 and np.allclose(equal_wheel(sectors, shift).edges, wheel.edges):
        if assumed and sectors == DEFAULT_SECTORS:
            yield _line("# sectors", str(sectors), "assumed, since none was given: bright and dark ones together")
        else:
            yield _line("sectors", str(sectors), "bright and dark ones together")
        yield _line("index_shift", _number(shift + 0.0), "of the edge after angle 0, in sectors; 0: no index")
    else:
        widths = ", ".join(_number(w / pitch) for w in sector_widths(wheel))
        yield f"widths = [{widths}]  # of the sectors, the first one bright"


def _threshold_lines(c: Comparator) -> Iterator[str]:
    yield _line("inverted", _flag(c.inverted), "true: a bright sector gives the lower value")
    yield ""
    yield "[threshold]"
    level = '"automatic"' if c.level is None else _number(c.level)
    yield _line("level", level, "midway between the plateaus, or a number in the unit of the channel")
    yield _line("hysteresis", _number(c.hysteresis), "whole band, as a share of the swing")
    yield _line("interpolated", _flag(c.interpolated), "crossing times between the samples")


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
    "index_turns": "revolutions that have to agree about the index; 0 where there is none",
}


def _filter_lines(wanted: Estimation) -> Iterator[str]:
    yield "[filter]"
    yield _line("fit", _flag(wanted.fit), "true: the next two are fitted to the beginning of the log", width=46)
    for name, kind in FILTER_KINDS.items():
        value = getattr(wanted.filter, name)
        shown = _number(value) if kind.unit == "1" else _amount(value, kind.unit)
        yield _line(name, shown, FILTER_WORDS.get(name, kind.name), width=46)


def _valve_lines(wanted: Estimation) -> Iterator[str]:
    yield "[valve]"
    off = "" if wanted.sections_given else "# "
    yield _line(f"{off}sections", str(wanted.sections), "PWM periods in a revolution of a rotary valve's spool")
    hardest = _amount(wanted.largest_deceleration, "rad/s^2")
    words = "of the shaft; by default speed, at least 155 rad/s, over 28 ms"
    yield _line("largest_deceleration", hardest, words, '"3000 rad/s^2"')


def _pressure_lines(pressure: InletPressure | None) -> Iterator[str]:
    off = "" if pressure is not None else "# "
    known = pressure or InletPressure("inlet pressure", "bar", pressure_edges())
    usual = known.edges
    yield f"{off}[pressure]"
    yield _line(f"{off}channel", _text(known.channel), "of the inlet pressure, for the duty ratio")
    yield _line(f"{off}unit", _text(known.unit or None), "where the log has none; plain units are gauge", '"bar"')
    yield _line(f"{off}fuse", _flag(known.fused), "true: its edges also give the angle, where the encoder is silent")
    yield _line(f"{off}level_share", _number(usual.level_share), "where the crossing level lies in the swing")
    yield _line(f"{off}hysteresis", _number(usual.hysteresis), "of the swing, beyond the level")
    swing = in_unit(usual.least_swing, PRESSURE_DIFFERENCE, "bar")
    yield _line(f"{off}least_swing", _amount(swing, "bar"), "below it nothing switches")
    yield _line(f"{off}level_time", _amount(1e3 * usual.level_time, "ms"), "in which the plateaus are followed")
    yield _line(f"{off}duty_excess", _number(known.duty_excess), "of the wave's duty ratio over the spool's")
    yield _line(f"{off}lag", _amount(1e3 * known.lag, "ms"), "of the wave, with `fuse`")
    deviation = _amount(1e3 * known.lag_deviation, "ms")
    yield _line(f"{off}lag_deviation", deviation, "with `fuse`; above 0 the lag is estimated too")
    yield ""


def _output_lines(wanted: Estimation) -> Iterator[str]:
    yield "[output]"
    words = "by default 1 kHz, or the sample rate where that is less"
    yield _line("rate", _amount(wanted.output_rate, "Hz"), words, '"1 kHz"')
    yield _line("smooth", _flag(wanted.smooth), "also what the whole log shows about each instant")


def _line(key: str, value: str | None, words: str, example: str = "", width: int = 30) -> str:
    """A key with its value, or as a comment with an example of one, and from column `width` on what it is."""
    return (f"# {key} = {example}" if value is None else f"{key} = {value}").ljust(width) + f"# {words}"


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
