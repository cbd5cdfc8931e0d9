"""The typed tree between Python and machine code: what a function does, with every type and name settled.

Expressions have no effects but where they stand alone in a `Let`: a call, a view of an array, room for an array, a
record. Variables of a `Let` are assigned once; those of a `Set` may be assigned again, all of one `Set` at once.
"""

from dataclasses import dataclass, field
from typing import Any, TypeAlias

from vvdp.generator.kinds import BOOL, INT, Address, Kind, Record, Row, Scalar


@dataclass(frozen=True, eq=False, slots=True)
class Variable:
    """A name within a function."""

    name: str
    kind: Kind


@dataclass(frozen=True, eq=False, slots=True)
class Constant:
    """A number."""

    kind: Scalar
    value: Any


@dataclass(frozen=True, eq=False, slots=True)
class Read:
    """The value of a variable."""

    variable: Variable

    @property
    def kind(self) -> Kind:
        """The type of the variable."""
        return self.variable.kind


@dataclass(frozen=True, eq=False, slots=True)
class Table:
    """An array of numbers that are known."""

    name: str
    kind: Row
    numbers: tuple[Any, ...]


@dataclass(frozen=True, eq=False, slots=True)
class Unary:
    """`-` or `~` of a number, `not` of a truth."""

    sign: str
    operand: "Expression"
    kind: Scalar


@dataclass(frozen=True, eq=False, slots=True)
class Binary:
    """Two numbers of one type joined by a Python operator; `//` and `%` only of whole numbers."""

    sign: str
    left: "Expression"
    right: "Expression"
    kind: Scalar


@dataclass(frozen=True, eq=False, slots=True)
class Compare:
    """Whether two numbers of one type compare so."""

    sign: str
    left: "Expression"
    right: "Expression"

    @property
    def kind(self) -> Scalar:
        """A truth."""
        return BOOL


@dataclass(frozen=True, eq=False, slots=True)
class Convert:
    """A number as another type: floats are cut towards zero and held within 64 bits, and NaN becomes 0."""

    kind: Scalar
    operand: "Expression"


@dataclass(frozen=True, eq=False, slots=True)
class Choose:
    """One of two numbers, both of which are at hand."""

    test: "Expression"
    then: "Expression"
    otherwise: "Expression"

    @property
    def kind(self) -> Kind:
        """The type of either."""
        return self.then.kind


@dataclass(frozen=True, eq=False, slots=True)
class Library:
    """A function of the processor, of the C library, or an intrinsic of the caller, without effects."""

    name: str
    arguments: tuple["Expression", ...]
    kind: Scalar


@dataclass(frozen=True, eq=False, slots=True)
class Field:
    """A field of a record."""

    record: "Expression"
    number: int
    kind: Kind


@dataclass(frozen=True, eq=False, slots=True)
class Length:
    """The length of an array along an axis, where it is not known."""

    array: "Expression"
    axis: int

    @property
    def kind(self) -> Scalar:
        """A whole number."""
        return INT


@dataclass(frozen=True, eq=False, slots=True)
class Item:
    """A number in an array."""

    array: "Expression"
    indexes: tuple["Expression", ...]
    kind: Scalar


@dataclass(frozen=True, eq=False, slots=True)
class View:
    """Numbers of an array from `offset` on as another array, which shares them."""

    array: "Expression"
    offset: "Expression"
    sizes: tuple["Expression", ...]
    kind: Row


@dataclass(frozen=True, eq=False, slots=True)
class Room:
    """A new array. Its numbers are not set."""

    sizes: tuple["Expression", ...]
    kind: Row


@dataclass(frozen=True, eq=False, slots=True)
class Make:
    """A record; of fields that are known there is no part."""

    parts: tuple["Expression | None", ...]
    kind: Record


@dataclass(frozen=True, eq=False, slots=True)
class Call:
    """A call of a function of the module."""

    function: "Function"
    arguments: tuple["Expression", ...]

    @property
    def kind(self) -> Kind:
        """The kind of the result of the function."""
        return self.function.result


@dataclass(frozen=True, eq=False, slots=True)
class CallAddress:
    """A call of a function by its address."""

    address: "Expression"
    arguments: tuple["Expression", ...]
    kind: Kind


@dataclass(frozen=True, eq=False, slots=True)
class Symbol:
    """The address of a function of another module, known when the code is loaded."""

    name: str
    kind: Address


@dataclass(frozen=True, eq=False, slots=True)
class CallIntrinsic:
    """A call of an intrinsic of the caller that has effects, or takes other arguments than floats."""

    name: str
    arguments: tuple["Expression", ...]
    kind: Kind


Expression: TypeAlias = (
    Constant | Read | Table | Unary | Binary | Compare | Convert | Choose | Library | Field | Length
    | Item | View | Room | Make | Call | CallAddress | Symbol | CallIntrinsic
)  # fmt: skip


@dataclass(frozen=True, eq=False, slots=True)
class Let:
    """The one assignment of a variable."""

    variable: Variable
    value: Expression
    line: int


@dataclass(frozen=True, eq=False, slots=True)
class Set:
    """Assignments of variables, all at once."""

    variables: tuple[Variable, ...]
    values: tuple[Expression, ...]
    line: int


@dataclass(frozen=True, eq=False, slots=True)
class Store:
    """A number written to an array."""

    array: Expression
    indexes: tuple[Expression, ...]
    value: Expression
    line: int


@dataclass(frozen=True, eq=False, slots=True)
class Do:
    """A call for its effects only."""

    call: Call | CallAddress | CallIntrinsic
    line: int


@dataclass(frozen=True, eq=False, slots=True)
class If:
    """A branch."""

    test: Expression
    then: "Block"
    otherwise: "Block"
    line: int


@dataclass(frozen=True, eq=False, slots=True)
class For:
    """A loop over range(start, stop, step); `exhausted` runs where no break has ended it."""

    variable: Variable
    range: tuple[Expression, Expression, Expression]
    body: "Block"
    exhausted: "Block"
    line: int


@dataclass(frozen=True, eq=False, slots=True)
class Loop:
    """A loop that only a break or a return ends."""

    body: "Block"
    line: int


@dataclass(frozen=True, eq=False, slots=True)
class Break:
    """Leaves the innermost loop."""


@dataclass(frozen=True, eq=False, slots=True)
class Continue:
    """Goes on with the next round of the innermost loop."""


@dataclass(frozen=True, eq=False, slots=True)
class Return:
    """Leaves the function."""

    value: Expression | None
    line: int


@dataclass(frozen=True, eq=False, slots=True)
class Fail:
    """Ends the run with the reason of this number."""

    number: int
    line: int


Statement: TypeAlias = Let | Set | Store | Do | If | For | Loop | Break | Continue | Return | Fail
Block: TypeAlias = tuple[Statement, ...] | list[Statement]
"""A list while it is written, a tuple after."""


@dataclass(frozen=True, eq=False)
class Function:
    """A function for one combination of argument types."""

    name: str
    parameters: tuple[Variable, ...]
    result: Kind
    body: Block
    file: str
    line: int
    apart: bool = False  # seldom called and without effects: never copied to where it is called


@dataclass(frozen=True, eq=False)
class Module:
    """Functions, callees first, of which the entries can be called from outside, and the reasons of failures."""

    functions: tuple[Function, ...]
    entries: tuple[str, ...]
    reasons: tuple[str, ...] = ()
    intrinsics: dict[str, Any] = field(default_factory=dict)


def freeze(block: Block) -> tuple[Statement, ...]:
    """The statements with every list in them made a tuple."""
    done: list[Statement] = []
    for one in block:
        if isinstance(one, If):
            one = If(one.test, freeze(one.then), freeze(one.otherwise), one.line)
        elif isinstance(one, For):
            one = For(one.variable, one.range, freeze(one.body), freeze(one.exhausted), one.line)
        elif isinstance(one, Loop):
            one = Loop(freeze(one.body), one.line)
        done.append(one)
    return tuple(done)
