"""The coefficients satisfy the conditions that make the methods what they are said to be.

Coefficients are rounded to about 16 digits. With terms up to a few hundred in the sums (Rodas: 34 times 1/gamma), what
is left of a condition is rounding of that size: 1e-12.
"""

import numpy as np
import pytest

from vvdp.numerics.tableaus import RODAS4_A, RODAS4_B, RODAS4_C, RODAS4_D, RODAS4_GAMMA, TSIT5_A, TSIT5_C, TSIT5_E

ROUNDING = 1e-12

A = np.zeros((7, 7))
A[:, :6] = TSIT5_A
B = A[6]
c = TSIT5_C


def explicit_conditions(b, order):
    """Left sides of the conditions of a Runge-Kutta method for all rooted trees up to an order, and right sides."""
    Ac = A @ c
    conditions = {
        1: [(b.sum(), 1)],
        2: [(b @ c, 1 / 2)],
        3: [(b @ c**2, 1 / 3), (b @ Ac, 1 / 6)],
        4: [(b @ c**3, 1 / 4), (b @ (c * Ac), 1 / 8), (b @ A @ c**2, 1 / 12), (b @ A @ Ac, 1 / 24)],
        5: [
            (b @ c**4, 1 / 5),
            (b @ (c**2 * Ac), 1 / 10),
            (b @ (c * (A @ c**2)), 1 / 15),
            (b @ (c * (A @ Ac)), 1 / 30),
            (b @ Ac**2, 1 / 20),
            (b @ A @ c**3, 1 / 20),
            (b @ A @ (c * Ac), 1 / 40),
            (b @ A @ A @ c**2, 1 / 60),
            (b @ A @ A @ Ac, 1 / 120),
        ],
    }
    return np.array([pair for k in range(1, order + 1) for pair in conditions[k]]).T


def test_stages_stand_where_their_rows_say():
    assert A.sum(axis=1) == pytest.approx(c, abs=ROUNDING)


def test_explicit_method_has_order_5():
    left, right = explicit_conditions(B, 5)
    assert left == pytest.approx(right, abs=ROUNDING)


def test_embedded_method_has_order_4_and_no_more():
    # the published error weights carry 18 digits of numbers below 1
    embedded = B - TSIT5_E
    left, right = explicit_conditions(embedded, 4)
    assert left == pytest.approx(right, abs=ROUNDING)
    left, right = explicit_conditions(embedded, 5)
    assert np.max(np.abs(left - right)) > 1e-4


class Rosenbrock:
    """The method in its usual form, recovered from the one without matrix products: C = 1/gamma - inverse(Gamma)."""

    def __init__(self):
        n = 6
        a, C = np.zeros((n, n)), np.zeros((n, n))
        a[:5, :4] = RODAS4_A
        a[5] = a[4]
        a[5, 4] = 1.0  # the last stage starts from the fifth
        C[:, :5] = RODAS4_B
        self.weights = a[5].copy()
        self.weights[5] = 1.0
        self.gamma = np.linalg.inv(np.eye(n) / RODAS4_GAMMA - C)
        self.alpha = a @ self.gamma
        self.beta = self.alpha + self.gamma
        self.b = self.weights @ self.gamma
        embedded = self.weights.copy()
        embedded[5] = 0.0
        self.b_embedded = embedded @ self.gamma

    def conditions(self, b):
        """Hairer and Wanner 1996, IV.7: by order."""
        alpha_i, beta_i = self.alpha.sum(axis=1), self.beta.sum(axis=1)
        return {
            1: [(b.sum(), 1)],
            2: [(b @ beta_i, 1 / 2)],
            3: [(b @ alpha_i**2, 1 / 3), (b @ self.beta @ beta_i, 1 / 6)],
            4: [
                (b @ alpha_i**3, 1 / 4),
                (b @ (alpha_i * (self.alpha @ beta_i)), 1 / 8),
                (b @ self.beta @ alpha_i**2, 1 / 12),
                (b @ self.beta @ self.beta @ beta_i, 1 / 24),
            ],
        }


def test_stiff_method_is_consistent():
    method = Rosenbrock()
    assert method.alpha.sum(axis=1) == pytest.approx(RODAS4_C, abs=ROUNDING)
    assert method.gamma.sum(axis=1) == pytest.approx(RODAS4_D, abs=ROUNDING)
    assert np.diag(method.gamma) == pytest.approx(np.full(6, RODAS4_GAMMA), abs=ROUNDING)


@pytest.mark.parametrize("order", [1, 2, 3, 4])
def test_stiff_method_has_order_4(order):
    method = Rosenbrock()
    for left, right in method.conditions(method.b)[order]:
        assert left == pytest.approx(right, abs=ROUNDING)


def test_embedded_stiff_method_has_order_3_and_no_more():
    method = Rosenbrock()
    conditions = method.conditions(method.b_embedded)
    for order in (1, 2, 3):
        for left, right in conditions[order]:
            assert left == pytest.approx(right, abs=ROUNDING)
    assert max(abs(left - right) for left, right in conditions[4]) > 1e-4


def test_stiff_method_ends_on_its_last_stage():
    """Stiffly accurate: b is the last row of beta, so the method damps an infinitely fast mode at once."""
    method = Rosenbrock()
    assert method.beta[5] == pytest.approx(method.b, abs=ROUNDING)
