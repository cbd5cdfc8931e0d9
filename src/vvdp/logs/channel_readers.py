"""Logs whose channels can be read from anywhere: each is a track with a length, a reader and a clock of its own.

Files made of named arrays (HDF5, MATLAB) do not say which array is the clock of which. The rule, in this order: what
the array itself says (a sample rate, a linked time axis); the time channel that the user named, for every array of
its length; the array named as a time that stands beside it, or else nearest above it; the sample rate that the user
gave. A clock of another length than its channel is a fault of the file and is refused when the channel is read.
"""

from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.errors import ConfigError, unusable
from vvdp.logs.budget import Budget, damage
from vvdp.logs.channel import ChannelInfo, Log, Portion, checked_size, list_names, no_such
from vvdp.logs.clock import ClockChoice, is_time, is_time_name, no_clock, seconds

Reader = Callable[[int, int], Array]
"""Samples from one number up to another."""


@dataclass(frozen=True)
class ChannelReader:
    """A channel that can be read from anywhere. Its clock: times [s], or why there is none."""

    info: ChannelInfo
    samples: int
    values: Reader
    times: Reader | ConfigError


class ChannelLog(Log):
    """A log of tracks."""

    def __init__(
        self, path: Path, tracks: Sequence[ChannelReader], unreadable: Mapping[str, str], held: Any = None
    ) -> None:
        super().__init__(path, held)
        self._tracks = {track.info.name: track for track in tracks}
        self.library = ""
        """What reads the file, where that is another's."""
        self.unreadable = unreadable

    def channels(self) -> tuple[ChannelInfo, ...]:
        """See `Log`."""
        return tuple(track.info for track in self._tracks.values())

    def portions(self, names: Sequence[str], samples: int) -> Iterator[Mapping[str, Portion]]:
        """See `Log`."""
        checked_size(samples)
        chosen = {name: self._tracks[self.channel(name).name] for name in names}
        for track in chosen.values():
            if isinstance(track.times, ConfigError):
                raise track.times
        self.done = 0.0
        return self._portions(chosen, samples)

    def _portions(self, chosen: Mapping[str, ChannelReader], samples: int) -> Iterator[Mapping[str, Portion]]:
        most = max((track.samples for track in chosen.values()), default=0)
        count = -(-most // samples)
        for k in range(count):
            parts = {}
            for name, track in chosen.items():
                begin, end = track.samples * k // count, track.samples * (k + 1) // count
                parts[name] = self._part(track, begin, end)
            self.done = (k + 1) / count
            yield parts
        self.done = 1.0

    def _part(self, track: ChannelReader, begin: int, end: int) -> Portion:
        assert not isinstance(track.times, ConfigError)
        where = f"channel {track.info.name!r}, samples {begin} to {end - 1}"
        try:
            times, values = track.times(begin, end), track.values(begin, end)
        except (ConfigError, MemoryError):
            raise
        except Exception as problem:  # the libraries raise many unrelated types on damaged files
            raise damage(self.path, f"{where}:", problem, self.library) from None
        if not times.size == values.size == end - begin:
            found = f"{values.size} values at {times.size} times"
            raise unusable(self.path, f"{where}: the file is damaged or cut off: {found}; expected {end - begin}")
        return Portion(times, values)


def evenly(start: float, increment: float) -> Reader:
    """The clock of samples that are `increment` [s] apart."""
    return lambda begin, end: start + increment * np.arange(begin, end, dtype=float)


def at_rate(rate: float) -> Reader:
    """The clock of `rate` samples per second, from 0."""
    return lambda begin, end: np.arange(begin, end) / rate


@dataclass(frozen=True)
class Leaf:
    """A vector of numbers somewhere in a file: path of names, how to read it, and the clock that it carries itself."""

    path: tuple[str, ...]
    samples: int
    values: Reader
    unit: str = ""
    clock: Reader | None = None
    clock_path: tuple[str, ...] | None = None
    """Path of the leaf that the file links to it as time axis."""


@dataclass
class Tree:
    """The leaves found in a file of named arrays, from which its tracks are made.

    A leaf goes by its whole path, or with `short` by its last name where that is the only one of its kind.
    """

    path: Path
    choice: ClockChoice
    separator: str
    short: bool = False
    leaves: dict[tuple[str, ...], Leaf] = field(default_factory=dict)
    unreadable: dict[tuple[str, ...], str] = field(default_factory=dict)
    remarks: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.budget = Budget(self.path)

    def add(self, leaf: Leaf) -> None:
        """Adds a leaf; one that claims to be larger than its file can hold is refused."""
        if fault := self.budget.content_fault(8.0 * leaf.samples):
            self.refuse(leaf.path, fault)
            return
        self.leaves[leaf.path] = leaf

    def refuse(self, path: tuple[str, ...], why: str) -> None:
        """Notes what cannot be a channel."""
        self.unreadable[path] = why

    def name(self, path: tuple[str, ...]) -> str:
        """The name of what stands at `path`, once all leaves are there."""
        if self.short and self._last_names[path[-1]] == 1:
            return path[-1]
        return self.separator.join(path)

    @cached_property
    def _last_names(self) -> Counter[str]:
        return Counter(path[-1] for path in [*self.leaves, *self.unreadable])

    @property
    def _refusal(self) -> dict[str, str]:
        return {self.name(path): why for path, why in self.unreadable.items()}

    @cached_property
    def _all_names(self) -> str:
        return list_names([self.name(path) for path in self.leaves])

    def log(self, held: Any = None, library: str = "") -> ChannelLog:
        """The log of all leaves, which a `library` reads. Raises ConfigError where the chosen time channel does not
        exist."""
        chosen = self._choose()
        beside: dict[tuple[str, ...], list[Leaf]] = {}
        for leaf in self.leaves.values():
            if is_time_name(leaf.path[-1]) and leaf.clock is None:
                beside.setdefault(leaf.path[:-1], []).append(leaf)
        tracks = []
        for leaf in self.leaves.values():
            group = self.separator.join(leaf.path[:-1])
            info = ChannelInfo(self.name(leaf.path), leaf.unit, leaf.samples, group)
            tracks.append(ChannelReader(info, leaf.samples, leaf.values, self._clock(leaf, chosen, beside)))
        log = ChannelLog(self.path, tracks, self._refusal, held)
        log.library = library
        log.remarks = tuple(dict.fromkeys(self.remarks))
        return log

    def _choose(self) -> Leaf | None:
        if self.choice.time is None:
            return None
        for leaf in self.leaves.values():
            if self.choice.time in (self.name(leaf.path), self.separator.join(leaf.path)):
                return leaf
        if why := self._refusal.get(self.choice.time):
            raise unusable(self.path, f"time channel {self.choice.time!r} {why}; expected numbers")
        raise no_such(self.path, "time channel", self.choice.time, [self.name(path) for path in self.leaves])

    def _clock(
        self, leaf: Leaf, chosen: Leaf | None, beside: Mapping[tuple[str, ...], list[Leaf]]
    ) -> Reader | ConfigError:
        name = self.name(leaf.path)
        try:
            if leaf.clock is not None:
                self.choice.refuse_rate(self.path, f"of channel {name!r}")
                return leaf.clock
            if (linked := self.leaves.get(leaf.clock_path or ())) and is_time(linked.path[-1], linked.unit):
                return _times(self, linked, leaf)
            if chosen is not None:
                return _times(self, chosen, leaf)
            for depth in range(len(leaf.path) - 1, -1, -1):
                if near := beside.get(leaf.path[:depth]):
                    fitting = [time for time in near if time.samples == leaf.samples] or near
                    if len(fitting) > 1 and leaf not in fitting:
                        names = list_names([self.name(time.path) for time in fitting])
                        raise unusable(self.path, f"channel {name!r} may have several clocks: {names}; name one")
                    return _times(self, leaf if leaf in fitting else fitting[0], leaf)
            if self.choice.rate is not None:
                return at_rate(self.choice.rate)
            raise no_clock(self.path, f"channel {name!r}", self._all_names)
        except ConfigError as problem:
            return problem


def _times(tree: Tree, time: Leaf, leaf: Leaf) -> Reader:
    """The clock of a leaf that another one holds. Raises ConfigError where it is of another length."""
    name = tree.name(time.path)
    tree.choice.refuse_rate(tree.path, f"channel {name!r}")
    if time.samples != leaf.samples:
        lengths = f"{leaf.samples} samples, its time channel {name!r} {time.samples}"
        raise unusable(tree.path, f"channel {tree.name(leaf.path)!r} has {lengths}")
    unit, remark = tree.choice.unit_of(tree.path, name, time.unit)
    if remark:
        tree.remarks.append(remark)
    return lambda begin, end: seconds(time.values(begin, end), unit)
