"""Rules that values keep, and the words in which one that does not is refused: one rule, one wording.

A message names the key, the value in the unit in which people write it, and the rule: "rated_flow: 0 lpm must be
greater than 0". It begins with the class of the values, for scripts; what is stated of a file leaves the class out.
"""

import math
import re
from typing import Any, NoReturn

from vvdp.base.display import NOTHING, value_text
from vvdp.base.errors import ParameterError
from vvdp.base.kinds import PRESSURE_LEVEL, Kind
from vvdp.base.params import field_kinds
from vvdp.base.signal import Signal

POSITIVE = "must be greater than 0"


def shown_value(value: Any, kind: Kind | None) -> str:
    """A value [SI], or the list of some, with its unit as people read it."""
    if isinstance(value, tuple):
        return ", ".join(shown_value(each, kind) for each in value) or NOTHING
    if isinstance(value, Signal):
        return f"{shown_value(value.extremes[0], kind)} to {shown_value(value.extremes[1], kind)}"
    return f"{value:g}" if kind is None else value_text(float(value), kind)


def field_text(values: object, key: str) -> str:
    """A value of a parameter class with its unit, as people read it."""
    return shown_value(getattr(values, key), field_kinds(type(values))[key])


def refuse(values: object, key: str, rule: str) -> NoReturn:
    """Raise ParameterError: the value under a key, and the `rule` that it does not keep, "must be less than 6 mm"."""
    raise ParameterError(f"{type(values).__name__}.{key}: {field_text(values, key)} {rule}")


def refuse_together(values: object, rule: str) -> NoReturn:
    """Raise ParameterError: a `rule` that several values do not keep together; it names their keys."""
    raise ParameterError(f"{type(values).__name__}: {rule}")


def refuse_rows(values: object, key: str, fault: str) -> NoReturn:
    """Raise ParameterError: what is wrong with the rows of a list under a key, "row 3 has ..."."""
    raise ParameterError(f"{type(values).__name__}.{key}: {fault}")


def require_positive(values: object, *keys: str, why: str = "") -> None:
    """Raise ParameterError if one of the values, or one of a list, is not greater than 0; `why` follows the rule."""
    for key in keys:
        value = getattr(values, key)
        if not all(each > 0.0 for each in (value if isinstance(value, tuple) else (value,))):
            kind = field_kinds(type(values))[key]
            rule = f"{POSITIVE} bara" if kind and kind.name == PRESSURE_LEVEL.name else POSITIVE
            refuse(values, key, f"{rule}: {why}" if why else rule)


def require_positive_value(name: str, value: float, kind: Kind) -> None:
    """Raise ParameterError if a value [SI] that belongs to no parameter class is not a finite number greater than 0."""
    if not 0.0 < value < math.inf:
        rule = POSITIVE if math.isfinite(value) else "must be a finite number"
        raise ParameterError(f"{name}: {value_text(value, kind)} {rule}")


def require_less(values: object, key: str, limit: str) -> None:
    """Raise ParameterError if the value under a key is not less than that under another one, the limit."""
    if not getattr(values, key) < getattr(values, limit):
        refuse(values, key, f"must be less than {limit}, {field_text(values, limit)}")


def require_rising(values: object, key: str, *, strictly: bool = True, rows: slice = slice(None)) -> None:
    """Raise ParameterError, with the row, if a list under a key, or its `rows`, does not rise from row to row."""
    column, kind = getattr(values, key)[rows], field_kinds(type(values))[key]
    for row in range(1, len(column)):
        before, after = column[row - 1], column[row]
        if after < before or (strictly and after == before):
            rule = "must be greater than" if strictly else "must be at least"
            fault = f"row {row + 1}, {shown_value(after, kind)}, {rule} row {row}, {shown_value(before, kind)}"
            refuse_rows(values, key, fault)


def refused_field(problem: ParameterError, cls: type) -> tuple[str, str]:
    """The field of `cls` that a refusal of its values names, empty without one, and what is wrong, without the class.

    Classes write `Class.field: what` or `Class: what`, with the name of the class or of one that it is derived from.
    """
    words = "|".join(each.__name__ for each in cls.__mro__)
    match = re.fullmatch(rf"(?:{words})(?:\.(\w+))?: (.*)", str(problem), re.DOTALL)
    if match is None or (match[1] and match[1] not in field_kinds(cls)):
        return "", without_class(str(problem))
    return match[1] or "", match[2]


def without_class(message: str) -> str:
    """A refusal of values of any parameter class, for a user who knows the key and not the class."""
    return re.sub(r"\A[A-Z]\w*(?:\.(?=\w+: )|: )", "", message)
