"""Nested values as structs of C, in which every number is a double, in the order of `simulation.values.flat`."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.kinds import Kind
from vvdp.base.params import field_kinds
from vvdp.generator.c_text import constant, member_name
from vvdp.generator.kinds import FLOAT
from vvdp.simulation.values import flat, names

INDENT = "    "


def struct_text(name: str, value: Any, about: str) -> str:
    """The definition of a struct for values like `value`, each member with its unit."""
    lines = [f"/* {about} */", "typedef struct {", *_members(value, 1), f"}} {name};", ""]
    return "\n".join(lines)


def initial_text(kind: str, name: str, value: Any, about: str) -> str:
    """A constant with the numbers of `value`."""
    lines = [f"/* {about} */", f"const {kind} {name} = {{", *_numbers(value, 1), "};", ""]
    return "\n".join(lines)


def _fields(value: Any) -> Iterator[tuple[str, Any, Kind | None]]:
    """Name in C, value and kind of each field in which there is a number."""
    kinds = field_kinds(type(value))
    for name in names(value):
        part = getattr(value, name)
        if flat(part).size:
            yield member_name(name), part, kinds.get(name)


def _members(value: Any, depth: int) -> list[str]:
    found, space = list[str](), INDENT * depth
    for name, part, kind in _fields(value):
        if names(part):
            found += [f"{space}struct {{", *_members(part, depth + 1), f"{space}}} {name};"]
            continue
        lengths = "".join(f"[{length}]" for length in np.shape(part))
        found.append(f"{space}double {name}{lengths};{unit_comment(kind)}")
    return found


def unit_comment(kind: Kind | None) -> str:
    """Unit and name of a kind as a comment."""
    return f" /* [{kind.unit}] {kind.name} */" if kind is not None else ""


def _numbers(value: Any, depth: int) -> list[str]:
    found, space = list[str](), INDENT * depth
    for name, part, kind in _fields(value):
        if names(part):
            found += [f"{space}.{name} = {{", *_numbers(part, depth + 1), f"{space}}},"]
        elif np.ndim(part):
            found += [
                f"{space}.{name} = {{",
                *_array(np.asarray(part, float), depth + 1),
                f"{space}}},{unit_comment(kind)}",
            ]
        else:
            found.append(f"{space}.{name} = {constant(FLOAT, float(part))},{unit_comment(kind)}")
    return found


def _array(array: Array, depth: int) -> list[str]:
    space = INDENT * depth
    if array.ndim > 1:
        return [f"{space}{{ {', '.join(constant(FLOAT, float(x)) for x in np.ravel(row))} }}," for row in array]
    numbers = [constant(FLOAT, float(x)) for x in array]
    return [f"{space}{', '.join(numbers[i : i + 6])}," for i in range(0, len(numbers), 6)]


class Classes:
    """Names under which the text of an entry knows the classes of its values."""

    def __init__(self) -> None:
        self.names: dict[type, str] = {}

    def name(self, cls: type) -> str:
        """The name of a class."""
        return self.names.setdefault(cls, f"T{len(self.names)}_{cls.__name__}")


def value_text(value: Any, vector: str, place: Iterator[int], classes: Classes) -> str:
    """Python text that makes a value like `value` from a flat vector; `place` counts its numbers."""
    if inner := names(value):
        parts = [value_text(getattr(value, name), vector, place, classes) for name in inner]
        return f"{classes.name(type(value))}({', '.join(parts)})"
    shape = np.shape(value)
    if not shape:
        return f"{vector}[{next(place)}]"
    count = int(np.prod(shape))
    begin = next(place) if count else 0
    for _ in range(count - 1):
        next(place)
    row = f"{vector}[{begin}:{begin + count}]"
    return row if len(shape) == 1 else f"{row}.reshape({shape!r})"


def store_lines(value: Any, path: str, vector: str, place: int = 0) -> list[str]:
    """Python text that writes a value like `value`, named `path`, to a flat vector from `place` on."""
    if inner := names(value):
        lines = []
        for name in inner:
            lines += store_lines(getattr(value, name), f"{path}.{name}", vector, place)
            place += flat(getattr(value, name)).size
        return lines
    count = flat(value).size
    if not np.ndim(value):
        return [f"{vector}[{place}] = {path}"]
    row = path if np.ndim(value) == 1 else f"{path}.ravel()"
    return [f"{vector}[{place}:{place + count}] = {row}"] if count else []
