"""Records are made by name where they have many fields: two numbers that change places are seen by no type checker."""

import ast

import pytest

PACKAGES = ("estimation", "sensing", "numerics", "comparison", "logs", "systems", "network", "components", "studies")
MOST = 5
RECORDS = {"NamedTuple", "Params"}


def is_record(cls: ast.ClassDef) -> bool:
    bases = {ast.unparse(base).split(".")[-1] for base in cls.bases}
    decorators = {ast.unparse(each).split("(")[0].split(".")[-1] for each in cls.decorator_list}
    return bool(bases & RECORDS) or "dataclass" in decorators


@pytest.fixture(scope="module")
def records(source):
    trees = [ast.parse(path.read_text("utf-8")) for path in source.rglob("*.py")]
    return {n.name for tree in trees for n in ast.walk(tree) if isinstance(n, ast.ClassDef) and is_record(n)}


def crowded(tree: ast.AST, records: set[str]):
    """Calls of records with more than `MOST` arguments by position; what is unpacked counts once."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Call) and ast.unparse(node.func).split(".")[-1] in records and len(node.args) > MOST:
            yield node.lineno, ast.unparse(node.func), len(node.args)


@pytest.mark.parametrize("package", PACKAGES)
def test_no_record_is_made_of_a_row_of_numbers(source, records, package):
    found = [
        f"{path.relative_to(source)}:{line}: {name} with {count} arguments by position"
        for path in sorted((source / package).rglob("*.py"))
        for line, name, count in crowded(ast.parse(path.read_text("utf-8")), records)
    ]
    assert not found


def test_a_crowded_call_is_seen():
    tree = ast.parse("Six(1, 2, 3, 4, 5, 6); Six(1, 2, 3, 4, 5, f=6); other(1, 2, 3, 4, 5, 6)")
    assert list(crowded(tree, {"Six"})) == [(1, "Six", 6)]
