"""A thousand parameter sets through one compiled call: on one thread and on two, in lanes and one by one."""

import os
import time

os.environ.setdefault("VVDP_THREADS", "2")

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from statistics import median

import numpy as np

from benchmarks.measure import ROUNDS, interleaved, ratios, report, run_as_command, spread
from vvdp.base.signal import constant
from vvdp.evaluation.bench import rotary_bench
from vvdp.evaluation.unit_rig import unit_on_rig
from vvdp.simulation.batch import BatchRun, simulate_batch
from vvdp.simulation.crew import Crew
from vvdp.simulation.lane_code import host_width
from vvdp.simulation.model import Case
from vvdp.systems.system import System, load_system

COUNT = 1000
TARGET, AROUND_TARGET = 1.7, 0.15
LANES_TARGET = {8: 3.0, 4: 1.8}
"""Faster than one by one, by how many lanes the processor has."""


def cases(system: System, count: int) -> Iterator[Case]:
    """Duty ratio and relief setting all over their range."""
    bench = rotary_bench(system, "batch")
    rng = np.random.default_rng(1)
    for duty, setting in zip(rng.uniform(0.2, 0.8, count), rng.uniform(1.1e7, 1.4e7, count), strict=True):
        operation, relief_valve = {"duty_ratio": constant(duty)}, {"cracking_pressure": float(setting)}
        yield bench.with_tables(operation=operation, relief_valve=relief_valve).case


def around(system: System, chosen: list[Case], rounds: int) -> None:
    """Tells what Python takes around the loop for each case: the processor time of cases that end at once."""
    at_once = replace(system.stepping, until=1e-9, window=1e-9, record_interval=1e-9, window_interval=1e-9)
    batch = partial(simulate_batch, system.model, chosen, at_once, Crew(1))
    batch()
    per_case = [1e3 * x / len(chosen) for x in interleaved({"around": batch}, rounds)["around"]]
    report("Python around a case", spread(per_case, "ms"), f"{AROUND_TARGET:g} ms", min(per_case) < AROUND_TARGET)


def in_lanes(batch: Callable[..., BatchRun], count: int, rounds: int) -> None:
    """Tells how many cases a core gets through in a second, in lanes and one by one; by processor time."""
    assert all(batch(Crew(1)).lanes)
    variants = {"in lanes": partial(batch, Crew(1)), "one by one": partial(batch, Crew(1), lanes=False)}
    times = interleaved(variants, rounds)
    for name, found in times.items():
        report(f"cases per second and core, {name}", spread([count / x for x in found], "cases"))
    found, target = ratios(times, "one by one", "in lanes"), LANES_TARGET[host_width()]
    report(f"{host_width()} lanes, faster by", spread(found, "times"), f"{target:g}", median(found) >= target)


def main(short: bool) -> None:
    """Checks that the threads change nothing, then times; by the clock on the wall, which two threads share."""
    count = 20 if short else COUNT
    system = unit_on_rig(load_system("prototype", until="5 ms" if short else "0.05 s"), "batch")
    chosen = list(cases(system, count))
    batch = partial(simulate_batch, system.model, chosen, system.stepping)
    in_lanes(batch, count, 2 if short else ROUNDS)
    one, two = batch(Crew(1)), batch(Crew(2))
    assert not any(one.reasons) and np.array_equal(one.final, two.final)
    variants = {"one thread": partial(batch, Crew(1)), "two threads": partial(batch, Crew(2))}
    times = interleaved(variants, 2 if short else ROUNDS, time.perf_counter)
    for name, found in times.items():
        report(f"{count} cases of {system.stepping.until:g} s, {name}", spread(found, "s"))
    began, began_cpu = time.perf_counter(), time.process_time()
    batch(Crew(2))
    got = (time.process_time() - began_cpu) / (time.perf_counter() - began)
    report("cores that two threads got", f"{got:.2f}, once; a busy machine gives fewer than 2")
    simulated = count * system.stepping.until
    report(
        "simulated s per s, two threads", spread([simulated / x for x in times["two threads"]], "times"), listed=True
    )
    around(system, chosen, 1 if short else 5)
    found = ratios(times, "one thread", "two threads")
    report("two threads, faster by", spread(found, "times"), f"{TARGET:g}", median(found) >= TARGET)


if __name__ == "__main__":
    run_as_command(main)
