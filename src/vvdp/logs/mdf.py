"""MDF files, version 3 and 4, through asammdf: every channel on the master of its group, converted as the file says.

Samples that the file marks as invalid are NaN.
"""

import gc
import logging
import sys
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import lru_cache
from typing import Any

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.errors import unusable
from vvdp.logs.content import Content, Leaf, Reader, unique
from vvdp.logs.mdf_blocks import bounded_blocks, check_lists

_TIME = 1
"""Synchronisation type, in the specification, of a master channel that is a time."""
_TEXT_CONVERSIONS = range(7, 12)
"""Conversions of the specification whose result is text, or may be."""
Fragments = Callable[[int, int], list[Any]]
"""Records from one number up to another, in the form in which asammdf takes them."""


def read_mdf(content: Content) -> None:
    """Finds what an MDF file holds."""
    import asammdf

    check_lists(content.path)
    with _quiet(), bounded_blocks():
        file: Any = asammdf.MDF(content.path)
    content.held = file
    if not callable(getattr(file._mdf, "_load_data", None)):
        raise unusable(content.path, f"cannot be read with {content.library}, which loads no part of the records")
    content.short = True
    names = [getattr(group.channel_group, "acq_name", "") for group in file.groups]
    labels = unique([name or f"group {number}" for number, name in enumerate(names)])
    for number, group in enumerate(file.groups):
        content.budget.count(len(group.channels))
        _add_group(content, number, group, labels[number])


@contextmanager
def _quiet() -> Iterator[None]:
    """asammdf says nothing on the terminal; what matters of it is raised as well.

    An object of asammdf that failed to open a file fails again when it is disposed of.
    """
    logging.getLogger("asammdf").setLevel(logging.CRITICAL + 1)
    usual, sys.unraisablehook = sys.unraisablehook, lambda _: None
    try:
        yield
    except Exception as problem:
        traceback.clear_frames(problem.__traceback__)
        gc.collect()
        raise
    finally:
        sys.unraisablehook = usual


def _add_group(content: Content, number: int, group: Any, label: str) -> None:
    fragments, master = _fragments(content, number), content.held.masters_db.get(number)
    length, clock = int(group.channel_group.cycles_nr), None
    names = unique([channel.name for channel in group.channels])
    if master is not None and getattr(group.channels[master], "sync_type", _TIME) in (0, _TIME):
        clock = (label, names[master])
        content.add(Leaf(clock, length, _times(content.held, number, fragments), "s", hidden=True))
    for index, channel in enumerate(group.channels):
        path, conversion = (label, names[index]), channel.conversion
        if index == master:
            continue
        if fault := _fault(channel):
            content.unreadable[path] = fault
            continue
        unit = str(getattr(conversion, "unit", "") or getattr(channel, "unit", "") or "")
        content.add(Leaf(path, length, _values(content.held, number, index, fragments), unit, clock=clock))


def _fault(channel: Any) -> str:
    """Why a channel is none of numbers; empty where it is."""
    if getattr(channel.conversion, "conversion_type", 0) in _TEXT_CONVERSIONS:
        return "is shown as text"
    kind = getattr(channel, "dtype_fmt", None)
    return "holds no numbers" if kind is not None and not _is_numbers(np.dtype(kind)) else ""


def _is_numbers(kind: Any) -> bool:
    return kind.kind in "fiub" and not kind.shape


def _fragments(content: Content, number: int) -> Fragments:
    """The records of a group; those read last are kept for its other channels.

    Only those that a portion needs: asked for a part of a channel, asammdf reads the whole where the file is large.
    """
    file, group = content.held, content.held.groups[number]

    @lru_cache(1)
    def fragments(begin: int, end: int) -> list[Any]:
        sizes = [block.original_size or 0 for block in group.data_blocks if getattr(block, "block_type", 0)]
        if fault := content.budget.chunk_fault(max(sizes, default=0)):
            raise unusable(content.path, f"group {number} {fault}")
        with bounded_blocks():
            parts = file._mdf._load_data(group, record_offset=begin, record_count=end - begin)
            return [_copy(part) for part in parts]

    return fragments


def _copy(part: Any) -> Any:
    """A fragment of its own: asammdf may fill the same buffer again for the next one."""
    if isinstance(part, tuple):  # version 3
        return (bytes(part[0]), *part[1:])
    return type(part)(bytes(part.data), part.record_offset, part.record_count, part.invalidation_data)


def _times(file: Any, number: int, fragments: Fragments) -> Reader:
    """Reads the master of a group [s]."""

    def read(begin: int, end: int) -> Array:
        return _join(
            [np.asarray(file.get_master(number, part, one_piece=True), float) for part in fragments(begin, end)]
        )

    return read


def _values(file: Any, number: int, index: int, fragments: Fragments) -> Reader:
    """Reads a channel of a group, NaN where samples are marked as invalid."""

    def read(begin: int, end: int) -> Array:
        found = []
        for part in fragments(begin, end):
            samples, invalid = file.get(
                group=number, index=index, data=part, samples_only=True, ignore_invalidation_bits=True
            )
            if not _is_numbers(samples.dtype) or samples.ndim != 1:
                raise ValueError(f"holds values of type {samples.dtype}")
            values = np.asarray(samples, float)
            found.append(values if invalid is None else np.where(invalid, np.nan, values))
        return _join(found)

    return read


def _join(parts: list[Array]) -> Array:
    return parts[0] if len(parts) == 1 else np.concatenate([np.empty(0), *parts])
