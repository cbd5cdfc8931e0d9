"""HDF5 files, vvdp's own results among them: every dataset of numbers is a channel.

A dataset may carry its unit (attribute `units` or `unit`) and its clock (`dt` or `sample_rate`, `t0`; or a dimension
scale, as netCDF writes it). Otherwise the dataset named as a time beside it or above it is the clock.
"""

import itertools
import math
from typing import Any

import h5py
import numpy as np

from vvdp.base.arrays import Array
from vvdp.logs.budget import LARGEST_CHUNK, Budget, unpack
from vvdp.logs.content import Content, Leaf, Names, Reader, at_rate, evenly

MOST_COLUMNS = 64
"""A matrix with more columns is not a set of channels."""


def read_hdf5(content: Content) -> None:
    """Finds what an HDF5 file holds."""
    content.held = h5py.File(content.path, "r")
    _walk(content, (), content.held)


def _walk(content: Content, path: Names, group: Any) -> None:
    with content.budget.inside(group.id) as fault:
        if fault:
            content.unreadable[path] = fault
            return
        content.budget.count(len(group))
        for name in group:
            own, item = (*path, name), own_item(group, name)
            if isinstance(item, h5py.Group):
                _walk(content, own, item)
            elif isinstance(item, h5py.Dataset):
                _add(content, own, item)
            else:
                content.unreadable[own] = item if isinstance(item, str) else "is a named type"


def own_item(group: Any, name: str) -> Any:
    """Item in a group under `name`, or the reason why it is not read: only items of this file are."""
    if isinstance(group.get(name, getlink=True), h5py.ExternalLink):
        return "lies in another file"
    try:
        item = group[name]
    except (KeyError, OSError, RuntimeError):
        return "is a broken link"
    return item if item.file.filename == group.file.filename else "lies in another file"


def storage_fault(dataset: Any, budget: Budget) -> str:
    """Why a dataset is not read, as it is stored; empty where it is."""
    if dataset.external or (dataset.is_virtual and any(each.file_name != "." for each in dataset.virtual_sources())):
        return "lies in another file"
    size = dataset.dtype.itemsize
    chunk, whole = size * math.prod(dataset.chunks or ()), size * (dataset.size or 0)
    return budget.chunk_fault(chunk) or budget.content_fault(whole)


def _add(content: Content, path: Names, dataset: Any) -> None:
    if dataset.dtype.names and not storage_fault(dataset, content.budget):
        for name in dataset.dtype.names:
            if dataset.ndim == 1 and dataset.dtype[name].kind in "fiub" and not dataset.dtype[name].shape:
                content.add(Leaf((*path, name), len(dataset), _field(dataset, name)))
            else:
                content.unreadable[*path, name] = "is not a column of numbers"
        return
    if fault := storage_fault(dataset, content.budget) or _content_fault(dataset):
        content.unreadable[path] = fault
        return
    unit = text(dataset.attrs.get("units", dataset.attrs.get("unit")))
    clock = _own_clock(dataset) or _dimension_scale(dataset)
    for k in range(1 if dataset.ndim == 1 else dataset.shape[1]):
        own = path if dataset.ndim == 1 else (*path[:-1], f"{path[-1]}[{k}]")
        content.add(Leaf(own, len(dataset), _column(dataset, k), unit, clock=clock))


def _content_fault(dataset: Any) -> str:
    """Why a dataset is not one or several channels of numbers; empty where it is."""
    if dataset.dtype.kind not in "fiub":
        return "holds complex numbers" if dataset.dtype.kind == "c" else "holds no numbers"
    if dataset.shape is None or not dataset.ndim:
        return "is a single number"
    if dataset.ndim > 2 or (dataset.ndim == 2 and dataset.shape[1] > MOST_COLUMNS):
        return f"is an array of {' x '.join(map(str, dataset.shape))}"
    return ""


class Parts:
    """Parts of a dataset, or of an array, by slices and numbers; each compressed chunk is checked once.

    HDF5 takes a chunk of any length, and fills one that is too short with whatever its memory held before. Raises
    ValueError for a chunk that does not hold what its shape needs.
    """

    def __init__(self, dataset: Any) -> None:
        self._dataset = dataset
        self._checked = set[tuple[int, ...]]()

    def __getitem__(self, selection: tuple[slice | int, ...]) -> Any:
        if getattr(self._dataset, "compression", None) == "gzip":
            spans = [slice(each, each + 1) if isinstance(each, int) else each for each in selection]
            chunks = zip(spans, self._dataset.chunks, strict=True)
            for place in itertools.product(*(range(s.start // n * n, s.stop, n) for s, n in chunks)):
                if place not in self._checked:
                    self._check(place)
                    self._checked.add(place)
        return self._dataset[selection]

    def _check(self, place: tuple[int, ...]) -> None:
        held = self._dataset.id
        if not held.get_chunk_info_by_coord(place).size:
            return  # never written: it holds the fill value
        without_filter, packed = held.read_direct_chunk(place)
        expected = self._dataset.dtype.itemsize * math.prod(self._dataset.chunks)
        if not without_filter and (size := len(unpack(packed, LARGEST_CHUNK))) != expected:
            found = f"more than {LARGEST_CHUNK}" if size > LARGEST_CHUNK else size
            raise ValueError(f"a compressed chunk holds {found} bytes, its shape needs {expected}")


def _field(dataset: Any, name: str) -> Reader:
    """Reads a field of a dataset of records."""
    parts = Parts(dataset)
    return lambda begin, end: np.asarray(parts[slice(begin, end),][name], float)


def _column(dataset: Any, column: int) -> Reader:
    """Reads a column, with fill value, scale and offset as netCDF defines them."""
    scale, offset, fill = (dataset.attrs.get(name) for name in ("scale_factor", "add_offset", "_FillValue"))
    across = (column,) if dataset.ndim > 1 else ()
    parts = Parts(dataset)

    def read(begin: int, end: int) -> Array:
        raw = parts[slice(begin, end), *across]
        values = np.asarray(raw, float)
        if scale is not None:
            values = values * float(np.ravel(scale)[0])
        if offset is not None:
            values = values + float(np.ravel(offset)[0])
        return values if fill is None else np.where(raw == np.ravel(fill)[0], np.nan, values)

    return read


def _own_clock(dataset: Any) -> Reader | None:
    for holder in (dataset, dataset.parent):
        start = _number(holder, "t0")
        for name in ("dt", "sample_interval"):
            if increment := _number(holder, name):
                return evenly(start, increment)
        for name in ("sample_rate", "sampling_rate", "fs"):
            if rate := _number(holder, name):
                return at_rate(rate, start)
    return None


def _number(holder: Any, name: str) -> float:
    """An attribute as a number; 0 where it is none."""
    try:
        number = float(np.ravel(holder.attrs.get(name))[0])
    except (TypeError, ValueError, IndexError):
        return 0.0
    return number if np.isfinite(number) else 0.0


def _dimension_scale(dataset: Any) -> Names | None:
    """Path of the dimension scale along the first axis; None for a dataset that is itself one."""
    try:
        if dataset.attrs.get("CLASS") == b"DIMENSION_SCALE" or not dataset.dims[0]:
            return None
        return tuple(dataset.dims[0][0].name.strip("/").split("/"))
    except RuntimeError:  # it points to nothing
        return None


def text(value: Any) -> str:
    """An attribute as text; empty where there is none."""
    if isinstance(value, np.ndarray):
        value = value.ravel()[0] if value.size == 1 else None
    if isinstance(value, bytes):
        return value.decode("utf-8", "replace")
    return str(value) if value is not None else ""
