"""`vvdp show`."""

from typing import TYPE_CHECKING, Any

from vvdp.cli.options import AsJson, Settings, SystemName

if TYPE_CHECKING:
    from vvdp.base.tables import Sourced
    from vvdp.systems.system import System


def show(system: SystemName, settings: Settings = None, json: AsJson = False) -> None:
    """Show all values of a system, with status and source.

    Pressure levels are shown gauge and absolute.
    """
    from vvdp.cli.screen import print_json
    from vvdp.systems.system import load_system

    loaded = load_system(system, settings or ())
    if json:
        print_json(_content(loaded))
    else:
        _print(loaded)


def _content(system: "System") -> dict[str, Any]:
    parameters = {f"{row.table}.{row.key}": _entry(row) for row in system.rows}
    assumed = [f"{row.table}.{row.key}" for row in system.assumed]
    return {
        "system": system.name,
        "title": system.title,
        "circuit": system.circuit,
        "assumed": assumed,
        "parameters": parameters,
    }


def _entry(row: "Sourced") -> dict[str, Any]:
    """A value as a program reads it: SI, a pressure level absolute; `value` is null where it changes over time."""
    if isinstance(row.value, float):
        low = high = row.value
    else:
        low, high = row.value.extremes
    return {
        "value": low if low == high else None,
        "low": low,
        "high": high,
        "unit": row.kind.unit,
        "kind": row.kind.name,
        "shown": row.displayed,
        "status": row.status,
        "source": row.source,
        "where": row.where,
        "note": row.note,
    }


def _print(system: "System") -> None:
    from vvdp.cli.screen import console, grid

    out = console()
    out.print(f"{system.title}\n{system.name}, circuit {system.circuit}\n")
    tables = dict.fromkeys(row.table for row in system.rows)
    for name in tables:
        table = grid("key", "value", "status", "source", "note", title=f"[{name}]")
        for row in system.rows:
            if row.table == name:
                source = ", ".join(part for part in (row.source, row.where) if part)
                table.add_row(row.key, row.displayed, row.status, source, row.note)
        out.print(table)
    assumed = system.assumed
    out.print(f"{len(assumed)} of {len(system.rows)} values are assumed:", style="bold")
    out.print(", ".join(f"{row.table}.{row.key}" for row in assumed) or "none", soft_wrap=True)
