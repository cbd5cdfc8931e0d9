"""Preparation of a run for its first step: a checked and linked case as flat vectors, and the compiled loop."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.conservation import NOTHING
from vvdp.base.kinds import KINK, PRESSURE_LEVEL
from vvdp.numerics.sparse import Pattern, pattern
from vvdp.simulation import places
from vvdp.simulation.check import check_model, check_times
from vvdp.simulation.exchange import Partner
from vvdp.simulation.layout import Vectors, command_parts, vectors
from vvdp.simulation.link import Linked, link, quiet
from vvdp.simulation.model import Case, Model
from vvdp.simulation.stepping import Method, Stepping
from vvdp.simulation.symbols import Untraceable
from vvdp.simulation.trace import dependencies, trace
from vvdp.simulation.values import leaves

MOST_MODES = 8
"""How often modes may follow each other at one call of `free_rates`."""
AT_TRIGGER, AT_MODE, AT_KINK = 1e-12, 1e-7, 1e-6
"""How far behind an event a step may end, as a share of the step: slopes change by far less than rates do."""


@dataclass(frozen=True, kw_only=True)
class Tables:
    """A case as flat vectors, with the times at which its programs are called and what judges a step."""

    vectors: Vectors
    plan: Array  # (1 + programs, columns of `vvdp.simulation.schedule`)
    atol: Array
    rtol: Array
    scale: Array
    floor: Array  # below which a state cannot be: 0 Pa absolute, minus infinity where there is no such bound
    width: Array  # of the mark, the triggers and the modes: how far behind an event a step may end, as a share of it
    pattern: Pattern


@dataclass(frozen=True, kw_only=True)
class Prepared(Tables):
    """A case with the compiled functions."""

    linked: Linked
    partners: Mapping[str, Partner]


def prepare(
    model: Model,
    case: Case,
    stepping: Stepping,
    say: Callable[[str], None] = quiet,
    *,
    checked: bool = False,
) -> Prepared:
    """Everything that the loop needs. The books take no part in the error control: it is they that judge it.

    checked  as of `link`
    """
    check_model(model, case)
    check_times(model, stepping.sample_period)
    linked = link(model, case, say=say, checked=checked)
    return Prepared(linked=linked, partners=model.partners, **vars(tables(model, case, stepping, linked.digest)))


def tables(model: Model, case: Case, stepping: Stepping, digest: str | None = None) -> Tables:
    """Data for the loop besides compiled functions; `digest` is the hash of the model, by which a part is kept."""
    kinds = [(path, kind) for path, _, kind in leaves(case.state)]
    scale = np.array([kind.scale if kind else 1.0 for _, kind in kinds])
    bounded = np.array([not (kind and kind.accumulates) for _, kind in kinds])
    active = sum(not path.startswith("books.") for path, _ in kinds)
    return Tables(
        vectors=vectors(case),
        plan=_plan(model, case, stepping.sample_period),
        atol=stepping.relative_tolerance * scale,
        rtol=stepping.relative_tolerance * bounded,
        scale=scale,
        floor=np.array([0.0 if kind and kind.name == PRESSURE_LEVEL.name else -np.inf for _, kind in kinds]),
        width=_width(model, case),
        pattern=_jacobian(model, case, digest, (len(kinds), active)),
    )


_patterns: dict[str | None, Pattern] = {}


def _jacobian(model: Model, case: Case, digest: str | None, shape: tuple[int, int]) -> Pattern:
    """Where the Jacobian of a model has entries; everywhere, where its text cannot be traced. Kept by its hash."""
    if digest is None or digest not in _patterns:
        try:
            found = dependencies(trace(model, case))[: shape[0], : shape[1]]
        except Untraceable:
            found = np.ones(shape, bool)
        _patterns[digest] = pattern(found)
    return _patterns[digest]


def _plan(model: Model, case: Case, sample_period: float) -> Array:
    """A row for the conditions and for each program, as `vvdp.simulation.schedule` has them."""
    parts, triggers = command_parts(case), 0
    modes = parts.get("modes", slice(0, 0))
    rows = [[sample_period, 0.0, 0.0, 0.0, modes.start, modes.stop]]
    for name, program in model.programs.items():
        triggers += program.trigger is not None
        period = sample_period if program.period is None else program.period
        trigger = 0.0 if program.trigger is None else triggers
        rows.append([period, program.phase, program.latency, trigger, parts[name].start, parts[name].stop])
    return np.array(rows, float)


def _width(model: Model, case: Case) -> Array:
    triggers = sum(program.trigger is not None for program in model.programs.values())
    kinds = [kind for _, _, kind in leaves(getattr(case.command, "modes", NOTHING))]
    return np.array([1.0] + triggers * [AT_TRIGGER] + [AT_KINK if kind is KINK else AT_MODE for kind in kinds])


def free_rates(ready: Prepared, command: Array | None = None) -> Callable[[float, Array], Array]:
    """rates(t, y) [per second], shape (n,), of a prepared case for a solver of your own.

    Modes follow the state at each call, so that nothing is landed on; a mode that does not come to rest is left as it
    is.

    command  in force, changed in place; by default that of the case
    """
    linked, n, params = ready.linked, ready.vectors.state.size, ready.vectors.params
    u = ready.vectors.command.copy() if command is None else command
    modes = slice(int(ready.plan[0, places.FIRST]), int(ready.plan[0, places.LAST]))
    dy = np.zeros(n + modes.stop - modes.start)

    def rates(t: float, y: Array) -> Array:
        for _ in range(MOST_MODES):
            linked.rates(t, np.ascontiguousarray(y, float), u, params, dy)
            found = np.floor(dy[n:])
            if np.array_equal(found, u[modes], equal_nan=True):
                break
            u[modes] = found
        return dy[:n].copy()

    return rates


class Reached(NamedTuple):
    """Where a run stands: everything that the loop changes, so that it can go on from there."""

    state: Array  # (n,)
    command: Array  # (commands,)
    memory: Array  # (memories,)
    agenda: Array  # (1 + programs, columns of `vvdp.simulation.schedule`)
    waiting: Array  # (1 + programs, depth, commands)
    clock: Array
    course: Array  # (3, as many as `Prepared.width`)

    def copy(self) -> "Reached":
        """The same in arrays of its own."""
        return Reached._make(part.copy() for part in self)


def start_run(ready: Tables, stepping: Stepping) -> Reached:
    """Where a run stands before its first step."""
    state, command, memory, _ = (part.copy() for part in ready.vectors)
    programs, clock = ready.plan.shape[0], np.zeros(places.CLOCK)
    clock[places.TIME] = stepping.begin
    clock[places.ERROR_BEFORE] = 1e-4
    clock[places.STEP] = min(1e-3 * stepping.sample_period, stepping.longest_step)
    clock[places.METHOD] = places.STIFF if stepping.method is Method.STIFF else places.EXPLICIT
    agenda, waiting = np.zeros((programs, places.AGENDA)), np.zeros((programs, places.DEPTH, command.size))
    return Reached(
        state=state,
        command=command,
        memory=memory,
        agenda=agenda,
        waiting=waiting,
        clock=clock,
        course=np.zeros((3, ready.width.size)),
    )
