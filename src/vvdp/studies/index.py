"""The index of a study's files: an SQLite database beside them.

    files(name, size, changed)                       each file of cases as it was when it was read
    cases(key, file, failure, settings, summary)     its cases; settings and summary are JSON

It may be missing, damaged, locked or behind at any time: it then knows less, and its files are read instead.
"""

import sqlite3
from collections.abc import Iterable, Iterator, Mapping
from contextlib import closing, contextmanager
from pathlib import Path
from typing import NamedTuple
from urllib.parse import quote

NAME = "index.sqlite"
VERSION = 1
WAITING = 5.0
"""Time [s] for which another process may hold the index."""

TABLES = f"""
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


def read_index(directory: Path) -> dict[str, tuple[Stamp, list[Row]]]:
    """What the index of `directory` knows: stamp and cases by the name of the file; nothing where it is of no use."""
    path = directory / NAME
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

    Where another process holds the index, or the place does not bear one, it stays behind.
    """
    path = directory / NAME
    try:
        try:
            _write(path, files, gone)
        except sqlite3.OperationalError:
            raise
        except sqlite3.DatabaseError:  # damaged
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
    """The index within a transaction."""
    with closing(sqlite3.connect(path, timeout=WAITING)) as base:
        if base.execute("pragma user_version").fetchone() != (VERSION,):
            base.executescript("drop table if exists files; drop table if exists cases;" + TABLES)
        with base:
            yield base
