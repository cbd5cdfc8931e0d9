"""A system with other values, or with some of what its file draws once more."""

import json
from collections.abc import Collection, Mapping, Sequence
from typing import Any

from vvdp.base.kinds import PRESSURE_LEVEL, Kind
from vvdp.base.tables import Table, with_settings
from vvdp.systems.part_files import GROUPS
from vvdp.systems.part_scopes import UNNAMED
from vvdp.systems.system import System

Number = float | tuple[float, ...]
"""A value or a list of values [SI, pressures absolute]."""


def with_numbers(system: System, numbers: Mapping[str, Number | str | Mapping[str, Any]]) -> System:
    """The system with other numbers, or texts and tables as in a file, at paths such as `components.pump.displacement`.

    Raises ConfigError with all faults.
    """
    kinds = {row.setting: row.kind for row in system.rows}
    settings = [f"{path}={setting_text(value, kinds.get(path))}" for path, value in numbers.items()]
    return system.read_from(with_settings(system.table, settings))


def with_tables(system: System, tables: Mapping[str, Mapping[str, Any] | None]) -> System:
    """The system with other tables of its file, or without those that are None.

    Raises ConfigError with all faults.
    """
    content = {key: entry for key, entry in system.table.content.items() if key not in tables}
    given = {key: entry for key, entry in tables.items() if entry is not None}
    return system.read_from(Table(system.table.place, content | given, system.table.lines))


def with_copies(system: System, names: Collection[str], suffixes: Sequence[str]) -> System:
    """The system with some nodes, components and programs of its file once more for each suffix, behind their names.

    Copies are joined to one another, and else to what the originals are joined to. They stand behind the originals,
    those of nodes behind all nodes, so that the order of the states that were there stays.

    Raises ConfigError with all faults.
    """
    table, content = system.table, dict(system.table.content)
    for group in GROUPS:
        entries: Mapping[str, Any] = content[group]
        own, listed = [name for name in entries if name in names], list(entries.items())
        copies = [(f"{name}{end}", _with_suffix(entries[name], names, end)) for end in suffixes for name in own]
        at = len(entries) if group == "nodes" or not own else list(entries).index(own[-1]) + 1
        content[group] = dict(listed[:at] + copies + listed[at:])
    return system.read_from(Table(table.place, content, table.lines))


def _with_suffix(entry: Any, names: Collection[str], suffix: str) -> Any:
    """An entry in which names, and paths that begin with one, end with a suffix."""
    if isinstance(entry, Mapping):
        return {key: each if key in UNNAMED else _with_suffix(each, names, suffix) for key, each in entry.items()}
    first, dot, rest = entry.partition(".") if isinstance(entry, str) else ("", "", "")
    return f"{first}{suffix}{dot}{rest}" if first in names else entry


def quantity_text(value: Any) -> str:
    """A quantity of pint as text with its unit; empty for anything else."""
    is_quantity = hasattr(value, "magnitude") and hasattr(value, "units")
    return f"{float(value.magnitude)!r} {value.units:~C}".replace("**", "^").strip() if is_quantity else ""


def setting_text(value: Any, kind: Kind | None) -> str:
    """A number [SI], quantity, text, list or table as the text of a setting.

    Raises TypeError, ValueError for anything else.
    """
    if isinstance(value, Mapping):
        inner = ", ".join(f"{json.dumps(key)} = {setting_text(each, kind)}" for key, each in value.items())
        return f"{{{inner}}}"
    if isinstance(value, list | tuple):
        return f"[{', '.join(setting_text(each, kind) for each in value)}]"
    if isinstance(value, str):
        return json.dumps(value)
    return json.dumps(quantity_text(value) or _text(float(value), kind))


def _text(value: float, kind: Kind | None) -> str:
    """A number [SI] with the unit of its kind."""
    if kind is PRESSURE_LEVEL:
        return f"{value / 1e5!r} bara"
    if kind is None or kind.unit == "1":
        return repr(value)
    return f"{value!r} {kind.unit}"
