"""The folder of compiled code: who may write there, what is found damaged, and how much is kept.

A file is written under another name and renamed when it is complete. Its first line is the sum of the rest, so that
damage is found before anything of it is executed.
"""

import functools
import hashlib
import os
import stat
import tempfile
import threading
from contextlib import suppress
from pathlib import Path

from vvdp.base.errors import RunError

ADVICE = "set VVDP_CACHE to a folder of your own"
MOST_BYTES = 2**29
"""Maximum size of the cache; files not used for longest are removed first."""
SUFFIX = ".o"


one_at_a_time = threading.RLock()
"""Held while code is compiled or read: a module is known by its name before it is complete."""


def quiet(message: str) -> None:
    """Says nothing: the default listener."""


def default_cache() -> Path:
    """Where compiled code is kept: `VVDP_CACHE`, else the user's cache folder."""
    if place := os.environ.get("VVDP_CACHE"):
        return Path(place)
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "vvdp"


def check_private(folder: Path) -> None:
    """Raises RunError where others than this user can write to `folder`, or put another one in its place."""
    if not hasattr(os, "getuid"):
        return
    place = folder.resolve()
    for part in (place, *place.parents):
        found = part.stat()
        if found.st_uid != os.getuid() and (part == place or found.st_uid != 0):
            raise RunError(f"compiled code in {folder} is not run, as {part} belongs to another user; {ADVICE}")
        shared = bool(found.st_mode & stat.S_IWOTH) or (bool(found.st_mode & stat.S_IWGRP) and not _is_own_group(found))
        if shared and (part == place or not found.st_mode & stat.S_ISVTX):
            told = f"compiled code in {folder} is not run, as other users may write to {part}"
            raise RunError(f"{told}; chmod go-w {part}, or {ADVICE}")


def _is_own_group(found: os.stat_result) -> bool:
    """Whether a file's group is the one that a user has for himself."""
    import grp
    import pwd

    try:
        user, group = pwd.getpwuid(os.getuid()), grp.getgrgid(found.st_gid)
    except KeyError:
        return False
    return group.gr_gid == user.pw_gid and group.gr_name == user.pw_name and not set(group.gr_mem) - {user.pw_name}


@functools.cache
def _processor() -> str:
    """A word for the kind of processor that code is compiled for, and for the version that compiles."""
    from vvdp.generator import binding

    return hashlib.sha256(f"{binding.processor()} {binding.version()}".encode()).hexdigest()[:8]


def _place(name: str, cache: Path) -> Path:
    return cache / f"{name}-{_processor()}{SUFFIX}"


def is_kept(name: str, cache: Path) -> bool:
    """Whether code of this name need not be compiled."""
    return _place(name, cache).exists()


def read_kept(name: str, cache: Path) -> bytes | None:
    """The code kept by this name; None where there is none, or where it is damaged and has to be made again.

    Raises RunError where others can write to the cache.
    """
    try:
        place = _place(name, cache)
        if not place.exists():
            return None
        check_private(cache)
        found, _, content = place.read_bytes().partition(b"\n")
        if found != hashlib.sha256(content).hexdigest().encode():
            return None
        os.utime(place)
        return content
    except OSError as problem:
        raise _unusable(cache, problem) from None


def keep(name: str, content: bytes, cache: Path) -> None:
    """Keep code by this name. Raises RunError where the cache cannot be written, or can be by others."""
    try:
        cache.mkdir(mode=0o700, parents=True, exist_ok=True)
        check_private(cache)
        with tempfile.NamedTemporaryFile(dir=cache, prefix=f".{name}-", delete=False) as file:
            beside = Path(file.name)
            try:
                file.write(hashlib.sha256(content).hexdigest().encode() + b"\n" + content)
                file.flush()
            except BaseException:  # such as a full disk
                beside.unlink()
                raise
        beside.replace(_place(name, cache))
        with suppress(FileNotFoundError):  # another process makes room as well
            _make_room(cache)
    except OSError as problem:
        raise _unusable(cache, problem) from None


def kept_bytes(cache: Path) -> int:
    """How much is kept, in bytes."""
    return sum(path.stat().st_size for path in cache.glob(f"*{SUFFIX}"))


def _make_room(cache: Path) -> None:
    """Remove what was not used for longest until `MOST_BYTES` are left; another process may do the same."""
    found = sorted((path.stat().st_mtime, path.stat().st_size, path) for path in cache.glob(f"*{SUFFIX}"))
    total = sum(size for _, size, _ in found)
    for _, size, path in found:
        if total <= MOST_BYTES:
            return
        path.unlink(missing_ok=True)
        total -= size


def _unusable(cache: Path, problem: OSError) -> RunError:
    return RunError(f"compiled code cannot be kept in {cache} ({problem.strerror}); {ADVICE}")
