"""Short paths of a file that draws its circuit: the table of a node, component or program may stand under its name
alone, and [values] gives a path of the file's own to any entry.

`[valve] nozzle_area = "36.5 mm^2"` is `nozzle_area` of `[components.valve]`. With `[values.operation]
pump_speed = "nodes.pump_shaft.speed"`, the file says `[operation] pump_speed = "1800 rpm"`. Both are the paths by which
values are set, ranged and listed.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from vvdp.base.errors import Fault
from vvdp.base.params import field_names
from vvdp.base.tables import Sourced, Table, copy_tables, fault_at, nearest
from vvdp.components.library import UsualOil
from vvdp.hydraulics.heat import HeatBalance
from vvdp.systems.bench_tables import Limits
from vvdp.systems.drawing import TABLES, Temperature
from vvdp.systems.part_files import GROUPS, VALUES, targets_of
from vvdp.systems.part_scopes import as_table

OWN = {"oil": UsualOil, "operation": Temperature, "heat": HeatBalance, "limits": Limits}
"""Tables of any drawn circuit, whose keys mean something there as well."""
FAULTS = "faults"


@dataclass(frozen=True)
class FullTable:
    """A drawn circuit in which each value stands with its node, component or program; `short` are the paths of the file
    for those that stand elsewhere in it."""

    table: Table
    short: Mapping[str, str]

    def locate(self, fault: Fault) -> Fault:
        """A fault at the path that the file has."""
        path = self.short.get(fault.key)
        return fault if path is None else replace(fault, key=path)

    def rows(self, rows: Sequence[Sourced]) -> tuple[Sourced, ...]:
        """Values under the paths that the file has, each once, where it has some in the order of its tables."""
        if not self.short:
            return tuple(rows)
        places = {path: number for number, path in enumerate(dict.fromkeys(self.short.values()))}
        named = {row.setting: row for row in map(self._rename, reversed(rows))}
        return tuple(sorted(reversed(named.values()), key=lambda row: places.get(row.setting, -1)))

    def _rename(self, row: Sourced) -> Sourced:
        path = self.short.get(row.setting)
        if path is None:
            return row
        table, _, key = path.rpartition(".")
        return replace(row, table=table, key=key)


def with_full_paths(table: Table, faults: list[Fault]) -> FullTable:
    """The drawn circuit with all values at their full paths; faults are appended for those that stand twice.

    A table that is not drawn is returned as it is.
    """
    names = _names(table.content)
    targets = dict(_targets(as_table(table.content.get(VALUES)), ()))
    if not names:
        return FullTable(table, {})
    _refuse_targets(targets, names, table, faults)
    content, lines, short = copy_tables(table.content), dict(table.lines), dict[str, str]()
    content.pop(VALUES, None)
    for name, given in table.content.items():
        if not isinstance(given, Mapping) or (name in TABLES and name not in OWN) or name in ("run", VALUES):
            continue
        for key, entry in given.items():
            outer = f"{name}.{key}"
            paths = targets.get(outer, (f"{names[name]}.{outer}",) if name in names and name not in OWN else ())
            for path in paths:
                if _has(table.content, path):
                    faults.append(fault_at(table, outer, f"is given twice; {path} stands in the file as well"))
                _set(content, path, entry)
                lines |= {path + line.removeprefix(outer): at for line, at in lines.items() if _is_below(line, outer)}
                short[path] = outer
            if paths and not (name in OWN and key in field_names(OWN[name])):
                del content[name][key]
        if name not in OWN and not content[name]:
            del content[name]
    if isinstance(content.get(FAULTS), Mapping):
        content[FAULTS] = {name: _fault_with_full_path(each, short) for name, each in content[FAULTS].items()}
    return FullTable(Table(table.place, content, lines), short)


def full_settings(table: Table, settings: Sequence[str]) -> list[str]:
    """Settings of the form path=value as `table` has their paths: a full one where it has a short one, and the other
    way round."""
    short = with_full_paths(table, []).short
    names = _names(table.content)

    def path_of(given: str) -> str:
        name, _, key = given.partition(".")
        if given in short:
            return short[given]
        if name in names and name not in table.content:
            return f"{names[name]}.{given}"
        return given

    found = []
    for setting in settings:
        path, equals, value = setting.partition("=")
        found.append(path_of(path.strip()) + equals + value)
    return found


def _names(content: Mapping[str, Any]) -> dict[str, str]:
    """The table in which each node, component and program stands, by its name."""
    return {name: group for group in GROUPS for name in as_table(content.get(group))}


def _targets(given: Mapping[str, Any], above: tuple[str, ...]) -> Iterator[tuple[str, tuple[str, ...]]]:
    """What each path of [values] sets."""
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
        if "." not in outer or not paths:
            words = f'expected [{VALUES}.TABLE] with KEY = "components.NAME.KEY", or a list of such paths'
            faults.append(fault_at(table, f"{VALUES}.{outer}", words))
        for path in paths:
            group, _, rest = path.partition(".")
            name, _, key = rest.partition(".")
            if names.get(name) != group or not key:
                known = [f"{of}.{each}" for each, of in names.items()]
                meant = nearest(f"{group}.{name}", known)
                faults.append(fault_at(table, f"{VALUES}.{outer}", f"{path!r} leads to nothing that is drawn{meant}"))


def _has(content: Mapping[str, Any], path: str) -> bool:
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


def _is_below(line: str, path: str) -> bool:
    return line == path or line.startswith(f"{path}.")


def _fault_with_full_path(entry: Any, short: Mapping[str, str]) -> Any:
    """An entry of [faults] that says which value becomes another by its full path."""
    value = as_table(entry).get("value")
    full = next((path for path, outer in short.items() if outer == value), None)
    return entry if full is None else {**entry, "value": full}
