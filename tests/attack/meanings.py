"""Whether a file was read as what stands in it, held against a sound file of which it was made.

Two texts mean the same if, and only if, they say the same: what differs in anything but comments and blanks must be
refused or show in what was read, and what differs in these alone must not. A number that is another one by a factor,
with the unit that it had, is read as another one by that factor.
"""

import json
import math
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from vvdp.base.kinds import PRESSURE_LEVEL, TEMPERATURE
from vvdp.studies.study import Study
from vvdp.systems.system import System

QUANTITY = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*(.*?)\s*\Z", re.DOTALL)
LEVELS = (PRESSURE_LEVEL, TEMPERATURE)
"""Kinds that have units whose zero is none."""


@dataclass(frozen=True)
class Meaning:
    """A text as a tree, what was read from it by name, and its numbers [SI] by their place in the tree."""

    tree: Any
    read: Mapping[str, str]
    numbers: Mapping[str, float]


def system_meaning(tree: Any, system: System) -> Meaning:
    """What a system file says, and all that `system` has of it."""
    network, rows = system.circuit.network, {row.setting: row for row in system.rows}
    read = {f"row {key}": repr(row) for key, row in rows.items()}
    read |= {
        "title": system.title,
        "circuit": system.circuit.text,
        "case": repr(system.case),
        "stepping": repr((system.stepping, system.average_from)),
        "places": repr(network.positions),
        "programs": repr([(each.reads, each.period, each.phase, each.latency) for each in network.programs.values()]),
        "tables": repr(system.tables),
        "faults": repr(system.faults),
        "shape": repr(system.lengths),
    }
    numbers = {key: row.value for key, row in rows.items() if isinstance(row.value, float) and row.kind not in LEVELS}
    return Meaning(tree, read, numbers)


def study_meaning(tree: Any, study: Study, systems: Sequence[System]) -> Meaning:
    """What a study file says: its cases, and what `systems` came of the first of them."""
    cases = {f"case {number}": repr(case) for number, case in enumerate(study.cases)}
    read = cases | {"study": repr((study.system, study.outputs, study.settings, study.until, study.title))}
    read |= {f"system {number}": repr(system.case) for number, system in enumerate(systems)}
    return Meaning(tree, read, {})


def columns_meaning(cells: Mapping[str, Sequence[str]], columns: Mapping[str, Sequence[float]]) -> Meaning:
    """What a table says: its cells, and the columns that were read [SI]."""
    return Meaning(
        {name: list(held) for name, held in cells.items()},
        {name: repr(list(held)) for name, held in columns.items()},
        {},
    )


def misreading(sound: Meaning, other: Meaning) -> str:
    """What of `other` was read as something else than stands there; empty if nothing was."""
    said = dict(_leaves(sound.tree)), dict(_leaves(other.tree))
    differing = sorted(key for key in said[0].keys() | said[1].keys() if said[0].get(key) != said[1].get(key))
    read = [key for key in sound.read.keys() | other.read.keys() if sound.read.get(key) != other.read.get(key)]
    if read and not differing and list(said[0]) == list(said[1]):
        return f"it says the same, and is read otherwise: {', '.join(sorted(read)[:3])}"
    if differing and not read:
        return f"says something else, and is read the same: {', '.join(differing[:3])}"
    for key in differing:
        place = key.removesuffix(".value")
        if place in sound.numbers and place in other.numbers and key in said[0] and key in said[1]:
            (before, unit), (after, new_unit) = said[0][key], said[1][key]
            if unit == new_unit and math.isfinite(before) and before and math.isfinite(after):
                expected = sound.numbers[place] * after / before
                if not math.isclose(other.numbers[place], expected, rel_tol=1e-9, abs_tol=1e-12):
                    return f"{place} is read as {other.numbers[place]!r}; expected {expected!r}"
    return ""


def _leaves(tree: Any, path: str = "") -> Iterator[tuple[str, tuple[float, str]]]:
    """Path, number and unit of every entry; of text that is no quantity the text in place of the unit."""
    if isinstance(tree, dict | list) and tree:
        for key, value in tree.items() if isinstance(tree, dict) else enumerate(tree):
            yield from _leaves(value, f"{path}.{key}" if path else str(key))
    elif isinstance(tree, str):
        match = QUANTITY.match(tree)
        yield path, (float(match[1]), " ".join(match[2].split())) if match else (math.inf, " ".join(tree.split()))
    elif isinstance(tree, int | float) and not isinstance(tree, bool):
        yield path, (float(tree) if abs(tree) < 1e300 else math.inf, "" if abs(tree) < 1e300 else repr(tree))
    else:
        yield path, (math.inf, json.dumps(tree, default=str))
