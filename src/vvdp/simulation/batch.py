"""Many cases of one model at once, on all cores; nothing is recorded but what a summary needs."""

import time
from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from vvdp.base.arrays import Array
from vvdp.base.errors import ParameterError, RunError
from vvdp.simulation import places
from vvdp.simulation.case_rows import CaseRows, case_rows
from vvdp.simulation.crew import Crew
from vvdp.simulation.exchange import release_all, troubles
from vvdp.simulation.lanes import SideBySide, run_lanes, side_by_side
from vvdp.simulation.layout import as_memory, case_form
from vvdp.simulation.layout import case_shape as case_shape
from vvdp.simulation.link import quiet
from vvdp.simulation.loop import workbench
from vvdp.simulation.loops import Loop, compiled_loop
from vvdp.simulation.model import Case, Model
from vvdp.simulation.outcome import Outcome, Window, kept_marks, marked_window, plain_window
from vvdp.simulation.prepare import Prepared, prepare
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
        return self.outcome_over(case, self._window(case))

    def outcome_over(self, case: int, window: Window) -> Outcome:
        """The same of any case, with means over this window."""
        return Outcome(
            model=self.model,
            case=self.cases[case],
            window=window,
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
    crew: Crew | None = None,
    *,
    lanes: bool = True,
    say: Callable[[str], None] = quiet,
) -> BatchRun:
    """All `cases` run to `stepping.until`; marks count from its `average_from` on.

    With `lanes` a core carries several cases at once where the model allows it. They then agree with `simulate`
    within the tolerance, and to the last bit with any other batch that they are in, on any number of cores. Without,
    and where the result says that a case ran alone, they agree with `simulate` to the last bit.

    A case that fails is reported in the result and stops no other. Once the `crew` (all cores, unless said) is stopped,
    no case goes on, and those that have not ended are reported likewise. Raises ParameterError where the cases are not
    of one shape.
    """
    _are_of_one_shape(cases)
    began = time.perf_counter()
    ready = prepare(model, cases[0], stepping, say)
    loop = compiled_loop(say)
    code = _lane_code(model, cases[0], ready, stepping, say) if lanes else "lanes were not asked for"
    work = _Work(ready, stepping, loop, code, crew or Crew())
    part = _carry_out_all(work, cases)
    clocks = part.rows.clock
    return BatchRun(
        model=model,
        cases=tuple(cases),
        stepping=stepping,
        final=part.rows.state,
        final_commands=part.rows.command,
        final_memories=part.rows.memory,
        low=part.rows.low,
        high=part.rows.high,
        mark_times=part.rows.mark_times,
        mark_states=part.rows.mark_states,
        span_states=part.rows.span_states,
        end=np.where(part.rows.status == places.DONE, stepping.until, clocks[:, places.TIME]),
        stiff=clocks[:, places.METHOD] == places.STIFF,
        reasons=_reasons(cases, part),
        remarks=tuple(remarks(clock) for clock in clocks),
        seconds=time.perf_counter() - began,
        digest=ready.linked.digest,
        lanes=tuple(part.lanes.tolist()),
        stopped=work.crew.is_halted,
        why_alone=code if isinstance(code, str) else None,
        **_counts(part.rows),
    )


def _lane_code(
    model: Model, case: Case, ready: Prepared, stepping: Stepping, say: Callable[[str], None]
) -> SideBySide | str:
    """The code for cases side by side, or why they run alone."""
    if stepping.method is Method.STIFF:
        return "the stiff method carries each case alone"
    if model.partners:
        return "a program exchanges values with a model outside"
    return side_by_side(model, case, ready.linked.digest, say)


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


class _Work(NamedTuple):
    """What runs the cases of a batch."""

    ready: Prepared
    stepping: Stepping
    loop: Loop
    code: SideBySide | str  # for cases side by side, or why they run alone
    crew: Crew


class _Carried(NamedTuple):
    """Rows after their run, of the marks those that are kept; where each case began, whether it ran in a lane, and what
    went wrong at its end."""

    rows: CaseRows
    start: Array
    lanes: npt.NDArray[np.bool_]
    troubles: npt.NDArray[np.object_]


def _carry_out_all(work: _Work, cases: Sequence[Case]) -> _Carried:
    """Runs all cases, those with more marks than there is room for a second time."""
    room = int(np.clip(_places(work.ready, len(cases)), 16, MOST_ROWS))
    part = _carry_out(work, cases, room)
    crowded = np.flatnonzero(part.rows.clock[:, places.STORED] >= room)  # marks on the way have been written over
    if crowded.size:
        room = int(part.rows.clock[crowded, places.MARKS].max()) + 1
        at_once = max(1, _places(work.ready, room))
        for some in np.split(crowded, range(at_once, crowded.size, at_once)):
            again = _carry_out(work, [cases[row] for row in some], room)
            part.rows.put(some, again.rows)
            part.lanes[some], part.troubles[some] = again.lanes, again.troubles
    return part


def _places(ready: Prepared, others: int) -> int:
    """How many states fit into the memory for marks for each of `others`."""
    return MARKS_MEMORY // (8 * ready.vectors.state.size * others)


def _carry_out(work: _Work, cases: Sequence[Case], room: int) -> _Carried:
    rows = case_rows(cases, work.ready, work.stepping, room)
    start, fresh = rows.state.copy(), [part.copy() for part in rows.progress()]
    if isinstance(work.code, SideBySide):
        run_lanes(work.code, work.ready, work.stepping, rows, work.crew)
    beside = rows.status != places.HANDED
    alone = np.flatnonzero(~beside)
    for part, first in zip(rows.progress(), fresh, strict=True):
        part[alone] = first[alone]
    _run_alone(work, rows, alone)
    marks = rows.clock[:, places.STORED].astype(np.int64)
    row, chosen = np.arange(len(cases))[:, np.newaxis], np.array([kept_marks(min(int(each), room)) for each in marks])
    times, states = rows.mark_times[row, chosen], rows.mark_states[row, chosen]
    times[marks == 0], states[marks == 0] = np.nan, np.nan
    ends = [_end_partners(work.ready, *each) for each in zip(cases, rows.memory, strict=True)]
    return _Carried(rows._replace(mark_times=times, mark_states=states), start, beside, np.array(ends, object))


def _run_alone(work: _Work, rows: CaseRows, order: npt.NDArray[np.int64]) -> None:
    """Runs each case of these rows by itself; all arrays are changed in place."""
    ready, stepping = work.ready, work.stepping
    nothing = [np.zeros((0, part.shape[1])) for part in rows[:3]]
    kept = rows.mark_times, rows.mark_states, stepping.span_times, rows.span_states, rows.low, rows.high, rows.status

    def run(queue: npt.NDArray[np.int64]) -> None:
        bench = workbench(ready.plan, rows.state.shape[1], ready.width.size, ready.pattern)
        work.loop.batch(
            *ready.linked[:4],
            *(*rows[:4], ready.plan, *rows[4:8]),
            *(ready.atol, ready.rtol, ready.scale, ready.floor, ready.width, ready.pattern, bench),
            *(stepping.until, stepping.longest_step, stepping.means_from(stepping.until), stepping.method.value),
            *(np.zeros(0), *nothing, *kept, order, queue),
        )

    if order.size and not work.crew.is_halted:
        work.crew.carry_out(run)


def _end_partners(ready: Prepared, case: Case, row: Array) -> str:
    """Ends what a case has exchanged values with; why that failed, empty if it did not."""
    memory = as_memory(case, row) if ready.partners else {}
    trouble = troubles(ready.partners, memory)
    release_all(ready.partners, memory)
    return trouble


def _reasons(cases: Sequence[Case], part: _Carried) -> tuple[str | None, ...]:
    """Why each case could not be carried to its end; None where it was."""
    low, high = start_bounds(cases[0].state)
    begun = ((low <= part.start) & (part.start <= high)).all(axis=1)
    ended = (part.rows.status == places.DONE) & (part.troubles == "") & begun
    each = zip(ended, part.troubles, cases, part.rows.clock, part.rows.state, part.rows.status, strict=True)
    return tuple(None if well else trouble or _reason(*about) for well, trouble, *about in each)


def _reason(case: Case, clock: Array, state: Array, status: int) -> str | None:
    if status in (places.PAUSED, places.HANDED):
        return f"stopped at t = {clock[places.TIME]:.6g} s"
    try:
        check_start(case)
    except RunError as problem:
        return str(problem)
    return None if status == places.DONE else failure(case, clock, state, status)


def _counts(rows: CaseRows) -> dict[str, npt.NDArray[np.int64]]:
    named = {"marks": places.STORED, "evaluations": places.EVALUATIONS, "switches": places.SWITCHES}
    counts = {name: rows.clock[:, place].astype(np.int64) for name, place in named.items()}
    counts["rejected"] = rows.clock[:, places.REJECTED].astype(np.int64)
    counts["steps"] = rows.clock[:, places.STEPS].astype(np.int64) - counts["rejected"]
    counts["samples"] = rows.agenda[:, 0, places.CALLS].astype(np.int64)
    return counts


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
