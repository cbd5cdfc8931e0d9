"""Files and result directories that are complete or not there, whatever happens to the process that writes them.

Everything is made under a name of its own, `.NAME.HOST-PROCESS-TOKEN.KIND`, synced, and renamed. It is locked while it
is made, so that a later call on the same host knows what a dead process has left, and clears it away.
"""

import errno
import fcntl
import os
import re
import shutil
from collections.abc import Collection, Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path

from vvdp.base.errors import WriteError, unusable
from vvdp.base.manifest import LIST, Entry, entry_of, has_list, kind_fault, list_text, read_list, refuse_foreign, tree

HOST = re.sub(r"[^A-Za-z0-9]", "_", os.uname().nodename)[:40]
FILE, NEW, OLD = "tmp", "new", "old"
"""A file, a directory that is being made, and one that makes way for it."""
UNFINISHED = re.compile(
    rf"\.(?P<name>.+)\.(?P<host>\w+)-(?P<process>\d+)-(?P<token>[0-9a-f]{{16}})\.(?P<kind>{FILE}|{NEW}|{OLD})"
)
FAULTS_OF_A_DISK = {errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO, errno.EROFS}


def write_whole(path: Path, content: str | bytes) -> None:
    """Writes a file that is never seen in part, and is on the disk when this returns.

    In the folder of a `result_directory`, which is synced as a whole before its renaming, it need not be so earlier.
    Raises WriteError where it cannot be written; nothing of it is left then, and an earlier file is as it was.
    """
    temporary = _sibling_path(path, os.urandom(8).hex(), FILE)
    synced = not any(UNFINISHED.fullmatch(folder.name) for folder in path.parents)
    try:
        try:
            with temporary.open("wb") as file:
                _lock(file.fileno())
                file.write(content.encode() if isinstance(content, str) else content)
                file.flush()
                if synced:
                    os.fsync(file.fileno())
                temporary.replace(path)
        except BaseException:
            temporary.unlink(missing_ok=True)
            raise
        if synced:
            _sync(path.parent)
    except OSError as problem:
        raise write_error(path, problem) from None


@contextmanager
def write_listed(directory: Path, names: Collection[str], *, pages: bool = False) -> Iterator[None]:
    """Lists the files `names`, paths below `directory`, as vvdp's own while they are written in the block.

    Until it ends they are known as unfinished, so that a call that is ended in between can be repeated. `pages` may be
    made again from other files. Raises ConfigError, before anything is written, where one of the names is in use by a
    file that vvdp did not write, or by one that was changed since.
    """
    files = read_list(directory)
    for name in names:
        _refuse_in_use(directory, name, files.get(name))
    written = files | {name: Entry(is_page=pages) for name in names}
    write_whole(directory / LIST, list_text(written))
    for folder in {(directory / name).parent for name in names}:
        folder.mkdir(parents=True, exist_ok=True)
    yield
    whole = {name: entry_of(directory / name, is_page=pages) for name in names if (directory / name).exists()}
    write_whole(directory / LIST, list_text(files | whole))


def list_all(folder: Path) -> None:
    """Lists every file below a `folder` that only vvdp writes to; folders with a list of their own count as a whole."""
    known, found = read_list(folder), dict[str, Entry]()
    for path in tree(folder):
        name = path.relative_to(folder).as_posix()
        inner = [f for f in path.parents if f != folder and f.is_relative_to(folder) and has_list(f)]
        if name != LIST and path.is_file() and (not inner or path == inner[-1] / LIST):
            is_page = name.endswith(f"/{LIST}") or (name in known and known[name].is_page)
            found[name] = entry_of(path, is_page=is_page)
    write_whole(folder / LIST, list_text(found))


def discard(directory: Path, names: Collection[str]) -> None:
    """Deletes the listed files `names` below `directory`; one that was changed since stays, and is no longer listed."""
    files = read_list(directory)
    for name in names:
        is_ours = name in files and not kind_fault(directory, name) and (directory / name).exists()
        if is_ours and entry_of(directory / name)[:2] == files[name][:2]:
            (directory / name).unlink()
    write_whole(directory / LIST, list_text({name: entry for name, entry in files.items() if name not in names}))


def _refuse_in_use(directory: Path, name: str, entry: Entry | None) -> None:
    path = directory / name
    if fault := kind_fault(directory, name):
        raise unusable(path, fault)
    if not path.exists():
        return
    if entry is None:
        raise unusable(path, "is in the way, and vvdp did not write it; move it away")
    if entry.sha256 and not entry.is_page and entry_of(path)[:2] != entry[:2]:
        raise unusable(path, "has changed since it was written; move it away")


@contextmanager
def result_directory(directory: Path, *, force: bool = False) -> Iterator[Path]:
    """A temporary folder that becomes `directory` when the block ends well, and vanishes when it does not.

    With `force` it takes the place of earlier results, which are there until it is whole. All files in it are listed as
    vvdp's own (`base.manifest`). What dead processes have left beside it is cleared away first. Raises ConfigError,
    before anything is run where that can be known, where `directory` exists (without `force`), holds anything that vvdp
    did not write (even with it), is being written by another process, or cannot be written; WriteError where the disk
    fails.
    """
    named, directory = directory, Path(os.path.realpath(directory))
    new = _sibling_path(directory, os.urandom(8).hex(), NEW)
    try:
        clear_unfinished(directory.parent)
        _refuse_to_replace(directory, named, force)
        directory.parent.mkdir(parents=True, exist_ok=True)
        _refuse_company(directory, named)
        new.mkdir()
        lock = os.open(new, os.O_RDONLY)
    except OSError as problem:
        raise unusable(named, f"cannot be written ({problem.strerror}: {problem.filename})") from None
    old = new.with_suffix(f".{OLD}")
    try:
        _lock(lock)
        yield new
        list_all(new)
        _sync_all(new)
        while not _put_in_place(new, directory):
            _refuse_to_replace(directory, named, force)
            _move_aside(directory, old)
        _sync(directory.parent)
    except OSError as problem:
        if problem.errno in FAULTS_OF_A_DISK:
            raise write_error(named, problem) from None
        raise
    finally:
        os.close(lock)
        _settle(directory, {NEW: new, OLD: old})


def clear_unfinished(folder: Path) -> None:
    """Removes from `folder` what dead processes of this host have left there, and finishes what they had nearly done.

    A process that dies between the two renames of an exchange leaves both directories under temporary names: the new
    one, which is whole then, is put in place.
    """
    found: dict[tuple[str, int, str], dict[str, Path]] = {}
    for path in folder.iterdir() if folder.is_dir() else ():
        match = UNFINISHED.fullmatch(path.name)
        if match and match["host"] == HOST:
            known = match["name"], int(match["process"]), match["token"]
            found.setdefault(known, {})[match["kind"]] = path
    for (name, process, _), parts in found.items():
        with suppress(OSError):  # what cannot be removed stays
            if all(_is_abandoned(path, process) for path in parts.values()):
                _settle(folder / name, parts)


def clear_below(directory: Path) -> None:
    """Does what `clear_unfinished` does in `directory` and in every folder below it; links are not followed."""
    for place, _, _ in os.walk(directory):
        clear_unfinished(Path(place))


def write_error(path: Path, problem: OSError) -> WriteError:
    """A `WriteError` about `path`, for a `problem` with it or with something inside of it."""
    return WriteError(problem.errno, problem.strerror or str(problem), str(path))


def _refuse_to_replace(directory: Path, named: Path, force: bool) -> None:
    if not directory.exists():
        return
    if not force:
        raise unusable(named, "already exists; choose another directory or use --force")
    if not directory.is_dir():
        raise unusable(named, "is not a directory")
    clear_below(directory)
    refuse_foreign(directory, named)


def _refuse_company(directory: Path, named: Path) -> None:
    """Raises ConfigError where another process is at work on `directory`: one of the two would work for nothing."""
    for path in directory.parent.iterdir():
        match = UNFINISHED.fullmatch(path.name)
        if match and match["name"] == directory.name and match["kind"] == NEW and _is_locked(path):
            raise unusable(named, f"is being written by process {match['process']}; choose another directory")


def _put_in_place(new: Path, directory: Path) -> bool:
    """Renames `new`; False where something is in its place."""
    try:
        new.rename(directory)
    except OSError as problem:
        if problem.errno in (errno.ENOTEMPTY, errno.EEXIST, errno.ENOTDIR):
            return False
        raise
    return True


def _move_aside(directory: Path, old: Path) -> None:
    shutil.rmtree(old, ignore_errors=True)
    with suppress(FileNotFoundError):  # another process was faster
        directory.rename(old)


def _settle(target: Path, parts: Mapping[str, Path]) -> None:
    """Finishes an exchange that was left between its two renames, and removes what else is left of it."""
    if NEW in parts and OLD in parts and parts[OLD].exists() and not target.exists():
        with suppress(FileNotFoundError):  # another process was faster
            parts[NEW].rename(target)
    for path in parts.values():
        if path.is_dir():
            shutil.rmtree(path, ignore_errors=True)
        else:
            path.unlink(missing_ok=True)


def _sibling_path(path: Path, token: str, kind: str) -> Path:
    return path.with_name(f".{path.name}.{HOST}-{os.getpid()}-{token}.{kind}")


def _is_abandoned(path: Path, process: int) -> bool:
    """Whether no process works on `path` any more; the lock speaks for processes that have numbers of their own."""
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return not _is_locked(path)
    except PermissionError:  # alive, and another person's
        return False
    return False


def _lock(opened: int) -> None:
    """Locks an open file or folder for as long as it is open, where the file system knows locks."""
    with suppress(OSError):
        fcntl.flock(opened, fcntl.LOCK_EX | fcntl.LOCK_NB)


def _is_locked(path: Path) -> bool:
    try:
        opened = os.open(path, os.O_RDONLY)
    except FileNotFoundError:
        return False
    try:
        fcntl.flock(opened, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return True
    except OSError:  # no locks here
        return False
    finally:
        os.close(opened)
    return False


def _sync_all(folder: Path) -> None:
    """Returns when everything in `folder` is on the disk."""
    for place, _, names in os.walk(folder):
        for name in names:
            _sync(Path(place, name))
        _sync(Path(place))


def _sync(path: Path) -> None:
    opened = os.open(path, os.O_RDONLY)
    try:
        os.fsync(opened)
    finally:
        os.close(opened)
