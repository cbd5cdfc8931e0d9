"""Building blocks of a model's values in the texts of `simulation.parts`: signals in flat vectors, and views of
these."""

from typing import Any, NamedTuple

import numpy as np

from vvdp.base.signal import changes_stop, changes_value, sines_value


class Signal(NamedTuple):
    """A signal in generated code: its numbers are in the parameters from `place` on; 0 where it is constant."""

    base: float
    place: float
    changes: float
    sines: float
    parameters: Any


def signal(t: float, base: float, place: float, changes: float, sines: float, parameters: Any) -> Signal:
    """The signal of these numbers in the flat vector `parameters`."""
    return Signal(base, place, changes, sines, parameters)


def moving(t: float, signal: Any) -> float:
    """The value at the time `t` [s] of a signal that may move."""
    place, n, m, p = int(signal.place), int(signal.changes), int(signal.sines), signal.parameters
    changed = changes_value(t, p[place : place + n], p[place + n : place + 2 * n], p[place + 2 * n : place + 3 * n])
    place = place + 3 * n
    swung = sines_value(t, p[place : place + m], p[place + m : place + 2 * m], p[place + 2 * m : place + 3 * m])
    value: float = signal.base + changed + swung
    return value


def corner(t: float, signal: Any) -> float:
    """The next time [s] at which a signal that may move has a corner."""
    place, n, p = int(signal.place), int(signal.changes), signal.parameters
    return changes_stop(t, p[place : place + n], p[place + n : place + 2 * n])


def record_value(t: float, signal: Any) -> float:
    """`base.signal.signal_value` of a signal in a flat vector."""
    return moving(t, signal) if signal.place > 0.0 else signal.base


def record_stop(t: float, signal: Any) -> float:
    """`base.signal.signal_stop` of a signal in a flat vector."""
    return corner(t, signal) if signal.place > 0.0 else np.inf


def view(vector: Any, place: int, shape: tuple[int, ...]) -> Any:
    """The numbers of a flat vector from `place` on as an array of this shape."""
    return vector[place : place + int(np.prod(shape))].reshape(shape)


def store(vector: Any, place: int, values: Any) -> int:
    """Write an array or a tuple to a flat vector from `place` on; returns the place behind it."""
    row = np.ravel(values)
    vector[place : place + row.size] = row
    return place + row.size
