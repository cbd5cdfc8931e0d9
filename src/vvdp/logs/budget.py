"""Limits of what a reader may spend on a file before it believes what the file says of itself.

Logs come from others, some of them damaged, some made to do harm. A file that holds more than any log does, or claims
more than it can hold, is refused before anything of that size is read.
"""

import math
import zlib
from collections.abc import Hashable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

from vvdp.base.errors import VvdpError, unusable

MOST_NODES = 10_000
"""Channels, groups and structs."""
DEEPEST = 30
LARGEST_CHUNK = 256 << 20
"""Largest content that may have to be read at once [bytes]."""
LARGEST_RATIO = 100.0
"""Beyond `LARGEST_CHUNK`, content is at most so many times as large as its file; measured signals stay below 20."""

_PIECE = 1 << 16


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

    @contextmanager
    def inside(self, identity: Hashable) -> Iterator[str]:
        """While the content of a group or struct is read; why it must not be, empty where it may."""
        if identity in self._above:
            yield "refers to what holds it"
        elif len(self._above) >= DEEPEST:
            yield "is nested too deeply"
        else:
            self._above.append(identity)
            yield ""
            self._above.pop()

    def chunk_fault(self, size: float) -> str:
        """Why a piece of `size` [bytes] that can only be read as a whole is refused; empty where it is not."""
        most = _megabytes(LARGEST_CHUNK)
        return f"is stored in pieces of {_megabytes(size)}, {most} at most" if size > LARGEST_CHUNK else ""

    @property
    def largest_content(self) -> float:
        """The most that the file can be believed to hold [bytes]."""
        return max(LARGEST_CHUNK, LARGEST_RATIO * self.path.stat().st_size)

    def content_fault(self, size: float) -> str:
        """Why content of `size` [bytes] is refused; empty where it is not."""
        if size <= self.largest_content:
            return ""
        return f"claims to hold {_megabytes(size)} in a file of {_megabytes(self.path.stat().st_size)}"

    def check_content(self, size: float) -> None:
        """Raises ConfigError for content of a `size` [bytes] that the file cannot hold."""
        if fault := self.content_fault(size):
            raise unusable(self.path, fault)


def _megabytes(size: float) -> str:
    return f"{max(math.ceil(size / 1e6), 1):.4g} MB"


def unpack(packed: bytes, most: int) -> bytearray:
    """Content that zlib has packed; no more than a megabyte beyond `most` bytes."""
    unpacker, found = zlib.decompressobj(), bytearray()
    for at in range(0, len(packed), _PIECE):
        piece = packed[at : at + _PIECE]
        while piece and len(found) <= most:
            found += unpacker.decompress(piece, 16 * _PIECE)
            piece = unpacker.unconsumed_tail
    return found


@contextmanager
def reading(path: Path, what: str, library: str) -> Iterator[None]:
    """While a `library` reads `what` of a file: whatever it raises on damaged content becomes a ConfigError.

    What only a mistake or another version of the library raises is reported as such.
    """
    try:
        yield
    except (VvdpError, MemoryError):
        raise
    except Exception as problem:  # the libraries raise many unrelated types on damaged files
        reason = f"{type(problem).__name__}: {problem}" if str(problem) else type(problem).__name__
        if isinstance(problem, AttributeError | ImportError | NotImplementedError | TypeError):
            raise unusable(path, f"{what} cannot be read with {library}, or the file is damaged ({reason})") from None
        raise unusable(path, f"{what} cannot be read, the file is damaged or cut off ({reason})") from None
