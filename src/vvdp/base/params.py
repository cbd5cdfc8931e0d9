"""Parameter classes: frozen, keyword-only, every field of a kind, every value checked when it is made."""

import dataclasses
from collections.abc import Callable
from functools import cache
from typing import Any, Union, dataclass_transform, get_args, get_origin, get_type_hints

from vvdp.base.errors import ParameterError
from vvdp.base.kinds import Kind
from vvdp.base.signal import Signal


def field_kinds(cls: type) -> dict[str, Kind | None]:
    """The kind of every annotated field of a class or NamedTuple; None for a nested one."""
    return _field_kinds(cls)


@cache
def _field_kinds(cls: type) -> dict[str, Kind | None]:
    return {name: _kind(hint) for name, hint in get_type_hints(cls, include_extras=True).items()}


def _kind(hint: Any) -> Kind | None:
    """The kind of an annotation, that of a quantity which may be None included."""
    quantity = get_args(hint)[0] if get_origin(hint) is Union else hint
    return next((each for each in getattr(quantity, "__metadata__", ()) if isinstance(each, Kind)), None)


def argument_kinds(function: Callable[..., Any]) -> dict[str, Kind | None]:
    """The kind of every annotated argument of a function, by name; None where it has none."""
    hints = get_type_hints(function, include_extras=True)
    return {name: _kind(hint) for name, hint in hints.items() if name != "return"}


def field_types(cls: type) -> dict[str, Any]:
    """The plain type of every annotated field of a class."""
    return _field_types(cls)


@cache
def _field_types(cls: type) -> dict[str, Any]:
    return get_type_hints(cls)


def field_names(cls: type) -> list[str]:
    """The fields of a parameter class, in their order."""
    return [each.name for each in dataclasses.fields(cls)]


def field_values(cls: type, record: Any) -> dict[str, Any]:
    """The values that a record has of the fields of a parameter class."""
    return {name: getattr(record, name) for name in field_names(cls)}


def default_values(cls: type) -> dict[str, Any]:
    """The fields of a parameter class that need not be given, with their values."""
    return {f.name: f.default for f in dataclasses.fields(cls) if f.default is not dataclasses.MISSING}


@dataclasses.dataclass(frozen=True)
class Idle:
    """Of a field, in its annotation: it has no effect while all of these values are 0.

    They are fields of its class, or `table.key` of another table of the file.
    """

    factors: tuple[str, ...]


def without_effect(*factors: str) -> Idle:
    """That a field has no effect while these are 0: `Annotated[Count, without_effect("ripple_amplitude")]`."""
    return Idle(factors)


def idle_fields(cls: type) -> dict[str, tuple[str, ...]]:
    """The fields of a class that have no effect while others are 0, with the names of those."""
    return _idle_fields(cls)


@cache
def _idle_fields(cls: type) -> dict[str, tuple[str, ...]]:
    found: dict[str, tuple[str, ...]] = {}
    for name, hint in get_type_hints(cls, include_extras=True).items():
        for each in getattr(hint, "__metadata__", ()):
            if isinstance(each, Idle):
                found[name] = each.factors
    return found


@dataclass_transform(frozen_default=True, kw_only_default=True)
class Params:
    """Base of every parameter class. A subclass is made a frozen, keyword-only dataclass by being written down.

    Raises `ParameterError` when a value lies outside the range of its kind.
    """

    def __init_subclass__(cls) -> None:
        if "check" in cls.__annotations__:
            raise ParameterError(f"{cls.__name__}.check: a field cannot be called so; `check` refuses values")
        dataclasses.dataclass(frozen=True, kw_only=True)(cls)

    def __post_init__(self) -> None:
        for name, kind in field_kinds(type(self)).items():
            value = getattr(self, name)
            if kind is None or (value is None and default_values(type(self)).get(name, kind) is None):
                continue
            if isinstance(value, str):
                raise ParameterError(
                    f"{type(self).__name__}.{name}: {value!r} is a text; expected a number in SI, as "
                    f"vvdp.base.units.parse({value!r}, kind) gives, for example of {kind.example!r}"
                )
            for bound in _bounds(value):
                if fault := kind.fault(bound):
                    raise ParameterError(f"{type(self).__name__}.{name}: {fault}")
        cls: type = type(self)
        for check in _checks(cls):
            check(self)

    def check(self) -> None:
        """Refuse values that contradict each other; those of the classes that a class builds on are refused before."""


@cache
def _checks(cls: type) -> tuple[Callable[[Params], None], ...]:
    """The `check` of each class that a class builds on, each once, then its own."""
    bases: list[type] = [base for base in cls.__bases__ if issubclass(base, Params)]
    own = [vars(cls)["check"]] if "check" in vars(cls) else []
    return tuple(dict.fromkeys([*(each for base in bases for each in _checks(base)), *own]))


def _bounds(value: Any) -> tuple[float, ...]:
    """The numbers of a value that have to lie within its kind."""
    if isinstance(value, Signal):
        return value.extremes
    return tuple(map(float, value)) if isinstance(value, tuple) else (float(value),)
