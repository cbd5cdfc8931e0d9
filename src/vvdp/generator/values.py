"""Values while a function is read: expressions of the tree, plain Python values that are known, and tuples of both."""

from typing import Any, get_args

import numpy as np

from vvdp.generator import tree
from vvdp.generator.kinds import (
    INT,
    Address,
    Kind,
    Known,
    Record,
    Row,
    Scalar,
    common_kind,
    kind_of,
    scalar_of,
    tuple_of,
)
from vvdp.generator.source import LanguageError

EXPRESSIONS = get_args(tree.Expression)
"""The classes of the tree's expressions."""


class Undefined:
    """Value of a name that is not assigned on some path to it, or not with one type."""

    def __init__(self, reason: str) -> None:
        self.reason = reason


def is_symbol(value: Any) -> bool:
    """Whether a value, or a part of it, is known only when the code runs."""
    if isinstance(value, slice):
        return any(map(is_symbol, (value.start, value.stop, value.step)))
    if isinstance(value, tuple | list):
        return any(map(is_symbol, value))
    return isinstance(value, EXPRESSIONS)


def is_number(value: Any) -> bool:
    """Whether a value is a number, known or not."""
    return isinstance(getattr(value, "kind", None), Scalar) or scalar_of(value) is not None


def is_array(value: Any) -> bool:
    """Whether a value is an array, known or not."""
    return isinstance(value, np.ndarray) or isinstance(getattr(value, "kind", None), Row)


def is_record(value: Any) -> bool:
    """Whether a value is a tuple or NamedTuple, in memory or in parts."""
    return isinstance(value, tuple | list) or isinstance(getattr(value, "kind", None), Record)


def type_of(value: Any) -> Kind:
    """The type of a value as it is; of a known one, that it is known."""
    if isinstance(value, EXPRESSIONS):
        kind: Kind = value.kind
        return kind
    if isinstance(value, tuple | list):
        return Record(_class(value), tuple(map(type_of, value)))
    return Known(value)


def argument_type(value: Any) -> Kind:
    """The type of a value as an argument: a float is not handed over as known, so one function serves all."""
    kind = type_of(value)
    return _open(kind)


def _open(kind: Kind) -> Kind:
    if isinstance(kind, Record):
        return Record(kind.cls, tuple(map(_open, kind.fields)))
    return kind_of(kind.value) if isinstance(kind, Known) and isinstance(kind.value, float) else kind


def carried_type(kind: Kind) -> Kind:
    """The type of what may change, as a variable in a loop: any number is open."""
    if isinstance(kind, Record):
        return Record(kind.cls, tuple(map(carried_type, kind.fields)))
    return scalar_of(kind.value) or kind if isinstance(kind, Known) else kind


def _class(value: tuple[Any, ...] | list[Any]) -> type:
    return tuple if isinstance(value, list) else type(value)


def joined_type(values: list[Any]) -> Kind | None:
    """The type that all values can be converted to; None where there is none."""
    kinds = [None if isinstance(value, Undefined) else type_of(value) for value in values]
    found = kinds[0]
    for kind in kinds[1:]:
        found = None if found is None or kind is None else common_kind(found, kind)
    return found


def are_same(one: Any, other: Any) -> bool:
    """Whether two values are one and the same."""
    if one is other:
        return True
    if isinstance(one, tree.Read) and isinstance(other, tree.Read):
        return one.variable is other.variable
    if isinstance(one, EXPRESSIONS) or isinstance(other, EXPRESSIONS):
        return False
    if isinstance(one, tuple) and isinstance(other, tuple):
        return type(one) is type(other) and len(one) == len(other) and all(map(are_same, one, other))
    return type(one) is type(other) and Known(one) == Known(other)


def part(value: Any, number: int) -> Any:
    """A field of a record; what is known of it is not read."""
    if isinstance(value, tuple | list):
        return value[number]
    kind = value.kind.fields[number]
    return kind.value if isinstance(kind, Known) else tree.Field(value, number, kind)


def parts(value: Any) -> Any:
    """A record as a tuple of its fields."""
    if isinstance(value, tuple | list):
        return value
    return tuple_of(value.kind.cls, [part(value, i) for i in range(len(value.kind.fields))])


def lengths(array: Any) -> tuple[Any, ...]:
    """The lengths of an array, known or not."""
    shape: tuple[int | None, ...] = array.shape if isinstance(array, np.ndarray) else array.kind.shape
    return tuple(tree.Length(array, axis) if n is None else n for axis, n in enumerate(shape))


def describe(value: Any) -> str:
    """A value in words for a message."""
    if isinstance(value, EXPRESSIONS):
        kind = value.kind
        words = {Row: "an array", Record: "a record", Address: "a function"}
        return f"{'an' if kind is INT else 'a'} {kind!r}" if isinstance(kind, Scalar) else words[type(kind)]
    if isinstance(value, Undefined):
        return "undefined"
    name = getattr(value, "__qualname__", None)
    return f"`{name}`" if name else f"the {type(value).__name__} {value!r}"[:80]


def refusal(construct: str, advice: str) -> LanguageError:
    """The error for what the language does not have; the place is added where it is known."""
    return LanguageError(construct, advice)
