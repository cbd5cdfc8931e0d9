"""One use of a part in a file: the nodes at its ports, what these carry, and the values that it is given."""

from dataclasses import dataclass, replace
from typing import Any

from vvdp.base.errors import Fault, ParameterError
from vvdp.base.tables import closest_word, fault_at, inner_table, nearest, refuse_unknown, suggestion
from vvdp.components.library import COMPONENTS
from vvdp.network.assembly import Assembly
from vvdp.network.component import Role
from vvdp.systems.drawing import NODES as NODE_TYPES
from vvdp.systems.drawn_parts import DrawnCircuit, drop_alternatives
from vvdp.systems.part_files import NODES, PARTS, TABLES_OF_A_PART, VALUES, WORDS, PartFile
from vvdp.systems.part_scopes import Entries, Place, Scope, as_table

OIL, SHAFT, ROD = "oil", "shaft", "rod"
CARRIED = {Role.PORT: OIL, Role.SHAFT: SHAFT, Role.SHAFT_SPEED: SHAFT, Role.ROD: ROD}
HELD = {"shaft": SHAFT, "driven-shaft": SHAFT, "rod": ROD}
"""Shaft or rod, by the type of a node that holds no oil."""


def joined_ports(entry: Any) -> dict[str, str]:
    """The ports of a component in a file, and what each carries."""
    component = COMPONENTS.get(str(as_table(entry).get("type")))
    if isinstance(component, Assembly):
        return dict.fromkeys(component.ports, OIL)
    return {} if component is None else {port: CARRIED[role] for port, role in component.ports.items()}


@dataclass(frozen=True)
class PartUse:
    """A part as a file, drawn in a scope, uses it under a name, with what the entry of [parts] says."""

    circuit: DrawnCircuit
    scope: Scope
    name: str
    entry: Entries
    file: PartFile

    @property
    def drawn_name(self) -> str:
        """The name of the part in the drawn circuit."""
        return self.scope.prefix + self.name

    @property
    def place(self) -> Place:
        """Where the use stands."""
        return self.scope.place(f"{PARTS}.{self.name}")

    @property
    def _other_keys(self) -> list[str]:
        """Keys that are neither ports nor values."""
        known = {*WORDS, *self.file.ports, *self.file.values}
        return [key for key in self.entry if key not in known]

    def inner_scope(self) -> Scope:
        """The file of the part as it is drawn here; faults where a port is joined to no node."""
        ports = {port: node for port in self.file.ports if (node := self._node_at(port)) is not None}
        at = fault_at(self.place.table, self.place.path, "")
        use = f"used as {self.name} at {at.place}:{at.line}" + (f", {self.scope.use}" if self.scope.use else "")
        return Scope(self.file, f"{self.drawn_name}_", ports, use, (*self.scope.above, self.file.identity))

    def record(self, inner: Scope) -> dict[str, Any]:
        """Record of the part in the drawn circuit; names and values follow when it is drawn."""
        place = {"at": self.entry["at"]} if "at" in self.entry else {}
        return {"source": self.file.name, "ports": dict(inner.ports), "names": [], "values": {}, **place}

    def refuse_keys(self, inner: Scope) -> None:
        """A fault for each key that is neither a port nor a value, and for each table that a part does not have."""
        wrong: list[Fault] = []
        refuse_unknown(inner.content, TABLES_OF_A_PART, "", self.file.table, wrong)
        for table in TABLES_OF_A_PART[1:]:
            inner_table(inner.content, table, self.file.table, wrong)
        names = [*(f"nodes.{port}" for port in self.file.ports), *(f"{VALUES}.{value}" for value in self.file.values)]
        ends = [name.partition(".")[2] for name in names]
        for name, end in zip(names, ends, strict=True):
            if end in WORDS or ends.count(end) > 1:
                words = "means something else where the part is used; choose another name for the port or value"
                wrong.append(fault_at(self.file.table, name, words))
        self.circuit.faults += [replace(each, message=f"{each.message} ({inner.use})") for each in wrong]
        offered = tuple(self.file.values)
        for key in self._other_keys:
            value = self.entry[key]
            is_joined = isinstance(value, str) and value.partition(".")[0] in self.scope.names
            what, known = ("port", self.file.ports) if is_joined else ("value", offered)
            meant = suggestion(key, (*self.file.ports, *offered)) or (nearest(key, known) if known else "")
            self.circuit.tell(self.place.below(key), f"{self.file.name} offers no {what} {key!r}{meant}")

    def _node_at(self, port: str) -> str | None:
        """The node of the drawn circuit at a port; None where that is none."""
        nodes = [each for each in as_table(self.scope.content.get("nodes")) if each not in self.scope.parts]
        node = self.entry.get(port)
        if node is None and port in (closest_word(key, self.file.ports) for key in self._other_keys):
            return None  # what is misspelt is reported
        if node is None:
            message = f"port {port!r} is not connected; join it to one of {', '.join(nodes) or 'no node yet'}"
            self.circuit.tell(self.place, message)
        elif not isinstance(node, str) or node not in nodes:
            message = f"port {port!r} ends at {node!r}, which is no node{nearest(str(node), nodes)}"
            self.circuit.tell(self.place.below(port), message)
        else:
            return self.scope.names.get(node)
        return None

    def check_port(self, port: str, carried: str, inner: Scope) -> None:
        """A fault where a port carries something that the node there does not hold."""
        node = self.entry.get(port)
        if port not in inner.ports or node in self.scope.ports:
            return
        kind = str(as_table(self.circuit.tables[NODES].get(inner.ports[port])).get("type"))
        if kind in NODE_TYPES and HELD.get(kind, OIL) != carried:
            what = carried if carried == OIL else f"a {carried}"
            words = f"port {port!r} carries {what}; {node!r} is a {kind.replace('-', ' ')}"
            self.circuit.tell(self.place.below(port), words)


def set_values(use: PartUse, inner: Scope) -> None:
    """Put the values of a part where they belong in the drawn circuit: all defaults, then what the use gives."""
    values: dict[str, list[str]] = use.circuit.parts[use.drawn_name]["values"]
    for value, targets in use.file.values.items():
        values[value] = _value_paths(use, inner, value, targets)
        own = as_table(as_table(inner.content[VALUES]).get(value))
        default = {key: entry for key, entry in own.items() if key != "sets"}
        for path in values[value] if default else ():
            use.circuit.set(path, inner.rename(default, use.circuit.parts), inner.place(f"{VALUES}.{value}"))
    given = {path for value, paths in values.items() if value in use.entry for path in paths}
    drop_alternatives(use.circuit.tables, given)
    for value, paths in values.items():
        place = use.place.below(value)
        for path in paths:
            if value in use.entry:
                use.circuit.set(path, use.scope.rename(use.entry[value], use.circuit.parts), place)
            elif not use.circuit.has(path):
                use.circuit.places[path] = place


def _value_paths(use: PartUse, inner: Scope, value: str, targets: tuple[str, ...]) -> list[str]:
    """The entries of the drawn circuit that a value sets, with a fault where there are none."""
    place = inner.place(f"{VALUES}.{value}")
    try:
        paths = [path for target in targets for path in use.circuit.paths(inner, target)]
    except ParameterError as problem:
        use.circuit.tell(place, str(problem))
        return []
    if not targets:
        words = 'expected what it sets: a path, such as "components.pump.displacement", or a list of some'
        use.circuit.tell(place, words)
    return paths
