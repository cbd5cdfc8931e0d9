"""Where a step must end, compiled: at the first instant at which the floor of a trigger, a mode or a kink changes.

`x` has the mark of a run at place 0, then its triggers, then its modes and kinks; `held` has the floors that hold.
`course` has a column for each of them: how fast it went in the last step [1/s], its acceleration [1/s^2], and whether
these are known.
"""

import numpy as np
from numba import njit

from vvdp.simulation.places import FIRST, LAST, LEVEL, TRIGGER

SETTLINGS = 32
"""How often modes may change at one instant."""


@njit(cache=True, error_model="numpy", inline="always")
def positions(events, t, y, u, p, rate, x):
    """Fills `x` from the events and from what stands behind the rates, `rate`."""
    events(t, y, u, p, x)
    behind = rate.size - y.size
    for i in range(behind):
        x[x.size - behind + i] = rate[y.size + i]


@njit(cache=True, error_model="numpy")
def settle(rates, t, y, u, p, plan, rate):
    """Rates at an instant with the modes that hold there; the place of one that finds no rest, else -1."""
    first, n, restless = int(plan[0, FIRST]), y.size, -1
    for _ in range(SETTLINGS):
        rates(t, y, u, p, rate)
        restless = -1
        for i in range(rate.size - n):
            mode = np.floor(rate[n + i])
            if mode != u[first + i]:
                u[first + i] = mode
                restless = i
        if restless < 0:
            break
    return restless


@njit(cache=True, error_model="numpy")
def hold(plan, agenda, u, course, held):
    """Fills `held`, and forgets the course of what has changed."""
    for k in range(1, plan.shape[0]):
        if plan[k, TRIGGER] > 0.0:
            _keep(int(plan[k, TRIGGER]), agenda[k, LEVEL], course, held)
    first, modes = int(plan[0, FIRST]), int(plan[0, LAST]) - int(plan[0, FIRST])
    for i in range(modes):
        _keep(held.size - modes + i, u[first + i], course, held)


@njit(cache=True, error_model="numpy", inline="always")
def _keep(i, floor, course, held):
    if held[i] != floor:
        held[i] = floor
        course[2, i] = 0.0


@njit(cache=True, error_model="numpy", inline="always")
def is_left(x, held):
    """Whether any floor has changed."""
    for i in range(1, x.size):
        if np.floor(x[i]) != held[i]:
            return True
    return False


@njit(cache=True, error_model="numpy")
def follow(course, before, x, step, step_before):
    """Brings the course up to the end of a step."""
    for i in range(1, x.size):
        speed = (x[i] - before[i]) / step
        course[1, i] = course[2, i] * 2.0 * (speed - course[0, i]) / (step + step_before)
        course[0, i] = speed
        course[2, i] = 1.0


@njit(cache=True, error_model="numpy")
def time_left(course, x, held, step_before):
    """The time [s] after which the first floor is expected to change; infinite where none is."""
    least = np.inf
    for i in range(1, x.size):
        if course[2, i] == 0.0:
            continue
        acceleration = course[1, i]
        speed = course[0, i] + 0.5 * acceleration * step_before
        distance = (held[i] + 1.0 if speed > 0.0 else held[i]) - x[i]
        s = distance / speed
        for _ in range(3):
            s = distance / (speed + 0.5 * acceleration * s)
        if s > 0.0:
            least = min(least, s)
    return least


@njit(cache=True, error_model="numpy")
def guess(lo, hi, before, after, held):
    """The earliest place between `lo` and `hi` at which a line from `before` to `after` says that a floor changes."""
    found = hi
    for i in range(1, held.size):
        if np.floor(after[i]) != held[i]:
            edge = held[i] + 1.0 if after[i] >= held[i] + 1.0 else held[i]
            share = (edge - before[i]) / (after[i] - before[i])
            found = min(found, lo + (hi - lo) * min(1.0, max(0.0, share)))
    return found


@njit(cache=True, error_model="numpy")
def lateness(before, x, held, width, step, usual):
    """How far a step has gone behind its events, over what is allowed, and what is, as a share of the step.

    usual  the step that would be taken without events, of which `width` is a share [s]
    """
    worst, near = 0.0, 1.0
    for i in range(1, held.size):
        if np.floor(x[i]) != held[i]:
            edge = held[i] + 1.0 if x[i] >= held[i] + 1.0 else held[i]
            allowed = width[i] * usual / step
            worst = max(worst, (x[i] - edge) / (x[i] - before[i]) / allowed)
            near = min(near, allowed)
    return worst, near


@njit(cache=True, error_model="numpy")
def changed(x, held):
    """The number of the last mode or kink whose floor has changed, counted from the end."""
    found = 1
    for i in range(1, held.size):
        if np.floor(x[i]) != held[i]:
            found = i
    return found - held.size
