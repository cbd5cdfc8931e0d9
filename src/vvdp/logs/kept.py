"""The result directory of an estimation, and reading it back.

estimate.toml   every setting, also the defaults; a config for the next estimation
result.h5       `time` and what belongs to it; `edges/...`, one row for each edge; `excerpt/...` and `folded/...`,
                what the figures are drawn from; every dataset with `units` and `long_name`
summary.json    the numbers that the log comes to
findings.json   what is wrong or in doubt, in words
meta.json       versions, hash of the log, options, seconds
"""

import io
import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.errors import unusable
from vvdp.base.files import write_error

FORMAT = 1
KIND = "estimate"
FILES = ("estimate.toml", "result.h5", "summary.json", "findings.json", "meta.json")
ROWS_IN_CHUNK = 65536

ROWS: Mapping[str, tuple[str, str]] = {
    "time": ("s", "time, uniform within a piece of the record"),
    "piece": ("1", "piece of the record; the filter starts anew with each"),
    "angle": ("rad", "spool angle, unwrapped"),
    "angle_in_turn": ("rad", "spool angle within the turn"),
    "speed": ("rad/s", "spool speed"),
    "angle_deviation": ("rad", "standard deviation of the spool angle"),
    "speed_deviation": ("rad/s", "standard deviation of the spool speed"),
    "pwm_frequency": ("Hz", "PWM frequency"),
}
PRESSURE_ROW = {"inlet_pressure": ("Pa", "inlet pressure (absolute)")}
FUSED_ROWS = {
    "pressure_phase": ("rad", "angle of the pressure's wave on the spool, mounting and unknown lag together"),
    "pressure_duty_ratio": ("1", "duty ratio by the pressure's wave"),
    "pressure_duty_deviation": ("1", "standard deviation of that duty ratio"),
    "pressure_lag": ("s", "lag of the pressure's wave, estimated where `lag_deviation` is above 0"),
}
SMOOTHED: Mapping[str, tuple[str, str]] = {
    "smoothed_angle": ("rad", "spool angle given the whole record, unwrapped"),
    "smoothed_speed": ("rad/s", "spool speed given the whole record"),
    "smoothed_angle_deviation": ("rad", "standard deviation of the smoothed angle"),
    "smoothed_speed_deviation": ("rad/s", "standard deviation of the smoothed speed"),
}
EDGES: Mapping[str, tuple[str, str]] = {
    "time": ("s", "time of the edge"),
    "interval": ("s", "interval within which it lies"),
    "piece": ("1", "piece of the record"),
    "number": ("1", "number of the edge, counted along the unwrapped angle"),
    "sector": ("1", "number of the edge on the wheel"),
    "polarity": ("1", "+1 rising, -1 falling, 0 unknown"),
    "angle": ("rad", "angle at which the edge lies"),
    "variance": ("rad^2", "variance of that angle as measured"),
    "innovation": ("rad", "by how much the edge differs from what was expected; NaN where it was not used"),
    "innovation_deviation": ("rad", "by how much it was expected to differ"),
    "normalised_innovation": ("1", "innovation over its deviation"),
    "settled": ("1", "1 after the first two turns of a piece"),
}


class _Disk(io.FileIO):
    """A file for HDF5 in which writing never fails: HDF5 cannot be closed after a failure, and crashes the process.

    The first `problem` is kept for whoever writes, and nothing is written after it.
    """

    problem: OSError | None = None

    def write(self, content: Any) -> int:
        view = memoryview(content).cast("B")
        try:
            while view and self.problem is None:
                view = view[super().write(view) :]
        except OSError as problem:
            self.problem = problem
        return memoryview(content).nbytes

    def truncate(self, size: int | None = None) -> int:
        try:
            return super().truncate(size)
        except OSError as problem:
            self.problem = self.problem or problem
            return size or 0


class Store:
    """Datasets that grow, in an HDF5 file that is whole once the block ends. Raises WriteError where the disk fails."""

    def __init__(self, path: Path) -> None:
        import h5py

        self._path, self._disk = path, _Disk(path, "w+")
        self.file = h5py.File(self._disk, "w")
        self._waiting: dict[str, list[Array]] = {}

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, problem: BaseException | None, trace: TracebackType | None
    ) -> None:
        try:
            if kind is None:
                self.flush()
            self.file.close()
        except (OSError, RuntimeError):
            if self._disk.problem is None:
                raise
        finally:
            self._disk.close()
        self._check()

    def _check(self) -> None:
        if self._disk.problem is not None:
            raise write_error(self._path, self._disk.problem) from None

    def columns(self, group: str, named: Mapping[str, tuple[str, str]]) -> None:
        """Empty datasets to be filled by `append`."""
        for name, (unit, words) in named.items():
            dataset = self.file.create_dataset(
                _path(group, name), (0,), float, maxshape=(None,), chunks=(ROWS_IN_CHUNK,), compression="gzip",
                compression_opts=1, shuffle=True,
            )  # fmt: skip
            dataset.attrs["units"], dataset.attrs["long_name"] = unit, words

    def append(self, group: str, values: Mapping[str, Array]) -> None:
        """Adds rows to the datasets of a group; they are written by whole chunks, each compressed once."""
        for name, new in values.items():
            path = _path(group, name)
            waiting = self._waiting.setdefault(path, [])
            waiting.append(new)
            if sum(part.size for part in waiting) >= ROWS_IN_CHUNK:
                rows = np.concatenate(waiting)
                whole = rows.size - rows.size % ROWS_IN_CHUNK
                self._write(path, rows[:whole])
                self._waiting[path] = [rows[whole:]]

    def flush(self) -> None:
        """Writes what waits for a chunk to be full; nothing is appended to these datasets afterwards."""
        for path, waiting in self._waiting.items():
            self._write(path, np.concatenate(waiting))
        self._waiting = {}

    def _write(self, path: str, rows: Array) -> None:
        dataset = self.file[path]
        size = dataset.shape[0]
        dataset.resize((size + rows.size,))
        dataset[size:] = rows
        self._check()

    def put(self, name: str, values: Array, unit: str, words: str) -> None:
        """A dataset as a whole; replaces one of that name."""
        if name in self.file:
            del self.file[name]
        dataset = self.file.create_dataset(name, data=np.asarray(values, float))
        dataset.attrs["units"], dataset.attrs["long_name"] = unit, words


def _path(group: str, name: str) -> str:
    return f"{group}/{name}" if group else name


@dataclass(frozen=True)
class Finding:
    """Something about the record that a person should know: what was found, with numbers, and what to do."""

    title: str
    found: str
    remedy: str
    grave: bool = False


def write_texts(
    folder: Path, config: str, summary: Mapping[str, Any], findings: tuple[Finding, ...], meta: Mapping[str, Any]
) -> None:
    """Writes all but result.h5 into a result directory."""
    (folder / "estimate.toml").write_text(config, encoding="utf-8")
    _write_json(folder / "summary.json", dict(summary))
    _write_json(folder / "findings.json", [asdict(finding) for finding in findings])
    _write_json(folder / "meta.json", {"format": FORMAT, "kind": KIND, **meta})


def _write_json(path: Path, content: Any) -> None:
    path.write_text(json.dumps(content, indent=1, allow_nan=False) + "\n", encoding="utf-8")


@dataclass(frozen=True)
class Kept:
    """A result directory of an estimation; the datasets stay on disk until asked for."""

    directory: Path
    summary: Mapping[str, Any]
    meta: Mapping[str, Any]
    findings: tuple[Finding, ...]
    config: str

    def has(self, name: str) -> bool:
        """Whether result.h5 holds a dataset or a group of that name."""
        import h5py

        with h5py.File(self.directory / "result.h5", "r") as file:
            return name in file

    def column(self, name: str, rows: slice = slice(None)) -> Array:
        """A dataset of result.h5, or some rows of it."""
        import h5py

        with h5py.File(self.directory / "result.h5", "r") as file:
            found: Array = file[name][rows]
            return found

    def unit(self, name: str) -> str:
        """The unit of a dataset."""
        import h5py

        with h5py.File(self.directory / "result.h5", "r") as file:
            return str(file[name].attrs.get("units", ""))

    def size(self, name: str) -> int:
        """How many rows a dataset has."""
        import h5py

        with h5py.File(self.directory / "result.h5", "r") as file:
            return int(file[name].shape[0])


def is_estimate(directory: Path) -> bool:
    """Whether a directory is the result of an estimation."""
    return (directory / "estimate.toml").is_file()


def read_kept(directory: Path) -> Kept:
    """A result directory read back. Raises ConfigError where it is none, or from another format."""
    import h5py

    if not directory.is_dir():
        raise unusable(directory, "is not a directory" if directory.exists() else "no such directory")
    missing = [name for name in FILES if not (directory / name).is_file()]
    if missing:
        raise unusable(directory, f"is not the result of an estimation: {', '.join(missing)} missing")
    try:
        meta, summary, findings = (
            json.loads((directory / name).read_text("utf-8")) for name in ("meta.json", "summary.json", "findings.json")
        )
        told = tuple(Finding(**finding) for finding in findings)
        config = (directory / "estimate.toml").read_text("utf-8")
        with h5py.File(directory / "result.h5", "r") as file:
            absent = [name for name in (*ROWS, *(f"edges/{name}" for name in EDGES)) if name not in file]
        if absent:
            raise ValueError(f"result.h5 has no {', '.join(absent)}")
        if not isinstance(meta, dict) or not isinstance(summary, dict):
            raise ValueError("summary.json or meta.json is no object")
    except (OSError, KeyError, ValueError, TypeError) as problem:
        raise unusable(directory, f"is damaged: {problem}") from None
    if meta.get("format") != FORMAT:
        raise unusable(directory, f"was written in format {meta.get('format')}; this version reads format {FORMAT}")
    return Kept(directory, summary, meta, told, config)
