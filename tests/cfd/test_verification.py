"""Flows in closed form, computed: how far off they are, and how fast that falls with the cells."""

import math

import numpy as np
import pytest
from tests.cfd.conftest import OIL, PAIR, PIPE

from vvdp.cfd.solve import solve
from vvdp.cfd.verification import (
    WEDGE,
    cylinders_case,
    cylinders_torque,
    pipe_case,
    pipe_force,
)


def errors(make, exact, counts, openfoam, folder):
    found = []
    for count in counts:
        solved = solve(make(count), folder / str(count), openfoam, 1, lambda progress: None)
        assert solved.settled
        assert solved.mesh.faults == ()
        found.append(abs(solved.judgement.value / exact - 1.0))
    return found


@pytest.mark.thorough
def test_a_laminar_pipe_has_the_drop_of_hagen_and_poiseuille(openfoam, tmp_path):
    """Force on the wall of a slice; measured 2.3, 0.62 and 0.16 % at 5, 10 and 20 cells along the radius."""
    exact = pipe_force(PIPE, OIL) * WEDGE / (2.0 * math.pi)
    found = errors(lambda n: pipe_case(PIPE, OIL, n), exact, (5, 10, 20), openfoam, tmp_path)
    orders = np.log2(np.array(found[:-1]) / found[1:])
    assert (orders > 1.85).all()
    assert (orders < 2.15).all()
    assert found[-1] < 2e-3


@pytest.mark.thorough
def test_turning_cylinders_have_the_torque_of_couette(openfoam, tmp_path):
    """Measured 3.1, 0.67 and 0.15 % at 4, 8 and 16 cells across the gap."""
    exact = cylinders_torque(PAIR, OIL)
    found = errors(lambda n: cylinders_case(PAIR, OIL, n), exact, (4, 8, 16), openfoam, tmp_path)
    orders = np.log2(np.array(found[:-1]) / found[1:])
    assert (orders > 1.9).all()
    assert (orders < 2.4).all()
    assert found[-1] < 2e-3


def test_closed_forms_by_hand():
    """8 pi 0.0387 1 0.02 = 0.01945 N, and -4 pi 0.0387 0.05 1e-3 (1e-4 4e-4)/(3e-4) = -3.242e-9 N m."""
    assert pipe_force(PIPE, OIL) == pytest.approx(0.019453, rel=1e-4)
    assert cylinders_torque(PAIR, OIL) == pytest.approx(-3.2421e-9, rel=1e-4)
