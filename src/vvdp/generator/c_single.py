"""A module of the tree as C99 in single precision: the text of `c_writer` with `float` for `double`.

Every operation is done in single precision, literals and functions of the C library included. Numbers that follow from
the digits of a double, such as the parts of a quarter of a turn, are those of a float. So that no number is lost
without a message, literals that a float cannot hold are refused.
"""

import ast
import linecache
import math
import re

import numpy as np

from vvdp.generator import elementary
from vvdp.generator.c_scopes import expressions_in
from vvdp.generator.c_writer import CModule
from vvdp.generator.kinds import FLOAT
from vvdp.generator.library import C_LIBRARY, EXACT
from vvdp.generator.llvm_statements import statements_in
from vvdp.generator.source import LanguageError
from vvdp.generator.tree import Constant, Function, Module, Table
from vvdp.generator.verify import statement_operands

LEAST, MOST = (float(getattr(np.finfo(np.float32), name)) for name in ("tiny", "max"))
"""The smallest float with all of its digits, and the largest."""

SHORTER = {
    elementary.ROUNDING: 1.5 * 2.0**23,
    **dict(zip(elementary.QUARTERS, (1.5703125, 4.837512969970703e-04, 7.549789948768648e-08, 0.0), strict=True)),
    elementary.HALF_PI_LOW: -4.371139000186241e-08,
    elementary.SPLIT: 2.0**12 + 1.0,
}
"""Values in single precision of numbers that follow from the digits of a double.

Source  Cody and Waite, Software Manual for the Elementary Functions (1980): a quarter of a turn in 8, 11 and 24 bits
"""
_FUNCTIONS = {*C_LIBRARY, *EXACT, "fma"}
_TOKENS = re.compile(
    r"""(?P<apart>/\*.*?\*/|"[^"\n]*"|\#include[^\n]*)
    |(?P<number>(?<![\w.])(?:\d+\.\d*(?:[eE][-+]?\d+)?|\d+[eE][-+]?\d+)(?![\w.]))
    |(?P<word>(?<![\w.>])[A-Za-z_]\w*)""",
    re.DOTALL | re.VERBOSE,
)


def single_text(text: str) -> str:
    """C text in single precision: types, literals and functions of the C library; comments and strings stay."""

    def in_single(found: re.Match[str]) -> str:
        whole = found[0]
        if found["apart"]:
            return whole
        if found["number"]:
            shorter = SHORTER.get(float(whole))
            return f"{whole if shorter is None else repr(shorter)}f"
        if whole == "double":
            return "float"
        return f"{whole}f" if whole in _FUNCTIONS and text[found.end() : found.end() + 1] == "(" else whole

    return _TOKENS.sub(in_single, text)


def single_module(made: CModule) -> CModule:
    """A written module in single precision."""
    flags = [f"{flag}f" if flag.removeprefix("-fno-builtin-") in _FUNCTIONS else flag for flag in made.flags]
    return CModule(
        header=single_text(made.header),
        source=single_text(made.source),
        functions=made.functions,
        flags=tuple(flags),
        needs=made.needs,
        types=made.types,
    )


def fits_single(number: float) -> bool:
    """Whether a float holds a number with all digits of its precision."""
    return number == 0.0 or not math.isfinite(number) or LEAST <= abs(number) <= MOST


def require_single(module: Module) -> None:
    """Raises LanguageError, with file and line, where a literal is one that a float cannot hold."""
    for function in module.functions:
        for statement in statements_in(function.body):
            for operand in statement_operands(statement):
                for each in expressions_in(operand):
                    numbers = each.numbers if isinstance(each, Table) else ()
                    numbers = (each.value,) if isinstance(each, Constant) and each.kind is FLOAT else numbers
                    for number in numbers:
                        if not fits_single(number):
                            raise _refusal(function, number)


def _refusal(function: Function, number: float) -> LanguageError:
    """The error of a literal of a function that a float cannot hold."""
    error = LanguageError(
        f"{number!r} is no number of single precision", f"write one from {LEAST:.2g} to {MOST:.2g}, 0 or infinity"
    )
    nodes = ast.walk(ast.parse("".join(linecache.getlines(function.file))))
    whole = next((n for n in nodes if isinstance(n, ast.FunctionDef) and n.lineno == function.line), None)
    literals = (n for n in ast.walk(whole) if isinstance(n, ast.Constant)) if whole else ()
    line = next((n.lineno for n in literals if n.value in (number, -number)), function.line)  # else of the module
    error.locate(function.file, line, whole.name if whole else function.name)
    return error
