"""Short paths of a file that draws its circuit: the table of a node, component or program may stand under its name
alone, and [values] gives a path of the file's own to any entry.

`[valve] nozzle_area = "36.5 mm^2"` is `nozzle_area` of `[components.valve]`. With `[values] operation.pump_speed =
"nodes.pump_shaft.speed"` the file says `[operation] pump_speed = "1800 rpm"`, with `check_valve = "components.valve"`
it has a table [check_valve] with values of the valve. These are the paths by which values are set, ranged and listed.
"""

import re
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from vvdp.base.errors import Fault
from vvdp.base.params import field_names
from vvdp.base.tables import Sourced, Table, copy_tables, fault_at, nearest, refuse_unknown
from vvdp.components.library import UsualOil
from vvdp.hydraulics.heat import HeatBalance
from vvdp.systems.drawing import TABLES, Temperature
from vvdp.systems.drawn_parts import FAULTS
from vvdp.systems.limits import Limits
from vvdp.systems.part_files import GROUPS, VALUES, targets_of
from vvdp.systems.part_scopes import Entries, as_table

FULL_PATH = re.compile(rf"\b(?:{'|'.join((*GROUPS, 'oils'))})\.\w+(?:\.\w+)*")
"""A path of a value in the text of a message."""
OWN = {"oil": UsualOil, "operation": Temperature, "heat": HeatBalance, "limits": Limits}
"""Tables of any drawn circuit, whose keys mean something there as well."""


@dataclass(frozen=True)
class FullTable:
    """A drawn circuit in which each value stands with its node, component or program.

    short    the paths that the file has for values that stand elsewhere in it
    written  the file as it is
    tables   the names that the file has for tables inside of its programs
    """

    table: Table
    short: Mapping[str, str]
    written: Table
    tables: Mapping[str, str]

    @property
    def names(self) -> frozenset[str]:
        """The tables that the file may have for what is drawn."""
        return frozenset((*self.tables.values(), *_names(self.written.content)))

    def path_of(self, full: str) -> str:
        """The path of a value in the file; of one that it leaves out, that of the table in which it would stand."""
        group, _, rest = full.partition(".")
        if full in self.short or full in self.written.lines or group not in GROUPS:
            return self.short.get(full, full)
        for table, outer in self.tables.items():
            if full == table or full.startswith(f"{table}."):
                return outer + full.removeprefix(table)
        return rest if rest.partition(".")[0] in self.written.content else full

    def locate(self, fault: Fault) -> Fault:
        """A fault at the path that the file has; the message of an entry of [faults] names that path as well."""
        message = fault.message
        if fault.key.startswith(f"{FAULTS}."):
            message = FULL_PATH.sub(lambda found: self.path_of(found[0]), message)
        return replace(fault, key=self.path_of(fault.key), message=message)

    def rows(self, rows: Sequence[Sourced]) -> tuple[Sourced, ...]:
        """Values under the paths that the file has, each once; with short paths, in the order of the file's tables."""
        if not self.short:
            return tuple(rows)
        named: dict[str, Sourced] = {}
        for row in map(self._rename, rows):
            named.setdefault(row.setting, row)
        places = {table: number for number, table in enumerate(self.written.content)}
        return tuple(sorted(named.values(), key=lambda row: places.get(row.table.partition(".")[0], 0)))

    def _rename(self, row: Sourced) -> Sourced:
        setting = self.path_of(row.setting)
        if setting == row.setting and not row.idle_at:
            return row
        table, _, key = setting.rpartition(".")
        return replace(row, table=table, key=key, idle_at=tuple(map(self.path_of, row.idle_at)))


def with_full_paths(table: Table, faults: list[Fault]) -> FullTable:
    """The drawn circuit with all values at their full paths; faults are appended for those that stand twice.

    A table in which nothing is drawn is returned as it is.
    """
    names = _names(table.content)
    if not names:
        return FullTable(table, {}, table, {})
    targets = dict(_targets(as_table(table.content.get(VALUES)), ()))
    _refuse_targets(targets, names, table, faults)
    content, lines, short = copy_tables(table.content), dict(table.lines), dict[str, str]()
    content.pop(VALUES, None)
    below_entry = _lines_by_entry(table.lines)
    for outer, entry in _short_entries(table.content):
        name, _, key = outer.partition(".")
        usual = (f"{names[name]}.{name}",) if name in names else ()
        paths = targets.get(outer) or [f"{path}.{key}" for path in targets.get(name, usual)]
        for path in paths:
            if _has(table.content, path) or path in short:
                words = f"is given twice; {short.get(path, path)} stands in the file as well"
                faults.append(fault_at(table, outer, words))
            _set(content, path, entry)
            lines |= {path + below: line for below, line in below_entry[outer].items()}
            short[path] = outer
        if paths and not (name in OWN and key in field_names(OWN[name])):
            del content[name][key]
    _refuse_unknown_keys(content, targets, names, table, faults)
    content = {name: inner for name, inner in content.items() if inner != {} or name in OWN}
    if isinstance(content.get(FAULTS), Mapping):
        content[FAULTS] = {name: _fault_with_full_path(each, short) for name, each in content[FAULTS].items()}
    inner = {path: outer for outer, paths in targets.items() for path in paths if _leads_inside(outer, path)}
    return FullTable(Table(table.place, content, lines), short, table, inner)


def path_in_file(table: Table, full: str) -> str:
    """The path that a file has for a full one: of a value, or of the table of a node, component or program."""
    return with_full_paths(table, []).path_of(full)


def full_settings(table: Table, settings: Sequence[str]) -> list[str]:
    """Settings of the form path=value as `table` has their paths: a full one where it has a short one, and the other
    way round."""
    short, names = with_full_paths(table, []).short, _names(table.content)
    found = []
    for setting in settings:
        path, equals, value = setting.partition("=")
        path = path.strip()
        name = path.partition(".")[0]
        full = f"{names[name]}.{path}" if name in names else path
        found.append(short.get(full, path if name in table.content else full) + equals + value)
    return found


def _short_entries(content: Entries) -> Iterator[tuple[str, Any]]:
    """The entries that may belong to a node, component or program, by their paths in the file."""
    for name, given in content.items():
        if isinstance(given, Mapping) and name not in ("run", VALUES) and (name in OWN or name not in TABLES):
            yield from ((f"{name}.{key}", entry) for key, entry in given.items())


def _names(content: Entries) -> dict[str, str]:
    """The table in which each node, component, program and oil stands, by its name; none of a name that a table of any
    circuit has."""
    groups = ((group, as_table(content.get(group))) for group in (*GROUPS, "oils"))
    return {name: group for group, entries in groups for name in entries if name not in (*TABLES, "run")}


def _targets(given: Entries, above: tuple[str, ...]) -> Iterator[tuple[str, tuple[str, ...]]]:
    """Targets of each path of [values]."""
    for key, entry in given.items():
        path = (*above, key)
        if isinstance(entry, Mapping) and "sets" not in entry:
            yield from _targets(entry, path)
        else:
            yield ".".join(path), targets_of(entry)


def _refuse_targets(
    targets: Mapping[str, tuple[str, ...]], names: Mapping[str, str], table: Table, faults: list[Fault]
) -> None:
    """A fault for each path of [values] that sets nothing."""
    for outer, paths in targets.items():
        if not paths:
            words = 'expected a path, such as "components.pump.displacement", or a list of some'
            faults.append(fault_at(table, f"{VALUES}.{outer}", words))
        for path in paths:
            group, _, rest = path.partition(".")
            name, _, key = rest.partition(".")
            is_table = not key or _leads_inside(outer, path)
            if names.get(name) != group or is_table == ("." in outer):
                known = [f"{of}.{each}" for each, of in names.items()]
                meant = nearest(f"{group}.{name}", known)
                faults.append(fault_at(table, f"{VALUES}.{outer}", f"{path!r} leads to nothing that is drawn{meant}"))


def _refuse_unknown_keys(
    content: Entries,
    targets: Mapping[str, tuple[str, ...]],
    names: Mapping[str, str],
    table: Table,
    faults: list[Fault],
) -> None:
    """A fault for each key left in a table of [values] that leads nowhere; it is taken out."""
    for name in dict.fromkeys(path.partition(".")[0] for path in targets if "." in path):
        if name in names or name in targets or not isinstance(content.get(name), dict):
            continue
        own = field_names(OWN[name]) if name in OWN else ()
        known = [*own, *(path.partition(".")[2] for path in targets if path.partition(".")[0] == name)]
        refuse_unknown(content[name], known, name, table, faults)
        for key in [key for key in content[name] if key not in own]:
            del content[name][key]


def _leads_inside(outer: str, path: str) -> bool:
    """Whether a name of the file stands for a table inside of a program, `gains = "programs.displacement.gains"`."""
    return "." not in outer and path.startswith("programs.") and path.count(".") == 2


def _has(content: Entries, path: str) -> bool:
    found: Any = content
    for word in path.split("."):
        found = as_table(found).get(word)
    return found is not None


def _set(content: dict[str, Any], path: str, entry: Any) -> None:
    *above, key = path.split(".")
    inner: Any = content
    for word in above:
        inner = inner.setdefault(word, {})
        if not isinstance(inner, dict):
            return  # no table: that is reported where the circuit is drawn
    inner[key] = entry


def _lines_by_entry(lines: Mapping[str, int]) -> Mapping[str, Mapping[str, int]]:
    """The lines of each entry TABLE.KEY and of what stands in it, by the rest of the path."""
    found: dict[str, dict[str, int]] = defaultdict(dict)
    for path, line in lines.items():
        table, _, rest = path.partition(".")
        key, dot, below = rest.partition(".")
        found[f"{table}.{key}"][dot + below] = line
    return found


def _fault_with_full_path(entry: Any, short: Mapping[str, str]) -> Any:
    """An entry of [faults] that says which value becomes another by its full path: in the circuit, if it is there."""
    value = as_table(entry).get("value")
    paths = [path for path, outer in short.items() if outer == value]
    stays_there = isinstance(value, str) and value.partition(".")[0] in OWN
    drawn = [path for path in paths if not path.startswith("programs.")] or ([] if stays_there else paths)
    return {**entry, "value": drawn[0]} if drawn else entry
