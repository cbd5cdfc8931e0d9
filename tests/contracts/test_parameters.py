"""A parameter of several numbers is a record with names, but for points and spans, whose order everybody knows."""

import ast
from collections.abc import Iterator

import pytest
from tests.contracts.conftest import tree_of

POINTS_AND_SPANS = {
    "block.growth": "along x, y and z",
    "uniform.value": "along x, y and z",
    "grid_convergence.sizes": "one for each of three grids, from fine to coarse",
    "grid_convergence.values": "one for each of three grids, from fine to coarse",
    "scenarios.temperatures": "least and greatest",
    "_temperature.ends": "least and greatest",
    "_spread.ends": "least and greatest",
    "_around.span": "least and greatest",
    "_heard_parts.gaps": "begin and end of each",
    "add_gaps.gaps": "begin and end of each",
    "_add_standstills.found": "begin and end of each",
    "silences.standstills": "begin and end of each",
    "measure.start": "x and y",
    "measure.end": "x and y",
    "measure.off": "x and y",
    "_free.size": "x and y",
    "_cut.segment": "x and y of both ends",
    "largest_jump.places": "begin and end of two spans",
    "_jump.places": "begin and end of two spans",
    "checked_steps.steps": "before and after",
    "dynamics.steps": "before and after",
    "_bode_panel.ends": "least and greatest",
    "lowest_cavitation_number.angles": "least and greatest",
    "smallest_openings.angles": "least and greatest",
}
"""Tuples of floats that may stay, with the order of their numbers."""


def holds_like_floats(annotation: ast.expr) -> bool:
    """Whether an annotation has a tuple of fixed length with more than one float."""
    if isinstance(annotation, ast.Constant) and isinstance(annotation.value, str):
        annotation = ast.parse(annotation.value, mode="eval").body
    tuples = (n for n in ast.walk(annotation) if isinstance(n, ast.Subscript) and ast.unparse(n.value) == "tuple")
    entries = ([ast.unparse(each) for each in n.slice.elts] for n in tuples if isinstance(n.slice, ast.Tuple))
    return any(each.count("float") > 1 and "..." not in each for each in entries)


def nameless(tree: ast.AST) -> Iterator[str]:
    """Parameters of functions that are tuples of like floats."""
    for function in (n for n in ast.walk(tree) if isinstance(n, ast.FunctionDef)):
        a = function.args
        for each in (*a.posonlyargs, *a.args, *a.kwonlyargs):
            if each.annotation is not None and holds_like_floats(each.annotation):
                yield f"{function.name}.{each.arg}"


def test_numbers_have_names(source):
    found = {name for path in source.rglob("*.py") for name in nameless(tree_of(path))}
    assert found == {*POINTS_AND_SPANS}


@pytest.mark.parametrize(
    ("annotation", "is_found"),
    [
        ("tuple[float, float]", True),
        ("'tuple[Phase, float, float] | None'", True),
        ("list[tuple[float, float]]", True),
        ("tuple[float, ...]", False),
        ("tuple[Phase, float]", False),
        ("Target", False),
    ],
)
def test_a_nameless_tuple_would_be_seen(annotation, is_found):
    assert list(nameless(ast.parse(f"def f(x: {annotation}): pass"))) == (["f.x"] if is_found else [])
