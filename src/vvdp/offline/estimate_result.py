"""The long series of an estimation, on disk while it runs and after it.

`result.h5` has `time` and what belongs to it, and `edges/...`, one row for each edge; every dataset with `units` and
`long_name`.
"""

import io
from collections.abc import Iterator, Mapping
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.files import write_error

ROWS_IN_CHUNK = 65536
AT_ONCE = 1_000_000
"""Rows that are read at once."""

ROWS: Mapping[str, tuple[str, str]] = {
    "time": ("s", "time, uniform within a piece of the record"),
    "piece": ("1", "piece of the record; the filter starts again with each"),
    "angle": ("rad", "shaft angle, unwrapped; it falls while the shaft turns backwards"),
    "angle_in_turn": ("rad", "shaft angle within the revolution"),
    "speed": ("rad/s", "shaft speed, negative backwards; without its ripple unless the filter has one"),
    "angle_deviation": ("rad", "standard deviation of the shaft angle"),
    "speed_deviation": ("rad/s", "standard deviation of that speed"),
    "pwm_frequency": ("Hz", "PWM frequency"),
    "standstill": ("1", "probability that the shaft stands still"),
    "settled": ("1", "1 where the row counts in means: after the first two revolutions of a piece"),
}
PRESSURE_ROW = {"inlet_pressure": ("Pa", "inlet pressure (absolute)")}
FUSED_ROWS = {
    "pressure_phase": ("rad", "angle of the pressure's wave on the spool, mounting and unknown lag together"),
    "pressure_duty_ratio": ("1", "duty ratio by the pressure's wave"),
    "pressure_duty_deviation": ("1", "standard deviation of that duty ratio"),
    "pressure_lag": ("s", "lag of the pressure's wave, estimated where `lag_deviation` is above 0"),
}
SMOOTHED: Mapping[str, tuple[str, str]] = {
    "smoothed_angle": ("rad", "shaft angle given the whole record, unwrapped"),
    "smoothed_speed": ("rad/s", "shaft speed given the whole record"),
    "smoothed_angle_deviation": ("rad", "standard deviation of the smoothed angle"),
    "smoothed_speed_deviation": ("rad/s", "standard deviation of the smoothed speed"),
}
EDGES: Mapping[str, tuple[str, str]] = {
    "time": ("s", "time of the edge"),
    "interval": ("s", "interval within which it lies"),
    "piece": ("1", "piece of the record"),
    "number": ("1", "number of the edge, counted along the unwrapped angle"),
    "sector": ("1", "number of the edge on the wheel"),
    "polarity": ("1", "+1 where the edge rises forward, -1 where it falls, 0 unknown"),
    "angle": ("rad", "angle at which the edge lies"),
    "variance": ("rad^2", "variance of that angle as measured"),
    "innovation": ("rad", "by how much the edge differs from what was expected; NaN where it was not used"),
    "innovation_deviation": ("rad", "by how much it was expected to differ"),
    "normalised_innovation": ("1", "innovation over its deviation"),
    "settled": ("1", "1 after the first two revolutions of a piece"),
}


class _Disk(io.FileIO):
    """A file for HDF5 in which writing never fails: HDF5 cannot be closed after a failure, and crashes the process.

    The first `problem` is kept for the writer, and nothing is written after it.
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

    def columns(self, group: str, named: Mapping[str, tuple[str, str]], rows: int = 0) -> None:
        """Datasets of so many `rows` of NaN, to be filled, and continued by `append`."""
        for name, (unit, words) in named.items():
            dataset = self.file.create_dataset(
                _path(group, name), (rows,), float, maxshape=(None,), chunks=(ROWS_IN_CHUNK,), compression="gzip",
                compression_opts=1, shuffle=True, fillvalue=np.nan,
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


def _path(group: str, name: str) -> str:
    return f"{group}/{name}" if group else name


def portions(file: Any, group: str, *names: str) -> Iterator[tuple[Array, ...]]:
    """Columns of a group of result.h5, `AT_ONCE` rows at once."""
    columns = [file[f"{group}{name}"] for name in names if f"{group}{name}" in file]
    for begin in range(0, columns[0].shape[0] if columns else 0, AT_ONCE):
        yield tuple(column[begin : begin + AT_ONCE] for column in columns)


def piece_rows(file: Any, group: str) -> dict[float, tuple[int, int]]:
    """The first row of each piece in a group of result.h5, and the one after its last."""
    found: dict[float, tuple[int, int]] = {}
    before = 0
    for (pieces,) in portions(file, group, "piece"):
        begins = np.flatnonzero(np.diff(pieces, prepend=np.nan) != 0.0)
        for begin, end in zip(begins.tolist(), [*begins[1:].tolist(), pieces.size], strict=True):
            piece = float(pieces[begin])
            found[piece] = found.get(piece, (before + begin, 0))[0], before + end
        before += pieces.size
    return found
