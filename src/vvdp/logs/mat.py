"""MATLAB files: versions 4 to 7 through SciPy, version 7.3 (which is HDF5) straight.

Both become the same nodes: numbers, text, structs, and what cannot be read with the reason. A vector of numbers is a
channel, named by the path of structs that leads to it (`log.pressure`). A struct with a field named as a time has it
as clock, so Simulink's "structure with time" and a timeseries taken apart (`Time`, `Data`) are read as they are; a
signal of Simulink goes by its label. Versions up to 7 can only be read whole; of 7.3 only what is asked for is read.
"""

import struct
import warnings
import zlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from vvdp.base.errors import ConfigError
from vvdp.logs.budget import Budget, damage
from vvdp.logs.channel import Log
from vvdp.logs.channel_readers import Leaf, Reader, Tree
from vvdp.logs.clock import ClockChoice, heading, is_time_name
from vvdp.logs.hdf5 import MOST_COLUMNS, open_hdf5, own_item, storage_fault, text

MOST_STRUCTS = 1000
_COMPRESSED = 15
"""The type of a compressed variable in a file of version 5 to 7."""
_PIECE = 1 << 16


@dataclass(frozen=True)
class Numbers:
    """A real array: its MATLAB size, and a reader of one of its columns (or of one of its rows)."""

    size: tuple[int, ...]
    column: Callable[[int], Reader]
    row: Callable[[int], Reader]


@dataclass(frozen=True)
class Structs:
    """A struct array: the fields of every element."""

    elements: Sequence[Mapping[str, "Node"]]


@dataclass(frozen=True)
class Text:
    """A row of characters."""

    content: str


@dataclass(frozen=True)
class Other:
    """Something else, and what."""

    what: str


Node = Numbers | Structs | Text | Other


def mat_log(path: Path, choice: ClockChoice) -> Log:
    """The log in a MATLAB file of version 4 to 7."""
    import scipy.io

    budget = Budget(path)
    try:
        _check_unpacked(budget)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            content = scipy.io.loadmat(path)
        variables = {
            _variable(name, value): _from_scipy(value, budget)
            for name, value in content.items()
            if not name.startswith("__")
        }
        tree = _tree(path, choice, variables)
    except (ConfigError, MemoryError):
        raise
    except Exception as problem:  # SciPy raises many unrelated types on damaged files
        raise damage(path, "the MATLAB file", problem) from None
    return tree.log()


def _check_unpacked(budget: Budget) -> None:
    """Raises ConfigError where compressed variables hold more than the file may; they can only be read whole."""
    unpacked = 0
    with budget.path.open("rb") as file:
        head = file.read(128)
        order = ">" if head[126:128] == b"MI" else "<"
        while head[:6] == b"MATLAB" and len(tag := file.read(8)) == 8:
            kind, size = struct.unpack(f"{order}II", tag)
            end = file.tell() + size
            unpacker = zlib.decompressobj() if kind == _COMPRESSED else None
            while unpacker is not None and file.tell() < end and (piece := file.read(min(_PIECE, end - file.tell()))):
                while piece:
                    unpacked += len(unpacker.decompress(piece, 16 * _PIECE))
                    budget.check_content(unpacked)
                    piece = unpacker.unconsumed_tail
            file.seek(end)


def mat73_log(path: Path, choice: ClockChoice) -> Log:
    """The log in a MATLAB file of version 7.3."""
    file = open_hdf5(path)
    try:
        reader = _Reader73(file, Budget(path))
        tree = _tree(path, choice, {name: reader.node(own_item(file, name)) for name in file if name[:1] != "#"})
    except ConfigError:
        file.close()
        raise
    except Exception as problem:  # h5py raises many unrelated types on damaged files
        file.close()
        raise damage(path, "the MATLAB 7.3 file", problem) from None
    return tree.log(file)


def _variable(name: str, value: Any) -> str:
    """The name of a variable; SciPy leaves that of an object in the object."""
    return _opaque(value, "s0") or name


def _opaque(value: Any, field: str) -> str:
    """What an object of MATLAB's newer classes says of itself: its name in `s0`, its class in `s2`."""
    if getattr(getattr(value, "dtype", None), "names", None) != ("s0", "s1", "s2", "arr"):
        return ""
    return text(value.ravel()[0][field])


def _from_scipy(value: Any, budget: Budget) -> Node:
    import scipy.io.matlab
    import scipy.sparse

    budget.count()
    if scipy.sparse.issparse(value):
        return Other("is a sparse matrix")
    if isinstance(value, scipy.io.matlab.MatlabFunction):
        return Other("is a function")
    if isinstance(value, scipy.io.matlab.MatlabOpaque | scipy.io.matlab.MatlabObject):
        return Other(_object(_opaque(value, "s2")))
    if not isinstance(value, np.ndarray):
        return Other("is not an array")
    if value.dtype.names is not None:
        if fault := _struct_fault(value.size) or budget.enter(id(value)):
            return Other(fault)
        rows = value.ravel(order="F")
        found = Structs([{name: _from_scipy(row[name], budget) for name in value.dtype.names} for row in rows])
        budget.leave()
        return found
    if value.dtype == object:
        return Other("is a cell array")
    if value.dtype.kind in "US":
        return Text("".join(map(str, value.ravel())))
    if value.dtype.kind not in "fiub":
        return Other("holds complex numbers" if value.dtype.kind == "c" else "holds no numbers")
    return Numbers(value.shape, lambda k: _slices(value[:, k]), lambda k: _slices(value[k, :]))


def _slices(vector: Any) -> Reader:
    return lambda begin, end: np.asarray(vector[begin:end], float)


def _object(kind: str) -> str:
    named = f" of class {kind}" if kind else ""
    return f"is a MATLAB object{named}, which only MATLAB can read; save its data as a struct of vectors"


def _struct_fault(number: int) -> str:
    if not number:
        return "is empty"
    return f"is an array of {number} structs" if number > MOST_STRUCTS else ""


class _Reader73:
    """Reads the nodes of a file of version 7.3, within a budget."""

    def __init__(self, file: Any, budget: Budget) -> None:
        self._file, self._budget = file, budget

    def node(self, item: Any) -> Node:
        """The node of a group or dataset, or of the reason why there is none."""
        self._budget.count()
        if isinstance(item, str):
            return Other(item)
        kind = text(item.attrs.get("MATLAB_class"))
        if "MATLAB_sparse" in item.attrs:
            return Other("is a sparse matrix")
        if "MATLAB_object_decode" in item.attrs and kind not in ("struct", "cell"):
            return Other("is a function" if kind == "function_handle" else _object(kind))
        if isinstance(item, h5py.Group):
            if fault := self._budget.enter(item.id):
                return Other(fault)
            found = self._struct(item)
            self._budget.leave()
            return found
        if fault := "" if isinstance(item, h5py.Dataset) else "is a named type":
            return Other(fault)
        return Other("is a cell array") if kind == "cell" else self._array(item, kind)

    def _array(self, item: Any, kind: str) -> Node:
        if fault := storage_fault(item, self._budget):
            return Other(fault)
        if "MATLAB_empty" in item.attrs:
            return Text("") if kind == "char" else Other("is empty")
        if kind == "char":
            return Text(item[()].T.ravel(order="C").astype("<u2").tobytes().decode("utf-16-le", "replace"))
        if item.dtype.names is not None or item.dtype.kind not in "fiub":
            return Other("holds complex numbers" if item.dtype.names == ("real", "imag") else "holds no numbers")
        # MATLAB counts down the columns, HDF5 along the rows: sizes are reversed.
        return Numbers(item.shape[::-1], lambda k: _along(item, (k, None)), lambda k: _along(item, (None, k)))

    def _struct(self, group: Any) -> Node:
        """A struct: each field either holds its value, or for a struct array a reference for each element."""
        fields = {name: own_item(group, name) for name in group}
        references = {
            name: item[()].T.ravel(order="F")
            for name, item in fields.items()
            if isinstance(item, h5py.Dataset) and item.dtype == h5py.ref_dtype and "MATLAB_class" not in item.attrs
            if not storage_fault(item, self._budget)
        }
        if not references:
            return Structs([{name: self.node(item) for name, item in fields.items()}])
        number = max(found.size for found in references.values())
        if fault := _struct_fault(number):
            return Other(fault)
        return Structs(
            [
                {name: self.node(self._file[found[k]]) for name, found in references.items() if k < found.size}
                for k in range(number)
            ]
        )


def _along(dataset: Any, fixed: tuple[int | None, int | None]) -> Reader:
    def read(begin: int, end: int) -> Any:
        span = tuple(slice(begin, end) if index is None else index for index in fixed)
        return np.asarray(dataset[span], float)

    return read


def _tree(path: Path, choice: ClockChoice, variables: Mapping[str, Node]) -> Tree:
    tree = Tree(path, choice, ".")
    _add_fields(tree, (), variables, None)
    return tree


def _add_fields(tree: Tree, path: tuple[str, ...], fields: Mapping[str, Node], length: int | None) -> None:
    """Adds the fields of one struct; `length` is that of the nearest clock, by which a matrix is cut."""
    for name, node in fields.items():
        if is_time_name(name) and isinstance(node, Numbers) and _is_vector(node):
            length = max(node.size)
    for name, node in fields.items():
        _add(tree, (*path, name), node, length, _unit(name, fields))


def _unit(name: str, fields: Mapping[str, Node]) -> str:
    """Unit of a field: from `<Name>Info.Units`, as a timeseries has it, or from a text `unit` beside it."""
    about = fields.get(f"{name}Info")
    if isinstance(about, Structs):
        return _text(about.elements[0], ("Units", "units"))
    return "" if is_time_name(name) else _text(fields, ("unit", "units", "Unit", "Units"))


def _text(fields: Mapping[str, Node], names: Sequence[str]) -> str:
    found = (node.content.strip() for name in names if isinstance(node := fields.get(name), Text))
    return next(found, "")


def _add(tree: Tree, path: tuple[str, ...], node: Node, length: int | None, unit: str) -> None:
    match node:
        case Other(what):
            tree.refuse(path, what)
        case Text():
            tree.refuse(path, "is text")
        case Structs(elements):
            for k, fields in enumerate(elements, 1):
                own = path if len(elements) == 1 else (*path[:-1], f"{path[-1]}({k})")
                _add_signal(tree, own, fields, length) if _is_signal(fields) else _add_fields(tree, own, fields, length)
        case Numbers():
            _add_numbers(tree, path, node, length, unit)


def _is_signal(fields: Mapping[str, Node]) -> bool:
    """Whether this is an element of Simulink's `signals`, with a label to go by."""
    return "values" in fields and isinstance(label := fields.get("label"), Text) and bool(label.content.strip())


def _add_signal(tree: Tree, path: tuple[str, ...], fields: Mapping[str, Node], length: int | None) -> None:
    name, unit = heading(_text(fields, ("label",)))
    labelled = (*path[:-1], name)
    if labelled in tree.leaves or is_time_name(name):
        labelled = (*path, "values")
    _add(tree, labelled, fields["values"], length, unit or _unit("values", fields))


def _is_vector(numbers: Numbers) -> bool:
    return len(numbers.size) == 2 and 1 in numbers.size and max(numbers.size) > 1


def _add_numbers(tree: Tree, path: tuple[str, ...], numbers: Numbers, length: int | None, unit: str) -> None:
    size = numbers.size
    if 0 in size:
        tree.refuse(path, "is empty")
    elif max(size) == 1:
        tree.refuse(path, "is a single number")
    elif len(size) != 2:
        tree.refuse(path, f"is an array of {' x '.join(map(str, size))}")
    elif _is_vector(numbers):
        read = numbers.column(0) if size[1] == 1 else numbers.row(0)
        tree.add(Leaf(path, max(size), read, unit))
    else:
        across = size[1] == length != size[0]
        count, samples = size if across else size[::-1]
        if count > MOST_COLUMNS:
            tree.refuse(path, f"is an array of {size[0]} x {size[1]}")
            return
        for k in range(count):
            column = (*path[:-1], f"{path[-1]}({k + 1},:)" if across else f"{path[-1]}(:,{k + 1})")
            tree.add(Leaf(column, samples, numbers.row(k) if across else numbers.column(k), unit))
