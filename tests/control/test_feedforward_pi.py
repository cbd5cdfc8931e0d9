"""Feedforward and PI: its closed loop, and what it does at its limits."""

import numpy as np
import pytest
from scipy.linalg import expm

from vvdp.base.errors import ParameterError
from vvdp.control.feedforward_pi import FeedforwardPI, pi_start, pi_step
from vvdp.control.reference import Reference, ReferenceFilter, reference_at_rest, reference_step

AREA = np.pi * 12.7e-3**2
GAINS = FeedforwardPI(area=AREA, proportional_rate=30.0, integral_rate=90.0, lowest_flow=-3e-5, highest_flow=3e-5)
PERIOD = 1e-3


def follow(references, start, gains=GAINS, leak=0.0):
    """Positions of an ideal drive, x' = Q/A_s - leak, and the integrals of its controller."""
    memory, x, positions, integrals = pi_start(), start, [], []
    for i, reference in enumerate(references):
        memory, flow = pi_step(memory, reference, x, PERIOD if i else 0.0, gains)
        positions.append(x)
        integrals.append(memory.integral)
        x += (flow / gains.area - leak) * PERIOD
    return np.array(positions), np.array(integrals)


def test_flow_by_hand():
    """A_s (0.01 + 30 * 1e-4 + 90 * (1e-4 * 1e-3)) = 5.0671e-4 * 0.013009 m/s."""
    memory, flow = pi_step(pi_start(), Reference(0.0101, 0.01, 0.0, 0.0), 0.01, PERIOD, GAINS)
    assert memory.integral == pytest.approx(1e-7)
    assert flow == pytest.approx(AREA * 0.013009, rel=1e-12)


def test_error_falls_as_the_matrix_of_the_corrected_equation_says():
    """e' = -(K_p e + K_i e_i)/A_s, which follows with the input matrix [0; -1/A_s]; sampled at 1 ms, to 1 %."""
    A = np.array([[0.0, 1.0], [-90.0, -30.0]])
    positions, _ = follow([reference_at_rest(0.0)] * 200, 1e-4)
    for k in (50, 100, 199):
        expected = -(expm(A * k * PERIOD) @ [0.0, -1e-4])[1]
        assert positions[k] == pytest.approx(expected, abs=2e-6)


def test_printed_input_matrix_gives_another_system():
    """[1; -1/A_s] adds the flow itself to the error's integral: A + B K is not the printed A_dyn then."""
    K = np.array([90.0 * AREA, 30.0 * AREA])
    A, A_dyn = np.array([[0.0, 1.0], [0.0, 0.0]]), np.array([[0.0, 1.0], [-90.0, -30.0]])
    assert np.allclose(A + np.outer([0.0, -1.0 / AREA], K), A_dyn)
    assert not np.allclose(A + np.outer([1.0, -1.0 / AREA], K), A_dyn, rtol=1e-6, atol=1e-3)


def test_no_gains_make_the_matrix_negative_definite():
    """Its symmetric part has a zero on the diagonal; what holds it is that its eigenvalues lie on the left."""
    rng = np.random.default_rng(3)
    for prop, integral in rng.uniform(0.1, 1e3, (100, 2)):
        A = np.array([[0.0, 1.0], [-integral, -prop]])
        assert np.max(np.linalg.eigvalsh(A + A.T)) >= 0.0
        assert np.max(np.linalg.eigvals(A).real) < 0.0


def test_a_reference_that_moves_is_followed_without_lag():
    """With its velocity known the flow leads; an unknown leak is taken over by the integral."""
    settings, reference, references = ReferenceFilter(filter_rate=60.0), reference_at_rest(0.0), []
    for k in range(3000):
        references.append(reference)
        reference = reference_step(reference, 0.01 * min(1.0, k * PERIOD), PERIOD, settings)
    wanted = np.array([r.position for r in references])
    positions, _ = follow(references, 0.0)
    assert np.max(np.abs(positions - wanted)) < 1e-5
    leaking, _ = follow(references, 0.0, leak=1e-3)
    assert abs(leaking[-1] - wanted[-1]) < 1e-7
    alone, _ = follow(references, 0.0, GAINS.__class__(**{**vars(GAINS), "integral_rate": 0.0}), leak=1e-3)
    assert alone[-1] - wanted[-1] == pytest.approx(-1e-3 / 30.0, rel=1e-3)


def test_integral_stands_still_at_the_limit():
    """10 mm at once: at 3e-5/A_s = 59 mm/s it takes 0.17 s."""
    positions, integrals = follow([reference_at_rest(0.01)] * 1000, 0.0)
    moving = positions < 0.01 - 3e-5 / AREA / 30.0
    assert np.all(integrals[moving[: len(integrals)]] == 0.0)
    assert np.max(positions) < 0.01 + 3e-4
    memory, flow = pi_step(pi_start()._replace(integral=1.0), reference_at_rest(0.0), 1e-3, PERIOD, GAINS)
    assert memory.integral < 1.0  # the error points back, so it may fall
    assert flow == GAINS.highest_flow


def test_contradictions_are_refused():
    with pytest.raises(ParameterError, match="both directions"):
        FeedforwardPI(area=AREA, proportional_rate=30.0, integral_rate=90.0, lowest_flow=0.0, highest_flow=3e-5)
    with pytest.raises(ParameterError, match="proportional_rate: 0 1/s"):
        FeedforwardPI(area=AREA, proportional_rate=0.0, integral_rate=90.0, lowest_flow=-3e-5, highest_flow=3e-5)
