"""What is simulated: a circuit and the functions that belong to it."""

from collections.abc import Callable
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from vvdp.base.books import NOTHING, Nothing
from vvdp.simulation.values import same


def no_program(t: float, memory: Any, measured: Any, settings: Any) -> tuple[Any, Any]:
    """The program of a system without sensors and controllers: nothing remembered, nothing commanded."""
    return memory, Nothing(0.0)


def no_mark(t: float, state: Any, params: Any) -> float:
    """The mark of a system without events."""
    return 0.0


def no_stop(t: float, params: Any) -> float:
    """The next jump of a system without jumps: never."""
    return np.inf


@dataclass(frozen=True)
class Model:
    """Plain functions that say how a system behaves.

    circuit(t, state, command, params) -> (rates, outputs)    rates have the NamedTuple of the state
    stored(state, params) -> Stored                           what the books' balance needs; None leaves it unchecked
    program(t, memory, measured, settings) -> (memory, command)   called at every sample, `measured` is the state
    mark(t, state, params) -> float                           an event wherever its floor changes
    stop(t, params) -> float                                  the next time after t at which the rates jump
    """

    circuit: Callable[..., Any]
    stored: Callable[..., Any] | None = None
    program: Callable[..., Any] = no_program
    mark: Callable[..., Any] = no_mark
    stop: Callable[..., Any] = no_stop

    @property
    def functions(self) -> tuple[Callable[..., Any], ...]:
        """The functions that run in the compiled loop."""
        return self.circuit, self.program, self.mark, self.stop


@dataclass(frozen=True, eq=False)
class Case:
    """The values that a model runs with. Two cases are equal where all their numbers, at the same places, are."""

    state: Any
    params: Any
    command: Any = NOTHING
    memory: Any = NOTHING
    settings: Any = NOTHING

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Case) and all(
            same(getattr(self, field.name), getattr(other, field.name)) for field in fields(self)
        )

    __hash__ = None  # type: ignore[assignment]
