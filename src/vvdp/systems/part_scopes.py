"""The names of one file among the parts of a circuit: what they are in the drawn circuit, and where they stand."""

import re
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, TypeAlias

from vvdp.base.errors import Fault
from vvdp.base.tables import ORIGIN, Table, fault_at
from vvdp.systems.part_files import GROUPS, PARTS, PartFile

Entries: TypeAlias = Mapping[str, Any]
"""Entries of a table of a file, by key."""
PATH = re.compile(r"[a-z]\w*(\.\w+)*")
TIME = "t"
"""Names that every program may read besides the quantities of the circuit."""
UNNAMED = frozenset((*ORIGIN, "type", "oil", "at", "range"))
"""Keys whose texts are not names of the circuit."""


@dataclass(frozen=True)
class Place:
    """Where an entry of a drawn circuit stands: a file, the path in it, and where that file is used."""

    table: Table
    path: str
    use: str = ""

    def below(self, key: str) -> "Place":
        """The place of a key of this table."""
        return Place(self.table, f"{self.path}.{key}", self.use)

    def fault(self, message: str) -> Fault:
        """A fault here, with the line of the file and that of its use."""
        return fault_at(self.table, self.path, message + (f" ({self.use})" if self.use else ""))


@dataclass(frozen=True)
class Scope:
    """One file as it is drawn: what goes before its names, the nodes at its ports, where and in what it is used."""

    file: PartFile
    prefix: str = ""
    ports: Mapping[str, str] = field(default_factory=dict)
    use: str = ""
    above: tuple[str, ...] = ()

    @property
    def content(self) -> Mapping[str, object]:
        """The tables of the file."""
        return self.file.table.content

    def place(self, path: str) -> Place:
        """Where a path of the file stands."""
        return Place(self.file.table, path, self.use)

    @cached_property
    def names(self) -> Mapping[str, str]:
        """The names of the file, and those of the drawn circuit that stand for them."""
        given = (name for group in (*GROUPS, PARTS) for name in as_table(self.content.get(group)))
        return {name: self.prefix + name for name in given} | dict(self.ports)

    @cached_property
    def parts(self) -> Mapping[str, object]:
        """The uses of parts in the file."""
        return as_table(self.content.get(PARTS))

    def rename(self, entry: Any, drawn: Collection[str], joined: Collection[str] = ()) -> Any:
        """An entry of the file with the names of the drawn circuit.

        drawn   the parts of the circuit: a dot after one leads into it
        joined  keys whose texts are names, known to the file or not
        """
        if isinstance(entry, str):
            return self._drawn_name(entry, drawn, is_name=False)
        if isinstance(entry, list):
            return [self.rename(each, drawn) for each in entry]
        if not isinstance(entry, Mapping):
            return entry
        return {
            key: value
            if key in UNNAMED
            else self._drawn_name(value, drawn, is_name=True)
            if key in joined and isinstance(value, str)
            else self.rename(value, drawn)
            for key, value in entry.items()
        }

    def _drawn_name(self, text: str, drawn: Collection[str], *, is_name: bool) -> str:
        """A name, or a path that begins with one, in the drawn circuit; any other text as it is."""
        if not PATH.fullmatch(text) or text == TIME:
            return text
        first, dot, rest = text.partition(".")
        if first not in self.names and not dot and not is_name:
            return text
        return inner_name(self.names.get(first, self.prefix + first) + dot + rest, drawn)


def inner_name(path: str, drawn: Collection[str]) -> str:
    """A path of the drawn circuit in which a dot after the name of a part leads into it: `supply.inlet.pressure`."""
    name, *rest = path.split(".")
    while name in drawn and rest:
        name = f"{name}_{rest.pop(0)}"
    return ".".join((name, *rest))


def as_table(given: Any) -> Entries:
    """A table, empty where something else stands."""
    return given if isinstance(given, Mapping) else {}
