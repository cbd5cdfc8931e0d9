"""Expectations of each row, fixed before: its verdict, its kind of evidence, the arithmetic of its tolerance.

`expected.csv` of each chapter has a line for every statement: its item, what it is about, its verdict, what it rests
on, and the width of its tolerance in SI units as arithmetic.
"""

import csv
import io
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from functools import cache
from importlib import resources
from typing import NamedTuple, TypeAlias

import numpy as np

from vvdp.reproduction.items import CHAPTERS
from vvdp.results.result import Column, Table
from vvdp.results.verdict import Evidence, Statement, Verdict, verdict_table

VERDICTS = "verdicts"
"""Name of the table of all statements."""

FILE = "expected.csv"
HEAD = ("item", "what", "verdict", "evidence", "width")
INDEPENDENT = (Evidence.SIMULATED, Evidence.COMPUTED)
"""What is compared with printed numbers and could have failed."""


class Expected(NamedTuple):
    """What is expected of a row; `evidence` is empty for a row that is in no list."""

    verdict: str = ""
    evidence: str = ""
    width: str = ""

    @property
    def is_drawing(self) -> bool:
        """Whether the row states nothing that could hold or fail."""
        return self.verdict == Verdict.DRAWING.value

    @property
    def is_independent(self) -> bool:
        """Whether the row compares a result with a printed number, and could have failed."""
        return self.evidence in INDEPENDENT

    def source(self, statement: Statement) -> str:
        """What stands in the source's column: the number of an identity is not printed, it is what a formula gives."""
        is_number = self.evidence == Evidence.IDENTITY and statement.source_text and not statement.source
        return f"by its formula {statement.source_text}" if is_number else statement.source_text

    def reason(self, statement: Statement) -> str:
        """Why the tolerance of a row is what it is, with its arithmetic."""
        return ": ".join(filter(None, (statement.because, self.width))) or "no tolerance"


Key: TypeAlias = tuple[str, str]
Verdicts: TypeAlias = Mapping[Key, str]
"""The verdict of each statement, by its item and what it is about."""


@cache
def expected_rows() -> Mapping[Key, Expected]:
    """What the committed lists say, by item and what a statement is about."""
    return {
        (row["item"], row["what"]): Expected(row["verdict"], row["evidence"], row["width"])
        for chapter in CHAPTERS
        for row in csv.DictReader(io.StringIO(resources.files(chapter).joinpath(FILE).read_text("utf-8")))
    }


def kind_of(item: str, statement: Statement) -> Expected:
    """What the committed lists say of a statement; empty for one that is in no list."""
    return expected_rows().get((item, statement.what), Expected())


def stated_table(statements: Sequence[tuple[str, Statement]]) -> Table:
    """The table of verdicts with the kind of each statement, and only what the source prints in its column."""
    table = verdict_table(statements)
    kinds = [kind_of(item, each) for item, each in statements]
    sources = [kind.source(each) for kind, (_, each) in zip(kinds, statements, strict=True)]
    own = {"evidence": [kind.evidence for kind in kinds], "source": sources}
    labels = {"evidence": "kind", "source": "source"}
    made = {name: Column(np.array(texts, str), None, labels[name]) for name, texts in own.items()}
    order = ("item", "what", "evidence", "source", "found", "tolerance", "tolerance_source", "verdict", "remark")
    columns = {**table.columns, **made}
    return replace(table, columns={name: columns[name] for name in order})


def expected_verdicts() -> Verdicts:
    """The verdicts of the committed lists."""
    return {key: row.verdict for key, row in expected_rows().items()}


def verdicts_of(statements: Iterable[tuple[str, Statement]]) -> Verdicts:
    """What was found, by item and statement."""
    return {(item, each.what): each.verdict.value for item, each in statements}


def verdict_changes(found: Verdicts, expected: Verdicts, items: Sequence[str]) -> list[str]:
    """A sentence for each statement of the `items` whose verdict is another than expected, or that came or went."""
    lines = []
    for item, what in dict.fromkeys([*found, *expected]):
        before, now = expected.get((item, what)), found.get((item, what))
        if item in items and before != now:
            lines.append(f"{item}, {what}: {now or 'not stated any more'}; expected {before or 'no such statement'}")
    return lines


def expectation_text(rows: Mapping[Key, Expected]) -> str:
    """The list as a file has it."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(HEAD)
    writer.writerows((*key, *row) for key, row in rows.items())
    return text.getvalue()
