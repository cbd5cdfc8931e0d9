"""Maps of the prototype: 100 x 100 points by quasi-steady averages, 12 x 10 simulated to their periodic states."""

import os
import tempfile
import time
from functools import partial
from pathlib import Path
from statistics import median

# Numba can be asked for less than this later, not for more.
os.environ.setdefault("NUMBA_NUM_THREADS", "2")

import numpy as np

from benchmarks.measure import interleaved, machine, report, spread
from vvdp.rigs.maps import analytic_map, default_axes, simulated_map
from vvdp.rigs.stand import stand
from vvdp.studies.engine import ThisProcess
from vvdp.systems.system import load_system

ANALYTIC_TARGET, SIMULATED_TARGET = 1.0, 180.0
REPEATS = 7


def main() -> None:
    """Both maps, each with its code compiled before."""
    print(machine())
    held = stand(load_system("prototype"))
    large, axes = default_axes(held, 100, 100), default_axes(held, 12, 10)
    analytic_map(held, axes, cores=2)
    times = interleaved({f"{n} cores": partial(analytic_map, held, large, cores=n) for n in (1, 2)}, REPEATS)
    for name, found in times.items():
        met = median(found) < ANALYTIC_TARGET if name == "2 cores" else None
        report(f"analytic map, 100 x 100, {name}", spread(found, "s"), "1 s" if met is not None else "", met)
    for name in ("prototype-constant-load", "prototype"):
        rig = stand(load_system(name))
        with tempfile.TemporaryDirectory() as folder:
            simulated_map(rig, default_axes(rig, 2, 2), Path(folder) / "first", engine=ThisProcess(2))
            began, began_cpu = time.perf_counter(), time.process_time()
            done = simulated_map(rig, axes, Path(folder) / "map", engine=ThisProcess(2))
            seconds, cpu = time.perf_counter() - began, time.process_time() - began_cpu
        text = f"{seconds:.1f} s, {cpu:.1f} s of processor time"
        report(f"simulated map, 12 x 10, {name}", text, "180 s", seconds < SIMULATED_TARGET)
        unsolved = sum(reason is not None for reason in done.reasons)
        worst = np.nanmax(done.columns["periodic_residual"])
        report("", f"largest residual {worst:.1e}, {unsolved} points deliver nothing or have no state")


if __name__ == "__main__":
    main()
