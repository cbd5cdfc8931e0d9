"""The clock of each leaf of a file.

Files made of named arrays (HDF5, MATLAB) and tables do not say it. The rule, in this order: what the array itself says
(a sample rate, a linked time axis); the time channel that the user named, for every array of its length; the array
named as a time that stands beside it, or else nearest above it; the sample rate that the user gave. A clock of another
length than its channel is a fault of the file and is refused.
"""

from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import NamedTuple

from vvdp.base.arrays import Array
from vvdp.base.errors import unusable
from vvdp.logs.clock import is_time, is_time_name, no_clock, seconds
from vvdp.logs.content import Content, Leaf, Names, Reader, at_rate, list_names, no_such


class Clock(NamedTuple):
    """Where the times of a channel come from: a leaf and its unit, or the numbers of the samples."""

    holder: Leaf | None
    unit: str
    by_number: Reader | None

    def times(self, arrays: Mapping[Names, Array], begin: int, samples: int) -> Array:
        """Times of samples [s], the first of which has the number `begin`."""
        if self.by_number is not None:
            return self.by_number(begin, begin + samples)
        assert self.holder is not None
        return seconds(arrays[self.holder.path], self.unit)


class Clocks:
    """The clocks of a file. Raises ConfigError where the user named one that the file does not have."""

    def __init__(self, content: Content) -> None:
        self._content = content
        self._chosen = self._choose()

    def find(self, leaf: Leaf) -> Clock:
        """The clock of a leaf. Raises ConfigError without one that fits."""
        content, choice, name = self._content, self._content.choice, self._content.name(leaf.path)
        if callable(leaf.clock):
            choice.refuse_rate(content.path, f"of channel {name!r}")
            return Clock(None, "s", leaf.clock)
        holder = content.leaves.get(leaf.clock or ())
        if holder is None or not is_time(holder.path[-1], holder.unit):
            holder = self._chosen or self._near(leaf)
        if holder is not None:
            return self._clock_of(holder, leaf)
        if choice.rate is not None:
            return Clock(None, "s", at_rate(choice.rate))
        raise no_clock(content.path, f"channel {name!r}", content.list_channels())

    def _clock_of(self, holder: Leaf, leaf: Leaf) -> Clock:
        content, name = self._content, self._content.name(holder.path)
        content.choice.refuse_rate(content.path, f"channel {name!r}")
        if holder.samples != leaf.samples:
            lengths = f"{leaf.samples} samples, its time channel {name!r} {holder.samples}"
            raise unusable(content.path, f"channel {content.name(leaf.path)!r} has {lengths}")
        unit, remark = content.choice.unit_of(content.path, name, holder.unit)
        if remark:
            content.remark(remark)
        return Clock(holder, unit, None)

    def _choose(self) -> Leaf | None:
        content, wanted = self._content, self._content.choice.time
        if wanted is None:
            return None
        for path in (*content.leaves, *content.unreadable):
            if wanted in (content.name(path), content.separator.join(path)):
                return self._readable(path)
        raise no_such(content.path, "time channel", wanted, [content.name(path) for path in content.leaves])

    def _near(self, leaf: Leaf) -> Leaf | None:
        """The leaf named as a time that stands beside another or nearest above it.

        Raises ConfigError where several may be it; of the columns of a table the first is taken.
        """
        content = self._content
        for depth in range(len(leaf.path) - 1, -1, -1):
            near = [self._readable(path) for path in self._times.get(leaf.path[:depth], ())]
            fitting = [time for time in near if time.samples == leaf.samples] or near
            if leaf in fitting and not content.rows:
                return leaf
            if len(fitting) > 1:
                self._tell_several(leaf, list_names([content.name(time.path) for time in fitting]))
            if fitting:
                return fitting[0]
        return None

    def _tell_several(self, leaf: Leaf, names: str) -> None:
        content = self._content
        if not content.rows:
            problem = f"channel {content.name(leaf.path)!r} may have several clocks: {names}; name one"
            raise unusable(content.path, problem)
        content.remark(f"several columns may be the time ({names}); the first is taken")

    @cached_property
    def _times(self) -> Mapping[Names, Sequence[Names]]:
        """Where leaves named as a time stand; in a table without one its date-times, or what is named so in vain."""
        content, found = self._content, dict[Names, list[Names]]()
        for path, leaf in content.leaves.items():
            if leaf.clock is None and is_time_name(path[-1]):
                found.setdefault(path[:-1], []).append(path)
        if content.rows and not found:
            hidden = [path for path, leaf in content.leaves.items() if leaf.hidden]
            found[()] = hidden or [path for path in content.unreadable if is_time_name(path[-1])]
        return found

    def _readable(self, path: Names) -> Leaf:
        content = self._content
        if path in content.leaves:
            return content.leaves[path]
        fault = f"time channel {content.name(path)!r} {content.unreadable[path]}"
        raise unusable(content.path, f"{fault}; expected numbers or date-times after ISO 8601")
