"""The optimum simulated beside the design as it was, and the closed forms held against both."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from vvdp.base.errors import ConfigError, Fault, RunError
from vvdp.design.problem import Problem
from vvdp.design.variables import redesigned
from vvdp.simulation.link import quiet
from vvdp.simulation.run import simulate
from vvdp.systems.summary import analytic_point, summary
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
    "mean_load_pressure_Pa",
    "spool_motor_power_W",
    "efficiency",
    "settled",
    "trusted",
)


@dataclass(frozen=True)
class Proof:
    """What simulation and closed forms say of one design at one operating point; `failure` where a run broke off."""

    design: str
    point: int
    found: Mapping[str, Any]
    failure: str = ""


def optimum_system(problem: Problem, values: Mapping[str, float], system: System | None = None) -> System:
    """The system (that of the problem, or as it stands at one of its points) with the optimum in it."""
    source = system or problem.system
    note = f"optimised: least {problem.objective}"
    if problem.limits:
        note += " subject to " + ", ".join(map(str, problem.limits))
    return redesigned(source, values, note, f"{problem.system.title}, optimised")


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
    """What puts the closed forms in doubt at the optimum, a sentence each; raises ConfigError where it cannot turn."""
    found: list[str] = []
    for point in problem.points:
        system = optimum_system(problem, values, point.system)
        at = analytic_point(system, point.setup.load_pressure)
        if not at.averaged_pwm_frequency > 0.0 and not point.setup.coupling > 0.0:
            message = f"no equilibrium speed: over a cycle the torques balance at {at.averaged_pwm_frequency:.4g} Hz"
            raise ConfigError([Fault(system.name, 0, "valve", message)])
        found += [text for text in at.warnings if text not in found]
    return found
