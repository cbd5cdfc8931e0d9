"""A thousand parameter sets through one compiled call, on one and on two threads."""

import os
import time

# Numba can be asked for less than this later, not for more.
os.environ.setdefault("NUMBA_NUM_THREADS", "2")

from collections.abc import Iterator
from functools import partial
from statistics import median

import numpy as np

from benchmarks.measure import interleaved, machine, ratios, report, spread
from vvdp.base.signal import constant
from vvdp.simulation.batch import simulate_batch
from vvdp.simulation.model import Case
from vvdp.systems.bench import rotary_bench
from vvdp.systems.system import System, load_system

COUNT = 1000
TARGET = 1.7


def cases(system: System) -> Iterator[Case]:
    """Duty ratio and relief setting all over their range."""
    bench = rotary_bench(system, "batch")
    rng = np.random.default_rng(1)
    for duty, setting in zip(rng.uniform(0.2, 0.8, COUNT), rng.uniform(1.1e7, 1.4e7, COUNT), strict=True):
        operation, relief_valve = {"duty_ratio": constant(duty)}, {"cracking_pressure": float(setting)}
        yield bench.changed(operation=operation, relief_valve=relief_valve).case


def main() -> None:
    """Checks that the threads change nothing, then times."""
    print(machine())
    system = load_system("prototype", until="0.05 s")
    chosen = list(cases(system))
    batch = partial(simulate_batch, system.model, chosen, system.stepping, 0.0)
    one, two = batch(cores=1), batch(cores=2)
    assert not any(one.reasons) and np.array_equal(one.final, two.final)
    times = interleaved({"one thread": partial(batch, cores=1), "two threads": partial(batch, cores=2)})
    for name, found in times.items():
        report(f"{COUNT} cases of {system.stepping.until:g} s, {name}", spread(found, "s"))
    began, began_cpu = time.perf_counter(), time.process_time()
    batch(cores=2)
    got = (time.process_time() - began_cpu) / (time.perf_counter() - began)
    report("cores that two threads got", f"{got:.2f}, once; a busy machine gives fewer than 2")
    simulated = COUNT * system.stepping.until
    report("simulated s per s, two threads", spread([simulated / x for x in times["two threads"]], "times"))
    found = ratios(times, "one thread", "two threads")
    report("two threads, faster by", spread(found, "times"), f"{TARGET:g}", median(found) >= TARGET)


if __name__ == "__main__":
    main()
