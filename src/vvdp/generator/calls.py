"""Calls of generated functions from Python: values to what C hands over, and back."""

import ctypes
from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from vvdp.generator.kinds import (
    BOOL,
    FLOAT,
    INT,
    POINTER,
    Kind,
    Known,
    Record,
    Row,
    Scalar,
    registers_of,
    size,
    tuple_of,
)
from vvdp.generator.library import Failure

if TYPE_CHECKING:
    from vvdp.generator.binding import Loaded
    from vvdp.generator.tree import Module

C_TYPES: dict[Any, Any] = {
    FLOAT: ctypes.c_double, INT: ctypes.c_int64, BOOL: ctypes.c_bool, POINTER: ctypes.c_void_p,
}  # fmt: skip

READ: dict[Kind, Callable[[Any], Any]] = {FLOAT: lambda slot: float(slot.view(np.float64)), INT: int, BOOL: bool}


class Entry:
    """A generated function that takes and gives Python values; as a whole number it is its address.

    A call releases the interpreter's lock. It raises Failure with file, line and reason where the function fails, and
    TypeError for values of other types than `kinds`.
    """

    def __init__(self, address: int, kinds: Sequence[Kind], result: Kind, reason: Callable[[int], str], keeper: Any):
        self.address, self.kinds, self.result = address, tuple(kinds), result
        self._reason, self._keeper = reason, keeper
        types = [C_TYPES[leaf] for kind in self.kinds for leaf in registers_of(kind)]
        if isinstance(result, Record):
            types.insert(0, ctypes.c_void_p)
        returned = C_TYPES[result] if isinstance(result, Scalar) else None
        self._run = ctypes.CFUNCTYPE(returned, *types, ctypes.c_void_p)(address)

    def __int__(self) -> int:
        return self.address

    def __call__(self, *values: Any) -> Any:
        trouble = ctypes.c_int64(0)
        result, kept, handed = self.result, list[Any](), list[Any]()
        if isinstance(result, Record):
            kept.append(np.zeros(max(1, size(result)), np.int64))
            handed.append(kept[0].ctypes.data)
        for value, kind in zip(values, self.kinds, strict=True):
            handed += _c_arguments(value, kind, kept)
        answer = self._run(*handed, ctypes.addressof(trouble))
        if trouble.value:
            raise Failure(self._reason(trouble.value))
        if isinstance(result, Known):
            return result.value
        return _read(result, iter(kept[0])) if isinstance(result, Record) else answer


def callables(module: "Module", loaded: "Loaded") -> dict[str, Entry]:
    """The entries of a module as functions of Python values, which keep its code in memory."""
    entries = (function for function in module.functions if function.name in module.entries)
    return {
        f.name: Entry(
            address=loaded.addresses[f.name],
            kinds=[parameter.kind for parameter in f.parameters],
            result=f.result,
            reason=lambda number: module.reasons[number - 1],
            keeper=loaded,
        )
        for f in entries
    }


def _c_arguments(value: Any, kind: Kind, kept: list[Any]) -> list[Any]:
    """The arguments in C for a value; what they point to is added to `kept`."""
    if kind is FLOAT:
        return [float(value)]
    if isinstance(kind, Scalar):
        return [int(value)]
    if isinstance(kind, Record):
        block = np.array(list(_slots(value, kind, kept)), np.int64)
        kept.append(block)
        return [block.ctypes.data]
    if isinstance(kind, Row):
        return _row_slots(value, kind, kept)
    return [int(value)]


def _row_slots(array: Any, kind: Row, kept: list[Any]) -> list[int]:
    if not (isinstance(array, np.ndarray) and array.dtype == kind.element.value and array.flags.c_contiguous):
        raise TypeError(f"expected an array of {kind.element.value} in C order")
    if len(array.shape) != len(kind.shape):
        raise TypeError(f"an array of shape {array.shape}; expected {kind!r}")
    lengths = [n for n, wanted in zip(array.shape, kind.shape, strict=True) if wanted is None]
    known = zip(array.shape, kind.shape, strict=True)
    if len(lengths) < len(array.shape) and any(wanted not in (None, n) for n, wanted in known):
        raise TypeError(f"an array of shape {array.shape}; expected {kind!r}")
    kept.append(array)
    return [array.__array_interface__["data"][0], *lengths]


def _slots(value: Any, kind: Record, kept: list[Any]) -> Iterator[int]:
    """The numbers of a record, 8 bytes each."""
    names: Sequence[Any] = getattr(kind.cls, "_fields", range(len(kind.fields)))
    for name, field in zip(names, kind.fields, strict=True):
        one = value[name] if isinstance(name, int) else getattr(value, name)
        if isinstance(field, Record):
            yield from _slots(one, field, kept)
        elif isinstance(field, Row):
            yield from _row_slots(one, field, kept)
        elif field is FLOAT:
            yield int(np.float64(one).view(np.int64))
        elif not isinstance(field, Known):
            yield int(one)


def _read(kind: Record, slots: Iterator[np.int64]) -> Any:
    """A record from its numbers."""
    found: list[Any] = []
    for field in kind.fields:
        if isinstance(field, Record):
            found.append(_read(field, slots))
        elif isinstance(field, Known):
            found.append(field.value)
        else:
            number = next(slots)
            found.append(READ[field](number))
    return tuple_of(kind.cls, found)
