"""MATLAB files: versions 4 to 7 through SciPy, version 7.3 (which is HDF5) straight.

Both become the same nodes: numbers, text, structs, and what cannot be read with the reason. A vector of numbers is a
channel, named by the path of structs that leads to it (`log.pressure`). A struct with a field named as a time has it
as clock, so Simulink's "structure with time" and a timeseries taken apart (`Time`, `Data`) are read as they are; a
signal of Simulink goes by its label. Versions up to 7 can only be read whole; of 7.3 only what is asked for is read.
"""

import math
import mmap
import struct
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from vvdp.base.errors import unusable
from vvdp.logs.budget import DEEPEST, Budget, unpack
from vvdp.logs.clock import heading, is_time_name
from vvdp.logs.content import Content, Leaf, Names, Reader
from vvdp.logs.hdf5 import MOST_COLUMNS, Parts, own_item, storage_fault, text

MOST_STRUCTS = 1000
_MATRIX, _COMPRESSED = 14, 15
"""Types of elements of a file of version 5 to 7: a variable or what stands in one, and a compressed variable."""


@dataclass(frozen=True)
class Unreadable:
    """Something that is neither numbers nor text nor a struct, and what."""

    what: str


Fields = Mapping[str, "Node"]
Numbers = Any
"""A real array in memory or in the file, with its axes in the order of HDF5: the last of MATLAB's first."""
Node = Unreadable | str | Sequence[Fields] | Numbers
"""Content of a variable: unreadable, a row of characters, the elements of a struct array, or an array."""


def read_mat(content: Content) -> None:
    """Finds what a MATLAB file of version 4 to 7 holds."""
    import scipy.io

    _check_unpacked(content.budget)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        variables = scipy.io.loadmat(content.path)
    # SciPy leaves the name of an object in the object.
    nodes = {
        _said_by_object(value, "s0") or name: _node(value, content.budget)
        for name, value in variables.items()
        if not name.startswith("__")
    }
    _add_variables(content, nodes)


def read_mat73(content: Content) -> None:
    """Finds what a MATLAB file of version 7.3 holds."""
    content.held = file = h5py.File(content.path, "r")
    nodes = {name: _node73(own_item(file, name), content.budget) for name in file if name[:1] != "#"}
    _add_variables(content, nodes)


def _check_unpacked(budget: Budget) -> None:
    """Raises ConfigError where packed variables hold more than the file may, or are nested deeper than SciPy can go."""
    with budget.path.open("rb") as file, mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as data:
        if 0 in data[:4]:
            return  # version 4, without either
        order = ">" if data[126:128] == b"MI" else "<"
        place, unpacked = 128, 0
        while place + 8 <= len(data):
            kind, size = struct.unpack_from(f"{order}II", data, place)
            end = min(place + 8 + size, len(data))
            if kind == _COMPRESSED:
                held = unpack(data[place + 8 : end], int(budget.largest_content) - unpacked)
                unpacked += len(held)
                budget.check_content(unpacked)
                _check_depth(budget.path, held, order, 0, len(held))
            else:
                _check_depth(budget.path, data, order, place, end)
            place += 8 + size


def _check_depth(path: Path, data: Any, order: str, place: int, end: int) -> None:
    """Raises ConfigError where variables of version 5 are nested deeper than any log."""
    ends: list[int] = []
    while place + 8 <= end:
        while ends and ends[-1] <= place:
            ends.pop()
        kind, size = struct.unpack_from(f"{order}II", data, place)
        place += 8
        if kind == _MATRIX:
            ends.append(place + size)
        elif kind < 1 << 16:  # what is smaller than four bytes stands in its own head
            place += size + -size % 8
        if len(ends) > DEEPEST:
            raise unusable(path, f"holds variables that are nested more than {DEEPEST} deep")


def _said_by_object(value: Any, field: str) -> str:
    """Text of a field of an object of MATLAB's newer classes: its name in `s0`, its class in `s2`; empty for others."""
    if getattr(getattr(value, "dtype", None), "names", None) != ("s0", "s1", "s2", "arr"):
        return ""
    return text(value.ravel()[0][field])


def _node(value: Any, budget: Budget) -> Node:
    budget.count()
    if fault := _fault(value):
        return Unreadable(fault)
    if value.dtype.kind in "US":
        return "".join(map(str, value.ravel()))
    if value.dtype.names is None:
        return value.T
    with budget.inside(id(value)) as fault:
        if fault := _structs_fault(value.size) or fault:
            return Unreadable(fault)
        return [{name: _node(row[name], budget) for name in value.dtype.names} for row in value.ravel(order="F")]


def _fault(value: Any) -> str:
    """Why what SciPy has read is no node; empty where it is."""
    import scipy.io.matlab
    import scipy.sparse

    if scipy.sparse.issparse(value):
        return "is a sparse matrix"
    if isinstance(value, scipy.io.matlab.MatlabFunction):
        return "is a function"
    if isinstance(value, scipy.io.matlab.MatlabOpaque | scipy.io.matlab.MatlabObject):
        return _object_fault(_said_by_object(value, "s2"))
    if not isinstance(value, np.ndarray):
        return "is not an array"
    if value.dtype == object:
        return "is a cell array"
    if value.dtype.names is None and value.dtype.kind not in "fiubUS":
        return "holds complex numbers" if value.dtype.kind == "c" else "holds no numbers"
    return ""


def _object_fault(kind: str) -> str:
    named = f" of class {kind}" if kind else ""
    return f"is a MATLAB object{named}, which only MATLAB can read; save its data as a struct of vectors"


def _structs_fault(number: int) -> str:
    if not number:
        return "is empty"
    return f"is an array of {number} structs" if number > MOST_STRUCTS else ""


def _node73(item: Any, budget: Budget) -> Node:
    budget.count()
    if isinstance(item, str):
        return Unreadable(item)
    about = item.attrs
    kind = text(about.get("MATLAB_class"))
    if fault := _fault73(item, kind, about, budget):
        return Unreadable(fault)
    if isinstance(item, h5py.Group):
        with budget.inside(item.id) as fault:
            return Unreadable(fault) if fault else _structs73(item, budget)
    if kind != "char":
        return item
    letters = np.zeros(0) if "MATLAB_empty" in about else Parts(item)[tuple(slice(0, n) for n in item.shape)].T
    return letters.ravel(order="C").astype("<u2").tobytes().decode("utf-16-le", "replace")


def _fault73(item: Any, kind: str, about: Any, budget: Budget) -> str:
    """Why a group or dataset of a class, with attributes `about` it, is no node; empty where it is."""
    if "MATLAB_sparse" in about:
        return "is a sparse matrix"
    if "MATLAB_object_decode" in about and kind not in ("struct", "cell"):
        return "is a function" if kind == "function_handle" else _object_fault(kind)
    if isinstance(item, h5py.Group):
        return ""
    if kind == "cell" or not isinstance(item, h5py.Dataset):
        return "is a cell array" if kind == "cell" else "is a named type"
    if fault := storage_fault(item, budget):
        return fault
    if item.shape is None or ("MATLAB_empty" in about and kind != "char"):
        return "is empty"
    if (held := item.dtype).kind not in "fiub":
        return "holds complex numbers" if held.names == ("real", "imag") else "holds no numbers"
    return ""


def _structs73(group: Any, budget: Budget) -> Node:
    """A struct: each field either holds its value, or for a struct array a reference for each element."""
    fields = {name: own_item(group, name) for name in group}
    references = {
        name: item[()].T.ravel(order="F")
        for name, item in fields.items()
        if isinstance(item, h5py.Dataset) and item.dtype == h5py.ref_dtype and "MATLAB_class" not in item.attrs
        if not storage_fault(item, budget)
    }
    if not references:
        return [{name: _node73(item, budget) for name, item in fields.items()}]
    number = max(found.size for found in references.values())
    if fault := _structs_fault(number):
        return Unreadable(fault)
    return [
        {name: _node73(group.file[found[k]], budget) for name, found in references.items() if k < found.size}
        for k in range(number)
    ]


def _add_variables(content: Content, nodes: Fields) -> None:
    content.separator = "."
    _add_fields(content, (), nodes, None)


def _add_fields(content: Content, path: Names, fields: Fields, length: int | None) -> None:
    """Adds the fields of one struct; `length` is that of the nearest clock, by which a matrix is cut."""
    for name, node in fields.items():
        if is_time_name(name) and isinstance(node, np.ndarray | h5py.Dataset) and _is_vector(node.shape):
            length = max(node.shape)
    for name, node in fields.items():
        _add(content, (*path, name), node, length, _unit(name, fields))


def _unit(name: str, fields: Fields) -> str:
    """Unit of a field: from `<Name>Info.Units`, as a timeseries has it, or from a text `unit` beside it."""
    about = fields.get(f"{name}Info")
    if isinstance(about, list):
        return _first_text(about[0], ("Units", "units"))
    return "" if is_time_name(name) else _first_text(fields, ("unit", "units", "Unit", "Units"))


def _first_text(fields: Fields, names: Sequence[str]) -> str:
    return next((node.strip() for name in names if isinstance(node := fields.get(name), str)), "")


def _is_vector(shape: tuple[int, ...]) -> bool:
    return len(shape) == 2 and 1 in shape and max(shape) > 1


def _add(content: Content, path: Names, node: Node, length: int | None, unit: str) -> None:
    match node:
        case Unreadable(what):
            content.unreadable[path] = what
        case str():
            content.unreadable[path] = "is text"
        case list():
            for k, fields in enumerate(node, 1):
                own = path if len(node) == 1 else (*path[:-1], f"{path[-1]}({k})")
                if "values" in fields and (label := _first_text(fields, ("label",))):
                    _add_signal(content, own, fields, length, label)
                else:
                    _add_fields(content, own, fields, length)
        case _:
            _add_numbers(content, path, node, length, unit)


def _add_signal(content: Content, path: Names, fields: Fields, length: int | None, label: str) -> None:
    """Adds an element of Simulink's `signals`, which goes by its label."""
    name, unit = heading(label)
    labelled = (*path[:-1], name)
    if labelled in content.leaves or is_time_name(name):
        labelled = (*path, "values")
    _add(content, labelled, fields["values"], length, unit or _unit("values", fields))


def _add_numbers(content: Content, path: Names, numbers: Numbers, length: int | None, unit: str) -> None:
    size = numbers.shape[::-1]
    if fault := _size_fault(size):
        content.unreadable[path] = fault
        return
    across = size[0] == 1 or (size[1] == length != size[0] and size[1] != 1)
    count, samples = size if across else size[::-1]
    if count > MOST_COLUMNS:
        content.unreadable[path] = _array(size)
        return
    for k in range(count):
        place = f"({k + 1},:)" if across else f"(:,{k + 1})"
        own = path if count == 1 else (*path[:-1], path[-1] + place)
        content.add(Leaf(own, samples, _vector(numbers, k, across), unit))


def _vector(numbers: Numbers, k: int, across: bool) -> Reader:
    """Reads a column of MATLAB's, or a row."""
    parts = Parts(numbers)
    if across:
        return lambda begin, end: np.asarray(parts[slice(begin, end), k], float)
    return lambda begin, end: np.asarray(parts[k, slice(begin, end)], float)


def _size_fault(size: Sequence[int]) -> str:
    """Why an array of this size is neither a vector nor a matrix; empty where it is."""
    if 0 in size:
        return "is empty"
    if math.prod(size) == 1:
        return "is a single number"
    return "" if len(size) == 2 else _array(size)


def _array(size: Sequence[int]) -> str:
    return f"is an array of {' x '.join(map(str, size))}"
