"""Carries a case through the compiled loop, in portions between which it can be watched and stopped."""

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.conservation import NOTHING
from vvdp.base.display import long_time
from vvdp.base.errors import RunError
from vvdp.generator.library import Failure
from vvdp.simulation import places
from vvdp.simulation.exchange import refuse_begun, release_all, troubles
from vvdp.simulation.layout import as_memory, memory_parts
from vvdp.simulation.limiting import LimitingState, state_words
from vvdp.simulation.link import quiet
from vvdp.simulation.loop import workbench
from vvdp.simulation.loops import Loop
from vvdp.simulation.loops import compiled_loop as compiled_loop
from vvdp.simulation.model import Case, Model
from vvdp.simulation.prepare import Prepared, Reached, start_run
from vvdp.simulation.prepare import prepare as prepare
from vvdp.simulation.stepping import Method as Method
from vvdp.simulation.stepping import Stepping as Stepping
from vvdp.simulation.values import as_series, as_value, leaves, names


class Pace(NamedTuple):
    """Of the portions in which a run goes: evaluations of the first one, and how long each of the next may take [s]."""

    first: float
    seconds: float


PROMPT, UNHURRIED = Pace(1e3, 7e-3), Pace(1e4, 0.2)
"""Where a caller may stop the run, and where only the keyboard may: each portion costs some tenths of a millisecond."""
MOST_GROWTH = 20.0
MOST_MARKS = 1e6
SOON, LONG = 1.0, 60.0
"""After so long [s] a run that is to take longer than that states this, and why."""
MOST_STATES = 3
"""So many states are reported where a run cannot go on."""
MANY_JUMPS = 5
"""From so many places on at which steps were refused in series, and no stop was named, a run has a note."""


@dataclass(frozen=True)
class Run:
    """Result of a run: recorded states, marks, extremes, counts. Rows and vectors are in the order of the state.

    A record on a sample has the command and the memory that were held until then.
    """

    model: Model
    case: Case
    stepping: Stepping
    times: Array  # (rows,)
    states: Array  # (rows, n)
    commands: Array  # (rows, commands)
    memories: Array  # (rows, memories)
    mark_times: Array  # (marks,)
    mark_states: Array  # (marks, n)
    span_times: Array  # (spans,) that have begun, of those of `stepping`
    span_states: Array  # (spans, n)
    initial: Array  # (n,)
    final: Array  # (n,)
    low: Array  # (n,) over every step, those of a run that it goes on from too, the books left out
    high: Array  # (n,)
    end: float
    steps: int
    rejected: int
    evaluations: int
    samples: int
    calls: Mapping[str, int]
    stiff: bool
    switches: int
    seconds: float
    digest: str
    finished: bool
    remarks: tuple[str, ...]
    reached: Reached
    failed: str = ""  # why something outside ended the run, as a foreign FMU

    @property
    def state(self) -> Any:
        """The recorded states in the shape of the circuit's state, an array over `times` at each leaf."""
        return as_series(self.case.state, self.states)

    @property
    def command(self) -> Any:
        """The recorded commands in the shape of the circuit's command, an array over `times` at each leaf."""
        return as_series(self.case.command, self.commands)

    @property
    def memory(self) -> dict[str, Any]:
        """The recorded memory of each program, an array over `times` (its last axis) at each leaf."""
        parts = memory_parts(self.case)
        return {name: as_series(self.case.memory[name], self.memories[:, part]) for name, part in parts.items()}

    @property
    def final_state(self) -> Any:
        """The state at the end."""
        return as_value(self.case.state, self.final)

    @property
    def final_command(self) -> Any:
        """The command in force at the end."""
        return as_value(self.case.command, self.reached.command)

    @property
    def final_memory(self) -> Mapping[str, Any]:
        """Memory of each program at the end."""
        return as_memory(self.case, self.reached.memory)

    @property
    def final_case(self) -> Case:
        """A case that starts as this run has ended; its programs start again in time. See `simulate` to go on."""
        return replace(self.case, state=self.final_state, command=self.final_command, memory=dict(self.final_memory))

    @property
    def outputs(self) -> Any:
        """The circuit's outputs at the recorded times, an array at each leaf (shape of `times`)."""
        return outputs(self.model, self.case, self.times, self.states, self.commands)

    @property
    def readings(self) -> dict[str, Any]:
        """Readings of the sensors of each program at the recorded times, an array at each leaf."""
        state, found = self.state, self.outputs
        with np.errstate(all="ignore"):
            return {
                name: _over_time(program.measure(self.times, state, found, self.case.params), self.times.shape)
                for name, program in self.model.programs.items()
            }


def outputs(model: Model, case: Case, times: Array, states: Array, commands: Array) -> Any:
    """The outputs of the circuit for recorded rows: the circuit itself, evaluated on whole columns at once."""
    state, command = as_series(case.state, states), as_series(case.command, commands)
    with np.errstate(all="ignore"):
        found = model.circuit(times, state, command, case.params)[1]
    return _over_time(found, times.shape)


def _over_time(value: Any, shape: tuple[int, ...]) -> Any:
    if inner := names(value):
        return type(value)(**{name: _over_time(getattr(value, name), shape) for name in inner})
    array = np.asarray(value, float)
    return array if array.shape[-1:] == shape else np.broadcast_to(array[..., np.newaxis], array.shape + shape)


def carried_on(before: Run, ready: Prepared, stepping: Stepping) -> Reached:
    """Where `before` has ended, to be carried on by another model and case of its text and shape."""
    if before.digest != ready.linked.digest:
        raise RunError("the run to continue is that of another model; start again from its final_case")
    reached = before.reached.copy()
    for place in (places.RECORDS, places.MARKS, places.STORED, places.SPANS, places.JUMPS, places.JUMP_TIME):
        reached.clock[place] = 0.0
    if stepping.method is not Method.AUTOMATIC:
        reached.clock[places.METHOD] = float(stepping.method is Method.STIFF)
    reached.clock[places.STEP] = min(reached.clock[places.STEP], stepping.longest_step)
    return reached


def simulate(
    model: Model,
    case: Case,
    stepping: Stepping,
    *,
    continue_from: Run | None = None,
    progress: Callable[[float], None] | None = None,
    stop: Callable[[], bool] | None = None,
    say: Callable[[str], None] = quiet,
    portion: float | None = None,
    checked: bool = False,
) -> Run:
    """The run of `case` to `stepping.until`.

    With `continue_from` it goes on where that run has ended, whatever `stepping.begin` says: with its time, state,
    memory and commands, those that wait included, and with the parameters and settings of `case`. Where that run ended
    on a sample, the result is to the last bit that of a run without a break.

    A run goes without the interpreter's lock, in portions of 0.2 s, of 7 ms where there is a `stop`, or of so many
    evaluations as `portion` says. After each one `progress` receives the time [s] reached, and `stop` is asked
    whether to end the run there; then, as after Ctrl-C, what was reached is kept (`Run.finished` is False). With
    `checked` bounds, divisions, whole numbers and assertions are checked on the way, and what passes keeps its bits.
    Raises RunError when the state becomes infinite or the step vanishes, with the time and the states concerned, and
    where a function of the model raises an error or a check fails, with file and line.
    """
    if continue_from is not None:
        stepping = replace(stepping, begin=continue_from.end)
    ready = prepare(model, case, stepping, say, checked=checked)
    loop = compiled_loop(say, checked=checked)
    before = carried_on(continue_from, ready, stepping) if continue_from else start_run(ready, stepping)
    refuse_begun(model.partners, as_memory(case, before.memory))
    reached, rows, began, finished, trouble = before.copy(), _Rows(before, stepping), time.perf_counter(), True, ""
    if continue_from is not None:
        rows.low, rows.high = continue_from.low.copy(), continue_from.high.copy()
    try:
        finished = _carry(loop, ready, stepping, reached, rows, case, _Watcher(progress, stop, portion, say))
    except KeyboardInterrupt:
        finished = False
    finally:
        memory = as_memory(case, reached.memory)
        trouble = troubles(model.partners, memory)
        release_all(model.partners, memory)
    if trouble and reached.clock[places.TIME] <= stepping.begin:
        raise RunError(trouble)
    counts = _counts(before, reached)
    stored, marks, spans = (int(reached.clock[place]) for place in (places.RECORDS, places.STORED, places.SPANS))
    end = float(reached.clock[places.TIME])
    return Run(
        model=model,
        case=case,
        stepping=stepping,
        times=rows.times[:stored],
        states=rows.states[:stored],
        commands=rows.commands[:stored],
        memories=rows.memories[:stored],
        mark_times=rows.mark_times[:marks],
        mark_states=rows.mark_states[:marks],
        span_times=rows.span_times[:spans],
        span_states=rows.span_states[:spans],
        initial=before.state,
        final=reached.state,
        low=rows.low,
        high=rows.high,
        end=stepping.until if finished else end,
        calls=dict(zip(model.programs, counts.pop("calls"), strict=True)),
        stiff=bool(reached.clock[places.METHOD] == places.STIFF),
        seconds=time.perf_counter() - began,
        digest=ready.linked.digest,
        finished=finished,
        remarks=remarks(reached.clock),
        failed=trouble,
        reached=reached,
        **counts,
    )


class _Rows:
    """Records that a run fills in its course."""

    def __init__(self, before: Reached, stepping: Stepping) -> None:
        self.times = stepping.record_times
        rows, n = self.times.size, before.state.size
        self.states = np.zeros((rows, n))
        self.commands, self.memories = np.zeros((rows, before.command.size)), np.zeros((rows, before.memory.size))
        self.mark_times, self.mark_states = np.zeros(256), np.zeros((256, n))
        self.span_times = stepping.span_times
        self.span_states = np.zeros((self.span_times.size, n))
        self.low, self.high = before.state.copy(), before.state.copy()


def _carry(
    loop: Loop,
    ready: Prepared,
    stepping: Stepping,
    reached: Reached,
    rows: _Rows,
    case: Case,
    watcher: "_Watcher",
) -> bool:
    """Whether the run came to its end; False where the watcher stopped it."""
    begun = time.perf_counter()
    counted: Count | None = clock_now(reached.clock)
    status, clock, budget = places.PAUSED, reached.clock, watcher.portion or watcher.pace.first
    bench = workbench(ready.plan, reached.state.size, ready.width.size, ready.pattern)
    limiting = LimitingState(case, ready, bench)
    while True:
        began, before = time.perf_counter(), clock[places.EVALUATIONS]
        try:
            status = loop.run(
                *ready.linked[:4],
                *(*reached[:3], ready.vectors.params, ready.plan, *reached[3:]),
                *(ready.atol, ready.rtol, ready.scale, ready.floor, ready.width, ready.pattern, bench),
                *(stepping.until, stepping.longest_step, stepping.begin, stepping.method.value, budget, 0),
                *(rows.times, rows.states, rows.commands, rows.memories, rows.mark_times, rows.mark_states),
                *(rows.span_times, rows.span_states, rows.low, rows.high),
            )
        except Failure as problem:
            raise RunError(f"the run ended at t = {clock[places.TIME]:.6g} s: {problem}") from None
        if ready.partners and troubles(ready.partners, as_memory(case, reached.memory)):
            return False
        if status == places.MARKS_FULL:
            if rows.mark_times.size > MOST_MARKS:
                until = f"until t = {clock[places.TIME]:.6g} s"
                raise RunError(f"more than {rows.mark_times.size} marks {until}; does the mark jump?")
            rows.mark_times = np.concatenate([rows.mark_times, np.zeros_like(rows.mark_times)])
            rows.mark_states = np.concatenate([rows.mark_states, np.zeros_like(rows.mark_states)])
        elif status not in (places.DONE, places.PAUSED):
            limits = state_words(case, limiting.count(reached.state)) if status == places.STEP_TOO_SMALL else ""
            raise RunError(failure(case, clock, reached.state, status, limits))
        if counted is not None:
            limiting.count(reached.state)
            if (gone := time.perf_counter() - begun) > SOON:
                if words := long_run(stepping.until, gone, counted, clock_now(clock)):
                    watcher.say(f"{words}; its steps are limited by {limiting.words}")
                counted = None
        stops = watcher.hears(float(clock[places.TIME]))
        if status == places.DONE or stops:
            return bool(status == places.DONE)
        budget = watcher.next_portion(clock[places.EVALUATIONS] - before, time.perf_counter() - began)


class Count(NamedTuple):
    """How far a run has come: time [s], steps and marks."""

    time: float
    steps: float
    marks: float


def clock_now(clock: Array) -> Count:
    """Counts of the clock of a run."""
    return Count(*(float(clock[place]) for place in (places.TIME, places.STEPS, places.MARKS)))


def long_run(until: float, gone: float, before: Count, now: Count) -> str:
    """How long the rest of a run will take and why, from what it counted in the time `gone` [s]; empty where short."""
    span = now.time - before.time
    if not span > 0.0:
        return f"this run stands at t = {now.time:.6g} s: {now.steps - before.steps:.0f} steps were refused or vanish"
    left = (until - now.time) * gone / span
    if left < LONG:
        return ""
    steps, marks = (now.steps - before.steps) / span, (now.marks - before.marks) / span
    periods = f"{marks:.3g} periods of {steps / marks:.3g} steps" if marks > 0.0 else f"{steps:.3g} steps"
    return f"this run will take about {long_time(left)} more: {periods} in a second of its time"


class _Watcher(NamedTuple):
    """Receivers of the progress of a run between its portions, and the size of these."""

    progress: Callable[[float], None] | None
    stop: Callable[[], bool] | None
    portion: float | None
    say: Callable[[str], None]

    @property
    def pace(self) -> Pace:
        """How soon it must be informed of the run again."""
        return UNHURRIED if self.stop is None else PROMPT

    def hears(self, now: float) -> bool:
        """Shows the time [s] that is reached; whether the run is to stop there."""
        if self.progress:
            self.progress(now)
        return self.stop is not None and self.stop()

    def next_portion(self, spent: float, seconds: float) -> float:
        """Evaluations of the next portion, after one of so many that took so long [s]."""
        return self.portion or max(1.0, spent * min(self.pace.seconds / max(seconds, 1e-9), MOST_GROWTH))


def _counts(before: Reached, reached: Reached) -> dict[str, Any]:
    """Effort of the run itself, without the run that it continues."""
    spent, calls = reached.clock - before.clock, (reached.agenda - before.agenda)[:, places.CALLS]
    return {
        "steps": int(spent[places.STEPS] - spent[places.REJECTED]),
        "rejected": int(spent[places.REJECTED]),
        "evaluations": int(spent[places.EVALUATIONS]),
        "switches": int(spent[places.SWITCHES]),
        "samples": int(calls[0]),
        "calls": [int(count) for count in calls[1:]],
    }


def remarks(clock: Array) -> tuple[str, ...]:
    """Notes for a user on a run that went to its end."""
    found = []
    if (jumps := int(clock[places.JUMPS])) >= MANY_JUMPS:
        first = clock[places.JUMP_TIME]
        found.append(
            f"the rates seem to jump at about t = {first:.6g} s, which no stop names ({jumps} times): a valve that "
            "opens at once, or an end of a stroke; such a place is passed by trial, less exactly than a named one"
        )
    return tuple(found)


def failure(case: Case, clock: Array, state: Array, status: int, limits: str = "") -> str:
    """Why a case could not be carried past the time of its `clock` [s], with its state there, shape (n,).

    `limits` names the state that limits the step, where that is known.
    """
    reached = clock[places.TIME]
    culprit = int(clock[places.CULPRIT])
    values = _states_that_matter(case, state, culprit if status == places.BELOW_ZERO else -1)
    why = why_not_on(status, _culprit(case, status, culprit))
    if limits and status == places.STEP_TOO_SMALL:
        why += f", limited by {limits}: is it much smaller than its neighbours?"
    return f"the run cannot go on at t = {reached:.6g} s: {why}; state: {values}"


def why_not_on(status: int, culprit: str = "") -> str:
    """Why the loop cannot go on where it answers `status`; `culprit` is the pressure or mode that it names, if any."""
    return {
        places.NOT_FINITE: "a rate is no longer finite (a pressure at absolute zero?)",
        places.STEP_TOO_SMALL: "the step has become too small",
        places.STOP_BEHIND: "`stop` names no later time; expected the next one at which the rates jump",
        places.TOO_MANY_WAITING: f"more than {places.DEPTH} commands of a program wait; has it a long latency?",
        places.BELOW_ZERO: f"{culprit} has fallen below 0 Pa absolute, where no oil is: more is drawn from it than "
        "flows in, as by a pump that turns backwards or a cylinder that moves faster than it is filled; with a vapour "
        'pressure of the oil (oil.vapour_pressure = "0.01 bara") the run goes on with vapour',
        places.RESTLESS: f"the mode '{culprit}' changes to and fro without end (chattering): where it holds, its law "
        "leads at once to where another does, and back; a lag or a hysteresis makes it one motion",
    }[status]


def _culprit(case: Case, status: int, place: int) -> str:
    """The name of the pressure or mode at this place that ends a run; none of what ends it otherwise."""
    told = {places.BELOW_ZERO: case.state, places.RESTLESS: getattr(case.command, "modes", NOTHING)}
    return [path for path, _, _ in leaves(told[status])][place] if status in told else ""


def _states_that_matter(case: Case, state: Array, culprit: int) -> str:
    """The state of this place and those that are not finite, else the first: three at most."""
    paths = [path for path, _, _ in leaves(case.state) if not path.startswith("books.")]
    order = sorted(range(len(paths)), key=lambda place: (place != culprit, bool(np.isfinite(state[place])), place))
    more = f", and {len(order) - MOST_STATES} more" if len(order) > MOST_STATES else ""
    return ", ".join(f"{paths[place]} = {state[place]:.4g}" for place in order[:MOST_STATES]) + more
