"""Nested values (NamedTuples, parameter classes, signals, arrays) to flat vectors and back."""

import dataclasses
from collections.abc import Iterator, Mapping
from functools import cache
from typing import Any

import numpy as np

from vvdp.base.books import NOTHING, Nothing
from vvdp.base.kinds import Kind
from vvdp.base.params import field_kinds, field_types
from vvdp.numerics.tableaus import Array


def names(value: Any) -> tuple[str, ...]:
    """Field names of a NamedTuple or dataclass, or of such a class; none for a number or an array."""
    return _field_names(value if isinstance(value, type) else type(value))


@cache
def _field_names(cls: type) -> tuple[str, ...]:
    if dataclasses.is_dataclass(cls):
        return tuple(f.name for f in dataclasses.fields(cls))
    return tuple(getattr(cls, "_fields", ()))


def blank(cls: type) -> Any:
    """A NamedTuple of zeros."""
    if cls is Nothing:
        return NOTHING
    hints = field_types(cls)
    return cls(*(blank(hints[name]) if names(hints[name]) else 0.0 for name in names(cls)))


def flat(value: Any) -> Array:
    """All numbers of a nested value, depth first, shape (n,)."""
    numbers: list[float] = []
    _gather(value, numbers)
    return np.array(numbers, float)


def _gather(value: Any, numbers: list[float]) -> None:
    if inner := names(value):
        for name in inner:
            _gather(getattr(value, name), numbers)
    elif isinstance(value, float):
        numbers.append(value)
    else:
        numbers.extend(np.ravel(np.asarray(value, float)).tolist())


def leaves(value: Any, path: str = "", kind: Kind | None = None) -> Iterator[tuple[str, Any, Kind | None]]:
    """Dotted path, value and kind of every leaf, in the order of `flat`."""
    inner = names(value)
    if not inner:
        yield path, value, kind
        return
    kinds = field_kinds(type(value))
    for name in inner:
        yield from leaves(getattr(value, name), f"{path}.{name}" if path else name, kinds.get(name))


def same(one: Any, other: Any) -> bool:
    """Whether two nested values have the same names, of fields and classes, and the same numbers."""
    if isinstance(one, Mapping) and isinstance(other, Mapping):
        return list(one) == list(other) and all(same(one[key], other[key]) for key in one)
    if (names(one) or names(other)) and not (type(one).__name__ == type(other).__name__ and names(one) == names(other)):
        return False
    if inner := names(one):
        return all(same(getattr(one, name), getattr(other, name)) for name in inner)
    return np.array_equal(np.asarray(one, float), np.asarray(other, float), equal_nan=True)


def rebuilt(example: Any, numbers: Iterator[Any]) -> Any:
    """A value of the shape of `example` with its leaves taken from `numbers`: floats, or whole columns of a record."""
    inner = names(example)
    if inner:
        members = {name: rebuilt(getattr(example, name), numbers) for name in inner}
        return type(example)(**members)
    if np.ndim(example):
        shape = np.shape(example)
        found = np.array([next(numbers) for _ in range(int(np.prod(shape)))])
        return found.reshape(*shape, *found.shape[1:])
    return next(numbers)


def as_value(example: Any, vector: Array) -> Any:
    """`vector` in the shape of `example`, floats at the leaves."""
    return rebuilt(example, iter([float(x) for x in vector]))


def as_series(example: Any, rows: Array) -> Any:
    """The columns of `rows`, shape (times, n), in the shape of `example`: an array over time at each leaf."""
    return rebuilt(example, iter(rows.T))
