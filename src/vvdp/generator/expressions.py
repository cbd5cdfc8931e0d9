"""Expressions of Python read into the tree."""

import ast
import builtins
import inspect
import types
from collections.abc import Callable
from enum import Enum
from typing import Any

import numpy as np

from vvdp.generator.arrays import entry, item
from vvdp.generator.body import Body, End, Names
from vvdp.generator.joining import merge
from vvdp.generator.kinds import BOOL, Address, Known, Record, Scalar, number_kind, tuple_of
from vvdp.generator.operations import binary, choose, compare, is_cheap, negate, truth, unary
from vvdp.generator.tree import Binary, CallAddress, Do, If, Symbol
from vvdp.generator.values import (
    Undefined,
    describe,
    is_array,
    is_number,
    is_record,
    is_symbol,
    lengths,
    part,
    parts,
    refusal,
    type_of,
)
from vvdp.generator.words import FOLDED, WORDS, Written, array_attribute

LIBRARIES = ("numpy", "scipy")
MOST_ROUNDS = 1000
"""Rounds of a comprehension at most."""


def evaluate(body: Body, node: ast.expr, names: Names) -> Any:
    """The value of an expression. Raises LanguageError where the language does not have it."""
    reader = EVALUATED.get(type(node))
    if reader is None:
        other = f"a {type(node).__name__} expression", "write it with plain statements"
        raise refusal(*REFUSED.get(type(node), other))
    before, body.line = body.line, getattr(node, "lineno", body.line)
    value = reader(body, node, names)
    body.line = before
    return value


def _name(body: Body, node: ast.Name, names: Names) -> Any:
    name = node.id
    if name in names:
        value = names[name]
        if isinstance(value, Undefined):
            raise refusal(value.reason, "assign it before the branch or loop, with one type")
        return value
    if name in body.source.names:
        return plain(body.source.names[name])
    if hasattr(builtins, name):
        return getattr(builtins, name)
    raise refusal(f"the name `{name}`, which is not assigned here", "assign it on every way to this line")


def plain(value: Any) -> Any:
    """A known value as the language has it: NumPy's numbers are plain ones."""
    return value.item() if isinstance(value, np.generic) else value


def _constant(body: Body, node: ast.Constant, names: Names) -> Any:
    if isinstance(node.value, complex | bytes):
        raise refusal(f"the {type(node.value).__name__} {node.value!r}", "use floats")
    return node.value


def _attribute(body: Body, node: ast.Attribute, names: Names) -> Any:
    return attribute(body, evaluate(body, node.value, names), node.attr)


def attribute(body: Body, value: Any, name: str) -> Any:
    """`value.name`."""
    if is_array(value):
        return array_attribute(body, value, name)
    if isinstance(type_of(value), Record):
        return _record_attribute(body, value, name)
    if is_symbol(value) or (isinstance(value, bool | int | float) and not isinstance(value, Enum)):
        raise refusal(f"`.{name}` of {describe(value)}", "use functions of numbers")
    try:
        return plain(getattr(value, name))
    except AttributeError:
        raise refusal(f"`.{name}`, which {describe(value)} does not have", "check the name") from None


def _record_attribute(body: Body, value: Any, name: str) -> Any:
    cls = type_of(value).cls  # type: ignore[union-attr]
    fields: tuple[str, ...] = getattr(cls, "_fields", ())
    if name in fields:
        return part(value, fields.index(name))
    if name == "_replace":
        return Written(lambda _, **given: tuple_of(cls, [given.get(f, part(value, i)) for i, f in enumerate(fields)]))
    found = inspect.getattr_static(cls, name, None)
    if isinstance(found, property):
        return body.unit.call(body, found.fget, (value,), {})
    if isinstance(found, types.FunctionType):
        return Written(lambda _, *values, **named: body.unit.call(body, found, (value, *values), named))
    if found is None or name in dir(tuple):
        what = f"it has {', '.join(fields)}" if fields else "index it"
        raise refusal(f"`.{name}` of a {cls.__name__}", what)
    return plain(found)


def _binary(body: Body, node: ast.BinOp, names: Names) -> Any:
    left = evaluate(body, node.left, names)
    return binary(body, node.op, left, evaluate(body, node.right, names))


def _unary(body: Body, node: ast.UnaryOp, names: Names) -> Any:
    if isinstance(node.op, ast.Not):
        return negate(test_of(body, node.operand, names))
    return unary(body, node.op, evaluate(body, node.operand, names))


def _compare(body: Body, node: ast.Compare, names: Names) -> Any:
    left = evaluate(body, node.left, names)
    right = evaluate(body, node.comparators[0], names)
    if len(node.ops) == 1:
        return compare(body, node.ops[0], left, right)
    right = body.bind(right)
    first = compare(body, node.ops[0], left, right)
    middle = "\0middle"  # the middle one of a chain is calculated once
    rest = ast.copy_location(ast.Compare(_name_node(middle, node), node.ops[1:], node.comparators[1:]), node)
    return _both(body, first, lambda: _compare(body, rest, {**names, middle: right}), both=True)


def _name_node(name: str, node: ast.expr) -> ast.Name:
    return ast.copy_location(ast.Name(name, ast.Load()), node)


def _truths(body: Body, node: ast.BoolOp, names: Names) -> Any:
    return _joined_truths(body, node, names, test=False)


def _joined_truths(body: Body, node: ast.BoolOp, names: Names, *, test: bool) -> Any:
    """`and`, `or`: truths, but in a test anything that counts as one."""

    def one(each: ast.expr) -> Any:
        if test:
            return test_of(body, each, names)
        value = evaluate(body, each, names)
        if number_kind(type_of(value)) is not BOOL:
            raise refusal(f"`and` or `or` of {describe(value)}", "write `a if test else b`")
        return value

    def rest(values: list[ast.expr]) -> Any:
        value = one(values[0])
        if len(values) == 1:
            return value
        return _both(body, value, lambda: rest(values[1:]), both=isinstance(node.op, ast.And))

    return rest(node.values)


def _both(body: Body, first: Any, second: Callable[[], Any], *, both: bool) -> Any:
    """`first and second()` or, where not `both`, `first or second()`, which is only calculated where it matters."""
    if not is_symbol(first):
        return second() if bool(first) is both else first
    inside: list[Any] = []
    with body.within(inside):
        value = second()
    if not inside and not is_symbol(value):
        return first if bool(value) is both else value
    if not inside and _is_light(value):
        return Binary("&" if both else "|", first, value, BOOL)
    block: list[Any] = []
    body.add(If(first, inside if both else block, block if both else inside, body.line))
    met = merge(body, [End(inside, {"truth": value}), End(block, {"truth": not both})])
    return met["truth"] if met else value


def _is_light(value: Any) -> bool:
    """Whether calculating a truth takes hardly more than asking whether it matters."""
    if isinstance(value, Binary):
        return value.kind is BOOL and _is_light(value.left) and _is_light(value.right)
    return all(is_cheap(getattr(value, side, None)) for side in ("left", "right", "operand"))


def test_of(body: Body, node: ast.expr, names: Names) -> Any:
    """The truth of an expression: known, or an expression."""
    if isinstance(node, ast.BoolOp):
        return _joined_truths(body, node, names, test=True)
    return truth(body, evaluate(body, node, names))


def _conditional(body: Body, node: ast.IfExp, names: Names) -> Any:
    test = test_of(body, node.test, names)
    if not is_symbol(test):
        return evaluate(body, node.body if test else node.orelse, names)
    then, otherwise = list[Any](), list[Any]()
    values = []
    for block, each in ((then, node.body), (otherwise, node.orelse)):
        with body.within(block):
            values.append(evaluate(body, each, names))
    if not then and not otherwise and all(is_cheap(value) and is_number(value) for value in values):
        return choose(body, test, *values)
    for block, i in ((then, 0), (otherwise, 1)):
        with body.within(block):
            values[i] = body.bind(values[i])
    body.add(If(test, then, otherwise, body.line))
    met = merge(body, [End(then, {"value": values[0]}), End(otherwise, {"value": values[1]})])
    value = met["value"] if met else None
    if isinstance(value, Undefined):
        raise refusal("values of different types on both sides of `if`", "use one type")
    return value


def _display(body: Body, node: ast.Tuple | ast.List, names: Names) -> Any:
    found = _spread(body, node.elts, names)
    return body.bind(tuple(found) if isinstance(node, ast.Tuple) else found)


def _spread(body: Body, nodes: list[ast.expr], names: Names) -> list[Any]:
    """The values of expressions, those of a starred tuple one by one."""
    found: list[Any] = []
    for node in nodes:
        if isinstance(node, ast.Starred):
            found += known_items(body, evaluate(body, node.value, names))
        else:
            found.append(evaluate(body, node, names))
    return found


def known_items(body: Body, values: Any) -> list[Any]:
    """The items of something of known length."""
    if is_array(values):
        count = lengths(values)[0]
        if not isinstance(count, int):
            raise refusal("an array whose length is not known", "write a loop over `range(x.size)`")
        return [item(body, values, i) for i in range(count)]
    if is_record(values):
        return list(parts(values))
    if not isinstance(values, range | str | dict | type(zip()) | type(enumerate(())) | type(reversed(()))):
        raise refusal(f"a loop over {describe(values)}", "loop over a range, a tuple or an array")
    return list(values)


def _subscript(body: Body, node: ast.Subscript, names: Names) -> Any:
    value = evaluate(body, node.value, names)
    found = index_of(body, node.slice, names)
    if is_array(value):
        return item(body, value, found)
    if is_record(value):
        return entry(body, value, found)
    if is_symbol(value) or is_symbol(found):
        raise refusal(f"an index of {describe(value)}", "index tuples and arrays only")
    return plain(value[found])


def index_of(body: Body, node: ast.expr, names: Names) -> Any:
    """An index, or a tuple of them."""
    if isinstance(node, ast.Slice):
        ends = (node.lower, node.upper, node.step)
        return slice(*(None if end is None else evaluate(body, end, names) for end in ends))
    if isinstance(node, ast.Tuple):
        return tuple(index_of(body, each, names) for each in node.elts)
    return evaluate(body, node, names)


def _comprehension(body: Body, node: ast.ListComp | ast.GeneratorExp, names: Names) -> Any:
    from vvdp.generator.statements import assign

    found: list[Any] = []

    def go(left: list[ast.comprehension], inner: Names) -> None:
        if not left:
            found.append(body.bind(evaluate(body, node.elt, inner)))
            return
        items = known_items(body, evaluate(body, left[0].iter, inner))
        if len(items) > MOST_ROUNDS:
            raise refusal(f"a comprehension of {len(items)} rounds", "write a loop over an array")
        for each in items:
            inside = dict(inner)
            assign(body, left[0].target, each, inside)
            tests = [test_of(body, test, inside) for test in left[0].ifs]
            if any(map(is_symbol, tests)):
                raise refusal("a comprehension whose length is not known", "write a loop over an array")
            if all(tests):
                go(left[1:], inside)

    go(node.generators, names)
    return found


def _call(body: Body, node: ast.Call, names: Names) -> Any:
    function = evaluate(body, node.func, names)
    values = _spread(body, node.args, names)
    given = {}
    for each in node.keywords:
        if each.arg is None:
            raise refusal("`**` in a call", "name the arguments")
        given[each.arg] = evaluate(body, each.value, names)
    return call(body, function, values, given)


def call(body: Body, function: Any, values: list[Any], given: dict[str, Any]) -> Any:
    """`function(*values, **given)`."""
    if isinstance(getattr(function, "kind", None), Address):
        address = function if is_symbol(function) else Symbol(function.name, function.kind)
        return _call_address(body, address, values)
    if isinstance(function, Written):
        return _write_in_place(body, function.word, values, given)
    function = body.unit.replacement(function)
    word = body.unit.words.get(function) or _word(function)
    if word is not None:
        return _write_in_place(body, word, values, given)
    if isinstance(function, type) and issubclass(function, tuple) and hasattr(function, "_fields"):
        return body.bind(_write_in_place(body, lambda _, *v, **g: function(*v, **g), values, given))
    if isinstance(function, type) and issubclass(function, Enum):
        return function(*values)
    if any(function is each for each in FOLDED):
        return function(*(known_items(body, v) if is_record(v) or is_array(v) else v for v in values), **given)
    if _is_plain(inspect.unwrap(function)):
        return body.unit.call(body, function, tuple(values), given)
    raise refusal(f"a call of {describe(function)}", "use the listed functions (`vvdp list --language`)")


def _is_plain(function: Any) -> bool:
    """Whether something is a Python function, and none of a library's own."""
    return isinstance(function, types.FunctionType) and str(function.__module__).partition(".")[0] not in LIBRARIES


def _word(function: Any) -> Any:
    try:
        return WORDS.get(function)
    except TypeError:
        return None


def _write_in_place(body: Body, word: Any, values: list[Any], given: dict[str, Any]) -> Any:
    try:
        return word(body, *values, **given)
    except TypeError as problem:
        raise refusal(f"a call with other arguments ({problem})", "hand over what the function takes") from problem


def _call_address(body: Body, function: Any, values: list[Any]) -> Any:
    kind: Address = function.kind
    if len(values) != len(kind.arguments):
        raise refusal(f"{len(values)} arguments", f"hand over {len(kind.arguments)}")
    made = [body.as_kind(value, each) for value, each in zip(values, kind.arguments, strict=True)]
    arguments = tuple(each for each in made if each is not None)
    result: Scalar | Known = kind.result or Known(None)
    found = CallAddress(function, arguments, result)
    if kind.result is None:
        body.add(Do(found, body.line))
        return None
    return body.bind(found)


EVALUATED: dict[type[ast.expr], Callable[[Body, Any, Names], Any]] = {
    ast.Name: _name, ast.Constant: _constant, ast.Attribute: _attribute, ast.Call: _call, ast.BinOp: _binary,
    ast.UnaryOp: _unary, ast.Compare: _compare, ast.BoolOp: _truths, ast.IfExp: _conditional, ast.Tuple: _display,
    ast.List: _display, ast.Subscript: _subscript, ast.ListComp: _comprehension, ast.GeneratorExp: _comprehension,
    ast.JoinedStr: lambda body, node, names: "",
}  # fmt: skip

REFUSED: dict[type[ast.expr], tuple[str, str]] = {
    ast.Lambda: ("a lambda", "define a function with `def` at the top level"),
    ast.Dict: ("a dictionary", "use a NamedTuple"),
    ast.Set: ("a set", "use a tuple"),
    ast.DictComp: ("a dictionary", "use a NamedTuple"),
    ast.SetComp: ("a set", "use a tuple"),
    ast.NamedExpr: ("`:=`", "assign on a line of its own"),
    ast.Yield: ("`yield`", "return a value"),
    ast.Await: ("`await`", "call a plain function"),
}
"""Expressions that are not allowed, in words, and what to write instead."""
