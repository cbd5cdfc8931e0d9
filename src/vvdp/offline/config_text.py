"""The settings of an estimation as a TOML file: every key, with a comment to each."""

import json
from collections.abc import Iterator, Sequence

import numpy as np

from vvdp.base.kinds import PRESSURE_DIFFERENCE
from vvdp.base.units import in_unit
from vvdp.estimation.pressure_edges import pressure_edges
from vvdp.logs.channel import ChannelInfo
from vvdp.offline.config import DEFAULT_SECTORS, FILTER_KINDS, Counts, Estimation, InletPressure, Stamps, Wave
from vvdp.sensing.wheel import CodeWheel, equal_wheel, sector_widths


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
    yield from _wheel_lines(wanted.wheel, assumed=wanted.sectors_assumed)
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
    off = "" if wanted.sections_given else "# "
    yield f"{off}sections = {wanted.sections}".ljust(30) + "# PWM periods in a revolution of a rotary valve's spool"
    hardest = _amount(wanted.largest_deceleration, "rad/s^2")
    yield from _optional(
        "largest_deceleration",
        hardest,
        '"3000 rad/s^2"',
        "of the shaft; by default speed, at least 155 rad/s, over 28 ms",
    )
    yield ""
    yield from _pressure_lines(wanted.pressure)
    yield "[output]"
    yield from _optional(
        "rate", _amount(wanted.output_rate, "Hz"), '"1 kHz"', "by default 1 kHz, or the sample rate where that is less"
    )
    yield f"smooth = {_flag(wanted.smooth)}".ljust(30) + "# also what the whole log shows about each instant"


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


def _source_lines(source: Wave | Counts | Stamps) -> Iterator[str]:
    match source:
        case Wave():
            yield f"wave = {_text(source.channel)}".ljust(30) + "# the photodiode's wave; or counts, or edges"
        case Counts():
            yield f"counts = {_text(source.channel)}".ljust(30) + "# a counter of edges; or wave, or edges"
        case Stamps():
            yield f"edges = {_text(source.channel)}".ljust(30) + "# times of edges; or wave, or counts"
            yield from _optional("falling", _text(source.falling or None), '"falling"', "falling edges, if apart")


def _wheel_lines(wheel: CodeWheel, *, assumed: bool) -> Iterator[str]:
    sectors, pitch = len(wheel.edges), 2.0 * np.pi / len(wheel.edges)
    shift = float(np.clip(round(wheel.edges[1] / pitch - 1.0, 12), -0.9, 0.9))
    if wheel.edges[0] == 0.0 and np.allclose(equal_wheel(sectors, shift).edges, wheel.edges):
        if assumed and sectors == DEFAULT_SECTORS:
            yield f"# sectors = {sectors}".ljust(30) + "# assumed, since none was given: bright and dark ones together"
        else:
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
    yield f"{off}fuse = {fuse}".ljust(30) + "# true: its edges also give the angle, where the encoder is silent"
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
