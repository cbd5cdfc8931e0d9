"""The folder of compiled code: who may write there, what is found damaged, and how a module comes out of it.

A module is compiled in a folder of its own beside the final one, which gets its name when it is complete. Its `sums`
are those of all its files, so that damage is seen before anything of it is executed.
"""

import functools
import hashlib
import os
import shutil
import stat
import sys
import tempfile
import threading
import types
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from vvdp.base.errors import RunError
from vvdp.simulation.loading import registries_left_out

TEXT, SUMS = "linked.py", "sums"
ADVICE = "set VVDP_CACHE to a folder of your own"


one_at_a_time = threading.RLock()
"""Held while code is compiled or read: a module is known by its name before it is complete."""


def quiet(message: str) -> None:
    """Says nothing: the default listener."""


def default_cache() -> Path:
    """Where compiled code is kept: `VVDP_CACHE`, else the user's cache folder."""
    if place := os.environ.get("VVDP_CACHE"):
        return Path(place)
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "vvdp"


class Wanted(NamedTuple):
    """A module: its name, its text, the names that it finds around itself, and what to do and say to compile it.

    Where there is nothing to say `announce` returns an empty text.
    """

    name: str
    source: str
    known: Mapping[str, Any]
    prepare: Callable[[], None]
    announce: Callable[[], str]


def load(wanted: Wanted, cache: Path, say: Callable[[str], None]) -> types.ModuleType:
    """The module from its folder in the cache, or compiled into it.

    Raises RunError where the cache cannot be written, or can be by others.
    """
    with one_at_a_time:
        if found := sys.modules.get(_module_name(wanted.name)):
            return found
        try:
            return _read_or_compile(wanted, cache, say)
        except OSError as problem:
            raise RunError(f"compiled code cannot be kept in {cache} ({problem.strerror}); {ADVICE}") from None


def _read_or_compile(wanted: Wanted, cache: Path, say: Callable[[str], None]) -> types.ModuleType:
    cache.mkdir(mode=0o700, parents=True, exist_ok=True)
    check_private(cache)
    folder = cache / f"{wanted.name}-{_processor()}"
    if folder.exists():
        check_private(folder)
        if found := _read_cached(wanted, folder):
            return found
        say(f"compiled code in {folder} is damaged; compiling it anew")
        shutil.rmtree(folder, ignore_errors=True)
    elif words := wanted.announce():
        say(words)
    return _compile(wanted, folder)


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
    """A word for the kind of processor, for which compiled code is."""
    import llvmlite.binding as llvm

    told = f"{llvm.get_host_cpu_name()} {sorted(llvm.get_host_cpu_features().items())}"
    return hashlib.sha256(told.encode()).hexdigest()[:8]


def _sums(folder: Path) -> str:
    files = sorted(path for path in folder.rglob("*") if path.is_file() and path.name != SUMS)
    return "".join(f"{hashlib.sha256(path.read_bytes()).hexdigest()} {path.relative_to(folder)}\n" for path in files)


def _read_cached(wanted: Wanted, folder: Path) -> types.ModuleType | None:
    """The module in `folder`; None where it is not what was put there."""
    try:
        if (folder / TEXT).read_text() != wanted.source or (folder / SUMS).read_text() != _sums(folder):
            return None
        return _execute(wanted, folder)
    except Exception:  # whatever is wrong with it: it is compiled anew, and what is wrong then is told
        return None


def _compile(wanted: Wanted, folder: Path) -> types.ModuleType:
    """The module compiled, and its folder under its final name."""
    workshop = Path(tempfile.mkdtemp(prefix=f".{wanted.name}-", dir=folder.parent))
    try:
        (workshop / TEXT).write_text(wanted.source)
        wanted.prepare()
        found = _execute(wanted, workshop)
        (workshop / SUMS).write_text(_sums(workshop))
        try:
            workshop.rename(folder)
        except OSError:
            if not folder.exists():  # else another process was faster, with the same text
                raise
        return found
    finally:
        shutil.rmtree(workshop, ignore_errors=True)


def _execute(wanted: Wanted, folder: Path) -> types.ModuleType:
    from numba.core import config as numba_config

    config: Any = numba_config
    found = types.ModuleType(_module_name(wanted.name))
    found.__file__ = str(folder / TEXT)
    found.__dict__.update(wanted.known)
    elsewhere, config.CACHE_DIR = config.CACHE_DIR, ""  # all of a module's code stands beside its text
    sys.modules[found.__name__] = found  # before it runs: Numba's cache looks its functions' module up by name
    try:
        with registries_left_out():
            exec(compile(wanted.source, found.__file__, "exec"), found.__dict__)
    except BaseException:
        del sys.modules[found.__name__]
        raise
    finally:
        config.CACHE_DIR = elsewhere
    return found


def is_loaded(name: str) -> bool:
    """Whether the module of this name is in this process already."""
    return _module_name(name) in sys.modules


def is_kept(name: str, cache: Path) -> bool:
    """Whether the module of this name need not be compiled."""
    return is_loaded(name) or (cache / f"{name}-{_processor()}").exists()


def _module_name(name: str) -> str:
    return f"vvdp_linked_{name}"


def cached_bytes(name: str, make: Callable[[], bytes], cache: Path) -> bytes:
    """What `make` gives, from its file in the cache where it was made before; damage is made anew.

    Raises RunError where the cache cannot be written, or can be by others.
    """
    try:
        cache.mkdir(mode=0o700, parents=True, exist_ok=True)
        check_private(cache)
        place = cache / f"{name}-{_processor()}.o"
        if place.exists():
            told, _, content = place.read_bytes().partition(b"\n")
            if told == hashlib.sha256(content).hexdigest().encode():
                return content
        content = make()
        with tempfile.NamedTemporaryFile(dir=cache, prefix=f".{name}-", delete=False) as file:
            file.write(hashlib.sha256(content).hexdigest().encode() + b"\n" + content)
        Path(file.name).replace(place)
        return content
    except OSError as problem:
        raise RunError(f"compiled code cannot be kept in {cache} ({problem.strerror}); {ADVICE}") from None
