"""A pass over the tree that joins short steps into the expressions that people would write."""

import re
from collections import Counter
from collections.abc import Set
from dataclasses import fields, replace
from typing import Any

from vvdp.generator import tree
from vvdp.generator.c_scopes import expressions_in, has_effect, reads_in
from vvdp.generator.kinds import Record, Row
from vvdp.generator.llvm_statements import statements_in
from vvdp.generator.verify import OPERANDS, statement_operands

UNNAMED = re.compile(r"(v|x|i|count)_\d+_?$")
"""Names that steps have which the Python text gives none."""
LONGEST = 14
"""Parts of an expression up to which it is joined with others; records are joined always, and so not copied."""


def join_steps(module: tree.Module) -> tree.Module:
    """The module without steps that have no name, are used once, and whose use comes next."""
    done: dict[tree.Function, tree.Function] = {}
    quiet = set[tree.Function]()
    for function in module.functions:
        if all(_changes_nothing(each, quiet) for each in statements_in(function.body)):
            quiet.add(function)
        uses = Counter(
            variable
            for statement in statements_in(function.body)
            for variable in reads_in(tuple(statement_operands(statement)))
        )
        again = {v for each in statements_in(function.body) if isinstance(each, tree.Set) for v in each.variables}
        done[function] = replace(function, body=_Joining(uses, again, done, quiet).block(function.body))
    return replace(module, functions=tuple(done.values()))


def _changes_nothing(statement: tree.Statement, quiet: Set[tree.Function]) -> bool:
    """Whether a statement writes to no array that others have, and cannot fail."""
    if isinstance(statement, tree.Store | tree.Fail):
        return False
    return all(is_quiet(each, quiet) for each in statement_operands(statement))


def is_quiet(value: tree.Expression, quiet: Set[tree.Function]) -> bool:
    """Whether an expression changes no array and cannot fail: all that it calls is known for it."""
    return not any(
        isinstance(each, tree.CallAddress | tree.CallIntrinsic | tree.Room)
        or (isinstance(each, tree.Call) and each.function not in quiet)
        for each in expressions_in(value)
    )


class _Joining:
    """The pass over one function: how often each variable is read, and which are assigned more than once.

    functions   those that took the place of others
    quiet       those that change no array and cannot fail, so that steps may be taken after them
    """

    def __init__(
        self,
        uses: Counter[tree.Variable],
        again: set[tree.Variable],
        functions: dict[tree.Function, tree.Function],
        quiet: Set[tree.Function],
    ) -> None:
        self.uses, self.again, self.functions, self.quiet = uses, again, functions, quiet
        self.aliases: dict[tree.Variable, tree.Expression] = {}  # records that are a field of another, not copied

    def block(self, block: tree.Block) -> tuple[tree.Statement, ...]:
        done: list[tree.Statement] = []
        waiting: dict[tree.Variable, tree.Let] = {}  # steps that may yet become part of what comes next
        for statement in block:
            values = self.ready(statement, waiting, done)
            found = self.with_inner(self.substitute(statement, values))
            if isinstance(found, tree.Let) and self.is_alias(found.value):
                self.aliases[found.variable] = found.value
            elif isinstance(found, tree.Let) and self.may_join(found):
                waiting[found.variable] = found
            else:
                done.append(found)
        return (*done, *waiting.values())

    def ready(
        self, statement: tree.Statement, waiting: dict[tree.Variable, tree.Let], done: list[tree.Statement]
    ) -> dict[tree.Variable, tree.Expression]:
        """The steps that become part of a statement; those that can wait no longer are added to `done`."""
        read = set(reads_in(tuple(statement_operands(statement))))
        keeps_all = isinstance(statement, tree.Let) and is_quiet(statement.value, self.quiet)
        found: dict[tree.Variable, tree.Expression] = {}
        for variable, let in list(waiting.items()):
            is_value = bool(UNNAMED.match(variable.name)) or isinstance(statement, tree.Set)
            if variable not in read and keeps_all and is_value:
                continue
            if variable in read and is_value:
                found[variable] = let.value
            else:
                done.append(let)
            del waiting[variable]
        return found

    def is_alias(self, value: tree.Expression) -> bool:
        """Whether a record is one that never changes, or a field of it."""
        if not isinstance(value.kind, Record):
            return False
        while isinstance(value, tree.Field):
            value = value.record
        return isinstance(value, tree.Read) and value.variable not in self.again

    def may_join(self, statement: tree.Let) -> bool:
        """Whether a step may become part of another: what has a name is kept, unless it is a variable's next value."""
        variable, value = statement.variable, statement.value
        if self.uses[variable] != 1 or isinstance(variable.kind, Row) or isinstance(value, tree.Room):
            return False
        if has_effect(value):
            return False
        return isinstance(value, tree.Make) or sum(1 for _ in expressions_in(value)) <= LONGEST

    def with_inner(self, statement: tree.Statement) -> tree.Statement:
        names = [each.name for each in fields(statement) if each.name in ("then", "otherwise", "body", "exhausted")]
        changes: dict[str, Any] = {name: self.block(getattr(statement, name)) for name in names}
        return replace(statement, **changes) if changes else statement

    def substitute(self, statement: tree.Statement, values: dict[tree.Variable, tree.Expression]) -> tree.Statement:
        """A statement with values in place of variables that it reads itself, not in statements within."""
        own = set(map(id, statement_operands(statement)))
        changes: dict[str, Any] = {}
        for each in fields(statement):
            inner = getattr(statement, each.name)
            if id(inner) in own:
                changes[each.name] = self.expression(inner, values)
            elif isinstance(inner, tuple) and any(id(part) in own for part in inner):
                changes[each.name] = tuple(self.expression(part, values) for part in inner)
        return replace(statement, **changes) if changes else statement

    def expression(self, value: tree.Expression, values: dict[tree.Variable, tree.Expression]) -> tree.Expression:
        """An expression with values in place of variables."""
        if isinstance(value, tree.Read):
            return values.get(value.variable) or self.aliases.get(value.variable, value)
        changes: dict[str, Any] = {}
        for name in OPERANDS[type(value)]:
            inner = getattr(value, name)
            if isinstance(inner, tuple):
                changes[name] = tuple(None if part is None else self.expression(part, values) for part in inner)
            else:
                changes[name] = self.expression(inner, values)
        if isinstance(value, tree.Call):
            changes["function"] = self.functions[value.function]
        return replace(value, **changes) if changes else value
