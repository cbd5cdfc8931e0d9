"""Simulated seconds per second of one core, and what one evaluation and one step take."""

from collections.abc import Callable
from statistics import median

from benchmarks.measure import ROUNDS, interleaved, report, run_as_command, spread
from vvdp.simulation.run import Run, simulate
from vvdp.systems.system import System, load_system

STIFF_OIL = ("oil.liquid_bulk_modulus=1e12 Pa", "oil.air_fraction=0")
CASES = {
    "prototype": ("prototype", (), "1 s"),
    "prototype-constant-load": ("prototype-constant-load", (), "1 s"),
    "prototype, stiff oil": ("prototype", STIFF_OIL, "0.1 s"),
}
TARGET = 20.0


def main(short: bool) -> None:
    """Runs the cases in turns, as `vvdp run` would: with the automatic method and everything recorded."""
    systems = {
        name: load_system(file, settings, "0.01 s" if short else until)
        for name, (file, settings, until) in CASES.items()
    }
    done: dict[str, list[Run]] = {name: [] for name in systems}
    runs = {name: again(system, done[name]) for name, system in systems.items()}
    for name, warm in runs.items():
        warm()  # compiled before the clock starts
        done[name].clear()
    times = interleaved(runs, 2 if short else ROUNDS)
    for name, found in times.items():
        run = done[name][-1]
        speeds = [run.end / x for x in found]
        target = (f"{TARGET:g}", median(speeds) >= TARGET) if name in ("prototype", "prototype-constant-load") else ()
        report(f"{name}, simulated s per s", spread(speeds, "times"), *target, listed=True)
        inside = [run.end / run.seconds for run in done[name]]
        report("   stepping alone", spread(inside, "times"))
        report(f"{name}, one evaluation, all included", spread(found, "ns", 1e9 / run.evaluations))
        method, attempted = "stiff" if run.stiff else "explicit", run.steps + run.rejected
        report(
            f"{name}, steps",
            f"{attempted / run.end:.0f} attempted per simulated second, {run.rejected / attempted:.0%} refused, "
            f"{attempted / median(found):.3g} per second, {run.evaluations} evaluations, {method} at the end",
        )


def again(system: System, done: list[Run]) -> Callable[[], None]:
    """A run of `system` at its tolerance, added to `done`."""
    stepping = system.stepping
    return lambda: done.append(simulate(system.model, system.case, stepping))


if __name__ == "__main__":
    run_as_command(main)
