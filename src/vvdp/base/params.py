"""Parameter classes: frozen, keyword-only, every field of a kind, every value checked when it is made."""

import dataclasses
import re
from functools import cache
from typing import Any, NoReturn, Union, dataclass_transform, get_args, get_origin, get_type_hints

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


def field_types(cls: type) -> dict[str, Any]:
    """The plain type of every annotated field of a class."""
    return _field_types(cls)


@cache
def _field_types(cls: type) -> dict[str, Any]:
    return get_type_hints(cls)


def field_names(cls: type) -> list[str]:
    """The fields of a parameter class, in their order."""
    return [each.name for each in dataclasses.fields(cls)]


def default_values(cls: type) -> dict[str, Any]:
    """The fields of a parameter class that need not be given, with their values."""
    return {f.name: f.default for f in dataclasses.fields(cls) if f.default is not dataclasses.MISSING}


def field_text(values: "Params", key: str) -> str:
    """A value of a parameter class with its unit, as a person reads it."""
    from vvdp.base.display import value_text

    kind, value = field_kinds(type(values))[key], getattr(values, key)
    return f"{value:g}" if kind is None else value_text(float(value), kind)


def refuse(values: "Params", key: str, rule: str) -> NoReturn:
    """Raise ParameterError: the value under a key, and the `rule` that it does not keep, "must be less than 6 mm"."""
    raise ParameterError(f"{type(values).__name__}.{key}: {field_text(values, key)} {rule}")


def require_positive(values: "Params", *keys: str) -> None:
    """Raise ParameterError if one of the values is not greater than 0."""
    for key in keys:
        if not getattr(values, key) > 0.0:
            refuse(values, key, "must be greater than 0")


def require_less(values: "Params", key: str, limit: str) -> None:
    """Raise ParameterError if the value under a key is not less than that under another one, the limit."""
    if not getattr(values, key) < getattr(values, limit):
        refuse(values, key, f"must be less than {limit}, {field_text(values, limit)}")


def refused_field(problem: ParameterError, cls: type) -> tuple[str, str]:
    """The field of `cls` that a refusal of its values names, empty without one, and what is wrong, without the class.

    Classes write `Class.field: what`, `Class.field = value: what` or `Class.field what`, with the name of the class or
    of one that it is derived from.
    """
    words = "|".join(each.__name__ for each in cls.__mro__)
    match = re.fullmatch(rf"(?:{words})(?:\.(\w+))?(?:: | = | )(.*)", str(problem), re.DOTALL)
    if match is None or (match[1] and match[1] not in field_kinds(cls)):
        return "", str(problem)
    return match[1] or "", match[2]


def without_class(message: str) -> str:
    """A refusal of values of any parameter class, for a person who knows the key and not the class."""
    return re.sub(r"\A[A-Z]\w*(?:\.(?=\w+(?::| =| ))|: )", "", message)


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
        self.check()

    def check(self) -> None:
        """Refuse values that contradict each other; a subclass overrides this where it has something to say."""


def _bounds(value: Any) -> tuple[float, ...]:
    """The numbers of a value that have to lie within its kind."""
    if isinstance(value, Signal):
        return value.extremes
    return tuple(map(float, value)) if isinstance(value, tuple) else (float(value),)
