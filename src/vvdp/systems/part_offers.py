"""Interface of a part for the file that uses it: the medium of each port, and quantity and default of each value."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from vvdp.base.display import value_text
from vvdp.base.kinds import Kind
from vvdp.base.params import Params, default_values, field_kinds
from vvdp.base.slots import inner_slots
from vvdp.components.library import COMPONENTS
from vvdp.network.assembly import Assembly
from vvdp.network.component import Component
from vvdp.network.program import ProgramType
from vvdp.programs.generic import GenericProgram
from vvdp.programs.library import PROGRAMS
from vvdp.programs.quantities import PLAIN, replacements, written_quantity
from vvdp.systems.drawing import NODES
from vvdp.systems.part_files import PARTS, VALUES, PartFile, find_part
from vvdp.systems.part_scopes import as_table
from vvdp.systems.part_uses import joined_ports

GENERIC = frozenset(replacements((), PLAIN))
"""Kinds that stand for those of a circuit: what a file gives shows the quantity."""


@dataclass(frozen=True)
class OfferedValue:
    """A value that a part offers: its physical quantity, and its default, or the value that it stands in place of, as
    text; empty where it has to be given."""

    kind: Kind | None
    default: str


def part_ports(file: PartFile) -> dict[str, str]:
    """The ports of a part, and what each carries; empty where no component ends there."""
    found = dict.fromkeys(file.ports, "")
    for entry in as_table(file.table.content.get("components")).values():
        found |= {entry[port]: what for port, what in joined_ports(entry).items() if entry.get(port) in found}
    for entry in as_table(file.table.content.get(PARTS)).values():
        inner = part_ports(find_part(entry, file.folder))
        found |= {entry[port]: what for port, what in inner.items() if entry.get(port) in found}
    return found


def part_values(file: PartFile) -> dict[str, OfferedValue]:
    """The values that a part offers. Raises ParameterError, ConfigError where a part in it is not there."""
    given = as_table(file.table.content.get(VALUES))
    found = {}
    for name, targets in file.values.items():
        offered = _value_at(file, targets[0]) if targets else OfferedValue(None, "")
        own = _text(given[name], None) if isinstance(given[name], Mapping) else ""
        found[name] = OfferedValue(offered.kind, own or offered.default)
    return found


def _value_at(file: PartFile, path: str) -> OfferedValue:
    """The value at a path of a file, in a part of it where the path leads there."""
    group, name, *keys = path.split(".")
    parts = as_table(file.table.content.get(PARTS))
    if name in parts and keys:
        inner = find_part(parts[name], file.folder)
        entry = as_table(parts[name]).get(keys[0]) if group == PARTS else None
        found = part_values(inner)[keys[0]] if group == PARTS and len(keys) == 1 else None
        if found is None:
            return _value_at(inner, ".".join((group, *keys)))
        return OfferedValue(found.kind, _text(entry, found.kind) or found.default)
    entry = as_table(as_table(file.table.content.get(group)).get(name))
    if group == "components" and keys[0] == "start" and len(keys) == 2:
        start = _state_kinds(str(entry.get("type"))).get(keys[1])
        return OfferedValue(start, _text(as_table(entry.get("start")).get(keys[1]), start))
    if other := _alternative(entry, keys[-1]):
        return other
    kind, usual = _kind(group, str(entry.get("type")), keys)
    for key in keys[:-1]:
        entry = as_table(entry.get(key))
    given = entry.get(keys[-1])
    if group == "programs" and kind in GENERIC:
        kind = written_quantity(given)
    text = _text(given, kind)
    return OfferedValue(kind, text or (value_text(usual, kind) if kind and isinstance(usual, float) else ""))


def _alternative(entry: Mapping[str, Any], key: str) -> OfferedValue | None:
    """The quantity that a component takes in place of one of its inputs; None of a key that is no alternative."""
    component = COMPONENTS.get(str(entry.get("type")))
    others = component.alternatives if isinstance(component, Component) and key not in entry else {}
    found = ((name, other) for name, other in others.items() if other.name == key)
    return next((OfferedValue(other.kind, f"in place of {name}") for name, other in found), None)


def _state_kinds(word: str) -> Mapping[str, Kind | None]:
    """The quantities of the state from which a component of a type starts."""
    component = COMPONENTS.get(word)
    return field_kinds(component.state) if isinstance(component, Component) and component.state else {}


def _kind(group: str, word: str, keys: Sequence[str]) -> tuple[Kind | None, Any]:
    """Quantity and default of a value of a node, component or program of a type; of a program, also in its tables."""
    classes: tuple[Any, ...] = ()
    key = keys[-1]
    if group == "programs" and (found := PROGRAMS.get(word)):
        own = found.type if isinstance(found, GenericProgram) else found
        if len(keys) == 1 and key in (kinds := field_kinds(own.reading)):
            return kinds[key], own.defaults.get(key)
        classes = _table_classes(own, keys[:-1])
    if group == "nodes" and word in NODES:
        classes = (NODES[word].table,)
    elif group == "components" and (component := COMPONENTS.get(word)):
        if isinstance(component, Assembly):
            classes = (component.params,)
        else:
            classes = tuple(component.params)
            for argument in component.inputs:
                if argument.name == key:
                    return argument.kind, argument.default
    for cls in classes:
        if key in (kinds := field_kinds(cls)):
            return kinds[key], default_values(cls).get(key)
    return None, None


def _table_classes(program: ProgramType, names: Sequence[str]) -> tuple[type[Params], ...]:
    """The classes that the table of these names, each inside the one before, may have in the values of a program."""
    classes: tuple[type[Params], ...] = (program.settings,) if program.settings else ()
    for name in names:
        slots = [slot for cls in classes if (slot := inner_slots(cls).get(name))]
        classes = tuple(each for slot in slots for each in slot.classes)
    return classes


def _text(entry: Any, kind: Kind | None) -> str:
    """An entry as a user wrote it."""
    value = entry.get("value", "changes" if kind else "") if isinstance(entry, Mapping) else entry
    return "" if value is None else str(value)
