"""A model to simulate: a circuit, the programs that watch and command it, and the values that they start from."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields
from typing import Any

import numpy as np

from vvdp.base.conservation import NOTHING
from vvdp.base.params import field_types
from vvdp.simulation.exchange import Partner
from vvdp.simulation.values import blank, names, same


def no_mark(t: float, state: Any, command: Any, params: Any) -> float:
    """The mark of a system without periods."""
    return 0.0


def no_stop(t: float, command: Any, params: Any) -> float:
    """The next jump of a system without jumps: never."""
    return np.inf


def no_memory(settings: Any) -> Any:
    """The memory of a program that remembers nothing."""
    return NOTHING


@dataclass(frozen=True)
class Program:
    """A controller, estimator or display: what it measures, and the step that it takes at each of its samples.

    measure(t, state, outputs, params) -> reading              what its sensors see, and no books
    step(t, memory, reading, settings) -> (memory, command)    a NamedTuple each, all floats or arrays of fixed length
    start(settings) -> memory                                  the memory before the first sample
    trigger(t, state, command, params, settings) -> float      an event wherever its floor changes

    It is called at `phase`, and then every `period` [s] (None: the run's sample period); with a trigger instead at
    each event, where a step of the run ends exactly. Its command acts `latency` [s] later, at most one period.
    `command` is what holds before the first one acts. A step that calls `simulation.exchange` names its `partner`.
    `is_bounded`: no number of the step grows with the time for which it runs, and it does not depend on `t`.
    """

    measure: Callable[..., Any]
    step: Callable[..., Any]
    command: Any = NOTHING
    start: Callable[..., Any] = no_memory
    trigger: Callable[..., Any] | None = None
    period: float | None = None
    phase: float = 0.0
    latency: float = 0.0
    partner: Partner | None = None
    is_bounded: bool = False


@dataclass(frozen=True)
class Model:
    """Plain functions that say how a system behaves.

    circuit(t, state, command, params) -> (rates, outputs)   rates have the NamedTuple of the state; see below
    stored(state, params) -> Stored                          what the books' balance needs; None leaves it unchecked
    start(params) -> state                                   where a run begins; None: the case has to say it
    conditions(t, params) -> held                            calculated once per sample period and held in between
    mark(t, state, command, params) -> float                 a period ends wherever its floor changes
    stop(t, command, params) -> float                        the next time after t at which the rates jump

    The command is a NamedTuple with a field `held` for the conditions, where there are any, and a field for each of
    the `programs` by its name. It changes at samples only. A circuit that jumps or has kinks may have a field `modes`
    as well, a NamedTuple of Mode and Kink: it returns such a tuple as a third value, steps end wherever the floor of a
    number in it changes, and the command holds these floors.
    """

    circuit: Callable[..., Any]
    stored: Callable[..., Any] | None = None
    start: Callable[..., Any] | None = None
    conditions: Callable[..., Any] | None = None
    programs: Mapping[str, Program] = field(default_factory=dict)
    mark: Callable[..., Any] = no_mark
    stop: Callable[..., Any] = no_stop

    @property
    def partners(self) -> Mapping[str, Partner]:
        """Partners of programs outside of compiled code, by the names of the programs."""
        return {name: program.partner for name, program in self.programs.items() if program.partner is not None}


@dataclass(frozen=True, eq=False)
class Case:
    """The values that a model runs with. Two cases are equal where all their numbers, at the same places, are.

    `memory` and `settings` have an entry for each program of the model.
    """

    state: Any
    params: Any
    command: Any = NOTHING
    memory: Mapping[str, object] = field(default_factory=dict)
    settings: Mapping[str, Any] = field(default_factory=dict)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Case) and all(
            same(getattr(self, field.name), getattr(other, field.name)) for field in fields(self)
        )

    __hash__ = None  # type: ignore[assignment]


def initial_case(model: Model, command: type, params: Any, settings: Mapping[str, object] | None = None) -> Case:
    """The case that `params`, and the `settings` of each program, make of a model that knows how to start.

    command  class of the model's command
    """
    assert model.start is not None
    given = dict(settings or {})
    held = {} if model.conditions is None else {"held": model.conditions(0.0, params)}
    if "modes" in names(command):
        held["modes"] = blank(field_types(command)["modes"])
    programs = {name: program.command for name, program in model.programs.items()}
    return Case(
        state=model.start(params),
        params=params,
        command=command(**held, **programs) if held or programs else NOTHING,
        memory={name: program.start(given.get(name, NOTHING)) for name, program in model.programs.items()},
        settings={name: given.get(name, NOTHING) for name in model.programs},
    )
