"""Quantities of programs that work for any of them: the quantity of the input decides the units of the program's
values.

A program for any quantity is written with the kinds of this module; `with_kinds` puts those of one circuit there.
"""

import re
from collections import namedtuple
from collections.abc import Hashable, Mapping, Sequence
from dataclasses import replace
from functools import lru_cache
from itertools import zip_longest
from typing import Annotated, Any, NamedTuple, cast

from vvdp.base.errors import ParameterError
from vvdp.base.kinds import (
    ANGLE,
    AREA,
    DURATION,
    EXCHANGED_POWER,
    FLOW,
    FORCE,
    FREQUENCY,
    POSITION,
    PRESSURE_LEVEL,
    SIGNED_PRESSURE,
    SPEED,
    TEMPERATURE,
    TEMPERATURE_DIFFERENCE,
    TORQUE,
    VELOCITY,
    VOLUME,
    Kind,
)
from vvdp.base.known_units import KNOWN, known_unit
from vvdp.base.params import Params, default_values, field_kinds, field_types
from vvdp.base.units import number_and_unit

LARGEST = 1e300
PLAIN = Kind("plain number", "1", -LARGEST, LARGEST, "0.5")
QUANTITIES = (
    *(PLAIN, PRESSURE_LEVEL, FLOW, POSITION, VELOCITY, FORCE, TORQUE, ANGLE, SPEED, FREQUENCY),
    *(DURATION, TEMPERATURE, replace(EXCHANGED_POWER, name="power in either direction"), AREA, VOLUME),
)
"""Quantities that a command can have, by unit; another unit is a quantity without a name."""
DIFFERENCES = {PRESSURE_LEVEL: SIGNED_PRESSURE, TEMPERATURE: TEMPERATURE_DIFFERENCE}
"""Kinds of the difference of two levels."""

INPUT = Kind("value of what is read", "Pa", -LARGEST, LARGEST, "100 bar")
SECOND = Kind("value of what is read second", "K", -LARGEST, LARGEST, "5 K")
THIRD = Kind("value of what is read third", "m", -LARGEST, LARGEST, "20 mm")
FOURTH = Kind("value of what is read fourth", "N", -LARGEST, LARGEST, "2 kN")
OUTPUT = Kind("value of the command", "1", -LARGEST, LARGEST, "0.8")
OUTPUT_CHANGE = Kind("change of the command", "1", -LARGEST, LARGEST, "0.8")
GAIN = Kind("gain", "1/Pa", -LARGEST, LARGEST, "0.02 1/bar")
OUTPUT_RATE = Kind("rate of the command", "1/s", -LARGEST, LARGEST, "0.5 1/s")
SECOND_RATE = Kind("second derivative of the command", "1/s^2", -LARGEST, LARGEST, "0.5 1/s^2")
THIRD_RATE = Kind("third derivative of the command", "1/s^3", -LARGEST, LARGEST, "0.5 1/s^3")
"""Kinds that stand for those of a circuit; their units are those of a fraction that follows a pressure."""
INPUTS = (INPUT, SECOND, THIRD, FOURTH)
"""Kinds of the inputs; a program that reads several quantities gives each input its own."""
OF_ANY_QUANTITY = frozenset({*INPUTS, OUTPUT, OUTPUT_CHANGE, GAIN, OUTPUT_RATE, SECOND_RATE, THIRD_RATE})
"""All that stand for others."""

Plain = Annotated[float, PLAIN]
Input = Annotated[float, INPUT]
Second = Annotated[float, SECOND]
Third = Annotated[float, THIRD]
Fourth = Annotated[float, FOURTH]
Output = Annotated[float, OUTPUT]
OutputChange = Annotated[float, OUTPUT_CHANGE]
Gain = Annotated[float, GAIN]
OutputRate = Annotated[float, OUTPUT_RATE]
SecondRate = Annotated[float, SECOND_RATE]
ThirdRate = Annotated[float, THIRD_RATE]


class Dimension(NamedTuple):
    """Powers of kg, m, s and K, and of the angle, which has no dimension in SI."""

    powers: tuple[Any, ...]
    angle: int

    def times(self, other: "Dimension") -> "Dimension":
        """The dimension of a product."""
        powers = tuple(a + b for a, b in zip(self.powers, other.powers, strict=True))
        return Dimension(powers, self.angle + other.angle)


def dimension(unit: str) -> Dimension:
    """The dimension of a unit. Raises ParameterError where it is not known."""
    found = known_unit(unit) if unit not in ("", "1") else KNOWN["%"]
    if found is None:
        found = KNOWN["K"] if unit in ("degC", "degF") else None
    if found is None:
        raise ParameterError(f"unknown unit {unit!r}")
    above, _, below = unit.partition("/")
    return Dimension(found.powers, _angles(above) - _angles(below))


def _angles(text: str) -> int:
    return len(re.findall(r"\b(?:rad|deg|rev|rpm)\b", text))


def quantity(of: Dimension) -> Kind:
    """The quantity of a dimension; that of the same powers where angles differ, as in a torque times a speed."""
    known = [(kind, dimension(kind.unit)) for kind in QUANTITIES]
    same = [kind for kind, each in known if each == of] or [kind for kind, each in known if each.powers == of.powers]
    if same:
        return same[0]
    unit = "*".join(f"{name}^{power}" for name, power in zip(("kg", "m", "s", "K"), of.powers, strict=True) if power)
    return Kind(f"quantity in {unit}", unit, -LARGEST, LARGEST, f"1 {unit}")


def written_dimension(entry: Any) -> Dimension | None:
    """The dimension of the first value in a file's entry for a key; None if there is none."""
    match entry:
        case str():
            try:
                return dimension(number_and_unit(entry)[1])
            except ParameterError:
                return None
        case int() | float():
            return dimension("")
        case list() if entry:
            return written_dimension(entry[-1])
        case Mapping() if entry:
            return written_dimension(entry.get("value", next(iter(entry.values()))))
    return None


def written_quantity(entry: Any) -> Kind:
    """The quantity of the first value in a file's entry for a key; a plain number if there is none."""
    found = written_dimension(entry)
    return PLAIN if found is None else quantity(found)


def written_number(entry: Any) -> float:
    """The number that a file gives for a key; nan where it is none."""
    try:
        return float(entry["value"] if isinstance(entry, Mapping) else entry)
    except (KeyError, TypeError, ValueError):
        return float("nan")


def product(one: Kind, other: Kind) -> Kind:
    """The quantity of a product."""
    return quantity(dimension(one.unit).times(dimension(other.unit)))


def of_gain(entry: Any, read: Kind) -> Kind:
    """The quantity of a gain, as a file gives it, times the input; with a plain number that of the input."""
    gain = written_dimension(entry)
    if gain is None:
        return PLAIN
    return read if gain == dimension("") else quantity(gain.times(dimension(read.unit)))


def _per(unit: str, other: str) -> str:
    if unit == other:
        return "1"
    return unit if other == "1" else f"{unit}/({other})" if re.search(r"[*/]", other) else f"{unit}/{other}"


def ratio(name: str, above: Kind, below: str, shown: str) -> Kind:
    """The quantity of `above` per unit: `below` in SI, `shown` for display."""
    unit, example = _per(above.unit, below), _per(above.display_unit or "1", shown)
    return Kind(name, unit, -LARGEST, LARGEST, f"1 {example}" if unit != "1" else "1")


def replacements(read: Sequence[Kind], command: Kind) -> dict[Kind, Kind]:
    """Replacements for the kinds of this module, given those of the inputs and of the command; the rest is plain."""
    reads = dict(zip_longest(INPUTS, read[: len(INPUTS)], fillvalue=PLAIN))
    first = reads[INPUT]
    return {
        **reads,
        OUTPUT: command,
        OUTPUT_CHANGE: DIFFERENCES.get(command, command),
        GAIN: ratio("gain", command, first.unit, first.display_unit or "1"),
        OUTPUT_RATE: ratio("rate", command, "s", "s"),
        SECOND_RATE: ratio("second derivative", command, "s^2", "s^2"),
        THIRD_RATE: ratio("third derivative", command, "s^3", "s^3"),
    }


def with_kinds(cls: type[Any], kinds: Mapping[Kind, Kind]) -> type[Any]:
    """The class with other kinds of its fields; a NamedTuple or a parameter class, the same one for the same kinds."""
    return _class_with(cast("Hashable", cls), tuple(kinds.items()))


@lru_cache(maxsize=1000)
def _class_with(cls: Any, kinds: tuple[tuple[Kind, Kind], ...]) -> type[Any]:
    known, own = dict(kinds), field_kinds(cls)
    found = {name: known[kind] for name, kind in own.items() if kind in known}
    if not found:
        return cast("type[object]", cls)
    if issubclass(cls, Params):
        return _other_params(cls, found)
    made: Any = namedtuple(cls.__name__, own, defaults=cls.__new__.__defaults__)  # type: ignore[misc]
    made.__annotations__ = {name: Annotated[float, found.get(name, kind)] for name, kind in own.items()}
    return cast("type[object]", made)


def _other_params(cls: type[Params], found: Mapping[str, Kind]) -> type[Params]:
    """The class with other kinds; a value that need not be given is led into the range of its kind."""
    types = field_types(cls)
    hints = {name: Annotated[types[name], kind] for name, kind in found.items()}
    usual = {name: value for name, value in default_values(cls).items() if name in found and types[name] is float}
    within = {name: min(max(value, found[name].low), found[name].high) for name, value in usual.items()}
    return type(cls.__name__, (cls,), {"__annotations__": hints, "__doc__": cls.__doc__, **within})
