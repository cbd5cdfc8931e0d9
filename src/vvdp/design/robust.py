"""Designs that lose little whatever parts, oil and duty turn out to be: an evolution by simulation alone.

Every design is simulated in every scenario, each an operating point with one draw of all tolerances and of the oil's
temperature, in lanes beside each other. The closed form only says where to begin.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.errors import ConfigError, Fault
from vvdp.base.kinds import TEMPERATURE
from vvdp.design.infeasibility import InfeasibleError
from vvdp.design.optimise import optimise
from vvdp.design.pareto import is_undominated
from vvdp.design.problem import Limit, Problem, cycle_points, problem, with_usual_limits
from vvdp.design.quantities import quantities, setup
from vvdp.design.solver import geometry_of, valve_of
from vvdp.design.spreads import Spread, spreads
from vvdp.design.variables import VARIABLES, design_settings, setting_text, with_variables
from vvdp.simulation.link import quiet
from vvdp.studies.engine import HERE, Engine
from vvdp.studies.run import run_study, silent
from vvdp.studies.study import Study
from vvdp.systems.system import System

OUTPUTS = ("loss_total_W", "pwm_frequency_Hz", "efficiency", "settled", "trusted")
"""Results that each simulation has to give."""
DUTY_RATIOS = ("0.4", "0.5", "0.6")
"""The duty cycle by default, equally long at each."""
SIZES = 6
"""Designs of least nominal loss, from small to large, that the evolution begins with."""
STEP, STRIDE = 0.06, 0.7
"""Of a child: scatter of the logarithms of its variables, and how far it goes along the difference of two others."""


@dataclass(frozen=True)
class Scenario:
    """Conditions of a design: its weight, values around the valve as text, and draws of scattered values [SI] by
    setting."""

    weight: float
    settings: Mapping[str, object]
    draws: Mapping[str, float]


@dataclass(frozen=True)
class Candidate:
    """A design [SI] with its size [m^3], and what the simulations say: means over the scenarios by weight, the largest
    loss [W], and why it cannot be on the front; empty where it can."""

    values: Mapping[str, float]
    size: float
    loss: float
    largest_loss: float
    pwm_frequency: float
    efficiency: float
    refusal: str

    @property
    def costs(self) -> tuple[float, float]:
        """Mean loss [W] and size [m^3]."""
        return self.loss, self.size


@dataclass(frozen=True)
class Robust:
    """Result of the search: the system before, the best design in closed form at the system's own operating point, all
    designs that were simulated, the scenarios, and whether it came to its end."""

    problem: Problem
    scenarios: tuple[Scenario, ...]
    taken: tuple[Spread, ...]
    before: Candidate
    nominal: Candidate
    candidates: tuple[Candidate, ...]
    runs: int
    finished: bool

    @property
    def front(self) -> tuple[Candidate, ...]:
        """The designs of which none other loses less and is no larger, by their mean loss."""
        fit = [each for each in (self.nominal, *self.candidates) if not each.refusal]
        if not fit:
            return ()
        best = is_undominated(np.array([each.costs for each in fit]))
        return tuple(sorted((each for each, kept in zip(fit, best, strict=True) if kept), key=lambda each: each.loss))

    @property
    def rejects(self) -> tuple[Candidate, ...]:
        """The designs that the simulation does not confirm."""
        return tuple(each for each in self.candidates if each.refusal)


@dataclass(frozen=True)
class Effort:
    """How many draws, designs in a generation and generations there are, and from which seed."""

    draws: int = 8
    designs: int = 10
    generations: int = 6
    seed: int = 1

    @property
    def most(self) -> int:
        """Designs at most."""
        return self.designs * self.generations + 2


def robust_problem(system: System, subject_to: Sequence[str] = (), bounds: Sequence[str] = ()) -> Problem:
    """Problem of the search: the usual variables and the lap ratio, with bounds and limits. Raises ConfigError with all
    faults."""
    lap = () if any(text.strip().startswith("lap_ratio") for text in bounds) else ("lap_ratio >= 0.4",)
    return with_usual_limits(problem(system, "loss_total", subject_to, (*bounds, *lap)), front=True)


def scenarios(
    asked: Problem, cycle: Path | None, temperatures: tuple[float, float], texts: Sequence[str], effort: Effort
) -> tuple[tuple[Scenario, ...], tuple[Spread, ...]]:
    """Every operating point with every draw, and what is drawn; Sobol's sequence spreads the draws evenly.

    temperatures  of the oil, coldest and hottest [K]

    A variable of the design keeps no range of the file, which says how little is known of the valve as it is, except
    its clearance, which is cut to the same tolerance. Raises ConfigError with all that is wrong.
    """
    from scipy.stats import qmc

    system, faults = asked.system, list[Fault]()
    points = [(1.0, {"operation.duty_ratio": d}) for d in DUTY_RATIOS]
    if cycle is not None:
        points = cycle_points(cycle, system, faults)
    if faults:
        raise ConfigError(faults)
    varied = {b.variable.setting for b in asked.bounds} - {CLEARANCE}
    taken = [each for each in spreads(system, texts) if each.setting not in {*varied, OIL_TEMPERATURE}]
    taken.append(_temperature(temperatures))
    total = sum(weight for weight, _ in points) * effort.draws
    rows = qmc.Sobol(len(taken), seed=effort.seed).random(effort.draws)
    draws = [{each.setting: float(each.quantile(x)) for each, x in zip(taken, row, strict=True)} for row in rows]
    found = [
        Scenario(weight / total, settings, {k: v for k, v in draw.items() if k not in settings})
        for weight, settings in points
        for draw in draws
    ]
    return tuple(found), tuple(taken)


CLEARANCE, OIL_TEMPERATURE = "valve.radial_clearance", "operation.oil_temperature"


def _temperature(ends: tuple[float, float]) -> Spread:
    return Spread(
        setting=OIL_TEMPERATURE,
        label="oil temperature",
        kind=TEMPERATURE,
        nominal=0.5 * sum(ends),
        low=ends[0],
        high=ends[1],
        status="given",
        source="",
        note="",
    )


class Runs(NamedTuple):
    """Where runs are kept and carried out, and what is informed of them: `progress` of runs, of all."""

    directory: Path
    engine: Engine = HERE
    progress: Callable[[int, int], None] = silent
    say: Callable[[str], None] = quiet


def robust(asked: Problem, met: Sequence[Scenario], taken: Sequence[Spread], effort: Effort, runs: Runs) -> Robust:
    """The search: designs of least nominal loss, small and large, then generations bred from those on the front.

    Runs that the directory already has are not run again. Ctrl-C ends the search after the current batches and keeps
    the designs until then; the same call goes on. Raises ConfigError where the directory cannot be used,
    KeyboardInterrupt where not even the first two designs came to their end.
    """
    trial = _Trials(asked, met, taken, effort, runs)
    rng = np.random.default_rng(effort.seed)
    known = trial.simulate([{}, _least(asked)])
    if len(known) < 2:
        raise KeyboardInterrupt
    before, nominal = known
    state = Robust(
        problem=asked,
        scenarios=tuple(met),
        taken=tuple(taken),
        before=before,
        nominal=_judge(nominal, before.pwm_frequency),
        candidates=(),
        runs=trial.runs,
        finished=True,
    )
    for number in range(effort.generations):
        parents = [dict(each.values) for each in state.front]
        designs = list(_seeds(asked))[: effort.designs] if number == 0 else []
        designs += _children(asked, parents or [asked.start], effort.designs - len(designs), rng)
        done = [_judge(each, before.pwm_frequency) for each in trial.simulate(designs)]
        finished = len(done) == len(designs)
        state = replace(state, candidates=(*state.candidates, *done), runs=trial.runs, finished=finished)
        if not finished:
            break
    return state


class _Trials:
    """Simulates designs in every scenario, in lanes; counts the runs that it has asked for and those carried out."""

    def __init__(
        self, asked: Problem, met: Sequence[Scenario], taken: Sequence[Spread], effort: Effort, kept: Runs
    ) -> None:
        self.asked, self.met, self.taken, self.kept = asked, met, {each.setting: each for each in taken}, kept
        self.all, self.wanted, self.runs = len(met) * effort.most, 0, 0

    def simulate(self, designs: Sequence[Mapping[str, float]]) -> list[Candidate]:
        """The designs as candidates, not yet judged; fewer where it was interrupted."""
        cases = [self.case(values, each) for values in designs for each in self.met]
        directory, engine, progress, say = self.kept
        results = run_study(
            Study(self.asked.system, cases, OUTPUTS),
            directory,
            engine=engine,
            progress=lambda done, _: progress(self.wanted + done, self.all),
            say=say,
        )
        self.runs += results.ran
        self.wanted += len(cases)
        count = len(self.met)
        whole = (min(results.missing) if results.missing else len(cases)) // count
        reasons = {failure.case: failure.reason for failure in results.failures}
        found = []
        for number in range(whole):
            rows = range(number * count, (number + 1) * count)
            columns = {name: np.asarray(results.outputs[name].values, float)[rows] for name in OUTPUTS}
            failure = next((reasons[row] for row in rows if row in reasons), "")
            found.append(self._candidate(designs[number], columns, failure))
        return found

    def case(self, values: Mapping[str, float], scenario: Scenario) -> dict[str, Any]:
        """The settings of a design in a scenario."""
        design = design_settings(self.asked.system, values)
        found = {setting: setting_text(value, kind) for setting, (value, kind) in design.items()}
        for setting, draw in scenario.draws.items():
            spread = self.taken[setting]
            value = draw
            if setting in design:
                made = design[setting][0]
                value = made + draw - spread.nominal if setting == CLEARANCE else made * draw / spread.nominal
            found[setting] = setting_text(value, spread.kind)
            if setting == "oil.viscosity_40":
                hot = next(row for row in self.asked.system.rows if row.setting == "oil.viscosity_100")
                found[hot.setting] = setting_text(hot.nominal * draw / spread.nominal, hot.kind)
        return found | dict(scenario.settings)

    def _candidate(self, values: Mapping[str, float], columns: Mapping[str, Array], failure: str) -> Candidate:
        weights = np.array([each.weight for each in self.met])
        mean = {name: float(np.sum(weights * columns[name])) for name in OUTPUTS}
        refusal = f"a run gives nothing: {failure}" if failure else ""
        if not refusal and not np.isfinite(mean["loss_total_W"]):
            refusal = "a run gives no mean: the spool hardly turns"
        for flag in ("settled", "trusted"):
            if not refusal and not np.all(columns[flag] == 1.0):
                refusal = f"a run is not {flag}"
        at = with_variables(self.asked.points[0].setup, values)
        return Candidate(
            values=dict(values),
            size=float(quantities(at).spool_volume),
            loss=mean["loss_total_W"],
            largest_loss=float(np.max(columns["loss_total_W"])),
            pwm_frequency=mean["pwm_frequency_Hz"],
            efficiency=mean["efficiency"],
            refusal=refusal,
        )


def _judge(each: Candidate, frequency: float) -> Candidate:
    """A candidate that is refused where it switches more slowly on the mean than the system as it is [Hz]."""
    if each.refusal or each.pwm_frequency >= frequency * (1.0 - 1e-6):
        return each
    return replace(each, refusal=f"switches at {each.pwm_frequency:.4g} Hz on the mean, below {frequency:.4g} Hz")


def _least(asked: Problem, *more: Limit) -> dict[str, float]:
    """The design of least nominal loss in closed form. Raises InfeasibleError where there is none."""
    question = replace(asked, limits=(*asked.limits, *more))
    return dict(optimise(question, starts=3, globally=False).values)


def _seeds(asked: Problem) -> Iterator[dict[str, float]]:
    """Designs of least nominal loss within sizes from half to twice that of the system as it is."""
    now = float(quantities(setup(asked.system)).spool_volume)
    for factor in np.geomspace(0.5, 2.0, SIZES):
        try:
            yield _least(asked, Limit("spool_volume", at_least=False, value=float(factor * now)))
        except InfeasibleError:
            continue


def _children(
    asked: Problem, parents: Sequence[Mapping[str, float]], count: int, rng: np.random.Generator
) -> list[dict[str, float]]:
    """Designs near the parents, each moved along the difference of two others and a little at random, that can be
    made."""
    names = [b.variable.name for b in asked.bounds]
    low, high = (np.log([getattr(b, end) for b in asked.bounds]) for end in ("low", "high"))
    x = np.log([[{**asked.start, **each}[name] for name in names] for each in parents])
    found: list[dict[str, float]] = []
    for _ in range(100 * max(count, 0)):
        if len(found) == count:
            break
        parent, one, other = x[rng.integers(len(x), size=3)]
        moved = parent + STRIDE * rng.uniform() * (one - other) + STEP * rng.standard_normal(len(names))
        values = {
            name: float(np.rint(v)) if VARIABLES[name].whole else float(v)
            for name, v in zip(names, np.exp(np.clip(moved, low, high)), strict=True)
        }
        if _can_be_made(asked, values):
            found.append(values)
    return found


def _can_be_made(asked: Problem, values: Mapping[str, float]) -> bool:
    """Whether nozzles and barriers fit, the clearance seals, and all is met that was asked for in closed form."""
    valve, found = valve_of(asked, values), asked.evaluate(values)
    given = replace(asked, objective="spool_volume", limits=tuple(each for each in asked.limits if not each.usual))
    excess = [each.excess(valve, found) for each in geometry_of(given)]
    excess += [each for limit in given.excesses(found) for each in limit]
    return all(float(each) <= 0.0 for each in excess)
