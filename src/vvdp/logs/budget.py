"""What a reader may spend on a file before it believes what the file says of itself.

Logs come from others, some of them damaged, some made to do harm. A file that holds more than any log does, or claims
more than it can hold, is refused before anything of that size is read.
"""

import math
from collections.abc import Hashable
from dataclasses import dataclass, field
from pathlib import Path

from vvdp.base.errors import ConfigError, unusable

MOST_NODES = 10_000
"""Channels, groups and structs."""
DEEPEST = 30
LARGEST_CHUNK = 256 << 20
"""What has to be read at once [bytes]."""
LARGEST_RATIO = 100.0
"""Beyond `LARGEST_CHUNK`, content is at most so many times as large as its file; measured signals stay below 20."""


@dataclass
class Budget:
    """The budget of one file."""

    path: Path
    _nodes: int = 0
    _above: list[Hashable] = field(default_factory=list)

    def count(self, nodes: int = 1) -> None:
        """Counts channels, groups or structs. Raises ConfigError beyond `MOST_NODES`."""
        self._nodes += nodes
        if self._nodes > MOST_NODES:
            raise unusable(self.path, f"holds more than {MOST_NODES} channels and groups; export those of the spool")

    def enter(self, identity: Hashable) -> str:
        """Goes into a group or struct; why that is refused, empty where it is not: then `leave` it."""
        if identity in self._above:
            return "refers to what holds it"
        if len(self._above) >= DEEPEST:
            return "is nested too deeply"
        self._above.append(identity)
        return ""

    def leave(self) -> None:
        """Goes out of the group or struct that was entered last."""
        self._above.pop()

    def chunk_fault(self, size: float) -> str:
        """Why a piece of `size` [bytes] that can only be read as a whole is refused; empty where it is not."""
        return f"is stored in pieces of {_megabytes(size)}, {_MOST_TEXT} at most" if size > LARGEST_CHUNK else ""

    def content_fault(self, size: float) -> str:
        """Why content of `size` [bytes] is refused; empty where it is not."""
        held = self.path.stat().st_size
        if size <= max(LARGEST_CHUNK, LARGEST_RATIO * held):
            return ""
        return f"claims to hold {_megabytes(size)} in a file of {_megabytes(held)}"

    def check_content(self, size: float) -> None:
        """Raises ConfigError for content of a `size` [bytes] that the file cannot hold."""
        if fault := self.content_fault(size):
            raise unusable(self.path, fault)


def _megabytes(size: float) -> str:
    return f"{max(math.ceil(size / 1e6), 1):.4g} MB"


_MOST_TEXT = _megabytes(LARGEST_CHUNK)


def damage(path: Path, where: str, problem: Exception, library: str = "") -> ConfigError:
    """The error for what a library could not read, or for a `library` of another version than vvdp knows."""
    reason = f"{type(problem).__name__}: {problem}" if str(problem) else type(problem).__name__
    if library and isinstance(problem, AttributeError | ImportError | NotImplementedError):
        return unusable(path, f"{where} cannot be read by this version of {library}, or is damaged ({reason})")
    return unusable(path, f"{where} cannot be read, the file is damaged ({reason})")
