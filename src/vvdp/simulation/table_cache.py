"""Tables of numbers kept in the cache: what was calculated once from the same values by the same code is read.

Beside the compiled code, since it goes out of date with it. A file begins with the hash of its own bytes, so that a
damaged one is calculated again; the oldest make room.
"""

import contextlib
import hashlib
import io
import os
import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np

from vvdp.base.arrays import Array
from vvdp.simulation.cache import default_cache

FOLDER = "tables"
MOST = 100
"""Tables that are kept."""
_SUM = hashlib.sha256().digest_size


def table_key(digest: str, *values: Array) -> str:
    """Key of a table: the hash of the code that makes it, and of all values that it is made from."""
    found = hashlib.sha256(digest.encode())
    for value in values:
        found.update(repr(value.shape).encode() + np.ascontiguousarray(value, float).tobytes())
    return found.hexdigest()[:32]


def kept_table(key: str, make: Callable[[], Array], cache: Path | None = None) -> Array:
    """The table known by `key`, read where it was made before, else made and kept.

    Where nothing can be kept it is made each time.
    """
    path = (cache or default_cache()) / FOLDER / f"{key}.table"
    if (found := _read(path)) is not None:
        return found
    made = make()
    with contextlib.suppress(OSError):
        _write(path, made)
    return made


def _read(path: Path) -> Array | None:
    try:
        content = path.read_bytes()
        if hashlib.sha256(content[_SUM:]).digest() != content[:_SUM]:
            return None
        found: Array = np.load(io.BytesIO(content[_SUM:]), allow_pickle=False)
        return found
    except (OSError, ValueError):
        return None


def _write(path: Path, table: Array) -> None:
    path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
    content = io.BytesIO()
    np.save(content, table, allow_pickle=False)
    handle, name = tempfile.mkstemp(dir=path.parent)
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(hashlib.sha256(content.getvalue()).digest() + content.getvalue())
        Path(name).replace(path)
    except OSError:
        Path(name).unlink(missing_ok=True)
        raise
    tables = sorted(path.parent.glob("*.table"), key=lambda each: each.stat().st_mtime)
    for old in tables[:-MOST]:
        old.unlink(missing_ok=True)
