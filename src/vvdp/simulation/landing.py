"""Where a step must end, compiled: at the first instant at which the floor of a trigger, a mode or a kink changes.

`x` has the mark of a run at place 0, then its triggers, then its modes and kinks; `held` has the floors that hold.
`course` has a column for each of them: how fast it went in the last step [1/s], its acceleration [1/s^2], and whether
these are known.
"""

import numpy as np

from vvdp.simulation.places import FIRST, HAIR, LAST, LEVEL, TRIGGER

SETTLINGS = 32
"""How often modes may change at one instant."""
GRAIN = 1e-10
"""How far behind its boundary a mode or kink has to be before it counts: what rests on a boundary does not chatter."""


def positions(events, t, y, u, p, rate, x):
    """Fills `x` from the events and from what stands behind the rates, `rate`."""
    events(t, y, u, p, x)
    behind = rate.size - y.size
    for i in range(behind):
        x[x.size - behind + i] = rate[y.size + i]


def settle(rates, t, y, u, p, plan, rate):
    """Rates at an instant with the modes that hold there; the place of one that finds no rest, else -1."""
    first, n, restless = int(plan[0, FIRST]), y.size, -1
    for _ in range(SETTLINGS):
        rates(t, y, u, p, rate)
        restless = -1
        for i in range(rate.size - n):
            if has_left(rate[n + i], u[first + i], GRAIN):
                u[first + i] = np.floor(rate[n + i])
                restless = i
        if restless < 0:
            break
    return restless


def hold(plan, agenda, u, held):
    """Fills `held` with the floors that hold."""
    for k in range(1, plan.shape[0]):
        if plan[k, TRIGGER] > 0.0:
            held[int(plan[k, TRIGGER])] = agenda[k, LEVEL]
    first, modes = int(plan[0, FIRST]), int(plan[0, LAST]) - int(plan[0, FIRST])
    for i in range(modes):
        held[held.size - modes + i] = u[first + i]


def forget(course, held, before):
    """Forgets the course of all whose floor is no longer what it was `before`."""
    for i in range(held.size):
        if held[i] != before[i]:
            course[2, i] = 0.0


def has_left(x, floor, grain):
    """Whether `x` is no longer between a floor and the next."""
    return x < floor - grain or x >= floor + 1.0 + grain


def is_left(x, held, grain):
    """Whether any floor has changed."""
    found = False
    for i in range(1, x.size):
        found = found or has_left(x[i], held[i], grain[i])
    return found


def edge(x, floor, grain):
    """The boundary on the side of `x`."""
    return floor + 1.0 + grain if x > floor + 0.5 else floor - grain


def follow(course, before, x, step, step_before):
    """Brings the course up to the end of a step."""
    per_step, per_mean = 1.0 / step, 2.0 / (step + step_before)
    for i in range(1, x.size):
        speed = (x[i] - before[i]) * per_step
        course[1, i] = course[2, i] * (speed - course[0, i]) * per_mean
        course[0, i] = speed
        course[2, i] = 1.0


def time_left(course, x, held, grain, step_before, soon):
    """The time [s] after which the first floor is expected to change; infinite where none is.

    soon  a time of interest: what is clearly later need not be known [s]
    """
    least = np.inf
    for i in range(1, x.size):
        acceleration = course[2, i] * course[1, i]
        speed = course[2, i] * (course[0, i] + 0.5 * acceleration * step_before)
        distance = (held[i] + 1.0 + grain[i] if speed > 0.0 else held[i] - grain[i]) - x[i]
        if abs(distance) < 2.0 * soon * abs(speed):
            s = distance / speed
            for _ in range(3):
                s = distance / (speed + 0.5 * acceleration * s)
            if s > 0.0:
                least = min(least, s)
    return least


def guess(lo, hi, before, after, held, grain):
    """The earliest place between `lo` and `hi` at which a line from `before` to `after` says that a floor changes."""
    found = hi
    for i in range(1, held.size):
        if has_left(after[i], held[i], grain[i]):
            share = (edge(after[i], held[i], grain[i]) - before[i]) / (after[i] - before[i])
            found = min(found, lo + (hi - lo) * min(1.0, max(0.0, share)))
    return found


def arc(course, i, before, x, floor, grain, step, step_before):
    """Where position `i` passes its boundary, as a share of the step, by its course before the step and its end."""
    way, goal = x - before, edge(x, floor, grain) - before
    speed = step * (course[0, i] + 0.5 * course[2, i] * course[1, i] * step_before) if course[2, i] > 0.0 else way
    root = np.sqrt(max(0.0, speed * speed + 4.0 * (way - speed) * goal))
    return 2.0 * goal / (speed + (root if goal > 0.0 else -root))


def secant(x_longer, x, floor, grain, longer):
    """The same by the end of the step and that of one `longer` times as long, both behind the boundary."""
    return 1.0 - (x - edge(x, floor, grain)) * (longer - 1.0) / (x_longer - x)


def lateness(before, x, held, grain, width, t, step, usual):
    """How far a step has gone behind its events, over what is allowed, and what is, as a share of the step.

    t      at the end of the step, whose rounding cannot be undercut [s]
    usual  the step that would be taken without events, of which `width` is a share [s]
    """
    least = 4.0 * HAIR * abs(t)
    worst, near = 0.0, 1.0
    for i in range(1, held.size):
        if has_left(x[i], held[i], grain[i]):
            allowed = max(width[i] * usual, least) / step
            worst = max(worst, (x[i] - edge(x[i], held[i], grain[i])) / (x[i] - before[i]) / allowed)
            near = min(near, allowed)
    return worst, near


def last_change(x, held, grain):
    """The number of the last mode or kink whose floor has changed, counted from the end."""
    found = 1
    for i in range(1, held.size):
        if has_left(x[i], held[i], grain[i]):
            found = i
    return found - held.size
