"""Functions, classes and modules stay small enough to be read at once; what is larger stands here, with the reason."""

import ast
import io
import tokenize
from collections.abc import Iterator
from typing import NamedTuple

import pytest

MOST = {"function": 40, "class": 80, "module": 400, "parameters": 6, "complexity": 10}
"""Lines of code of each, without docstrings, comments and empty lines; parameters; ways through a function."""


class Size(NamedTuple):
    """One measure of one thing: which thing, which measure, how much."""

    name: str
    measure: str
    amount: int


def code_lines(text: str) -> set[int]:
    """Numbers of the lines that hold more than comments."""
    silent = {tokenize.COMMENT, tokenize.NL, tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT, tokenize.ENDMARKER}
    tokens = tokenize.generate_tokens(io.StringIO(text).readline)
    return {n for t in tokens if t.type not in silent for n in range(t.start[0], t.end[0] + 1)}


def described_lines(tree: ast.AST) -> set[int]:
    """Numbers of the lines that descriptions of modules, classes, functions and values take."""
    texts = (n for n in ast.walk(tree) if isinstance(n, ast.Expr) and isinstance(n.value, ast.Constant))
    return {n for each in texts if isinstance(each.value.value, str) for n in range(each.lineno, each.end_lineno + 1)}


def parameters(function: ast.FunctionDef) -> int:
    """How many arguments a function takes, but for the object that a method belongs to."""
    a = function.args
    named = [each.arg for each in (*a.posonlyargs, *a.args, *a.kwonlyargs)]
    return len(named) - (named[:1] in (["self"], ["cls"])) + bool(a.vararg) + bool(a.kwarg)


BRANCHES = (ast.If, ast.For, ast.While, ast.ExceptHandler, ast.match_case)


def own_nodes(function: ast.AST) -> Iterator[ast.AST]:
    """What stands in a function, but not in functions within it."""
    for child in ast.iter_child_nodes(function):
        if not isinstance(child, ast.FunctionDef | ast.ClassDef):
            yield child
            yield from own_nodes(child)


def complexity(function: ast.FunctionDef) -> int:
    """One more than the statements at which a function may go two ways, as McCabe counts."""
    return 1 + sum(isinstance(node, BRANCHES) for node in own_nodes(function))


def named(node: ast.AST, where: str) -> Iterator[tuple[str, ast.FunctionDef | ast.ClassDef]]:
    for child in ast.iter_child_nodes(node):
        if isinstance(child, ast.FunctionDef | ast.ClassDef):
            yield f"{where}.{child.name}", child
            yield from named(child, f"{where}.{child.name}")
        else:
            yield from named(child, where)


def sizes(text: str, module: str) -> Iterator[Size]:
    """Every measure of a module and of what it defines."""
    tree = ast.parse(text)
    lines = code_lines(text) - described_lines(tree)
    yield Size(module, "module", len(lines))
    for name, each in named(tree, module):
        length = sum(n in lines for n in range(each.lineno, each.end_lineno + 1))
        if isinstance(each, ast.ClassDef):
            yield Size(name, "class", length)
        else:
            yield Size(name, "function", length)
            yield Size(name, "parameters", parameters(each))
            yield Size(name, "complexity", complexity(each))


def excesses(text: str, module: str) -> list[Size]:
    return [size for size in sizes(text, module) if size.amount > MOST[size.measure]]


@pytest.fixture(scope="module")
def too_large(source) -> dict[str, list[Size]]:
    """What exceeds a limit, by its name below vvdp."""
    found: dict[str, list[Size]] = {}
    for path in sorted(source.rglob("*.py")):
        for size in excesses(path.read_text("utf-8"), ".".join(path.relative_to(source).with_suffix("").parts)):
            found.setdefault(size.name, []).append(size)
    return found
