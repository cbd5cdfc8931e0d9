"""Calls of generated functions from Python: values to what C hands over, and back."""

import ctypes
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np

from vvdp.generator.binding import Loaded
from vvdp.generator.kinds import BOOL, FLOAT, INT, Kind, Known, Record, Row, Scalar, size
from vvdp.generator.library import Failure
from vvdp.generator.tree import Function, Module
from vvdp.generator.values import tuple_of

C_TYPES: dict[Kind, Any] = {FLOAT: ctypes.c_double, INT: ctypes.c_int64, BOOL: ctypes.c_bool}

READ: dict[Kind, Callable[[Any], Any]] = {FLOAT: lambda slot: float(slot.view(np.float64)), INT: int, BOOL: bool}


def callables(module: Module, loaded: Loaded) -> dict[str, Callable[..., Any]]:
    """The entries of a module as functions of Python values, which keep its code in memory."""
    return {f.name: _callable(f, loaded, module) for f in module.functions if f.name in module.entries}


def _callable(function: Function, loaded: Loaded, module: Module) -> Callable[..., Any]:
    kinds = [parameter.kind for parameter in function.parameters]
    result = function.result

    def call(*values: Any) -> Any:
        """Raises Failure with file, line and reason where the function fails, TypeError for other arguments."""
        found = np.zeros(max(1, size(result)), np.int64)
        trouble, kept = ctypes.c_int64(0), [found]
        handed = [ctypes.c_void_p(found.ctypes.data)] if isinstance(result, Record) else []
        for value, kind in zip(values, kinds, strict=True):
            handed += _c_arguments(value, kind, kept)
        returned = C_TYPES[result] if isinstance(result, Scalar) else None
        types: list[Any] = [type(each) for each in handed]
        run = ctypes.CFUNCTYPE(returned, *types, ctypes.c_void_p)(loaded.addresses[function.name])
        answer = run(*handed, ctypes.addressof(trouble))
        if trouble.value:
            raise Failure(module.reasons[trouble.value - 1])
        if isinstance(result, Known):
            return result.value
        return _read(result, iter(found)) if isinstance(result, Record) else answer

    return call


def _c_arguments(value: Any, kind: Kind, kept: list[Any]) -> list[Any]:
    """The arguments in C for a value; what they point to is added to `kept`."""
    if isinstance(kind, Scalar):
        return [C_TYPES[kind](value)]
    if isinstance(kind, Record):
        block = np.array(list(_slots(value, kind, kept)), np.int64)
        kept.append(block)
        return [ctypes.c_void_p(block.ctypes.data)]
    if isinstance(kind, Row):
        address, *lengths = _row_slots(value, kind, kept)
        return [ctypes.c_void_p(address), *map(ctypes.c_int64, lengths)]
    return [ctypes.c_void_p(int(value))]


def _row_slots(array: Any, kind: Row, kept: list[Any]) -> list[int]:
    if not (isinstance(array, np.ndarray) and array.dtype == kind.element.value and array.flags.c_contiguous):
        raise TypeError(f"expected an array of {kind.element.value} in C order")
    known = zip(array.shape, kind.shape, strict=True)
    if any(wanted not in (None, length) for length, wanted in known):
        raise TypeError(f"an array of shape {array.shape}; expected {kind!r}")
    kept.append(array)
    return [array.ctypes.data, *(n for n, wanted in zip(array.shape, kind.shape, strict=True) if wanted is None)]


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
