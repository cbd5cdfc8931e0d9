"""The body of a function while it is written: its statements, its variables, and its values as expressions."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from vvdp.generator import tree
from vvdp.generator.kinds import BOOL, FLOAT, INT, Kind, Known, Record, Row, Scalar, tuple_of
from vvdp.generator.source import Source
from vvdp.generator.values import EXPRESSIONS, describe, is_array, part, refusal

if TYPE_CHECKING:
    from vvdp.generator.unit import Unit

Names = dict[str, Any]
"""Values of the local names."""
Word = Callable[..., Any]
"""A function that is written in place: it takes the body and the arguments."""


@dataclass
class End:
    """A way out of statements: their list, to which more may be added, and what the names stand for there."""

    block: list[tree.Statement]
    names: Names


@dataclass
class Exits:
    """The ways out of a loop's body."""

    breaks: list[End] = field(default_factory=list)
    continues: list[End] = field(default_factory=list)


class Body:
    """The statements of one function, written one after the other to `block`."""

    def __init__(self, unit: "Unit", source: Source) -> None:
        self.unit, self.source = unit, source
        self._taken = source.function.__code__.co_varnames
        self.block: list[tree.Statement] = []
        self.line = source.node.lineno
        self.returns: list[tuple[End, Any, int]] = []
        self.loops: list[Exits] = []
        self._count = 0

    @contextmanager
    def within(self, block: list[tree.Statement]) -> Iterator[None]:
        """Writes to another list."""
        before, self.block = self.block, block
        try:
            yield
        finally:
            self.block = before

    def add(self, statement: tree.Statement) -> None:
        """Writes a statement."""
        self.block.append(statement)

    def variable(self, name: str, kind: Kind) -> tree.Variable:
        """A variable with a name of its own."""
        self._count += 1
        own = f"{name}_{self._count}"
        return tree.Variable(f"{own}_" if own in self._taken else own, kind)

    def bind(self, value: Any, name: str = "v") -> Any:
        """The value, calculated here once; of a tuple each part."""
        if isinstance(value, tuple):
            return tuple_of(type(value), [self.bind(one, name) for one in value])
        if isinstance(value, list):
            return [self.bind(one, name) for one in value]
        if isinstance(value, tree.Constant | tree.Read) or not isinstance(value, EXPRESSIONS):
            return value
        variable = self.variable(name, value.kind)
        self.add(tree.Let(variable, value, self.line))
        return tree.Read(variable)

    def number(self, value: Any, kind: Scalar) -> tree.Expression:
        """A number as an expression of this type."""
        if isinstance(value, tree.Constant):
            value = value.value
        if isinstance(value, EXPRESSIONS) and isinstance(value.kind, Scalar):
            return self._convert_number(value, kind)
        if isinstance(value, bool | int | float | np.generic):
            plain = {FLOAT: float, INT: int}.get(kind, bool)(value)
            if kind is INT and not -(2**63) <= plain < 2**63:
                raise refusal(f"the whole number {plain}", "use numbers of 64 bits")
            return tree.Constant(kind, plain)
        raise refusal(f"{describe(value)} where a number is expected", "use a number")

    def _convert_number(self, value: tree.Expression, kind: Scalar) -> tree.Expression:
        if value.kind is kind:
            return value
        if self.unit.checked and value.kind is FLOAT and kind is INT:
            value = self.bind(value)
            for limit, sign in ((-(2.0**63), ">="), (2.0**63, "<")):
                inside = tree.Compare(sign, value, tree.Constant(FLOAT, limit))
                self.require(inside, "a number that no whole number of 64 bits can hold")
        return tree.Convert(kind, value)

    def require(self, test: Any, reason: str) -> None:
        """Ends the run here with `reason` unless `test` holds."""
        fail = tree.Fail(self.unit.reason(self, reason), self.line)
        self.add(tree.If(self.number(test, BOOL), [], [fail], self.line))

    def as_kind(self, value: Any, kind: Kind) -> tree.Expression | None:
        """A value as an expression of this type; None where it is known."""
        if isinstance(kind, Known):
            return None
        if isinstance(kind, Scalar):
            return self.number(value, kind)
        if isinstance(kind, Row) and is_array(value):
            return self.array(value)
        if isinstance(kind, Record) and not (isinstance(value, EXPRESSIONS) and value.kind == kind):
            made = [self.as_kind(part(value, i), each) for i, each in enumerate(kind.fields)]
            value = self.bind(tree.Make(tuple(made), kind))
        if not isinstance(value, EXPRESSIONS):
            raise refusal(f"{describe(value)} where {kind!r} is expected", "use one type")
        found: tree.Expression = value
        return found

    def array(self, value: Any) -> tree.Expression:
        """An array as an expression."""
        found: tree.Expression = self.unit.table(value) if isinstance(value, np.ndarray) else value
        return found
