"""The record of a run as the bytes of an HDF5 file that follows netCDF: dimensions by scales, a unit on every dataset.

The file is made in memory, so nothing half-written is ever on a disk, and a full disk is an ordinary error: HDF5 itself
fails again while it closes a file that it could not write.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.kinds import Kind
from vvdp.simulation.run import Run
from vvdp.simulation.values import leaves

CONVENTIONS = "CF-1.11"
COMPRESSED_FROM = 10_000
"""Datasets of so many numbers and more are compressed."""
TIME_VALUE = "time_value"
"""Name of a recorded quantity `time`, such as the one a program is shown: as `time` it would pass for the dimension."""
NO_VARIABLE = "This is a netCDF dimension but not a netCDF variable."


def record_bytes(run: Run, attributes: Mapping[str, str | int]) -> bytes:
    """The HDF5 file of everything that `run` has recorded; the same run gives the same bytes.

    Dataset `time` is the scale of the first axis of all but the marks, whose dimension is `mark`: as `time` it would
    contradict that of the file, and readers of all groups at once would refuse it. An axis of a value that is itself an
    array has a scale that only says its length. `attributes` are those of the file as a whole.
    """
    import h5py

    with h5py.File("record", "w", driver="core", backing_store=False) as file:
        file.attrs.update({"Conventions": CONVENTIONS, **attributes})
        time = _create(file, "time", run.times, ("s", "time"))
        time.make_scale("time")
        for group, value in _recorded(run).items():
            for path, leaf, kind in leaves(value):
                if path.rpartition(".")[2] != "unused":
                    name = _dataset_name(f"{group}.{path}")
                    _add_dataset(file, name, np.moveaxis(leaf, -1, 0), _description(path, kind), time)
        marks = _length_scale(file, "marks/mark", run.mark_times.size)
        _add_dataset(file, "marks/time", run.mark_times, ("s", "time of each mark"), marks)
        for column, (path, _, kind) in enumerate(leaves(run.case.state)):
            values = run.mark_states[:, column]
            _add_dataset(file, _dataset_name(f"marks.states.{path}"), values, _description(path, kind), marks)
        file.flush()
        image: bytes = file.id.get_file_image()
    return image


def _recorded(run: Run) -> dict[str, Any]:
    """What is recorded over time, an array with time as its last axis at each leaf."""
    return {
        "states": run.state,
        "outputs": run.outputs,
        "commands": run.command,
        **{f"memory.{name}": value for name, value in run.memory.items()},
        **{f"readings.{name}": value for name, value in run.readings.items()},
    }


def _dataset_name(path: str) -> str:
    *groups, name = path.split(".")
    return "/".join([*groups, TIME_VALUE if name == "time" else name])


def _description(path: str, kind: Kind | None) -> tuple[str, str]:
    """Unit and name in words of a recorded quantity."""
    words = path.removeprefix("books.").replace(".", ", ").replace("_", " ")
    unit = kind.unit if kind else "1"
    if kind and kind.name == "pressure level":
        words += " (absolute)"
    return unit, words


def _add_dataset(file: Any, name: str, values: Array, description: tuple[str, str], first: Any) -> None:
    dataset = _create(file, name, values, description)
    dataset.dims[0].attach_scale(first)
    for axis in range(1, dataset.ndim):
        length = dataset.shape[axis]
        dataset.dims[axis].attach_scale(_length_scale(file, f"length_{length}", length))


def _create(file: Any, name: str, values: Array, description: tuple[str, str]) -> Any:
    options = {"compression": "gzip", "compression_opts": 1, "shuffle": True} if values.size >= COMPRESSED_FROM else {}
    dataset = file.create_dataset(name, data=values, **options)
    dataset.attrs["units"], dataset.attrs["long_name"] = description
    return dataset


def _length_scale(file: Any, name: str, length: int) -> Any:
    """The scale of a dimension that stands for no quantity: it only has a length."""
    if name not in file:
        file.create_dataset(name, shape=(length,), dtype="f4").make_scale(f"{NO_VARIABLE}{length:10d}")
    return file[name]
