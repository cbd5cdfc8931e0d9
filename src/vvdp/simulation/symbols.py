"""Numbers that remember how they were made: what a formula does with them becomes a graph of operations.

An operation on the same numbers is noted once. Nothing is rearranged, and left out is only what leaves every float as
it is, so that the graph has the values of the formula to the last bit, but for small whole powers, which are products.
"""

from collections.abc import Callable
from enum import Enum, auto
from typing import Any, NamedTuple

import numpy as np


class Untraceable(Exception):
    """A use of numbers in a circuit that cannot be written as a graph of operations; states the reason, for a user."""


class Op(Enum):
    """Kind of a node of a graph: a constant, one of the inputs, or an operation on other nodes."""

    CONSTANT = auto()
    TIME = auto()
    STATE = auto()
    COMMAND = auto()
    PARAMETER = auto()
    SIGNAL = auto()
    ADD = auto()
    SUBTRACT = auto()
    MULTIPLY = auto()
    DIVIDE = auto()
    NEGATIVE = auto()
    ABSOLUTE = auto()
    POWER = auto()
    SQRT = auto()
    EXP = auto()
    EXPM1 = auto()
    LOG = auto()
    LOG1P = auto()
    SIN = auto()
    COS = auto()
    TAN = auto()
    TANH = auto()
    ATAN = auto()
    FLOOR = auto()
    LESS = auto()
    AT_MOST = auto()
    EQUAL = auto()
    BOTH = auto()
    EITHER = auto()
    NOT = auto()
    SELECT = auto()


INPUTS = frozenset({Op.TIME, Op.STATE, Op.COMMAND, Op.PARAMETER, Op.SIGNAL})
SYMMETRIC = frozenset({Op.ADD, Op.MULTIPLY, Op.EQUAL, Op.BOTH, Op.EITHER})
"""Operations that give the same, to the last bit, with their two numbers exchanged."""
WHOLE_POWERS = 4
"""Up to which whole power a number is multiplied with itself, within an ulp or two of the power."""


class Node(NamedTuple):
    """An operation on nodes that come before it; `number` is a constant's value, or an input's place in its vector."""

    op: Op
    inputs: tuple[int, ...] = ()
    number: float = 0.0


class Recorder:
    """Notes the operations on its symbols, in the order in which they are asked for."""

    def __init__(self) -> None:
        self.nodes: list[Node] = []
        self._known: dict[tuple[object, ...], int] = {}

    def input(self, op: Op, place: int = 0) -> "Symbol":
        """The symbol of an input."""
        return Symbol(self, self._node(op, (), float(place)))

    def place(self, value: Any) -> int:
        """The node of a symbol, a condition or a plain number."""
        if isinstance(value, Symbol | Condition):
            return value.place
        if isinstance(value, bool | np.bool_) or np.ndim(value) or not isinstance(value, int | float | np.number):
            raise Untraceable(f"a number meets {_kind(value)}, with which it cannot be calculated")
        return self._node(Op.CONSTANT, (), float(value))

    def number(self, op: Op, *values: Any) -> Any:
        """The result of an operation."""
        same = self._same(op, values)
        return Symbol(self, self._node(op, tuple(map(self.place, values)))) if same is None else same

    def condition(self, op: Op, *values: Any) -> "Condition":
        """The result of a comparison, or of several joined."""
        return Condition(self, self._node(op, tuple(map(self.place, values))))

    def _node(self, op: Op, inputs: tuple[int, ...], number: float = 0.0) -> int:
        if op in SYMMETRIC:
            inputs = tuple(sorted(inputs))
        key = (op, inputs, number.hex())  # shows -0.0 from 0.0, and finds nan again
        if key not in self._known:
            self._known[key] = len(self.nodes)
            self.nodes.append(Node(op, inputs, number))
        return self._known[key]

    def _same(self, op: Op, values: tuple[Any, ...]) -> Any:
        """The one of `values` that the operation returns as it is, whatever float it stands for; None if it may not."""
        if op is Op.SELECT:
            return values[1] if self.place(values[1]) == self.place(values[2]) else None
        first, last = values[0], values[-1]
        if op is Op.MULTIPLY and _is(first, 1.0):
            return last
        if (op in (Op.MULTIPLY, Op.DIVIDE) and _is(last, 1.0)) or (op is Op.SUBTRACT and _is(last, 0.0)):
            return first
        # A signal is a sum already, and never -0.0.
        if op is Op.ADD and _is(last, 0.0) and self.nodes[self.place(first)].op is Op.SIGNAL:
            return first
        return None


class Symbol:
    """A number of which only the making is known."""

    ndim = 0

    def __init__(self, recorder: Recorder, place: int) -> None:
        self.recorder, self.place = recorder, place

    def __add__(self, other: Any) -> Any:
        return self.recorder.number(Op.ADD, self, other)

    def __radd__(self, other: Any) -> Any:
        return self.recorder.number(Op.ADD, other, self)

    def __sub__(self, other: Any) -> Any:
        return self.recorder.number(Op.SUBTRACT, self, other)

    def __rsub__(self, other: Any) -> Any:
        return self.recorder.number(Op.SUBTRACT, other, self)

    def __mul__(self, other: Any) -> Any:
        return self.recorder.number(Op.MULTIPLY, self, other)

    def __rmul__(self, other: Any) -> Any:
        return self.recorder.number(Op.MULTIPLY, other, self)

    def __truediv__(self, other: Any) -> Any:
        return self.recorder.number(Op.DIVIDE, self, other)

    def __rtruediv__(self, other: Any) -> Any:
        return self.recorder.number(Op.DIVIDE, other, self)

    def __pow__(self, other: Any) -> Any:
        return power(self, other)

    def __rpow__(self, other: Any) -> Any:
        return self.recorder.number(Op.POWER, other, self)

    def __neg__(self) -> Any:
        return self.recorder.number(Op.NEGATIVE, self)

    def __pos__(self) -> Any:
        return self

    def __abs__(self) -> Any:
        return self.recorder.number(Op.ABSOLUTE, self)

    def __lt__(self, other: Any) -> "Condition":
        return self.recorder.condition(Op.LESS, self, other)

    def __le__(self, other: Any) -> "Condition":
        return self.recorder.condition(Op.AT_MOST, self, other)

    def __gt__(self, other: Any) -> "Condition":
        return self.recorder.condition(Op.LESS, other, self)

    def __ge__(self, other: Any) -> "Condition":
        return self.recorder.condition(Op.AT_MOST, other, self)

    def __eq__(self, other: object) -> Any:
        return self.recorder.condition(Op.EQUAL, self, other)

    def __ne__(self, other: object) -> Any:
        return ~self.recorder.condition(Op.EQUAL, self, other)

    __hash__ = None  # type: ignore[assignment]

    def __array_ufunc__(self, ufunc: np.ufunc, method: str, *values: Any, **options: Any) -> Any:
        return _apply_ufunc(ufunc, method, values, options)

    def __bool__(self) -> bool:
        raise Untraceable("an `if`, `and`, `or`, `min` or `max` asks for the value of a number; use select and minimum")

    def __float__(self) -> float:
        raise Untraceable("a number is asked for its value, by float() or a function of math; use those of numpy")

    __int__ = __index__ = __float__


class Condition:
    """Something that holds or does not, of which only the making is known."""

    ndim = 0

    def __init__(self, recorder: Recorder, place: int) -> None:
        self.recorder, self.place = recorder, place

    def select(self, a: Any, b: Any) -> Any:
        """`a` where it holds, else `b`."""
        return self.recorder.number(Op.SELECT, self, a, b)

    def __and__(self, other: Any) -> Any:
        return self._join(Op.BOTH, other)

    def __or__(self, other: Any) -> Any:
        return self._join(Op.EITHER, other)

    def __invert__(self) -> "Condition":
        return self.recorder.condition(Op.NOT, self)

    __rand__, __ror__ = __and__, __or__

    def __array_ufunc__(self, ufunc: np.ufunc, method: str, *values: Any, **options: Any) -> Any:
        return _apply_ufunc(ufunc, method, values, options)

    def __bool__(self) -> bool:
        raise Untraceable("an `if`, `and`, `or` or `not` asks whether something holds; use select, &, | and ~")

    def _join(self, op: Op, other: Any) -> Any:
        if isinstance(other, bool | np.bool_):
            if op is Op.BOTH:
                return self if other else False
            return True if other else self
        if not isinstance(other, Condition):
            raise Untraceable(f"a condition is joined with {_kind(other)}")
        return self.recorder.condition(op, self, other)


def power(base: Any, exponent: Any) -> Any:
    """`base ** exponent`; a product where the exponent is a small whole number."""
    if isinstance(exponent, Symbol) or not 0 < abs(exponent) <= WHOLE_POWERS or exponent % 1:
        return _recorder((base, exponent)).number(Op.POWER, base, exponent)
    if exponent < 0:
        return 1.0 / power(base, -exponent)
    half, odd = divmod(int(exponent), 2)
    square = power(base * base, half) if half else None
    if square is None:
        return base
    return square * base if odd else square


def _apply_ufunc(ufunc: np.ufunc, method: str, values: tuple[Any, ...], options: Any) -> Any:
    """The result of a function of NumPy."""
    if method != "__call__" or options or ufunc not in UFUNCS or any(map(np.ndim, values)):
        raise Untraceable(f"numpy.{ufunc.__name__} is not among the functions that can be traced")
    return UFUNCS[ufunc](_recorder(values), *values)


def _recorder(values: tuple[Any, ...]) -> Recorder:
    found: Recorder = next(value.recorder for value in values if isinstance(value, Symbol | Condition))
    return found


def _is(value: Any, number: float) -> bool:
    """Whether `value` is this plain number; -0.0 is not 0.0."""
    return isinstance(value, int | float) and not isinstance(value, bool) and float(value).hex() == number.hex()


def _kind(value: Any) -> str:
    return "an array" if np.ndim(value) else f"a {type(value).__name__}"


def _plain(op: Op) -> Callable[..., Any]:
    return lambda recorder, *values: recorder.number(op, *values)


def _comparison(op: Op) -> Callable[..., Any]:
    return lambda recorder, *values: recorder.condition(op, *values)


UFUNCS: dict[np.ufunc, Callable[..., Any]] = {
    np.add: _plain(Op.ADD),
    np.subtract: _plain(Op.SUBTRACT),
    np.multiply: _plain(Op.MULTIPLY),
    np.divide: _plain(Op.DIVIDE),
    np.negative: _plain(Op.NEGATIVE),
    np.positive: lambda _, value: value,
    np.absolute: _plain(Op.ABSOLUTE),
    np.square: lambda _, value: value * value,
    np.power: lambda _, base, exponent: power(base, exponent),
    np.float_power: lambda _, base, exponent: power(base, exponent),
    np.sqrt: _plain(Op.SQRT),
    np.exp: _plain(Op.EXP),
    np.expm1: _plain(Op.EXPM1),
    np.log: _plain(Op.LOG),
    np.log1p: _plain(Op.LOG1P),
    np.sin: _plain(Op.SIN),
    np.cos: _plain(Op.COS),
    np.tan: _plain(Op.TAN),
    np.tanh: _plain(Op.TANH),
    np.arctan: _plain(Op.ATAN),
    np.floor: _plain(Op.FLOOR),
    np.less: _comparison(Op.LESS),
    np.less_equal: _comparison(Op.AT_MOST),
    np.greater: lambda recorder, a, b: recorder.condition(Op.LESS, b, a),
    np.greater_equal: lambda recorder, a, b: recorder.condition(Op.AT_MOST, b, a),
    np.equal: _comparison(Op.EQUAL),
    np.not_equal: lambda recorder, a, b: ~recorder.condition(Op.EQUAL, a, b),
    np.logical_and: lambda _, a, b: a & b,
    np.logical_or: lambda _, a, b: a | b,
    np.logical_not: lambda _, a: ~a,
    np.bitwise_and: lambda _, a, b: a & b,
    np.bitwise_or: lambda _, a, b: a | b,
    np.invert: lambda _, a: ~a,
}
"""Operation on symbols of each function of NumPy."""
