"""Why a function cannot be compiled, in one message."""

import ast
import inspect
import re
import textwrap
import types
from collections.abc import Iterator
from typing import Any

from vvdp.simulation.reach import Functions

BESIDE = r"File |During: |There are |- Of which|Overload|With argument|Rejected|raised from|\^|>>>|def |<source"
TYPING = r"(Unknown|Untyped|Cannot|Unsupported|Invalid|NameError|.*not supported|.*not implemented)"


def reason(problem: Exception, functions: Functions) -> str:
    """What the compiler has to say, without the layers around it: the innermost message, and where it arose."""
    plain = [function for function, _ in functions.values()]
    name = plain[0].__qualname__ if plain else "this"
    begin = f"{name} or a function that it reaches cannot be compiled"
    for left_out in (told for function in plain for told in _left_out(function)):
        return f"{begin}: {left_out}"
    text = re.sub(r"\x1b\[[0-9;]*m", "", str(problem))
    told = [line.strip() for line in text.splitlines()]
    places = [
        place for line in told if (place := re.match(r'File "(.*)", line (\d+)', line)) and "linked.py" not in place[1]
    ]
    causes = [line for line in told if line and not re.match(BESIDE, line)]
    typing = [line for line in causes if re.match(TYPING, line)]
    cause = (typing or causes or [type(problem).__name__])[0 if not typing else -1]
    if isinstance(problem, LookupError | TypeError | AttributeError):
        cause = f"{type(problem).__name__}: {cause}"
    where = f" ({places[0][1]}, line {places[0][2]})" if places else ""
    return f"{begin}: {cause[:300]}{where}"


def _left_out(function: types.FunctionType) -> Iterator[str]:
    """Calls that leave fields of a NamedTuple to their defaults, which compiled code does not fill in."""
    try:
        lines, first = inspect.getsourcelines(function)
        tree = ast.parse(textwrap.dedent("".join(lines)))
    except (OSError, SyntaxError):
        return
    for call in ast.walk(tree):
        if not isinstance(call, ast.Call) or any(isinstance(given, ast.Starred) for given in call.args):
            continue
        cls = _resolve_name(call.func, function)
        fields = getattr(cls, "_fields", ()) if isinstance(cls, type) else ()
        given = {*fields[: len(call.args)], *(keyword.arg for keyword in call.keywords)}
        if missing := [field for field in fields if field not in given]:
            place = f"{function.__code__.co_filename}, line {first + call.lineno - 1}"
            yield f"{ast.unparse(call.func)} is made without {', '.join(missing)}; write every field out ({place})"


def _resolve_name(target: ast.expr, function: types.FunctionType) -> Any:
    if isinstance(target, ast.Attribute):
        return getattr(_resolve_name(target.value, function), target.attr, None)
    return function.__globals__.get(target.id) if isinstance(target, ast.Name) else None
