"""One step of the stiffly accurate Rosenbrock method Rodas 4(3), compiled, with a sparse Jacobian by differences."""

import numpy as np

from vvdp.numerics.tableaus import RODAS4_A, RODAS4_B, RODAS4_C, RODAS4_D, RODAS4_GAMMA
from vvdp.simulation.steps import copy, fill

HAIR_OF_STATE = 1.5e-8
"""By how much of its size a state is moved to difference the rates: the root of what a float resolves."""


def differences(rates, t, y, u, p, k0, scale, pattern, moved, shifted, jacobian):
    """The entries of the Jacobian at (t, y), where the rates are `k0`, by one evaluation for each group of columns."""
    active = pattern.group.size
    copy(moved, y)
    for g in range(pattern.first.size - 1):
        for c in range(active):
            if pattern.group[c] == g:
                moved[c] = y[c] + HAIR_OF_STATE * max(abs(y[c]), scale[c])
        rates(t, moved, u, p, shifted)
        for e in range(pattern.first[g], pattern.first[g + 1]):
            r, c = pattern.rows[e], pattern.columns[e]
            jacobian[e] = (shifted[r] - k0[r]) / (moved[c] - y[c])
        for c in range(active):
            moved[c] = y[c]


def fastest_rate(pattern, jacobian, sums):
    """A bound for the rate of the fastest motion [1/s]: the largest row sum of the Jacobian made symmetric.

    Scaling the states makes |J_ij| and |J_ji| equal, to the root of their product, and leaves the eigenvalues; what
    feeds one way only does not change them (Gershgorin 1931).

    sums  room for a sum for each state
    """
    fill(sums, 0.0)
    for q in range(pattern.pairs.shape[0]):
        e, mirrored = pattern.pairs[q, 0], pattern.pairs[q, 1]
        size = np.sqrt(abs(jacobian[e] * jacobian[mirrored]))
        sums[pattern.rows[e]] += size
        if mirrored != e:
            sums[pattern.columns[e]] += size
    fastest = 0.0
    for m in range(pattern.group.size):
        fastest = max(fastest, sums[m])
    return fastest


def factorise(pattern, jacobian, g, factors):
    """The factors of g I - J."""
    fill(factors, 0.0)
    for c in range(pattern.diagonal.size):
        factors[pattern.diagonal[c]] = g
    for e in range(jacobian.size):
        if pattern.places[e] >= 0:
            factors[pattern.places[e]] -= jacobian[e]
    for s in range(pattern.steps.shape[0]):
        target, factor, row = pattern.steps[s, 0], pattern.steps[s, 1], pattern.steps[s, 2]
        if row < 0:
            factors[target] /= factors[factor]
        else:
            factors[target] -= factors[factor] * factors[row]


def solve(pattern, factors, x):
    """Solves for `x` in place with what `factorise` left."""
    for q in range(pattern.lower.shape[0]):
        x[pattern.lower[q, 0]] -= factors[pattern.lower[q, 2]] * x[pattern.lower[q, 1]]
    for q in range(pattern.order.size - 1, -1, -1):
        r = pattern.order[q]
        for e in range(pattern.upper_first[q], pattern.upper_first[q + 1]):
            x[r] -= factors[pattern.upper[e, 2]] * x[pattern.upper[e, 1]]
        x[r] /= factors[pattern.diagonal[r]]


def stiff_step(rates, t, step, t_right, y, command, params, scale, pattern, k, trial, error, bench):
    """Rodas 4(3) from (t, y) with k[0] = f(t, y): new state in `trial`, its rate in k[6], its error in `error`.

    Returns the evaluations that it took and the rate of the fastest motion [1/s]. The books are pure integrals of the
    states before them, and are eliminated by hand.
    """
    n, active = y.size, pattern.group.size
    u, shifted, slope = bench.stages, bench.shifted, bench.slope
    jacobian, factors = bench.jacobian, bench.factors
    differences(rates, t, y, command, params, k[0], scale, pattern, trial, shifted, jacobian)
    # A difference in time taken towards the inside of the step never straddles a stop.
    later = t + 1e-5 * step
    fill(slope, 0.0)
    if later > t:
        rates(later, y, command, params, shifted)
        for m in range(n):
            slope[m] = (shifted[m] - k[0, m]) / (later - t)
    g = 1.0 / (RODAS4_GAMMA * step)
    factorise(pattern, jacobian, g, factors)
    for i in range(6):
        if i == 5:
            for m in range(n):
                trial[m] += u[4, m]
        elif i > 0:
            for m in range(n):
                a = 0.0
                for l in range(i):
                    a += RODAS4_A[i, l] * u[l, m]
                trial[m] = y[m] + a
        if i > 0:
            rates(t_right if RODAS4_C[i] == 1.0 else t + RODAS4_C[i] * step, trial, command, params, shifted)
        for m in range(n):
            a = (shifted[m] if i > 0 else k[0, m]) + step * RODAS4_D[i] * slope[m]
            for l in range(i):
                a += RODAS4_B[i, l] / step * u[l, m]
            u[i, m] = a
        solve(pattern, factors, u[i, :active])
        for e in range(jacobian.size):
            if pattern.places[e] < 0:
                u[i, pattern.rows[e]] += jacobian[e] * u[i, pattern.columns[e]]
        for m in range(active, n):
            u[i, m] /= g
    for m in range(n):
        trial[m] += u[5, m]
        error[m] = u[5, m]
    rates(t_right, trial, command, params, k[6])
    return 7.0 + pattern.first.size - 1.0, fastest_rate(pattern, jacobian, shifted)
