"""The compiled loop against SciPy's solvers, and its two methods against each other."""

from dataclasses import replace
from typing import Annotated, NamedTuple

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from vvdp.base.books import Nothing
from vvdp.base.kinds import Kind, Ratio
from vvdp.base.params import Params
from vvdp.simulation.link import link
from vvdp.simulation.model import Case, Model
from vvdp.simulation.run import Method, Stepping, simulate
from vvdp.simulation.values import flat, leaves
from vvdp.systems.system import System, load_system, shipped

Plain = Annotated[float, Kind("plain number", "1", -1e9, 1e9, "1")]


class Robertson(NamedTuple):
    a: Plain
    b: Plain
    c: Plain


class Oscillation(NamedTuple):
    x: Plain
    v: Plain


class Damping(Params):
    mu: Ratio


def robertson(t: float, s: Robertson, u: Nothing, p: Nothing) -> tuple[Robertson, Nothing]:
    slow, fast, quick = 0.04 * s.a, 1e4 * s.b * s.c, 3e7 * s.b * s.b
    return Robertson(-slow + fast, slow - fast - quick, quick), Nothing(0.0)


def van_der_pol(t: float, s: Oscillation, u: Nothing, p: Damping) -> tuple[Oscillation, Nothing]:
    return Oscillation(s.v, p.mu * ((1.0 - s.x * s.x) * s.v - s.x)), Nothing(0.0)


def test_stiff_reaction_agrees_with_radau_and_switches_method():
    """Robertson's three reactions until 40 s. Both solvers keep local errors below 1e-8 and 1e-10; the problem damps
    them, so they end within some tens of tolerances of each other."""
    case = Case(Robertson(1.0, 0.0, 0.0), Nothing())
    stepping = Stepping(
        until=40.0, relative_tolerance=1e-8, sample_period=1.0, record_interval=1.0, window_interval=1.0
    )
    run = simulate(Model(robertson), case, stepping)
    assert run.stiff
    assert run.evaluations < 1e5  # explicit: 40 s times 2e3 1/s over a stability limit of 3, times 6

    def rates(t, y):
        return flat(robertson(t, Robertson(*y), Nothing(), Nothing())[0])

    peer = solve_ivp(rates, (0.0, 40.0), [1.0, 0.0, 0.0], method="Radau", rtol=1e-10, atol=1e-14)
    assert run.final == pytest.approx(peer.y[:, -1], abs=1e-6, rel=0.0)
    assert run.final.sum() == pytest.approx(1.0, abs=1e-9)


def test_relaxation_oscillation_agrees_with_radau_and_switches_method():
    """Van der Pol with mu = 1e6 in slow time: a creep along x - x^3/3 that ends in a jump at about 0.807 s.

    The jump shifts by the accumulated error; before it (0.5 s) the curve forgets errors.
    """
    case = Case(Oscillation(2.0, 0.0), Damping(mu=1e6))
    stepping = Stepping(until=0.5, relative_tolerance=1e-8, sample_period=0.1, record_interval=0.1, window_interval=0.1)
    run = simulate(Model(van_der_pol), case, stepping)
    assert run.stiff

    def rates(t, y):
        return flat(van_der_pol(t, Oscillation(*y), Nothing(), Damping(mu=1e6))[0])

    peer = solve_ivp(rates, (0.0, 0.5), [2.0, 0.0], method="Radau", rtol=1e-10, atol=1e-12)
    assert run.final == pytest.approx(peer.y[:, -1], abs=1e-6)


def scales(system: System) -> np.ndarray:
    return np.array([kind.scale for _, _, kind in leaves(system.case.state)])


def by_scipy(system: System, tolerance: float) -> np.ndarray:
    """The final state by LSODA on the linked rates, begun anew at each sample, where the command may change."""
    linked = link(system.model, system.case)
    case, stepping = system.case, system.stepping
    y, u, m, p, z = (flat(part) for part in (case.state, case.command, case.memory, case.params, case.settings))

    def rates(t, y):
        dy = np.zeros_like(y)
        linked.rates(t, np.ascontiguousarray(y), u, p, dy)
        return dy

    period = stepping.sample_period
    for k in range(round(stepping.until / period)):
        span = (k * period, (k + 1) * period)
        found = solve_ivp(rates, span, y, method="LSODA", rtol=tolerance, atol=tolerance * scales(system))
        assert found.success
        y = found.y[:, -1].copy()
        linked.sample(span[1], m, y, z, u)
    return y


def distance(a: np.ndarray, b: np.ndarray, system: System) -> float:
    return float(np.max(np.abs(a - b) / np.abs(b).clip(scales(system))))


OVERRIDE = "relief_valve.override_pressure=10 bar"


class Chain(NamedTuple):
    a: Plain
    b: Plain
    c: Plain
    d: Plain


def chain(t: float, s: Chain, u: Nothing, p: Nothing) -> tuple[Chain, Nothing]:
    """Slow, but each drives the next a thousandfold: beside that, the diagonal of the matrix that a stiff step
    factorises is small, so rows are exchanged in more than one column."""
    K = 1e3
    return Chain(-s.a + K * s.d, K * s.a - 2.0 * s.b, K * s.a + K * s.b - 3.0 * s.c, -4.0 * s.d), Nothing(0.0)


def test_stiff_method_solves_what_needs_exchanged_rows():
    """Against the matrix exponential. A wrong solution would be refused step after step."""
    matrix = np.array([flat(chain(0.0, Chain(*row), Nothing(), Nothing())[0]) for row in np.eye(4)]).T
    start = np.array([1.0, -1.0, 0.5, 2.0])
    stepping = Stepping(
        until=1.0,
        relative_tolerance=1e-6,
        sample_period=1.0,
        record_interval=1.0,
        window_interval=1.0,
        method=Method.STIFF,
    )
    run = simulate(Model(chain), Case(Chain(*start), Nothing()), stepping)
    assert run.final == pytest.approx(expm(matrix) @ start, rel=1e-5)
    assert run.steps < 100


@pytest.mark.parametrize("name", shipped())
def test_stiff_method_takes_few_steps_on_the_shipped_systems(name):
    """A wrong factorisation shows as refused steps by the million, not as a wrong answer: the error control sees."""
    system = load_system(name, [], until="0.05 s")
    run = simulate(system.model, system.case, replace(system.stepping, method=Method.STIFF))
    assert run.steps < 5000
    assert run.rejected < 0.3 * run.steps


@pytest.mark.parametrize("method", [Method.EXPLICIT, Method.STIFF])
@pytest.mark.parametrize("name", shipped())
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


@pytest.mark.parametrize("name", shipped())
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
