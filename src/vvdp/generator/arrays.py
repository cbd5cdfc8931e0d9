"""Arrays: their numbers, slices, element-wise work and sums, all written as loops over numbers."""

import ast
from collections.abc import Callable
from typing import Any

import numpy as np

from vvdp.generator import tree
from vvdp.generator.body import Body
from vvdp.generator.kinds import FLOAT, INT, Row, Scalar
from vvdp.generator.operations import choose, combine, compare, kind_of_number
from vvdp.generator.values import (
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

Index = Any
"""A number, a slice, or a tuple of both."""


def row_of(body: Body, array: Any) -> tree.Expression:
    """An array as an expression at hand."""
    found: tree.Expression = body.bind(body.array(array), "row")
    return found


def element(array: Any) -> Scalar:
    """The type of an array's numbers."""
    kind = type_of(array)
    if isinstance(kind, Row):
        return kind.element
    return INT if array.dtype.kind in "iu" else FLOAT


def total(body: Body, array: Any) -> Any:
    """How many numbers an array has."""
    count: Any = 1
    for length in lengths(array):
        count = combine(body, "*", count, length)
    return body.bind(count, "count")


def flat(body: Body, array: Any) -> Any:
    """The numbers of an array as a row."""
    if len(lengths(array)) == 1:
        return row_of(body, array)
    return _view(body, row_of(body, array), 0, (total(body, array),))


def reshape(body: Body, array: Any, shape: Any) -> Any:
    """The numbers of an array in another shape."""
    sizes = tuple(parts(shape)) if is_record(shape) else (shape,)
    return _view(body, row_of(body, array), 0, sizes)


def _view(body: Body, array: tree.Expression, offset: Any, sizes: tuple[Any, ...]) -> Any:
    kind = Row(element(array), tuple(n if isinstance(n, int) else None for n in sizes))
    numbers = tuple(body.bind(body.number(n, INT)) for n in sizes)
    return body.bind(tree.View(array, body.bind(body.number(offset, INT)), numbers, kind), "row")


def room(body: Body, shape: Any, kind: Scalar) -> Any:
    """A new array whose numbers are not set; in a checked unit they are NaN."""
    sizes = tuple(parts(shape)) if is_record(shape) else (shape,)
    known = tuple(n if isinstance(n, int) else None for n in sizes)
    made = body.bind(tree.Room(tuple(body.bind(body.number(n, INT)) for n in sizes), Row(kind, known)), "row")
    if body.unit.checked and kind is FLOAT:
        fill(body, made, float("nan"))
    return made


def each(body: Body, count: Any, do: Callable[[Any], None]) -> None:
    """`do` for every number from 0 to below `count`: written out where these are few and known."""
    if isinstance(count, int) and count <= body.unit.options.unrolled:
        for i in range(count):
            do(i)
        return
    variable = body.variable("i", INT)
    inside: list[Any] = []
    with body.within(inside):
        do(tree.Read(variable))
    limits = tree.Constant(INT, 0), body.number(count, INT), tree.Constant(INT, 1)
    body.add(tree.For(variable, limits, inside, [], body.line))


def elementwise(body: Body, function: Callable[..., Any], *values: Any) -> Any:
    """A new array of what `function` gives for the numbers of arrays of one shape, and for single numbers."""
    rows = [value for value in values if is_array(value)]
    largest = max(rows, key=lambda row: len(lengths(row)))
    if any(len(lengths(row)) != len(lengths(largest)) for row in rows):
        raise refusal("arrays of different ranks", "write a loop")
    count = total(body, largest)
    for row in rows if body.unit.checked else ():
        same = compare(body, ast.Eq(), total(body, row), count)
        if is_symbol(same):
            body.require(same, "arrays of different lengths")
    sources = [flat(body, value) if is_array(value) else body.bind(value) for value in values]
    kinds = [tree.Constant(element(v), 0) if is_array(v) else v for v in values]
    kind = kind_of_number(_trial(body, function, kinds))
    made = room(body, lengths(largest), kind)
    target = flat(body, made)

    def one(i: Any) -> None:
        numbers = [item(body, value, i) if is_array(value) else value for value in sources]
        put(body, target, i, function(*numbers))

    each(body, count, one)
    return made


def _trial(body: Body, function: Callable[..., Any], values: list[Any]) -> Any:
    """The value of `function` for such values; nothing of it is kept."""
    with body.within([]):
        return function(*(tree.Read(body.variable("x", v.kind)) if isinstance(v, tree.Constant) else v for v in values))


def fill(body: Body, target: Any, value: Any) -> None:
    """Writes a number everywhere, or numbers from an array or a tuple of as many, to an array."""
    row = flat(body, target)
    if is_record(value):
        for i, one in enumerate(_numbers(parts(value))):
            put(body, row, i, one)
        return
    source = flat(body, value) if is_array(value) else body.bind(value)
    each(body, total(body, row), lambda i: put(body, row, i, item(body, source, i) if is_array(source) else source))


def _numbers(values: Any) -> list[Any]:
    """All numbers of nested tuples."""
    return [one for value in values for one in (_numbers(parts(value)) if is_record(value) else [value])]


def made_array(body: Body, values: Any) -> Any:
    """A new array with the numbers of an array, or of tuples of one length."""
    if is_array(values):
        made = room(body, lengths(values), element(values))
        fill(body, made, values)
        return made
    rows = list(parts(values))
    shape: tuple[int, ...] = (len(rows),)
    if rows and is_record(rows[0]):
        shape = (len(rows), len(parts(rows[0])))
    whole = all(kind_of_number(one) is not FLOAT for one in _numbers(rows)) and bool(rows)
    made = room(body, shape, INT if whole else FLOAT)
    fill(body, made, tuple(rows))
    return made


def _position(body: Body, array: Any, axis: int, index: Any) -> Any:
    """An index along an axis; a known one may count from the end."""
    if not is_number(index) or kind_of_number(index) is FLOAT:
        raise refusal(f"{describe(index)} as an index", "use a whole number")
    length = lengths(array)[axis]
    if isinstance(index, int | np.integer) and index < 0:
        index = combine(body, "+", length, int(index))
    index = body.bind(index, "i")
    if body.unit.checked and (is_symbol(index) or is_symbol(length)):
        body.require(compare(body, ast.GtE(), index, 0), "an index below 0")
        body.require(compare(body, ast.Lt(), index, length), "an index behind the end of an array")
    elif not is_symbol(index) and not is_symbol(length) and not 0 <= index < length:
        raise refusal(f"index {index} of an array of {length}", "stay within the array")
    return index


def item(body: Body, array: Any, index: Index) -> Any:
    """`array[index]`: a number, or a view of what is left where there is a slice or fewer indexes than axes."""
    found = index if isinstance(index, tuple) else (index,)
    if isinstance(array, np.ndarray) and not is_symbol(found):
        return _plain(array[index])
    row = row_of(body, array)
    if len(found) > len(lengths(row)):
        raise refusal(f"{len(found)} indexes of an array of rank {len(lengths(row))}", "use one for each axis")
    if len(found) == len(lengths(row)) and not any(isinstance(one, slice) for one in found):
        places = tuple(body.number(_position(body, row, axis, one), INT) for axis, one in enumerate(found))
        return body.bind(tree.Item(row, places, element(row)), "x")
    return _section(body, row, found)


def _plain(value: Any) -> Any:
    return value.item() if np.ndim(value) == 0 else np.ascontiguousarray(value)


def _section(body: Body, row: Any, index: tuple[Any, ...]) -> Any:
    """A view of neighbouring rows, or of part of one."""
    offset: Any = 0
    shape = lengths(row)
    left: list[Any] = []
    for axis, one in enumerate(index):
        stride: Any = 1
        for length in shape[axis + 1 :]:
            stride = combine(body, "*", stride, length)
        if isinstance(one, slice):
            if axis + 1 < len(index) or any(n != 1 for n in left):
                raise refusal("a slice before an index", "slice the last index only")
            first, count = _range(body, row, axis, one)
            left.append(count)
        else:
            first = _position(body, row, axis, one)
        offset = combine(body, "+", offset, combine(body, "*", first, stride))
    return _view(body, row, offset, (*left, *shape[len(index) :]))


def _range(body: Body, row: Any, axis: int, given: slice) -> tuple[Any, Any]:
    """Where a slice begins, and how many numbers it has."""
    if given.step is not None:
        raise refusal("a slice with a step", "write a loop")
    length = lengths(row)[axis]
    first, last = (_end(body, length, end) for end in (given.start or 0, length if given.stop is None else given.stop))
    if body.unit.checked and any(map(is_symbol, (first, last, length))):
        for low, high in ((0, first), (first, last), (last, length)):
            body.require(compare(body, ast.LtE(), low, high), "a slice that is not within its array")
    return first, body.bind(combine(body, "-", last, first), "count")


def _end(body: Body, length: Any, end: Any) -> Any:
    if isinstance(end, int) and end < 0:
        end = combine(body, "+", length, end)
    if isinstance(end, int) and isinstance(length, int):
        end = min(end, length)
    return body.bind(end, "i")


def put(body: Body, array: Any, index: Index, value: Any) -> None:
    """`array[index] = value`."""
    if isinstance(array, np.ndarray):
        raise refusal("a change of an array that is no argument", "copy it with `.copy()` first")
    if not is_array(array):
        raise refusal(f"a change of {describe(array)}", "make a new value, with `_replace`")
    found = index if isinstance(index, tuple) else (index,)
    if len(found) < len(lengths(array)) or any(isinstance(one, slice) for one in found):
        fill(body, item(body, array, index), value)
        return
    row = row_of(body, array)
    places = tuple(body.number(_position(body, row, axis, one), INT) for axis, one in enumerate(found))
    body.add(tree.Store(row, places, body.number(value, element(row)), body.line))


def entry(body: Body, values: Any, index: Any) -> Any:
    """`values[index]` of a tuple: known, or chosen among numbers by an index that is not."""
    if isinstance(index, int | slice):
        try:
            return part(values, index) if isinstance(index, int) else parts(values)[index]
        except IndexError:
            raise refusal(f"index {index} of a tuple of {len(parts(values))}", "stay within the tuple") from None
    numbers = parts(values)
    if not (is_number(index) and numbers and all(map(is_number, numbers))):
        raise refusal("an index of a tuple that is not known", "use an array, or a tuple of numbers only")
    if not any(map(is_symbol, numbers)):
        return item(body, body.unit.constant_row(tuple(numbers)), index)
    index = body.bind(index)
    found = numbers[-1]
    for i in range(len(numbers) - 2, -1, -1):
        found = choose(body, compare(body, ast.Eq(), index, i), numbers[i], found)
    return found


def reduce_array(body: Body, array: Any, step: Callable[[Any, Any], Any], start: Any) -> Any:
    """The numbers of an array joined by `step` from left to right; without `start` from the first one."""
    row = flat(body, array)
    kind = element(row) if start is None else kind_of_number(combine(body, "+", start, tree.Constant(element(row), 0)))
    result = body.variable("sum", kind)
    body.add(tree.Set((result,), (body.number(item(body, row, 0) if start is None else start, kind),), body.line))

    def one(i: Any) -> None:
        value = step(tree.Read(result), item(body, row, i))
        body.add(tree.Set((result,), (body.number(value, kind),), body.line))

    each(body, total(body, row), one)
    return body.bind(tree.Read(result))
