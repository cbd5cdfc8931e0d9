"""MDF files, version 3 and 4, through asammdf: every channel on the master of its group, converted as the file says.

Samples that the file marks as invalid are NaN.
"""

import gc
import logging
import sys
from pathlib import Path
from typing import Any

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.errors import ConfigError, unusable
from vvdp.logs.budget import Budget, damage
from vvdp.logs.channel import Log, unique
from vvdp.logs.channel_readers import Leaf, Tree
from vvdp.logs.clock import ClockChoice

_TIME = 1
"""What the specification calls the synchronisation type of a master that is a time."""
_TEXT_CONVERSIONS = range(7, 12)
"""Conversions of the specification whose result is text, or may be."""


def mdf_log(path: Path, choice: ClockChoice) -> Log:
    """The log in an MDF file."""
    file = _open_mdf(path)
    try:
        tree = Tree(path, choice, "/", short=True)
        labels = unique([_label(number, group) for number, group in enumerate(file.groups)])
        for number, group in enumerate(file.groups):
            master, records = file.masters_db.get(number), _Records(file, number)
            tree.budget.count(len(group.channels))
            names = unique([channel.name for channel in group.channels])
            for index, channel in enumerate(group.channels):
                if index != master:
                    _add(tree, records, index, (labels[number], names[index]), channel)
    except (ConfigError, MemoryError):
        raise
    except Exception as problem:  # asammdf raises many unrelated types on damaged files
        raise damage(path, "the MDF file", problem, _library()) from None
    return tree.log(file, _library())


def _library() -> str:
    import asammdf

    return f"asammdf ({asammdf.__version__})"


def _open_mdf(path: Path) -> Any:
    import asammdf

    logging.getLogger("asammdf").setLevel(logging.CRITICAL + 1)  # what matters of it is raised as well
    # An object of asammdf that failed to open a file fails again when it is disposed of, and says so on the terminal.
    usual, sys.unraisablehook = sys.unraisablehook, _unheard
    said = ""
    try:
        return asammdf.MDF(path)
    except MemoryError:
        raise
    except Exception as problem:
        said = str(problem) or type(problem).__name__
    finally:
        if said:
            gc.collect()
        sys.unraisablehook = usual
    raise unusable(path, f"cannot be read as MDF, the file is damaged or cut off ({said})")


def _unheard(_: object) -> None:
    pass


def _label(number: int, group: Any) -> str:
    return getattr(group.channel_group, "acq_name", "") or f"group {number}"


class _Records:
    """The records of a group as they lie in the file; those read last are kept for its other channels."""

    def __init__(self, file: Any, number: int) -> None:
        self.file, self.number = file, number
        self._span = (0, 0)
        self._sound = False
        self._read: list[Any] = []

    def between(self, begin: int, end: int) -> list[Any]:
        """Records from number `begin` up to `end`, in the form that `get` takes."""
        if self._span != (begin, end):
            group = self.file.groups[self.number]
            self._check_blocks(group)
            found = self.file._mdf._load_data(group, record_offset=begin, record_count=end - begin)
            self._read = [_copy(fragment) for fragment in found]
            self._span = (begin, end)
        return self._read

    def _check_blocks(self, group: Any) -> None:
        """Raises ConfigError where a compressed block claims more than can be read at once."""
        if self._sound:
            return
        path = Path(self.file.name)
        sizes = [block.original_size or 0 for block in group.data_blocks if getattr(block, "block_type", 0)]
        if fault := Budget(path).chunk_fault(max(sizes, default=0)):
            raise unusable(path, f"group {self.number} {fault}")
        self._sound = True


def _copy(fragment: Any) -> Any:
    """A fragment of its own: asammdf may fill the same buffer again for the next one."""
    if isinstance(fragment, tuple):  # version 3
        return (bytes(fragment[0]), *fragment[1:])
    return type(fragment)(
        bytes(fragment.data), fragment.record_offset, fragment.record_count, fragment.invalidation_data
    )


class _Samples:
    """A channel of a group, its times and values.

    They are cut from the records that a portion needs: asked for a part of a channel by `record_offset`, asammdf reads
    the whole channel where the file is large.
    """

    def __init__(self, records: _Records, index: int) -> None:
        self._records, self._index = records, index
        self._span = (0, 0)
        self._read: list[Any] = []

    def times(self, begin: int, end: int) -> Array:
        """Times of the master [s]."""
        return _join([np.asarray(signal.timestamps, float) for signal in self._signals(begin, end)])

    def values(self, begin: int, end: int) -> Array:
        """Values, NaN where they are marked as invalid."""
        return _join([_valid(signal) for signal in self._signals(begin, end)])

    def _signals(self, begin: int, end: int) -> list[Any]:
        if self._span != (begin, end):
            file, number = self._records.file, self._records.number
            self._read = [
                file.get(group=number, index=self._index, data=fragment, ignore_invalidation_bits=True)
                for fragment in self._records.between(begin, end)
            ]
            self._span = (begin, end)
        return self._read


def _join(parts: list[Array]) -> Array:
    return parts[0] if len(parts) == 1 else np.concatenate([np.empty(0), *parts])


def _valid(signal: Any) -> Array:
    if signal.samples.dtype.kind not in "fiub" or signal.samples.ndim != 1:
        raise ValueError(f"holds values of type {signal.samples.dtype}")
    values = np.asarray(signal.samples, float)
    return values if signal.invalidation_bits is None else np.where(signal.invalidation_bits, np.nan, values)


def _add(tree: Tree, records: _Records, index: int, path: tuple[str, ...], channel: Any) -> None:
    file, number = records.file, records.number
    group = file.groups[number]
    conversion = channel.conversion
    if conversion is not None and getattr(conversion, "conversion_type", 0) in _TEXT_CONVERSIONS:
        tree.refuse(path, "is shown as text")
        return
    kind = getattr(channel, "dtype_fmt", None)
    if kind is not None and (np.dtype(kind).kind not in "fiub" or np.dtype(kind).shape):
        tree.refuse(path, "holds no numbers")
        return
    unit = str(getattr(conversion, "unit", "") or getattr(channel, "unit", "") or "")
    samples = _Samples(records, index)
    master = file.masters_db.get(number)
    on_time = master is not None and getattr(group.channels[master], "sync_type", _TIME) in (0, _TIME)
    length = int(group.channel_group.cycles_nr)
    tree.add(Leaf(path, length, samples.values, unit, samples.times if on_time else None))
