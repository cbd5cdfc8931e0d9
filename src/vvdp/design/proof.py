"""Designs simulated beside the design as it was, and the closed forms held against that."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

from vvdp.base.display import MINUS, percent, with_unit
from vvdp.base.errors import ConfigError, Fault, RunError
from vvdp.base.kinds import FREQUENCY, MEAN_POWER, Kind
from vvdp.design.optimise import Optimum
from vvdp.design.problem import Problem, Side
from vvdp.design.variables import redesign
from vvdp.evaluation.bench import rotary_bench
from vvdp.evaluation.summary import simulated_summary, summary
from vvdp.geometry.shape_tables import given_shape
from vvdp.simulation.batch import simulate_batch
from vvdp.simulation.link import quiet
from vvdp.simulation.run import simulate
from vvdp.systems.resolved import resolved_text
from vvdp.systems.system import System

SIMULATED = (
    "pwm_frequency_Hz",
    "analytic_pwm_frequency_Hz",
    "loss_full_open_W",
    "loss_transition_W",
    "loss_valve_leakage_W",
    "loss_total_W",
    "analytic_loss_full_open_W",
    "analytic_loss_transition_W",
    "analytic_loss_leakage_W",
    "analytic_loss_compressibility_W",
    "analytic_loss_total_W",
    "mean_load_flow_m3_s",
    "analytic_load_flow_m3_s",
    "pressure_mean_load_line_Pa",
    "spool_motor_power_W",
    "efficiency",
    "settled",
    "trusted",
)

COUNTERPARTS: Mapping[str, str] = {
    "loss_total": "loss_total_W",
    "loss_full_open": "loss_full_open_W",
    "loss_transition": "loss_transition_W",
    "loss_leakage": "loss_valve_leakage_W",
    "pwm_frequency": "pwm_frequency_Hz",
    "efficiency": "efficiency",
    "load_flow": "mean_load_flow_m3_s",
}
"""The simulated value of a quantity in closed form."""
TOLERANCE = 0.1
"""By what part total loss and PWM frequency may differ between closed form and simulation before that is a doubt."""


@dataclass(frozen=True)
class Proof:
    """Results of simulation and closed forms for one design at one operating point; `failure` if a simulation
    failed."""

    design: str
    point: int
    found: Mapping[str, float | bool]
    failure: str = ""


def optimum_system(problem: Problem, values: Mapping[str, float], system: System | None = None) -> System:
    """The system (that of the problem, or as it stands at one of its points) with the optimum in it."""
    source = system or problem.system
    note = f"optimised: least {problem.objective}"
    if problem.limits:
        note += " subject to " + ", ".join(map(str, problem.limits))
    return redesign(source, values, note, f"{problem.system.title}, optimised")


def optimum_text(found: Optimum) -> str:
    """The optimum as a system file, under what it was asked for."""
    problem = found.problem
    asked = [
        f"The optimum of {problem.system.name}: least {problem.objective}",
        *(f"  subject to {limit}{' (usual limit)' if limit.usual else ''}" for limit in problem.limits),
        *(f"  within {Side(b, upper=False)} and {Side(b, upper=True)}" for b in problem.bounds),
    ]
    text = "".join(f"# {line}\n" for line in asked)
    return text + "\n" + resolved_text(optimum_system(problem, found.values))


def proofs(
    problem: Problem,
    values: Mapping[str, float],
    *,
    progress: Callable[[int, int], None] | None = None,
    say: Callable[[str], None] = quiet,
) -> list[Proof]:
    """A simulation of every operating point before and after; fewer where Ctrl-C ended them."""
    found: list[Proof] = []
    try:
        for number, point in enumerate(problem.points):
            for design, system in (("before", point.system), ("after", optimum_system(problem, values, point.system))):
                found.append(_proof(design, number, system, say))
                if progress:
                    progress(len(found), 2 * len(problem.points))
    except KeyboardInterrupt:
        pass
    return found


def _proof(design: str, number: int, system: System, say: Callable[[str], None]) -> Proof:
    try:
        run = simulate(system.model, system.case, system.stepping, say=say)
    except RunError as problem:
        return Proof(design, number, {}, str(problem))
    if not run.finished:
        raise KeyboardInterrupt
    whole = summary(system, run)
    return Proof(design, number, {key: whole[key] for key in SIMULATED if key in whole})


def doubts(problem: Problem, values: Mapping[str, float]) -> list[str]:
    """Doubts about the closed forms at the optimum, a sentence each; raises ConfigError where it cannot turn."""
    found: list[str] = []
    for point in problem.points:
        system = optimum_system(problem, values, point.system)
        at = rotary_bench(system, "design").unit.operating_point(point.setup.load_pressure)
        if not at.averaged_pwm_frequency > 0.0 and not point.setup.coupling > 0.0:
            message = f"no equilibrium speed: over a cycle the torques balance at {at.averaged_pwm_frequency:.4g} Hz"
            raise ConfigError([Fault(system.name, 0, "valve", message)])
        found += [text for text in at.warnings if text not in found]
    rated = rotary_bench(problem.system, "design").rated_power
    needed = max(q.input_power for q in problem.evaluate(values))
    if needed > rated:
        found.append(f"the pump takes in {needed:.4g} W, more than the {rated:.4g} W of its motor")
    return found + _unmade(problem, values)


def _unmade(problem: Problem, values: Mapping[str, float]) -> list[str]:
    """The obstacle to building the optimum as a solid with the usual lengths of its shape."""
    try:
        system = optimum_system(problem, values)
        given_shape(rotary_bench(system, "design").valve, None, (), system.lengths)
    except ConfigError as raised:
        lines = "; ".join(line for fault in raised.faults for line in fault.message.splitlines())
        told = "the usual lengths of the shape do not fit this valve, vvdp geometry needs others"
        return [f"{told} (--set geometry.KEY=VALUE): {lines}"]
    return []


def simulation_doubts(found: Optimum, proven: Sequence[Proof]) -> list[str]:
    """Where the simulation does not bear out an optimum, a sentence each, the worst first."""
    before = {each.point: each.found for each in proven if each.design == "before"}
    several, told = len(found.problem.points) > 1, []
    for each in proven:
        where = f" at point {each.point + 1}" if several else ""
        if each.failure:
            told.append(f"the simulation {each.design}{where} failed: {each.failure}")
        if each.failure or each.design == "before":
            continue
        loss = each.found["loss_total_W"]
        claimed, was = found.after[each.point].loss_total, found.before[each.point].loss_total
        simulated_before = before.get(each.point, {}).get("loss_total_W", loss)
        if loss > simulated_before and claimed < was:
            told.append(
                f"simulated{where}, the optimum loses {loss:.4g} W, more than the {simulated_before:.4g} W before; "
                f"analytically it loses less ({claimed:.4g} W against {was:.4g} W)"
            )
        told += [f"{text}{where}" for text in _apart("total loss", MEAN_POWER, loss, claimed)]
        if "analytic_pwm_frequency_Hz" in each.found:
            pair = each.found["pwm_frequency_Hz"], each.found["analytic_pwm_frequency_Hz"]
            told += [f"{text}{where}" for text in _apart("PWM frequency", FREQUENCY, *pair)]
        told += [f"{text}{where}" for text in _not_settled(each.found)]
    return told


def _apart(label: str, kind: Kind, simulated: float, analytic: float) -> list[str]:
    if abs(simulated - analytic) <= TOLERANCE * abs(analytic):
        return []
    apart = percent(simulated / analytic - 1.0)
    return [
        f"the {label} is {with_unit(simulated, kind)} simulated and {with_unit(analytic, kind)} analytic, "
        f"{apart if apart.startswith(MINUS) else f'+{apart}'}; more than {percent(TOLERANCE, 0)} is not to be relied on"
    ]


def _not_settled(found: Mapping[str, float | bool]) -> list[str]:
    told = []
    if not found["settled"]:
        told.append("the simulation has not settled: its means are still changing, a longer run.until may help")
    if not found.get("trusted", True):
        told.append("the simulation's balances of energy and mass do not close")
    return told


def simulated_means(problem: Problem, proven: Sequence[Proof]) -> tuple[str, float, float] | None:
    """A quantity, the objective where a simulation gives it and the total loss elsewhere, simulated before and after,
    as the weighted mean over the points; None where a point was not simulated."""
    quantity = problem.objective if problem.objective in COUNTERPARTS else "loss_total"
    by_key = {(each.design, each.point): each.found.get(COUNTERPARTS[quantity]) for each in proven}
    means = []
    for design in ("before", "after"):
        values = [by_key.get((design, number)) for number in range(len(problem.points))]
        if any(value is None for value in values):
            return None
        means.append(_mean(problem, [float(value) for value in values if value is not None]))
    return quantity, means[0], means[1]


def _mean(problem: Problem, values: Sequence[float]) -> float:
    total = sum(point.weight for point in problem.points)
    return sum(point.weight / total * value for point, value in zip(problem.points, values, strict=True))


class Simulated(NamedTuple):
    """Simulated results of one of many designs, weighted means over the points (NaN if one failed), and reasons to
    doubt them."""

    loss_total: float
    pwm_frequency: float
    efficiency: float
    settled: bool
    doubts: tuple[str, ...]


def simulated_designs(
    problem: Problem, designs: Sequence[Mapping[str, float]], *, say: Callable[[str], None] = quiet
) -> tuple[Simulated, ...]:
    """All `designs` simulated at every operating point, a batch for each point."""
    if not designs:
        return ()
    by_point: list[list[Mapping[str, object]]] = []
    for point in problem.points:
        systems = [optimum_system(problem, values, point.system) for values in designs]
        first = systems[0]
        run = simulate_batch(first.model, [each.case for each in systems], first.stepping, say=say)
        by_point.append(
            [
                {"failure": run.reasons[k] or "it turns too slowly for a mean"}
                if (outcome := run.outcome(k)) is None or not outcome.window.periods
                else simulated_summary(outcome, systems[k])
                for k in range(len(systems))
            ]
        )
    return tuple(_simulate(problem, values, [rows[k] for rows in by_point]) for k, values in enumerate(designs))


def _simulate(problem: Problem, values: Mapping[str, float], rows: Sequence[Mapping[str, Any]]) -> Simulated:
    told = [f"the simulation gives nothing: {row['failure']}" for row in rows if "failure" in row]
    if told:
        nan = float("nan")
        return Simulated(loss_total=nan, pwm_frequency=nan, efficiency=nan, settled=False, doubts=tuple(told))
    loss, frequency, efficiency = (
        _mean(problem, [float(row[key]) for row in rows]) for key in ("loss_total_W", "pwm_frequency_Hz", "efficiency")
    )
    told = _apart("total loss", MEAN_POWER, loss, float(problem.mean(problem.evaluate(values), "loss_total")))
    told += list(dict.fromkeys(text for row in rows for text in _not_settled(row)))
    return Simulated(
        loss_total=loss,
        pwm_frequency=frequency,
        efficiency=efficiency,
        settled=all(row["settled"] for row in rows),
        doubts=tuple(told),
    )
