"""What a measured log is: channels, each with its own unit and its own clock, read in portions."""

from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple, Self

from vvdp.base.arrays import Array
from vvdp.base.errors import ConfigError, ParameterError, unusable
from vvdp.base.tables import suggestion


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


class Log(ABC):
    """A file of measurements, open for reading. Nothing of it is held but what the current portion needs.

    path        the file
    remarks     what was taken for granted or left out, for the reader to see; complete once all portions are read
    unreadable  what the file holds under a name that is not a channel of numbers, and why it is none
    done        the fraction of the file that the latest `portions` has gone through, 0 to 1
    """

    def __init__(self, path: Path, held: Any = None) -> None:
        self.path = path
        self._held = held
        self.remarks: tuple[str, ...] = ()
        self.unreadable: Mapping[str, str] = {}
        self.done = 0.0

    @abstractmethod
    def channels(self) -> tuple[ChannelInfo, ...]:
        """The channels of the log, in the order of the file."""

    @abstractmethod
    def portions(self, names: Sequence[str], samples: int) -> Iterator[Mapping[str, Portion]]:
        """The channels `names` in portions of about `samples` samples, from beginning to end.

        Every portion holds every name. Where channels have clocks of their own, the parts that come together are
        the same fraction of each channel, not the same stretch of time; a part may be empty.
        Raises ConfigError at once for a name that the log does not have or a channel without a clock, and on the
        way for a file that is damaged further on; ParameterError where `samples` is not positive.
        """

    def close(self) -> None:
        """Closes the file; reading is over."""
        if self._held is not None:
            self._held.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def channel(self, name: str) -> ChannelInfo:
        """The channel `name`; `group/name` and a last part that no other channel has do as well.

        Raises ConfigError, with those that exist, where there is none.
        """
        known = self.channels()
        for called in (_own_name, _name_with_group, _last_part):
            found = [info for info in known if called(info) == name]
            if len(found) == 1:
                return found[0]
        if name in self.unreadable:
            raise unusable(self.path, f"{name!r} {self.unreadable[name]}; expected a channel of numbers")
        raise no_such(self.path, "channel", name, [info.name for info in known])

    def remark(self, text: str) -> None:
        """Adds a remark, once."""
        if text not in self.remarks:
            self.remarks += (text,)


def _own_name(info: ChannelInfo) -> str:
    return info.name


def _name_with_group(info: ChannelInfo) -> str:
    return f"{info.group}/{info.name}"


def _last_part(info: ChannelInfo) -> str:
    return info.name[len(info.group) + 1 :] if info.group and info.name.startswith(info.group) else info.name


def no_such(path: Path, what: str, name: str, names: Sequence[str]) -> ConfigError:
    """The error for a name that a file does not have among `names`."""
    return unusable(path, f"no {what} {name!r}; channels are {list_names(names)}{suggestion(name, names, 3)}")


def checked_size(samples: int) -> int:
    """`samples` per portion. Raises ParameterError unless positive."""
    if samples < 1:
        raise ParameterError(f"portions of {samples} samples; expected at least 1")
    return samples


def list_names(names: Sequence[str], most: int = 40) -> str:
    """Names as a message shows them, shortened where there are many."""
    if not names:
        return "none"
    rest = f" and {len(names) - most} more" if len(names) > most else ""
    return ", ".join(map(repr, names[:most])) + rest


def unique(names: Sequence[str]) -> list[str]:
    """Names, told apart by a number where the file has one twice: `v`, `v #2`."""
    taken: set[str] = set()
    found = []
    for name in names:
        candidate, number = name, 1
        while candidate in taken:
            number += 1
            candidate = f"{name} #{number}"
        taken.add(candidate)
        found.append(candidate)
    return found
