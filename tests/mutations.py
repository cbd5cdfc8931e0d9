"""Break laws and messages one at a time, and see which tests notice: `python -m tests.mutations --count 20`.

Works on a clone of the last commit in a temporary folder. Each mutant changes one operator, number, comparison or
message of a function drawn with a fixed seed. The tests of its own package run first, then all others of the
selection, up to the first failure. Exits with 1 if a mutant survives. A survivor may be equivalent to the original:
read it before you write a test.
"""

import argparse
import ast
import os
import random
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).parents[1]
LAWS = ("control", "estimation", "fluid", "hydraulics", "numerics", "sensing", "valve")
MESSAGES = ("base", "network", "simulation", "studies", "systems")
SELECTION = "not slow"
OPERATORS = {ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult}
COMPARISONS = {ast.Lt: ast.Gt, ast.Gt: ast.Lt, ast.LtE: ast.Gt, ast.GtE: ast.Lt, ast.Eq: ast.NotEq, ast.NotEq: ast.Eq}


class Mutant(NamedTuple):
    """A changed text of one file, and the line and expression that changed."""

    path: Path
    line: int
    before: str
    after: str
    text: str


def places(function: ast.AST, messages: bool) -> Iterator[ast.expr]:
    """Nodes of a function that a mutant may change: of its formulas, or of the messages that it raises."""
    for node in ast.walk(function):
        if messages:
            if isinstance(node, ast.Raise) and node.exc is not None:
                yield from (text for text in ast.walk(node.exc) if isinstance(text, ast.expr) and is_sentence(text))
        elif isinstance(node, ast.expr) and is_formula(node):
            yield node


def is_formula(node: ast.AST) -> bool:
    """Whether `change` knows another operator, comparison or number for a node."""
    if isinstance(node, ast.BinOp):
        return type(node.op) in OPERATORS and not is_sentence(node.left)
    if isinstance(node, ast.Compare):
        return len(node.ops) == 1 and type(node.ops[0]) in COMPARISONS
    return isinstance(node, ast.Constant) and isinstance(node.value, float) and node.value != 0.0


def is_sentence(node: ast.AST) -> bool:
    """Whether a node is a text of two words or more."""
    return isinstance(node, ast.Constant) and isinstance(node.value, str) and " " in node.value.strip()


def changed_text(text: str, node: ast.expr) -> tuple[str, str, str] | None:
    """Source of a node, its replacement, and the whole text with it; None if the node is not found in the text."""
    lines = text.splitlines(keepends=True)
    begin = sum(map(len, lines[: node.lineno - 1]))
    if isinstance(node, ast.Constant) and isinstance(node.value, str):
        # A part of an f-string has the position of the whole; the words themselves are unique enough behind it.
        before, after, begin = node.value, " lost ", text.find(node.value, begin)
    else:
        before = ast.get_source_segment(text, node) or ""
        begin = text.find(before, begin + len(lines[node.lineno - 1].encode()[: node.col_offset].decode()))
        after = f"({replacement(node)})"
    return (before, after, text[:begin] + after + text[begin + len(before) :]) if before and begin >= 0 else None


def replacement(node: ast.expr) -> str:
    """Source of a node with another operator, another comparison, or a number that is 10 % larger."""
    if isinstance(node, ast.BinOp):
        node.op = OPERATORS[type(node.op)]()
    elif isinstance(node, ast.Compare):
        node.ops = [COMPARISONS[type(node.ops[0])]()]
    elif isinstance(node, ast.Constant):
        assert isinstance(node.value, float)
        node.value *= 1.1
    return ast.unparse(node)


def functions(package: str) -> Iterator[tuple[Path, int]]:
    """File and number of each function of a package."""
    for path in sorted((ROOT / "src" / "vvdp" / package).rglob("*.py")):
        tree = ast.parse(path.read_text("utf-8"))
        for number, node in enumerate(ast.walk(tree)):
            if isinstance(node, ast.FunctionDef):
                yield path, number


def mutant(chance: random.Random, messages: bool) -> Mutant:
    """A mutant of a function drawn by chance."""
    candidates = [each for package in (MESSAGES if messages else LAWS) for each in functions(package)]
    while True:
        path, number = chance.choice(candidates)
        text = path.read_text("utf-8")
        tree = ast.parse(text)
        function = list(ast.walk(tree))[number]
        found = list(places(function, messages))
        if not found:
            continue
        node = chance.choice(found)
        if made := changed_text(text, node):
            return Mutant(path.relative_to(ROOT), node.lineno, *made)


def killer(clone: Path, changed: Mutant) -> str | None:
    """The first test that fails with the mutant in place; None if all pass."""
    target = clone / changed.path
    original = target.read_text("utf-8")
    package = changed.path.parts[2]
    own = [f"tests/{package}"] if (clone / "tests" / package).is_dir() else []
    rest = sorted(
        f"tests/{path.name}" for path in (clone / "tests").iterdir() if path.is_dir() and path.name != package
    )
    environment = {**os.environ, "PYTHONPATH": str(clone / "src")}
    try:
        target.write_text(changed.text, "utf-8")
        for folders in filter(None, (own, rest)):
            command = [sys.executable, "-m", "pytest", "-x", "-q", "-m", SELECTION, "--no-header", *folders]
            done = subprocess.run(command, cwd=clone, env=environment, capture_output=True, text=True, check=False)
            if done.returncode == 1:
                return next(line for line in done.stdout.splitlines() if line.startswith(("FAILED", "ERROR")))
            if done.returncode not in (0, 5):
                return f"pytest ended with {done.returncode}"
    finally:
        target.write_text(original, "utf-8")
    return None


def main() -> int:
    """Run all mutants and print a line for each. Returns the exit code."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--count", type=int, default=20)
    parser.add_argument("--seed", type=int, default=20261124)
    options = parser.parse_args()
    chance, survivors = random.Random(options.seed), 0
    with tempfile.TemporaryDirectory() as folder:
        clone = Path(folder) / "clone"
        subprocess.run(["git", "clone", "-q", str(ROOT), str(clone)], check=True)
        for number in range(options.count):
            changed = mutant(chance, messages=number % 4 == 3)
            began = time.monotonic()
            found = killer(clone, changed)
            survivors += found is None
            place = f"{changed.path}:{changed.line}"
            print(f"{number + 1:3} {place}  {changed.before!r} -> {changed.after!r}")
            print(f"    {found or 'SURVIVED'}  ({time.monotonic() - began:.0f} s)", flush=True)
    print(f"{options.count - survivors} of {options.count} found")
    return int(survivors > 0)


if __name__ == "__main__":
    sys.exit(main())
