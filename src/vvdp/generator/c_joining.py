"""A pass over the tree that joins short steps into the expressions that people would write."""

import re
from collections import Counter
from dataclasses import fields, replace
from typing import Any

from vvdp.generator import tree
from vvdp.generator.c_scopes import expressions_in, has_effect, reads_in
from vvdp.generator.kinds import Row
from vvdp.generator.llvm_statements import inner_blocks, statements_in
from vvdp.generator.verify import OPERANDS, statement_operands

UNNAMED = re.compile(r"(v|x|i|count)_\d+_?$")
"""Names that steps have which the Python text gives none."""
LONGEST = 14
"""Parts of an expression up to which it is joined with others."""


def join_steps(function: tree.Function) -> tree.Function:
    """The function without steps that have no name, are used once, and whose use comes next."""
    uses = Counter(
        variable
        for statement in statements_in(function.body)
        for variable in reads_in(tuple(statement_operands(statement)))
    )
    return replace(function, body=_block(function.body, uses))


def _block(block: tree.Block, uses: Counter[tree.Variable]) -> tuple[tree.Statement, ...]:
    done: list[tree.Statement] = []
    waiting: dict[tree.Variable, tree.Let] = {}  # steps that may yet become part of what comes next
    for statement in block:
        read = set(reads_in(tuple(statement_operands(statement))))
        keeps_all = isinstance(statement, tree.Let) and not has_effect(statement.value)
        values = {variable: let.value for variable, let in waiting.items() if variable in read}
        for variable, let in list(waiting.items()):
            if not UNNAMED.match(variable.name) and not isinstance(statement, tree.Set):
                values.pop(variable, None)
            elif variable not in read and keeps_all:
                continue
            if variable not in values:
                done.append(let)
            del waiting[variable]
        found = _with_inner(_substitute(statement, values), uses)
        if isinstance(found, tree.Let) and _may_join(found, uses):
            waiting[found.variable] = found
        else:
            done.append(found)
    return (*done, *waiting.values())


def _may_join(statement: tree.Let, uses: Counter[tree.Variable]) -> bool:
    """Whether a step may become part of another: what has a name is kept, unless it is a variable's next value."""
    variable, value = statement.variable, statement.value
    if uses[variable] != 1 or isinstance(variable.kind, Row) or isinstance(value, tree.Room):
        return False
    return not has_effect(value) and sum(1 for _ in expressions_in(value)) <= LONGEST


def _with_inner(statement: tree.Statement, uses: Counter[tree.Variable]) -> tree.Statement:
    if not inner_blocks(statement):
        return statement
    names = [each.name for each in fields(statement) if each.name in ("then", "otherwise", "body", "exhausted")]
    changes: dict[str, Any] = {name: _block(getattr(statement, name), uses) for name in names}
    return replace(statement, **changes)


def _substitute(statement: tree.Statement, values: dict[tree.Variable, tree.Expression]) -> tree.Statement:
    """A statement with values in place of variables that it reads itself, not in statements within."""
    if not values or not statement_operands(statement):
        return statement
    own = set(map(id, statement_operands(statement)))
    changes: dict[str, Any] = {}
    for each in fields(statement):
        inner = getattr(statement, each.name)
        if id(inner) in own:
            changes[each.name] = _with(inner, values)
        elif isinstance(inner, tuple) and any(id(part) in own for part in inner):
            changes[each.name] = tuple(_with(part, values) for part in inner)
    return replace(statement, **changes)


def _with(value: tree.Expression, values: dict[tree.Variable, tree.Expression]) -> tree.Expression:
    """An expression with values in place of variables."""
    if isinstance(value, tree.Read):
        return values.get(value.variable, value)
    changes: dict[str, Any] = {}
    for name in OPERANDS[type(value)]:
        inner = getattr(value, name)
        if isinstance(inner, tuple):
            changes[name] = tuple(None if part is None else _with(part, values) for part in inner)
        else:
            changes[name] = _with(inner, values)
    return replace(value, **changes) if changes else value
