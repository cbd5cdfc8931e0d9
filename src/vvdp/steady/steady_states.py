"""Steady states of a test rig, many operating points at once: shooting, and for an orifice load the area that holds the
pressure."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from vvdp.base.signal import constant
from vvdp.evaluation.summary import Summary, simulated_summary
from vvdp.simulation.crew import Crew
from vvdp.simulation.link import quiet
from vvdp.steady.averages import averages, means_at
from vvdp.steady.cycle_means import CycleMeans
from vvdp.steady.shooting import Guess, Periodic, periodic_states
from vvdp.steady.test_stand import SetPoint, Stand, guessed_speed, load_area, standstill
from vvdp.valve.rotary import RotaryValve
from vvdp.valve.torque import pwm_frequency

HELD = 2e-4
"""Largest relative distance of the mean load pressure from its operating point; both above the tank's pressure."""
MOST_SIZINGS = 8
LARGEST_CHANGE = 3.0
"""Factor by which an orifice grows or shrinks from one sizing to the next."""


@dataclass(frozen=True)
class Steady:
    """A operating point and its periodic state, or why there is none. `area` is that of an orifice load, nan
    otherwise.
    """

    stand: Stand
    point: SetPoint
    periodic: Periodic | None
    area: float
    reason: str | None

    @property
    def summary(self) -> Summary:
        """Results of the state, as docs/keys.md has it; empty where there is none."""
        if self.periodic is None or self.periodic.outcome is None:
            return {}
        return simulated_summary(self.periodic.outcome, self.stand.at(self.point).own_system)


def steady_states(
    points: Sequence[tuple[Stand, SetPoint]],
    area: float | None = None,
    *,
    cores: int | None = None,
    say: Callable[[str], None] = quiet,
) -> list[Steady]:
    """The periodic state at every operating point, each on its own stand; all stands are of one circuit.

    An orifice load is sized, by a secant on the logarithms of area and pressure, until the mean load pressure is within
    `HELD` of its operating point. With an `area` [m^2] it has that, and the load pressure of the points is a guess.

    Source  ours, docs/models/periodic-states.md
    """
    found: dict[int, Steady] = {}
    open_: dict[int, _Sizing] = {}
    guesses = _guesses(points, cores, say)
    for number, (stand, point) in enumerate(points):
        first = _first_sizing(stand, point, guesses[number], area)
        if isinstance(first, str):
            found[number] = Steady(stand, point, None, np.nan, first)
        else:
            open_[number] = first
    for _ in range(MOST_SIZINGS):
        if not open_:
            break
        one = points[next(iter(open_))][0]
        runs = periodic_states(one.model, [each.guess for each in open_.values()], one.stepping, Crew(cores), say)
        for number, run in zip(list(open_), runs, strict=True):
            stand, point = points[number]
            sizing = open_.pop(number)
            if run.outcome is None:
                found[number] = Steady(stand, point, run, sizing.area, run.reason)
            elif not stand.makes_pressure or area or _is_held(run, stand, point):
                found[number] = Steady(stand, point, run, sizing.area, None)
            else:
                open_[number] = _resize_orifice(sizing, run, stand, point)
    for number, sizing in open_.items():
        reason = f"no orifice found that holds the load pressure in {MOST_SIZINGS} sizings"
        found[number] = Steady(*points[number], None, sizing.area, reason)
    return [found[number] for number in range(len(points))]


def _guesses(
    points: Sequence[tuple[Stand, SetPoint]], cores: int | None, say: Callable[[str], None]
) -> list[CycleMeans]:
    """The quasi-steady averages of every point; points of one valve go together."""
    by_valve: dict[RotaryValve, list[int]] = {}
    for number, (stand, _) in enumerate(points):
        by_valve.setdefault(stand.bench.valve, []).append(number)
    found: dict[int, CycleMeans] = {}
    for valve, numbers in by_valve.items():
        rows = np.array([points[number][0].cycle_point(points[number][1]) for number in numbers], float)
        means = averages(rows, valve, cores=cores, say=say)
        found |= {number: means_at(means, row) for row, number in enumerate(numbers)}
    return [found[number] for number in range(len(points))]


@dataclass(frozen=True)
class _Sizing:
    """A case with its orifice, and the areas and pressures of those before it, as logarithms."""

    guess: Guess
    area: float
    tried: list[tuple[float, float]]


def _first_sizing(stand: Stand, point: SetPoint, means: CycleMeans, area: float | None) -> "_Sizing | str":
    """Where the search at a operating point begins, or why there is nothing to search for."""
    opened = (area or load_area(point, means, stand)) if stand.makes_pressure else np.nan
    speed = guessed_speed(means, stand)
    if opened is None:
        return "delivers nothing that could hold this load pressure"
    if stuck := standstill(point, means, stand):
        return stuck
    if not speed > 0.0:
        return "the spool does not turn"
    case = stand.case(point, means, opened if stand.makes_pressure else None)
    return _Sizing(Guess(case, 1.0 / pwm_frequency(speed, stand.bench.valve)), opened, [])


def _above_tank(run: Periodic, stand: Stand, point: SetPoint) -> float:
    """Mean load pressure over its operating point, both above the tank's [1]."""
    assert run.outcome is not None
    mean = stand.bench.mean(run.outcome, stand.bench.LOAD_TOTAL)
    return (mean - stand.tank_pressure) / (point.load_pressure - stand.tank_pressure)


def _is_held(run: Periodic, stand: Stand, point: SetPoint) -> bool:
    return abs(_above_tank(run, stand, point) - 1.0) <= HELD


def _resize_orifice(sizing: _Sizing, run: Periodic, stand: Stand, point: SetPoint) -> _Sizing:
    """The next orifice: by the root law at first, then by the secant through the last two."""
    here = np.log(sizing.area), np.log(max(_above_tank(run, stand, point), 1e-3))
    slope = -2.0
    if sizing.tried:
        before = sizing.tried[-1]
        if abs(here[0] - before[0]) > 1e-9:
            slope = float(np.clip((here[1] - before[1]) / (here[0] - before[0]), -4.0, -0.02))
    change = float(np.clip(-here[1] / slope, -np.log(LARGEST_CHANGE), np.log(LARGEST_CHANGE)))
    area = float(np.exp(here[0] + change))
    case = stand.bench.with_load(run.case, constant(area), point.load_pressure)
    return _Sizing(Guess(case, run.period), area, [*sizing.tried, here])
