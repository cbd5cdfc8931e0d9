"""Ports that are open together: against the balance of flows, an integral by another method, and by hand."""

from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq

from vvdp.valve.condition import Condition
from vvdp.valve.flow_map import quasi_steady_mean
from vvdp.valve.geometry import nozzle_width, pitch
from vvdp.valve.joined_ports import Ends, _at, joined_ports
from vvdp.valve.losses import closed_form_load_flow, full_open_loss, transition_loss

PAGE = " ".join((Path(__file__).parents[2] / "docs/models/rotary-valve.md").read_text("utf-8").split())
BAR, T, Q = 1e5, 101325.0, 40.0 / 6e4


def condition(load=100.0, relief=120.0, override=0.0):
    return Condition(
        flow=Q,
        load_pressure=load * BAR + T,
        relief_pressure=relief * BAR + T,
        tank_pressure=T,
        density=876.0,
        relief_override=override * BAR,
        relief_rated_flow=Q,
    )


@pytest.mark.parametrize("lap", [0.95, 0.8, 0.64, 0.5, 0.3])
@pytest.mark.parametrize(("load", "relief", "override"), [(100, 120, 0), (100, 120, 10), (100, 200, 0), (30, 45, 5)])
def test_losses_and_flows_are_those_of_the_average_over_a_period(prototype, lap, load, relief, override):
    """Which finds the inlet pressure by bisection at 1000 angles, the centre section to the power 1.91."""
    valve, at = replace(prototype, lap_ratio=lap), condition(load, relief, override)
    closed, mean = transition_loss(at, valve), quasi_steady_mean(0.5, at, valve)
    open_loss = full_open_loss(Q, 876.0, valve)
    assert closed.loss + open_loss == pytest.approx(mean.loss, rel=1e-3)
    assert closed_form_load_flow(0.5, at, valve) == pytest.approx(mean.load_flow, rel=3e-4)
    assert closed.relief_flow == pytest.approx(mean.relief_flow, abs=5e-4 * Q)


@pytest.mark.parametrize("joint", [0.05, 0.2, 0.36, 0.5, 0.9])
@pytest.mark.parametrize("rise", [0.0, 10e5])
def test_integrals_by_another_method(joint, rise):
    """The inlet pressure by Brent at each opening, the integrals by adaptive quadrature between the kinks."""
    ends = Ends(20e5, 120e5, rise, 3.93e5, 2.75e5)

    def flows(t):
        def port(a, over):
            return a / np.sqrt(ends.nozzle + ends.other * a * a) * np.sign(over) * np.sqrt(abs(over))

        def surplus(p):  # p: inlet over the tank
            q = port(joint - t, p - 100e5), port(t, p)
            return 1.0 - sum(q) - (max(p - 120e5, 0.0) / rise if rise else 0.0)

        top = 120e5 + rise
        p = top if surplus(top) > 0.0 else brentq(surplus, 1e-3, top, xtol=1e-6)
        load = port(joint - t, p - 100e5)
        return p - load * 100e5 - ends.nozzle - ends.other, load, max(1.0 - load - port(t, p), 0.0)

    found = joined_ports(joint, ends)
    grid = np.linspace(0.0, joint, 41)
    for k, value in enumerate(found):
        wanted = sum(
            quad(lambda t, k=k: flows(t)[k], low, high, epsrel=1e-9, limit=200)[0] for low, high in pairwise(grid)
        )
        assert value == pytest.approx(wanted, rel=1e-5, abs=1e-5 * joint)


def test_one_instant_by_hand():
    """Both ports at a = 0.25 of n = 4, r = 0: g = 1/8. Load 1, relief far above: (sqrt(p - 1) + sqrt(p))/8 = 1 has
    sqrt(p) = (8 + 1/8)/2 = 4.0625, so that the load gets 1 - 4.0625/8 = 0.4921875; at p = 16.50390625."""
    found = _at(0.25, 0.5, Ends(1e6, 1e6 + 1.0, 0.0, 4.0, 0.0))
    assert found.load_flow == pytest.approx(0.4921875, rel=1e-12)
    assert found.excess_drop == pytest.approx(16.50390625 - 0.4921875 - 4.0, rel=1e-12)
    assert found.relief_flow == 0.0


def test_oil_flows_back_from_the_load_by_hand():
    """g = 1/2 and 1, load 4: y - sqrt(4 - y^2)/2 = 1, so 5 y^2 - 8 y = 0, y = 1.6: 0.6 flow from load to tank."""
    found = _at(1.0, 1.5, Ends(1e6, 1e6 + 4.0, 0.0, 1.0, 0.0))
    assert found.load_flow == pytest.approx(1.0 - 1.6, rel=1e-12)
    assert found.excess_drop == pytest.approx(2.56 + 0.6 * 4.0 - 1.0, rel=1e-12)


def test_no_kink_at_zero_lap_nor_below(prototype):
    """Slopes over the lap by differences on either side of 1, and of where the relief valve no longer opens."""

    def loss(lap):
        return transition_loss(condition(override=10.0), replace(prototype, lap_ratio=lap)).loss

    dwell = 2.0 * nozzle_width(prototype) / pitch(prototype) * Q
    for lap in (1.0, 1.0 - 0.183, 1.0 - 0.477):
        left, right = ((loss(lap + s * 2e-4) - loss(lap + s * 1e-4)) / (s * 1e-4) for s in (-1.0, 1.0))
        assert left == pytest.approx(right, abs=2e-3 * dwell * 120e5)
    assert (loss(1.001) - loss(1.0)) / 1e-3 == pytest.approx(dwell * (130e5 - 6.677e5), rel=0.02)


def test_least_loss_of_the_prototype_lies_at_a_lap_of_two_thirds(prototype):
    laps = np.linspace(0.3, 1.2, 91)
    losses = [transition_loss(condition(), replace(prototype, lap_ratio=lap)).loss for lap in laps]
    assert laps[int(np.argmin(losses))] == pytest.approx(0.64, abs=0.011)
    assert round(losses[70]) == 1333
    assert round(min(losses)) == 688
    assert "of the 1333 W of the transitions of `prototype-constant-load` 688 W are left at the best lap, 0.64" in PAGE
