"""Plain Python functions read from their source text, and the refusal of what the language does not have."""

import ast
import hashlib
import inspect
import linecache
import time
import types
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

from vvdp.base.errors import VvdpError


class LanguageError(VvdpError):
    """A function uses what the language does not have: file and line, the construct, and what to write instead."""

    def __init__(self, construct: str, advice: str) -> None:
        super().__init__(construct, advice)
        self.construct, self.advice = construct, advice
        self.file, self.line, self.function = "", 0, ""

    def locate(self, file: str, line: int, function: str) -> None:
        """Notes where the construct stands; the innermost place is kept."""
        if not self.file:
            self.file, self.line, self.function = file, line, function

    def __str__(self) -> str:
        where = f"{self.file}:{self.line}: " if self.file else ""
        within = f" (in {self.function})" if self.function else ""
        return f"{where}{self.construct}{within}; {self.advice}"


def known_text(text: str, name: str) -> str:
    """A name for `text` that is in no file, such as a cell of a notebook; functions compiled under it can be read."""
    file = f"<{name} {hashlib.sha256(text.encode()).hexdigest()[:16]}>"
    linecache.cache[file] = (len(text), None, text.splitlines(keepends=True), file)
    return file


@dataclass(frozen=True)
class Source:
    """The text of a function and the names that it can see."""

    function: types.FunctionType
    name: str
    node: ast.FunctionDef
    file: str
    names: Mapping[str, object]


def read_source(function: Any) -> Source:
    """The source of a plain function. Raises LanguageError where there is none that can be read."""
    plain = inspect.unwrap(function)
    if not isinstance(plain, types.FunctionType):
        raise LanguageError(f"{function!r} is called", "write a plain function at the top level of a module")
    code = plain.__code__
    name = plain.__qualname__
    if code.co_freevars:
        raise LanguageError(f"{name} closes over {', '.join(code.co_freevars)}", "hand the values over as arguments")
    lines = tuple(linecache.getlines(code.co_filename))
    node = _functions(code.co_filename, lines).get(code.co_firstlineno)
    if node is not None and not _is_current(code, lines):
        raise LanguageError(f"{code.co_filename} has changed since it was imported", "start again")
    if node is None or node.name != code.co_name:
        what = "a lambda" if code.co_name == "<lambda>" else f"no source text for {name}"
        error = LanguageError(what, "define the function with `def` in a file")
        error.locate(code.co_filename, code.co_firstlineno, name)
        raise error
    return Source(plain, name, node, code.co_filename, plain.__globals__)


@lru_cache(maxsize=512)
def _functions(file: str, lines: tuple[str, ...]) -> dict[int, ast.FunctionDef]:
    """By the line on which it begins, decorators included, each function of a file."""
    found = {}
    for node in ast.walk(ast.parse("".join(lines), file)):
        if isinstance(node, ast.FunctionDef):
            found[min([node.lineno, *(each.lineno for each in node.decorator_list)])] = node
    return found


_STARTED = time.time()
MARGIN = 60.0
"""Files older by so much than this module in memory have not changed since they were imported [s]."""


def _is_current(code: types.CodeType, lines: tuple[str, ...]) -> bool:
    """Whether the text of a function is that of its code; it is not where a file has changed under a process."""
    try:
        changed = Path(code.co_filename).stat().st_mtime
    except OSError:  # text that no file holds
        return True
    if changed < _STARTED - MARGIN:
        return True
    return any(_is_same(code, other) for other in _codes(code.co_filename, lines))


@lru_cache(maxsize=64)
def _codes(file: str, lines: tuple[str, ...]) -> list[types.CodeType]:
    """The code of every function of a file as it is now."""
    found = [compile("".join(lines), file, "exec")]
    for each in found:
        found += [constant for constant in each.co_consts if isinstance(constant, types.CodeType)]
    return found


def _is_same(one: types.CodeType, other: types.CodeType) -> bool:
    parts = ("co_name", "co_firstlineno", "co_code", "co_names", "co_varnames", "co_consts")
    return all(getattr(one, part) == getattr(other, part) for part in parts)


def stored_names(statements: list[ast.stmt]) -> set[str]:
    """The names that statements assign."""
    nodes = (node for each in statements for node in ast.walk(each))
    return {node.id for node in nodes if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store)}


def leaves_loop(statements: list[ast.stmt]) -> bool:
    """Whether statements hold a `break` or `continue` of the loop around them."""
    for each in statements:
        if isinstance(each, ast.Break | ast.Continue):
            return True
        if isinstance(each, ast.For | ast.While):
            if leaves_loop(each.orelse):
                return True
        elif any(leaves_loop(getattr(each, part, [])) for part in ("body", "orelse")):
            return True
    return False
