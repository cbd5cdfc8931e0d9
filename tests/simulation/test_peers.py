"""The compiled loop against SciPy's solvers, and its two methods against each other."""

from typing import Annotated, NamedTuple

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from vvdp.base.conservation import Nothing
from vvdp.base.kinds import Kind, Ratio
from vvdp.base.params import Params
from vvdp.simulation.model import Case, Model
from vvdp.simulation.run import Method, Stepping, simulate
from vvdp.simulation.values import flat, leaves

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


def test_both_methods_agree_on_the_switching_circuit(switching):
    """All states, books included, after 0.1 s of closed loop: 15 edges, and the spool on its end stop after each.

    There the rates jump where no stop says so, and a method of any order is of order one: a jump costs about the
    tolerance, 1e-10; some tens of them, each amplified by at most a hundred: 1e-6.
    """
    model, case = switching
    explicit, stiff = (
        simulate(model, case(), Stepping(until=0.1, relative_tolerance=1e-10, method=method)).final
        for method in (Method.EXPLICIT, Method.STIFF)
    )
    scale = np.array([kind.scale for _, _, kind in leaves(case().state)])
    assert np.max(np.abs(explicit - stiff) / np.abs(explicit).clip(scale)) < 1e-6
