"""Statements of Python read into the tree."""

import ast
from collections.abc import Callable
from typing import Any

from vvdp.generator import tree
from vvdp.generator.arrays import fill, item, put
from vvdp.generator.body import Body, End, Exits, Names
from vvdp.generator.expressions import evaluate, index_of, known_items, test_of
from vvdp.generator.joining import changing, merge, set_all
from vvdp.generator.kinds import INT, Kind, common_kind
from vvdp.generator.operations import binary, negate
from vvdp.generator.source import leaves_loop, stored_names
from vvdp.generator.values import (
    Undefined,
    carried_type,
    is_array,
    is_symbol,
    lengths,
    refusal,
    type_of,
)

TRIES = 8
"""Readings of a loop's body until the types of what it changes stay."""


def read_block(body: Body, statements: list[ast.stmt], names: Names) -> Names | None:
    """Values of the names behind these statements; None if nothing comes behind them."""
    found: Names | None = names
    for statement in statements:
        reader = READ.get(type(statement))
        body.line = statement.lineno
        if reader is None:
            other = f"a {type(statement).__name__} statement", "write it with assignments, `if`, `for` and `while`"
            raise refusal(*REFUSED.get(type(statement), other))
        found = reader(body, statement, found)
        if found is None:
            return None
    return found


def _assign(body: Body, node: ast.Assign, names: Names) -> Names:
    value = evaluate(body, node.value, names)
    for target in node.targets:
        assign(body, target, value, names)
    return names


def _annotate(body: Body, node: ast.AnnAssign, names: Names) -> Names:
    if node.value is not None:
        assign(body, node.target, evaluate(body, node.value, names), names)
    return names


def assign(body: Body, target: ast.expr, value: Any, names: Names) -> None:
    """`target = value`."""
    if isinstance(target, ast.Name):
        names[target.id] = body.bind(value, target.id)
    elif isinstance(target, ast.Tuple | ast.List):
        _unpack(body, target.elts, body.bind(value), names)
    elif isinstance(target, ast.Subscript):
        put(body, evaluate(body, target.value, names), index_of(body, target.slice, names), body.bind(value))
    else:
        raise refusal("an assignment to an attribute", "make a new value, with `_replace`")


def _unpack(body: Body, targets: list[ast.expr], value: Any, names: Names) -> None:
    if any(isinstance(each, ast.Starred) for each in targets):
        raise refusal("a starred target", "take the items by their places")
    if is_array(value):
        items = [item(body, value, i) for i in range(len(targets))]
    else:
        items = known_items(body, value)
    if len(items) != len(targets):
        raise refusal(f"{len(items)} values for {len(targets)} names", "name each of them")
    for each, one in zip(targets, items, strict=True):
        assign(body, each, one, names)


def _augment(body: Body, node: ast.AugAssign, names: Names) -> Names:
    if isinstance(node.target, ast.Name):
        old = evaluate(body, ast.copy_location(ast.Name(node.target.id, ast.Load()), node), names)
        new = binary(body, node.op, old, evaluate(body, node.value, names))
        if is_array(old):
            fill(body, old, new)
        else:
            names[node.target.id] = body.bind(new, node.target.id)
    elif isinstance(node.target, ast.Subscript):
        array = evaluate(body, node.target.value, names)
        place = body.bind(index_of(body, node.target.slice, names), "i")
        put(body, array, place, binary(body, node.op, item(body, array, place), evaluate(body, node.value, names)))
    else:
        raise refusal("an assignment to an attribute", "make a new value, with `_replace`")
    return names


def _expression(body: Body, node: ast.Expr, names: Names) -> Names:
    if not isinstance(node.value, ast.Constant):
        body.bind(evaluate(body, node.value, names))
    return names


def _return(body: Body, node: ast.Return, names: Names) -> None:
    value = None if node.value is None else body.bind(evaluate(body, node.value, names))
    body.returns.append((End(body.block, names), value, node.lineno))


def _raise(body: Body, node: ast.Raise, names: Names) -> None:
    words = ast.unparse(node.exc) if node.exc else "an error"
    body.add(tree.Fail(body.unit.reason(body, words), node.lineno))


def _assert(body: Body, node: ast.Assert, names: Names) -> Names:
    if body.unit.checked:
        body.require(test_of(body, node.test, names), f"assert {ast.unparse(node.test)}")
    return names


def _if(body: Body, node: ast.If, names: Names) -> Names | None:
    test = test_of(body, node.test, names)
    if not is_symbol(test):
        return read_block(body, node.body if test else node.orelse, names)
    line, ends = body.line, []
    blocks: tuple[list[Any], list[Any]] = ([], [])
    for block, statements in zip(blocks, (node.body, node.orelse), strict=True):
        with body.within(block):
            end = read_block(body, statements, dict(names))
        if end is not None:
            ends.append(End(block, end))
    body.add(tree.If(test, *blocks, line))
    return merge(body, ends)


def _break(body: Body, node: ast.Break, names: Names) -> None:
    body.loops[-1].breaks.append(End(body.block, names))


def _continue(body: Body, node: ast.Continue, names: Names) -> None:
    body.loops[-1].continues.append(End(body.block, names))


def _for(body: Body, node: ast.For, names: Names) -> Names | None:
    call = node.iter
    if isinstance(call, ast.Call) and isinstance(call.func, ast.Name) and call.func.id == "range" and not call.keywords:
        limits = [evaluate(body, each, names) for each in call.args]
        first, last, step = ((0, *limits, 1) if len(limits) == 1 else (*limits, 1))[:3]
        if all(isinstance(each, int) for each in (first, last, step)):
            rounds = range(first, last, step)
            if len(rounds) <= body.unit.options.unrolled and not leaves_loop(node.body):
                return _unroll(body, node, list(rounds), names)
        return _rounds(body, node, names, (first, last, step), None)
    values = evaluate(body, call, names)
    if is_array(values) and is_symbol(values):
        values = body.bind(values)
        return _rounds(body, node, names, (0, lengths(values)[0], 1), values)
    if isinstance(values, range) and len(values) > body.unit.options.unrolled:
        return _rounds(body, node, names, (values.start, values.stop, values.step), None)
    return _unroll(body, node, known_items(body, values), names)


def _unroll(body: Body, node: ast.For, items: list[Any], names: Names) -> Names | None:
    """A loop over known items, with one copy of its body for each."""
    if leaves_loop(node.body):
        return _items_in_rounds(body, node, items, names)
    found: Names | None = names
    for one in items:
        assign(body, node.target, one, names)
        found = read_block(body, node.body, names)
        if found is None:
            return None
        names = found
    return read_block(body, node.orelse, names)


class Round:
    """One reading of a loop's body: its statements, its ways back to the beginning, and its ways out."""

    def __init__(self, statement: Any, backs: list[End], exits: list[End], exhausted: End | None) -> None:
        self.statement, self.backs, self.exits, self.exhausted = statement, backs, exits, exhausted


def _while(body: Body, node: ast.While, names: Names) -> Names | None:
    def read(names: Names) -> Round:
        inside: list[Any] = []
        out: list[Any] = []
        statement = tree.Loop(inside, node.lineno)
        with body.within(inside):
            test = test_of(body, node.test, names)
            if is_symbol(test):
                body.add(tree.If(negate(test), out, [], node.lineno))
            with body.within(out if is_symbol(test) else inside):
                after = None if test is True else read_block(body, node.orelse, dict(names))
        past = End(out if is_symbol(test) else inside, after) if after is not None else None
        if test is False:
            return Round(statement, [], [past] if past else [], None)
        backs, breaks = _read_rounds(body, node.body, names, inside)
        return Round(statement, backs, [*([past] if past else []), *breaks], None)

    return _loop(body, node, names, read)


def _rounds(body: Body, node: ast.For, names: Names, limits: tuple[Any, Any, Any], over: Any) -> Names | None:
    first, last, step = (body.bind(body.number(limit, INT)) for limit in limits)

    def read(names: Names) -> Round:
        inside: list[Any] = []
        exhausted: list[Any] = []
        variable = body.variable("i", INT)
        statement = tree.For(variable, (first, last, step), inside, exhausted, node.lineno)
        start = dict(names)
        with body.within(inside):
            found = tree.Read(variable)
            assign(body, node.target, found if over is None else item(body, over, found), start)
        backs, breaks = _read_rounds(body, node.body, start, inside)
        with body.within(exhausted):
            after = read_block(body, node.orelse, dict(names))
        past = End(exhausted, after) if after is not None else None
        return Round(statement, backs, breaks, past)

    return _loop(body, node, names, read)


def _items_in_rounds(body: Body, node: ast.For, items: list[Any], names: Names) -> Names | None:
    """A loop over known items that may be left: in each round the copy of the body that belongs to it runs."""
    limits = tree.Constant(INT, 0), tree.Constant(INT, len(items)), tree.Constant(INT, 1)

    def read(names: Names) -> Round:
        variable, inside, exhausted = body.variable("i", INT), list[Any](), list[Any]()
        backs, breaks, block = list[End](), list[End](), inside
        for number, one in enumerate(items):
            own, others, start = block, list[Any](), dict(names)
            if number < len(items) - 1:
                own = []
                is_its_turn = tree.Compare("==", tree.Read(variable), tree.Constant(INT, number))
                block.append(tree.If(is_its_turn, own, others, node.lineno))
            with body.within(own):
                assign(body, node.target, one, start)
            ends = _read_rounds(body, node.body, start, own)
            backs, breaks, block = backs + ends[0], breaks + ends[1], others
        with body.within(exhausted):
            after = read_block(body, node.orelse, dict(names))
        past = End(exhausted, after) if after is not None else None
        return Round(tree.For(variable, limits, inside, exhausted, node.lineno), backs, breaks, past)

    return _loop(body, node, names, read)


def _read_rounds(
    body: Body, statements: list[ast.stmt], names: Names, inside: list[Any]
) -> tuple[list[End], list[End]]:
    """The ways back to the beginning of a loop, and those out of it by `break`."""
    body.loops.append(Exits())
    with body.within(inside):
        end = read_block(body, statements, dict(names))
    exits = body.loops.pop()
    return [*exits.continues, *([End(inside, end)] if end is not None else [])], exits.breaks


def _loop(body: Body, node: ast.For | ast.While, names: Names, read: Callable[[Names], Round]) -> Names | None:
    """A loop whose body is read until the types of all that it changes stay as they are at its beginning."""
    stored = stored_names([node])
    carried = [name for name in names if name in stored]
    kinds: dict[str, Kind | None] = {}
    for name in carried:
        kinds[name] = None if isinstance(names[name], Undefined) else carried_type(type_of(names[name]))
    for _ in range(TRIES):
        returns = len(body.returns)
        start = {name: changing(body, name, kinds[name], names[name]) for name in carried}
        found = read(names | start)
        after = {name: _types_after(kinds[name], [end.names.get(name) for end in found.backs]) for name in carried}
        if after == kinds:
            return _close(body, names, start, found)
        del body.returns[returns:]
        kinds = after
    raise refusal("a loop whose values change their types in every round", "keep one type for each name")


def _types_after(kind: Kind | None, values: list[Any]) -> Kind | None:
    for value in values:
        kind = None if kind is None or isinstance(value, Undefined) else common_kind(kind, type_of(value))
    return kind


def _close(body: Body, names: Names, start: Names, found: Round) -> Names | None:
    """Writes a loop with the assignments of what it carries, and of what its ways out have in common."""
    set_all(body, tuple(start.values()), tuple(names[name] for name in start))
    body.add(found.statement)
    for end in found.backs:
        with body.within(end.block):
            set_all(body, tuple(start.values()), tuple(end.names[name] for name in start))
        if end.block is not found.statement.body:
            end.block.append(tree.Continue())
    ends = [*([found.exhausted] if found.exhausted else []), *found.exits]
    met = merge(body, ends)
    for end in found.exits:
        end.block.append(tree.Break())
    return met


READ: dict[type[ast.stmt], Callable[[Body, Any, Any], Names | None]] = {
    ast.Assign: _assign, ast.AnnAssign: _annotate, ast.AugAssign: _augment, ast.Expr: _expression,
    ast.Return: _return, ast.Raise: _raise, ast.Assert: _assert, ast.If: _if, ast.For: _for, ast.While: _while,
    ast.Break: _break, ast.Continue: _continue, ast.Pass: lambda body, node, names: names,
}  # fmt: skip

REFUSED: dict[type[ast.stmt], tuple[str, str]] = {
    ast.Try: ("`try`", "check values with `if` before they are used"),
    ast.With: ("`with`", "write plain statements"),
    ast.FunctionDef: ("a function within a function", "define it at the top level of a module"),
    ast.ClassDef: ("a class within a function", "define it at the top level of a module"),
    ast.Import: ("an import within a function", "import at the top of the module"),
    ast.ImportFrom: ("an import within a function", "import at the top of the module"),
    ast.Global: ("`global`", "hand the value over as an argument and return it"),
    ast.Nonlocal: ("`nonlocal`", "hand the value over as an argument and return it"),
    ast.Delete: ("`del`", "leave the name alone"),
    ast.Match: ("`match`", "write `if` and `elif`"),
}
"""Statements that are not allowed, in words, and what to write instead."""
