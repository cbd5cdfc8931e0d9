"""A circuit while its parts are drawn out: entries by name, the parts, and where each entry stands in a file."""

from collections.abc import Collection, Iterable, Iterator, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any, TypeAlias

from vvdp.base.errors import Fault, ParameterError
from vvdp.base.tables import nearest
from vvdp.components.library import COMPONENTS as COMPONENT_TYPES
from vvdp.programs.library import PROGRAMS as PROGRAM_TYPES
from vvdp.systems.own_programs import own_program
from vvdp.systems.part_files import COMPONENTS, DRAWN, GROUPS, NODES, PARTS, PROGRAMS
from vvdp.systems.part_keys import PartType, part_keys
from vvdp.systems.part_scopes import Entries, Place, Scope, as_table, inner_name

FAULTS = "faults"
TYPES: Mapping[str, Mapping[str, PartType]] = {COMPONENTS: COMPONENT_TYPES, PROGRAMS: PROGRAM_TYPES}
Keys: TypeAlias = tuple[str, ...]
SIGNAL_WORDS = frozenset(("value", "step", "ramp", "sine", "table", "from"))
"""Words of which an entry with a value has one."""


class DrawnCircuit:
    """Nodes, components and programs by their names in the network, and the parts that they belong to."""

    def __init__(self, faults: list[Fault], folder: Path) -> None:
        self.faults, self.folder = faults, folder
        self.tables: dict[str, dict[str, Any]] = {group: {} for group in GROUPS}
        self.parts: dict[str, dict[str, Any]] = {}
        self.places: dict[str, Place] = {}
        self.taken: dict[str, str] = {}

    def tell(self, place: Place, message: str) -> None:
        """Append a fault."""
        self.faults.append(place.fault(message))

    def take(self, place: Place, name: str) -> bool:
        """Whether a name was free; it is taken from now on."""
        if name in self.taken:
            self.tell(place, f"the name {name!r} is taken by {self.taken[name]}; choose another")
            return False
        self.taken[name] = place.path + (f" of {place.table.place}" if place.use else "")
        return True

    def rename(self, scope: Scope, joined: Mapping[str, Collection[str]]) -> None:
        """Give the entries of a file, `joined` by their paths, the names that they have in the circuit."""
        for path, ports in joined.items():
            group, _, name = path.partition(".")
            self.tables[group][name] = scope.rename(self.tables[group][name], self.parts, ports)

    def set(self, path: str, entry: Any, place: Place) -> None:
        """Put an entry at a path TABLE.NAME.KEY."""
        *above, key = path.split(".")
        inner: Any = self.tables
        for word in above:
            inner = inner.setdefault(word, {})
            if not isinstance(inner, dict):
                self.tell(place, f"{path} leads through {word}, which is not a table")
                return
        inner[key] = entry
        self.places[path] = place

    def change(self, place: Place, group: str, name: str, entry: Any) -> None:
        """Change entries inside of a part, `[nodes.supply.inlet]`: what is given, and nothing else."""
        table = self.tables[group]
        if not isinstance(entry, Mapping):
            self.tell(place, f"{entry!r} is not a table")
        elif name in self.parts:
            for key, inner in entry.items():
                self.change(place.below(key), group, f"{name}_{key}", inner)
        elif name not in table:
            self.tell(place, f"no such name among the {group}{nearest(name, table) if table else ''}")
        else:
            for key in other_keys(group, table[name], entry, self.folder):
                del table[name][key]
            drop_alternatives(self.tables, [f"{group}.{name}.{key}" for key in entry])
            for keys, value in _leaves(entry, table[name]):
                below = ".".join(keys)
                self.set(f"{group}.{name}.{below}", value, place.below(below))

    def has(self, path: str) -> bool:
        """Whether an entry stands at a path."""
        inner: Any = self.tables
        for word in path.split("."):
            inner = as_table(inner).get(word)
        return inner is not None

    def paths(self, scope: Scope, target: str) -> tuple[str, ...]:
        """The paths that a path of a file leads to. Raises ParameterError if there are none."""
        group, _, rest = target.partition(".")
        if group not in (*GROUPS, PARTS) or "." not in rest:
            groups = ", ".join((*GROUPS, PARTS))
            raise ParameterError(f"{target!r} is no path of an entry; expected TABLE.NAME.KEY with a table of {groups}")
        if group == PARTS:
            return self._value_paths(scope, rest)
        name, _, key = inner_name(scope.prefix + rest, self.parts).partition(".")
        if name not in self.tables[group] or not key:
            own = [each.removeprefix(scope.prefix) for each in self.tables[group] if each.startswith(scope.prefix)]
            raise ParameterError(f"{target!r} leads to none of the {group}{nearest(name, own) if own else ''}")
        return (f"{group}.{name}.{key}",)

    def _value_paths(self, scope: Scope, path: str) -> tuple[str, ...]:
        part, _, value = path.rpartition(".")
        name = inner_name(scope.prefix + part, self.parts)
        if name not in self.parts and part.partition(".")[0] in scope.parts:
            return ()  # why it is not drawn is reported
        if name not in self.parts:
            own = [each.removeprefix(scope.prefix) for each in self.parts if each.startswith(scope.prefix)]
            raise ParameterError(f"{part!r} is no part{nearest(part, own) if own else ''}")
        values: Mapping[str, list[str]] = self.parts[name]["values"]
        if value not in values:
            raise ParameterError(f"{part} has no value {value!r}{nearest(value, list(values)) if values else ''}")
        return tuple(values[value])

    def content(self, given: Entries) -> dict[str, Any]:
        """The circuit instead of the `given` content of its file."""
        drawn = {group: table for group, table in self.tables.items() if table or group in given}
        found = dict(given) | drawn | {PARTS: {name: {DRAWN: part} for name, part in self.parts.items()}}
        if isinstance(given.get(FAULTS), Mapping):
            found[FAULTS] = {name: _named_fault(entry, self.parts) for name, entry in given[FAULTS].items()}
        return found


def is_record(drawn: Any, tables: Mapping[str, Mapping[str, object]]) -> bool:
    """Whether `drawn` is what a drawn circuit keeps of a part, and its nodes and entries are in `tables`."""
    match drawn:
        case {"source": str(), "ports": Mapping() as ports, "names": list(names), "values": Mapping() as values}:
            joined = all(isinstance(node, str) and node in tables[NODES] for node in ports.values())
            return joined and all(isinstance(each, str) for each in names) and _are_paths(values.values(), tables)
    return False


def _are_paths(values: Iterable[Any], tables: Mapping[str, Mapping[str, object]]) -> bool:
    """Whether each of the values is a list of paths TABLE.NAME.KEY of entries in `tables`."""
    paths = [path for value in values for path in (value if isinstance(value, list) else [None])]
    words = [path.split(".") if isinstance(path, str) else [] for path in paths]
    return all(len(each) > 2 and each[1] in tables.get(each[0], {}) for each in words)


def _leaves(entry: Mapping[str, object], before: Any, above: Keys = ()) -> Iterator[tuple[Keys, Any]]:
    """The values of a table and of those in it, by keys; `before` is what stands in its place now."""
    for key, value in entry.items():
        inner = as_table(before).get(key)
        if isinstance(value, Mapping) and isinstance(inner, Mapping) and SIGNAL_WORDS.isdisjoint(inner):
            yield from _leaves(value, inner, (*above, key))
        else:
            yield (*above, key), value


def _named_fault(entry: Any, parts: Mapping[str, Mapping[str, object]]) -> Any:
    """An entry of [faults] whose names are those of the drawn circuit."""
    found = dict(as_table(entry))
    for key in ("sensor", "actuator", "jams"):
        if isinstance(found.get(key), str):
            found[key] = inner_name(found[key], parts)
    if isinstance(found.get("value"), str):
        paths = _entry_paths(found["value"], parts)
        found["value"] = paths[0] if len(paths) == 1 else found["value"]
    return found if isinstance(entry, Mapping) else entry


def part_settings(content: Mapping[str, object]) -> dict[str, str]:
    """The values that the parts of a drawn circuit offer, as keys of `--set`, and the first entry that each sets."""
    return {
        f"{PARTS}.{name}.{value}": paths[0]
        for name, use in as_table(content.get(PARTS)).items()
        for value, paths in as_table(use)[DRAWN]["values"].items()
    }


def setting_path(content: Mapping[str, object], setting: str) -> str:
    """The entry of a drawn circuit that a key of `--set` reaches; the first one of a value that sets several."""
    return _entry_paths(setting, {name: as_table(use)[DRAWN] for name, use in as_table(content.get(PARTS)).items()})[0]


def _entry_paths(path: str, parts: Mapping[str, Mapping[str, object]]) -> tuple[str, ...]:
    """The entries that a path with the names of parts leads to."""
    group, dot, rest = path.partition(".")
    part, _, value = rest.rpartition(".")
    values = as_table(as_table(parts.get(inner_name(part, parts))).get("values")) if group == PARTS else {}
    return tuple(values.get(value, ())) or (group + dot + inner_name(rest, parts),)


def other_keys(group: str, part: Entries, entry: Entries, folder: Path = Path()) -> list[str]:
    """The keys of a component or program that the other type which `entry` gives it does not take: they go with it.

    folder  in which a user-defined program is looked for
    """
    word = str(entry.get("type"))
    found = TYPES.get(group, {}).get(word)
    if found is None and group == PROGRAMS and ":" in word:
        with suppress(ParameterError):  # reported where the program is drawn
            found = own_program(word, {group: {"own": entry}}, folder)
    return [] if found is None else [key for key in part if key not in part_keys(found).known]


def drop_alternatives(tables: Mapping[str, dict[str, Any]], given: Collection[str]) -> None:
    """Take out of `tables` what parts say of an input whose alternative is `given`: a duty ratio for a position.

    given  paths of entries, TABLE.NAME.KEY
    """
    for path in given:
        group, _, rest = path.partition(".")
        name, _, key = rest.partition(".")
        entry = tables[group].get(name, {})
        found = TYPES.get(group, {}).get(str(entry.get("type")))
        for word, other in getattr(found, "alternatives", {}).items():
            left = {word: other.name, other.name: word}.get(key)
            if left is not None and f"{group}.{name}.{left}" not in given:
                entry.pop(left, None)
