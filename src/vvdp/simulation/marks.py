"""States that a run keeps, compiled: at its marks and records, on the cubic of a step, and where its spans begin."""

import numpy as np

from vvdp.simulation.places import HAIR, MARK_BEFORE, MARKS, RECORDS, SPANS, STORED
from vvdp.simulation.steps import between, copy


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


def pass_marks(events, clock, t, step, y, u, p, trial, k, middle, g, mark, marks_from, mark_times, mark_states):
    """Stores the states at the marks from `clock` to `mark`, the value at the end; when full, over the last row."""
    before = clock[MARK_BEFORE]
    change = np.floor(mark) - np.floor(before)
    for i in range(int(abs(change))):
        level = np.floor(before) + 1.0 + i if change > 0.0 else np.floor(before) - i
        s = mark_fraction(events, t, step, y, u, p, trial, k, middle, g, level, before < level)
        clock[MARKS] += 1.0
        if t + s * step >= marks_from:
            row = min(int(clock[STORED]), mark_times.size - 1)
            between(s, step, y, trial, k, mark_states[row])
            mark_times[row] = t + s * step
            clock[STORED] = row + 1.0
    clock[MARK_BEFORE] = mark


def store_records(
    clock, t, t_new, step, ended, y, trial, k, command, memory, record_times, record, record_command, record_memory
):
    """Stores state, command and memory at the times to be recorded up to `t_new`; the last ones where a run `ended`."""
    row = int(clock[RECORDS])
    while row < record_times.size and (record_times[row] <= t_new or ended):
        between(min(1.0, (record_times[row] - t) / step), step, y, trial, k, record[row])
        copy(record_command[row], command)
        copy(record_memory[row], memory)
        row += 1
    clock[RECORDS] = row


def begin_spans(clock, t, y, span_times, span_states):
    """Stores the state at the spans that begin at `t`; when the next one begins [s], infinite after the last."""
    row = int(clock[SPANS])
    while row < span_times.size and span_times[row] <= t + HAIR * abs(t):
        copy(span_states[row], y)
        row += 1
    clock[SPANS] = row
    return span_times[row] if row < span_times.size else np.inf
