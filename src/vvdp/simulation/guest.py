"""A model that another program integrates, compiled: its rates, its events, and what happens at them."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from vvdp.generator.kinds import FLOAT, Kind
from vvdp.simulation.landing import GRAIN, hold, positions, settle
from vvdp.simulation.loop import BENCH, CUBE, EVENT_LIST, MATRIX, RATES, SAMPLE, STOP, VECTOR
from vvdp.simulation.schedule import instant, landing_time, next_due

DERIVE = (RATES, FLOAT, FLOAT, VECTOR, VECTOR, VECTOR, VECTOR)


def derive(rates, t, t_next, y, command, params, rate):
    """Fills `rate` with the rates [per second] at a time: up to the next event those that hold before it."""
    rates(t if t < t_next else np.nextafter(t_next, -np.inf), y, command, params, rate)


INDICATE = (RATES, EVENT_LIST, FLOAT, FLOAT, VECTOR, VECTOR, VECTOR, MATRIX, MATRIX, BENCH, VECTOR)


def indicate(rates, events, t, t_next, y, command, params, plan, agenda, bench, found):
    """Fills `found` with two numbers for each trigger, mode and kink; one is negative where its floor has changed."""
    derive(rates, t, t_next, y, command, params, bench.rate)
    positions(events, t, y, command, params, bench.rate, bench.x)
    hold(plan, agenda, command, bench.held)
    for i in range(1, bench.x.size):
        found[2 * i - 2] = bench.x[i] - bench.held[i] + GRAIN
        found[2 * i - 1] = bench.held[i] + 1.0 + GRAIN - bench.x[i]


UPCOMING = (STOP, FLOAT, VECTOR, VECTOR, MATRIX, MATRIX)


def upcoming(stop, t, command, params, plan, agenda):
    """The time of the next event that is known after t [s], infinite where none is."""
    return landing_time(stop(t, command, params), next_due(plan, agenda), np.inf)


ENTER: tuple[Kind, ...] = (RATES, SAMPLE, EVENT_LIST, STOP, FLOAT, *[VECTOR] * 4, MATRIX, MATRIX, CUBE, BENCH)


def enter(rates, sample, events, stop, t, y, command, memory, params, plan, agenda, waiting, bench):
    """All that happens at an event; the time of the next one that is known [s], infinite where none is.

    NaN where too many commands of a program wait, or a mode changes without end.
    """
    derive(rates, t, t, y, command, params, bench.rate)
    positions(events, t, y, command, params, bench.rate, bench.g)
    if not instant(sample, events, t, y, command, memory, params, plan, agenda, waiting, bench.g):
        return np.nan
    if settle(rates, t, y, command, params, plan, bench.rate) >= 0:
        return np.nan
    return upcoming(stop, t, command, params, plan, agenda)


Entries = Mapping[str, tuple[Callable[..., Any], Sequence[Kind]]]
EVENTS: Entries = {"upcoming": (upcoming, UPCOMING)}
"""Functions for a host whose model is run by its own loop."""
ENTRIES: Entries = {
    **EVENTS,
    "derive": (derive, DERIVE),
    "indicate": (indicate, INDICATE),
    "enter": (enter, ENTER),
}
"""The functions for the host, with the types of their arguments."""
