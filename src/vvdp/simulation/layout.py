"""A case as the flat vectors that compiled code takes, and back.

state    the numbers of the state
command  the numbers of the command now in force, `held` and one part for each program
memory   the memories of all programs, one after the other
params   a block for the circuit and one for each program, and behind them a tail with everything that has a length

In a block stands a number as it is; a signal as its base, the place of its numbers in the vector (0 where it is
constant), and how many changes and sines it has; an array or tuple as its place and its shape. What has a length is
thus no part of the compiled text: a table of 300 points runs with the code of a table of two.

Then come, in the circuit's block, the shape of each array of the command and where `held` begins in the command; in a
program's, where its memory and its command begin, and the shape of each array of its memory.
"""

from collections.abc import Hashable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.conservation import NOTHING
from vvdp.base.signal import Signal
from vvdp.simulation.model import Case
from vvdp.simulation.values import are_floats, as_value, flat, form, leaves, names, parts

SIGNAL_SLOTS = 4
"""Numbers that a signal has in its block: base, place, changes, sines."""


class Vectors(NamedTuple):
    """A case in the order in which compiled code takes it, each of shape (n,)."""

    state: Array
    command: Array
    memory: Array
    params: Array


class Blocks(NamedTuple):
    """Where the blocks of the parameters begin: those of the programs by name, and the tail."""

    programs: dict[str, int]
    tail: int


def vectors(case: Case) -> Vectors:
    """The numbers of `case`."""
    return _vectors(case, _Frame(case))


def rows(cases: Sequence[Case]) -> Vectors:
    """The numbers of cases of one form, a row for each; the parameters of shorter ones are filled up with zeros."""
    found: dict[tuple[object, ...], Vectors] = {}
    each, frame = [], _Frame(cases[0])
    for case in cases:
        if (key := all_but_state(case)) not in found:
            found[key] = _vectors(case, frame)
        each.append(found[key])
    params = np.zeros((len(cases), max(one.params.size for one in each)))
    for row, one in zip(params, each, strict=True):
        row[: one.params.size] = one.params
    states = np.stack([flat(case.state) for case in cases])
    return Vectors(states, np.stack([one.command for one in each]), np.stack([one.memory for one in each]), params)


class _Frame:
    """Layout between the numbers of the parameters, alike in all cases of one form: shapes, and where parts begin."""

    def __init__(self, case: Case) -> None:
        memory, command, shapes = memory_parts(case), command_parts(case), Packed()
        shapes.add_shapes(case.command)
        self.circuit = [*shapes.fixed, float(command["held"].start) if "held" in command else 0.0]
        self.programs = {}
        for name in case.memory:
            shapes = Packed()
            shapes.add_shapes(case.memory[name])
            begins = [float(memory[name].start), float(command[name].start) if name in command else 0.0]
            self.programs[name] = [*begins, *shapes.fixed]


def _vectors(case: Case, frame: _Frame) -> Vectors:
    memory = [flat(value) for value in case.memory.values()]
    packed = Packed()
    packed.add(case.params)
    packed.fixed += frame.circuit
    for name in case.memory:
        packed.add(case.settings[name])
        packed.fixed += frame.programs[name]
    return Vectors(
        state=flat(case.state),
        command=flat(case.command),
        memory=np.concatenate(memory) if memory else np.zeros(0),
        params=packed.vector(),
    )


def all_but_state(case: Case) -> tuple[object, ...]:
    """Identities that are equal if two cases at hand share all their values except the numbers of the state."""
    shared = (case.params, case.command, *case.memory.values(), *case.settings.values())
    return (type(case.state), *map(id, shared))


def command_parts(case: Case) -> dict[str, slice]:
    """Where in the command the conditions `held` and the command of each program stand; empty without either."""
    return _parts({name: getattr(case.command, name) for name in names(case.command)})


def held_part(case: Case) -> slice:
    """Where in the command the conditions stand; empty without any."""
    return command_parts(case).get("held", slice(0, 0))


def mode_paths(case: Case) -> list[str]:
    """The names of the modes of a circuit, in their order."""
    return [path for path, _, _ in leaves(getattr(case.command, "modes", NOTHING))]


def memory_parts(case: Case) -> dict[str, slice]:
    """Where in the memory the memory of each program stands."""
    return _parts(case.memory)


def as_memory(case: Case, vector: Array) -> dict[str, Any]:
    """The memory of each program that `vector`, shape (n,), holds."""
    return {name: as_value(case.memory[name], vector[part]) for name, part in memory_parts(case).items()}


def case_form(case: Case, known: dict[int, Hashable]) -> Hashable:
    """Form that cases of the same `case_shape` share, unless arrays of parameters differ in length.

    For many cases it takes less: what they share is looked at once, by its identity in `known` (`values.form`).
    """
    whole = (case.params, case.state, case.command, *case.settings.values(), *case.memory.values())
    return (tuple(case.settings), tuple(case.memory), *(form(value, known) for value in whole))


def case_shape(case: Case) -> tuple[tuple[str, object], ...]:
    """Shape that cases that run as one batch must share: the names of the values, and the kind of each.

    Signals, and arrays of parameters, may differ in their lengths.
    """
    found: list[tuple[str, object]] = []
    for part, value in (("params", case.params), *((f"settings.{k}", v) for k, v in case.settings.items())):
        found += [
            (path, "signal" if isinstance(leaf, Signal) else np.ndim(leaf)) for path, leaf in members(value, part)
        ]
    held = [("state", case.state), ("command", case.command)]
    for part, value in (*held, *((f"memory.{k}", v) for k, v in case.memory.items())):
        found += [(path, np.shape(leaf)) for path, leaf in members(value, part)]
    return tuple(found)


def members(value: Any, path: str) -> Iterator[tuple[str, Any]]:
    """Dotted path and value of every number, array, tuple and signal in a nested value."""
    inner = () if isinstance(value, Signal) else names(value)
    if not inner:
        yield path, value
    for name in inner:
        yield from members(getattr(value, name), f"{path}.{name}")


def arrays(value: Any) -> list[Any]:
    """The arrays and tuples in a nested value, in order."""
    found: list[Any] = []
    _gather_arrays(value, found)
    return found


def _gather_arrays(value: Any, found: list[Any]) -> None:
    inner = () if isinstance(value, Signal) else parts(value)
    if inner:
        if not are_floats(inner):
            for each in inner:
                _gather_arrays(each, found)
    elif np.ndim(value):
        found.append(value)


def slots(value: Any) -> int:
    """How many numbers `value` has in a block."""
    return sum(SIGNAL_SLOTS if isinstance(leaf, Signal) else 1 + np.ndim(leaf) for _, leaf in members(value, ""))


def blocks(case: Case) -> Blocks:
    """Where the blocks of the parameters of `case` begin."""
    place = slots(case.params) + _shape_slots(case.command) + 1
    programs = {}
    for name, memory in case.memory.items():
        programs[name] = place
        place += slots(case.settings[name]) + 2 + _shape_slots(memory)
    return Blocks(programs, place)


def _shape_slots(value: Any) -> int:
    return sum(np.ndim(array) for array in arrays(value))


def _parts(values: Mapping[str, object]) -> dict[str, slice]:
    parts, place = {}, 0
    for name, value in values.items():
        parts[name] = slice(place, place + flat(value).size)
        place = parts[name].stop
    return parts


class Packed:
    """Values on their way into a vector of blocks and a tail."""

    def __init__(self) -> None:
        self.fixed: list[float] = []
        self._tail: list[float] = []
        self._places: list[int] = []

    def add(self, value: Any) -> None:
        """Adds `value` to the block."""
        if isinstance(value, Signal):
            self._add_signal(value)
        elif inner := parts(value):
            if are_floats(inner):
                self.fixed += inner
            else:
                for each in inner:
                    self.add(each)
        elif type(value) is not float and np.ndim(value):
            self._place()
            self.fixed += map(float, np.shape(value))
            self._tail += np.ravel(np.asarray(value, float)).tolist()
        else:
            self.fixed.append(float(value))

    def _add_signal(self, value: Signal) -> None:
        self.fixed.append(value.base + 0.0)  # what a constant signal comes to, -0.0 as well
        if not (value.start or value.amplitude):
            self.fixed += (0.0, 0.0, 0.0)
            return
        self._place()
        self.fixed += (float(len(value.start)), float(len(value.amplitude)))
        for column in (value.start, value.duration, value.change, value.amplitude, value.frequency, value.phase):
            self._tail += column

    def add_shapes(self, value: Any) -> None:
        """Adds the shapes of the arrays in `value` to the block."""
        for array in arrays(value):
            self.fixed += map(float, np.shape(array))

    def vector(self) -> Array:
        """The blocks and the tail, shape (n,)."""
        fixed = np.array(self.fixed, float)
        if self._places:
            fixed[self._places] += fixed.size
        return np.concatenate([fixed, np.array(self._tail, float)])

    def _place(self) -> None:
        self._places.append(len(self.fixed))
        self.fixed.append(float(len(self._tail)))
