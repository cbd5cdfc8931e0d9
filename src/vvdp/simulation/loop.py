"""The compiled loop: one for all circuits. Flat vectors in, and pointers to the linked functions.

It is compiled once per installation and cached. What a run has reached is in `clock` and `agenda` (and in the vectors
that it changes in place), so a run can be handed back at any step and taken up again with the same result to the last
bit.
"""

import numpy as np
from numba import float64, int64, njit, prange, types

from vvdp.simulation.places import (
    AUTOMATIC,
    BEGUN,
    DONE,
    EVALUATIONS,
    HAIR,
    JUMP_TIME,
    JUMPS,
    LANDED,
    MARK_BEFORE,
    MARKS,
    MARKS_FULL,
    METHOD,
    NOT_FINITE,
    OTHER_COST,
    PAUSED,
    PERIOD,
    RECORDS,
    REFUSED,
    REJECTED,
    REVIEW,
    STEP,
    STEP_TOO_SMALL,
    STEPS,
    STIFF,
    STOP_BEHIND,
    STORED,
    SWITCHES,
    TIME,
    TOO_MANY_WAITING,
    TRIAL,
    TRIGGER,
    WINDOW_COST,
    WINDOW_TIME,
)
from vvdp.simulation.schedule import begin, instant, is_crossed, next_due
from vvdp.simulation.steps import between, explicit_step, stiff_step, widen

VECTOR = float64[::1]
MATRIX = float64[:, ::1]
CUBE = float64[:, :, ::1]
RATES = types.FunctionType(types.void(float64, VECTOR, VECTOR, VECTOR, VECTOR))
SAMPLE = types.FunctionType(types.void(int64, float64, VECTOR, VECTOR, VECTOR, VECTOR, VECTOR))
EVENTS = types.FunctionType(types.void(float64, VECTOR, VECTOR, VECTOR, VECTOR))
STOP = types.FunctionType(float64(float64, VECTOR, VECTOR))

# An event is where its crossing is known to this share of the step.
NEAR = 1e-12

# The automatic choice: an explicit window that costs more than this many evaluations per sample period is worth a
# trial of the stiff method; a window ends after so many periods or so many evaluations, whichever comes first.
TRIAL_COST = 900.0
WINDOW_PERIODS = 20.0
WINDOW_EVALUATIONS = 40000.0
REVIEW_WINDOWS = 20.0

# After so many refusals in a row a step is tried with the explicit method: at a jump of the rates the stiff one's
# Jacobian by differences is the jump over a hair's breadth, and no step is short enough for it.
PATIENCE = 6.0

# So many refusals in a row, away from every landing: a kink takes three or four, a jump more.
SERIES = 5.0


@njit(cache=True, error_model="numpy")
def chosen_method(t, period, clock):
    """Reviews the automatic choice of method: tries the other one when the present one is dear, keeps the cheaper."""
    elapsed, spent = t - clock[WINDOW_TIME], clock[EVALUATIONS] - clock[WINDOW_COST]
    if elapsed < WINDOW_PERIODS * period and spent < WINDOW_EVALUATIONS:
        return
    cost = spent / elapsed * period
    clock[WINDOW_TIME], clock[WINDOW_COST] = t, clock[EVALUATIONS]
    if clock[TRIAL] == 1.0:
        clock[TRIAL] = 0.0
        clock[REVIEW] = REVIEW_WINDOWS
        if cost > clock[OTHER_COST]:
            clock[METHOD] = STIFF - clock[METHOD]
        else:
            clock[SWITCHES] += 1.0
        return
    clock[REVIEW] -= 1.0
    if clock[REVIEW] <= 0.0 and (clock[METHOD] == STIFF or cost > TRIAL_COST):
        clock[TRIAL], clock[OTHER_COST] = 1.0, cost
        clock[METHOD] = STIFF - clock[METHOD]


@njit(cache=True, error_model="numpy")
def first_crossing(events, t, step, y, u, p, trial, k, middle, plan, agenda, g, before, after):
    """The first crossing of any trigger on the cubic, as a fraction of the step between `before` and `after`."""
    lo, hi = before, after
    for _ in range(60):
        s = 0.5 * (lo + hi)
        between(s, step, y, trial, k, middle)
        events(t + s * step, middle, u, p, g)
        if is_crossed(plan, agenda, g):
            hi = s
        else:
            lo = s
    return hi


@njit(cache=True, error_model="numpy")
def mark_fraction(events, t, step, y, u, p, trial, k, middle, g, goal, upward):
    """Where on the cubic the mark passes `goal`, as a fraction of the step."""
    lo, hi = 0.0, 1.0
    for _ in range(50):
        s = 0.5 * (lo + hi)
        between(s, step, y, trial, k, middle)
        events(t + s * step, middle, u, p, g)
        if (g[0] < goal) == upward:
            lo = s
        else:
            hi = s
    return hi


RUN = int64(
    RATES, SAMPLE, EVENTS, STOP,
    VECTOR, VECTOR, VECTOR, VECTOR, MATRIX, MATRIX, CUBE, VECTOR, VECTOR, VECTOR, VECTOR,
    int64, float64, float64, float64, int64, float64, int64,
    VECTOR, MATRIX, MATRIX, MATRIX, VECTOR, MATRIX, VECTOR, VECTOR,
)  # fmt: skip


@njit(RUN, cache=True, error_model="numpy")
def run(
    rates, sample, events, stop,
    y, command, memory, params, plan, agenda, waiting, clock, atol, rtol, scale,
    active, t_end, longest, marks_from, method, budget, overwrite,
    record_times, record, record_command, record_memory, mark_times, mark_states, low, high,
):  # fmt: skip
    """Carries a run on from where `clock` stands, to `t_end` or until `budget` evaluations are spent.

    Every step ends at the latest on the next sample, where a command begins to act and on the next time that `stop`
    names; rates at a step's right end are taken just before that instant. A step in which a trigger's floor changes
    is taken again until it ends there. States at `record_times` go to `record`, with the command and the memory that
    hold until then; at each change of the floor of the mark (from `marks_from` on) they go to `mark_states`; when
    that is full the run is handed back, or with `overwrite` the last row is kept up to date.
    """
    n, period = y.size, plan[0, PERIOD]
    trial, error, middle, k = np.zeros(n), np.zeros(n), np.zeros(n), np.zeros((7, n))
    jacobian, matrix, pivots = np.zeros((n, active)), np.zeros((active, active)), np.zeros(active)
    triggers = 0
    for place in plan[:, TRIGGER]:
        triggers = max(triggers, int(place))
    g, reached = np.zeros(1 + triggers), np.zeros(1 + triggers)
    t, h = clock[TIME], clock[STEP]
    enough = clock[EVALUATIONS] + budget
    if clock[BEGUN] == 0.0:
        clock[BEGUN], clock[LANDED] = 1.0, 1.0
        events(t, y, command, params, g)
        clock[MARK_BEFORE] = g[0]
        if not begin(sample, events, t, y, command, memory, params, plan, agenda, waiting, g):
            return TOO_MANY_WAITING
    rates(t, y, command, params, k[0])
    t_stop, t_due = stop(t, command, params), next_due(plan, agenda)
    # Towards an event: the times between which it lies, the next one to be tried, and how often that was done.
    before, after, goal, tries = t, np.inf, np.inf, 0
    spent, taken, refused = clock[EVALUATIONS], clock[STEPS], clock[REJECTED]
    while t < t_end - HAIR * abs(t_end):
        if not t_stop > t:
            return STOP_BEHIND
        t_next = min(t_stop, t_due if t_due <= t_end + HAIR * abs(t_end) else t_end)
        if tries == 0:
            if clock[EVALUATIONS] >= enough:
                return PAUSED
            spent, taken, refused = clock[EVALUATIONS], clock[STEPS], clock[REJECTED]
            before, after = t, np.inf
            last = t + h * (1.0 + 1e-9) >= t_next
            step = t_next - t if last else h
            t_new = t_next if last else t + step
        else:
            last = goal >= t_next
            t_new, step = goal, goal - t
        t_right = np.nextafter(t_new, -np.inf) if last else t_new
        if clock[METHOD] == STIFF and clock[REFUSED] < PATIENCE:
            cost = stiff_step(
                rates, t, step, t_right, y, command, params, active, scale, k, trial, error, jacobian, matrix, pivots
            )
            exponent = -0.25
        else:
            cost = explicit_step(rates, t, step, t_right, y, command, params, active, k, trial, error)
            exponent = -0.2
        clock[EVALUATIONS] += cost
        clock[STEPS] += 1.0
        size, finite = 0.0, True
        for m in range(active):
            e = abs(error[m]) / (atol[m] + rtol[m] * max(abs(y[m]), abs(trial[m])))
            finite = finite and e < 1e300
            size += e * e
        size = np.sqrt(size / active)
        if not finite or size > 1.0:
            clock[REJECTED] += 1.0
            clock[REFUSED] += 1.0
            tries = 0
            h = step * (max(0.2, 0.9 * size**exponent) if finite else 0.1)
            clock[STEP] = h
            if h < 1e-14 * max(abs(t), period):
                return STEP_TOO_SMALL if finite else NOT_FINITE
            continue
        events(t_new, trial, command, params, reached)
        event = triggers > 0 and is_crossed(plan, agenda, reached)
        if event or (tries > 0 and goal < after):
            width = max(NEAR * step, 4.0 * HAIR * abs(t_new))
            if event:
                after = t_new
            else:
                before = t_new
            near = 0.5 * (before + after)
            if after - before > width:
                s = first_crossing(
                    events, t, step, y, command, params, trial, k, middle, plan, agenda, g,
                    (before - t) / step, (after - t) / step,
                )  # fmt: skip
                near = t + s * step
            if not (event and (after - before <= width or after - near <= width)):
                tries += 1
                clock[REJECTED] += 1.0
                goal = near + 0.5 * width if tries < 12 else 0.5 * (before + after)
                if not before < goal < after:
                    goal = after
                continue
        change = np.floor(reached[0]) - np.floor(clock[MARK_BEFORE])
        if overwrite == 0 and clock[STORED] + abs(change) > mark_times.size:
            # The step is taken again when there is room, however many marks it passes.
            clock[EVALUATIONS], clock[STEPS], clock[REJECTED] = spent, taken, refused
            return MARKS_FULL
        mark_before = clock[MARK_BEFORE]
        for i in range(int(abs(change))):
            level = np.floor(mark_before) + 1.0 + i if change > 0.0 else np.floor(mark_before) - i
            s = mark_fraction(
                events, t, step, y, command, params, trial, k, middle, g, level, mark_before < level
            )  # fmt: skip
            clock[MARKS] += 1.0
            if t + s * step >= marks_from:
                row = min(int(clock[STORED]), mark_times.size - 1)
                between(s, step, y, trial, k, mark_states[row])
                mark_times[row] = t + s * step
                clock[STORED] = row + 1.0
        clock[MARK_BEFORE] = reached[0]
        row, ended = int(clock[RECORDS]), t_new >= t_end - HAIR * abs(t_end)
        while row < record_times.size and (record_times[row] <= t_new or ended):
            between(min(1.0, (record_times[row] - t) / step), step, y, trial, k, record[row])
            record_command[row, :] = command
            record_memory[row, :] = memory
            row += 1
        clock[RECORDS] = row
        widen(low, high, active, step, y, trial, k)
        if clock[REFUSED] >= SERIES and clock[LANDED] == 0.0:
            clock[JUMPS] += 1.0
            if clock[JUMPS] == 1.0:
                clock[JUMP_TIME] = t_new
        t = t_new
        y[:] = trial
        # A step that was refused once stands before a kink: growing at once would only have the next one refused.
        grown = step * min(1.0 if clock[REFUSED] > 0.0 else 5.0, max(0.2, 0.9 * (size + 1e-12) ** exponent))
        landed = last or event
        h = min(max(h, grown) if landed else grown, longest)
        clock[REFUSED], tries = 0.0, 0
        clock[LANDED] = 1.0 if landed else 0.0
        if landed:
            if not instant(sample, events, t, y, command, memory, params, plan, agenda, waiting, reached):
                clock[TIME] = t
                return TOO_MANY_WAITING
            t_stop, t_due = stop(t, command, params), next_due(plan, agenda)
            rates(t, y, command, params, k[0])
        else:
            k[0, :] = k[6]
        clock[TIME], clock[STEP] = t, h
        if method == AUTOMATIC:
            chosen_method(t, period, clock)
    return DONE


BATCH = types.void(
    RATES, SAMPLE, EVENTS, STOP,
    MATRIX, MATRIX, MATRIX, MATRIX, MATRIX, CUBE, float64[:, :, :, ::1], MATRIX, VECTOR, VECTOR, VECTOR,
    int64, float64, float64, float64, int64,
    MATRIX, CUBE, MATRIX, MATRIX, int64[::1],
)  # fmt: skip


@njit(BATCH, cache=True, error_model="numpy", nogil=True, parallel=True)
def batch(
    rates, sample, events, stop,
    y, command, memory, params, plan, agenda, waiting, clocks, atol, rtol, scale,
    active, t_end, longest, marks_from, method,
    mark_times, mark_states, low, high, status,
):  # fmt: skip
    """Runs one case per row of `params` and `y` on all cores; of the marks keeps the first and the last.

    `y`, `command`, `memory`, `agenda`, `waiting` and `clocks` are changed in place.
    """
    for case in prange(params.shape[0]):
        n = y.shape[1]
        low[case, :] = y[case]
        high[case, :] = y[case]
        status[case] = run(
            rates, sample, events, stop,
            y[case], command[case], memory[case], params[case], plan, agenda[case], waiting[case], clocks[case],
            atol, rtol, scale,
            active, t_end, longest, marks_from, method, 1e300, 1,
            np.zeros(0), np.zeros((0, n)), np.zeros((0, command.shape[1])), np.zeros((0, memory.shape[1])),
            mark_times[case], mark_states[case], low[case], high[case],
        )  # fmt: skip
