"""The listed functions of Python, math and NumPy, and what each becomes in the tree."""

import ast
import builtins
import math
from collections.abc import Callable
from typing import Any

import numpy as np

from vvdp.generator import arithmetic, elementary
from vvdp.generator.arrays import (
    element,
    elementwise,
    fill,
    flat,
    item,
    made_array,
    reduce_array,
    reshape,
    room,
)
from vvdp.generator.body import Body, Word
from vvdp.generator.kinds import BOOL, FLOAT, INT, Scalar
from vvdp.generator.library import EXACT
from vvdp.generator.operations import choose, combine, compare, kind_of_number, truth, unary
from vvdp.generator.tree import Compare, Library
from vvdp.generator.values import (
    describe,
    is_array,
    is_number,
    is_record,
    is_symbol,
    lengths,
    parts,
    refusal,
)


def _library(name: str) -> Word:
    """A function of floats, of arrays number by number; a known argument is left to where the code runs."""

    def word(body: Body, *values: Any) -> Any:
        if any(map(is_array, values)):
            return elementwise(body, lambda *each: word(body, *each), *values)
        if name in EXACT and not any(map(is_symbol, values)):
            with np.errstate(all="ignore"):
                return float(EXACT[name][1](*values))
        return Library(name, tuple(body.number(value, FLOAT) for value in values), FLOAT)

    return word


def _function(plain: Callable[..., Any]) -> Word:
    """A function that is written in the language itself, of arrays number by number."""

    def word(body: Body, *values: Any) -> Any:
        if any(map(is_array, values)):
            return elementwise(body, lambda *each: word(body, *each), *values)
        return body.unit.call(body, plain, tuple(body.number(value, FLOAT) for value in values), {})

    return word


def _extreme(op: ast.cmpop) -> Word:
    """Python's `min` or `max`: the first of those than which none is smaller, or larger."""

    def better(body: Body, best: Any, value: Any) -> Any:
        best, value = body.bind(best), body.bind(value)
        if not is_symbol(best) and not is_symbol(value):
            return value if compare(body, op, value, best) else best
        return choose(body, compare(body, op, value, best), value, best)

    def word(body: Body, *values: Any) -> Any:
        if len(values) == 1 and is_array(values[0]):
            return reduce_array(body, values[0], lambda best, value: better(body, best, value), None)
        found, *others = parts(values[0]) if len(values) == 1 else values
        for value in others:
            found = better(body, found, value)
        return found

    return word


def _absolute(body: Body, value: Any) -> Any:
    if is_array(value):
        return elementwise(body, lambda each: _absolute(body, each), value)
    if not is_symbol(value):
        return abs(value)
    if kind_of_number(value) is FLOAT:
        return Library("fabs", (value,), FLOAT)
    value = body.bind(body.number(value, INT))
    return choose(body, compare(body, ast.Lt(), value, 0), unary(body, ast.USub(), value), value)


def _cast(kind: Scalar, plain: Callable[..., Any]) -> Word:
    def word(body: Body, value: Any = 0) -> Any:
        if kind is BOOL:
            return truth(body, value)
        if is_symbol(value):
            return body.number(value, kind)
        if not is_number(value):
            raise refusal(f"{describe(value)} where a number is expected", "use a number")
        return plain(value)

    return word


def _to_whole(name: str) -> Word:
    """math.floor and the like, which give whole numbers."""
    return lambda body, value: body.number(_library(name)(body, value), INT)


def _length(body: Body, value: Any) -> Any:
    if is_array(value):
        return lengths(value)[0]
    return len(parts(value)) if is_record(value) else len(value)


def _shape(body: Body, value: Any) -> Any:
    return tuple(lengths(value)) if is_array(value) else ()


def _element_kind(given: Any) -> Scalar:
    kinds = {None: FLOAT, float: FLOAT, np.float64: FLOAT, int: INT, np.int64: INT, np.intp: INT}
    if given not in kinds:
        raise refusal(f"an array of {describe(given)}", "use float64 or int64")
    return kinds[given]


def _fill_with(value: float | None) -> Word:
    def word(body: Body, shape: Any, dtype: Any = None) -> Any:
        made = room(body, shape, _element_kind(dtype))
        if value is not None:
            fill(body, made, value)
        return made

    return word


def _full(body: Body, shape: Any, value: Any, dtype: Any = None) -> Any:
    kind = kind_of_number(value) if dtype is None else _element_kind(dtype)
    made = room(body, shape, kind)
    fill(body, made, value)
    return made


def _like(value: float | None) -> Word:
    def word(body: Body, array: Any) -> Any:
        made = room(body, lengths(array), element(array))
        if value is not None:
            fill(body, made, value)
        return made

    return word


def _array(body: Body, values: Any, dtype: Any = None) -> Any:
    made = made_array(body, values)
    if dtype is None or element(made) is _element_kind(dtype):
        return made
    other = room(body, lengths(made), _element_kind(dtype))
    fill(body, other, made)
    return other


def _where(body: Body, test: Any, then: Any, otherwise: Any) -> Any:
    return choose(body, truth(body, test), body.bind(then), body.bind(otherwise))


def _is_finite(body: Body, value: Any) -> Any:
    return compare(body, ast.Lt(), _absolute(body, value), math.inf)


def _is_nan(body: Body, value: Any) -> Any:
    value = body.bind(body.number(value, FLOAT))
    return Compare("!=", value, value)


def _is_infinite(body: Body, value: Any) -> Any:
    return compare(body, ast.Eq(), _absolute(body, value), math.inf)


def _sum(body: Body, values: Any, start: Any = 0) -> Any:
    if is_array(values):
        return reduce_array(body, values, lambda total, value: combine(body, "+", total, value), start or 0.0)
    for value in parts(values):
        start = combine(body, "+", start, value)
    return start


def _copy(body: Body, array: Any) -> Any:
    return made_array(body, array)


def _dot(body: Body, one: Any, other: Any) -> Any:
    """The sum of products from left to right."""
    return _sum(body, elementwise(body, lambda a, b: combine(body, "*", a, b), one, other))


def _method(body: Body, array: Any) -> dict[str, Callable[..., Any]]:
    """Methods of an array."""
    return {
        "copy": lambda: made_array(body, array),
        "ravel": lambda: flat(body, array),
        "reshape": lambda *shape: reshape(body, array, shape[0] if len(shape) == 1 else shape),
        "sum": lambda: _sum(body, array),
        "min": lambda: WORDS[min](body, array),
        "max": lambda: WORDS[max](body, array),
        "fill": lambda value: fill(body, array, value),
        "item": lambda *index: item(body, flat(body, array), index[0] if index else 0),
    }


def array_attribute(body: Body, array: Any, name: str) -> Any:
    """`array.name`."""
    if name in ("size", "ndim", "shape"):
        count: Any = 1
        for length in lengths(array):
            count = combine(body, "*", count, length)
        return {"size": count, "ndim": len(lengths(array)), "shape": tuple(lengths(array))}[name]
    found = _method(body, array).get(name)
    if found is None:
        raise refusal(f"`.{name}` of an array", f"use one of {', '.join(sorted(_method(body, array)))}, or a loop")
    return Written(lambda _, *values: found(*values))


class Written:
    """Something that can be called while a function is read, and is written in place."""

    def __init__(self, word: Word) -> None:
        self.word = word


FROM_LIBRARY = {
    "exp": "exp", "expm1": "expm1", "exp2": "exp2", "log": "log", "log2": "log2", "log10": "log10", "tan": "tan",
    "sinh": "sinh", "cosh": "cosh", "tanh": "tanh", "acos": "arccos", "atan": "arctan", "atan2": "arctan2",
    "asinh": "arcsinh", "acosh": "arccosh", "atanh": "arctanh", "hypot": "hypot", "cbrt": "cbrt", "pow": "power",
    "fmod": "fmod", "nextafter": "nextafter", "copysign": "copysign", "sqrt": "sqrt", "fabs": "fabs", "trunc": "trunc",
}  # fmt: skip
"""By their names in the C library, the functions of math, and their names in NumPy."""

ELEMENTARY: dict[Callable[..., float], tuple[Any, Any]] = {
    elementary.sine: (math.sin, np.sin), elementary.cosine: (math.cos, np.cos),
    elementary.arcsine: (math.asin, np.arcsin), elementary.log_of_one_plus: (math.log1p, np.log1p),
}  # fmt: skip
"""Functions of math and NumPy, by the function of the language that replaces them."""

WORDS: dict[Any, Word] = {
    **{getattr(math, name): _library(name) for name in FROM_LIBRARY if name != "trunc"},
    **{getattr(np, name): _library(c_name) for c_name, name in FROM_LIBRARY.items()},
    **{function: _library(name) for name, function in (("floor", np.floor), ("ceil", np.ceil), ("rint", np.rint))},
    math.floor: _to_whole("floor"), math.ceil: _to_whole("ceil"), math.trunc: _to_whole("trunc"),
    **{word: _function(function) for function, named in ELEMENTARY.items() for word in named},
    elementary.far_sine: _library("sin"), elementary.far_cosine: _library("cos"),
    math.erf: _library("erf"), math.erfc: _library("erfc"), math.gamma: _library("tgamma"),
    math.lgamma: _library("lgamma"),
    abs: _absolute, np.absolute: _absolute,
    min: _extreme(ast.Lt()), max: _extreme(ast.Gt()), np.min: _extreme(ast.Lt()), np.max: _extreme(ast.Gt()),
    np.minimum: _function(arithmetic.smaller), np.maximum: _function(arithmetic.larger),
    np.sinc: _function(arithmetic.sinc),
    float: _cast(FLOAT, float), int: _cast(INT, int), bool: _cast(BOOL, bool),
    np.float64: _cast(FLOAT, float), np.int64: _cast(INT, int), np.intp: _cast(INT, int), np.bool_: _cast(BOOL, bool),
    np.isfinite: _is_finite, math.isfinite: _is_finite, np.isnan: _is_nan, math.isnan: _is_nan,
    np.isinf: _is_infinite, math.isinf: _is_infinite,
    np.zeros: _fill_with(0.0), np.ones: _fill_with(1.0), np.empty: _fill_with(None), np.full: _full,
    np.zeros_like: _like(0.0), np.ones_like: _like(1.0), np.empty_like: _like(None), np.copy: _copy,
    np.array: _array, np.asarray: _array, np.where: _where, np.sum: _sum, sum: _sum, np.dot: _dot,
    np.shape: _shape, len: _length,
}  # fmt: skip
"""Functions that code may call besides plain functions."""

FOLDED = (range, tuple, list, zip, enumerate, reversed)
"""Builtins that are calculated while a function is read; their arguments have known lengths."""


def word_names() -> list[str]:
    """The listed functions as people write them, in order."""
    homes = {"builtins": "", "math": "math."}
    listed = [f for f in WORDS if getattr(f, "__module__", "") != elementary.__name__]
    names = {f"{homes.get(getattr(f, '__module__', ''), 'np.')}{f.__name__}" for f in listed}
    return sorted(names | {f.__name__ for f in FOLDED if hasattr(builtins, f.__name__)})
