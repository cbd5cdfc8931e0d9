"""Simulated seconds per second on one core, and what one evaluation and one step take."""

from collections.abc import Callable
from dataclasses import replace
from statistics import median

from benchmarks.measure import interleaved, machine, report, spread
from vvdp.simulation.run import Run, simulate
from vvdp.systems.system import System, load_system

STIFF_OIL = ("oil.liquid_bulk_modulus=1e12 Pa", "oil.air_fraction=0")
CASES = {
    "prototype": ("prototype", (), "1 s"),
    "prototype-constant-load": ("prototype-constant-load", (), "1 s"),
    "prototype, stiff oil": ("prototype", STIFF_OIL, "0.1 s"),
}
TARGET = 20.0


def main() -> None:
    """Runs the cases in turns, as `vvdp run` would: with the automatic method and everything recorded."""
    print(machine())
    systems = {name: load_system(file, settings, until) for name, (file, settings, until) in CASES.items()}
    runs = {name: again(system) for name, system in systems.items()}
    last = {name: run() for name, run in runs.items()}  # compiled before the clock starts
    times = interleaved(runs)
    for name, found in times.items():
        run = last[name]
        speeds = [run.end / x for x in found]
        target = (f"{TARGET:g}", median(speeds) >= TARGET) if name in ("prototype", "prototype-constant-load") else ()
        report(f"{name}, simulated s per s", spread(speeds, "times"), *target)
        report(f"{name}, one evaluation, all included", spread(found, "ns", 1e9 / run.evaluations))
        method = "stiff" if run.stiff else "explicit"
        report(
            f"{name}, steps",
            f"{run.steps / run.end:.0f} attempted per simulated second, {run.rejected / run.steps:.0%} refused, "
            f"{run.steps / median(found):.3g} per second, {run.evaluations} evaluations, {method} at the end",
        )


def again(system: System) -> Callable[[], Run]:
    """A run of `system` at a relative tolerance of 1e-7."""
    stepping = replace(system.stepping, relative_tolerance=1e-7)
    return lambda: simulate(system.model, system.case, stepping)


if __name__ == "__main__":
    main()
