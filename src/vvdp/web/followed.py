"""Numbers of a report that follow a run in the browser: cells of its listings, and values beside parts of its diagrams.

A listing is made once more from a summary of other numbers, no two alike: what a cell then shows shows its key.
"""

import random
from collections.abc import Iterator, Mapping
from dataclasses import replace
from math import isfinite
from typing import Any

from vvdp.base.display import display_unit
from vvdp.base.kinds import Kind
from vvdp.report.circuit import figure_of, graph_of
from vvdp.report.diagram import laid_out
from vvdp.report.report import DIAGRAM, diagram_values, lines_of
from vvdp.results.result import Result
from vvdp.runs.result import loss_listings, number_listings
from vvdp.runs.run import RecordedRun

POWER = "power_"
PUT_IN, GIVEN = "put_in", "given_out"
"""Sums of powers that a page forms: those into the circuit, and those out of it."""
KEPT = ("averaged_", "duration_", "wall_time_")
"""Beginnings of keys whose numbers do not follow: words depend on them, or they show nothing of the system."""


def unit_of(kind: Kind) -> dict[str, Any]:
    """How a number of a kind is shown, as JSON has it."""
    unit = display_unit(kind)
    return {"symbol": unit.symbol, "scale": unit.scale, "datum": unit.datum}


def followed_cells(run: RecordedRun, result: Result) -> dict[str, list[list[Any]]]:
    """The cells of each listing that show a number of the summary: row, place among its values, key, value and unit."""
    tags = _tags(run.summary)
    known = {value: key for key, value in tags.items()} | _powers(tags)
    other = replace(run, summary={**run.summary, **tags})
    tagged = number_listings(other) | loss_listings(other)
    found = {
        name: [
            [place, at, known[cell], value if isinstance(value, float) and isfinite(value) else None, unit_of(row.kind)]
            for place, (row, other) in enumerate(zip(listing.rows, tagged[name].rows, strict=True))
            for at, (value, cell) in enumerate(zip(row.values, other.values, strict=True))
            if row.kind is not None and isinstance(cell, float) and cell in known
        ]
        for name, listing in result.listings.items()
        if name in tagged and len(tagged[name].rows) == len(listing.rows)
    }
    return {name: cells for name, cells in found.items() if cells}


def _tags(summary: Mapping[str, float | bool]) -> dict[str, Any]:
    """Another number for each that follows, no two alike, some of them negative."""
    chance = random.Random(1)
    numbers = [key for key, value in summary.items() if not isinstance(value, bool) and not key.startswith(KEPT)]
    return {key: chance.uniform(1.0, 2.0) * chance.choice((-1.0, 1.0)) for key in numbers}


def _powers(tags: Mapping[str, float]) -> dict[float, str]:
    powers = [value for key, value in tags.items() if key.startswith(POWER)]
    into, out = sum(p for p in powers if p > 0.0), -sum(p for p in powers if p < 0.0)
    return {total: name for total, name in ((into, PUT_IN), (out, GIVEN)) if total}


def followed_texts(run: RecordedRun) -> dict[str, list[list[Any]]]:
    """The values in each diagram, by figure: place among its lines of text, the text, words before, key and unit."""
    found = {figure: list(_texts(run, part)) for figure, part in diagrams(run)}
    return {name: texts for name, texts in found.items() if texts}


def diagrams(run: RecordedRun) -> Iterator[tuple[str, str]]:
    """The figure of each circuit diagram, with the part that it shows; no part for the whole circuit."""
    yield DIAGRAM, ""
    yield from ((figure_of(part), part) for part in run.network.circuits)


def _texts(run: RecordedRun, part: str) -> Iterator[list[Any]]:
    values = diagram_values(run)
    made = laid_out(graph_of(run.network, "", part), lines_of(values))
    labels = [*((piece.name, piece.label) for piece in made.pieces), *made.names.items()]
    place = 0
    for name, label in labels:
        for line in label.lines:
            for each in values.get(name, ()):
                if each.text in line:
                    yield [place, each.text, each.words, each.key, unit_of(each.kind)]
            place += 1
