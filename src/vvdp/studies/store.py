"""What a study keeps on disk: `study.json`, which says what it is, and a file of finished cases for every batch.

    study.json          format, version, resolved base system, number of cases
    cases-<hash>.json   finished cases by key: what was set, results, or why it failed

A file is written under another name, synced and renamed: whatever happens, it is whole or absent. Nothing else is
kept; which cases are finished is read from the files.
"""

import hashlib
import json
import math
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from vvdp.base.errors import unusable

FORMAT = 1
DESCRIPTION = "study.json"


@dataclass(frozen=True)
class Finished:
    """A case that has been run: the results of the simulation, or why it failed."""

    key: str
    settings: Mapping[str, Any]
    failure: str | None
    summary: Mapping[str, float | bool]


def opened_store(directory: Path, description: Mapping[str, Any]) -> dict[str, Finished]:
    """Makes `directory` the place of a study and returns its finished cases by key.

    Raises ConfigError where it holds something else, cannot be written, or has a damaged file.
    """
    if directory.exists() and not directory.is_dir():
        raise unusable(directory, "is not a directory")
    if directory.exists() and any(directory.iterdir()) and not (directory / DESCRIPTION).exists():
        raise unusable(directory, "holds something else than a study; choose another directory")
    try:
        directory.mkdir(parents=True, exist_ok=True)
        _write(directory / DESCRIPTION, {"format": FORMAT, **description})
    except OSError as problem:
        raise unusable(directory, f"cannot be written ({problem.strerror})") from None
    return finished_cases(directory)


def finished_cases(directory: Path) -> dict[str, Finished]:
    """All finished cases in `directory` by key. Raises ConfigError where a file is damaged."""
    found: dict[str, Finished] = {}
    for path in sorted(directory.glob("cases-*.json")):
        try:
            content = json.loads(path.read_text("utf-8"))
            if content["format"] != FORMAT:
                raise unusable(path, f"was written in format {content['format']}; this version reads format {FORMAT}")
            for case in content["cases"]:
                summary = {key: math.nan if value is None else value for key, value in case["summary"].items()}
                found[case["key"]] = Finished(case["key"], case["settings"], case["failure"], summary)
        except (OSError, ValueError, KeyError, TypeError, AttributeError) as problem:
            if isinstance(problem, unusable(path, "").__class__):
                raise
            raise unusable(path, f"is damaged ({problem}); remove it to have its cases run again") from None
    return found


def write_finished(directory: Path, cases: list[Finished]) -> None:
    """Adds finished cases to `directory`, all or none."""
    name = hashlib.sha256("".join(case.key for case in cases).encode()).hexdigest()[:16]
    rows = [
        {
            "key": case.key,
            "settings": dict(case.settings),
            "failure": case.failure,
            "summary": {key: value if math.isfinite(value) else None for key, value in case.summary.items()},
        }
        for case in cases
    ]
    _write(directory / f"cases-{name}.json", {"format": FORMAT, "cases": rows})


def _write(path: Path, content: Mapping[str, Any]) -> None:
    write_whole(path, json.dumps(content, indent=1, allow_nan=False) + "\n")


def write_whole(path: Path, text: str) -> None:
    """Writes a file that is never seen in part, and is on the disk when this returns."""
    temporary = path.with_name(f".{path.name}.{os.getpid()}.tmp")
    with temporary.open("w", encoding="utf-8", newline="") as file:
        file.write(text)
        file.flush()
        os.fsync(file.fileno())
    temporary.replace(path)
    folder = os.open(path.parent, os.O_RDONLY)
    try:
        os.fsync(folder)
    finally:
        os.close(folder)
