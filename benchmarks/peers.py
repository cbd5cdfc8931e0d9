"""The compiled loop against solvers that others use, with the same compiled right-hand side: error against time.

Each peer is restarted at every sample, as the loop is, and judges the same states: the books' tolerance is so wide that
they take no part. The picture shows the largest error of the means against processor time, over tolerances, without a
jump in the rates (a relief valve with an override); most of what the peers need is Python around each evaluation, so
the evaluations are told as well. At the jump of the ideal relief valve LSODA creeps at some tolerances and not at
others: what is told of it is their share.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from benchmarks.bare import bare_run
from benchmarks.measure import HERE, report, run_as_command
from vvdp.evaluation.bench import RotaryBench
from vvdp.simulation import places
from vvdp.simulation.prepare import Prepared, free_rates, prepare
from vvdp.simulation.values import leaves
from vvdp.systems.system import System, load_system

OVERRIDE = "relief_valve.override_pressure=10 bar"
PICTURE = HERE / "work-precision.svg"
TARGET = 20.0
EQUAL = 1e-7
"""Error of the means at which the peers are compared."""
CONVERGED = 1e-12
SAMPLE = 1e-3
MOST = 400_000
"""Evaluations per simulated second beyond which a solver counts as creeping; without a jump it takes half of them."""
MEANS = (RotaryBench.LOAD_FLOW_TOTAL, RotaryBench.INLET_TOTAL, RotaryBench.LOAD_TOTAL)
Rates = Callable[[float, np.ndarray], np.ndarray]
Solver = Callable[[Rates, float, float, np.ndarray, np.ndarray, np.ndarray], np.ndarray]


class Creeps(Exception):
    """A solver has taken more evaluations than `MOST`."""


def by_scipy(method: str, f: Rates, begin: float, end: float, y: np.ndarray, rtol: Any, atol: Any) -> np.ndarray:
    """The state at the end of a sample by a method of SciPy, of which only LSODA takes a tolerance for each state."""
    found = solve_ivp(f, (begin, end), y, method, rtol=rtol if method == "LSODA" else float(rtol[0]), atol=atol)
    assert found.success, found.message
    return np.asarray(found.y[:, -1])


def by_cvode(method: str, f: Rates, begin: float, end: float, y: np.ndarray, rtol: Any, atol: Any) -> np.ndarray:
    """The state at the end of a sample by SUNDIALS."""
    from sksundae.cvode import CVODE

    def into(t: float, x: np.ndarray, out: np.ndarray) -> None:
        out[:] = f(t, x)

    solver = CVODE(into, rtol=float(rtol[0]), atol=atol, method=method, max_num_steps=MOST)
    found = solver.solve(np.array([begin, end]), y)
    assert found.success, found.message
    return np.asarray(found.y[-1])


def peers() -> dict[str, tuple[Solver, np.ndarray]]:
    """Solvers by name, and the tolerances at which each is tried."""
    found: dict[str, tuple[Solver, np.ndarray]] = {
        "LSODA": (partial(by_scipy, "LSODA"), 10.0 ** -np.arange(5.0, 10.6, 1.0)),
        "Radau": (partial(by_scipy, "Radau"), 10.0 ** -np.arange(4.0, 7.1, 1.0)),
    }
    try:
        import sksundae
    except ImportError:
        report("CVODE", "not measured: scikit-sundae is not installed (pip install vvdp[bench])", listed=True)
        return found
    report("CVODE", f"scikit-sundae {sksundae.__version__}", listed=True)
    for method in ("BDF", "Adams"):
        found[f"CVODE {method}"] = (partial(by_cvode, method), 10.0 ** -np.arange(5.0, 10.6, 1.0))
    return found


@dataclass(frozen=True)
class Point:
    """A run: its tolerance, the largest relative error of the means, processor time [s], evaluations."""

    tolerance: float
    error: float
    seconds: float
    evaluations: int


def by_peer(
    ready: Prepared, solver: Solver, tolerance: float, until: float, most: float = np.inf
) -> tuple[np.ndarray, int]:
    """Final state and number of evaluations. Raises Creeps after `most` of these."""
    y, command, memory = (part.copy() for part in ready.vectors[:3])
    rates, params, evaluations = free_rates(ready, command), ready.vectors.params, 0
    bounded = np.arange(y.size) < ready.pattern.group.size
    rtol = np.where(ready.rtol > 0.0, tolerance, 1e-12)
    atol = np.where(bounded, tolerance * ready.scale, 1e12)

    def f(t: float, x: np.ndarray) -> np.ndarray:
        nonlocal evaluations
        evaluations += 1
        if evaluations > most:
            raise Creeps
        return rates(t, x)

    for sample in range(round(until / SAMPLE)):
        t, t_next = sample * SAMPLE, (sample + 1) * SAMPLE
        y = solver(f, t, t_next, y, rtol, atol).copy()
        for which in range(ready.plan.shape[0]):
            ready.linked.sample(which, t_next, y, command, memory, params, command)
    return y, evaluations


def ready_at(system: System, tolerance: float) -> Prepared:
    """The system as the loop takes it."""
    return prepare(system.model, system.case, replace(system.stepping, relative_tolerance=tolerance))


def error(system: System, final: np.ndarray, reference: np.ndarray) -> float:
    """Largest relative error of the means over the run."""
    paths = [path for path, _, _ in leaves(system.case.state)]
    rows = [paths.index(path) for path in MEANS]
    return float(np.max(np.abs(final[rows] / reference[rows] - 1.0)))


def least(call: Callable[[], Any], rounds: int) -> tuple[Any, float]:
    """What `call` gives, and the least processor time of some calls [s]."""
    found, seconds = None, np.inf
    for _ in range(rounds):
        began = time.process_time()
        found = call()
        seconds = min(seconds, time.process_time() - began)
    return found, seconds


def curves(system: System, until: float, short: bool) -> dict[str, list[Point]]:
    """The points of every solver, vvdp's first, over its tolerances."""
    reference, _, _ = bare_run(ready_at(system, CONVERGED), until)
    found: dict[str, list[Point]] = {"vvdp": []}
    for tolerance in 10.0 ** -np.arange(4.0, 5.1 if short else 10.6, 1.0):
        ready = ready_at(system, tolerance)
        (final, clock, _), seconds = least(partial(bare_run, ready, until), 1 if short else 15)
        evaluations = int(clock[places.EVALUATIONS])
        found["vvdp"].append(Point(tolerance, error(system, final, reference), seconds, evaluations))
    ready = ready_at(system, 1e-7)
    for name, (solver, tolerances) in peers().items():
        found[name] = []
        for tolerance in tolerances[:1] if short else tolerances:
            call = partial(by_peer, ready, solver, tolerance, until)
            (final, evaluations), seconds = least(call, 1 if short else 3)
            found[name].append(Point(tolerance, error(system, final, reference), seconds, evaluations))
    return found


def at_error(points: list[Point], wanted: float) -> float:
    """Processor time at which a solver errs as much as `wanted`, on a line between its points in logarithms; or NaN."""
    errors, seconds = zip(*sorted((p.error, p.seconds) for p in points if p.error > 0.0), strict=True)
    if not errors[0] <= wanted <= errors[-1]:
        return float("nan")
    return float(np.exp(np.interp(np.log(wanted), np.log(errors), np.log(seconds))))


def creeping(until: float, count: int) -> None:
    """Tells at how many tolerances LSODA creeps at the jump of the ideal relief valve."""
    ready, tolerances = ready_at(load_system("prototype", until=f"{until} s"), 1e-7), np.geomspace(1e-5, 1e-9, count)
    caught = 0
    for tolerance in tolerances:
        try:
            by_peer(ready, partial(by_scipy, "LSODA"), float(tolerance), until, MOST * until)
        except Creeps:
            caught += 1
    text = f"at {caught} of {count} tolerances from 1e-5 to 1e-9 it needs over {MOST * until:g} evaluations"
    report(f"LSODA, {until:g} s, ideal relief valve", text, listed=True)


def draw(found: dict[str, list[Point]], until: float, path: Path) -> None:
    """The work-precision diagram."""
    import matplotlib as mpl

    mpl.use("Agg")
    mpl.rcParams["svg.hashsalt"] = "vvdp"
    from matplotlib import pyplot as plt

    figure, axes = plt.subplots(figsize=(6.4, 4.4), layout="constrained")
    for (name, points), marker in zip(found.items(), "os^vDx", strict=False):
        axes.loglog([p.seconds * 1e3 for p in points], [p.error for p in points], marker=marker, label=name)
    axes.set_xlabel(f"processor time for {until:g} s [ms]")
    axes.set_ylabel("largest relative error of the means")
    axes.set_title("prototype with 10 bar of override, a point for every tolerance")
    axes.grid(which="major", alpha=0.3)
    axes.legend()
    figure.savefig(path, metadata={"Date": None})
    plt.close(figure)


def main(short: bool) -> None:
    """Error of means against processor time, vvdp and its peers."""
    until = 0.003 if short else 0.05
    found = curves(load_system("prototype", [OVERRIDE], until=f"{until} s"), until, short)
    for name, points in found.items():
        for p in points:
            text = f"error {p.error:.1e}, {1e3 * p.seconds:.3g} ms, {p.evaluations} evaluations"
            report(f"{name} at {p.tolerance:.0e}", text)
    if short:
        creeping(0.002, 2)
        return
    own = at_error(found["vvdp"], EQUAL)
    for name, points in found.items():
        ratio = at_error(points, EQUAL) / own
        if name != "vvdp":
            target = (f"{TARGET:g}", ratio >= TARGET) if name == "LSODA" else ()
            report(f"{name} over vvdp at an error of {EQUAL:.0e}", f"{ratio:.3g} times", *target, listed=True)
    creeping(0.1, 17)
    draw(found, until, PICTURE)
    print(f"picture: {PICTURE.name}")


if __name__ == "__main__":
    run_as_command(main)
