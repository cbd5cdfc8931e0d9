# ruff: noqa: E501
"""Faults planted in the writers and in the front end, each of which the tests of the language find."""

import pytest
from tests.generator import programs
from tests.generator.ways import module_of, run, ways_of

from vvdp.generator import llvm_expressions, llvm_statements, llvm_text, python_writer, tree


def swap_branches(original):
    return lambda text, s: original(text, tree.If(s.test, s.otherwise, s.then, s.line))


def lose_value(original):
    """The lost phi: where ways meet, one of the variables keeps its old value."""

    def write(text, s):
        return (
            original(text, tree.Set(s.variables[:-1], s.values[:-1], s.line))
            if len(s.variables) > 1
            else original(text, s)
        )

    return write


def one_by_one(original):
    """Assignments that should happen at once, one after the other."""

    def write(text, s):
        for variable, value in zip(s.variables, s.values, strict=True):
            original(text, tree.Set((variable,), (value,), s.line))

    return write


def towards_zero(original):
    return lambda text, sign, left, right: text.get(f"{'sdiv' if sign == '//' else 'srem'} i64 {left}, {right}")


def swap_operands(original):
    return lambda text, v: original(
        text, type(v)(v.sign, v.right, v.left, *([v.kind] if isinstance(v, tree.Binary) else []))
    )


def unguarded_zero(original):
    return lambda text, v: original(text, tree.Choose(v.test, v.otherwise, v.then))


def one_round_more(original):
    return lambda text, count, last, step, register: original(
        text, count, text.get(f"add i64 {last}, 1"), step, register
    )


def first_field(original):
    return lambda text, v: (
        original(text, tree.Field(v.record, 0, v.kind)) if v.record.kind.fields[0] == v.kind else original(text, v)
    )


def transposed(original):
    return lambda text, array, indexes: original(text, array, indexes[::-1])


def lost_store(original):
    return lambda text, s: None if len(s.indexes) == 2 else original(text, s)


def continue_as_break(original):
    return lambda text, s: text.end(f"br label %{text.loops[-1][0]}")


def no_exhausted(original):
    return lambda text, s: (
        original(text, tree.For(s.variable, s.range, s.body, (), s.line))
        if not ends(s.exhausted)
        else original(text, s)
    )


def ends(block):
    return not llvm_statements.falls_through(block)


def rounded(original):
    return lambda text, v: (
        (
            text.get(
                f"fptosi double {text.call('double', 'llvm.rint.f64', f'double {llvm_expressions.one(text, v.operand)}', 'double')} to i64"
            ),
        )
        if v.kind is llvm_expressions.INT and v.operand.kind is llvm_expressions.FLOAT
        else original(text, v)
    )


def view_from_start(original):
    return lambda text, v: original(text, tree.View(v.array, tree.Constant(llvm_expressions.INT, 0), v.sizes, v.kind))


EXPRESSIONS, STATEMENTS = llvm_expressions.WRITTEN, llvm_statements.WRITTEN
FAULTS = [
    ("swapped branches", STATEMENTS, tree.If, swap_branches),
    ("lost phi", STATEMENTS, tree.Set, lose_value),
    ("assignments one by one", STATEMENTS, tree.Set, one_by_one),
    ("continue leaves the loop", STATEMENTS, tree.Continue, continue_as_break),
    ("a store is lost", STATEMENTS, tree.Store, lost_store),
    ("the else of a loop is lost", STATEMENTS, tree.For, no_exhausted),
    ("a choice the wrong way round", EXPRESSIONS, tree.Choose, unguarded_zero),
    ("operands of a comparison swapped", EXPRESSIONS, tree.Compare, swap_operands),
    ("operands of an operator swapped", EXPRESSIONS, tree.Binary, swap_operands),
    ("the first field for every other", EXPRESSIONS, tree.Field, first_field),
    ("a float rounded, not cut", EXPRESSIONS, tree.Convert, rounded),
    ("a slice from the start", EXPRESSIONS, tree.View, view_from_start),
    ("< for <=", llvm_expressions.ORDERS, "<=", lambda original: "lt"),
    ("> for >=", llvm_expressions.ORDERS, ">=", lambda original: "gt"),
    ("+ for -", llvm_expressions.WHOLE_SIGNS, "-", lambda original: "add"),
    ("a sum for a product", llvm_expressions.FLOAT_SIGNS, "*", lambda original: "fadd"),
    ("or for and", llvm_expressions.WHOLE_SIGNS, "&", lambda original: "or"),
    ("// and % towards zero", llvm_expressions, "_floor", towards_zero),
    ("one round too many", llvm_statements, "_goes_on", one_round_more),
    ("rows for columns", llvm_expressions, "item_address", transposed),
    (
        "a minimum that is a maximum",
        python_writer.EXPRESSED,
        tree.Compare,
        lambda original: lambda v: original(tree.Compare({"<": ">"}.get(v.sign, v.sign), v.left, v.right)),
    ),
    (
        "NaN is equal to itself",
        llvm_text,
        "constant",
        lambda original: lambda kind, value: original(kind, abs(value) if kind is llvm_text.FLOAT else value),
    ),
]


@pytest.mark.sampled(6)
@pytest.mark.parametrize(("words", "place", "name", "fault"), FAULTS, ids=[row[0] for row in FAULTS])
def test_a_planted_fault_is_found(monkeypatch, words, place, name, fault):
    if isinstance(place, dict):
        monkeypatch.setitem(place, name, fault(place[name]))
    else:
        monkeypatch.setattr(place, name, fault(getattr(place, name)))
    assert is_found(), words


def is_found():
    """Whether a test of the language fails."""
    for function, cases in programs.CASES:
        if function is programs.while_loops:  # a fault may let it run for ever
            continue
        try:
            ways = ways_of(module_of(function, cases[0]))
            wrong = any(run(way, values) != run(function, values) for values in cases for way in ways.values())
        except Exception:  # LLVM or the verifier has refused it
            return True
        if wrong:
            return True
    return False
