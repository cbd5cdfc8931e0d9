"""Carries a case through the compiled loop, in portions between which it can be watched and stopped."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from pathlib import Path
from typing import Any

import numpy as np

from vvdp.base.errors import ParameterError, RunError
from vvdp.base.kinds import Ratio, Time
from vvdp.base.params import Params
from vvdp.numerics.tableaus import Array
from vvdp.simulation.link import Linked, link, quiet
from vvdp.simulation.model import Case, Model
from vvdp.simulation.values import as_series, as_value, flat, leaves

PORTION = 2e6
"""Evaluations between two looks at the keyboard: about a second."""
MOST_MARKS = 1e6


class Method(Enum):
    """How a run is stepped; the values are those of the compiled loop."""

    AUTOMATIC = 0
    EXPLICIT = 1
    STIFF = 2


class Stepping(Params):
    """How long and how finely a run is stepped and recorded.

    The whole run is recorded every `record_interval`, its last `window` every `window_interval` as well.
    """

    until: Time
    relative_tolerance: Ratio = 1e-7
    sample_period: Time = 1e-3
    record_interval: Time = 1e-3
    window: Time = 0.25
    window_interval: Time = 2e-5
    method: Method = Method.AUTOMATIC

    def check(self) -> None:
        for name in ("until", "sample_period", "record_interval", "window_interval"):
            if not getattr(self, name) > 0.0:
                raise ParameterError(f"{name} = {getattr(self, name):g} s; expected more than 0 s")
        if not 1e-13 <= self.relative_tolerance <= 1e-2:
            raise ParameterError(f"relative_tolerance = {self.relative_tolerance:g}; expected 1e-13 to 0.01")
        rows = self.until / self.record_interval + min(self.window, self.until) / self.window_interval
        if rows > 2e7:
            raise ParameterError(f"{rows:.3g} rows to record; at most 2e7: record less often or in a shorter window")

    @property
    def record_times(self) -> Array:
        """All times [s] at which the state is recorded, increasing."""
        coarse = np.arange(round(self.until / self.record_interval) + 1) * self.record_interval
        begin = max(0.0, self.until - self.window)
        fine = begin + np.arange(round((self.until - begin) / self.window_interval) + 1) * self.window_interval
        both = np.union1d(coarse, fine)
        both = both[np.concatenate([[True], np.diff(both) > 1e-3 * self.window_interval])]
        inside: Array = both[both <= self.until * (1 + 1e-12)].clip(max=self.until)
        return inside


@dataclass(frozen=True)
class Prepared:
    """A case as flat vectors, with the compiled functions."""

    linked: Linked
    state: Array
    command: Array
    memory: Array
    params: Array
    settings: Array
    atol: Array
    rtol: Array
    scale: Array
    active: int


def prepared(
    model: Model, case: Case, tolerance: float, cache: Path | None = None, say: Callable[[str], None] = quiet
) -> Prepared:
    """Everything that the loop needs. The books take no part in the error control: it is they that judge it."""
    kinds = [(path, kind) for path, _, kind in leaves(case.state)]
    linked = link(model, case, cache, say)
    scale = np.array([kind.scale if kind else 1.0 for _, kind in kinds])
    bounded = np.array([not (kind and kind.accumulates) for _, kind in kinds])
    active = sum(not path.startswith("books.") for path, _ in kinds)
    return Prepared(
        linked=linked,
        state=flat(case.state),
        command=flat(case.command),
        memory=flat(case.memory),
        params=flat(case.params),
        settings=flat(case.settings),
        atol=tolerance * scale,
        rtol=tolerance * bounded,
        scale=scale,
        active=active,
    )


@dataclass(frozen=True)
class Run:
    """What a run has left: recorded states, marks, extremes, counts. Rows and vectors are in the order of the state."""

    model: Model
    case: Case
    stepping: Stepping
    times: Array  # (rows,)
    states: Array  # (rows, n)
    commands: Array  # (rows, commands)
    mark_times: Array  # (marks,)
    mark_states: Array  # (marks, n)
    final: Array  # (n,)
    low: Array  # (n,) over every step
    high: Array  # (n,)
    end: float
    steps: int
    rejected: int
    evaluations: int
    samples: int
    stiff: bool
    switches: int
    seconds: float
    digest: str
    finished: bool

    @property
    def state(self) -> Any:
        """The recorded states in the shape of the circuit's state, an array over `times` at each leaf."""
        return as_series(self.case.state, self.states)

    @property
    def final_state(self) -> Any:
        """The state at the end."""
        return as_value(self.case.state, self.final)

    @property
    def outputs(self) -> Any:
        """The circuit's outputs at the recorded times, an array at each leaf (shape of `times`)."""
        return outputs(self.model, self.case, self.times, self.states, self.commands)


def outputs(model: Model, case: Case, times: Array, states: Array, commands: Array) -> Any:
    """The outputs of the circuit for recorded rows: the circuit itself, evaluated on whole columns at once."""
    state, command = as_series(case.state, states), as_series(case.command, commands)
    with np.errstate(all="ignore"):
        _, found = model.circuit(times, state, command, case.params)
    return type(found)(*(np.broadcast_to(np.asarray(value, float), times.shape) for value in found))


def simulate(
    model: Model,
    case: Case,
    stepping: Stepping,
    *,
    progress: Callable[[float], None] | None = None,
    say: Callable[[str], None] = quiet,
    cache: Path | None = None,
    portion: float = PORTION,
) -> Run:
    """The run of `case` to `stepping.until`.

    `progress` hears the time [s] reached after every portion; Ctrl-C ends the run there and keeps what was reached
    (`Run.finished` is False). Raises RunError when the state becomes infinite or the step vanishes, with the time and
    the states concerned.
    """
    ready = prepared(model, case, stepping.relative_tolerance, cache, say)
    loop = compiled_loop(say)
    n, record_times = ready.state.size, stepping.record_times
    y, command, memory = ready.state.copy(), ready.command.copy(), ready.memory.copy()
    clock = np.zeros(loop.CLOCK)
    clock[loop.STEP] = 1e-3 * stepping.sample_period
    clock[loop.METHOD] = loop.STIFF if stepping.method is Method.STIFF else loop.EXPLICIT
    record, record_command = np.zeros((record_times.size, n)), np.zeros((record_times.size, command.size))
    mark_times, mark_states = np.zeros(256), np.zeros((256, n))
    low, high = ready.state.copy(), ready.state.copy()
    began, finished, status = time.perf_counter(), True, loop.PAUSED
    try:
        while status != loop.DONE:
            status = loop.run(
                *ready.linked[:4],
                *(y, command, memory, ready.params, ready.settings),
                *(ready.atol, ready.rtol, ready.scale, clock),
                *(ready.active, stepping.sample_period, stepping.until, 0.0, stepping.method.value, portion, 0),
                *(record_times, record, record_command, mark_times, mark_states, low, high),
            )
            if status == loop.MARKS_FULL:
                if mark_times.size > MOST_MARKS:
                    reached = f"until t = {clock[loop.TIME]:.6g} s"
                    raise RunError(f"more than {mark_times.size} marks {reached}; does the mark jump?")
                mark_times = np.concatenate([mark_times, np.zeros_like(mark_times)])
                mark_states = np.concatenate([mark_states, np.zeros_like(mark_states)])
            elif status in (loop.NOT_FINITE, loop.STEP_TOO_SMALL):
                raise RunError(failure(case, clock[loop.TIME], y, status == loop.NOT_FINITE))
            if progress:
                progress(float(clock[loop.TIME]))
    except KeyboardInterrupt:
        finished = False
    rows, marks = int(clock[loop.RECORDS]), int(clock[loop.STORED])
    return Run(
        model=model,
        case=case,
        stepping=stepping,
        times=record_times[:rows],
        states=record[:rows],
        commands=record_command[:rows],
        mark_times=mark_times[:marks],
        mark_states=mark_states[:marks],
        final=y,
        low=low,
        high=high,
        end=float(clock[loop.TIME]),
        steps=int(clock[loop.STEPS] - clock[loop.REJECTED]),
        rejected=int(clock[loop.REJECTED]),
        evaluations=int(clock[loop.EVALUATIONS]),
        samples=int(clock[loop.SAMPLES]),
        stiff=bool(clock[loop.METHOD] == loop.STIFF),
        switches=int(clock[loop.SWITCHES]),
        seconds=time.perf_counter() - began,
        digest=ready.linked.digest,
        finished=finished,
    )


def is_loop_compiled() -> bool:
    """Whether the compiled loop is kept from an earlier run."""
    return any((Path(__file__).parent / "__pycache__").glob("loop.run-*.nbi"))


def compiled_loop(say: Callable[[str], None]) -> Any:
    """The compiled loop; Numba is loaded here, and only here."""
    if not is_loop_compiled():
        say("compiling the simulation loop (once for each installation, about half a minute)")
    from vvdp.simulation import loop

    return loop


def failure(case: Case, reached: float, state: Array, infinite: bool) -> str:
    """Why a case could not be carried past the time `reached` [s], with its state there, shape (n,)."""
    found = ((path, x) for (path, _, _), x in zip(leaves(case.state), state, strict=False))
    values = ", ".join(f"{path} = {x:.4g}" for path, x in found if not path.startswith("books."))
    why = "a rate is no longer finite (a pressure at absolute zero?)" if infinite else "the step has become too small"
    return f"the run cannot go on at t = {reached:.6g} s: {why}; state: {values}"
