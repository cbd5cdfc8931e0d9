"""Nested values (NamedTuples, parameter classes, signals, arrays) to flat vectors and back."""

import dataclasses
from collections.abc import Callable, Hashable, Iterator, Mapping
from functools import cache, lru_cache
from operator import attrgetter
from typing import Any

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.conservation import NOTHING, Nothing
from vvdp.base.kinds import Kind
from vvdp.base.params import field_kinds, field_types
from vvdp.base.signal import Signal


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


@cache
def _parts_of(cls: type) -> Callable[[Any], tuple[Any, ...]] | None:
    """Function that splits a nested value into its fields, in order; None if there are none."""
    inner = _field_names(cls)
    if not inner:
        return None
    if issubclass(cls, tuple):
        return tuple
    if len(inner) == 1:
        return lambda value: (getattr(value, inner[0]),)
    return attrgetter(*inner)


def parts(value: Any) -> tuple[Any, ...]:
    """The fields of a NamedTuple or dataclass, in order; none for a number or an array."""
    cls: Any = type(value)
    apart = _parts_of(cls)
    return apart(value) if apart else ()


_FLOATS = {float}


def are_floats(values: tuple[Any, ...]) -> bool:
    """Whether all are plain numbers, which most fields are: then there is nothing in them to look for."""
    return set(map(type, values)) == _FLOATS


def form(value: Any, known: dict[int, Hashable]) -> Hashable:
    """The classes and the shapes in a nested value: two of one form have the same names and as many numbers.

    A signal may have any length. `known` are the forms of values at hand, by identity; those found are added, so that
    of what many values share nothing is looked at twice.
    """
    cls: Any = type(value)
    if cls is float:
        return ()
    if cls is Signal:
        return "signal"
    if not (apart := _parts_of(cls)):
        return tuple(np.shape(value))
    if (found := known.get(id(value))) is None:
        inner = apart(value)
        found = (cls,) + (((),) * len(inner) if are_floats(inner) else tuple([form(each, known) for each in inner]))
        known[id(value)] = found
    return found


def flat(value: Any) -> Array:
    """All numbers of a nested value, depth first, shape (n,)."""
    numbers: list[float] = []
    _gather(value, numbers)
    return np.array(numbers, float)


def _gather(value: Any, numbers: list[float]) -> None:
    if inner := parts(value):
        if are_floats(inner):
            numbers += inner
        else:
            for each in inner:
                _gather(each, numbers)
    elif isinstance(value, float):
        numbers.append(value)
    else:
        numbers.extend(np.ravel(np.asarray(value, float)).tolist())


def leaves(value: Any, path: str = "", kind: Kind | None = None) -> Iterator[tuple[str, Any, Kind | None]]:
    """Dotted path, value and kind of every leaf, in the order of `flat`."""
    found: list[Any] = []
    _collect(value, found)
    paths, kinds = _leaf_places(form(value, {}), path, kind)
    return zip(paths, found, kinds, strict=True)


def leaf_paths(found: Hashable) -> tuple[str, ...]:
    """Dotted paths of the leaves of all values of one form, in the order of `flat`."""
    return _leaf_places(found, "", None)[0]


def _collect(value: Any, found: list[Any]) -> None:
    if not (inner := parts(value)):
        found.append(value)
    elif are_floats(inner):
        found += inner
    else:
        for each in inner:
            _collect(each, found)


@lru_cache(maxsize=1000)
def _leaf_places(found: Hashable, path: str, kind: Kind | None) -> tuple[tuple[str, ...], tuple[Kind | None, ...]]:
    """Paths and kinds of the leaves of all values of one form."""
    if found == "signal":
        found = (Signal, *[()] * len(_field_names(Signal)))
    if not (isinstance(found, tuple) and found and isinstance(found[0], type)):
        return (path,), (kind,)
    kinds = field_kinds(found[0])
    inner = [
        _leaf_places(each, f"{path}.{name}" if path else name, kinds.get(name))
        for name, each in zip(_field_names(found[0]), found[1:], strict=True)
    ]
    return tuple(x for paths, _ in inner for x in paths), tuple(x for _, each in inner for x in each)


def same(one: Any, other: Any) -> bool:
    """Whether two nested values have the same names, of fields and classes, and the same numbers."""
    if isinstance(one, Mapping) and isinstance(other, Mapping):
        return list(one) == list(other) and all(same(one[key], other[key]) for key in one)
    if (names(one) or names(other)) and not (type(one).__name__ == type(other).__name__ and names(one) == names(other)):
        return False
    if inner := names(one):
        return all(same(getattr(one, name), getattr(other, name)) for name in inner)
    return np.array_equal(np.asarray(one, float), np.asarray(other, float), equal_nan=True)


def rebuild(example: Any, numbers: Iterator[Any]) -> Any:
    """A value of the shape of `example` with its leaves taken from `numbers`: floats, or whole columns of a record."""
    inner = names(example)
    if inner:
        members = {name: rebuild(getattr(example, name), numbers) for name in inner}
        return type(example)(**members)
    if np.ndim(example):
        shape = np.shape(example)
        found = np.array([next(numbers) for _ in range(int(np.prod(shape)))])
        return found.reshape(*shape, *found.shape[1:])
    return next(numbers)


def as_value(example: Any, vector: Array) -> Any:
    """`vector` in the shape of `example`, floats at the leaves."""
    return rebuild(example, iter([float(x) for x in vector]))


def as_series(example: Any, rows: Array) -> Any:
    """The columns of `rows`, shape (times, n), in the shape of `example`: an array over time at each leaf."""
    return rebuild(example, iter(rows.T))
