"""A measured log: channels, each with its own unit and its own clock, read in portions."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple, Self

from vvdp.base.arrays import Array
from vvdp.base.errors import ParameterError, unusable
from vvdp.logs.budget import reading
from vvdp.logs.clocks import Clock, Clocks
from vvdp.logs.content import Content, Leaf, no_such, read_anywhere


@dataclass(frozen=True)
class ChannelInfo:
    """A recorded channel as the file describes it; `name` is unique in the log."""

    name: str
    unit: str  # as written in the file, "" if none
    samples: int | None  # None where unknown before reading
    group: str


class Portion(NamedTuple):
    """Consecutive samples of a channel, as recorded: on its own clock, not resampled, NaN kept."""

    times: Array  # [s]
    values: Array  # in the unit of the channel


class Log:
    """A file of measurements, open for reading. Nothing of it is held but what the current portion needs.

    path        the file
    unreadable  what the file holds under a name that is not a channel of numbers, and why it is none
    done        the fraction of the file that the latest `portions` has gone through, 0 to 1
    """

    def __init__(self, content: Content) -> None:
        self.path = content.path
        self.unreadable: Mapping[str, str] = {content.name(path): why for path, why in content.unreadable.items()}
        self.done = 0.0
        self._content = content
        self._clocks = Clocks(content)
        self._leaves = {content.name(path): leaf for path, leaf in content.leaves.items() if not leaf.hidden}

    @property
    def remarks(self) -> tuple[str, ...]:
        """Notes on what was assumed or left out, for the reader; complete once all portions are read."""
        return tuple(self._content.remarks)

    def channels(self) -> tuple[ChannelInfo, ...]:
        """The channels of the log, in the order of the file."""
        between = self._content.separator
        return tuple(
            ChannelInfo(name, leaf.unit, leaf.samples, between.join(leaf.path[:-1]))
            for name, leaf in self._leaves.items()
        )

    def portions(self, names: Sequence[str], samples: int) -> Iterator[Mapping[str, Portion]]:
        """The channels `names` in portions of about `samples` samples, from beginning to end.

        Every portion holds every name. Where channels have clocks of their own, the parts that come together are
        the same fraction of each channel, not the same stretch of time; a part may be empty.
        Raises ConfigError at once for a name that the log does not have or a channel without a clock, and on the
        way for a file that is damaged further on; ParameterError where `samples` is not positive.
        """
        if samples < 1:
            raise ParameterError(f"portions of {samples} samples; expected at least 1")
        leaves = {name: self._leaves[self.channel(name).name] for name in names}
        clocks = {name: self._clocks.find(leaf) for name, leaf in leaves.items()}
        return self._portions(leaves, clocks, samples)

    def _portions(
        self, leaves: Mapping[str, Leaf], clocks: Mapping[str, Clock], samples: int
    ) -> Iterator[Mapping[str, Portion]]:
        self.done = 0.0
        holders = [clock.holder for clock in clocks.values() if clock.holder is not None]
        needed = {leaf.path: leaf for leaf in (*leaves.values(), *holders)}
        read = self._content.rows or partial(read_anywhere, self._content)
        blocks, begin = read(list(needed.values()), samples), dict.fromkeys(leaves, 0)
        while True:
            with reading(self.path, "what follows", self._content.library):
                block = next(blocks, None)
            if block is None:
                break
            arrays, self.done = block
            portions = {}
            for name, leaf in leaves.items():
                values = arrays[leaf.path]
                portions[name] = Portion(clocks[name].times(arrays, begin[name], values.size), values)
                begin[name] += values.size
            yield portions
        self.done = 1.0

    def close(self) -> None:
        """Closes the file; reading is over."""
        self._content.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def channel(self, name: str) -> ChannelInfo:
        """The channel `name`; `group/name` and a last part that no other channel has do as well.

        Raises ConfigError, with those that exist, where there is none.
        """
        known, between = self.channels(), self._content.separator
        called = [
            (info.name, f"{info.group}/{info.name}", info.name.removeprefix(f"{info.group}{between}")) for info in known
        ]
        for names in zip(*called, strict=True):
            if names.count(name) == 1:
                return known[names.index(name)]
        if name in self.unreadable:
            raise unusable(self.path, f"{name!r} {self.unreadable[name]}; expected a channel of numbers")
        raise no_such(self.path, "channel", name, [info.name for info in known])

    def remark(self, text: str) -> None:
        """Adds a note, once."""
        self._content.remark(text)
