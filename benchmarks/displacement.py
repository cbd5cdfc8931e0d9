"""What the whole machine costs beside the prototype: a run, an evaluation, a sample, compiling it; and chapter 6."""

import os
from collections.abc import Callable
from statistics import median

import numpy as np

from benchmarks.against_c import EVALUATIONS, evaluations
from benchmarks.measure import (
    ROUNDS,
    compiled,
    empty_caches,
    in_new_process,
    interleaved,
    ratios,
    report,
    run_as_command,
    spread,
)
from vvdp.generator.kinds import INT
from vvdp.simulation import loop
from vvdp.simulation.prepare import prepare
from vvdp.simulation.run import Run, simulate
from vvdp.systems.system import System, load_system

MACHINE, CHAPTER, PLAIN = "displacement-control", "displacement-chapter6", "prototype"
REAL_TIME_TARGET, CHAPTER_TARGET, SHARE_TARGET, EVALUATION_TARGET, COMPILE_TARGET = 25.0, 150.0, 0.4, 2.0, 2.2
STATES, CALLS = 1000, 1000
COMPILE = """
import time
from vvdp.simulation.run import simulate
from vvdp.systems.system import load_system
system = load_system("{name}", (), "0.01 s")
began = time.process_time()
simulate(system.model, system.case, system.stepping)
print('{{"seconds": ' + str(time.process_time() - began) + "}}")
"""


def samples(sample, which, rounds, y, u, m, p, c):  # type: ignore[no-untyped-def]
    """As many samples of a program as asked, a millisecond apart, at one state."""
    for i in range(rounds):
        sample(which, 5.0 + 1e-3 * i, y, u, m, p, c)


SAMPLES = (loop.SAMPLE, INT, INT, *[loop.VECTOR] * 5)


def main(short: bool) -> None:
    """Runs, evaluations and samples in turns; then compilations."""
    rounds = 2 if short else ROUNDS
    untils = {MACHINE: "12 s", CHAPTER: "16 s", PLAIN: "6 s"}  # so long that what a run takes before it starts is small
    machine, chapter, plain = (load_system(name, (), "0.05 s" if short else until) for name, until in untils.items())
    done = against_prototype({MACHINE: machine, CHAPTER: chapter, PLAIN: plain}, rounds)
    evaluating(machine, plain, done, rounds)
    sampling(machine, done[MACHINE], rounds)
    if not short:
        compiling(3)


def against_prototype(systems: dict[str, System], rounds: int) -> dict[str, Run]:
    """Simulated seconds per second of each; the last run of each is returned."""
    done: dict[str, list[Run]] = {name: [] for name in systems}
    runs = {name: _again(system, done[name]) for name, system in systems.items()}
    for warm in runs.values():
        warm()
    times = interleaved(runs, rounds)
    speeds = {name: [done[name][-1].end / x for x in taken] for name, taken in times.items()}
    for name, target in ((MACHINE, REAL_TIME_TARGET), (CHAPTER, CHAPTER_TARGET)):
        found = speeds[name]
        report(f"{name}, simulated s per s", spread(found, "times"), f"{target:g}", median(found) >= target)
    report(f"{PLAIN}, simulated s per s", spread(speeds[PLAIN], "times"), listed=True)
    shares = ratios(speeds, MACHINE, PLAIN)
    met = median(shares) >= SHARE_TARGET
    report(f"{MACHINE} over {PLAIN}, simulated s per s", spread(shares, "times"), f"{SHARE_TARGET:g}", met)
    for name in (MACHINE, CHAPTER, PLAIN):
        run = done[name][-1]
        report(
            f"{name}, steps",
            f"{run.steps / run.end:.0f} per simulated second, {run.rejected / run.steps:.0%} refused, "
            f"{run.evaluations / run.end:.0f} evaluations",
            listed=True,
        )
    return {name: found[-1] for name, found in done.items()}


def evaluating(machine: System, plain: System, done: dict[str, Run], rounds: int) -> None:
    """One right-hand side over the states of a run, of both."""
    variants: dict[str, Callable[[], object]] = {}
    evaluate = compiled(evaluations, EVALUATIONS)
    for name, system in ((MACHINE, machine), (PLAIN, plain)):
        run, ready = done[name], prepare(system.model, system.case, system.stepping)
        rows = np.linspace(len(run.states) // 2, len(run.states) - 1, STATES).astype(int)
        states, rate = np.ascontiguousarray(run.states[rows]), np.zeros(run.initial.size + ready.width.size)
        rate = rate[: run.initial.size + int(ready.plan[0, 5] - ready.plan[0, 4])]
        given = (ready.linked.rates, states, CALLS // 100, run.commands[-1].copy(), ready.vectors.params, rate)
        variants[name] = lambda given=given: evaluate(*given)  # type: ignore[misc]
    times = interleaved(variants, rounds)
    for name, taken in times.items():
        report(f"{name}, one evaluation", spread(taken, "ns", 1e9 / (STATES * (CALLS // 100))), listed=True)
    found = ratios(times, MACHINE, PLAIN)
    met = median(found) <= EVALUATION_TARGET
    report("evaluation, machine over prototype", spread(found, "times"), f"{EVALUATION_TARGET:g}", met)


def sampling(machine: System, run: Run, rounds: int) -> None:
    """A sample of each program of the machine."""
    for name, taken in sample_times(machine, run, rounds).items():
        report(f"a sample of the program {name}", spread(taken, "us", 1e6), listed=True)


def sample_times(system: System, run: Run, rounds: int) -> dict[str, list[float]]:
    """The time of a sample of each program of a system, as the compiled loop calls it at the end of a run [s]."""
    ready, sample = prepare(system.model, system.case, system.stepping), compiled(samples, SAMPLES)
    state, params, variants = run.states[-1].copy(), ready.vectors.params, dict[str, Callable[[], object]]()
    for which, name in enumerate(system.model.programs, 1):
        command, memory = run.commands[-1].copy(), run.memories[-1].copy()
        given = (ready.linked.sample, which, CALLS, state, command, memory, params, command.copy())
        variants[name] = lambda given=given: sample(*given)  # type: ignore[misc]
    return {name: [each / CALLS for each in taken] for name, taken in interleaved(variants, rounds).items()}


def compiling(rounds: int) -> None:
    """The first run of each, in a new process with an empty cache."""
    found = []
    for _ in range(rounds):
        seconds = []
        for name in (MACHINE, PLAIN):
            with empty_caches(os.environ) as environment:
                seconds.append(in_new_process(COMPILE.format(name=name), environment)["seconds"])
        found.append(seconds[0] / seconds[1])
    met = median(found) <= COMPILE_TARGET
    report("first compilation, machine over prototype", spread(found, "times"), f"{COMPILE_TARGET:g}", met)


def _again(system: System, done: list[Run]) -> Callable[[], None]:
    return lambda: done.append(simulate(system.model, system.case, system.stepping))


if __name__ == "__main__":
    run_as_command(main)
