"""Parts of a drawn circuit drawn out: their nodes, components and programs under names that begin with the part's name.

What is `inlet` in a part that is used as `supply` becomes `supply_inlet`: that is its name in the network, in the
equations and in the keys of results. A file may also write it with a dot, `supply.inlet`. The drawn circuit is a table
like any other; it keeps in `[parts.NAME] drawn` what the part was, so that it can be read again without its file.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from vvdp.base.errors import ConfigError, Fault, ParameterError
from vvdp.base.tables import Table, copy_tables, fault_at, inner_table, nearest
from vvdp.network.network import NAME
from vvdp.systems.drawn_parts import DrawnCircuit, is_record
from vvdp.systems.part_files import (
    COMPONENTS,
    DRAWN,
    GROUPS,
    PARTS,
    PORT,
    PartFile,
    ports_of,
    read_used_part,
)
from vvdp.systems.part_scopes import Entries, Place, Scope, as_table
from vvdp.systems.part_uses import PartUse, joined_ports, set_values


@dataclass(frozen=True)
class Expanded:
    """A circuit with its parts drawn out, and where its entries come from."""

    table: Table
    places: Mapping[str, Place]

    def locate(self, fault: Fault) -> Fault:
        """A fault of the drawn circuit at the line of the file where its cause stands."""
        path = fault.key
        while path not in self.places and "." in path:
            path = path.rpartition(".")[0]
        place, below = self.places.get(path), fault.key[len(path) + 1 :]
        if place is None:
            return fault
        return (place.below(below) if below else place).fault(fault.message)


def expand(table: Table, folder: Path) -> Expanded:
    """The circuit of a file with all its parts drawn out; files of parts are looked for in `folder`.

    A circuit without parts is returned as it is. Raises ConfigError with all faults of the parts and their uses.
    """
    faults: list[Fault] = []
    content, file = table.content, Path(table.place).name
    ports = ports_of(content)
    if ports:
        words = f'only a part has this; use the file in another one: [parts.NAME] file = "{file}"'
        faults.append(fault_at(table, f"nodes.{ports[0]}", words))
    for group in (*GROUPS, PARTS) if PARTS in content else ():
        inner_table(content, group, table, faults)
    _refuse(faults)
    if PARTS not in content:
        return Expanded(table, {})
    top = PartFile(file, table, folder / file)
    circuit = DrawnCircuit(faults)
    Expansion(circuit).draw(Scope(top, above=(top.identity,)))
    _refuse_inner_joints(circuit)
    _refuse(faults)
    return Expanded(Table(table.place, circuit.content(content), table.lines), circuit.places)


def _refuse(faults: list[Fault]) -> None:
    if faults:
        raise ConfigError(list(dict.fromkeys(faults)))


def _refuse_inner_joints(circuit: DrawnCircuit) -> None:
    """A fault where a component outside of a part is joined to a node inside of it."""
    for name, entry in circuit.tables[COMPONENTS].items():
        outside = {part: use for part, use in circuit.parts.items() if name not in use["names"]}
        for port in joined_ports(entry):
            part = next((part for part, use in outside.items() if entry.get(port) in use["names"]), "")
            if part:
                ports = ", ".join(outside[part]["ports"])
                words = f"port {port!r} ends at {entry[port]!r}, inside of {part!r}, whose ports are {ports}"
                circuit.tell(circuit.places[f"components.{name}"], words)


class Expansion:
    """Draws a file and the parts that it uses into one circuit."""

    def __init__(self, circuit: DrawnCircuit) -> None:
        self.circuit = circuit
        self.carried: dict[tuple[str, str], str] = {}
        """The content of a port, by the prefix of its part and its name."""

    def draw(self, scope: Scope) -> None:
        """Draw one file: what stands in it first, then its parts, then what it changes inside of them."""
        changes, joined, uses = [], dict[str, Mapping[str, str]](), list[tuple[PartUse, Scope]]()
        for group, name, entry in _entries(scope):
            place = scope.place(f"{group}.{name}")
            if name in scope.parts and "type" in as_table(entry):
                self.circuit.tell(place, f"the name {name!r} is that of a part as well; choose another")
            elif name in scope.parts or (_has_no_type(entry) and _is_inside(name, scope.parts)):
                changes.append((place, group, scope.prefix + name, entry))
            elif self.circuit.take(place, scope.prefix + name):
                joined[f"{group}.{scope.prefix}{name}"] = self._add(scope, group, name, entry)
        for name, entry in scope.parts.items():
            if (use := self._use(scope, name, entry)) is not None:
                uses.append((use, self._draw_part(use)))
        self.circuit.rename(scope, joined)
        for use, inner in uses:
            set_values(use, inner)
        for place, group, name, entry in changes:
            self.circuit.change(place, group, name, scope.rename(entry, self.circuit.parts))

    def _add(self, scope: Scope, group: str, name: str, entry: Any) -> Mapping[str, str]:
        """Add a node, component or program of a file; what its ports carry."""
        self.circuit.tables[group][scope.prefix + name] = copy_tables(entry) if isinstance(entry, Mapping) else entry
        self.circuit.places[f"{group}.{scope.prefix}{name}"] = scope.place(f"{group}.{name}")
        ports = joined_ports(entry) if group == "components" else {}
        own = ports_of(scope.content)
        self.carried |= {(scope.prefix, entry[port]): what for port, what in ports.items() if entry.get(port) in own}
        return ports

    def _use(self, scope: Scope, name: str, entry: Any) -> PartUse | None:
        """One use of a part that is still to be drawn; None where there is nothing to draw."""
        place, circuit = scope.place(f"{PARTS}.{name}"), self.circuit
        if not isinstance(entry, Mapping):
            circuit.tell(place, f"{entry!r} is not a table; expected {{ file = ... }} or {{ type = ... }}")
        elif DRAWN in entry:
            self._use_drawn(scope, name, entry)
        elif not NAME.fullmatch(name):
            circuit.tell(place, f"{name!r} cannot be a name; use small letters, digits and _, beginning with a letter")
        elif circuit.take(place, scope.prefix + name):
            try:
                file = read_used_part(entry, scope.file.folder)
            except ParameterError as problem:
                circuit.tell(place.below("file") if "file" in entry else place, str(problem))
                return None
            if file.identity not in scope.above:
                return PartUse(circuit, scope, name, entry, file)
            chain = " -> ".join(Path(each).name for each in (*scope.above, file.identity))
            circuit.tell(place, f"{file.name} would be a part of itself: {chain}")
        return None

    def _draw_part(self, use: PartUse) -> Scope:
        """Draw the file of a part; the scope in which it was."""
        inner = use.inner_scope()
        use.refuse_keys(inner)
        before = set(self.circuit.taken)
        self.circuit.parts[use.drawn_name] = use.record(inner)
        self.draw(inner)
        self.circuit.parts[use.drawn_name]["names"] = [each for each in self.circuit.taken if each not in before]
        for port in use.file.ports:
            if carried := self.carried.get((inner.prefix, port)):
                if use.entry.get(port) in ports_of(use.scope.content):
                    self.carried[use.scope.prefix, use.entry[port]] = carried
                use.check_port(port, carried, inner)
        return inner

    def _use_drawn(self, scope: Scope, name: str, entry: Entries) -> None:
        """A part that was drawn before: its values may be set again."""
        place, circuit = scope.place(f"{PARTS}.{name}"), self.circuit
        if not is_record(entry[DRAWN], circuit.tables):
            circuit.tell(place.below(DRAWN), "is not what vvdp keeps of a part; name its file or type instead")
            return
        circuit.parts[name], values = dict(entry[DRAWN]), entry[DRAWN]["values"]
        circuit.take(place, name)
        for key, value in entry.items():
            if key != DRAWN and key not in values:
                known = nearest(key, list(values)) if values else ""
                circuit.tell(place.below(key), f"is no value of the part that can be set{known}")
            for path in values.get(key, ()) if key != DRAWN else ():
                circuit.set(path, scope.rename(value, circuit.parts), place.below(key))


def _entries(scope: Scope) -> Iterator[tuple[str, str, Any]]:
    """Table, name and content of what a file draws, but for its ports."""
    for group in GROUPS:
        for name, entry in as_table(scope.content.get(group)).items():
            if as_table(entry).get("type") != PORT:
                yield group, name, entry


def _has_no_type(entry: Any) -> bool:
    return isinstance(entry, Mapping) and "type" not in entry


def _is_inside(name: str, parts: Mapping[str, object]) -> bool:
    """Whether a name is one inside of a part, written with an underscore."""
    return any(name.startswith(f"{part}_") for part in parts)
