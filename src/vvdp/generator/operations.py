"""Operators: folded where both sides are known, else an expression of the tree."""

import ast
import operator
from collections.abc import Callable
from typing import Any

import numpy as np

from vvdp.generator import arithmetic, tree
from vvdp.generator.body import Body
from vvdp.generator.kinds import BOOL, FLOAT, INT, WIDTH, Scalar, number_kind
from vvdp.generator.values import describe, is_array, is_number, is_record, is_symbol, parts, refusal, type_of

SIGNS = {
    ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/", ast.FloorDiv: "//", ast.Mod: "%", ast.Pow: "**",
    ast.BitAnd: "&", ast.BitOr: "|", ast.BitXor: "^", ast.LShift: "<<", ast.RShift: ">>",
    ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">=", ast.Eq: "==", ast.NotEq: "!=",
}  # fmt: skip
PLAIN: dict[str, Callable[[Any, Any], Any]] = {
    "+": operator.add, "-": operator.sub, "*": operator.mul, "/": operator.truediv, "//": operator.floordiv,
    "%": operator.mod, "**": operator.pow, "&": operator.and_, "|": operator.or_, "^": operator.xor,
    "<<": operator.lshift, ">>": operator.rshift, "<": operator.lt, "<=": operator.le, ">": operator.gt,
    ">=": operator.ge, "==": operator.eq, "!=": operator.ne,
}  # fmt: skip
FLOORS: dict[str, Callable[..., Any]] = {"//": arithmetic.floor_quotient, "%": arithmetic.floor_remainder}
UNARY: dict[type[ast.unaryop], Callable[[Any], Any]] = {
    ast.USub: operator.neg,
    ast.UAdd: operator.pos,
    ast.Invert: operator.invert,
}
BITS = ("&", "|", "^")
SHIFTS = ("<<", ">>")
LARGEST_POWER = 0x10000


def kind_of_number(value: Any) -> Scalar:
    """The type of a number. Raises LanguageError where it is none."""
    found = number_kind(type_of(value))
    if found is None:
        raise refusal(f"{describe(value)} where a number is expected", "use numbers")
    return found


def widest(*values: Any) -> Scalar:
    """The type to which these numbers are converted where they meet."""
    return max(map(kind_of_number, values), key=WIDTH.__getitem__)


def binary(body: Body, op: ast.operator, left: Any, right: Any) -> Any:
    """`left op right`."""
    sign = SIGNS.get(type(op))
    if sign is None:
        raise refusal(f"the operator {type(op).__name__}", "write the sums out")
    return combine(body, sign, left, right)


def combine(body: Body, sign: str, left: Any, right: Any) -> Any:
    """`left sign right`, of numbers, of arrays element by element, or of tuples."""
    if is_array(left) or is_array(right):
        return _joined_arrays(body, sign, left, right)
    if is_record(left) or is_record(right):
        return _joined_tuples(sign, left, right)
    if not is_symbol(left) and not is_symbol(right):
        return _fold(body, sign, left, right)
    if sign == "**":
        return power(body, left, right)
    if sign == "/":
        return _divide(body, body.number(left, FLOAT), body.number(right, FLOAT))
    if sign in BITS or sign in SHIFTS:
        return _joined_bits(body, sign, left, right)
    if widest(left, right) is not FLOAT:
        return _whole(body, sign, body.number(left, INT), body.number(right, INT))
    floats = body.number(left, FLOAT), body.number(right, FLOAT)
    if sign in FLOORS:
        return body.unit.call(body, FLOORS[sign], floats, {})
    return tree.Binary(sign, *floats, FLOAT)


def _joined_arrays(body: Body, sign: str, left: Any, right: Any) -> Any:
    if not is_symbol(left) and not is_symbol(right):
        return PLAIN[sign](left, right)
    from vvdp.generator.arrays import elementwise

    return elementwise(body, lambda a, b: combine(body, sign, a, b), left, right)


def _joined_bits(body: Body, sign: str, left: Any, right: Any) -> Any:
    kind = INT if sign in SHIFTS else widest(left, right)
    if FLOAT in (kind, kind_of_number(left), kind_of_number(right)):
        raise refusal(f"`{sign}` of floats", "use whole numbers or truths")
    return tree.Binary(sign, body.number(left, kind), body.number(right, kind), kind)


def _joined_tuples(sign: str, left: Any, right: Any) -> Any:
    if sign == "+" and is_record(left) and is_record(right):
        return tuple(parts(left)) + tuple(parts(right))
    if sign == "*" and isinstance(right, int) and is_record(left):
        return tuple(parts(left)) * right
    raise refusal(f"`{sign}` of a tuple", "take its fields, or use an array")


def _fold(body: Body, sign: str, left: Any, right: Any) -> Any:
    """The value of an operation on known numbers; what the C library would have to do is left to it."""
    if not (is_number(left) and is_number(right)):
        return PLAIN[sign](left, right)
    kind = widest(left, right)
    if sign == "**" and (kind is FLOAT or right < 0):
        return power(body, body.number(left, kind), right)
    if kind is FLOAT and sign in ("//", "%", "/"):
        function: Callable[..., Any] = FLOORS.get(sign, operator.truediv)
        with np.errstate(all="ignore"):
            return float(function(np.float64(left), np.float64(right)))
    if sign in ("/", "//", "%") and right == 0:
        raise refusal("a division of whole numbers by 0", "divide by another number")
    return PLAIN[sign](left, right)


def _divide(body: Body, left: tree.Expression, right: tree.Expression) -> tree.Expression:
    if body.unit.checked and not isinstance(right, tree.Constant):
        right = body.bind(right)
        body.require(tree.Compare("!=", right, tree.Constant(FLOAT, 0.0)), "a division by zero")
    return tree.Binary("/", left, right, FLOAT)


def _whole(body: Body, sign: str, left: tree.Expression, right: tree.Expression) -> tree.Expression:
    """An operation on whole numbers, which in a checked unit must not leave 64 bits."""
    for one, other in ((left, right), (right, left)):
        if isinstance(one, tree.Constant) and (one.value, sign) in ((1, "*"), (0, "+")):
            return other
    if not body.unit.checked:
        return tree.Binary(sign, left, right, INT)
    left, right = body.bind(left), body.bind(right)
    if sign in ("//", "%"):
        body.require(tree.Compare("!=", right, tree.Constant(INT, 0)), "a division by zero")
        return tree.Binary(sign, left, right, INT)
    body.require(tree.Library(f"fits{sign}", (left, right), BOOL), "a whole number of more than 64 bits")
    return tree.Binary(sign, left, right, INT)


def power(body: Body, base: Any, exponent: Any) -> Any:
    """`base ** exponent`: a known whole exponent makes products, by squares; else pow of the C library."""
    if isinstance(exponent, int) and abs(exponent) <= LARGEST_POWER:
        base = body.bind(base)
        result: Any = None
        left = abs(exponent)
        while left:
            if left & 1:
                result = base if result is None else combine(body, "*", result, base)
            left >>= 1
            if left:
                base = body.bind(combine(body, "*", base, base))
        if result is None:
            return 1.0 if kind_of_number(base) is FLOAT else 1
        return combine(body, "/", 1.0, result) if exponent < 0 else result
    if widest(base, exponent) is not FLOAT:
        raise refusal("a whole number to a power that is not known", "write the power with floats")
    return tree.Library("pow", (body.number(base, FLOAT), body.number(exponent, FLOAT)), FLOAT)


def unary(body: Body, op: ast.unaryop, value: Any) -> Any:
    """`op value`."""
    if isinstance(op, ast.Not):
        return negate(truth(body, value))
    if is_array(value) and is_symbol(value):
        from vvdp.generator.arrays import elementwise

        return elementwise(body, lambda each: unary(body, op, each), value)
    if not is_symbol(value):
        return UNARY[type(op)](value)
    kind = kind_of_number(value)
    if isinstance(op, ast.Invert):
        if kind is not INT:
            raise refusal(f"`~` of {describe(value)}", "write `not`")
        return tree.Unary("~", value, INT)
    number = body.number(value, INT if kind is BOOL else kind)
    return number if isinstance(op, ast.UAdd) else tree.Unary("-", number, INT if kind is BOOL else kind)


def negate(value: Any) -> Any:
    """`not value`, of a truth."""
    return tree.Unary("not", value, BOOL) if is_symbol(value) else not value


def truth(body: Body, value: Any) -> Any:
    """Whether a value counts as true: known, or an expression."""
    if not is_symbol(value):
        if is_array(value):
            raise refusal("the truth of an array", "compare its numbers")
        return bool(value)
    if is_record(value):
        return bool(parts(value))
    if not is_number(value):
        raise refusal(f"the truth of {describe(value)}", "compare numbers")
    kind = kind_of_number(value)
    return value if kind is BOOL else tree.Compare("!=", value, body.number(0, kind))


def compare(body: Body, op: ast.cmpop, left: Any, right: Any) -> Any:
    """`left op right`."""
    if isinstance(op, ast.Is | ast.IsNot):
        if left is not None and right is not None and (is_symbol(left) or is_symbol(right)):
            raise refusal("`is` of numbers", "compare with `==`")
        return (left is right) == isinstance(op, ast.Is)
    if isinstance(op, ast.In | ast.NotIn):
        found = _is_in(body, left, right)
        return negate(found) if isinstance(op, ast.NotIn) else found
    sign = SIGNS[type(op)]
    if not is_symbol(left) and not is_symbol(right):
        return PLAIN[sign](left, right)
    if is_array(left) or is_array(right):
        raise refusal(f"`{sign}` of arrays", "compare number by number")
    kind = widest(left, right)
    return tree.Compare(sign, body.number(left, kind), body.number(right, kind))


def _is_in(body: Body, value: Any, items: Any) -> Any:
    if not is_record(items) and not isinstance(items, set | frozenset | range | str):
        raise refusal(f"`in` {describe(items)}", "name the values in a tuple")
    found: Any = False
    for item in parts(items) if is_record(items) else items:
        same = compare(body, ast.Eq(), value, item)
        if not is_symbol(same):
            if same:
                return True
        else:
            found = same if found is False else tree.Binary("|", found, same, BOOL)
    return found


def choose(body: Body, test: Any, then: Any, otherwise: Any) -> Any:
    """One of two numbers, both calculated."""
    if not is_symbol(test):
        return then if test else otherwise
    kind = widest(then, otherwise)
    return tree.Choose(test, body.number(then, kind), body.number(otherwise, kind))


def is_cheap(value: Any) -> bool:
    """Whether a value is at hand, so that it may as well be calculated where it is not used."""
    return not is_symbol(value) or isinstance(value, tree.Constant | tree.Read)
