"""The result directory: what a run leaves on disk, and reading it back.

system.toml     the system as it was resolved
result.h5       times, states, outputs, marks; commands, memory and readings of each program; every dataset with
                `units` and `long_name`, time first, as its dimension (`simulation.record`)
summary.json    the numbers that the run comes to
meta.json       versions, hash of the linked equations, tolerances, residuals, seconds
"""

import json
import platform
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

import vvdp
from vvdp.base.errors import unusable
from vvdp.base.files import write_whole
from vvdp.numerics.tableaus import Array
from vvdp.simulation.record import TIME_VALUE, record_bytes
from vvdp.simulation.run import Run

FORMAT = 2
GROUPS = ("states", "outputs", "commands", "memory", "readings")


@dataclass(frozen=True)
class Series:
    """A recorded quantity: values over `Results.times`, SI unit, and what it is; time is the first axis."""

    values: Array
    unit: str
    long_name: str


@dataclass(frozen=True)
class Results:
    """A result directory read back."""

    directory: Path
    system: str
    summary: Mapping[str, Any]
    meta: Mapping[str, Any]
    times: Array  # (rows,)
    states: Mapping[str, Series]
    outputs: Mapping[str, Series]
    commands: Mapping[str, Series]  # by "<program>.<field>", and "held.<field>" for the conditions
    memory: Mapping[str, Series]  # by "<program>.<field>", as the readings are
    readings: Mapping[str, Series]
    mark_times: Array  # (marks,)
    mark_states: Mapping[str, Series]


def write_results(folder: Path, run: Run, *, system: str, summary: Mapping[str, Any], more: Mapping[str, Any]) -> None:
    """Writes a run into `folder`: the text of the resolved `system`, its `summary`, and `more` for meta.json."""
    import numba

    (folder / "system.toml").write_text(system, encoding="utf-8")
    _write_json(folder / "summary.json", summary)
    meta = {
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
        **more,
    }
    if run.remarks:
        meta["remarks"] = list(run.remarks)
    _write_json(folder / "meta.json", meta)
    attributes: dict[str, str | int] = {
        "title": str(more.get("title", "")),
        "system": str(more.get("system", "")),
        "vvdp": vvdp.__version__,
        "format": FORMAT,
    }
    write_whole(folder / "result.h5", record_bytes(run, attributes))


def _write_json(path: Path, content: Mapping[str, Any]) -> None:
    path.write_text(json.dumps(dict(content), indent=1) + "\n", encoding="utf-8")


def read_results(directory: Path) -> Results:
    """The content of a result directory. Raises ConfigError where it is none, or from another format."""
    import h5py

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
        text = (directory / "system.toml").read_text("utf-8")
        summary = json.loads((directory / "summary.json").read_text("utf-8"))
        with h5py.File(directory / "result.h5", "r") as file:
            groups = {name: _series(file.get(name, {})) for name in GROUPS}
            mark_states = _series(file["marks/states"])
            times, marks = file["time"][:], file["marks/time"][:]
    except (OSError, KeyError, ValueError) as problem:
        raise unusable(directory, f"is damaged: {problem}") from None
    return Results(
        directory=directory,
        system=text,
        summary=summary,
        meta=meta,
        times=times,
        mark_times=marks,
        mark_states=mark_states,
        **groups,
    )


def _series(group: Any, path: str = "") -> dict[str, Series]:
    found: dict[str, Series] = {}
    for name, item in group.items():
        name = "time" if name == TIME_VALUE else name
        full = f"{path}.{name}" if path else name
        if hasattr(item, "shape"):
            found[full] = Series(item[:], str(item.attrs["units"]), str(item.attrs["long_name"]))
        else:
            found |= _series(item, full)
    return found
