"""The text of functions over flat vectors: values built from them and written back to them."""

import dataclasses
from collections.abc import Iterator
from typing import Any

import numpy as np

from vvdp.base.signal import Signal
from vvdp.simulation.layout import SIGNAL_SLOTS, arrays
from vvdp.simulation.values import flat, names


class Classes:
    """Names under which a text knows the classes of a case's values."""

    def __init__(self) -> None:
        self.names: dict[type, str] = {}

    def name(self, cls: type) -> str:
        """The name of a class; a new one where it has none yet."""
        return self.names.setdefault(cls, f"T{len(self.names)}_{cls.__name__}")

    def tuples(self) -> Iterator[tuple[str, type]]:
        """Name and class of every NamedTuple."""
        return ((name, cls) for cls, name in self.names.items() if not dataclasses.is_dataclass(cls))

    def records(self) -> Iterator[tuple[str, type]]:
        """Name and class of every dataclass, that is of every parameter class."""
        return ((name, cls) for cls, name in self.names.items() if dataclasses.is_dataclass(cls))


@dataclasses.dataclass
class Place:
    """A place in a vector: so many numbers behind one that is known, or is calculated where the text runs."""

    offset: int = 0
    base: str = ""

    def __str__(self) -> str:
        return f"{self.base} + {self.offset}" if self.base else str(self.offset)


def parameters(value: Any, place: Place, classes: Classes) -> str:
    """Source that makes `value` from its block of the parameters `p`; `place` is moved behind it."""
    if isinstance(value, Signal):
        return f"signal(t, {', '.join(_number('p', place) for _ in range(SIGNAL_SLOTS))}, p)"
    if inner := names(value):
        parts = [parameters(getattr(value, name), place, classes) for name in inner]
        return f"{classes.name(type(value))}({', '.join(parts)})"
    if np.ndim(value):
        at = _number("p", place)
        return f"view(p, int({at}), {_tuple(_shape(value, 'p', place))})"
    return _number("p", place)


def numbers(value: Any, vector: str, place: Place, shapes: Place, lines: list[str], classes: Classes) -> str:
    """Source that makes `value` from the numbers of a flat vector; `place` is moved behind it.

    The shapes of its arrays are in the parameters at `shapes`, which is moved on too. What has to be calculated
    before is added to `lines`.
    """
    if inner := names(value):
        parts = [numbers(getattr(value, name), vector, place, shapes, lines, classes) for name in inner]
        return f"{classes.name(type(value))}({', '.join(parts)})"
    if np.ndim(value):
        return _array(vector, place, _shape(value, "p", shapes), lines)
    return _number(vector, place)


def retell(value: Any, vector: str, place: Place, lines: list[str], classes: Classes) -> str:
    """Like `numbers`, from a vector that `tell` wrote: the shape of an array stands before its numbers."""
    if inner := names(value):
        parts = [retell(getattr(value, name), vector, place, lines, classes) for name in inner]
        return f"{classes.name(type(value))}({', '.join(parts)})"
    if np.ndim(value):
        return _array(vector, place, _shape(value, vector, place), lines)
    return _number(vector, place)


def told_size(value: Any) -> int:
    """How many numbers `write` with shapes makes of `value`."""
    return int(flat(value).size) + sum(np.ndim(array) for array in arrays(value))


def _number(vector: str, place: Place) -> str:
    text = f"{vector}[{place}]"
    place.offset += 1
    return text


def _shape(value: Any, vector: str, place: Place) -> list[str]:
    return [f"int({_number(vector, place)})" for _ in range(np.ndim(value))]


def _tuple(parts: list[str]) -> str:
    return f"({', '.join(parts)},)"


def _array(vector: str, place: Place, shape: list[str], lines: list[str]) -> str:
    text = f"view({vector}, {place}, {_tuple(shape)})"
    behind = f"{vector}_{len(lines)}"
    lines.append(f"    {behind} = {place} + {' * '.join(shape)}")
    place.base, place.offset = behind, 0
    return text


def write(value: Any, path: str, vector: str, place: Place, lines: list[str], *, shapes: bool = False) -> None:
    """Adds to `lines` the source that writes a value like `value`, named `path`, to a flat vector at `place`.

    With `shapes` the shape of an array goes before its numbers.
    """
    if inner := names(value):
        for name in inner:
            write(getattr(value, name), f"{path}.{name}", vector, place, lines, shapes=shapes)
    elif np.ndim(value):
        if shapes:
            lines += [f"    {_number(vector, place)} = np.shape({path})[{axis}]" for axis in range(np.ndim(value))]
        behind = f"{vector}_{len(lines)}"
        lines.append(f"    {behind} = store({vector}, {place}, {path})")
        place.base, place.offset = behind, 0
    else:
        lines.append(f"    {_number(vector, place)} = {path}")


def remember(value: Any, path: str, start: str, behind: str) -> list[str]:
    """Source that writes a memory like `value`, named `path`, to the numbers `start` to `behind` of `m`.

    An array of it may be a view of where another belongs, so two are written beside first.
    """
    lines: list[str] = []
    if len(arrays(value)) < 2:
        write(value, path, "m", Place(0, start), lines)
        return lines
    lines.append(f"    beside = np.empty({behind} - {start})")
    write(value, path, "beside", Place(), lines)
    return [*lines, f"    store(m, {start}, beside)"]
