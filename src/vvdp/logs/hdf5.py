"""HDF5 files, vvdp's own results among them: every dataset of numbers is a channel.

A dataset may carry its unit (attribute `units` or `unit`) and its clock (`dt` or `sample_rate`, `t0`; or a dimension
scale, as netCDF writes it). Otherwise the dataset named as a time beside it or above it is the clock.
"""

import math
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.errors import ConfigError, unusable
from vvdp.logs.budget import Budget, damage
from vvdp.logs.channel import Log
from vvdp.logs.channel_readers import Leaf, Reader, Tree, evenly
from vvdp.logs.clock import ClockChoice

MOST_COLUMNS = 64
"""A matrix with more columns is not a set of channels."""


def hdf5_log(path: Path, choice: ClockChoice) -> Log:
    """The log in an HDF5 file."""
    file = open_hdf5(path)
    tree = Tree(path, choice, "/")
    try:
        _walk(tree, (), file)
    except ConfigError:
        file.close()
        raise
    except Exception as problem:  # h5py raises many unrelated types on damaged files
        file.close()
        raise damage(path, "the HDF5 file", problem) from None
    return tree.log(file)


def open_hdf5(path: Path) -> Any:
    """The HDF5 file `path`, open for reading. Raises ConfigError where it is damaged."""
    try:
        return h5py.File(path, "r")
    except OSError as problem:
        raise unusable(path, f"cannot be read as HDF5, the file is damaged or cut off ({problem})") from None


def _walk(tree: Tree, path: tuple[str, ...], group: Any) -> None:
    if fault := tree.budget.enter(group.id):
        tree.refuse(path, fault)
        return
    tree.budget.count(len(group))
    for name in group:
        own, item = (*path, name), own_item(group, name)
        if isinstance(item, h5py.Group):
            _walk(tree, own, item)
        elif isinstance(item, h5py.Dataset):
            _add(tree, own, item)
        else:
            tree.refuse(own, item if isinstance(item, str) else "is a named type")
    tree.budget.leave()


def own_item(group: Any, name: str) -> Any:
    """What stands in a group under `name`, or why that is not read: only what lies in this file is."""
    if isinstance(group.get(name, getlink=True), h5py.ExternalLink):
        return "lies in another file"
    item = group.get(name)
    if item is None:
        return "is a broken link"
    return item if item.file.filename == group.file.filename else "lies in another file"


def storage_fault(dataset: Any, budget: Budget) -> str:
    """Why a dataset is not read, as it is stored; empty where it is."""
    if dataset.external or (dataset.is_virtual and any(each.file_name != "." for each in dataset.virtual_sources())):
        return "lies in another file"
    size = dataset.dtype.itemsize
    return budget.chunk_fault(size * math.prod(dataset.chunks or ())) or budget.content_fault(
        size * (dataset.size or 0)
    )


def _add(tree: Tree, path: tuple[str, ...], dataset: Any) -> None:
    if fault := storage_fault(dataset, tree.budget):
        tree.refuse(path, fault)
        return
    if dataset.dtype.names:
        for name in dataset.dtype.names:
            if dataset.ndim == 1 and dataset.dtype[name].kind in "fiub" and not dataset.dtype[name].shape:
                tree.add(Leaf((*path, name), len(dataset), field_reader(dataset, name)))
            else:
                tree.refuse((*path, name), "is not a column of numbers")
        return
    if why := unfit(dataset):
        tree.refuse(path, why)
        return
    unit, clock = text(dataset.attrs.get("units", dataset.attrs.get("unit"))), _own_clock(dataset)
    link = _dimension_scale(dataset)
    if dataset.ndim == 1:
        tree.add(
            Leaf(
                path=path,
                samples=dataset.shape[0],
                values=_read_scaled(dataset, 0),
                unit=unit,
                clock=clock,
                clock_path=link,
            )
        )
    else:
        for k in range(dataset.shape[1]):
            column = (*path[:-1], f"{path[-1]}[{k}]")
            tree.add(
                Leaf(
                    path=column,
                    samples=dataset.shape[0],
                    values=_read_scaled(dataset, k),
                    unit=unit,
                    clock=clock,
                    clock_path=link,
                )
            )


def unfit(dataset: Any) -> str:
    """Why a dataset is not one or several channels of numbers; empty where it is."""
    if dataset.dtype.kind not in "fiub":
        return "holds complex numbers" if dataset.dtype.kind == "c" else "holds no numbers"
    if dataset.shape is None or not dataset.ndim:
        return "is a single number"
    if dataset.ndim > 2 or (dataset.ndim == 2 and dataset.shape[1] > MOST_COLUMNS):
        return f"is an array of {' x '.join(map(str, dataset.shape))}"
    return ""


def field_reader(dataset: Any, name: str) -> Reader:
    """Reads a field of a dataset of records."""
    return lambda begin, end: np.asarray(dataset[begin:end][name], float)


def _read_scaled(dataset: Any, column: int) -> Reader:
    """Reads a column, with fill value, scale and offset as netCDF defines them."""
    scale, offset = dataset.attrs.get("scale_factor"), dataset.attrs.get("add_offset")
    fill = dataset.attrs.get("_FillValue")

    def read(begin: int, end: int) -> Array:
        raw = dataset[begin:end] if dataset.ndim == 1 else dataset[begin:end, column]
        values = np.asarray(raw, float)
        if scale is not None:
            values = values * float(np.ravel(scale)[0])
        if offset is not None:
            values = values + float(np.ravel(offset)[0])
        if fill is not None:
            values = np.where(raw == np.ravel(fill)[0], np.nan, values)
        return values

    return read


def _own_clock(dataset: Any) -> Reader | None:
    for holder in (dataset, dataset.parent):
        start = _number(holder.attrs.get("t0", 0.0)) or 0.0
        for name in ("dt", "sample_interval"):
            if increment := _number(holder.attrs.get(name)):
                return evenly(start, increment)
        for name in ("sample_rate", "sampling_rate", "fs"):
            if rate := _number(holder.attrs.get(name)):
                return lambda begin, end, start=start, rate=rate: start + np.arange(begin, end) / rate  # type: ignore[misc]
    return None


def _number(value: object) -> float | None:
    try:
        number = float(np.ravel(value)[0])  # type: ignore[call-overload]
    except (TypeError, ValueError, IndexError):
        return None
    return number if np.isfinite(number) else None


def _dimension_scale(dataset: Any) -> tuple[str, ...] | None:
    """Path of the dimension scale along the first axis; None for a dataset that is itself one."""
    if dataset.attrs.get("CLASS") == b"DIMENSION_SCALE" or not dataset.dims[0]:
        return None
    return tuple(dataset.dims[0][0].name.strip("/").split("/"))


def text(value: Any) -> str:
    """An attribute as text; empty where there is none."""
    if isinstance(value, np.ndarray):
        value = value.ravel()[0] if value.size == 1 else None
    if isinstance(value, bytes):
        return value.decode("utf-8", "replace")
    return str(value) if value is not None else ""
