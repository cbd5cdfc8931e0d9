"""The compiled loop: one for all circuits. Flat vectors in, and pointers to the linked functions.

It is compiled once per installation and cached. What a run has reached is in `clock`, `agenda` and `course` (and in the
vectors that it changes in place), so a run can be handed back at any step and taken up again with the same result to
the last bit.
"""

from typing import Any, NamedTuple

import numpy as np

from vvdp.base.arrays import Array
from vvdp.generator.kinds import FLOAT, INT, Address, Record, Row
from vvdp.numerics.sparse import Pattern
from vvdp.simulation.landing import (
    GRAIN,
    follow,
    forget,
    guess,
    hold,
    is_left,
    last_change,
    lateness,
    positions,
    settle,
)
from vvdp.simulation.marks import begin_spans, pass_marks, store_records
from vvdp.simulation.pace import (
    EXPLICIT_BELOW,
    FIRST_STEPS,
    TINY,
    choose_method,
    grow,
    next_step,
    note_event,
    note_jump,
    refuse,
)
from vvdp.simulation.places import (
    AIMED,
    AUTOMATIC,
    BEGUN,
    BELOW_ZERO,
    CULPRIT,
    DONE,
    EVALUATIONS,
    FASTEST,
    FIRST,
    HAIR,
    HALT,
    HASTY,
    LANDED,
    LAST,
    MARK_BEFORE,
    MARKS_FULL,
    METHOD,
    NOT_FINITE,
    PAUSED,
    PERIOD,
    REFUSED,
    REJECTED,
    RESTLESS,
    SIGNS,
    STEP,
    STEP_BEFORE,
    STEP_TOO_SMALL,
    STEPS,
    STIFF,
    STOP_BEHIND,
    STORED,
    TIME,
    TOO_MANY_WAITING,
)
from vvdp.simulation.queue import take
from vvdp.simulation.schedule import begin, instant, landing_time, next_due
from vvdp.simulation.steps import below, between, copy, explicit_step, fill, widen
from vvdp.simulation.stiff import stiff_step

VECTOR, MATRIX, CUBE, TESSERACT = (Row(FLOAT, (None,) * axes) for axes in range(1, 5))
INTS, TABLE = Row(INT, (None,)), Row(INT, (None, None))
RATES = Address((FLOAT, *[VECTOR] * 4), None)
SAMPLE = Address((INT, FLOAT, *[VECTOR] * 5), None)
EVENT_LIST = Address((FLOAT, *[VECTOR] * 4), None)
STOP = Address((FLOAT, VECTOR, VECTOR), FLOAT)
PATTERN = Record(Pattern, (*[INTS] * 5, TABLE, *[INTS] * 2, *[TABLE] * 3, INTS))


class Workbench(NamedTuple):
    """Room for a run between its steps: it makes no array itself."""

    trial: Any  # (n,)
    error: Any  # (n,)
    lean: Any  # (n,)
    middle: Any  # (n,)
    rate: Any  # (n + modes,)
    shifted: Any  # (n + modes,)
    slope: Any  # (n,)
    before: Any  # (positions,), as all that follow
    x: Any
    g: Any
    held: Any
    grain: Any
    low: Any
    high: Any
    jacobian: Any  # (entries,)
    factors: Any
    k: Any  # (7, n + modes)
    stages: Any  # (6, n)


BENCH = Record(Workbench, (*[VECTOR] * 16, *[MATRIX] * 2))

# After so many refusals in a row a step is tried with the explicit method: at a jump of the rates the stiff one's
# Jacobian by differences is the jump over a hair's breadth, and no step is short enough for it.
PATIENCE = 6.0

# Tries to land on one event; where a floor jumps, each halves what is left of the step.
TRIES = 60

# So many events in haste: the modes chatter.
MANY = 200.0


def first_change(rates, events, t, step, y, u, p, near, bench):
    """Where on its cubic the first floor changes, as a fraction of the step, how far it surely has not, and the cost.

    near  what is near enough, as a fraction of the step
    """
    lo, hi, same, cost = 0.0, 1.0, 0, 0.0
    k, trial, middle, rate, x = bench.k, bench.trial, bench.middle, bench.rate, bench.g
    held, grain, low, high = bench.held, bench.grain, bench.low, bench.high
    copy(low, bench.before)
    copy(high, bench.x)
    for _ in range(TRIES):
        if hi - lo <= near:
            break
        s = guess(lo, hi, low, high, held, grain) + (0.5 * near if same < 0 else -0.5 * near)
        if abs(same) > 2 or not lo < s < hi:
            s, same = 0.5 * (lo + hi), 0
        between(s, step, y, trial, k, middle)
        if rate.size > y.size:
            rates(t + s * step, middle, u, p, rate)
            cost += 1.0
        positions(events, t + s * step, middle, u, p, rate, x)
        if is_left(x, held, grain):
            hi, same = s, max(same, 0) + 1
            copy(high, x)
        else:
            lo, same = s, min(same, 0) - 1
            copy(low, x)
    return guess(lo, hi, low, high, held, grain), lo, cost


RUN = (
    RATES, SAMPLE, EVENT_LIST, STOP,
    VECTOR, VECTOR, VECTOR, VECTOR, MATRIX, MATRIX, CUBE, VECTOR, MATRIX, VECTOR, VECTOR, VECTOR, VECTOR, VECTOR,
    PATTERN, BENCH, FLOAT, FLOAT, FLOAT, INT, FLOAT, INT,
    VECTOR, MATRIX, MATRIX, MATRIX, VECTOR, MATRIX, VECTOR, MATRIX, VECTOR, VECTOR,
)  # fmt: skip


def run(
    rates, sample, events, stop,
    y, command, memory, params, plan, agenda, waiting, clock, course, atol, rtol, scale, floor, width,
    pattern, bench, t_end, longest, marks_from, method, budget, overwrite,
    record_times, record, record_command, record_memory, mark_times, mark_states, span_times, span_states, low, high,
):  # fmt: skip
    """Carries a run on from where `clock` stands, to `t_end` or until `budget` evaluations are spent.

    Every step ends at the latest on the next sample, where a command begins to act, where a span begins, and on the
    next time that `stop` names; rates at a step's right end are taken just before that instant. A step in which the
    floor of a trigger, a mode or a kink changes is taken again until it ends there, by less than the share `width` of a
    step behind it. States at `record_times` go to `record`, with the command and the memory that hold until then, those
    at `span_times` to `span_states`; at each change of the floor of the mark (from `marks_from` on) they go to
    `mark_states`; when that is full the run is handed back, or with `overwrite` the last row is kept up to date. A
    state that has fallen below its `floor` ends the run.
    """
    period, active = plan[0, PERIOD], pattern.group.size
    modes = int(plan[0, LAST]) - int(plan[0, FIRST])
    trial, error, lean, middle, k = bench.trial, bench.error, bench.lean, bench.middle, bench.k
    before, x, g, held, grain = bench.before, bench.x, bench.g, bench.held, bench.grain
    fill(held, 0.0)
    fill(grain, 0.0)
    for i in range(width.size - modes, width.size):
        grain[i] = GRAIN
    heaviness = EXPLICIT_BELOW * (pattern.first.size + 6.0) / 6.0
    t, h = clock[TIME], clock[STEP]
    enough = clock[EVALUATIONS] + budget
    if clock[BEGUN] == 0.0:
        clock[BEGUN], clock[LANDED] = 1.0, 1.0
        settle(rates, t, y, command, params, plan, k[0])  # what is measured at once depends on the modes
        events(t, y, command, params, g)
        clock[MARK_BEFORE] = g[0]
        if not begin(sample, events, t, y, command, memory, params, plan, agenda, waiting, g):
            return TOO_MANY_WAITING
    restless = settle(rates, t, y, command, params, plan, k[0])
    if restless >= 0:
        clock[CULPRIT] = restless
        return RESTLESS
    positions(events, t, y, command, params, k[0], before)
    hold(plan, agenda, command, held)
    t_span = begin_spans(clock, t, y, span_times, span_states)
    t_stop, t_due = stop(t, command, params), min(next_due(plan, agenda), t_span)
    again, tries = 0.0, 0  # the step to be tried again, where the last one went over an event
    spent, taken, refused, fastest = clock[EVALUATIONS], clock[STEPS], clock[REJECTED], clock[FASTEST]
    while t < t_end - HAIR * abs(t_end):
        if not t_stop > t:
            return STOP_BEHIND
        t_next = landing_time(t_stop, t_due, t_end)
        if tries == 0:
            if clock[EVALUATIONS] >= enough:
                return PAUSED
            spent, taken, refused, fastest = clock[EVALUATIONS], clock[STEPS], clock[REJECTED], clock[FASTEST]
            step, aimed = next_step(clock, course, before, held, grain)
        else:
            step, aimed = again, False
        last = t + step * (1.0 + 1e-9) >= t_next
        step = t_next - t if last else step
        t_new = t_next if last else t + step
        t_right = np.nextafter(t_new, -np.inf) if last else t_new
        stiff = clock[METHOD] == STIFF and clock[REFUSED] < PATIENCE
        if method == AUTOMATIC and step * clock[FASTEST] < heaviness and clock[SIGNS] > FIRST_STEPS:
            stiff = False
        if stiff:
            cost, clock[FASTEST] = stiff_step(
                rates, t, step, t_right, y, command, params, scale, pattern, k, trial, error, bench
            )
            exponent = -0.25
        else:
            cost = explicit_step(rates, t, step, t_right, y, command, params, active, k, trial, error, lean)
            exponent = -0.2
        clock[EVALUATIONS] += cost
        clock[STEPS] += 1.0
        size, leant, turned, finite = 0.0, 0.0, 0.0, True
        for m in range(active):
            tolerance = 1.0 / (atol[m] + rtol[m] * max(abs(y[m]), abs(trial[m])))
            e, l, d = error[m] * tolerance, lean[m] * tolerance, (k[6, m] - k[5, m]) * tolerance
            finite = finite and abs(e) < 1e300
            size += e * e
            leant += l * l
            turned += d * d
        size = np.sqrt(size / max(active, 1))
        if not finite or size > 1.0:
            tries = 0
            h = refuse(clock, step, size, finite, exponent)
            if h < 1e-14 * max(abs(t), period):
                return STEP_TOO_SMALL if finite else NOT_FINITE
            continue
        positions(events, t_new, trial, command, params, k[6], x)
        event = is_left(x, held, grain)
        if event and step > 4.0 * HAIR * abs(t_new) and tries < TRIES:
            late, near = lateness(before, x, held, grain, width, t_new, step, max(h, step))
            if late > 1.0:
                s, sure, evaluations = first_change(
                    rates, events, t, step, y, command, params,
                    0.2 * near if tries > 0 else max(0.2 * near, 1e-5), bench,
                )  # fmt: skip
                clock[EVALUATIONS] += evaluations
                if 1.0 - sure > near:
                    tries += 1
                    clock[REJECTED] += 1.0
                    again = step * min(s + 0.5 * near, 1.0 - 0.1 * near)
                    continue
        change = np.floor(x[0]) - np.floor(clock[MARK_BEFORE])
        if overwrite == 0 and clock[STORED] + abs(change) > mark_times.size:
            # The step is taken again when there is room, however many marks it passes.
            clock[EVALUATIONS], clock[STEPS], clock[REJECTED], clock[FASTEST] = spent, taken, refused, fastest
            return MARKS_FULL
        if change != 0.0:
            pass_marks(
                events, clock, t, step, y, command, params, trial, k, middle, g,
                x[0], marks_from, mark_times, mark_states,
            )  # fmt: skip
        clock[MARK_BEFORE] = x[0]
        ended = t_new >= t_end - HAIR * abs(t_end)
        store_records(
            clock, t, t_new, step, ended, y, trial, k, command, memory,
            record_times, record, record_command, record_memory,
        )  # fmt: skip
        widen(low, high, active, step, y, trial, k)
        note_jump(clock, t_new)
        follow(course, before, x, step, clock[STEP_BEFORE])
        clock[STEP_BEFORE] = step
        t = t_new
        copy(y, trial)
        fallen = below(y, floor, active)
        if fallen >= 0:
            clock[TIME], clock[CULPRIT] = t, fallen
            return BELOW_ZERO
        landed = last or event
        cut = landed or step < h
        h = grow(clock, size, step, h, exponent, cut, longest)
        if method == AUTOMATIC:
            choose_method(clock, step, cut, heaviness, step * np.sqrt(turned / max(leant, TINY)))
        clock[REFUSED], tries = 0.0, 0
        clock[LANDED] = 1.0 if landed else 0.0
        clock[AIMED] = 1.0 if aimed and not event else 0.0
        if landed:
            if event:
                note_event(clock, t)
            copy(g, x)
            if not instant(sample, events, t, y, command, memory, params, plan, agenda, waiting, g):
                clock[TIME] = t
                return TOO_MANY_WAITING
            restless = settle(rates, t, y, command, params, plan, k[0])
            if restless >= 0 or clock[HASTY] > MANY:
                clock[TIME], clock[CULPRIT] = t, restless if restless >= 0 else last_change(x, held, grain)
                return RESTLESS
            positions(events, t, y, command, params, k[0], before)
            copy(g, held)
            hold(plan, agenda, command, held)
            forget(course, held, g)
            t_span = begin_spans(clock, t, y, span_times, span_states)
            t_stop, t_due = stop(t, command, params), min(next_due(plan, agenda), t_span)
        else:
            copy(k[0], k[6])
            copy(before, x)
        clock[TIME], clock[STEP] = t, h
    return DONE


def workbench(plan: Array, n: int, positions: int, pattern: Pattern) -> Workbench:
    """A workbench for n states and so many positions."""
    zeros, behind = np.zeros, n + int(plan[0, LAST]) - int(plan[0, FIRST])
    return Workbench(
        trial=zeros(n),
        error=zeros(n),
        lean=zeros(n),
        middle=zeros(n),
        rate=zeros(behind),
        shifted=zeros(behind),
        slope=zeros(n),
        before=zeros(positions),
        x=zeros(positions),
        g=zeros(positions),
        held=zeros(positions),
        grain=zeros(positions),
        low=zeros(positions),
        high=zeros(positions),
        jacobian=zeros(pattern.rows.size),
        factors=zeros(pattern.group.size + 2 * pattern.lower.shape[0]),
        k=zeros((7, behind)),
        stages=zeros((6, n)),
    )


PORTION = 2000.0
"""Evaluations of a case in a batch between two looks at whether all are to stop: at most some milliseconds."""

BATCH = (
    RATES, SAMPLE, EVENT_LIST, STOP,
    MATRIX, MATRIX, MATRIX, MATRIX, MATRIX, CUBE, TESSERACT, MATRIX, CUBE,
    VECTOR, VECTOR, VECTOR, VECTOR, VECTOR, PATTERN, BENCH, FLOAT, FLOAT, FLOAT, INT,
    VECTOR, MATRIX, MATRIX, MATRIX,
    MATRIX, CUBE, VECTOR, CUBE, MATRIX, MATRIX, INTS, INTS, INTS,
)  # fmt: skip


def batch(
    rates, sample, events, stop,
    y, command, memory, params, plan, agenda, waiting, clocks, course, atol, rtol, scale, floor, width,
    pattern, bench, t_end, longest, marks_from, method, record_times, record, record_command, record_memory,
    mark_times, mark_states, span_times, span_states, low, high, status, order, queue,
):  # fmt: skip
    """Runs the cases of these rows, in this order, one after the other; of the marks keeps the first and the last.

    order  rows of the arrays that have one for each case; `y` and the like are changed in place
    queue  the place of the next case in `order`, shared with others who do the same with workbenches of their own
    """
    while queue[HALT] == 0:
        place = take(queue)
        if place >= order.size:
            break
        case = order[place]
        copy(low[case], y[case])
        copy(high[case], y[case])
        status[case] = PAUSED
        while status[case] == PAUSED and queue[HALT] == 0:
            status[case] = run(
                rates, sample, events, stop,
                y[case], command[case], memory[case], params[case], plan, agenda[case], waiting[case], clocks[case],
                course[case], atol, rtol, scale, floor, width,
                pattern, bench, t_end, longest, marks_from, method, PORTION, 1,
                record_times, record, record_command, record_memory,
                mark_times[case], mark_states[case], span_times, span_states[case], low[case], high[case],
            )  # fmt: skip
