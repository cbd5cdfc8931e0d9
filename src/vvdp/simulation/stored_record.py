"""The record of a run read back from its HDF5 file, which may come from anyone.

It is read with the checks of the log readers: nothing outside of the file, nothing larger than it can hold, no circles.
"""

from pathlib import Path
from typing import Any

import h5py
import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.errors import unusable
from vvdp.base.kinds import Kind, kind_named
from vvdp.logs.budget import Budget
from vvdp.logs.hdf5 import Parts, own_item, storage_fault
from vvdp.simulation.record import GROUPS, TIME_VALUE, Record, Series


def read_record(path: Path) -> Record:
    """The record in an HDF5 file. Raises OSError, KeyError or ValueError where it holds none, ConfigError where it
    refers to what lies outside of it, or claims more than it can hold.
    """
    with h5py.File(path, "r") as file:
        budget = Budget(path)
        times = _values(file, "time", budget)
        marks = _group(file, "marks")
        mark_times = _values(marks, "time", budget)
        found = Record(
            times=times,
            **{name: _read_series(_group(file, name), budget) if name in file else {} for name in GROUPS},
            mark_times=mark_times,
            mark_states=_read_series(_group(marks, "states"), budget),
        )
    _check_lengths(found)
    return found


def _check_lengths(record: Record) -> None:
    """Raises ValueError where a series has not as many values as there are times."""
    if record.times.ndim != 1 or not record.times.size or record.mark_times.ndim != 1:
        raise ValueError(f"time has the shape {record.times.shape}, marks/time {record.mark_times.shape}")
    parts = {**record.groups, "marks/states": record.mark_states}
    for group, members in parts.items():
        rows = record.mark_times.size if group == "marks/states" else record.times.size
        for path, series in members.items():
            if series.values.shape[:1] != (rows,):
                raise ValueError(f"{group}/{path} has the shape {series.values.shape}; expected {rows} rows")


def _group(parent: Any, name: str) -> Any:
    """A group of the file itself. Raises KeyError where there is none."""
    found = own_item(parent, name)
    if not isinstance(found, h5py.Group):
        raise KeyError(f"{name} {found if isinstance(found, str) else 'is no group'}")
    return found


def _values(group: Any, name: str, budget: Budget) -> Array:
    """All numbers of a dataset of the file itself. Raises ConfigError or ValueError where they are not read."""
    item = own_item(group, name)
    place = f"{group.name.rstrip('/')}/{name}"
    fault = item if isinstance(item, str) else storage_fault(item, budget) if hasattr(item, "dtype") else "is a group"
    if not fault and item.dtype.kind not in "fiub":
        fault = "holds no numbers"
    if fault:
        raise unusable(budget.path, f"{place} {fault}")
    found: Array = Parts(item)[tuple(slice(0, length) for length in item.shape)]
    return found


def _read_series(group: Any, budget: Budget, path: str = "") -> dict[str, Series]:
    found: dict[str, Series] = {}
    with budget.inside(group.id) as fault:
        if fault:
            raise unusable(budget.path, f"{group.name} {fault}")
        budget.count(len(group))
        for name in group:
            shown = "time" if name == TIME_VALUE else name
            full = f"{path}.{shown}" if path else shown
            item = own_item(group, name)
            if hasattr(item, "keys"):
                found |= _read_series(item, budget, full)
            else:
                values = _values(group, name, budget)
                found[full] = Series(values, _read_kind(item.attrs), str(item.attrs["long_name"]))
    return found


def _read_kind(attributes: Any) -> Kind | None:
    """The kind of a dataset; one that vvdp does not know is made from its name and unit."""
    name, unit = str(attributes.get("kind", "")), str(attributes["units"])
    return kind_named(name) or (Kind(name or "quantity", unit, -np.inf, np.inf, f"1 {unit}") if unit != "1" else None)
