"""The assumed values of a system in words, by the table in which they stand."""

from collections import Counter
from collections.abc import Sequence

from vvdp.base.tables import Sourced

MOST_NAMED = 3
"""So many tables are named; the others are added up."""


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
