"""TDMS files of LabVIEW and NI-DAQmx, through npTDMS.

A waveform channel carries its clock (`wf_increment`, `wf_start_offset`, `wf_start_time`); others go by the time
channel of their group. Channels started at different moments keep their distance: times count from the earliest start.

npTDMS reads at least one chunk at a time, and a defragmented file is a single chunk of hours. Where the data lie
plainly in the file, one value after the other or one row after the other, they are therefore read from their places.
"""

import bisect
import logging
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.errors import ConfigError
from vvdp.logs.budget import damage
from vvdp.logs.channel import Log
from vvdp.logs.channel_readers import Leaf, Reader, Tree, evenly
from vvdp.logs.clock import ClockChoice


def tdms_log(path: Path, choice: ClockChoice) -> Log:
    """The log in a TDMS file."""
    import nptdms

    nptdms.log.log_manager.set_level(logging.CRITICAL)  # what matters of it is a remark
    raw = path.open("rb")
    try:
        file = nptdms.TdmsFile.open(raw, raw_timestamps=True)
        tree = Tree(path, choice, "/", short=True)
        channels = [channel for group in file.groups() for channel in group.channels()]
        tree.budget.count(len(channels))
        starts = {c.path: s for c in channels if (s := _start(c)) is not None}
        first = min(starts.values(), default=None)
        for channel in channels:
            _add(tree, file, channel, _seconds(starts[channel.path], first) if channel.path in starts else 0.0)
        cut_off = file.file_status.incomplete_final_segment
    except (ConfigError, MemoryError):
        raw.close()
        raise
    except Exception as problem:  # npTDMS raises many unrelated types on damaged files
        raw.close()
        raise damage(path, "the TDMS file", problem, "npTDMS") from None
    if cut_off:
        tree.remarks.append("the last segment is incomplete; what it holds is read")
    return tree.log(raw, "npTDMS")


def _add(tree: Tree, file: Any, channel: Any, shift: float) -> None:
    path = (channel.group_name, channel.name)
    if _is_instants(channel):
        tree.add(Leaf(path, len(channel), _instants(channel), "s"))
        return
    kind = np.dtype(channel.dtype).kind if channel.data_type is not None else "V"
    if kind not in "fiub":
        tree.refuse(path, "holds no data" if kind == "V" else "holds no numbers")
        return
    unit = str(channel.properties.get("unit_string") or channel.properties.get("NI_UnitDescription") or "")
    increment = float(channel.properties.get("wf_increment") or 0.0)
    if str(channel.properties.get("wf_xunit_string") or "s") != "s":
        increment = 0.0  # a spectrum, say, is a waveform over something else than time
    clock = evenly(shift + float(channel.properties.get("wf_start_offset") or 0.0), increment) if increment else None
    tree.add(Leaf(path, len(channel), _numbers(tree.path, file, channel), unit, clock))


def _start(channel: Any) -> tuple[int, int] | None:
    """When a waveform was started; None where the file does not say (its epoch is 1904)."""
    start = channel.properties.get("wf_start_time")
    if not channel.properties.get("wf_increment") or start is None or start.seconds <= 0:
        return None
    return int(start.seconds), int(start.second_fractions)


def _seconds(instant: Any, origin: Any) -> Any:
    """Seconds from one instant to another, both in whole seconds and 2^-64 seconds: no rounding to a date-time."""
    return instant[0] - origin[0] + (instant[1] - origin[1]) * 2.0**-64


def _is_instants(channel: Any) -> bool:
    from nptdms import types

    return channel.data_type is types.TimeStamp


def _instants(channel: Any) -> Reader:
    def read(begin: int, end: int) -> Array:
        first, found = channel.read_data(0, 1), channel.read_data(begin, end - begin)
        origin = float(first.seconds[0]), float(first.second_fractions[0])
        return np.asarray(_seconds((found.seconds.astype(float), found.second_fractions.astype(float)), origin))

    return read


class _Stretch(NamedTuple):
    """Samples from number `first` on that lie `step` bytes apart from `place` on."""

    first: int
    samples: int
    place: int
    step: int
    kind: Any


def _numbers(path: Path, file: Any, channel: Any) -> Reader:
    found: list[list[_Stretch] | None] = []

    def read(begin: int, end: int) -> Array:
        if not found:
            found.append(_stretches(file, channel))
        if found[0] is None:
            return np.asarray(channel.read_data(begin, end - begin), float)
        raw = _raw(path, found[0], begin, end)
        scaling = channel._scaling
        return np.asarray(raw if scaling is None else scaling.scale(_Raw(raw)), float)

    return read


class _Raw:
    """Unscaled values as the scalings of npTDMS want them."""

    def __init__(self, data: Any) -> None:
        self.data = data
        self.scaler_data: dict[int, Any] = {}


def _raw(path: Path, stretches: list[_Stretch], begin: int, end: int) -> Any:
    parts = []
    with path.open("rb") as file:
        for stretch in stretches[bisect.bisect_right(stretches, begin, key=_first) - 1 :]:
            if stretch.first >= end:
                break
            low, high = max(begin - stretch.first, 0), min(end - stretch.first, stretch.samples)
            if high <= low:
                continue
            file.seek(stretch.place + low * stretch.step)
            data = file.read((high - low - 1) * stretch.step + stretch.kind.itemsize)
            parts.append(np.ndarray((high - low,), stretch.kind, data, strides=(stretch.step,)))
    return parts[0] if len(parts) == 1 else np.concatenate(parts)


def _first(stretch: _Stretch) -> int:
    return stretch.first


def _stretches(file: Any, channel: Any) -> list[_Stretch] | None:
    """Where the samples of a channel lie; None where that is not plain, or another npTDMS keeps it elsewhere."""
    stretches: list[_Stretch] = []
    first = 0
    try:
        for segment in file._reader._segments:
            own = segment.get_segment_object(channel.path)
            if own is None or not own.has_data or not own.number_values:
                continue
            if segment._have_daqmx_objects() or own.data_type.nptype is None:
                return None
            kind = own.data_type.nptype.newbyteorder(">" if segment.toc_mask & _BIG_ENDIAN else "<")
            for place, step, samples in _chunks(segment, own, kind.itemsize):
                if samples:
                    stretches.append(_Stretch(first, samples, place, step, kind))
                    first += samples
    except AttributeError:
        return None
    return stretches if first == len(channel) else None


_BIG_ENDIAN = 1 << 6


def _chunks(segment: Any, own: Any, width: int) -> list[tuple[int, int, int]]:
    """Place of the first sample, distance of samples and their number, for each chunk of a segment."""
    objects = segment._get_data_objects()
    before = objects[: [item.path for item in objects].index(own.path)]
    shortened = segment.final_chunk_lengths_override
    size = sum(item.data_size for item in objects)
    found = []
    for k in range(segment.num_chunks):
        last = shortened is not None and k == segment.num_chunks - 1
        length: Callable[[Any], int] = (
            (lambda item: shortened.get(item.path, 0)) if last else (lambda item: item.number_values)
        )
        begin = segment.data_position + k * size
        if segment._have_interleaved_data():
            offset, step = sum(item.data_type.size for item in before), sum(item.data_type.size for item in objects)
        else:
            offset, step = sum(length(item) * item.data_type.size if last else item.data_size for item in before), width
        found.append((begin + offset, step, length(own)))
    return found
