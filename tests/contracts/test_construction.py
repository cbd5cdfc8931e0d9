"""Records are made by name where they have many fields: two numbers that change places are seen by no type checker."""

import ast
import dataclasses
import importlib
from collections.abc import Iterator, Mapping
from pathlib import Path
from types import SimpleNamespace
from typing import Any, NamedTuple

import pytest

import vvdp

MOST = 5
TO_BE_NAMED = ("rigs", "design", "report", "cli", "logs")
"""Packages whose records are not yet all made by name; this list is to become empty."""
OWN_ORDER = "an array for each field of the same record, in its own order"
ALLOWED = {
    ("simulation/prepare.py", "Reached"): OWN_ORDER,
    ("simulation/batch.py", "Reached"): OWN_ORDER,
    ("estimation/smoother.py", "Forward"): "a row of the record's own numbers, as the compiled replay takes it",
}
"""Places, by file and class, with the reason why the order of the fields is known to be right there."""


class Crowd(NamedTuple):
    """A call that makes a record of many fields by position."""

    line: int
    record: str
    text: str


def fields_of(found: Any) -> tuple[str, ...]:
    """The fields of a NamedTuple or dataclass; none of anything else."""
    if not isinstance(found, type):
        return ()
    if dataclasses.is_dataclass(found):
        return tuple(field.name for field in dataclasses.fields(found))
    return tuple(getattr(found, "_fields", ()))


def resolve(node: ast.expr, known: Mapping[str, Any]) -> Any:
    """What `a.b.c` means where the names `known` are; None where that shows only when it runs."""
    if isinstance(node, ast.Name):
        return known.get(node.id)
    if isinstance(node, ast.Attribute):
        return getattr(resolve(node.value, known), node.attr, None)
    return None


def imported(tree: ast.AST) -> dict[str, Any]:
    """What a file imports of vvdp within its functions as well."""
    return {
        each.asname or each.name: getattr(importlib.import_module(node.module), each.name, None)
        for node in ast.walk(tree)
        if isinstance(node, ast.ImportFrom) and node.module and node.module.startswith("vvdp")
        for each in node.names
    }


def calls(node: ast.AST, owner: Any, known: Mapping[str, Any]) -> Iterator[tuple[ast.Call, Any]]:
    """Each call with what it calls; `cls` is the class around it."""
    for child in ast.iter_child_nodes(node):
        inside = known.get(child.name) if isinstance(child, ast.ClassDef) else owner
        if isinstance(child, ast.Call):
            yield child, resolve(child.func, {**known, "cls": inside})
        yield from calls(child, inside, known)


def crowded(tree: ast.AST, known: Mapping[str, Any]) -> Iterator[Crowd]:
    """Calls that fill more than `MOST` fields by position, one by one, unpacked (`*row`) or by `_make`."""
    for call, called in calls(tree, None, known):
        made = getattr(called, "__name__", "") == "_make"
        record = getattr(called, "__self__", None) if made else called
        count = len(fields_of(record))
        unpacked = made or any(isinstance(argument, ast.Starred) for argument in call.args)
        if count > MOST and (unpacked or len(call.args) > MOST):
            yield Crowd(call.lineno, record.__name__, ast.unparse(call))


def crowds_of(path: Path, source: Path) -> list[Crowd]:
    name = ".".join(("vvdp", *path.relative_to(source).with_suffix("").parts)).removesuffix(".__init__")
    tree = ast.parse(path.read_text("utf-8"))
    return list(crowded(tree, imported(tree) | vars(importlib.import_module(name))))


def packages() -> list[str]:
    return sorted({path.parent.name for path in Path(vvdp.__file__).parent.glob("*/__init__.py")} - {*TO_BE_NAMED})


@pytest.mark.parametrize("package", packages())
def test_no_record_is_made_of_a_row_of_numbers(source, package):
    found = [
        f"{path.relative_to(source)}:{crowd.line}: {crowd.text}"
        for path in sorted((source / package).rglob("*.py"))
        for crowd in crowds_of(path, source)
        if (str(path.relative_to(source)), crowd.record) not in ALLOWED
    ]
    assert not found


def test_each_exception_is_still_needed(source):
    used = {(file, crowd.record) for file, _ in ALLOWED for crowd in crowds_of(source / file, source)}
    assert used == set(ALLOWED)


class Six(NamedTuple):
    a: float
    b: float
    c: float
    d: float
    e: float
    f: float


@dataclasses.dataclass
class Seven:
    a: float
    b: float
    c: float
    d: float
    e: float
    f: float
    g: float = 0.0


class Two(NamedTuple):
    a: float
    b: float


@pytest.mark.parametrize(
    "text",
    [
        "Six(1, 2, 3, 4, 5, 6)",
        "Six(*row)",
        "Six(1, *row)",
        "Six._make(row)",
        "here.Six(1, 2, 3, 4, 5, 6)",
        "Seven(1, 2, 3, 4, 5, 6)",
        "class Six:\n def make(cls): return cls(1, 2, 3, 4, 5, 6)",
        "alias(1, 2, 3, 4, 5, 6)",
        "f(Six(*row))",
    ],
)
def test_a_crowded_call_is_found(text):
    known = {"Six": Six, "Seven": Seven, "alias": Six, "here": SimpleNamespace(Six=Six)}
    assert [crowd.record for crowd in crowded(ast.parse(text), known)] in (["Six"], ["Seven"])


@pytest.mark.parametrize(
    "text", ["Six(1, 2, 3, 4, 5, f=6)", "Six(**row)", "Two(*row)", "Two._make(row)", "other(1, 2, 3, 4, 5, 6)"]
)
def test_other_calls_are_not_found(text):
    assert not list(crowded(ast.parse(text), {"Six": Six, "Two": Two, "other": max}))
