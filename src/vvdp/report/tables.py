"""The values of a system with their origin, as HTML."""

from collections.abc import Iterator, Mapping
from types import MappingProxyType
from typing import Any

from vvdp.base.display import value_and_unit
from vvdp.base.signal import Signal
from vvdp.base.tables import Sourced
from vvdp.report.html import group, row, table, text
from vvdp.report.references import Reference
from vvdp.systems.system import System

Cells = tuple[str, str]
"""Value and unit of a parameter as HTML."""


def parameter_table(
    system: System, known: Mapping[str, Reference], ready: Mapping[str, Cells] = MappingProxyType({})
) -> str:
    """All parameters with their origin, grouped by table; `ready` has the cells of some by their setting."""
    head = ["Parameter", "Value", "Unit", "Status", "Source", "Where", "Note"]
    return table(head, _parameter_rows(system, known, ready, len(head)), (1,), "values")


def assumed_table(system: System) -> str:
    """The parameters that are merely assumed; on paper only where they are marked."""
    rows = (
        row(
            [
                f'<span class="keys">{_breaking(r.table)}.<wbr>{_breaking(r.key)}</span>',
                *_value(system, r),
                text(r.remark),
            ],
            ("", "n", "u", "q"),
        )
        for r in system.assumptions
    )
    listed = table(["Parameter", "Value", "Unit", "Why"], rows, (1,))
    return f'<div class="on-screen">{listed}</div>\n<p class="on-paper">They are marked assumed under Parameters.</p>'


def _parameter_rows(
    system: System, known: Mapping[str, Reference], ready: Mapping[str, Cells], columns: int
) -> Iterator[str]:
    before = ""
    for r in system.rows:
        if r.table != before:
            yield group(text(r.table.replace("_", " ")), columns)
            before = r.table
        status = f'<span class="assumed">{r.status}</span>' if r.status == "assumed" else text(r.status)
        cells = [
            f'<span class="keys">{_breaking(r.key)}</span>',
            *(ready.get(r.setting) or _value(system, r)),
            status,
            _cite(r.source, known),
            text(r.where),
            text(r.remark),
        ]
        yield row(cells, ("", "n", "u", "", "", "q", "q"))


def _breaking(key: str) -> str:
    return text(key).replace("_", "_<wbr>")


def _value(system: System, r: Sourced) -> Cells:
    absolute = _is_absolute(system, r)
    if isinstance(r.value, Signal) and not r.value.is_constant:
        (low, unit), (high, _) = (value_and_unit(v, r.kind, absolute=absolute) for v in r.value.extremes)
        return f"{text(low)} to {text(high)}", text(unit) + " (changes)"
    if isinstance(r.value, tuple):
        both = [value_and_unit(value, r.kind, absolute=absolute) for value in r.value]
        return text(", ".join(value for value, _ in both)), text(both[0][1] if both else "")
    value, unit = value_and_unit(r.value.base if isinstance(r.value, Signal) else r.value, r.kind, absolute=absolute)
    return text(value), text(unit)


def _is_absolute(system: System, given: Sourced) -> bool:
    """Whether a pressure level was written as an absolute one."""
    entry: Any = system.content
    for key in (*given.table.split("."), given.key):
        entry = entry.get(key, "") if isinstance(entry, dict) else ""
    return "bara" in str(entry) or "psia" in str(entry)


def _cite(key: str, known: Mapping[str, Reference]) -> str:
    return f'<a href="#ref-{text(key)}">{text(key)}</a>' if key in known else text(key)
