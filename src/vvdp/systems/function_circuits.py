"""Circuits that a function draws from the tables of a system file."""

import traceback
from collections.abc import Mapping
from dataclasses import fields
from pathlib import Path
from typing import Any, NamedTuple

from vvdp.base.errors import Fault, NetworkError, ParameterError
from vvdp.base.params import Params
from vvdp.base.rules import without_class
from vvdp.base.tables import Sourced, Table, build_inner
from vvdp.network.network import Network
from vvdp.systems.circuits import NetworkFunction, circuit_names, draw, network_function, table_slots
from vvdp.systems.part_scopes import Entries

DRAWN = ("nodes", "components", "parts")
"""Tables of which a file that draws its circuit has one."""


def circuit_function(table: Table, folder: Path, faults: list[Fault]) -> NetworkFunction | None:
    """The function that draws the circuit; None where the file draws it itself, or names none."""
    name = table.content.get("circuit")
    line = table.lines.get("circuit", 0)
    if not set(DRAWN).isdisjoint(table.content):
        if name is not None:
            faults.append(Fault(table.place, line, "circuit", "this file draws its circuit; remove this line"))
        return None
    if not isinstance(name, str):
        what = "missing" if name is None else f"{name!r} is not a circuit"
        expected = ", ".join((*circuit_names(), "module:function"))
        message = f"{what}; expected {expected}, or tables [nodes] and [components]"
        faults.append(Fault(table.place, line, "circuit", message))
        return None
    try:
        function = network_function(name, folder)
        table_slots(function)
    except ParameterError as problem:
        faults.append(Fault(table.place, line, "circuit", str(problem)))
        return None
    return function


class ReadBefore(NamedTuple):
    """Tables of a file that were read already: what they say, the values, and where these come from."""

    content: Entries
    values: Entries
    rows: tuple[Sourced, ...]


def read_tables(
    function: NetworkFunction,
    content: Mapping[str, object],
    table: Table,
    faults: list[Fault],
    before: ReadBefore | None,
) -> tuple[dict[str, Any], list[Sourced]]:
    """The values of the tables that a circuit takes, and where each comes from; what stays is not read again."""
    slots = table_slots(function)
    values: dict[str, Any] = {}
    rows: list[Sourced] = []
    for key, slot in slots.items():
        part = content.get(key)
        if part is None and slot.optional:
            continue
        if before is not None and key in before.values and repr(part) == repr(before.content.get(key)):
            values[key] = before.values[key]
            rows += [row for row in before.rows if row.table == key]
            continue
        values[key], found = build_inner(slot, part, key, table, faults)
        rows += found
    return values, rows


def keys_of(cls: type[Params]) -> set[str]:
    """The keys of a table of this class."""
    return {field.name for field in fields(cls)}  # type: ignore[arg-type]


def network_of(
    function: NetworkFunction, values: Mapping[str, object], table: Table, faults: list[Fault]
) -> Network | None:
    """The network that a function draws, with a fault where it cannot."""
    try:
        network = draw(function, values)
    except (NetworkError, ParameterError) as problem:
        key, _, message = str(problem).partition(": ")
        line = table.lines.get(key, 0)
        text = message if line else without_class(str(problem))
        faults.append(Fault(table.place, line, key if line else "", text))
        return None
    except Exception as problem:  # of code that is not ours
        at = traceback.extract_tb(problem.__traceback__)[-1]
        what = f"{type(problem).__name__}: {problem} ({at.filename}:{at.lineno})"
        faults.append(Fault(table.place, table.lines.get("circuit", 0), "circuit", f"cannot be drawn: {what}"))
        return None
    if not isinstance(network, Network):
        name = function.__qualname__
        faults.append(Fault(table.place, table.lines.get("circuit", 0), "circuit", f"{name} returns no Network"))
        return None
    return network
