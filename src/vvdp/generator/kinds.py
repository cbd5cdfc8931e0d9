"""The types of the language: numbers, arrays, records, addresses of functions, and values that are known before."""

import enum
import struct
from collections.abc import Callable, Hashable, Iterator
from dataclasses import dataclass, fields, is_dataclass
from functools import cache
from typing import Any, TypeAlias, cast

import numpy as np


class Scalar(enum.Enum):
    """A number: what it is called in NumPy."""

    FLOAT = "float64"
    INT = "int64"
    BOOL = "bool"

    def __repr__(self) -> str:
        return self.name.lower()


FLOAT, INT, BOOL = Scalar.FLOAT, Scalar.INT, Scalar.BOOL
POINTER = "pointer"
WIDTH = {BOOL: 0, INT: 1, FLOAT: 2}
"""A number is converted to a wider type where two meet."""


@dataclass(frozen=True)
class Row:
    """An array in C order; `None` for a length that is known only when the code runs."""

    element: Scalar
    shape: tuple[int | None, ...]

    def __repr__(self) -> str:
        return f"{self.element!r}[{', '.join('?' if n is None else str(n) for n in self.shape)}]"


@dataclass(frozen=True)
class Record:
    """A tuple or NamedTuple; in memory its numbers stand one after the other, 8 bytes each."""

    cls: type
    fields: tuple["Kind", ...]

    def __repr__(self) -> str:
        return f"{self.cls.__name__}({', '.join(map(repr, self.fields))})"


@dataclass(frozen=True)
class Address:
    """The address of a function with the C convention of `leaves`."""

    arguments: tuple["Kind", ...]
    result: Scalar | None

    def __repr__(self) -> str:
        return f"({', '.join(map(repr, self.arguments))}) -> {self.result!r}"


@dataclass(frozen=True)
class External:
    """A function of another module, which code calls by its name; what stands for it is stated when code is loaded."""

    name: str
    kind: Address


@dataclass(frozen=True)
class Intrinsic:
    """A function that the caller supplies as LLVM text and as Python: both must give the same bits.

    arguments  their types: an array is handed over as its address and all of its lengths
    text       definitions; among them that of `@<name>`
    plain      the same in Python
    result     a number, or None
    is_pure    whether it takes only floats, gives one, and has no effects
    """

    name: str
    arguments: tuple["Kind", ...]
    text: str
    plain: Callable[..., Any]
    result: Scalar | None = FLOAT
    is_pure: bool = True


@dataclass(frozen=True, eq=False)
class Known:
    """A value that is known before the code runs, and takes no room in it."""

    value: Any

    @property
    def key(self) -> Hashable:
        """Equal for values that no code can distinguish."""
        value = self.value
        if isinstance(value, float):
            return float, struct.pack("<d", value)
        if value is None or isinstance(value, bool | int | str):
            return type(value), value
        return type(value), id(value)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Known) and self.key == other.key

    def __hash__(self) -> int:
        return hash(self.key)

    def __repr__(self) -> str:
        return getattr(self.value, "__qualname__", None) or repr(self.value)


Kind: TypeAlias = Scalar | Row | Record | Address | Known
NOTHING = Known(None)


def leaves(kind: Kind) -> Iterator[Scalar | str]:
    """The numbers and pointers that a value consists of in memory, and as arguments in C unless it is a record."""
    if isinstance(kind, Scalar):
        yield kind
    elif isinstance(kind, Row):
        yield POINTER
        yield from (INT for length in kind.shape if length is None)
    elif isinstance(kind, Record):
        for field in kind.fields:
            yield from leaves(field)
    elif isinstance(kind, Address):
        yield POINTER


def registers_of(kind: Kind) -> list[Scalar | str]:
    """The form in which a value is handed over: of a record its address."""
    return [POINTER] if isinstance(kind, Record) else list(leaves(kind))


@cache
def size(kind: Kind) -> int:
    """How many leaves a value has."""
    return len(list(leaves(kind)))


@cache
def place(kind: Record, number: int) -> int:
    """How many leaves stand before a field of a record."""
    return sum(size(field) for field in kind.fields[:number])


def has_rows(kind: Kind) -> bool:
    """Whether there is an array in a value."""
    return isinstance(kind, Row) or (isinstance(kind, Record) and any(map(has_rows, kind.fields)))


def common_kind(one: Kind, other: Kind) -> Kind | None:
    """The type that values of both can be converted to; None where there is none."""
    if one == other:
        return one
    if isinstance(one, Record) and isinstance(other, Record):
        parts = [common_kind(a, b) for a, b in zip(one.fields, other.fields, strict=False)]
        if one.cls is other.cls and len(one.fields) == len(other.fields) and None not in parts:
            return Record(one.cls, cast(tuple[Kind, ...], tuple(parts)))
        return None
    if isinstance(one, Row) and isinstance(other, Row):
        if one.element is other.element and len(one.shape) == len(other.shape):
            return Row(one.element, tuple(a if a == b else None for a, b in zip(one.shape, other.shape, strict=True)))
        return None
    a, b = number_kind(one), number_kind(other)
    return None if a is None or b is None else max(a, b, key=WIDTH.__getitem__)


def number_kind(kind: Kind) -> Scalar | None:
    """The type of a number, be it known or not; None for all else."""
    if isinstance(kind, Known):
        return scalar_of(kind.value)
    return kind if isinstance(kind, Scalar) else None


def scalar_of(value: Any) -> Scalar | None:
    """The type of a plain number; None for all else."""
    if isinstance(value, bool | np.bool_):
        return BOOL
    if isinstance(value, int | np.integer):
        return INT
    return FLOAT if isinstance(value, float | np.floating) else None


def kind_of(value: Any) -> Kind:
    """The type of an argument like `value`: lengths of arrays are left open; what is no number is known."""
    if isinstance(value, Scalar | Row | Record | Address | Known):
        return value
    if (scalar := scalar_of(value)) is not None:
        return scalar
    if isinstance(value, np.ndarray):
        return Row(element_of(value), (None,) * value.ndim)
    if isinstance(value, tuple):
        return Record(type(value), tuple(map(kind_of, value)))
    if is_dataclass(value) and not isinstance(value, type):
        return Record(stand_in(type(value)), tuple(kind_of(getattr(value, f.name)) for f in fields(value)))
    return Known(value)


def element_of(array: np.ndarray[Any, Any]) -> Scalar:
    """The type of the numbers of an array, which are doubles or 64-bit integers. Raises TypeError for others."""
    found = {"float64": FLOAT, "int64": INT}.get(array.dtype.name)
    if found is None or not array.flags.c_contiguous:
        raise TypeError(f"an array of {array.dtype} numbers; expected float64 or int64 in C order")
    return found


@cache
def stand_in(cls: type) -> type:
    """The NamedTuple with the fields of a frozen dataclass, as which code knows it."""
    from collections import namedtuple

    return namedtuple(cls.__name__, [f.name for f in fields(cls)])


def tuple_of(cls: type, parts: Iterator[Any] | list[Any] | tuple[Any, ...]) -> Any:
    """A tuple or NamedTuple of these parts."""
    return tuple(parts) if cls is tuple else cls(*parts)
