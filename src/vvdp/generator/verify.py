"""The verifier: what must be true of a tree after every pass.

Types of operands, one meaning for each variable, values before their use on every way, calls of functions that stand
before, known functions of the library only, no way past the end of a function.
"""

from collections.abc import Callable, Iterator, Sequence
from typing import Any

from vvdp.generator import tree
from vvdp.generator.kinds import BOOL, FLOAT, INT, Address, Kind, Known, Record, Row, Scalar
from vvdp.generator.library import C_LIBRARY, EXACT, FITS

Assigned = set[tree.Variable] | None
"""The variables that have a value; None where nothing gets to."""
ORDERS = ("<", "<=", ">", ">=", "==", "!=")
SIGNS: dict[Scalar, tuple[str, ...]] = {
    FLOAT: ("+", "-", "*", "/"),
    INT: ("+", "-", "*", "//", "%", "&", "|", "^", "<<", ">>"),
    BOOL: ("&", "|", "^"),
}


class TreeError(Exception):
    """A tree that is wrong: a fault of the generator, never of the function that it was made from."""


def verify(module: tree.Module) -> tree.Module:
    """The module as it is. Raises TreeError with function and line where a rule is broken."""
    known: set[tree.Function] = set()
    names = [function.name for function in module.functions]
    if len(set(names)) < len(names) or not set(module.entries) <= set(names):
        raise TreeError("functions of one name, or an entry that is no function")
    for function in module.functions:
        _Verifier(function, known, module).check()
        known.add(function)
    return module


class _Verifier:
    """The check of one function."""

    def __init__(self, function: tree.Function, known: set[tree.Function], module: tree.Module) -> None:
        self.function, self.known, self.module = function, known, module
        self.line = function.line
        self.once: set[tree.Variable] = set(function.parameters)
        self.again: set[tree.Variable] = set()
        self.breaks: list[list[Assigned]] = []

    def require(self, holds: bool, words: str) -> None:
        if not holds:
            raise TreeError(f"{self.function.name}, line {self.line} of {self.function.file}: {words}")

    def check(self) -> None:
        names = [v.name for v in self.function.parameters]
        self.require(len(set(names)) == len(names), "parameters of one name")
        end = self.block(self.function.body, set(self.function.parameters))
        self.require(end is None, "a way past the end")

    def block(self, block: tree.Block, assigned: Assigned) -> Assigned:
        for statement in block:
            self.line = getattr(statement, "line", self.line)
            if assigned is None:
                raise TreeError(f"{self.function.name}, line {self.line}: a statement that nothing gets to")
            for value in statement_operands(statement):
                self.expression(value, assigned)
            check = CHECKED.get(type(statement), _Verifier.leave)
            assigned = check(self, statement, assigned)
        return assigned

    def expression(self, value: tree.Expression, assigned: set[tree.Variable]) -> None:
        if isinstance(value, tree.Read):
            self.require(value.variable in assigned, f"{value.variable.name} is read before it has a value")
            return
        for inner in operands(value):
            self.expression(inner, assigned)
        problem = wrong(value, self.module)
        self.require(not problem, problem)
        if isinstance(value, tree.Call):
            self.require(value.function in self.known, f"{value.function.name} is called before it is defined")

    def assign(self, statement: tree.Let | tree.Set, assigned: set[tree.Variable]) -> Assigned:
        is_let = isinstance(statement, tree.Let)
        variables = (statement.variable,) if isinstance(statement, tree.Let) else statement.variables
        for variable, value in zip(variables, statement_operands(statement), strict=True):
            same = fits(value.kind, variable.kind)
            self.require(same, f"{variable.name} is {variable.kind!r}, not {value.kind!r}")
            taken = self.once | self.again if is_let else self.once
            self.require(variable not in taken, f"{variable.name} is assigned twice")
        (self.once if is_let else self.again).update(variables)
        return assigned | set(variables)

    def branch(self, statement: tree.If, assigned: set[tree.Variable]) -> Assigned:
        self.require(statement.test.kind is BOOL, "a test that is no truth")
        return _common([self.block(each, assigned) for each in (statement.then, statement.otherwise)])

    def loop(self, statement: tree.For | tree.Loop, assigned: set[tree.Variable]) -> Assigned:
        inside = assigned
        if isinstance(statement, tree.For):
            self.require(all(each.kind is INT for each in statement.range), "a range that is not whole")
            self.require(statement.variable not in self.once, "a count that is assigned twice")
            self.once.add(statement.variable)
            inside = assigned | {statement.variable}
        self.breaks.append([])
        self.block(statement.body, inside)
        ends = self.breaks.pop()
        if isinstance(statement, tree.For):
            ends.append(self.block(statement.exhausted, assigned))
        return _common(ends)

    def leave(self, statement: tree.Statement, assigned: set[tree.Variable]) -> Assigned:
        words = _wrong_statement(statement, self.function, self.module)
        self.require(not words, words)
        if isinstance(statement, tree.Break | tree.Continue):
            self.require(bool(self.breaks), "a break or continue outside of a loop")
            if isinstance(statement, tree.Break):
                self.breaks[-1].append(assigned)
        return assigned if isinstance(statement, tree.Store | tree.Do) else None


CHECKED: dict[type[Any], Callable[[_Verifier, Any, set[tree.Variable]], Assigned]] = {
    tree.Let: _Verifier.assign,
    tree.Set: _Verifier.assign,
    tree.If: _Verifier.branch,
    tree.For: _Verifier.loop,
    tree.Loop: _Verifier.loop,
}


def _wrong_statement(statement: tree.Statement, function: tree.Function, module: tree.Module) -> str:
    """The fault of a statement whose expressions are right; empty where there is none."""
    if isinstance(statement, tree.Return):
        result = function.result
        value = statement.value
        right = isinstance(result, Known) if value is None else fits(value.kind, result)
        return "" if right else "a result of another type"
    if isinstance(statement, tree.Store):
        row = statement.array.kind
        right = isinstance(row, Row) and statement.value.kind is row.element
        return "" if right and _are_indexes(statement.indexes, row) else "a number or an index of another type"
    if isinstance(statement, tree.Fail):
        return "" if 0 < statement.number <= len(module.reasons) else "a failure without a reason"
    return ""


def _are_indexes(values: Sequence[tree.Expression], row: Kind) -> bool:
    return isinstance(row, Row) and [value.kind for value in values] == [INT] * len(row.shape)


def _common(ends: list[Assigned]) -> Assigned:
    found = [end for end in ends if end is not None]
    return set.intersection(*found) if found else None


def statement_operands(statement: tree.Statement) -> Sequence[tree.Expression]:
    """The expressions of a statement, without those of statements within."""
    if isinstance(statement, tree.Let):
        return (statement.value,)
    if isinstance(statement, tree.Set):
        return statement.values
    if isinstance(statement, tree.Store):
        return (statement.array, *statement.indexes, statement.value)
    if isinstance(statement, tree.Do):
        return (statement.call,)
    if isinstance(statement, tree.If):
        return (statement.test,)
    if isinstance(statement, tree.For):
        return statement.range
    return (statement.value,) if isinstance(statement, tree.Return) and statement.value is not None else ()


OPERANDS: dict[type[Any], tuple[str, ...]] = {
    tree.Constant: (),
    tree.Read: (),
    tree.Table: (),
    tree.Unary: ("operand",),
    tree.Convert: ("operand",),
    tree.Binary: ("left", "right"),
    tree.Compare: ("left", "right"),
    tree.Choose: ("test", "then", "otherwise"),
    tree.Library: ("arguments",),
    tree.Field: ("record",),
    tree.Length: ("array",),
    tree.Item: ("array", "indexes"),
    tree.View: ("array", "offset", "sizes"),
    tree.Room: ("sizes",),
    tree.Make: ("parts",),
    tree.Call: ("arguments",),
    tree.CallAddress: ("address", "arguments"),
    tree.Symbol: (),
    tree.CallIntrinsic: ("arguments",),
}


def operands(value: tree.Expression) -> list[tree.Expression]:
    """The expressions within an expression."""
    found: list[tree.Expression] = []
    for name in OPERANDS[type(value)]:
        inner = getattr(value, name)
        found += [each for each in inner if each is not None] if isinstance(inner, tuple) else [inner]
    return found


def calls_in(value: tree.Expression) -> Iterator[tree.Function]:
    """The functions of the module that an expression calls."""
    if isinstance(value, tree.Call):
        yield value.function
    for inner in operands(value):
        yield from calls_in(inner)


def fits(kind: Kind, target: Kind) -> bool:
    """Whether a value of one type may stand where another is: an array may leave more of its lengths open."""
    if isinstance(kind, Row) and isinstance(target, Row) and len(kind.shape) == len(target.shape):
        open_ = all(wanted in (None, known) for known, wanted in zip(kind.shape, target.shape, strict=True))
        return kind.element is target.element and open_
    return kind == target


def _all_fit(values: Sequence[tree.Expression], kinds: Sequence[Kind]) -> bool:
    return len(values) == len(kinds) and all(fits(v.kind, k) for v, k in zip(values, kinds, strict=True))


def wrong(value: tree.Expression, module: tree.Module) -> str:
    """The fault of an expression whose operands are right; empty where there is none."""
    kinds = [each.kind for each in operands(value)]
    checks: dict[type[Any], Any] = {
        tree.Binary: lambda v: kinds == [v.kind] * 2 and v.sign in SIGNS[v.kind],
        tree.Compare: lambda v: kinds[0] == kinds[1] and isinstance(kinds[0], Scalar) and v.sign in ORDERS,
        tree.Unary: lambda v: kinds == [v.kind] and v.sign in {FLOAT: "-", INT: "-~", BOOL: ("not",)}[v.kind],
        tree.Convert: lambda v: isinstance(kinds[0], Scalar) and kinds[0] is not v.kind,
        tree.Choose: lambda v: kinds[0] is BOOL and kinds[1] == kinds[2],
        tree.Constant: lambda v: type(v.value) is {FLOAT: float, INT: int, BOOL: bool}[v.kind],
        tree.Field: lambda v: isinstance(kinds[0], Record) and kinds[0].fields[v.number] == v.kind,
        tree.Length: lambda v: isinstance(kinds[0], Row) and kinds[0].shape[v.axis] is None,
        tree.Item: lambda v: _are_indexes(v.indexes, kinds[0]),
        tree.View: lambda v: (
            isinstance(kinds[0], Row) and kinds[0].element is v.kind.element and set(kinds[1:]) == {INT}
        ),
        tree.Room: lambda v: kinds == [INT] * len(v.kind.shape),
        tree.Make: lambda v: _is_whole(v),
        tree.Call: lambda v: _all_fit(v.arguments, [p.kind for p in v.function.parameters]),
        tree.CallAddress: lambda v: isinstance(kinds[0], Address) and _all_fit(v.arguments, kinds[0].arguments),
        tree.CallIntrinsic: lambda v: _is_supplied(v, module),
        tree.Library: lambda v: _is_permitted(v, kinds, module),
    }
    check = checks.get(type(value))
    return "" if check is None or check(value) else f"a wrong {type(value).__name__}: {value!r}"[:300]


def _is_whole(value: tree.Make) -> bool:
    """Whether a record has a part for each field that is not known, and for no other."""
    pairs = list(zip(value.parts, value.kind.fields, strict=True))
    return all(isinstance(k, Known) if p is None else fits(p.kind, k) for p, k in pairs)


def _is_supplied(value: tree.CallIntrinsic, module: tree.Module) -> bool:
    intrinsic = module.intrinsics.get(value.name)
    result = Known(None) if intrinsic is None or intrinsic.result is None else intrinsic.result
    return intrinsic is not None and value.kind == result and _all_fit(value.arguments, intrinsic.arguments)


def _is_permitted(value: tree.Library, kinds: list[Kind], module: tree.Module) -> bool:
    if value.name in FITS:
        return kinds == [INT, INT] and value.kind is BOOL
    counts = {name: count for name, (count, _) in EXACT.items()} | C_LIBRARY
    counts |= {name: len(intrinsic.arguments) for name, intrinsic in module.intrinsics.items() if intrinsic.is_pure}
    return kinds == [FLOAT] * counts.get(value.name, -1) and value.kind is FLOAT
