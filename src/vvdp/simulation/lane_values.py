"""Vectors in code under construction: operators on them write instructions for many cases side by side, the lanes.

A loop over lanes cannot be left to the compiler, which calls powers and exponentials one by one.
"""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any

from llvmlite import ir

DOUBLE, INTEGER, TRUTH = ir.DoubleType(), ir.IntType(64), ir.IntType(1)
ROUNDING = 1.5 * 2.0**52
"""Added to a number below 2^51, it leaves the nearest whole number in the last bits."""


class Code:
    """A place where vector instructions are written.

    width  how many lanes a vector has; 1 writes plain numbers, which LLVM handles better than vectors of one
    fused  whether the processor multiplies and adds with one rounding
    """

    def __init__(self, builder: Any, width: int, fused: bool) -> None:
        self.builder, self.width, self.fused = builder, width, fused

    def vector(self, value: Any) -> "Vector":
        """A plain number in all lanes; a vector as it is."""
        return value if isinstance(value, Vector) else self.constants([float(value)] * self.width)

    def constants(self, values: Sequence[float]) -> "Vector":
        """A vector with these numbers in its lanes."""
        return Vector(self, self._constant(DOUBLE, list(values)))

    def whole(self, value: int) -> Any:
        """An integer in all lanes."""
        return self._constant(INTEGER, [value] * self.width)

    def whole_truth(self) -> Any:
        """Truth in all lanes."""
        return self._constant(TRUTH, [1] * self.width)

    def kind(self, one: Any) -> Any:
        """The type of a vector of `one`."""
        return one if self.width == 1 else ir.VectorType(one, self.width)

    def _constant(self, one: Any, values: list[Any]) -> Any:
        return ir.Constant(self.kind(one), values[0] if self.width == 1 else values)

    def floats(self, integers: Any) -> "Vector":
        """The numbers that have these bits."""
        return Vector(self, self.builder.bitcast(integers, self.kind(DOUBLE)))

    def call(self, name: str, *values: Any) -> "Vector":
        """An operation of the processor that LLVM knows by `name`."""
        kind, suffix = self.kind(DOUBLE), "f64" if self.width == 1 else f"v{self.width}f64"
        found = declare(self.builder.module, f"llvm.{name}.{suffix}", kind, [kind] * len(values))
        return Vector(self, self.builder.call(found, [self.vector(value).value for value in values]))

    def scalar(self, name: str, value: "Vector") -> "Vector":
        """A function of the C library, lane by lane: for what is rare."""
        found = declare(self.builder.module, name, DOUBLE, [DOUBLE])
        if self.width == 1:
            return Vector(self, self.builder.call(found, [value.value]))
        result = value.value
        for lane in range(self.width):
            place = ir.Constant(ir.IntType(32), lane)
            one = self.builder.call(found, [self.builder.extract_element(value.value, place)])
            result = self.builder.insert_element(result, one, place)
        return Vector(self, result)

    def multiply_add(self, a: Any, b: Any, c: Any) -> "Vector":
        """`a b + c`, with one rounding where the processor can."""
        if self.fused:
            return self.call("fma", a, b, c)
        result: Vector = self.vector(a) * b + c
        return result

    def product(self, a: "Vector", b: "Vector") -> tuple["Vector", "Vector"]:
        """`a b`, and what its rounding has taken away, exactly."""
        p = a * b
        if self.fused:
            return p, self.call("fma", a, b, -p)
        (ah, al), (bh, bl) = _halves(a), _halves(b)
        return p, ((ah * bh - p) + ah * bl + al * bh) + al * bl

    def polynomial(self, x: "Vector", coefficients: Sequence[float]) -> "Vector":
        """`sum(c[i] x^i)`, in halves, which do not wait for each other."""
        powers, terms = x, [self.vector(c) for c in coefficients]
        while len(terms) > 1:
            pairs = [self.multiply_add(b, powers, a) for a, b in zip(terms[::2], terms[1::2], strict=False)]
            terms, powers = pairs + terms[len(pairs) * 2 :], powers * powers
        return terms[0]

    @contextmanager
    def where_any(self, mask: "Mask", result: "Vector") -> Iterator[list["Vector"]]:
        """Writes instructions that seldom run; the list takes what replaces `result` then, and what holds after."""
        before = self.builder.block
        bits = self.builder.bitcast(mask.value, ir.IntType(self.width))
        held = [result]
        with self.builder.if_then(self.builder.icmp_unsigned("!=", bits, ir.Constant(bits.type, 0)), likely=False):
            yield held
            inside = self.builder.block
        joined = self.builder.phi(result.value.type)
        joined.add_incoming(result.value, before)
        joined.add_incoming(held[0].value, inside)
        held[0] = Vector(self, joined)


class Vector:
    """A number for each lane."""

    def __init__(self, code: Code, value: Any) -> None:
        self.code, self.value = code, value

    @property
    def bits(self) -> Any:
        """The bits of the numbers, as integers."""
        return self.code.builder.bitcast(self.value, self.code.kind(INTEGER))

    def __add__(self, other: Any) -> "Vector":
        return self._of(self.code.builder.fadd, self, other)

    def __radd__(self, other: Any) -> "Vector":
        return self._of(self.code.builder.fadd, other, self)

    def __sub__(self, other: Any) -> "Vector":
        return self._of(self.code.builder.fsub, self, other)

    def __rsub__(self, other: Any) -> "Vector":
        return self._of(self.code.builder.fsub, other, self)

    def __mul__(self, other: Any) -> "Vector":
        return self._of(self.code.builder.fmul, self, other)

    def __rmul__(self, other: Any) -> "Vector":
        return self._of(self.code.builder.fmul, other, self)

    def __truediv__(self, other: Any) -> "Vector":
        return self._of(self.code.builder.fdiv, self, other)

    def __rtruediv__(self, other: Any) -> "Vector":
        return self._of(self.code.builder.fdiv, other, self)

    def __neg__(self) -> "Vector":
        return Vector(self.code, self.code.builder.fneg(self.value))

    def __abs__(self) -> "Vector":
        return self.code.call("fabs", self)

    def __lt__(self, other: Any) -> "Mask":
        return self._compare("<", other)

    def __le__(self, other: Any) -> "Mask":
        return self._compare("<=", other)

    def __gt__(self, other: Any) -> "Mask":
        return self._compare(">", other)

    def equals(self, other: Any) -> "Mask":
        """Where both are the same; nowhere where one is NaN."""
        return self._compare("==", other)

    def _compare(self, sign: str, other: Any) -> "Mask":
        return Mask(self.code, self.code.builder.fcmp_ordered(sign, self.value, self.code.vector(other).value))

    def _of(self, instruction: Any, a: Any, b: Any) -> "Vector":
        return Vector(self.code, instruction(self.code.vector(a).value, self.code.vector(b).value))


class Mask:
    """Something that holds in some lanes."""

    def __init__(self, code: Code, value: Any) -> None:
        self.code, self.value = code, value

    def select(self, a: Any, b: Any) -> Vector:
        """`a` where it holds, else `b`."""
        chosen = self.code.builder.select(self.value, self.code.vector(a).value, self.code.vector(b).value)
        return Vector(self.code, chosen)

    def __and__(self, other: "Mask") -> "Mask":
        return Mask(self.code, self.code.builder.and_(self.value, other.value))

    def __or__(self, other: "Mask") -> "Mask":
        return Mask(self.code, self.code.builder.or_(self.value, other.value))

    def __invert__(self) -> "Mask":
        return Mask(self.code, self.code.builder.xor(self.value, self.code.whole_truth()))


def declare(module: Any, name: str, result: Any, arguments: Sequence[Any]) -> Any:
    """A function that is known to `module` by its name only."""
    if name not in module.globals:
        ir.Function(module, ir.FunctionType(result, arguments), name)
    return module.globals[name]


def _halves(a: Vector) -> tuple[Vector, Vector]:
    """The upper 26 bits of a number, and the rest."""
    scaled = a * (2.0**27 + 1.0)
    high = scaled - (scaled - a)
    return high, a - high
