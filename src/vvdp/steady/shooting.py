"""The periodic steady state of a switched circuit, found by shooting over one period instead of by waiting.

A self-spinning spool is periodic in its angle, not in time: the unknowns are the states at a mark (the spool's speed
among them), the equation is that they come back at the next mark, and the time between both is a result.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from vvdp.base.arrays import Array
from vvdp.base.kinds import TIME
from vvdp.base.rules import require_positive_value
from vvdp.simulation.batch import BatchRun, simulate_batch
from vvdp.simulation.crew import Crew
from vvdp.simulation.link import quiet
from vvdp.simulation.model import Case, Model
from vvdp.simulation.outcome import Outcome, Window
from vvdp.simulation.run import Stepping
from vvdp.simulation.values import as_value, flat, leaves

LIMIT = 1e-5
"""Largest relative change of a state over the period at which it counts as periodic, some times the noise of steps."""

DISTANCE = 3e-4
"""Largest relative distance from the periodic state, as the next Newton step shows it, at which it counts as found."""

PERTURBATION = 5e-3
"""Relative change of a state for the columns of the Jacobian: far above the noise of the stepping, 1e-6."""

TOLERANCE = 1e-8
"""Relative tolerance of the stepping; a looser one is tightened to it."""

SHRINK, GROW = 0.6, 1.5
"""Share of a state by which one step may lessen or add to it: pressures and speeds keep their sign."""

MOST_ROUNDS = 25
MARGIN = 1.25
"""Simulated time over the expected period."""

SOONEST = 1e-6
"""A mark before this share of the simulated time is the one at the start, passed again by a spool that turns back."""

MOST_PATIENCE = 6
"""How often the simulated time is doubled for a case whose mark does not come."""


@dataclass(frozen=True)
class Periodic:
    """The periodic steady state of one case, or why it has none.

    `residual` is the largest change of a state over the period, relative to its size, and `distance` how far the
    periodic state may still be, as the next Newton step shows it. Means over the period come from `outcome`.
    """

    case: Case
    outcome: Outcome | None
    residual: float
    distance: float
    period: float
    rounds: int
    reason: str | None


class Guess(NamedTuple):
    """Where the search for a periodic state begins: a case whose state stands at a mark, and the expected time between
    marks [s]."""

    case: Case
    period: float


class _Shot(NamedTuple):
    """One round for one case: what comes back at the next mark, and the Jacobian of it."""

    image: Array  # (unknowns,)
    jacobian: Array  # (unknowns, unknowns)
    outcome: Outcome


def periodic_states(
    model: Model,
    guesses: Sequence[Guess],
    stepping: Stepping,
    crew: Crew | None = None,
    say: Callable[[str], None] = quiet,
) -> list[Periodic]:
    """The periodic steady states that these guesses lead to, all at once on all cores.

    A Newton step needs one period for each unknown and one more; a step that leads into the impossible is halved.
    Raises ParameterError where the cases differ in shape or a period is not above zero.

    Once the `crew` (all cores, unless said) is stopped, the states found by then are kept, and the other cases have
    that as their reason.

    Source  ours, docs/models/periodic-states.md
    """
    for each in guesses:
        require_positive_value("period", each.period, TIME)
    unknown = _unknowns(guesses[0].case)
    scale = np.array([kind.scale if kind else 1.0 for _, _, kind in leaves(guesses[0].case.state)])[unknown]
    stepping = replace(stepping, relative_tolerance=min(stepping.relative_tolerance, TOLERANCE), average_from=None)

    def run(cases: Sequence[Case], until: float) -> BatchRun:
        return simulate_batch(model, cases, replace(stepping, until=until), crew or Crew(), say=say)

    runner = _Runner(run, unknown, scale)
    trials = [_Trial(case, flat(case.state)[unknown], period) for case, period in guesses]
    found: dict[int, Periodic] = {}
    missing = f"no periodic state after {MOST_ROUNDS} rounds"
    for rounds in range(1, MOST_ROUNDS + 1):
        pending = [number for number in range(len(trials)) if number not in found]
        if not pending:
            break
        shots = runner.shots(*zip(*(trials[number].begin for number in pending), strict=True))
        if shots is None:
            missing = f"stopped in round {rounds}, before the periodic state was found"
            break
        for number, shot in zip(pending, shots, strict=True):
            after = _after(trials[number], shot, scale, rounds)
            if isinstance(after, Periodic):
                found[number] = after
            else:
                trials[number] = after
    return [
        found.get(number) or _without_state(trial.case, trial.best, trial.period, MOST_ROUNDS, missing)
        for number, trial in enumerate(trials)
    ]


@dataclass(frozen=True)
class _Trial:
    """A case whose state is still looked for: where the next round begins, and the last step with its origin."""

    case: Case
    guess: Array
    period: float
    best: float = np.inf
    step: tuple[Array, Array] | None = None

    @property
    def begin(self) -> tuple[Case, Array, float]:
        """What a round needs."""
        return self.case, self.guess, self.period


def _after(trial: _Trial, shot: "_Shot | str", scale: Array, rounds: int) -> "_Trial | Periodic":
    """What a round leads to: the periodic state, a better guess, or half the last step where the round failed."""
    if isinstance(shot, str):
        if trial.step is None:
            return _without_state(trial.case, np.inf, np.nan, rounds, shot)
        origin, half = trial.step[0], 0.5 * trial.step[1]
        return replace(trial, guess=origin + half, step=(origin, half))
    guess = trial.guess
    size = scale + np.abs(guess)
    change = shot.image - guess
    delta = _newton_step(shot.jacobian, change, size)
    residual, distance = float(np.max(np.abs(change) / size)), float(np.max(np.abs(delta) / size))
    period = shot.outcome.window.end - shot.outcome.window.begin
    if residual <= LIMIT and distance <= DISTANCE:
        return Periodic(
            case=shot.outcome.case,
            outcome=shot.outcome,
            residual=residual,
            distance=distance,
            period=period,
            rounds=rounds,
            reason=None,
        )
    return replace(
        trial,
        guess=guess + np.clip(delta, -SHRINK * np.abs(guess), GROW * np.abs(guess) + scale),
        period=period,
        best=min(trial.best, residual),
        step=(guess, delta),
    )


def _without_state(case: Case, residual: float, period: float, rounds: int, reason: str) -> Periodic:
    return Periodic(
        case=case, outcome=None, residual=residual, distance=np.inf, period=period, rounds=rounds, reason=reason
    )


def _unknowns(case: Case) -> npt.NDArray[np.intp]:
    """Places of the states that must come back: all but the books and what grows indefinitely, an angle."""
    kinds = enumerate(leaves(case.state))
    return np.array(
        [i for i, (path, _, kind) in kinds if not path.startswith("books.") and not (kind and kind.accumulates)],
        np.intp,
    )


def _newton_step(jacobian: Array, change: Array, size: Array) -> Array:
    """The step to where the state comes back: (1 - J) step = change, in relative units.

    A state without dynamics of its own (a static valve) has J = 1 and no change: least squares leave it alone.
    """
    scaled = jacobian * size[None, :] / size[:, None]
    step, *_ = np.linalg.lstsq(np.eye(size.size) - scaled, change / size, rcond=1e-9)
    return np.asarray(step * size, float)


@dataclass(frozen=True)
class _Runner:
    """Runs cases over one period, each with its neighbours for the Jacobian."""

    run: Callable[[Sequence[Case], float], BatchRun]
    unknown: npt.NDArray[np.intp]
    scale: Array

    def shots(
        self, cases: Sequence[Case], guesses: Sequence[Array], periods: Sequence[float]
    ) -> list[_Shot | str] | None:
        """For each case its shot, or why there is none; None where they were stopped.

        Cases of alike periods run together.
        """
        found: list[_Shot | str] = [""] * len(cases)
        groups: dict[int, list[int]] = {}
        for i, period in enumerate(periods):
            groups.setdefault(int(np.floor(np.log(period) / np.log(1.5))), []).append(i)
        for members in groups.values():
            until, waiting = MARGIN * max(periods[i] for i in members), members
            for patience in range(MOST_PATIENCE + 1):
                part = self._together([cases[i] for i in waiting], [guesses[i] for i in waiting], until)
                if part is None:
                    return None
                late = []
                for i, shot in zip(waiting, part, strict=True):
                    if shot is None and patience < MOST_PATIENCE:
                        late.append(i)
                    else:
                        found[i] = f"no mark within {until:.3g} s: the spool does not turn" if shot is None else shot
                if not late:
                    break
                until, waiting = 2.0 * until, late
        return found

    def _together(
        self, cases: Sequence[Case], guesses: Sequence[Array], until: float
    ) -> list[_Shot | str | None] | None:
        n = self.unknown.size
        rows: list[Case] = []
        steps: list[Array] = []
        for case, guess in zip(cases, guesses, strict=True):
            state = flat(case.state)
            state[self.unknown] = guess
            delta = PERTURBATION * (np.abs(guess) + self.scale)
            steps.append(delta)
            for column in range(-1, n):
                shifted = state.copy()
                if column >= 0:
                    shifted[self.unknown[column]] += delta[column]
                rows.append(replace(case, state=as_value(case.state, shifted)))
        run = self.run(rows, until)
        if run.stopped:
            return None
        return [self._shoot(run, i * (n + 1), steps[i]) for i in range(len(cases))]

    def _shoot(self, run: BatchRun, row: int, delta: Array) -> _Shot | str | None:
        n = self.unknown.size
        reasons = [reason for reason in run.reasons[row : row + n + 1] if reason]
        if run.marks[row : row + n + 1].min() < 1 or not run.mark_times[row, 0] > SOONEST * run.stepping.until:
            return reasons[0] if reasons else None
        images = run.mark_states[row : row + n + 1, 0][:, self.unknown]
        reached, end = run.mark_states[row, 0], float(run.mark_times[row, 0])
        window = Window(begin=0.0, end=end, first=flat(run.cases[row].state), last=reached, periods=1, settled=True)
        # What the run passes after the mark, and what its programs remember then, is no part of the period.
        over = replace(run.outcome_over(row, window), final=reached, end=end, remarks=(), memory={})
        return _Shot(images[0], (images[1:] - images[0]).T / delta[None, :], over)
