"""What holding a duty ratio costs: a sample of the control, a run with it against one without, compiling it."""

import os
from collections.abc import Callable
from statistics import median

from benchmarks.displacement import sample_times
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

SAMPLE_TARGET, RATIO_TARGET, REAL_TIME_TARGET, COMPILE_TARGET = 3.0, 1.5, 30.0, 1.6
COMPILE = """
import time
from vvdp.simulation.run import simulate
from vvdp.systems.system import load_system
system = load_system("{name}", (), "0.01 s")
began = time.process_time()
simulate(system.model, system.case, system.stepping)
print('{{"seconds": ' + str(time.process_time() - began) + "}}")
"""


def main(short: bool) -> None:
    """Samples, runs and compilations, each beside what it is compared with."""
    rounds = 2 if short else ROUNDS
    controlled = load_system("vvdp-duty-control", (), "0.05 s" if short else "1 s")
    cost_per_sample(controlled, rounds)
    against_prototype(controlled, load_system("prototype", (), "0.05 s" if short else "1 s"), rounds)
    if not short:
        compiling(3)


def cost_per_sample(system: System, rounds: int) -> None:
    """All programs of the control: encoder, event filter, sensor, observer, reference and law."""
    run = simulate(system.model, system.case, system.stepping)
    taken = [sum(each) for each in zip(*sample_times(system, run, rounds).values(), strict=True)]
    met = median(taken) * 1e6 < SAMPLE_TARGET
    report("encoder, filter, observer, law: one sample", spread(taken, "us", 1e6), f"{SAMPLE_TARGET:g}", met)


def against_prototype(controlled: System, plain: System, rounds: int) -> None:
    """A simulated second of both."""
    done: dict[str, list[Run]] = {"duty control": [], "prototype": []}
    runs = {name: _again(system, done[name]) for name, system in zip(done, (controlled, plain), strict=True)}
    for warm in runs.values():
        warm()
    times = interleaved(runs, rounds)
    found = ratios(times, "duty control", "prototype")
    report("duty control over prototype", spread(found, "times"), f"{RATIO_TARGET:g}", median(found) <= RATIO_TARGET)
    speeds = [controlled.stepping.until / x for x in times["duty control"]]
    met = median(speeds) >= REAL_TIME_TARGET
    report("duty control, simulated s per s", spread(speeds, "times"), f"{REAL_TIME_TARGET:g}", met)


def compiling(rounds: int) -> None:
    """The first run of each, in a new process with an empty cache."""
    found = []
    for _ in range(rounds):
        seconds = []
        for name in ("vvdp-duty-control", "prototype"):
            with empty_caches(os.environ) as environment:
                seconds.append(in_new_process(COMPILE.format(name=name), environment)["seconds"])
        found.append(seconds[0] / seconds[1])
    met = median(found) <= COMPILE_TARGET
    report("first compilation, duty control over prototype", spread(found, "times"), f"{COMPILE_TARGET:g}", met)


def _again(system: System, done: list[Run]) -> Callable[[], None]:
    return lambda: done.append(simulate(system.model, system.case, system.stepping))


if __name__ == "__main__":
    run_as_command(main)
