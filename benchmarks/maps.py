"""Maps of the prototype: 100 x 100 points by quasi-steady averages, a flow map, 12 x 10 simulated ones."""

import os
import random
import tempfile
import time
from dataclasses import replace
from functools import partial
from pathlib import Path
from statistics import median
from unittest.mock import patch

os.environ.setdefault("VVDP_THREADS", "2")

import numpy as np

from benchmarks.measure import interleaved, report, run_as_command, spread
from vvdp.rigs.map_axes import default_axes
from vvdp.rigs.maps import analytic_map, simulated_map
from vvdp.steady.averages import averages
from vvdp.steady.test_stand import stand
from vvdp.studies.engine import ThisProcess
from vvdp.systems.system import load_system

ANALYTIC_TARGET, TABLE_TARGET, SIMULATED_TARGET = 1.0, 1.0, 180.0
REPEATS = 7


def table(duties: int, loads: int, repeats: int) -> None:
    """Tells the processor time of a quasi-steady flow map, worked out, and read where it was worked out before."""
    held = stand(load_system("prototype"))
    points = [
        held.set_point._replace(duty_ratio=float(duty), load_pressure=float(load))
        for load in np.linspace(5e5, 119e5, loads)
        for duty in np.linspace(0.0, 1.0, duties)
    ]
    found: dict[str, list[float]] = {"worked out": [], "read": []}
    with tempfile.TemporaryDirectory() as folder, patch.dict(os.environ, VVDP_CACHE=folder):
        for number in range(-1, repeats):  # the first one compiles
            rows = np.array([held.cycle_point(each._replace(oil_temperature=310.0 + number)) for each in points])
            work = partial(averages, rows, held.bench.valve)
            for times in found.values():
                began = time.process_time()
                work(cores=1)
                times.append(time.process_time() - began)
    for name, times in found.items():
        target = ("1 s", min(times[1:]) < TABLE_TARGET) if name == "worked out" else ()
        report(f"flow map, {duties} x {loads}, {name}", spread(times[1:], "s"), *target, listed=True)


def main(short: bool) -> None:
    """The maps, each with its code compiled before."""
    held = stand(load_system("prototype"))
    size, repeats = (10, 1) if short else (100, REPEATS)
    large, axes = default_axes(held, size, size), default_axes(held, *((2, 1) if short else (12, 10)))
    analytic_map(held, axes, cores=2)

    def fresh(cores: int) -> None:
        """A map that is not kept yet: at a slightly different temperature."""
        other = replace(large, temperatures=(large.temperatures[0] + 1e-3 * random.random(),))
        analytic_map(held, other, cores=cores)

    times = interleaved({f"{n} cores": partial(fresh, n) for n in (1, 2)}, repeats, time.perf_counter)
    for name, found in times.items():
        target = ("1 s", median(found) < ANALYTIC_TARGET) if name == "2 cores" else ()
        report(f"analytic map, {size} x {size}, {name}", spread(found, "s"), *target, listed=True)
    table(*((5, 3, 1) if short else (81, 25, REPEATS)))
    for name in ("prototype-constant-load",) if short else ("prototype-constant-load", "prototype"):
        rig = stand(load_system(name))
        with tempfile.TemporaryDirectory() as folder:
            simulated_map(rig, default_axes(rig, 2, 2), Path(folder) / "first", engine=ThisProcess(2))
            began, began_cpu = time.perf_counter(), time.process_time()
            done = simulated_map(rig, axes, Path(folder) / "map", engine=ThisProcess(2))
            seconds, cpu = time.perf_counter() - began, time.process_time() - began_cpu
        text = f"{seconds:.1f} s, {cpu:.1f} s of processor time"
        report(
            f"simulated map, {len(axes.duty_ratios)} x {len(axes.load_pressures)}, {name}",
            text,
            "180 s",
            seconds < SIMULATED_TARGET,
        )
        unsolved = sum(reason is not None for reason in done.reasons)
        worst = np.nanmax(done.columns["periodic_residual"])
        report("", f"largest residual {worst:.1e}, {unsolved} points deliver nothing or have no state")


if __name__ == "__main__":
    run_as_command(main)
