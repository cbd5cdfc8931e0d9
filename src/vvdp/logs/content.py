"""Content of a file as a reader finds it: leaves, each a vector of numbers with the names that lead to it."""

from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.errors import ConfigError, unusable
from vvdp.base.tables import suggestion
from vvdp.logs.budget import Budget, reading
from vvdp.logs.clock import ClockChoice

Names = tuple[str, ...]
"""The names that lead to something in a file, from outside in."""
Reader = Callable[[int, int], Array]
"""Samples from one number up to another."""
INSTANTS = "holds date-times"
"""Why a column of date-times is no channel; it comes as seconds from its first one and may be the clock."""


@dataclass(frozen=True)
class Leaf:
    """A vector of numbers in a file.

    samples  None where their number is not known before reading
    values   None where the file can only be read from its beginning
    clock    what the file says of its times: a reader of them [s], or the path of the leaf that holds them
    hidden   whether it is a clock and no channel
    """

    path: Names
    samples: int | None
    values: Reader | None = None
    unit: str = ""
    clock: Reader | Names | None = field(default=None, kw_only=True)
    hidden: bool = field(default=False, kw_only=True)


class Column(NamedTuple):
    """A column of a table: its heading, and why it is no channel of numbers, empty where it is."""

    name: str
    unit: str
    fault: str


Rows = Callable[[Sequence[Leaf], int], Iterator[tuple[Mapping[Names, Array], float]]]
"""Reads leaves in blocks of about so many samples: their values, and the fraction of the file read so far."""


@dataclass
class Content:
    """Content of a file, which its reader fills in.

    separator  stands between the names that lead to a leaf
    short      a leaf goes by its last name where it is the only one of that name
    rows       reads a file that is a table, where all leaves have one clock
    columns    of a table in the order of the file, whether they can be read or not
    held       what is to be closed
    library    what reads the file, with its version
    """

    path: Path
    choice: ClockChoice
    separator: str = "/"
    short: bool = False
    rows: Rows | None = None
    held: Any = None
    library: str = ""
    columns: Sequence[Names] = ()
    leaves: dict[Names, Leaf] = field(default_factory=dict)
    unreadable: dict[Names, str] = field(default_factory=dict)
    remarks: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.budget = Budget(self.path)

    def add(self, leaf: Leaf) -> None:
        """Adds a leaf; one that claims to be larger than its file can hold is refused."""
        if fault := self.budget.content_fault(8.0 * (leaf.samples or 0)):
            self.unreadable[leaf.path] = fault
        else:
            self.leaves[leaf.path] = leaf

    def add_table(self, columns: Sequence[Column], count: int | None, rows: Rows) -> None:
        """Adds all columns of a table of `count` rows, each by its number: `rows` reads them."""
        self.budget.count(len(columns))
        self.budget.check_content(8.0 * (count or 0))
        self.rows = rows
        self.columns = [(name,) for name in unique([column.name for column in columns])]
        for path, column in zip(self.columns, columns, strict=True):
            if column.fault:
                self.unreadable[path] = column.fault
            if column.fault == INSTANTS:
                self.add(Leaf(path, count, None, "s", hidden=True))
            elif not column.fault:
                self.add(Leaf(path, count, None, column.unit))

    def remark(self, text: str) -> None:
        """Adds a note, once."""
        if text not in self.remarks:
            self.remarks.append(text)

    def close(self) -> None:
        """Closes what is open."""
        if self.held is not None:
            self.held.close()

    def name(self, path: Names) -> str:
        """The name of what stands at `path`, once all leaves are there."""
        return path[-1] if self.short and self._last_names[path[-1]] == 1 else self.separator.join(path)

    def list_channels(self) -> str:
        """The names of all channels, as a message shows them."""
        return list_names([self.name(path) for path, leaf in self.leaves.items() if not leaf.hidden])

    @cached_property
    def _last_names(self) -> Counter[str]:
        shown = [path for path, leaf in self.leaves.items() if not leaf.hidden]
        return Counter(path[-1] for path in (*shown, *self.unreadable))


def read_anywhere(content: Content, leaves: Sequence[Leaf], samples: int) -> Iterator[tuple[dict[Names, Array], float]]:
    """Leaves that can be read from anywhere in blocks of the same fraction of each; see `Rows`."""
    count = -(-max((leaf.samples or 0 for leaf in leaves), default=0) // samples)
    for k in range(count):
        arrays = {}
        for leaf in leaves:
            assert leaf.values is not None and leaf.samples is not None
            begin, end = leaf.samples * k // count, leaf.samples * (k + 1) // count
            where = f"channel {content.name(leaf.path)!r}, samples {begin} to {end - 1}"
            with reading(content.path, f"{where}:", content.library):
                arrays[leaf.path] = found = leaf.values(begin, end)
            if found.size != end - begin:
                problem = f"the file is damaged or cut off: {found.size} values; expected {end - begin}"
                raise unusable(content.path, f"{where}: {problem}")
        yield arrays, (k + 1) / count


def at_rate(rate: float, start: float = 0.0) -> Reader:
    """The clock of `rate` samples per second, from `start` [s]."""
    return lambda begin, end: start + np.arange(begin, end) / rate


def evenly(start: float, increment: float) -> Reader:
    """The clock of samples that are `increment` [s] apart."""
    return lambda begin, end: start + increment * np.arange(begin, end, dtype=float)


def no_such(path: Path, what: str, name: str, names: Sequence[str]) -> ConfigError:
    """The error for a name that a file does not have among `names`."""
    return unusable(path, f"no {what} {name!r}; channels are {list_names(names)}{suggestion(name, names, 3)}")


def list_names(names: Sequence[str], most: int = 40) -> str:
    """Names as a message shows them, shortened where there are many."""
    if not names:
        return "none"
    rest = f" and {len(names) - most} more" if len(names) > most else ""
    return ", ".join(map(repr, names[:most])) + rest


def unique(names: Sequence[str]) -> list[str]:
    """Names, distinguished by a number where the file has one twice: `v`, `v #2`."""
    found: dict[str, None] = {}
    for name in names:
        candidate, number = name, 1
        while candidate in found:
            number += 1
            candidate = f"{name} #{number}"
        found[candidate] = None
    return list(found)
