"""The index of a study's files: an SQLite database beside them.

    files(name, size, changed)                       each file of cases as it was when it was read
    cases(key, file, failure, settings, summary)     its cases; settings and summary are JSON

It may be missing, damaged, locked or behind at any time: it then knows less, and its files are read instead. A file of
that name which is not ours, known by its `application_id`, is renamed and never opened; a link is neither.
"""

import itertools
import os
import sqlite3
import stat
import time
from collections.abc import Iterable, Iterator, Mapping
from contextlib import closing, contextmanager, suppress
from pathlib import Path
from typing import NamedTuple
from urllib.parse import quote

from vvdp.base.errors import unusable

NAME = "index.sqlite"
VERSION = 1
APPLICATION = 0x76766470
"""By which a database is known as an index of vvdp: "vvdp" in ASCII."""
HEADER = b"SQLite format 3\0"
ID_AT = slice(68, 72)
"""Where the header of a database has its `application_id`."""
COMPANIONS = ("journal", "wal", "shm")
WAITING = 5.0
"""Time [s] for which another process may hold the index."""

TABLES = f"""
pragma application_id = {APPLICATION};
pragma user_version = {VERSION};
create table if not exists files (name text primary key, size integer, changed integer);
create table if not exists cases (
    key text, file text, failure text, settings text, summary text, primary key (key, file)
);
create index if not exists by_file on cases (file);
"""


class Stamp(NamedTuple):
    """By which a file is known to be the one that was read."""

    size: int
    changed: int  # [ns]


class Row(NamedTuple):
    """A case as the index holds it."""

    key: str
    failure: str | None
    settings: str
    summary: str


def stamp(path: Path) -> Stamp:
    """The stamp of a file as it is now."""
    found = path.stat()
    return Stamp(found.st_size, found.st_mtime_ns)


def is_own_index(path: Path) -> bool:
    """Whether a file is a database that vvdp made as an index, or an empty one; no link is followed."""
    try:
        if not stat.S_ISREG(path.lstat().st_mode):
            return False
        with path.open("rb") as file:
            begin = file.read(ID_AT.stop)
    except OSError:
        return False
    return not begin or (begin.startswith(HEADER) and int.from_bytes(begin[ID_AT], "big") == APPLICATION)


def companions(path: Path) -> list[Path]:
    """Files beside a database that SQLite would take for a part of it."""
    return [each for part in COMPANIONS if os.path.lexists(each := path.with_name(f"{path.name}-{part}"))]


def _put_aside(path: Path) -> None:
    """Renames what is instead of an index and cannot be used as one.

    A journal names files that SQLite deletes when it rolls a database back, so none is opened with its database: it is
    left by a process that died, or by the author of the directory. Raises ConfigError for a link.
    """
    found = [each for each in (path, *companions(path)) if os.path.lexists(each)]
    for each in found:
        if each.is_symlink():
            raise unusable(each, "is a link, which is not followed; remove it")
    if found == [path] and is_own_index(path):
        return
    for each in found:
        names = (each.with_name(f"aside{number or ''}-{each.name}") for number in itertools.count())
        each.rename(next(name for name in names if not os.path.lexists(name)))


def _is_at_work(path: Path) -> bool:
    """Whether another process may be in the middle of a transaction."""
    with suppress(OSError):
        return any(time.time() - each.lstat().st_mtime < WAITING for each in companions(path))
    return True


def read_index(directory: Path) -> dict[str, tuple[Stamp, list[Row]]]:
    """Content of the index of `directory`: stamp and cases by the name of the file; nothing where it is of no use."""
    path = directory / NAME
    if not is_own_index(path) or companions(path):
        return {}
    try:
        with closing(sqlite3.connect(f"file:{quote(str(path))}?mode=ro", uri=True, timeout=WAITING)) as base:
            if base.execute("pragma user_version").fetchone() != (VERSION,):
                return {}
            found: dict[str, tuple[Stamp, list[Row]]] = {
                name: (Stamp(size, changed), [])
                for name, size, changed in base.execute("select name, size, changed from files")
            }
            for file, *row in base.execute("select file, key, failure, settings, summary from cases"):
                found[file][1].append(Row(*row))
            return found
    except (sqlite3.Error, KeyError):
        return {}


def write_index(directory: Path, files: Mapping[str, tuple[Stamp, Iterable[Row]]], gone: Iterable[str] = ()) -> None:
    """Enters files and their cases, and drops those that are gone: all of it or nothing.

    Where another process holds the index, or the place does not bear one, it stays behind. Raises ConfigError where the
    index is a link.
    """
    path = directory / NAME
    try:
        if _is_at_work(path):
            return
        _put_aside(path)
        try:
            _write(path, files, gone)
        except sqlite3.OperationalError:
            raise
        except sqlite3.DatabaseError:  # ours, and damaged
            path.unlink(missing_ok=True)
            _write(path, files, gone)
    except (sqlite3.OperationalError, OSError):
        return


def _write(path: Path, files: Mapping[str, tuple[Stamp, Iterable[Row]]], gone: Iterable[str]) -> None:
    with _open_index(path) as base:
        base.executemany("delete from files where name = ?", [(name,) for name in (*gone, *files)])
        base.executemany("delete from cases where file = ?", [(name,) for name in (*gone, *files)])
        base.executemany("insert into files values (?, ?, ?)", [(name, *mark) for name, (mark, _) in files.items()])
        base.executemany(
            "insert into cases values (?, ?, ?, ?, ?)",
            [
                (row.key, name, row.failure, row.settings, row.summary)
                for name, (_, rows) in files.items()
                for row in rows
            ],
        )


@contextmanager
def _open_index(path: Path) -> Iterator[sqlite3.Connection]:
    """The index within a transaction, without a journal beside it, which a process that is killed would leave.

    Until the transaction has ended its version is 0, so that what is left of a broken one is made again.
    """
    with closing(sqlite3.connect(path, timeout=WAITING)) as base:
        base.execute("pragma journal_mode = memory")
        if base.execute("pragma user_version").fetchone() != (VERSION,):
            if base.execute("pragma quick_check").fetchone() != ("ok",):
                raise sqlite3.DatabaseError("torn")
            base.executescript(f"begin; drop table if exists files; drop table if exists cases; {TABLES} commit;")
        base.execute("pragma user_version = 0")
        with base:
            yield base
        base.execute(f"pragma user_version = {VERSION}")
