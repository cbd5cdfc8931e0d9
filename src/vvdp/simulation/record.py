"""The record of a run as the bytes of an HDF5 file that follows netCDF: dimensions by scales, a unit on every dataset.

The file is made in memory, so nothing half-written is ever on a disk, and a full disk is an ordinary error: HDF5 itself
fails again while it closes a file that it could not write.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.kinds import DURATION, PRESSURE_LEVEL, Kind
from vvdp.simulation.run import Run
from vvdp.simulation.values import leaves

GROUPS = ("states", "outputs", "commands", "memory", "readings")
CONVENTIONS = "CF-1.11"
COMPRESSED_FROM = 10_000
"""Datasets of so many numbers and more are compressed."""
TIME_VALUE = "time_value"
"""Name of a recorded quantity `time`, such as the one a program is shown: as `time` it would pass for the dimension."""
NO_VARIABLE = "This is a netCDF dimension but not a netCDF variable."


@dataclass(frozen=True)
class Series:
    """A recorded quantity: values over time [SI], time first, what it is, and in words; None where no kind is known."""

    values: Array
    kind: Kind | None
    long_name: str

    @property
    def unit(self) -> str:
        """The SI unit of the values."""
        return self.kind.unit if self.kind else "1"


@dataclass(frozen=True, kw_only=True)
class Record:
    """All that a run has recorded; the same in memory as read back from a file.

    Commands are by "program.field", and "held.field" for the conditions; memory and readings by "program.field".
    """

    times: Array  # (rows,)
    states: Mapping[str, Series]
    outputs: Mapping[str, Series]
    commands: Mapping[str, Series]
    memory: Mapping[str, Series]
    readings: Mapping[str, Series]
    mark_times: Array  # (marks,)
    mark_states: Mapping[str, Series]

    @property
    def groups(self) -> dict[str, Mapping[str, Series]]:
        """Recorded quantities over time, by group."""
        return {name: getattr(self, name) for name in GROUPS}

    def over_periods(self, means: Array) -> Array:
        """Values of each period between marks, held over the recorded rows in it; nan outside."""
        marks = self.mark_times
        place = np.searchsorted(marks, self.times, side="right") - 1
        inside = (place >= 0) & (place < marks.size - 1)
        found = np.full(self.times.size, np.nan)
        found[inside] = means[place[inside]]
        return found

    def period_means(self, path: str) -> Array:
        """Means over each period of what the integral `path` adds up [SI], shape (marks - 1,)."""
        means: Array = np.diff(self.mark_states[path].values) / np.diff(self.mark_times)
        return means


def record_of(run: Run) -> Record:
    """Record of a run in memory."""
    paths = [(path, kind) for path, _, kind in leaves(run.case.state)]
    marks = {path: _series(path, run.mark_states[:, place], kind) for place, (path, kind) in enumerate(paths)}
    return Record(
        times=run.times,
        states=_all_series(run.state),
        outputs=_all_series(run.outputs),
        commands=_all_series(run.command),
        memory={f"{name}.{path}": s for name, value in run.memory.items() for path, s in _all_series(value).items()},
        readings={f"{name}.{path}": s for name, v in run.readings.items() for path, s in _all_series(v).items()},
        mark_times=run.mark_times,
        mark_states=marks,
    )


def _all_series(value: Any) -> dict[str, Series]:
    named = ((path, leaf, kind) for path, leaf, kind in leaves(value) if path.rpartition(".")[2] != "unused")
    return {path: _series(path, np.moveaxis(leaf, -1, 0), kind) for path, leaf, kind in named}


def _series(path: str, values: Array, kind: Kind | None) -> Series:
    words = path.removeprefix("books.").replace(".", ", ").replace("_", " ")
    return Series(values, kind, words + (" (absolute)" if kind and kind.name == PRESSURE_LEVEL.name else ""))


def record_bytes(record: Record, attributes: Mapping[str, str | int]) -> bytes:
    """The HDF5 file of a record; the same record gives the same bytes.

    Dataset `time` is the scale of the first axis of all but the marks, whose dimension is `mark`: as `time` it would
    contradict that of the file, and readers of all groups at once would refuse it. An axis of a value that is itself an
    array has a scale that only says its length. `attributes` are those of the file as a whole.
    """
    import h5py

    with h5py.File("record", "w", driver="core", backing_store=False) as file:
        file.attrs.update({"Conventions": CONVENTIONS, **attributes})
        time = _create(file, "time", Series(record.times, DURATION, "time"))
        time.make_scale("time")
        for group, members in record.groups.items():
            for path, series in members.items():
                _add_dataset(file, _dataset_name(f"{group}.{path}"), series, time)
        marks = _length_scale(file, "marks/mark", record.mark_times.size)
        _add_dataset(file, "marks/time", Series(record.mark_times, DURATION, "time of each mark"), marks)
        for path, series in record.mark_states.items():
            _add_dataset(file, _dataset_name(f"marks.states.{path}"), series, marks)
        file.flush()
        image: bytes = file.id.get_file_image()
    return image


def _dataset_name(path: str) -> str:
    *groups, name = path.split(".")
    return "/".join([*groups, TIME_VALUE if name == "time" else name])


def _add_dataset(file: Any, name: str, series: Series, first: Any) -> None:
    dataset = _create(file, name, series)
    dataset.dims[0].attach_scale(first)
    for axis in range(1, dataset.ndim):
        length = dataset.shape[axis]
        dataset.dims[axis].attach_scale(_length_scale(file, f"length_{length}", length))


def _create(file: Any, name: str, series: Series) -> Any:
    values = series.values
    options = {"compression": "gzip", "compression_opts": 1, "shuffle": True} if values.size >= COMPRESSED_FROM else {}
    dataset = file.create_dataset(name, data=values, **options)
    dataset.attrs["units"], dataset.attrs["long_name"] = series.unit, series.long_name
    if series.kind:
        dataset.attrs["kind"] = series.kind.name
    return dataset


def _length_scale(file: Any, name: str, length: int) -> Any:
    """The scale of a dimension that stands for no quantity: it only has a length."""
    if name not in file:
        file.create_dataset(name, shape=(length,), dtype="f4").make_scale(f"{NO_VARIABLE}{length:10d}")
    return file[name]
