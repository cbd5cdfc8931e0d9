"""The compiled loop against SciPy's LSODA with the same compiled right-hand side, at equal error.

LSODA is restarted at every sample, as the loop is, and judges the same states: the books' tolerance is so wide that
they take no part. Its relative tolerance is the loosest tried that reaches the loop's error at 1e-7. At the jump of the
ideal relief valve LSODA creeps, which says little about its speed elsewhere: the comparison is made with an override,
too.
"""

from collections.abc import Iterable
from dataclasses import replace
from functools import partial
from statistics import median

import numpy as np
from scipy.integrate import solve_ivp

from benchmarks.bare import bare_run
from benchmarks.measure import ROUNDS, interleaved, machine, ratios, report, spread
from vvdp.simulation import places
from vvdp.simulation.run import Prepared, prepared
from vvdp.simulation.values import leaves
from vvdp.systems.bench import RotaryBench
from vvdp.systems.system import System, load_system

CREEPING = 10.0**-6.5
OVERRIDE = "relief_valve.override_pressure=10 bar"
UNTIL = 0.2
TOLERANCE = 1e-7
TOLERANCES = tuple(10.0**-e for e in np.arange(7.0, 11.1, 0.25).tolist())
MEANS = (RotaryBench.LOAD_FLOW_TOTAL, RotaryBench.INLET_TOTAL, RotaryBench.LOAD_TOTAL)
TARGET = 20.0


def by_lsoda(ready: Prepared, tolerance: float) -> tuple[np.ndarray, int]:
    """Final state and number of evaluations."""
    rates, params = ready.linked.rates, ready.vectors.params
    y, command, memory = (part.copy() for part in ready.vectors[:3])
    out = np.zeros_like(y)
    bounded = np.arange(y.size) < ready.active
    rtol = np.where(ready.rtol > 0.0, tolerance, 1e-12)
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
        for which in range(ready.plan.shape[0]):
            ready.linked.sample(which, t_next, y, command, memory, params, command)
    return y, evaluations


def errors(system: System, final: np.ndarray, reference: np.ndarray) -> np.ndarray:
    """Relative errors of the means over the run, in the order of MEANS."""
    places = [path for path, _, _ in leaves(system.case.state)]
    rows = [places.index(path) for path in MEANS]
    return np.abs(final[rows] / reference[rows] - 1.0)


def compared(system: System, tolerances: Iterable[float], rounds: int) -> list[float]:
    """How many times faster the loop is than LSODA at the first of `tolerances` with which LSODA errs no more.

    At the last of them where none does.
    """
    ready, finer = (
        prepared(system.model, system.case, replace(system.stepping, relative_tolerance=tolerance))
        for tolerance in (TOLERANCE, 1e-11)
    )
    reference, _, _ = bare_run(finer, UNTIL)
    final, clock, _ = bare_run(ready, UNTIL)
    ours = errors(system, final, reference)
    report("vvdp at 1e-7, errors of means", f"{_shown(ours)}; {clock[places.EVALUATIONS]:.0f} evaluations")
    for tolerance in tolerances:
        final, evaluations = by_lsoda(ready, tolerance)
        found = errors(system, final, reference)
        report(f"LSODA at {tolerance:.1e}", f"{_shown(found)}; {evaluations} evaluations")
        if found.max() <= ours.max():
            break
    variants = {"vvdp": partial(bare_run, ready, UNTIL), "LSODA": partial(by_lsoda, ready, tolerance)}
    times = interleaved(variants, rounds)
    for name, seconds in times.items():
        report(f"{UNTIL:g} s, {name}", spread(seconds, "ms", 1e3))
    return ratios(times, "LSODA", "vvdp")


def main() -> None:
    """The prototype as shipped, and with a relief valve whose law has no jump."""
    print(machine())
    print(f"errors of the means of {', '.join(path.rpartition('.')[2] for path in MEANS)}, relative, to 1e-11")
    print(f"-- as shipped, ideal relief valve (LSODA creeps at its jump), one run at {CREEPING:.1e}")
    found = compared(load_system("prototype", until=f"{UNTIL} s"), [CREEPING], 1)
    report("as shipped, LSODA over vvdp", spread(found, "times"))
    print(f"-- {OVERRIDE}")
    found = compared(load_system("prototype", [OVERRIDE], until=f"{UNTIL} s"), TOLERANCES, ROUNDS)
    report("without the jump, LSODA over vvdp", spread(found, "times"), f"{TARGET:g}", median(found) >= TARGET)


def _shown(values: np.ndarray) -> str:
    return ", ".join(f"{x:.1e}" for x in values)


if __name__ == "__main__":
    main()
