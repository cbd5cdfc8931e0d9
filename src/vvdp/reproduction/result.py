"""All verdicts as one result."""

from collections import Counter
from collections.abc import Sequence
from typing import Any, TypeAlias

import numpy as np

from vvdp.base.kinds import COUNT
from vvdp.reproduction.expectation import VERDICTS, kind_of, stated_table
from vvdp.reproduction.runner import VERB, Outcome, all_statements
from vvdp.results.result import Column, Finding, Grade, Number, Result, Table
from vvdp.results.verdict import Evidence, Statement, Verdict

Rows: TypeAlias = Sequence[tuple[str, Statement]]
"""Statements, each under the name of its item."""


def _count_words(count: int, noun: str) -> str:
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"


def stop_finding(missing: Sequence[str]) -> tuple[Finding, ...]:
    """That a run was stopped, and the items that it lacks; nothing if none is `missing`."""
    if not missing:
        return ()
    text = f"{_count_words(len(missing), 'item')} missing: {', '.join(missing)}."
    return (Finding(text=text, grade=Grade.BAD, title="Stopped"),)


def verdict_result(
    outcomes: Sequence[Outcome], changes: Sequence[str], seconds: float, missing: Sequence[str] = ()
) -> Result:
    """The table of all verdicts, how many there are of each, and what differs from what is expected.

    `missing` names the items that were asked for and not calculated, since the run was stopped.
    """
    statements = all_statements(outcomes)
    counts = Counter(each.verdict for _, each in statements)
    words = ", ".join(f"{counts[verdict]} {verdict.value}" for verdict in Verdict if counts[verdict])
    failures = [f"{each.item.name} failed: {each.failure}" for each in outcomes if each.failure]
    numbers = {
        f"{verdict.name.lower()}_count": Number(float(counts[verdict]), COUNT, f"statements: {verdict.value}")
        for verdict in Verdict
    }
    return Result(
        verb=VERB,
        title="The dissertation, item by item",
        system="wang2017",
        references=("wang2017",),
        tables={"chapters": chapter_table(outcomes), VERDICTS: stated_table(statements)},
        numbers={"item_count": Number(float(len(outcomes)), COUNT, "items"), **numbers, **evidence_counts(statements)},
        findings=(
            *stop_finding(missing),
            Finding(
                text=f"{_count_words(len(outcomes), 'item')}, {_count_words(len(statements), 'statement')}: {words}."
            ),
            Finding(text=headline(statements)),
            *(Finding(text=text, grade=Grade.BAD) for text in failures),
            *(Finding(text=text, grade=Grade.BAD, title="Verdict changed") for text in changes),
        ),
        seconds=seconds,
        finished=not missing,
    )


def evidence_counts(statements: Rows) -> dict[str, Number]:
    """How many statements of each kind there are, drawings left out; and of those that compare a result with a
    printed number, how many there are and how many are reproduced."""
    kinds = [(kind_of(item, each), each.verdict) for item, each in statements]
    counts = Counter(kind.evidence for kind, verdict in kinds if verdict is not Verdict.DRAWING)
    independent = [verdict for kind, verdict in kinds if kind.is_independent]
    return {
        **{
            f"{each.name.lower()}_evidence_count": Number(float(counts[each.value]), COUNT, f"kind: {each.value}")
            for each in Evidence
        },
        "independent_count": Number(float(len(independent)), COUNT, "simulated or computed, against a printed number"),
        "independent_reproduced_count": Number(
            float(independent.count(Verdict.REPRODUCED)), COUNT, "of which reproduced"
        ),
    }


def headline(statements: Rows) -> str:
    """How many results stand against printed numbers and could have failed, and how many of them are reproduced."""
    counts = evidence_counts(statements)
    total, held = (int(counts[f"independent{each}_count"].value) for each in ("", "_reproduced"))
    text = f"{_count_words(total, 'simulated or computed number')} compared with printed numbers that could have failed"
    return f"{text}: {held} reproduced."


def chapter_table(outcomes: Sequence[Outcome]) -> Table:
    """How many statements of each chapter have each verdict."""
    chapters = sorted({each.item.chapter for each in outcomes})
    found = Counter((each.item.chapter, s.verdict) for each in outcomes for _, s in each.statements)
    columns = {"chapter": Column(np.array([str(chapter) for chapter in chapters]), None, "chapter")}
    for verdict in Verdict:
        counts = np.array([float(found[chapter, verdict]) for chapter in chapters])
        columns[verdict.name.lower()] = Column(counts, COUNT, verdict.value)
    return Table(title="Verdicts by chapter", columns=columns)


def json_rows(outcomes: Sequence[Outcome]) -> list[dict[str, Any]]:
    """Every statement as one object: numbers in SI units, words where the source has no number."""
    return [_json_row(item, each) for item, each in all_statements(outcomes)]


def _json_row(item: str, each: Statement) -> dict[str, Any]:
    kind = kind_of(item, each)
    return {
        "item": item,
        "what": each.what,
        "source_value": each.low if each.low == each.high else each.source_text,
        "vvdp_value": each.found if each.found == each.found and not each.result else each.found_text,
        "unit": "" if each.is_drawing else each.kind.unit,
        "tolerance": each.tolerance,
        "tolerance_source": each.because,
        "evidence": kind.evidence,
        "reason": kind.reason(each),
        "verdict": each.verdict.value,
        "remark": each.remark,
    }
