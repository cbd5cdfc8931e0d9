"""The result directory: what a run leaves on disk, and reading it back.

system.toml     the system as it was resolved
result.h5       times, states, outputs, marks; commands, memory and readings of each program; every dataset with
                `units` and `long_name`, time first, as its dimension (`simulation.record`)
summary.json    the numbers that the run comes to
meta.json       versions, hash of the linked equations, tolerances, residuals, seconds
"""

import json
import math
import platform
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

import vvdp
from vvdp.base.errors import unusable
from vvdp.base.files import write_whole
from vvdp.results.store import write_json
from vvdp.simulation.record import Record, read_record, record_bytes
from vvdp.simulation.run import Run

FORMAT = 2


@dataclass(frozen=True)
class Results:
    """What a result directory holds: the text of the system, the numbers of the run, its origin and its record."""

    directory: Path
    system: str
    summary: Mapping[str, Any]
    meta: Mapping[str, Any]
    record: Record


def origin(run: Run) -> dict[str, Any]:
    """What meta.json says of how a run was computed."""
    import numba

    found = {
        "format": FORMAT,
        "vvdp": vvdp.__version__,
        "python": platform.python_version(),
        "numpy": np.__version__,
        "numba": numba.__version__,
        "equations": run.digest,
        "relative_tolerance": run.stepping.relative_tolerance,
        "sample_period_s": run.stepping.sample_period,
        "until_s": run.stepping.until,
        "finished": run.finished,
        "seconds": run.seconds,
    }
    return found | ({"remarks": list(run.remarks)} if run.remarks else {})


def write_results(folder: Path, results: Results) -> None:
    """Writes a run into `folder`; each file is whole or absent. `results.directory` is not looked at."""
    write_whole(folder / "system.toml", results.system)
    write_json(folder / "summary.json", results.summary)
    write_json(folder / "meta.json", results.meta)
    attributes: dict[str, str | int] = {name: str(results.meta.get(name, "")) for name in ("title", "system", "vvdp")}
    write_whole(folder / "result.h5", record_bytes(results.record, attributes | {"format": FORMAT}))


def read_results(directory: Path) -> Results:
    """The content of a result directory. Raises ConfigError where it is none, or from another format."""
    if not directory.is_dir():
        raise unusable(directory, "is not a directory" if directory.exists() else "no such directory")
    missing = [n for n in ("system.toml", "result.h5", "summary.json", "meta.json") if not (directory / n).is_file()]
    if missing:
        raise unusable(directory, f"is not a result directory: {', '.join(missing)} missing")
    try:
        meta = json.loads((directory / "meta.json").read_text("utf-8"))
        form = meta.get("format")
    except (OSError, ValueError, AttributeError) as problem:
        raise unusable(directory, f"is damaged: {problem}") from None
    if form != FORMAT:
        raise unusable(
            directory, f"was written in format {form}; this version reads format {FORMAT}: run its system.toml again"
        )
    try:
        return Results(
            directory=directory,
            system=(directory / "system.toml").read_text("utf-8"),
            summary={
                key: math.nan if value is None else value
                for key, value in json.loads((directory / "summary.json").read_text("utf-8")).items()
            },
            meta=meta,
            record=read_record(directory / "result.h5"),
        )
    except (OSError, KeyError, ValueError) as problem:
        raise unusable(directory, f"is damaged: {problem}") from None
