# ruff: noqa: ARG002, E501
"""Random programs of the language, well defined by construction, and a minimiser for those that fail.

Whole numbers are kept small by a remainder, indexes within their array, loops short, and no division is by zero. Only
operations with one exact result are used, so all ways must agree to the last bit.
"""

import ast
import linecache
import random
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from tests.generator.ways import all_ways, module_with, run

ARGUMENTS = (1.5, -0.75, 5, -3, True, np.array([0.5, -2.0, 3.25, 8.0]))
"""What every program is called with: x, y, m, n, ok, row."""
HEAD = "def program(x, y, m, n, ok, row):\n    u, v, k, flag = 0.5, x, 1, not ok\n    pair = (x, n)\n"
TAIL = "    return x, y, u, v, m, n, k, flag, ok, pair\n"
FLOATS, WHOLES, TRUTHS = ("x", "y", "u", "v"), ("m", "n", "k"), ("ok", "flag")
LEAST = 3


class Writer:
    """A program under construction."""

    def __init__(self, seed: int) -> None:
        self.draw = random.Random(seed)
        self.lines: list[str] = []

    def program(self) -> str:
        """The text of a program."""
        self.block(1, self.draw.randint(3, 8), loop=False)
        return HEAD + "".join(f"{line}\n" for line in self.lines) + TAIL

    def block(self, depth: int, count: int, *, loop: bool) -> None:
        for _ in range(count):
            self.statement(depth, loop=loop)

    def statement(self, depth: int, *, loop: bool) -> None:
        kinds = ["float", "whole", "truth", "store", "pair", "swap", "augmented"]
        if depth < 4:
            kinds += ["if", "if", "for", "while"]
        if loop:
            kinds += ["leave"]
        getattr(self, f"write_{self.draw.choice(kinds)}")(depth, loop)

    def put(self, depth: int, text: str) -> None:
        self.lines.append("    " * depth + text)

    def write_float(self, depth: int, loop: bool) -> None:
        self.put(depth, f"{self.draw.choice(FLOATS)} = {self.number(2)}")

    def write_whole(self, depth: int, loop: bool) -> None:
        self.put(depth, f"{self.draw.choice(WHOLES)} = {self.whole(2)}")

    def write_truth(self, depth: int, loop: bool) -> None:
        self.put(depth, f"{self.draw.choice(TRUTHS)} = {self.truth(2)}")

    def write_store(self, depth: int, loop: bool) -> None:
        self.put(depth, f"row[{self.whole(1)} % 4] = {self.number(2)}")

    def write_pair(self, depth: int, loop: bool) -> None:
        self.put(depth, f"pair = ({self.number(1)}, {self.whole(1)})")

    def write_swap(self, depth: int, loop: bool) -> None:
        a, b = self.draw.sample(FLOATS, 2)
        self.put(depth, f"{a}, {b} = {b}, {a}")

    def write_augmented(self, depth: int, loop: bool) -> None:
        if self.draw.random() < 0.5:
            self.put(depth, f"{self.draw.choice(FLOATS)} {self.draw.choice('+-*')}= {self.number(1)}")
        else:
            self.put(depth, f"row[1:3] *= {self.number(1)}")

    def write_if(self, depth: int, loop: bool) -> None:
        self.put(depth, f"if {self.truth(2)}:")
        self.block(depth + 1, self.draw.randint(1, 3), loop=loop)
        if self.draw.random() < 0.6:
            self.put(depth, "else:")
            self.block(depth + 1, self.draw.randint(1, 3), loop=loop)

    def write_for(self, depth: int, loop: bool) -> None:
        limits = self.draw.choice(["m % 6", "k % 5", "3", "m % 7, -2, -1", "n % 3, 9, 2"])
        over = self.draw.choice(
            [f"i{depth} in range({limits})", f"i{depth} in range({limits})", f"e{depth} in (x, y, u)"]
        )
        self.put(depth, f"for {over}:")
        self.block(depth + 1, self.draw.randint(1, 3), loop=True)
        if over.startswith("e"):
            self.put(depth + 1, f"v = v - e{depth}")
        else:
            self.put(depth + 1, f"k = (k + i{depth}) % 1009")
        if self.draw.random() < 0.3:
            self.put(depth, "else:")
            self.block(depth + 1, 1, loop=loop)

    def write_while(self, depth: int, loop: bool) -> None:
        self.put(depth, f"c{depth} = 0")
        self.put(depth, f"while c{depth} < 5 and {self.truth(1)}:")
        self.put(depth + 1, f"c{depth} += 1")
        self.block(depth + 1, self.draw.randint(1, 3), loop=True)

    def write_leave(self, depth: int, loop: bool) -> None:
        self.put(depth, f"if {self.truth(1)}:")
        self.put(depth + 1, self.draw.choice(["break", "continue", "return x, y, u, v, m, n, k, flag, ok, pair"]))

    def number(self, depth: int) -> str:
        if depth == 0:
            return self.draw.choice(
                [*FLOATS, "pair[0]", f"row[{self.draw.randint(-4, 3)}]", "0.25", "-1.5", "3.0", "0.0"]
            )
        a, b, c = (self.number(depth - 1) for _ in range(3))
        return self.draw.choice(
            [
                f"({a} + {b})", f"({a} - {b})", f"({a} * {b}) * 0.125", f"{a} / (abs({b}) + 1.0)", f"min({a}, {b})",
                f"max({a}, {b}, {c})", f"({a} if {self.truth(depth - 1)} else {b})", f"np.floor({a})", f"abs({a})",
                f"float({self.whole(depth - 1)})", f"-{a}", f"np.sqrt(abs({a}))", f"({a} // 0.75)", f"({a} % 1.5)",
                f"({a} + {self.whole(depth - 1)})", f"row[{self.whole(depth - 1)} % 4]", f"{a} ** 2 * 0.5", a,
            ]
        )  # fmt: skip

    def whole(self, depth: int) -> str:
        if depth == 0:
            return self.draw.choice([*WHOLES, "pair[1]", "2", "-7", "0", "11"])
        a, b = self.whole(depth - 1), self.whole(depth - 1)
        return self.draw.choice(
            [
                f"({a} + {b}) % 1009", f"({a} - {b}) % 513", f"({a} * {b}) % 1009", f"({a} // 3)", f"({a} % 7)",
                f"({a} // -({b} % 5 + 1))", f"({a} % -({b} % 4 + 1))", f"min({a}, {b})", f"max({a}, {b})", f"-({a} % 100)",
                f"({a} if {self.truth(depth - 1)} else {b})", f"abs({a})", f"({a} & 255)", f"({a} ^ {b}) % 999", a,
                f"int({self.truth(depth - 1)})", f"len((1, {b}))",
            ]
        )  # fmt: skip

    def truth(self, depth: int) -> str:
        if depth == 0:
            return self.draw.choice([*TRUTHS, "True"])
        sign = self.draw.choice(["<", "<=", ">", ">=", "==", "!="])
        a, b = self.truth(depth - 1), self.truth(depth - 1)
        return self.draw.choice(
            [
                f"({self.number(depth - 1)} {sign} {self.number(depth - 1)})",
                f"({self.whole(depth - 1)} {sign} {self.whole(depth - 1)})",
                f"({a} and {b})", f"({a} or {b})", f"(not {a})", f"(0.0 < {self.number(depth - 1)} <= 2.0)", f"({a} | {b})",
            ]
        )  # fmt: skip


def random_program(seed: int) -> str:
    """The text of a program that `seed` names."""
    return Writer(seed).program()


def function_of(text: str) -> Callable[..., Any]:
    """The function `program` of a text."""
    name = f"<program {abs(hash(text))}>"
    linecache.cache[name] = (len(text), None, text.splitlines(keepends=True), name)
    known: dict[str, Any] = {"np": np}
    exec(compile(text, name, "exec"), known)
    found: Callable[..., Any] = known["program"]
    return found


def failures(texts: dict[str, str]) -> dict[str, str]:
    """By the names of programs, the way in which they give other bits than CPython; what agrees is left out."""
    functions = {name: function_of(text) for name, text in texts.items()}
    module = module_with(functions, ARGUMENTS)
    ways = all_ways(module)
    found = {}
    for name, function in functions.items():
        expected = run(function, ARGUMENTS)
        wrong = [way for way, entries in ways.items() if run(entries[name], ARGUMENTS) != expected]
        if wrong:
            found[name] = ", ".join(wrong)
    return found


def minimised(text: str, fails: Callable[[str], bool]) -> str:
    """A program that still fails and has no statement that may be left out."""
    shorter = True
    while shorter:
        shorter = False
        for candidate in reductions(text):
            if fails(candidate):
                text, shorter = candidate, True
                break
    return text


def reductions(text: str) -> Iterator[str]:
    """The program without one of its statements, or with one replaced by what is in it."""
    count = len(list(_blocks(ast.parse(text))))
    for number in range(count):
        size = len(list(_blocks(ast.parse(text)))[number])
        for place in reversed(range(size)):
            tree = ast.parse(text)
            block = list(_blocks(tree))[number]
            if _counts(block[place]):
                continue
            inner = [*getattr(block[place], "body", []), *getattr(block[place], "orelse", [])]
            for other in ([], inner) if inner else ([],):
                kept = [*block[:place], *other, *block[place + 1 :]]
                original = list(block)
                block[:] = kept or [ast.Pass()]
                if isinstance(tree.body[0], ast.FunctionDef) and tree.body[0].body:
                    yield ast.unparse(tree) + "\n"
                block[:] = original


def _counts(statement: ast.stmt) -> bool:
    """Whether a statement is what ends a `while`, without which it would run for ever."""
    target = statement.target if isinstance(statement, ast.AugAssign) else None
    return isinstance(target, ast.Name) and target.id.startswith("c")


def _blocks(tree: ast.AST) -> Iterator[list[ast.stmt]]:
    for node in ast.walk(tree):
        for part in ("body", "orelse"):
            block = getattr(node, part, None)
            if isinstance(block, list) and block and not isinstance(node, ast.Module):
                yield block
