"""TDMS files of LabVIEW and NI-DAQmx, through npTDMS.

A waveform channel carries its clock (`wf_increment`, `wf_start_offset`, `wf_start_time`); others go by the time
channel of their group. Channels started at different moments keep their distance: times count from the earliest start.

npTDMS reads at least one chunk at a time, and a defragmented file is a single chunk of hours. Where the data lie
plainly in the file, one value after the other or one row after the other, they are therefore read from their places.
"""

import bisect
import io
import logging
from collections.abc import Iterator
from functools import cache
from operator import attrgetter
from pathlib import Path
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np

from vvdp.base.arrays import Array
from vvdp.logs.content import Content, Leaf, Reader, evenly

_BIG_ENDIAN = 1 << 6
_PLAIN = 1 << 20
"""A length [bytes] that need not be held against the file's."""


class _Bounded(io.BufferedReader):
    """A file of which no more is asked than is left: npTDMS asks for as long a text as a damaged file says it is."""

    def read(self, size: int | None = -1) -> bytes:
        """Reads up to `size` bytes."""
        if size is not None and size > _PLAIN:
            here = self.tell()
            size = min(size, self.seek(0, io.SEEK_END) - here)
            self.seek(here)
        return super().read(size)


def read_tdms(content: Content) -> None:
    """Finds what a TDMS file holds."""
    import nptdms

    nptdms.log.log_manager.set_level(logging.CRITICAL)  # what matters of it is a note
    content.short = True
    content.held = _Bounded(io.FileIO(content.path))
    file = nptdms.TdmsFile.open(content.held, raw_timestamps=True)
    channels = [channel for group in file.groups() for channel in group.channels()]
    content.budget.count(len(channels))
    starts = {c.path: s for c in channels if (s := _start(c)) is not None}
    first = min(starts.values(), default=None)
    for channel in channels:
        _add(content, file, channel, _seconds(starts[channel.path], first) if channel.path in starts else 0.0)
    if file.file_status.incomplete_final_segment:
        content.remark("the last segment is incomplete; what it holds is read")


def _add(content: Content, file: Any, channel: Any, shift: float) -> None:
    from nptdms import types

    path, about = (channel.group_name, channel.name), channel.properties
    if channel.data_type is types.TimeStamp:
        content.add(Leaf(path, len(channel), _instants(channel), "s"))
        return
    kind = np.dtype(channel.dtype).kind if channel.data_type is not None else "V"
    if kind not in "fiub":
        content.unreadable[path] = "holds no data" if kind == "V" else "holds no numbers"
        return
    unit = str(about.get("unit_string") or about.get("NI_UnitDescription") or "")
    increment = float(about.get("wf_increment") or 0.0)
    if str(about.get("wf_xunit_string") or "s") != "s":
        increment = 0.0  # a spectrum, say, is a waveform over something else than time
    clock = evenly(shift + float(about.get("wf_start_offset") or 0.0), increment) if increment else None
    content.add(Leaf(path, len(channel), _numbers(content.path, file, channel), unit, clock=clock))


def _start(channel: Any) -> tuple[int, int] | None:
    """When a waveform was started; None where the file does not say (its epoch is 1904)."""
    start = channel.properties.get("wf_start_time")
    if not channel.properties.get("wf_increment") or start is None or start.seconds <= 0:
        return None
    return int(start.seconds), int(start.second_fractions)


def _seconds(instant: Any, origin: Any) -> Any:
    """Seconds from one instant to another, both in whole seconds and 2^-64 seconds: no rounding to a date-time."""
    return instant[0] - origin[0] + (instant[1] - origin[1]) * 2.0**-64


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
    @cache
    def stretches() -> list[_Stretch]:
        try:
            found = list(_stretches(file, channel))
        except AttributeError:  # another npTDMS keeps it elsewhere
            return []
        return found if sum(stretch.samples for stretch in found) == len(channel) else []

    def read(begin: int, end: int) -> Array:
        if not stretches():
            return np.asarray(channel.read_data(begin, end - begin), float)
        raw, scaling = _raw(path, stretches(), begin, end), channel._scaling
        unscaled = SimpleNamespace(data=raw, scaler_data={})  # as the scalings of npTDMS want it
        return np.asarray(raw if scaling is None else scaling.scale(unscaled), float)

    return read


def _raw(path: Path, stretches: list[_Stretch], begin: int, end: int) -> Any:
    parts = []
    with path.open("rb") as file:
        for stretch in stretches[bisect.bisect_right(stretches, begin, key=attrgetter("first")) - 1 :]:
            low, high = max(begin - stretch.first, 0), min(end - stretch.first, stretch.samples)
            if high <= low:
                break
            file.seek(stretch.place + low * stretch.step)
            data = file.read((high - low - 1) * stretch.step + stretch.kind.itemsize)
            parts.append(np.ndarray((high - low,), stretch.kind, data, strides=(stretch.step,)))
    return parts[0] if len(parts) == 1 else np.concatenate(parts)


def _stretches(file: Any, channel: Any) -> Iterator[_Stretch]:
    """Where the samples of a channel lie, as far as that is plain: chunks that are neither packed nor cut off."""
    first = 0
    for segment in file._reader._segments:
        objects = segment._get_data_objects()
        at = next((k for k, item in enumerate(objects) if item.path == channel.path), None)
        if at is None or not objects[at].number_values:
            continue
        own = objects[at]
        if segment._have_daqmx_objects() or own.data_type.nptype is None or segment.final_chunk_lengths_override:
            return
        kind = own.data_type.nptype.newbyteorder(">" if segment.toc_mask & _BIG_ENDIAN else "<")
        in_rows = segment._have_interleaved_data()
        sizes = [item.data_type.size if in_rows else item.data_size for item in objects]
        chunk, step = sum(item.data_size for item in objects), sum(sizes) if in_rows else kind.itemsize
        for k in range(segment.num_chunks):
            place = segment.data_position + k * chunk + sum(sizes[:at])
            yield _Stretch(first, own.number_values, place, step, kind)
            first += own.number_values
