"""Messages speak the user's names and units: no class of Python, no SI number with another unit in files, one wording.

The texts are collected where they are written: what is raised, and what goes into a fault. Numbers of values pass
through `base.rules` and `base.display`, which know the unit of each kind.
"""

import ast
import re
from collections.abc import Iterable, Iterator

import pytest
from tests.contracts.conftest import tree_of

CALLS = {"refuse", "refuse_rows", "refuse_together", "Fault", "fault", "fault_at", "unusable", "FieldError"}
"""Functions that are handed a message, besides what is raised."""
FOR_CODE = ("base/params.py", "base/rules.py", "generator/", "network/", "simulation/", "results/store.py")
"""Modules whose messages are about classes, functions and SI numbers that someone wrote in Python."""
CLASS = re.compile(r"\A[A-Z]\w+(?:\.\w|\.\{|: )|type\((?:self|values|cls)\)\.__name__")
SI = re.compile(r"\{[^{}]*:[^{}]*g\} ?(?:Pa|m|m\^[23]|m\^3/s|rad|rad/s|rad\^2)(?![\w^/*²³])")
WORDINGS = {
    r"\b(?:above|over|more than|larger than|exceeds?|exceed) (?:0|zero)\b|\bgreater than zero\b": "greater than 0",
    r"\bpositive\b(?! definite)": "greater than 0",
    r"\b(?:is|are) not (?:above|below|less|greater|more)\b|\bnot below\b": "must be greater than, must be at least",
    r"\bdo(?:es)? not exceed\b": "must be greater than",
    r"\b(?:of|number) from \d+ on\b|\b\d+ or more\b": "at least",
}


def text_of(node: ast.expr) -> str:
    """A message as it is written, with what is filled in between braces."""
    match node:
        case ast.Constant(value=str(text)):
            return text
        case ast.JoinedStr(values=parts):
            return "".join(map(text_of, parts))
        case ast.FormattedValue(value=value, format_spec=spec):
            return "{" + ast.unparse(value) + (f":{text_of(spec)}" if spec else "") + "}"
        case ast.BinOp(left=left, op=ast.Add(), right=right):
            return text_of(left) + text_of(right)
        case ast.IfExp(body=one, orelse=other):
            return f"{text_of(one)} | {text_of(other)}"
    return ""


def messages(tree: ast.Module) -> Iterator[tuple[int, str]]:
    """Line and text of each message of a module."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) in ("message", "rule", "fault"):
            yield node.lineno, text_of(node.value)
        calls = [node.exc] if isinstance(node, ast.Raise) else [node] if isinstance(node, ast.Call) else []
        for call in calls:
            if not isinstance(call, ast.Call):
                continue
            if isinstance(node, ast.Raise) or ast.unparse(call.func).rpartition(".")[2] in CALLS:
                yield from ((each.lineno, text_of(each)) for each in call.args if text_of(each))


def faults(name: str, found_in: Iterable[tuple[int, str]]) -> list[str]:
    found = []
    for line, text in found_in:
        if not name.startswith(FOR_CODE):
            found += [f"{name}:{line}: names a class: {text}"] if CLASS.search(text) else []
            found += [f"{name}:{line}: an SI number: {text}"] if SI.search(text) else []
        found += [f"{name}:{line}: say {use!r}: {text}" for rule, use in WORDINGS.items() if re.search(rule, text)]
    return found


def test_messages_speak_the_users_names_and_units(source):
    found, count = [], 0
    for path in sorted(source.rglob("*.py")):
        own = list(messages(tree_of(path)))
        found += faults(path.relative_to(source).as_posix(), own)
        count += len(own)
    assert not found, "\n".join(found)
    assert count > 500


@pytest.mark.parametrize(
    "line",
    [
        'raise ParameterError(f"Orifice.area: {self.area:g} mm^2")',
        'raise ParameterError(f"{type(self).__name__}.area")',
        'raise ParameterError("Orifice: area and length")',
        'raise ParameterError(f"area: {self.pressure:g} Pa")',
        'fault_at(origin, path, f"{v:.3g} rad/s is too fast")',
        'Fault("a", 0, "", "expected a value above zero")',
        'refuse(self, "area", "does not exceed the other")',
        'raise ConfigError([Fault("a", 0, "", "expected 2 or more")])',
    ],
)
def test_a_bad_message_is_found(line):
    assert faults("hydraulics/orifice.py", messages(ast.parse(line)))


@pytest.mark.parametrize(
    "line",
    [
        'refuse(self, "area", "must be greater than 0")',
        'raise ParameterError(f"a rate of {rate:g} Hz; expected at least 2 Hz")',
        'raise NetworkError(f"{name}: {component.__class__}")',
    ],
)
def test_a_good_message_is_left_alone(line):
    assert not faults("hydraulics/orifice.py", messages(ast.parse(line)))
