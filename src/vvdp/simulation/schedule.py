"""When conditions and programs are called and when their commands act: the compiled part of the loop between steps.

y, u, m, p are the state, the command in force, the memory and the parameters, flat; they are changed in place.
"""

import numpy as np

from vvdp.simulation.places import (
    CALLS,
    DEPTH,
    DUE,
    FIRST,
    HAIR,
    HEAD,
    LAST,
    LATENCY,
    LEVEL,
    NUMBER,
    PERIOD,
    PHASE,
    SERVED,
    TRIGGER,
    WAITING,
)


def next_due(plan, agenda):
    """The next time at which a sample is to be taken or a waiting command to act; infinite where there is none."""
    found = np.inf
    for k in range(plan.shape[0]):
        if plan[k, TRIGGER] == 0.0:
            found = min(found, plan[k, PHASE] + agenda[k, NUMBER] * plan[k, PERIOD])
        if agenda[k, WAITING] > 0.0:
            found = min(found, agenda[k, DUE + int(agenda[k, HEAD])])
    return found


def landing_time(t_stop, t_due, t_end):
    """The time at which a step ends at the latest: the next jump, what is due next, or the end of the run.

    What is due a hair before a jump is served at the jump: a step between the two would be as short as the rounding.
    """
    t_next = t_due if t_due <= t_end + HAIR * abs(t_end) else t_end
    return t_stop if t_stop <= t_next + HAIR * abs(t_next) else t_next


def ask(sample, k, t, y, u, m, p, plan, agenda, waiting):
    """Calls program `k`; its command acts at once or waits. False where no more can wait."""
    if agenda[k, WAITING] >= DEPTH:
        return False
    slot = (int(agenda[k, HEAD]) + int(agenda[k, WAITING])) % DEPTH
    c = waiting[k, slot]
    sample(k, t, y, u, m, p, c)
    agenda[k, CALLS] += 1.0
    agenda[k, SERVED] = 1.0
    if plan[k, LATENCY] > 0.0:
        agenda[k, DUE + slot] = t + plan[k, LATENCY]
        agenda[k, WAITING] += 1.0
    else:
        for j in range(int(plan[k, FIRST]), int(plan[k, LAST])):
            u[j] = c[j]
    return True


def instant(sample, events, t, y, u, m, p, plan, agenda, waiting, g):
    """All that is due at `t`: conditions, commands that have waited, then the programs in order.

    `g` holds the events as they were reached, and is used up. A program goes where the floor of its trigger has
    changed, be it by another's command; at most once at an instant, and not for its own command. False as for `ask`.
    """
    latest, crossed = t + HAIR * abs(t), 0
    if plan[0, PHASE] + agenda[0, NUMBER] * plan[0, PERIOD] <= latest:
        sample(0, t, y, u, m, p, u)
        agenda[0, NUMBER] += 1.0
        agenda[0, CALLS] += 1.0
    for k in range(1, plan.shape[0]):
        agenda[k, SERVED] = 0.0
        while agenda[k, WAITING] > 0.0 and agenda[k, DUE + int(agenda[k, HEAD])] <= latest:
            c = waiting[k, int(agenda[k, HEAD])]
            for j in range(int(plan[k, FIRST]), int(plan[k, LAST])):
                u[j] = c[j]
            agenda[k, HEAD] = (agenda[k, HEAD] + 1.0) % DEPTH
            agenda[k, WAITING] -= 1.0
            agenda[k, SERVED] = 2.0
    for k in range(1, plan.shape[0]):
        if plan[k, TRIGGER] == 0.0:
            due = plan[k, PHASE] + agenda[k, NUMBER] * plan[k, PERIOD] <= latest
            agenda[k, NUMBER] += due
        else:
            due = np.floor(g[int(plan[k, TRIGGER])]) != agenda[k, LEVEL]
        if due and not ask(sample, k, t, y, u, m, p, plan, agenda, waiting):
            return False
    if g.size == 1:
        return True
    for _ in range(plan.shape[0]):
        events(t, y, u, p, g)
        crossed = 0
        for k in range(1, plan.shape[0]):
            trigger = int(plan[k, TRIGGER])
            if crossed == 0 and trigger > 0 and agenda[k, SERVED] == 0.0 and np.floor(g[trigger]) != agenda[k, LEVEL]:
                crossed = k
        if crossed == 0:
            break
        if not ask(sample, crossed, t, y, u, m, p, plan, agenda, waiting):
            return False
    for k in range(1, plan.shape[0]):
        if plan[k, TRIGGER] > 0.0:
            agenda[k, LEVEL] = np.floor(g[int(plan[k, TRIGGER])])
    return True


def begin(sample, events, t, y, u, m, p, plan, agenda, waiting, g):
    """The first instant of a run, at which no event can have happened yet. False as for `ask`."""
    events(t, y, u, p, g)
    for k in range(plan.shape[0]):
        if plan[k, TRIGGER] > 0.0:
            agenda[k, LEVEL] = np.floor(g[int(plan[k, TRIGGER])])
        else:
            agenda[k, NUMBER] = max(0.0, np.floor((t - plan[k, PHASE]) / plan[k, PERIOD]) - 1.0)
            while plan[k, PHASE] + agenda[k, NUMBER] * plan[k, PERIOD] < t - HAIR * abs(t):
                agenda[k, NUMBER] += 1.0
    return instant(sample, events, t, y, u, m, p, plan, agenda, waiting, g)
