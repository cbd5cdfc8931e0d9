"""How long a step is, compiled: aimed at events, shorter after a refusal, by PI control after an accepted one."""

import numpy as np

from vvdp.simulation.landing import time_left
from vvdp.simulation.places import (
    AIMED,
    DOUBT,
    ERROR_BEFORE,
    EVALUATIONS,
    EVENT_TIME,
    EVENTS,
    EXPLICIT,
    FASTEST,
    HASTY,
    JUMP_TIME,
    JUMPS,
    LANDED,
    METHOD,
    REFUSED,
    REJECTED,
    SIGNS,
    SPARED,
    STEP,
    STEP_BEFORE,
    STIFF,
    STIFF_FIRST,
    SWITCHES,
)

# A step that is to end on an event aims so far behind it, as a share of the step.
AIM = 5e-7

# So many refusals in a row, away from every landing: a kink takes three or four, a jump more.
SERIES = 5.0

# Events, each within this time [s] of the one before; the loops say how many are too many.
HASTE = 1e-9


# An explicit step is at the edge of its stability where step times fastest rate is `STABLE`. Twice beyond `STIFF_FROM`
# the stiff method takes over; below `EXPLICIT_BELOW`, for each of its evaluations over those of an explicit step, it
# hands back, but not within its first steps, in which its step has still to grow.
STABLE, STIFF_FROM, EXPLICIT_BELOW, FIRST_STEPS = 3.2, 2.2, 2.6, 3.0

MOST_DOUBT = 31.0  # about this many more signs of stiffness are asked for, at most

TINY = 1e-300  # a square that may stand below a fraction


def next_step(clock, course, before, held, grain):
    """The length of the next step, shorter where an event is near, and whether it is aimed at one."""
    h = clock[STEP]
    step, aimed = h, False
    if clock[AIMED] == 0.0:
        ahead = time_left(course, before, held, grain, clock[STEP_BEFORE], 2.0 * h)
        aimed = ahead <= h
        step = ahead * (1.0 + AIM) if aimed else 0.5 * ahead if ahead < 2.0 * h else h
    return step, aimed


def refuse(clock, step, size, finite, exponent):
    """Counts a refusal; the step to try next."""
    clock[REJECTED] += 1.0
    clock[REFUSED] += 1.0
    most = 0.5 if clock[REFUSED] > 1.0 else 1.0
    clock[STEP] = step * (max(0.2, min(most, 0.9 * size**exponent)) if finite else 0.1)
    return clock[STEP]


def grow(clock, size, step, h, exponent, cut, longest):
    """The step after an accepted one; `cut` says that something else than its error made that one short."""
    if clock[REFUSED] == 0.0:
        # size ** 0.7 / before ** 0.4, to the power `exponent`: with one power instead of two. Steady where the error
        # is 0.9 ** (1 / 0.06), a sixth of what is allowed. At 0.96 and half of it there are 5 % fewer steps, but means
        # move by up to 5e-5.
        e, before = size + 1e-12, clock[ERROR_BEFORE]
        cube, square = e * e * e, before * before
        most, growth = 5.0, 0.9 * (cube * cube * e / (square * square)) ** (0.1 * exponent)
        clock[ERROR_BEFORE] = max(size, 1e-4)
    else:  # it stands before a kink: growing at once would only have the next one refused
        most, growth = 1.0, 0.9 * (size + 1e-12) ** exponent
    grown = step * min(most, max(0.2, growth))
    return min(max(h, grown) if cut else grown, longest)


def note_jump(clock, t):
    """Counts a series of refusals that ends at `t`, where nothing says why."""
    if clock[REFUSED] >= SERIES and clock[LANDED] == 0.0:
        clock[JUMPS] += 1.0
        if clock[JUMPS] == 1.0:
            clock[JUMP_TIME] = t


def note_event(clock, t):
    """Counts an event, and those that follow in haste."""
    clock[EVENTS] += 1.0
    clock[HASTY] = clock[HASTY] + 1.0 if t - clock[EVENT_TIME] < HASTE else 0.0
    clock[EVENT_TIME] = t


def choose_method(clock, step, cut, heaviness, stiffness):
    """Hands over to the stiff method, or back, after an accepted step; `cut` as in `grow`.

    Each time the stiff method has taken more evaluations than explicit steps would have, it has to show more signs the
    next time, and fewer again where it has paid.

    heaviness  step times fastest rate at which the stiff method costs what the explicit one does
    stiffness  step times fastest rate, as the last two stages of an explicit step show it
    """
    if clock[METHOD] == STIFF:
        clock[SPARED] += 6.0 / STABLE * step * clock[FASTEST]  # six evaluations for each explicit step
        clock[SIGNS] += 1.0
        if step * clock[FASTEST] < heaviness and clock[SIGNS] > FIRST_STEPS and not cut:
            loses = clock[EVALUATIONS] - clock[STIFF_FIRST] > clock[SPARED]
            clock[DOUBT] = min(2.0 * clock[DOUBT] + 1.0, MOST_DOUBT) if loses else 0.5 * clock[DOUBT]
            clock[METHOD], clock[SIGNS] = EXPLICIT, 0.0
    elif not cut:
        clock[SIGNS] = clock[SIGNS] + 1.0 if stiffness > STIFF_FROM else 0.0
        if clock[SIGNS] >= 2.0 * (1.0 + clock[DOUBT]):
            clock[METHOD], clock[FASTEST], clock[SIGNS] = STIFF, np.inf, 0.0
            clock[STIFF_FIRST], clock[SPARED] = clock[EVALUATIONS], 0.0
            clock[SWITCHES] += 1.0
