"""The compiled loop against SciPy's LSODA with the same compiled right-hand side, at equal error.

LSODA is restarted at every sample, as the loop is, and judges the same states: the books' tolerance is so wide that
they take no part. Its relative tolerance is the loosest that reaches the loop's error at 1e-7.
"""

from dataclasses import replace
from functools import partial
from statistics import median

import numpy as np
from scipy.integrate import solve_ivp

from benchmarks.measure import interleaved, machine, ratios, report, spread
from vvdp.simulation.run import Method, Prepared, Run, prepared, simulate
from vvdp.simulation.values import leaves
from vvdp.systems.system import System, load_system

UNTIL = 0.2
TOLERANCE = 1e-7
TOLERANCES = 10.0 ** -np.arange(4.0, 11.1, 0.5)
MEANS = ("books.totals.load_flow", "books.totals.inlet_pressure", "books.totals.load_pressure")
TARGET = 20.0


def by_lsoda(ready: Prepared, tolerance: float) -> tuple[np.ndarray, int]:
    """Final state and number of evaluations."""
    rates, params = ready.linked.rates, ready.params
    y, command, memory, out = ready.state.copy(), ready.command.copy(), ready.memory.copy(), np.zeros_like(ready.state)
    bounded = np.arange(y.size) < ready.active
    rtol = np.where(bounded, ready.rtol / ready.rtol.max() * tolerance, 0.0)
    atol = np.where(bounded, tolerance * ready.scale, 1e12)
    evaluations = 0

    def f(t: float, x: np.ndarray) -> np.ndarray:
        rates(t, x, command, params, out)
        return out.copy()

    for sample in range(round(UNTIL / 1e-3)):
        t, t_next = sample * 1e-3, (sample + 1) * 1e-3
        found = solve_ivp(f, (t, t_next), y, "LSODA", rtol=rtol, atol=atol)
        assert found.success, found.message
        y = found.y[:, -1].copy()
        evaluations += found.nfev
        ready.linked.sample(t_next, memory, y, ready.settings, command)
    return y, evaluations


def by_vvdp(system: System, tolerance: float) -> Run:
    """The same by the compiled loop."""
    stepping = replace(system.stepping, relative_tolerance=tolerance, method=Method.EXPLICIT)
    return simulate(system.model, system.case, stepping)


def errors(system: System, final: np.ndarray, reference: np.ndarray) -> np.ndarray:
    """Relative errors of the means over the run, in the order of MEANS."""
    places = [path for path, _, _ in leaves(system.case.state)]
    rows = [places.index(path) for path in MEANS]
    return np.abs(final[rows] / reference[rows] - 1.0)


def main() -> None:
    """Finds the equal tolerance, then times."""
    print(machine())
    system = load_system("prototype", until=f"{UNTIL} s")
    ready = prepared(system.model, system.case, TOLERANCE)
    reference = by_vvdp(system, 1e-11).final
    ours = by_vvdp(system, TOLERANCE)
    wanted = errors(system, ours.final, reference).max()
    names = ", ".join(path.rpartition(".")[2] for path in MEANS)
    report(
        "vvdp at 1e-7",
        f"errors of mean {names}: {_shown(errors(system, ours.final, reference))}; {ours.evaluations} evaluations",
    )
    equal = None
    for tolerance in TOLERANCES:
        final, evaluations = by_lsoda(ready, float(tolerance))
        found = errors(system, final, reference)
        report(f"LSODA at {tolerance:.1e}", f"{_shown(found)}; {evaluations} evaluations")
        if found.max() <= wanted:
            equal = float(tolerance)
            break
    if equal is None:
        raise SystemExit("LSODA does not reach the error of the loop")
    times = interleaved({"vvdp": partial(by_vvdp, system, TOLERANCE), "LSODA": partial(by_lsoda, ready, equal)})
    for name, seconds in times.items():
        report(f"{UNTIL:g} s, {name}", spread(seconds, "s"))
    found = ratios(times, "LSODA", "vvdp")
    report("LSODA over vvdp, at equal error", spread(found, "times"), f"{TARGET:g}", median(found) >= TARGET)


def _shown(values: np.ndarray) -> str:
    return ", ".join(f"{x:.1e}" for x in values)


if __name__ == "__main__":
    main()
