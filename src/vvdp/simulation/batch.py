"""Many cases of one model at once, on all cores; nothing is recorded but what a summary needs."""

import time
from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from vvdp.base.arrays import Array
from vvdp.base.errors import ParameterError, RunError
from vvdp.simulation import places
from vvdp.simulation.crew import Crew, all_cores, never
from vvdp.simulation.exchange import release_all, troubles
from vvdp.simulation.lanes import SideBySide, run_lanes, side_by_side
from vvdp.simulation.layout import as_memory, case_form
from vvdp.simulation.layout import case_shape as case_shape
from vvdp.simulation.layout import rows as rows_of
from vvdp.simulation.link import quiet
from vvdp.simulation.loop import workbench
from vvdp.simulation.loops import Loop, compiled_loop
from vvdp.simulation.model import Case, Model
from vvdp.simulation.outcome import Outcome, Window, kept_marks, marked_window, plain_window
from vvdp.simulation.prepare import Prepared, Reached, prepare, start_run
from vvdp.simulation.run import failure, remarks
from vvdp.simulation.start import check_start, start_bounds
from vvdp.simulation.stepping import Method, Stepping

MARKS_MEMORY = 2**28
"""Bytes for the marks of a batch; cases with more marks than there is room for are run a second time."""
MOST_ROWS = 512
"""Room for so many marks of a case at most: a system that hands out memory in large pages clears all of it."""


@dataclass(frozen=True)
class BatchRun:
    """Result of a batch: a row for every case, columns in the order of the state.

    Marks are those from `average_from` on, of which `kept_marks` are held; a case without any has NaN. `reasons` says
    why a case could not be carried to the end, None where it was; the row of such a case holds what it had reached.
    `stopped` says whether the batch was stopped; cases that had ended by then are as they would be anyway.
    """

    model: Model
    cases: tuple[Case, ...]
    stepping: Stepping
    final: Array  # (cases, n)
    final_commands: Array  # (cases, commands)
    final_memories: Array  # (cases, memories)
    low: Array  # (cases, n) over every step, the books left out
    high: Array  # (cases, n)
    marks: npt.NDArray[np.int64]  # (cases,)
    mark_times: Array  # (cases, 5) of `kept_marks`
    mark_states: Array  # (cases, 5, n)
    span_states: Array  # (cases, spans, n) at the `span_times` of the stepping
    end: Array  # (cases,)
    steps: npt.NDArray[np.int64]  # (cases,) and so are the counts below
    rejected: npt.NDArray[np.int64]
    evaluations: npt.NDArray[np.int64]
    samples: npt.NDArray[np.int64]
    switches: npt.NDArray[np.int64]
    stiff: npt.NDArray[np.bool_]
    reasons: tuple[str | None, ...]
    remarks: tuple[tuple[str, ...], ...]
    seconds: float
    digest: str
    lanes: tuple[bool, ...]  # whether a case ran in a lane beside others, or alone
    stopped: bool
    why_alone: str | None  # why all of them did; None where only those did that are stiff or cannot go on

    def outcome(self, case: int) -> Outcome | None:
        """What the summary of a case is calculated from; None where it failed, or no means are wanted."""
        if self.reasons[case] or self.stepping.average_from is None:
            return None
        return Outcome(
            model=self.model,
            case=self.cases[case],
            window=self._window(case),
            final=self.final[case],
            low=self.low[case],
            high=self.high[case],
            end=float(self.end[case]),
            steps=int(self.steps[case]),
            rejected=int(self.rejected[case]),
            evaluations=int(self.evaluations[case]),
            stiff=bool(self.stiff[case]),
            seconds=self.seconds / len(self.cases),
            finished=True,
            remarks=self.remarks[case],
            memory=as_memory(self.cases[case], self.final_memories[case]),
        )

    def _window(self, row: int) -> Window:
        case, marks = self.cases[row], int(self.marks[row])
        if marks >= 2:
            return marked_window(case, self.mark_times[row], self.mark_states[row], marks)
        times, end = self.stepping.span_times, float(self.end[row])
        return plain_window(case, times, self.span_states[row], end, self.final[row])


def simulate_batch(
    model: Model,
    cases: Sequence[Case],
    stepping: Stepping,
    *,
    cores: int | None = None,
    lanes: bool = True,
    stop: Callable[[], bool] = never,
    say: Callable[[str], None] = quiet,
) -> BatchRun:
    """All `cases` run to `stepping.until`; marks count from its `average_from` on.

    With `lanes` a core carries several cases at once where the model allows it. They then agree with `simulate`
    within the tolerance, and to the last bit with any other batch that they are in, on any number of cores. Without,
    and where the result says that a case ran alone, they agree with `simulate` to the last bit.

    A case that fails is reported in the result and stops no other. `stop` is asked every few milliseconds, in the
    thread of the caller; once it states this, no case goes on, and those that have not ended are reported likewise.
    Raises ParameterError where the cases are not of one shape, or `cores` (all, unless said) is not a number of them.
    """
    _are_of_one_shape(cases)
    crew = Crew(_threads(cores), stop)
    began = time.perf_counter()
    ready = prepare(model, cases[0], stepping, say)
    loop = compiled_loop(say)
    code: SideBySide | str = "lanes were not asked for"
    if lanes and stepping.method is Method.STIFF:
        code = "the stiff method carries each case alone"
    elif lanes and model.partners:
        code = "a program exchanges values with a model outside"
    elif lanes:
        code = side_by_side(model, cases[0], ready.linked.digest, say)
    rows = int(np.clip(_places(ready, len(cases)), 16, MOST_ROWS))
    part = _carry_out(loop, ready, code, cases, stepping, rows, crew)
    crowded = np.flatnonzero(part.clocks[:, places.STORED] >= rows)  # marks on the way have been written over
    if crowded.size:
        room = int(part.clocks[crowded, places.MARKS].max()) + 1
        at_once = max(1, _places(ready, room))
        for some in np.split(crowded, range(at_once, crowded.size, at_once)):
            again = _carry_out(loop, ready, code, [cases[row] for row in some], stepping, room, crew)
            for whole, piece in zip(part, again, strict=True):
                whole[some] = piece
    clocks = part.clocks
    low, high = start_bounds(cases[0].state)
    ended = (
        (part.status == places.DONE) & (part.troubles == "") & ((low <= part.start) & (part.start <= high)).all(axis=1)
    )
    reasons = tuple(
        None if well else trouble or _reason(case, clock, state, status)
        for well, trouble, case, clock, state, status in zip(
            ended, part.troubles, cases, clocks, part.final, part.status, strict=True
        )
    )
    return BatchRun(
        model=model,
        cases=tuple(cases),
        stepping=stepping,
        final=part.final,
        final_commands=part.commands,
        final_memories=part.memories,
        low=part.low,
        high=part.high,
        mark_times=part.mark_times,
        mark_states=part.mark_states,
        span_states=part.span_states,
        end=np.where(part.status == places.DONE, stepping.until, clocks[:, places.TIME]),
        stiff=clocks[:, places.METHOD] == places.STIFF,
        reasons=reasons,
        remarks=tuple(remarks(clock) for clock in clocks),
        seconds=time.perf_counter() - began,
        digest=ready.linked.digest,
        lanes=tuple(part.lanes.tolist()),
        stopped=crew.is_halted,
        why_alone=code if isinstance(code, str) else None,
        **_counts(part),
    )


def _are_of_one_shape(cases: Sequence[Case]) -> None:
    if not cases:
        raise ParameterError("no cases; expected at least one")
    shared = dict[int, Hashable]()
    shape, known = case_shape(cases[0]), {case_form(cases[0], shared)}
    for number, case in enumerate(cases[1:], 1):
        if (form := case_form(case, shared)) in known:
            continue
        known.add(form)
        if difference := _difference(case_shape(case), shape):
            raise ParameterError(
                f"case {number} is not of the shape of case 0: {difference}; run them in batches apart"
            )


def _reason(case: Case, clock: Array, state: Array, status: int) -> str | None:
    if status in (places.PAUSED, places.HANDED):
        return f"stopped at t = {clock[places.TIME]:.6g} s"
    try:
        check_start(case)
    except RunError as problem:
        return str(problem)
    return None if status == places.DONE else failure(case, clock, state, status)


def _counts(part: "_Carried") -> dict[str, npt.NDArray[np.int64]]:
    clocks = part.clocks
    named = {"marks": places.STORED, "evaluations": places.EVALUATIONS, "switches": places.SWITCHES}
    counts = {name: clocks[:, place].astype(np.int64) for name, place in named.items()}
    counts["rejected"] = clocks[:, places.REJECTED].astype(np.int64)
    counts["steps"] = clocks[:, places.STEPS].astype(np.int64) - counts["rejected"]
    counts["samples"] = part.samples
    return counts


def _places(ready: Prepared, others: int) -> int:
    """How many states fit into the memory for marks for each of `others`."""
    return MARKS_MEMORY // (8 * ready.vectors.state.size * others)


class _Carried(NamedTuple):
    start: Array
    final: Array
    commands: Array
    memories: Array
    low: Array
    high: Array
    clocks: Array
    status: npt.NDArray[np.int64]
    samples: npt.NDArray[np.int64]
    mark_times: Array
    mark_states: Array
    span_states: Array
    lanes: npt.NDArray[np.bool_]
    troubles: npt.NDArray[np.object_]


def _carry_out(
    loop: Loop,
    ready: Prepared,
    code: SideBySide | str,
    cases: Sequence[Case],
    stepping: Stepping,
    rows: int,
    crew: Crew,
) -> _Carried:
    count, n = len(cases), ready.vectors.state.size
    state, command, memory, params = rows_of(cases)
    start, others = state.copy(), start_run(ready, stepping)[3:]
    begun = Reached(state, command, memory, *(np.stack([part] * count) for part in others))
    low, high, status = state.copy(), state.copy(), np.full(count, places.HANDED)
    times, states = np.zeros((count, rows)), np.zeros((count, rows, n))
    span_states = np.zeros((count, stepping.span_times.size, n))
    kept = (times, states, stepping.span_times, span_states, low, high, status)
    if isinstance(code, SideBySide):
        fresh = begun.copy()
        run_lanes(code, ready, stepping, begun, params, kept, crew)
        beside = status != places.HANDED
        alone = np.flatnonzero(~beside)
        for part, first in zip(begun, fresh, strict=True):
            part[alone] = first[alone]
    else:
        beside, alone = np.zeros(count, bool), np.arange(count)
    _run_alone(loop, ready, stepping, begun, params, kept, alone, crew)
    clocks = begun.clock
    marks = clocks[:, places.STORED].astype(np.int64)
    row, chosen = np.arange(count)[:, np.newaxis], np.array([kept_marks(min(int(each), rows)) for each in marks])
    mark_times, mark_states = times[row, chosen], states[row, chosen]
    mark_times[marks == 0], mark_states[marks == 0] = np.nan, np.nan
    return _Carried(
        start=start,
        final=begun.state,
        commands=begun.command,
        memories=begun.memory,
        low=low,
        high=high,
        clocks=clocks,
        status=status,
        samples=begun.agenda[:, 0, places.CALLS].astype(np.int64),
        mark_times=mark_times,
        mark_states=mark_states,
        span_states=span_states,
        lanes=beside,
        troubles=np.array([_end_partners(ready, *each) for each in zip(cases, begun.memory, strict=True)], object),
    )


def _end_partners(ready: Prepared, case: Case, row: Array) -> str:
    """Ends what a case has exchanged values with; why that failed, empty if it did not."""
    memory = as_memory(case, row) if ready.partners else {}
    trouble = troubles(ready.partners, memory)
    release_all(ready.partners, memory)
    return trouble


def _run_alone(
    loop: Loop,
    ready: Prepared,
    stepping: Stepping,
    begun: Reached,
    params: Array,
    kept: Any,
    order: npt.NDArray[np.int64],
    crew: Crew,
) -> None:
    """Runs each case of these rows by itself; all arrays are changed in place."""
    nothing = [np.zeros((0, part.shape[1])) for part in begun[:3]]

    def work(queue: npt.NDArray[np.int64]) -> None:
        bench = workbench(ready.plan, begun.state.shape[1], ready.width.size, ready.pattern)
        loop.batch(
            *ready.linked[:4],
            *(*begun[:3], params, ready.plan, *begun[3:]),
            *(ready.atol, ready.rtol, ready.scale, ready.floor, ready.width, ready.pattern, bench),
            *(stepping.until, stepping.longest_step, stepping.means_from(stepping.until), stepping.method.value),
            *(np.zeros(0), *nothing, *kept, order, queue),
        )

    if order.size and not crew.is_halted:
        crew.carry_out(work)


def _difference(shape: tuple[tuple[str, object], ...], other: tuple[tuple[str, object], ...]) -> str | None:
    if shape == other:
        return None
    mine, others = dict(shape), dict(other)
    name = next(name for name in (*mine, *others) if mine.get(name) != others.get(name))
    return f"{name} is {_form(mine.get(name))} against {_form(others.get(name))}"


def _form(found: object) -> str:
    if found is None:
        return "nothing"
    if isinstance(found, str):
        return f"a {found}"
    return "a number" if found in (0, ()) else f"an array of {found if isinstance(found, tuple) else f'{found} axes'}"


def _threads(cores: int | None) -> int:
    """How many threads carry out a batch: `cores`, or all that this process may use."""
    most = all_cores()
    if cores is not None and not 1 <= cores <= most:
        raise ParameterError(f"{cores} cores; expected 1 to {most}")
    return cores or most
