"""A study on disk: `study.json`, which says what it is, and a file of finished cases for every batch.

    study.json          format, version, resolved base system, number of cases
    cases-<hash>.json   finished cases by key: what was set, results, or why it failed; and the SHA-256 of that
    index.sqlite        the same cases in one table

Whatever happens, a file is complete or not there (`base.files`). The files count; the index only saves opening them
all, answers questions, and is made again from them where it is missing, damaged or old. Many processes write files,
one the index.
"""

import hashlib
import json
import math
import os
import re
import shutil
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from vvdp.base.errors import ConfigError, unusable
from vvdp.base.files import UNFINISHED, clear_below, clear_unfinished, write_whole
from vvdp.base.manifest import has_list, kind_fault, open_directory, parsed_json, refuse_foreign
from vvdp.studies.index import NAME as INDEX
from vvdp.studies.index import Row, Stamp, companions, is_own_index, read_index, stamp, write_index

FORMAT = 2
MARK = "vvdp"
"""By which study.json is known as ours."""
DESCRIPTION = "study.json"
CASES = re.compile(r"cases-[0-9a-f]{16}\.json")


@dataclass(frozen=True)
class Finished:
    """A case that has been run: the results of the simulation, or why it failed."""

    key: str
    settings: Mapping[str, object]
    failure: str | None
    summary: Mapping[str, float | bool]


def opened_store(directory: Path, description: Mapping[str, object]) -> dict[str, Finished]:
    """Makes `directory` the place of a study and returns its finished cases by key.

    Raises ConfigError where it holds something else, cannot be written, or has a damaged file.
    """
    require_store(directory)
    try:
        clear_unfinished(directory)
        directory.mkdir(parents=True, exist_ok=True)
        _write(directory / DESCRIPTION, {"store": MARK, "format": FORMAT, **description})
    except OSError as problem:
        raise unusable(directory, f"cannot be written ({problem.strerror})") from None
    known = read_index(directory)
    found = _files(directory, known)
    unknown = {name: entry for name, entry in found.items() if known.get(name, (None,))[0] != entry[0]}
    gone = known.keys() - found.keys()
    if unknown or gone:
        rows = {name: (mark, [_row(case) for case in cases]) for name, (mark, cases) in unknown.items()}
        write_index(directory, rows, gone)
    return _by_key(found)


@contextmanager
def set_aside(directory: Path, *, force: bool) -> Iterator[None]:
    """With `force`, puts an earlier study away while another begins; it comes back if that does not begin.

    Raises ConfigError where `directory` holds anything that no study of vvdp wrote, or that was changed since.
    """
    if not (force and directory.exists()):
        require_store(directory)
        if has_list(directory):
            open_directory(directory, resuming=True)
        yield
        return
    clear_below(directory)
    refuse_foreign(directory, directory, is_own)
    aside = Path(tempfile.mkdtemp(prefix=f".{directory.name}-", dir=directory.parent))
    earlier = directory.rename(aside / directory.name)
    try:
        yield
    finally:
        if not directory.exists():
            earlier.rename(directory)
        shutil.rmtree(aside)


def require_store(directory: Path) -> None:
    """Raises ConfigError where `directory` is there and holds something else than a study of this version."""
    if not os.path.lexists(directory) or (directory.is_dir() and not any(directory.iterdir())):
        return
    if not directory.is_dir():
        raise unusable(directory, "is not a directory")
    if not is_store(directory):
        raise unusable(directory, "holds something else than a study; choose another directory")
    path = directory / DESCRIPTION
    described = parsed_json(path.read_text("utf-8", "replace"), path)
    if described.get("store") != MARK or described.get("format") != FORMAT:
        raise unusable(
            directory, f"holds something else than a study, or one of another version of vvdp: see {DESCRIPTION}"
        )


def is_own(path: Path) -> bool:
    """Whether a file in a store was written as a part of it, and is as it was written."""
    if path.name == INDEX:
        return is_own_index(path)
    if path in companions(path.with_name(INDEX)):
        return is_own_index(path.with_name(INDEX))
    try:
        if path.name == DESCRIPTION:
            return parsed_json(path.read_text("utf-8"), path).get("store") == MARK
        return bool(UNFINISHED.fullmatch(path.name)) or (bool(CASES.fullmatch(path.name)) and bool(_read(path)))
    except (ConfigError, UnicodeDecodeError):
        return False


def finished_cases(directory: Path) -> dict[str, Finished]:
    """All finished cases in `directory` by key; nothing is written. Raises ConfigError where a file is damaged."""
    return _by_key(_files(directory, read_index(directory)))


def _by_key(files: Mapping[str, tuple[Stamp, list[Finished]]]) -> dict[str, Finished]:
    return {case.key: case for _, cases in files.values() for case in cases}


def _files(
    directory: Path, known: Mapping[str, tuple[Stamp, Sequence[Row]]]
) -> dict[str, tuple[Stamp, list[Finished]]]:
    """Stamp and cases of every file; one that the index has as it is now is not read."""
    found: dict[str, tuple[Stamp, list[Finished]]] = {}
    for path in sorted(each for each in directory.iterdir() if CASES.fullmatch(each.name)):
        if fault := kind_fault(directory, path.name):
            raise unusable(path, fault)
        mark, rows = known.get(path.name, (None, ()))
        now = stamp(path)
        try:
            cases = [_row_case(row) for row in rows] if mark == now else _read(path)
        except ValueError:  # in the index
            cases = _read(path)
        found[path.name] = now, cases
    return found


def _read(path: Path) -> list[Finished]:
    try:
        content = json.loads(path.read_text("utf-8"))
        if content["format"] != FORMAT:
            raise unusable(path, f"was written in format {content['format']}; this version reads format {FORMAT}")
        if content["sha256"] != _sum(content["cases"]):
            raise unusable(path, "has changed since it was written; remove it to have its cases run again")
        return [
            Finished(case["key"], case["settings"], case["failure"], _numbers(case["summary"]))
            for case in content["cases"]
        ]
    except ConfigError:
        raise
    except (OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError) as problem:
        raise unusable(path, f"is damaged ({problem}); remove it to have its cases run again") from None


def _sum(cases: Any) -> str:
    """Digest that identifies the cases of a file."""
    return hashlib.sha256(json.dumps(cases, sort_keys=True).encode()).hexdigest()


def _numbers(summary: Mapping[str, float | bool]) -> dict[str, float | bool]:
    if wrong := [key for key, value in summary.items() if not isinstance(value, int | float | None)]:
        raise ValueError(f"{wrong[0]} is no number")
    return {key: math.nan if value is None else value for key, value in summary.items()}


def _content(case: Finished) -> dict[str, Any]:
    return {
        "key": case.key,
        "settings": dict(case.settings),
        "failure": case.failure,
        "summary": {key: value if math.isfinite(value) else None for key, value in case.summary.items()},
    }


def _row(case: Finished) -> Row:
    content = _content(case)
    return Row(
        case.key, case.failure, *(json.dumps(content[name], allow_nan=False) for name in ("settings", "summary"))
    )


def _row_case(row: Row) -> Finished:
    return Finished(row.key, json.loads(row.settings), row.failure, _numbers(json.loads(row.summary)))


def _place(directory: Path, cases: Sequence[Finished]) -> Path:
    """The file of a batch: the same batch, finished twice, has the same name."""
    name = hashlib.sha256("".join(case.key for case in cases).encode()).hexdigest()[:16]
    return directory / f"cases-{name}.json"


def write_finished(directory: Path, cases: Sequence[Finished]) -> None:
    """Adds the file of a batch to `directory`, all of it or nothing."""
    content = [_content(case) for case in cases]
    _write(_place(directory, cases), {"format": FORMAT, "sha256": _sum(content), "cases": content})


def keep_finished(directory: Path, cases: Sequence[Finished]) -> None:
    """Enters a batch into the index; adds its file where the worker could not, and so it is not there."""
    path = _place(directory, cases)
    if not path.exists():
        write_finished(directory, cases)
    write_index(directory, {path.name: (stamp(path), [_row(case) for case in cases])})


def is_store(directory: Path) -> bool:
    """Whether `directory` can be seen from here and is the place of a study."""
    return (directory / DESCRIPTION).is_file() and not kind_fault(directory, DESCRIPTION)


def _write(path: Path, content: Mapping[str, object]) -> None:
    write_whole(path, json.dumps(content, indent=1, allow_nan=False) + "\n")
