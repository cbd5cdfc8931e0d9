"""Items worked out in this process."""

import ast
import math
import operator
import re
from collections.abc import Callable
from functools import cache
from pathlib import Path

import pytest

from vvdp.reproduction.expectation import expected_rows, expected_verdicts, kind_of, verdict_changes, verdicts_of
from vvdp.reproduction.items import chosen_items
from vvdp.results.verdict import Statement, Verdict

OPERATORS = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.Pow: operator.pow,
}
PLACE = re.compile(r"(below )?(\([2-6]\.\d+\)( to \([2-6]\.\d+\))?|[1-7](\.\d+)+|abstract)[^:]*: .")
"""A printed statement with its place: an equation, a section or the abstract."""
NUMBER = re.compile(r"(?<![\w.])-?\d+(?:\.\d+)?")
DOCS = Path(__file__).parents[2] / "docs"


def arithmetic(text: str) -> float:
    """What a text of numbers and operations comes to."""

    def value(node: ast.expr) -> float:
        if isinstance(node, ast.Constant) and isinstance(node.value, int | float):
            return float(node.value)
        assert isinstance(node, ast.BinOp), text
        return float(OPERATORS[type(node.op)](value(node.left), value(node.right)))

    return value(ast.parse(text, mode="eval").body)


@pytest.fixture(scope="session")
def width_of() -> Callable[[str], float]:
    return arithmetic


def check_reason(item: str, statement: Statement) -> None:
    """The words of a tolerance give exactly its width; a contradiction names two places."""
    width = expected_rows()[item, statement.what].width
    assert bool(width) == bool(statement.tolerance), statement.what
    if width:
        assert statement.because, f"{statement.what}: no reason"
        assert arithmetic(width) == pytest.approx(statement.tolerance, rel=1e-3), statement.what
    for printed in statement.contradiction or ():
        assert PLACE.match(printed), printed
    check_excuses(statement)


def check_excuses(statement: Statement) -> None:
    """A row that is reproduced can fail, and nothing would excuse it: neither a contradiction nor a second run."""
    if statement.verdict is Verdict.REPRODUCED:
        assert math.isfinite(statement.low) or math.isfinite(statement.high), statement.what
        assert statement.contradiction is None and statement.other is None, statement.what
    assert statement.other is None or statement.assumption, statement.what


def plain(cell: str) -> str:
    """A cell of a page without what Markdown asks for."""
    return cell.replace("\\|", "|").replace("`", "").replace("−", "-").strip()


def check_page(item: str, statement: Statement) -> None:
    """The page of the chapter shows source, result and remark as they are calculated, their numbers to 2 %."""
    texts = (kind_of(item, statement).source(statement), statement.found_text, statement.remark)
    for cell, text in zip(page_rows()[item, plain(statement.what)], map(plain, texts), strict=True):
        assert NUMBER.sub("#", cell) == NUMBER.sub("#", text), statement.what
        found = [float(number) for number in NUMBER.findall(text)]
        assert [float(number) for number in NUMBER.findall(cell)] == pytest.approx(found, rel=0.02), statement.what


@cache
def page_rows() -> dict[tuple[str, str], tuple[str, str, str]]:
    """Source, result and remark of each row of the pages of the reproduction, by item and what it is about."""
    rows, item = {}, ""
    for page in sorted((DOCS / "reproduction").glob("chapter-*.md")):
        for line in page.read_text("utf-8").splitlines():
            if line.startswith("## "):
                item = line.removeprefix("## ").partition(":")[0]
            cells = [plain(cell) for cell in re.split(r"(?<!\\)\|", line.strip("|"))]
            if len(cells) == 7 and cells[5].startswith("*"):
                rows[item, cells[0]] = cells[2], cells[3], cells[6]
    return rows


@pytest.fixture(scope="session")
def as_expected() -> Callable[[str], list[str]]:
    """Works an item out; a sentence for each of its verdicts that is another than expected."""

    def check(name: str) -> list[str]:
        (item,) = chosen_items([name])
        statements = item.work().statements
        found = verdicts_of((name, statement) for statement in statements)
        assert len(found) == len(statements), "two statements of one name"
        for statement in statements:
            check_reason(name, statement)
            check_page(name, statement)
        return verdict_changes(found, expected_verdicts(), [name])

    return check
