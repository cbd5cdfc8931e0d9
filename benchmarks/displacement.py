"""What the whole machine costs: a run in closed loop and an evaluation of it against the prototype, compiling it."""

import os
from collections.abc import Callable
from statistics import median

from benchmarks.measure import (
    ROUNDS,
    empty_caches,
    in_new_process,
    interleaved,
    ratios,
    report,
    run_as_command,
    spread,
)
from vvdp.simulation.run import Run, simulate
from vvdp.systems.system import System, load_system

MACHINE, PROTOTYPE, CHAPTER = "displacement-control", "prototype", "displacement-chapter6"
EVALUATION_TARGET, SHARE_TARGET, REAL_TIME_TARGET, CHAPTER_TARGET, COMPILE_TARGET = 2.0, 0.4, 25.0, 150.0, 2.2
COMPILE = """
import time
from vvdp.simulation.run import simulate
from vvdp.systems.system import load_system
system = load_system("{name}", ["run.average_from=0 s"], "0.01 s")
began = time.process_time()
simulate(system.model, system.case, system.stepping)
print('{{"seconds": ' + str(time.process_time() - began) + "}}")
"""


def main(short: bool) -> None:
    """Runs and compilations, each beside what it is compared with."""
    until = "0.05 s" if short else "6 s"
    systems = {name: load_system(name, ["run.average_from=0 s"], until) for name in (MACHINE, PROTOTYPE, CHAPTER)}
    runs(systems, 2 if short else ROUNDS)
    if not short:
        compiling(3)


def runs(systems: dict[str, System], rounds: int) -> None:
    """All systems for as long, in turn."""
    done: dict[str, list[Run]] = {name: [] for name in systems}
    again = {name: _again(system, done[name]) for name, system in systems.items()}
    for warm in again.values():
        warm()
    times = interleaved(again, rounds)
    evaluations = {name: each[-1].evaluations for name, each in done.items()}
    each = {name: [taken / evaluations[name] for taken in times[name]] for name in systems}
    found = ratios(each, MACHINE, PROTOTYPE)
    met = median(found) <= EVALUATION_TARGET
    report(
        "an evaluation, controllers and all, over the prototype's",
        spread(found, "times"),
        f"{EVALUATION_TARGET:g}",
        met,
    )
    share = ratios(times, PROTOTYPE, MACHINE)
    report("speed, over the prototype's", spread(share, "times"), f"{SHARE_TARGET:g}", median(share) >= SHARE_TARGET)
    for name, target in ((MACHINE, REAL_TIME_TARGET), (CHAPTER, CHAPTER_TARGET)):
        speeds = [systems[name].stepping.until / taken for taken in times[name]]
        report(f"{name}, simulated s per s", spread(speeds, "times"), f"{target:g}", median(speeds) >= target)


def compiling(rounds: int) -> None:
    """The first run of each, in a new process with an empty cache."""
    found = []
    for _ in range(rounds):
        seconds = []
        for name in (MACHINE, PROTOTYPE):
            with empty_caches(os.environ) as environment:
                seconds.append(in_new_process(COMPILE.format(name=name), environment)["seconds"])
        found.append(seconds[0] / seconds[1])
    met = median(found) <= COMPILE_TARGET
    report("first compilation, machine over prototype", spread(found, "times"), f"{COMPILE_TARGET:g}", met)


def _again(system: System, done: list[Run]) -> Callable[[], None]:
    return lambda: done.append(simulate(system.model, system.case, system.stepping))


if __name__ == "__main__":
    run_as_command(main)
