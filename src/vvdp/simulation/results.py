"""The result directory: what a run leaves on disk, and reading it back.

system.toml     the system as it was resolved
result.h5       times, states, outputs, marks; commands, memory and readings of each program; every dataset with
                `units` and `long_name`, time first, as its dimension (`simulation.record`)
summary.json    the numbers that the run comes to
meta.json       versions, hash of the linked equations, tolerances, residuals, seconds
vvdp.json       the list of these files, with their sums (`base.manifest`)
"""

import math
import platform
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from vvdp.base.errors import unusable
from vvdp.base.files import write_listed, write_whole
from vvdp.base.manifest import Directory, open_directory
from vvdp.base.version import VERSION
from vvdp.results.store import META, read_meta, write_json
from vvdp.simulation.record import Record, record_bytes
from vvdp.simulation.run import Run

FORMAT = 2
SYSTEM, SUMMARY, RECORD = "system.toml", "summary.json", "result.h5"
MEASURED = ("relative_tolerance", "sample_period_s", "until_s", "seconds")
"""Numbers that meta.json has of every run."""


@dataclass(frozen=True)
class Results:
    """Content of a result directory: the text of the system, the numbers of the run, its origin and its record."""

    directory: Path
    system: str
    summary: Mapping[str, float | bool]
    meta: Mapping[str, object]
    record: Record


def origin(run: Run) -> dict[str, Any]:
    """Entries of meta.json on how a run was computed."""
    from vvdp.generator import binding

    found = {
        "format": FORMAT,
        "vvdp": VERSION,
        "python": platform.python_version(),
        "numpy": np.__version__,
        "llvm": binding.version(),
        "equations": run.digest,
        "relative_tolerance": run.stepping.relative_tolerance,
        "sample_period_s": run.stepping.sample_period,
        "until_s": run.stepping.until,
        "finished": run.finished,
        "seconds": run.seconds,
    }
    further = {"remarks": list(run.remarks), "failed": run.failed}
    return found | {word: value for word, value in further.items() if value}


def write_results(folder: Path, results: Results) -> None:
    """Writes a run into `folder`; each file is complete or not there. `results.directory` is not looked at."""
    with write_listed(folder, [SYSTEM, SUMMARY, META, RECORD]):
        write_whole(folder / SYSTEM, results.system)
        write_json(folder / SUMMARY, results.summary)
        write_json(folder / META, results.meta)
        attributes: dict[str, str | int] = {
            name: str(results.meta.get(name, "")) for name in ("title", "system", "vvdp")
        }
        write_whole(folder / RECORD, record_bytes(results.record, attributes | {"format": FORMAT}))


def read_results(place: Path | Directory) -> Results:
    """The content of a run's directory. Raises ConfigError where it is none, changed, damaged, or of another format."""
    from vvdp.simulation.stored_record import read_record

    directory = open_directory(place)
    for name in (SYSTEM, RECORD, SUMMARY):
        directory.file(name)
    meta = read_meta(directory)
    if meta.get("format") != FORMAT:
        raise unusable(
            directory.path,
            f"was written in format {meta.get('format')}; this version reads format {FORMAT}: run its {SYSTEM} again",
        )
    _check_meta(directory.path / META, meta)
    try:
        record = read_record(directory.file(RECORD))
    except (OSError, KeyError, ValueError, RuntimeError) as problem:
        raise unusable(directory.path / RECORD, f"is damaged: {problem}") from None
    return Results(
        directory=directory.path,
        system=directory.text(SYSTEM),
        summary=_read_summary(directory),
        meta=meta,
        record=record,
    )


def _check_meta(path: Path, meta: Mapping[str, object]) -> None:
    """Raises ConfigError where what every run says of itself has another type than it was written with."""
    for name in MEASURED:
        if not isinstance(meta.get(name), int | float) or isinstance(meta[name], bool):
            raise unusable(path, f"is damaged: {name} = {meta.get(name)!r}; expected a number")
    if not isinstance(meta.get("finished"), bool):
        raise unusable(path, f"is damaged: finished = {meta.get('finished')!r}; expected true or false")
    remarks = meta.get("remarks", [])
    if not isinstance(remarks, list) or not all(isinstance(text, str) for text in remarks):
        raise unusable(path, "is damaged: notes is not a list of texts")


def _read_summary(directory: Directory) -> dict[str, Any]:
    found = directory.json(SUMMARY)
    for key, value in found.items():
        if not isinstance(value, int | float | None):
            raise unusable(directory.path / SUMMARY, f"is damaged: {key} = {value!r}; expected a number or a flag")
    return {key: math.nan if value is None else value for key, value in found.items()}
