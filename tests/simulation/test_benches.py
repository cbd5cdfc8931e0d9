"""The shipped benches in the compiled loop: against LSODA, both methods against each other, single runs and batches."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from vvdp.evaluation.bench_report import additions
from vvdp.evaluation.summary import simulated_summary, summary
from vvdp.simulation.balance import LIMIT, balance
from vvdp.simulation.batch import simulate_batch
from vvdp.simulation.prepare import free_rates, prepare
from vvdp.simulation.run import Method, simulate
from vvdp.simulation.values import leaves
from vvdp.systems.system import System, load_system

BENCHES = ("prototype", "prototype-constant-load")


def scales(system: System) -> np.ndarray:
    return np.array([kind.scale for _, _, kind in leaves(system.case.state)])


def by_scipy(system: System, tolerance: float) -> np.ndarray:
    """The final state by LSODA on the linked rates, begun anew at each sample, where the command may change."""
    case, stepping = system.case, system.stepping
    ready = prepare(system.model, case, stepping)
    y, u, m, p = (part.copy() for part in ready.vectors)
    rates = free_rates(ready, u)
    period = stepping.sample_period
    for k in range(round(stepping.until / period)):
        span = (k * period, (k + 1) * period)
        found = solve_ivp(rates, span, y, method="LSODA", rtol=tolerance, atol=tolerance * scales(system))
        assert found.success
        y = found.y[:, -1].copy()
        ready.linked.sample(0, span[1], y, u, m, p, u)
    return y


def distance(a: np.ndarray, b: np.ndarray, system: System) -> float:
    """Largest relative distance. What goes into tanks and what comes out of them have a kink wherever a flow turns
    round, and serve as a measure of throughput; only their difference is compared. The time for which a port cavitates
    grows by leaps within steps and is left out."""
    paths = [path for path, _, _ in leaves(system.case.state)]
    i, o = paths.index("books.taken_in"), paths.index("books.given_out")
    out = [i, o, *(place for place, path in enumerate(paths) if path.endswith("cavitating"))]
    a, b = (np.concatenate([np.delete(x, out), [x[i] - x[o]]]) for x in (a, b))
    scale = np.append(np.delete(scales(system), out), 1e-6)
    return float(np.max(np.abs(a - b) / np.abs(b).clip(scale)))


OVERRIDE = "relief_valve.override_pressure=10 bar"


@pytest.mark.parametrize("name", BENCHES)
def test_stiff_method_takes_few_steps_on_the_shipped_systems(name):
    """A wrong factorisation shows as refused steps by the million, not as a wrong answer: the error control sees."""
    system = load_system(name, [], until="0.05 s")
    run = simulate(system.model, system.case, replace(system.stepping, method=Method.STIFF))
    assert run.steps < 5000
    assert run.rejected < 0.3 * run.steps


@pytest.mark.parametrize("method", [Method.EXPLICIT, Method.STIFF])
@pytest.mark.parametrize("name", BENCHES)
def test_benches_agree_with_lsoda(name, method):
    """All states, books included, after 50 ms: about nine transitions of the ports.

    The relief valve has an override here, because LSODA cannot pass the jump of an ideal one. The rates have kinks,
    where a method of any order is of order one: a kink costs about the tolerance, amplified by the rate at which the
    inlet pressure runs (3e10 Pa/s, so 1e-10 of the pressure in a step of 1e-5 s weighs 1e-3 of it): with 1e-10 and some
    tens of kinks, 1e-7 at most. LSODA at 1e-11 lies below that.
    """
    system = load_system(name, [OVERRIDE], until="0.05 s")
    stepping = replace(system.stepping, relative_tolerance=1e-10, method=method)
    ours = simulate(system.model, system.case, stepping).final
    assert distance(ours, by_scipy(system, 1e-11), system) < 1e-7


@pytest.mark.parametrize("name", BENCHES)
def test_both_methods_agree_on_the_shipped_systems(name):
    """With the ideal relief valve, a jump in the rates; they differ by less at a finer tolerance."""
    system = load_system(name, [], until="0.05 s")

    def final(method, tolerance):
        stepping = replace(system.stepping, relative_tolerance=tolerance, method=method)
        return simulate(system.model, system.case, stepping).final

    reference = final(Method.STIFF, 1e-12)
    coarse, fine = (distance(final(Method.EXPLICIT, tol), reference, system) for tol in (1e-7, 1e-10))
    assert coarse < 1e-2
    assert fine < 1e-5


# Books


def balanced(name, settings=(), tolerance=1e-7):
    system = load_system(name, list(settings), until="0.1 s")
    return balance(simulate(system.model, system.case, replace(system.stepping, relative_tolerance=tolerance)))


@pytest.mark.parametrize("name", BENCHES)
def test_shipped_systems_balance(name):
    assert balanced(name).is_trusted


@pytest.mark.parametrize("name", BENCHES)
def test_residual_falls_with_the_tolerance(name):
    """It is the error of the run and nothing else: at 1e-10 what is left of it is small even against 1e-7."""
    books = balanced(name, tolerance=1e-10)
    assert abs(books.energy_residual) < 1e-9
    assert abs(books.mass_residual) < 1e-9


@pytest.mark.parametrize("name", BENCHES)
def test_coarse_run_is_not_trusted(name):
    assert not balanced(name, tolerance=1e-3).is_trusted


@pytest.mark.parametrize("name", BENCHES)
@pytest.mark.parametrize("pressure", ["5 bar", '{step=["0 bar","3 bar"],at="0.0203 s"}', "-0.2 bar"])
def test_books_balance_with_a_tank_that_is_not_at_the_reference_pressure(name, pressure):
    books = balanced(name, [f"operation.tank_pressure={pressure}"])
    assert abs(books.energy_residual) < LIMIT
    assert abs(books.mass_residual) < LIMIT


# Batches


def test_summaries_of_a_batch_are_those_of_single_runs():
    duties = ("0.35", "0.5", "0.8")
    systems = [load_system("prototype", [f"operation.duty_ratio={duty}"], until="0.2 s") for duty in duties]
    one = systems[0]
    run = simulate_batch(one.model, [s.case for s in systems], one.stepping, lanes=False)
    for row, system in enumerate(systems):
        alone = simulate(system.model, system.case, system.stepping)
        assert np.array_equal(run.final[row], alone.final)
        found = run.outcome(row)
        assert found is not None
        in_batch, single = simulated_summary(found, system), summary(system, alone)
        in_batch |= additions(system).closed_forms(in_batch)
        assert in_batch.keys() == single.keys()
        other = {k for k in single if in_batch[k] != single[k] and not np.isnan([in_batch[k], single[k]]).all()}
        assert other <= {"wall_time_s"}
