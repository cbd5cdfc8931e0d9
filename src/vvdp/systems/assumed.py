"""The assumed values of a system that have an effect, and how many they are in words, by their table."""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import replace

from vvdp.base.tables import Sourced
from vvdp.components.drives import DRIVE_COUPLING
from vvdp.network.network import Network

MOST_NAMED = 3
"""So many tables are named; the others are added up."""


def assumed_rows(rows: Sequence[Sourced]) -> tuple[Sourced, ...]:
    """The values that are merely assumed and have an effect.

    rows  all values of a system
    """
    values = {row.setting: row.nominal for row in rows}
    return tuple(row for row in rows if row.status == "assumed" and not is_idle(row, values))


def is_idle(row: Sourced, values: Mapping[str, float]) -> bool:
    """Whether a value has no effect because others are 0, as its class declares (`base.params.without_effect`).

    values  of all rows, by table and key [SI]
    """
    return bool(row.idle_at) and all(values.get(setting) == 0.0 for setting in row.idle_at)


def with_idle_speeds(rows: Sequence[Sourced], network: Network) -> list[Sourced]:
    """The rows of a drawn circuit; the speed of a shaft that turns spools through couplings alone is without effect
    while these do not couple."""
    couplings: dict[str, list[str]] = {}
    for part in network.parts.values():
        for port, node in part.nodes.items():
            coupling = f"components.{part.name}.coupling" if (part.component, port) == (DRIVE_COUPLING, "motor") else ""
            couplings.setdefault(f"nodes.{node}.speed", []).append(coupling)
    idle = {speed: tuple(each) for speed, each in couplings.items() if all(each)}
    return [replace(row, idle_at=idle[row.setting]) if row.setting in idle else row for row in rows]


def assumed_words(rows: Sequence[Sourced]) -> str:
    """How many values are assumed, and where most of them stand: "19 assumed values: 16 of the default oil, 3 of load".

    rows  the values that are assumed, of all tables
    """
    if not rows:
        return "no assumed values"
    counts = Counter(map(_group, rows)).most_common()
    named, others = counts[:MOST_NAMED], counts[MOST_NAMED:]
    if len(others) == 1:
        named, others = counts, []
    words = [f"{count} of {name}" for name, count in named]
    if others:
        words.append(f"{sum(count for _, count in others)} of {len(others)} other tables")
    return f"{len(rows)} assumed value{'s' if len(rows) > 1 else ''}: {', '.join(words)}"


def _group(row: Sourced) -> str:
    """The table of a value by the name of its node or component; the values that every oil has by default."""
    name = row.table.rpartition(".")[2].replace("_", " ")
    is_oil = name == "oil" or name.endswith(" oil")
    return f"the default {name}" if is_oil and row.note == "default" else f"the {name}" if is_oil else name
