"""Items worked out in this process."""

import ast
import operator
import re
from collections.abc import Callable

import pytest

from vvdp.reproduction.expectation import expected_rows, expected_verdicts, verdict_changes, verdicts_of
from vvdp.reproduction.items import chosen_items
from vvdp.results.verdict import Statement

OPERATORS = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.Pow: operator.pow,
}
PLACE = re.compile(r"(below )?(\([2-6]\.\d+\)( to \([2-6]\.\d+\))?|[1-7](\.\d+)+|abstract)[^:]*: .")
"""A printed statement with its place: an equation, a section or the abstract."""


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
        return verdict_changes(found, expected_verdicts(), [name])

    return check
