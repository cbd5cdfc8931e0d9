"""A circuit while its parts are drawn out: entries by name, the parts, and where each entry stands in a file."""

from collections.abc import Collection, Mapping
from typing import Any

from vvdp.base.errors import Fault, ParameterError
from vvdp.base.tables import nearest
from vvdp.systems.part_files import DRAWN, GROUPS, PARTS
from vvdp.systems.part_scopes import Place, Scope, as_table, inner_name

FAULTS = "faults"


class DrawnCircuit:
    """Nodes, components and programs by their names in the network, and the parts that they belong to."""

    def __init__(self, faults: list[Fault]) -> None:
        self.faults = faults
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
            self.tables[group][name] = scope.renamed(self.tables[group][name], self.parts, ports)

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
            return self._offered(scope, rest)
        name, _, key = inner_name(scope.prefix + rest, self.parts).partition(".")
        if name not in self.tables[group] or not key:
            own = [each.removeprefix(scope.prefix) for each in self.tables[group] if each.startswith(scope.prefix)]
            raise ParameterError(f"{target!r} leads to none of the {group}{nearest(name, own) if own else ''}")
        return (f"{group}.{name}.{key}",)

    def _offered(self, scope: Scope, path: str) -> tuple[str, ...]:
        part, _, value = path.rpartition(".")
        name = inner_name(scope.prefix + part, self.parts)
        if name not in self.parts and part.partition(".")[0] in scope.parts:
            return ()  # why it is not drawn is told
        if name not in self.parts:
            own = [each.removeprefix(scope.prefix) for each in self.parts if each.startswith(scope.prefix)]
            raise ParameterError(f"{part!r} is no part{nearest(part, own) if own else ''}")
        values: Mapping[str, list[str]] = self.parts[name]["values"]
        if value not in values:
            raise ParameterError(f"{part} has no value {value!r}{nearest(value, list(values)) if values else ''}")
        return tuple(values[value])

    def content(self, given: Mapping[str, Any]) -> dict[str, Any]:
        """The circuit in the place of the `given` content of its file."""
        drawn = {group: table for group, table in self.tables.items() if table or group in given}
        found = dict(given) | drawn | {PARTS: {name: {DRAWN: part} for name, part in self.parts.items()}}
        if isinstance(given.get(FAULTS), Mapping):
            found[FAULTS] = {name: self._faulty(entry) for name, entry in given[FAULTS].items()}
        return found

    def _faulty(self, entry: Any) -> Any:
        """A fault whose names are those of the circuit."""
        if not isinstance(entry, Mapping):
            return entry
        found = dict(entry)
        for key in ("sensor", "actuator", "jams"):
            if isinstance(found.get(key), str):
                found[key] = inner_name(found[key], self.parts)
        if isinstance(found.get("value"), str):
            group, dot, rest = found["value"].partition(".")
            part, _, value = rest.rpartition(".")
            values = as_table(self.parts.get(inner_name(part, self.parts), {}).get("values")) if group == PARTS else {}
            paths = values.get(value, ())
            found["value"] = paths[0] if len(paths) == 1 else group + dot + inner_name(rest, self.parts)
        return found
