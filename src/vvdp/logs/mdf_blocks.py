"""Checks that asammdf leaves out for an MDF file: that lists of blocks end, and the size that packed blocks unpack
to."""

import struct
import zlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from vvdp.base.errors import unusable
from vvdp.logs.budget import LARGEST_CHUNK

_LISTED = (b"##DG", b"##CG", b"##CN", b"##DL", b"##LD", b"##EV", b"##AT", b"##FH", b"DG", b"CG", b"CN")
"""Blocks whose first link leads to the next one of their kind."""
_HEADER = 64
"""Where the header block begins."""
_MOST_LINKS = 1 << 16


def check_lists(path: Path) -> None:
    """Raises ConfigError where a list of blocks leads back into itself: it would be followed without end."""
    following = _following_blocks(path)
    sound = {0}
    for place in following:
        trail: set[int] = set()
        while place in following and place not in sound:
            if place in trail:
                raise unusable(path, "holds a list of blocks that leads back into itself, the file is damaged")
            trail.add(place)
            place = following[place]
        sound |= trail


def _following_blocks(path: Path) -> dict[int, int]:
    """The place of each block that can be reached from the header, and of the one that follows it in its list."""
    following, waiting = {}, [_HEADER]
    with path.open("rb") as file:
        version = file.read(32)[8:12]
        links = _links4 if version >= b"4" else _links3
        while waiting:
            place = waiting.pop()
            if place in following or not place:
                continue
            file.seek(min(place, 1 << 62))
            kind, found = links(file)
            following[place] = found[0] if kind in _LISTED and found else 0
            waiting += found
    return following


def _links4(file: Any) -> tuple[bytes, tuple[int, ...]]:
    """Kind and links of a block of version 4."""
    head = file.read(24)
    if len(head) < 24 or head[:2] != b"##":
        return b"", ()
    number = min(struct.unpack("<Q", head[16:])[0], _MOST_LINKS)
    held = file.read(8 * number)
    return head[:4], struct.unpack(f"<{len(held) // 8}Q", held[: len(held) // 8 * 8])


def _links3(file: Any) -> tuple[bytes, tuple[int, ...]]:
    """Kind and the two links that may lead to lists of a block of version 3."""
    held = file.read(12)
    return held[:2], struct.unpack("<2I", held[4:]) if len(held) == 12 and held[:2] in (b"HD", *_LISTED) else ()


@contextmanager
def bounded_blocks() -> Iterator[None]:
    """While asammdf reads: no block unpacks to more than may be read at once."""
    from asammdf.blocks import mdf_v4

    functions: dict[int, Callable[[bytes], bytes]] = vars(mdf_v4)["DECOMPRESS_FUNC_MAP"]
    usual = dict(functions)
    functions.update({kind: _unpack for kind, unpack in usual.items() if "zlib" in str(unpack.__module__)})
    try:
        yield
    finally:
        functions.update(usual)


def _unpack(packed: bytes) -> bytes:
    unpacker = _fastest().decompressobj()
    found: bytes = unpacker.decompress(packed, LARGEST_CHUNK)
    if not unpacker.eof:
        raise ValueError("a block is cut off, or unpacks to more than can be read at once")
    return found


def _fastest() -> Any:
    """Library for unpacking that asammdf brings along, or Python's own if it is not installed."""
    return import_module("isal.isal_zlib") if find_spec("isal") else zlib
