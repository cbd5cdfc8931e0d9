"""One step of either method, compiled: explicit Tsitouras 5(4), and Rodas 4(3) for stiff rates."""

import numpy as np
from numba import njit

from vvdp.numerics.tableaus import RODAS4_A, RODAS4_B, RODAS4_C, RODAS4_D, RODAS4_GAMMA, TSIT5_A, TSIT5_C, TSIT5_E

# As tuples, whose entries compiled code knows as constants; the sums below are written out for speed.
TSIT5_ROWS = tuple(tuple(float(x) for x in row) for row in TSIT5_A)
TSIT5_ERROR = tuple(float(x) for x in TSIT5_E)


# Written into the loop rather than called: a call per step with so many arrays costs a few per cent.
@njit(cache=True, error_model="numpy", inline="always")
def explicit_step(rates, t, step, t_right, y, command, params, active, k, trial, error):
    """Tsitouras 5(4) from (t, y) with k[0] = f(t, y): new state in `trial`, its rate in k[6], its error in `error`.

    Only the first `active` states feed back on the rates and are judged; the books behind them are needed at the end.
    """
    A, C, E = TSIT5_ROWS, TSIT5_C, TSIT5_ERROR
    for m in range(active):
        trial[m] = y[m] + step * (A[1][0] * k[0, m])
    rates(t + C[1] * step, trial, command, params, k[1])
    for m in range(active):
        trial[m] = y[m] + step * (A[2][0] * k[0, m] + A[2][1] * k[1, m])
    rates(t + C[2] * step, trial, command, params, k[2])
    for m in range(active):
        trial[m] = y[m] + step * (A[3][0] * k[0, m] + A[3][1] * k[1, m] + A[3][2] * k[2, m])
    rates(t + C[3] * step, trial, command, params, k[3])
    for m in range(active):
        trial[m] = y[m] + step * (A[4][0] * k[0, m] + A[4][1] * k[1, m] + A[4][2] * k[2, m] + A[4][3] * k[3, m])
    rates(t + C[4] * step, trial, command, params, k[4])
    for m in range(active):
        a = A[5][0] * k[0, m] + A[5][1] * k[1, m] + A[5][2] * k[2, m] + A[5][3] * k[3, m] + A[5][4] * k[4, m]
        trial[m] = y[m] + step * a
    rates(t_right, trial, command, params, k[5])
    for m in range(y.size):
        a = A[6][0] * k[0, m] + A[6][1] * k[1, m] + A[6][2] * k[2, m] + A[6][3] * k[3, m] + A[6][4] * k[4, m]
        trial[m] = y[m] + step * (a + A[6][5] * k[5, m])
    rates(t_right, trial, command, params, k[6])
    for m in range(active):
        e = E[0] * k[0, m] + E[1] * k[1, m] + E[2] * k[2, m] + E[3] * k[3, m] + E[4] * k[4, m] + E[5] * k[5, m]
        error[m] = step * (e + E[6] * k[6, m])
    return 6.0


@njit(cache=True, error_model="numpy")
def factorised(matrix, pivots):
    """LU factors of `matrix` in place with partial pivoting."""
    n = pivots.size
    for c in range(n):
        best = c
        for r in range(c + 1, n):
            if abs(matrix[r, c]) > abs(matrix[best, c]):
                best = r
        pivots[c] = best
        if best != c:
            for m in range(n):
                matrix[c, m], matrix[best, m] = matrix[best, m], matrix[c, m]
        for r in range(c + 1, n):
            if matrix[r, c] != 0.0:
                f = matrix[r, c] / matrix[c, c]
                matrix[r, c] = f
                for m in range(c + 1, n):
                    matrix[r, m] -= f * matrix[c, m]


@njit(cache=True, error_model="numpy")
def solved(matrix, pivots, x):
    """Solution in place of `matrix` x = x, `matrix` as left by `factorised`."""
    n = pivots.size
    # All rows first: `factorised` has exchanged the multipliers along with them.
    for c in range(n):
        p = int(pivots[c])
        x[c], x[p] = x[p], x[c]
    for c in range(n):
        for r in range(c + 1, n):
            x[r] -= matrix[r, c] * x[c]
    for c in range(n - 1, -1, -1):
        for m in range(c + 1, n):
            x[c] -= matrix[c, m] * x[m]
        x[c] /= matrix[c, c]


@njit(cache=True, error_model="numpy")
def stiff_step(rates, t, step, t_right, y, command, params, active, scale, k, trial, error, jacobian, matrix, pivots):
    """Rodas 4(3) from (t, y) with k[0] = f(t, y); as `explicit_step`.

    The Jacobian is by forward differences, one evaluation per active state; the books are pure integrals and are
    eliminated by hand.
    """
    n, na = y.size, active
    u, slope, shifted, reduced = np.zeros((6, n)), np.zeros(n), np.zeros(n), np.zeros(na)
    trial[:] = y
    for c in range(na):
        delta = 1.5e-8 * max(abs(y[c]), scale[c])
        trial[c] = y[c] + delta
        delta = trial[c] - y[c]
        rates(t, trial, command, params, shifted)
        for m in range(n):
            jacobian[m, c] = (shifted[m] - k[0, m]) / delta
        trial[c] = y[c]
    # A difference in time taken towards the inside of the step never straddles a stop.
    later = t + 1e-5 * step
    if later > t:
        rates(later, y, command, params, shifted)
        for m in range(n):
            slope[m] = (shifted[m] - k[0, m]) / (later - t)
    g = 1.0 / (RODAS4_GAMMA * step)
    for r in range(na):
        for c in range(na):
            matrix[r, c] = -jacobian[r, c]
        matrix[r, r] += g
    factorised(matrix, pivots)
    shifted[:] = k[0]
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
            a = shifted[m] + step * RODAS4_D[i] * slope[m]
            for l in range(i):
                a += RODAS4_B[i, l] / step * u[l, m]
            u[i, m] = a
        for c in range(na):
            reduced[c] = u[i, c]
        solved(matrix, pivots, reduced)
        for m in range(n):
            a = u[i, m]
            for c in range(na):
                a += jacobian[m, c] * reduced[c]
            u[i, m] = a / g
        for c in range(na):
            u[i, c] = reduced[c]
    for m in range(n):
        trial[m] += u[5, m]
        error[m] = u[5, m]
    rates(t_right, trial, command, params, k[6])
    return 8.0 + 1.5 * na


@njit(cache=True, error_model="numpy")
def between(s, step, y, trial, k, middle):
    """State at the fraction `s` of an accepted step, by the cubic through both ends and their rates, into `middle`."""
    a, b = (1.0 + 2.0 * s) * (1.0 - s) ** 2, s * s * (3.0 - 2.0 * s)
    c, d = step * s * (1.0 - s) ** 2, -step * s * s * (1.0 - s)
    for m in range(y.size):
        middle[m] = y[m] * a + trial[m] * b + c * k[0, m] + d * k[6, m]


@njit(cache=True, error_model="numpy")
def turning_value(a, b, rise, fall):
    """Where the cubic from `a` to `b` turns round, its slopes at the ends `rise` and `fall` of opposite sign."""
    c2, c3 = 3.0 * (b - a) - 2.0 * rise - fall, rise + fall - 2.0 * (b - a)
    root = np.sqrt(c2 * c2 - 3.0 * c3 * rise)
    q = -c2 - root if c2 > 0.0 else root - c2
    s = rise / q
    if not 0.0 <= s <= 1.0:
        s = q / (3.0 * c3)
    return a + s * (rise + s * (c2 + s * c3))


@njit(cache=True, error_model="numpy", inline="always")
def widen(low, high, active, step, y, trial, k):
    """Takes a step into the extremes of all but the books, with where its cubic turns round."""
    for m in range(active):
        low[m] = min(low[m], trial[m])
        high[m] = max(high[m], trial[m])
        if k[0, m] * k[6, m] < 0.0:
            turn = turning_value(y[m], trial[m], step * k[0, m], step * k[6, m])
            low[m] = min(low[m], turn)
            high[m] = max(high[m], turn)
