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

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from vvdp.base.signal import Signal
from vvdp.numerics.tableaus import Array
from vvdp.simulation.model import Case
from vvdp.simulation.values import as_value, flat, names

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
    memory = [flat(value) for value in case.memory.values()]
    return Vectors(
        state=flat(case.state),
        command=flat(case.command),
        memory=np.concatenate(memory) if memory else np.zeros(0),
        params=_params(case),
    )


def rows(cases: Sequence[Case]) -> Vectors:
    """The numbers of many cases, a row for each; the parameters of shorter ones are filled up with zeros."""
    found: dict[tuple[object, ...], Vectors] = {}
    for case in cases:
        if (key := all_but_state(case)) not in found:
            found[key] = vectors(case)
    each = [found[all_but_state(case)] for case in cases]
    params = np.zeros((len(cases), max(one.params.size for one in each)))
    for row, one in zip(params, each, strict=True):
        row[: one.params.size] = one.params
    states = np.stack([flat(case.state) for case in cases])
    return Vectors(states, np.stack([one.command for one in each]), np.stack([one.memory for one in each]), params)


def all_but_state(case: Case) -> tuple[object, ...]:
    """What tells whether two cases at hand share all their values but the numbers of the state."""
    shared = (case.params, case.command, *case.memory.values(), *case.settings.values())
    return (type(case.state), *map(id, shared))


def command_parts(case: Case) -> dict[str, slice]:
    """Where in the command the conditions `held` and the command of each program stand; empty without either."""
    return _parts({name: getattr(case.command, name) for name in names(case.command)})


def memory_parts(case: Case) -> dict[str, slice]:
    """Where in the memory the memory of each program stands."""
    return _parts(case.memory)


def as_memory(case: Case, vector: Array) -> dict[str, Any]:
    """The memory of each program that `vector`, shape (n,), holds."""
    return {name: as_value(case.memory[name], vector[part]) for name, part in memory_parts(case).items()}


def case_shape(case: Case) -> tuple[tuple[str, object], ...]:
    """What must be the same in cases that run as one batch: the names of the values, and what kind each is.

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
    return [leaf for _, leaf in members(value, "") if np.ndim(leaf)]


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


def _parts(values: Mapping[str, Any]) -> dict[str, slice]:
    parts, place = {}, 0
    for name, value in values.items():
        parts[name] = slice(place, place + flat(value).size)
        place = parts[name].stop
    return parts


def _params(case: Case) -> Array:
    memory, command, packed = memory_parts(case), command_parts(case), Packed()
    packed.add(case.params)
    packed.add_shapes(case.command)
    packed.fixed.append(float(command["held"].start) if "held" in command else 0.0)
    for name in case.memory:
        packed.add(case.settings[name])
        packed.fixed += [float(memory[name].start), float(command[name].start) if name in command else 0.0]
        packed.add_shapes(case.memory[name])
    return packed.vector()


class Packed:
    """Values on their way into a vector of blocks and a tail."""

    def __init__(self) -> None:
        self.fixed: list[float] = []
        self._tail: list[float] = []
        self._places: list[int] = []

    def add(self, value: Any) -> None:
        """Adds `value` to the block."""
        for _, leaf in members(value, ""):
            if isinstance(leaf, Signal):
                self.fixed.append(leaf.base + 0.0)  # what a constant signal comes to, -0.0 as well
                if leaf.start or leaf.amplitude:
                    self._place()
                else:
                    self.fixed.append(0.0)
                self.fixed += [float(len(leaf.start)), float(len(leaf.amplitude))]
                for column in (leaf.start, leaf.duration, leaf.change, leaf.amplitude, leaf.frequency, leaf.phase):
                    self._tail += column
            elif np.ndim(leaf):
                self._place()
                self.fixed += map(float, np.shape(leaf))
                self._tail += np.ravel(np.asarray(leaf, float)).tolist()
            else:
                self.fixed.append(float(leaf))

    def add_shapes(self, value: Any) -> None:
        """Adds the shapes of the arrays in `value` to the block."""
        for array in arrays(value):
            self.fixed += map(float, np.shape(array))

    def vector(self) -> Array:
        """The blocks and the tail, shape (n,)."""
        fixed = np.array(self.fixed, float)
        fixed[self._places] += fixed.size
        return np.concatenate([fixed, np.array(self._tail, float)])

    def _place(self) -> None:
        self._places.append(len(self.fixed))
        self.fixed.append(float(len(self._tail)))
