"""The table of a program with a foreign FMU: its variables under their names in the file, and units on both sides."""

import keyword
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from vvdp.base.errors import ParameterError
from vvdp.base.kinds import Kind
from vvdp.base.known_units import known_unit
from vvdp.base.tables import nearest
from vvdp.base.units import number_and_unit
from vvdp.programs.foreign.archive import Archive
from vvdp.programs.foreign.description import OUTPUT, PARAMETER, REAL, FmuUnit, Variable
from vvdp.programs.quantities import PLAIN, Dimension, dimension, product, quantity

KEYS = ("fmu", "inputs", "outputs", "values", "power", "extrapolate")
"""The keys of a program with an FMU, beside those of every program."""
TIME, MADE, THROUGHPUT = "time", "exchange", "exchanged"
OWN_FIELDS = (TIME, MADE, THROUGHPUT)
"""Names of the command that are no outputs of the FMU."""


class FieldError(ParameterError):
    """The fault of a key of the table of a program."""

    def __init__(self, key: str, message: str) -> None:
        super().__init__(message)
        self.key = key


class Joint(NamedTuple):
    """A variable of an FMU under its name in the file; SI value = factor * value + offset."""

    name: str
    variable: Variable
    kind: Kind
    factor: float
    offset: float

    @property
    def first(self) -> float:
        """The start value [SI]; 0 if the FMU gives none."""
        return self.factor * (self.variable.start or 0.0) + self.offset

    def to_si(self, value: str) -> str:
        """The text of the SI value."""
        scaled = value if self.factor == 1.0 else f"{self.factor!r} * {value}"
        return f"{scaled} + {self.offset!r}" if self.offset else scaled

    def from_si(self, value: str) -> str:
        """The text of the value that the FMU counts with."""
        shifted = f"({value} - {self.offset!r})" if self.offset else value
        return shifted if self.factor == 1.0 else f"{shifted} / {self.factor!r}"


def named_entries(table: Mapping[str, object], key: str) -> Mapping[str, object]:
    """A table of the program; a list of names stands for variables of the same names."""
    entry = table.get(key, {})
    if isinstance(entry, list) and all(isinstance(each, str) for each in entry):
        return {each: each for each in entry}
    if not isinstance(entry, Mapping):
        raise FieldError(key, f"{entry!r}; expected a table of names, or a list of variables")
    return entry


def switch(table: Mapping[str, object], key: str) -> bool:
    """Whether a key of the program is set; without it, it is not. Raises FieldError."""
    entry = table.get(key, False)
    if not isinstance(entry, bool):
        raise FieldError(key, f"{entry!r}; expected true or false")
    return entry


def joints(archive: Archive, table: Mapping[str, object], key: str, causality: str) -> tuple[Joint, ...]:
    """The inputs or outputs that the table names. Raises FieldError."""
    found = []
    for name, entry in named_entries(table, key).items():
        given = entry if isinstance(entry, Mapping) else {"variable": entry}
        variable, unit = given.get("variable", name), given.get("unit", "")
        if not isinstance(variable, str) or not isinstance(unit, str) or not given.keys() <= {"variable", "unit"}:
            raise FieldError(f"{key}.{name}", f'{entry!r}; expected "VARIABLE" or {{ variable = "...", unit = "..." }}')
        if not name.isidentifier() or keyword.iskeyword(name) or name.startswith("_"):
            raise FieldError(f"{key}.{name}", f'{name!r} is no plain name; write NAME = "{variable}"')
        if name in OWN_FIELDS:
            raise FieldError(f"{key}.{name}", f"the name {name!r} is that of a value of every FMU; choose another")
        path = f"{key}.{name}"
        found.append(_joint(archive, path, name, _variable(archive, path, variable, causality), unit))
    if not found and causality == OUTPUT:
        raise FieldError(key, f"missing{nearest('', _names(archive, OUTPUT))}")
    return tuple(found)


def _names(archive: Archive, causality: str) -> list[str]:
    variables = archive.description.variables.values()
    return [each.name for each in variables if each.causality == causality and each.type in REAL.values()]


def _variable(archive: Archive, key: str, name: str, causality: str) -> Variable:
    known, kind = archive.description.variables, REAL[archive.description.fmi]
    if name not in known:
        raise FieldError(key, f"the FMU has no variable {name!r}{nearest(name, _names(archive, causality))}")
    found = known[name]
    if found.causality != causality:
        raise FieldError(key, f"{name!r} is of the causality {found.causality}; expected {causality}")
    if found.type != kind or found.is_array:
        kind_words = f"an array of {found.type}" if found.is_array else f"of the type {found.type}"
        raise FieldError(key, f"{name!r} is {kind_words}; expected a single {kind}")
    return found


def _joint(archive: Archive, key: str, name: str, variable: Variable, told: str) -> Joint:
    """A variable with its unit: that of the FMU, or the one that the table gives. Raises FieldError."""
    own = _unit(archive, variable.unit)
    try:
        of = dimension(told) if told else None
    except ParameterError as problem:
        raise FieldError(f"{key}.unit", str(problem)) from None
    if own is not None and of is not None and own.powers != of.powers:
        raise FieldError(key, f"the FMU has {variable.name!r} in {variable.unit}, the table in {told}; they contradict")
    if own is None and variable.unit and of is None:
        raise FieldError(key, f'the unit {variable.unit!r} of {variable.name!r} is not known; give one, unit = "..."')
    if own is None:
        own = _named_unit(told)
    kind = PLAIN if own is None else quantity(of or Dimension(own.powers, own.angle))
    return Joint(name, variable, kind, *((1.0, 0.0) if own is None else own[:2]))


def _unit(archive: Archive, name: str) -> FmuUnit | None:
    """A unit of an FMU, by its description or by its name; None if neither is known."""
    return archive.description.units.get(name) or _named_unit(name)


def _named_unit(name: str) -> FmuUnit | None:
    found = known_unit(name) if name not in ("", "1") else None
    return None if found is None else FmuUnit(found.size, found.zero, found.powers, dimension(name).angle)


def parameter(archive: Archive, name: str, entry: Any) -> tuple[int, float]:
    """The reference of a parameter and its value in the unit of the FMU, for a number or a text with a unit."""
    key = f"values.{name}"
    variable = _variable(archive, key, name, PARAMETER)
    if isinstance(entry, int | float) and not isinstance(entry, bool) and np.isfinite(entry):
        return variable.reference, float(entry)
    try:
        number, unit = number_and_unit(entry)
    except ParameterError as problem:
        raise FieldError(key, str(problem)) from None
    own, given = _unit(archive, variable.unit), _named_unit(unit)
    if own is None or given is None or own.powers != given.powers:
        raise FieldError(key, f"{entry!r}; the FMU has it in {variable.unit or 'no unit'}")
    return variable.reference, (number * given.factor + given.offset - own.offset) / own.factor


def power_pairs(
    table: Mapping[str, object], inputs: Sequence[Joint], outputs: Sequence[Joint]
) -> tuple[tuple[Joint, Joint], ...]:
    """The pairs of an output and an input whose product is a power."""
    found = []
    for name, other in named_entries(table, "power").items():
        given = next((joint for joint in outputs if joint.name == name), None)
        read = next((joint for joint in inputs if joint.name == other), None)
        if given is None or read is None:
            raise FieldError("power", f"{name} = {other!r}; expected the name of an output, and of the input beside it")
        if product(given.kind, read.kind).unit != "W":
            units = f"{given.name} [{given.kind.unit}] times {read.name} [{read.kind.unit}]"
            raise FieldError("power", f"{units} is no power; a flow belongs to a pressure, a force to a velocity")
        found.append((given, read))
    return tuple(found)
