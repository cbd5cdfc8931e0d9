"""The verdicts that are expected, and those that have changed.

`expected.csv` of each chapter has a line for every statement: its item, what it is about, its verdict.
"""

import csv
import io
from collections.abc import Iterable, Mapping, Sequence
from importlib import resources
from typing import TypeAlias

from vvdp.reproduction.items import CHAPTERS
from vvdp.results.verdict import Statement

FILE = "expected.csv"
HEAD = ("item", "what", "verdict")
Verdicts: TypeAlias = Mapping[tuple[str, str], str]
"""The verdict of each statement, by its item and what it is about."""


def expected_verdicts() -> Verdicts:
    """What the committed lists say."""
    return {
        (row["item"], row["what"]): row["verdict"]
        for chapter in CHAPTERS
        for row in csv.DictReader(io.StringIO(resources.files(chapter).joinpath(FILE).read_text("utf-8")))
    }


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


def expectation_text(verdicts: Verdicts) -> str:
    """The list as a file has it."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(HEAD)
    writer.writerows((item, what, verdict) for (item, what), verdict in verdicts.items())
    return text.getvalue()
