"""Records are made by name where they have many fields: two numbers that change places are seen by no type checker."""

import ast
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import NamedTuple

import pytest
from tests.contracts.conftest import tree_of

import vvdp

MOST = 5
OWN_ORDER = "an array for each field of the same record, in its own order"
ALLOWED = {
    ("simulation/prepare.py", "Reached"): OWN_ORDER,
    ("estimation/smoother.py", "Forward"): "a row of the record's own numbers, as the compiled replay takes it",
    ("estimation/smoother.py", "Between"): "a row of the columns stacked in its order, as the compiled replay takes it",
}
"""Places, by file and class, with the reason why the order of the fields is known to be right there."""


ROOT = Path(vvdp.__file__).parent


class Crowd(NamedTuple):
    """A call that makes a record of many fields by position."""

    line: int
    record: str
    text: str


Names = dict[str, "ast.ClassDef | tuple[str, str]"]
"""What a file knows: classes that it defines, and what it imports of vvdp, as module and name."""


class Record(NamedTuple):
    """A NamedTuple or dataclass."""

    name: str
    fields: tuple[str, ...]


def names_in(tree: ast.AST) -> Names:
    """What is imported and defined anywhere in a file."""
    names: Names = {}
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and (node.module or "").split(".")[0] == "vvdp":
            names |= {each.asname or each.name: (node.module, each.name) for each in node.names}
        elif isinstance(node, ast.ClassDef):
            names[node.name] = node
    return names


@cache
def names_of(module: str) -> Names:
    """What one of our modules knows; nothing of it is run."""
    path = ROOT.joinpath(*module.split(".")[1:])
    path = path / "__init__.py" if path.is_dir() else path.with_suffix(".py")
    return names_in(tree_of(path)) if path.is_file() else {}


def meaning(name: str, names: Names) -> Record | Names | None:
    """The record or the module that a name stands for; None for all else."""
    match names.get(name):
        case ast.ClassDef() as cls:
            return record(cls, names)
        case (module, inner):
            return meaning(inner, names_of(module)) or names_of(f"{module}.{inner}") or None
    return None


def resolve(node: ast.expr, names: Names) -> Record | Names | None:
    """What `a.b.c` stands for."""
    if isinstance(node, ast.Name):
        return meaning(node.id, names)
    inside = resolve(node.value, names) if isinstance(node, ast.Attribute) else None
    return meaning(node.attr, inside) if isinstance(inside, dict) else None


def record(cls: ast.ClassDef, names: Names) -> Record | None:
    """The fields of a class and its bases; None where it is no record."""
    bases = [found for base in cls.bases if isinstance(found := resolve(base, names), Record)]
    named = any(ast.unparse(base) == "NamedTuple" for base in cls.bases)
    decorated = any(ast.unparse(each).startswith(("dataclass", "dataclasses.")) for each in cls.decorator_list)
    if not (bases or named or decorated or cls.name == "Params"):
        return None
    own = [each.target.id for each in cls.body if isinstance(each, ast.AnnAssign) and isinstance(each.target, ast.Name)]
    return Record(cls.name, (*dict.fromkeys([*(field for base in bases for field in base.fields), *own]),))


def calls(node: ast.AST, owner: str, names: Names) -> Iterator[tuple[ast.Call, Record, bool]]:
    """Each call of a record, and whether by `_make`; `cls` is the class around it."""
    for child in ast.iter_child_nodes(node):
        inside = child.name if isinstance(child, ast.ClassDef) else owner
        if isinstance(child, ast.Call):
            made = isinstance(child.func, ast.Attribute) and child.func.attr == "_make"
            called = child.func.value if made else child.func
            own = isinstance(called, ast.Name) and called.id == "cls"
            found = meaning(inside, names) if own else resolve(called, names)
            if isinstance(found, Record):
                yield child, found, made
        yield from calls(child, inside, names)


def crowded(tree: ast.AST) -> Iterator[Crowd]:
    """Calls that fill more than `MOST` fields by position, one by one, unpacked (`*row`) or by `_make`."""
    for call, called, made in calls(tree, "", names_in(tree)):
        unpacked = made or any(isinstance(argument, ast.Starred) for argument in call.args)
        if len(called.fields) > MOST and (unpacked or len(call.args) > MOST):
            yield Crowd(call.lineno, called.name, ast.unparse(call))


def crowds_of(path: Path) -> list[Crowd]:
    return list(crowded(tree_of(path)))


def packages() -> list[str]:
    return sorted({path.parent.name for path in ROOT.glob("*/__init__.py")})


@pytest.mark.parametrize("package", packages())
def test_no_record_is_made_of_a_row_of_numbers(source, package):
    found = [
        f"{path.relative_to(source)}:{crowd.line}: {crowd.text}"
        for path in sorted((source / package).rglob("*.py"))
        for crowd in crowds_of(path)
        if (str(path.relative_to(source)), crowd.record) not in ALLOWED
    ]
    assert not found


def test_each_exception_is_still_needed(source):
    used = {(file, crowd.record) for file, _ in ALLOWED for crowd in crowds_of(source / file)}
    assert used == set(ALLOWED)


FILE = """
class Six(NamedTuple):
    a: float; b: float; c: float; d: float; e: float; f: float

@dataclass(frozen=True)
class Five:
    a: float; b: float; c: float; d: float; e: float

@dataclass
class Seven(Five):
    f: float
    g: float = 0.0

class Two(NamedTuple):
    a: float; b: float

class Free:
    a: float; b: float; c: float; d: float; e: float; f: float

"""


@pytest.mark.parametrize(
    "line",
    [
        "Six(1, 2, 3, 4, 5, 6)",
        "Six(*row)",
        "Six(1, *row)",
        "Six._make(row)",
        "Seven(1, 2, 3, 4, 5, 6)",
        "f(Six(*row))",
        "class Own(Seven):\n  def make(cls): return cls(1, 2, 3, 4, 5, 6)",
        "from vvdp.valve.operating_point import OperatingPoint as P\nP(*row)",
        "from vvdp.valve import operating_point as where\nwhere.OperatingPoint(*row)",
    ],
)
def test_a_crowded_call_is_found(line):
    assert len(list(crowded(ast.parse(FILE + line)))) == 1


@pytest.mark.parametrize(
    "line",
    [
        "Six(1, 2, 3, 4, 5, f=6)",
        "Six(**row)",
        "Two(*row)",
        "Two._make(row)",
        "Five(*row)",
        "Free(1, 2, 3, 4, 5, 6)",
        "other(1, 2, 3, 4, 5, 6)",
        "six.Six(1, 2, 3, 4, 5, 6)",
    ],
)
def test_other_calls_are_not_found(line):
    assert not list(crowded(ast.parse(FILE + line)))
