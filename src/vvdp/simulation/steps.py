"""One explicit step, compiled: Tsitouras 5(4), and the cubic between the ends of a step."""

import numpy as np

from vvdp.numerics.tableaus import TSIT5_A, TSIT5_C, TSIT5_E

# As tuples, whose entries compiled code knows as constants; the sums below are written out for speed.
TSIT5_ROWS = tuple(tuple(float(x) for x in row) for row in TSIT5_A)
TSIT5_ERROR = tuple(float(x) for x in TSIT5_E)


def below(y, floor, count):
    """The first of `count` states that lies below its floor; -1 where none does."""
    for m in range(count):
        if y[m] < floor[m]:
            return m
    return -1


def copy(target, source):
    """Writes the numbers of `source` to `target`."""
    for m in range(target.size):
        target[m] = source[m]


def fill(target, value):
    """Writes `value` everywhere."""
    for m in range(target.size):
        target[m] = value


# Written into the loop rather than called: a call per step with so many arrays costs a few per cent.
def explicit_step(rates, t, step, t_right, y, command, params, active, k, trial, error, lean):
    """Tsitouras 5(4) from (t, y) with k[0] = f(t, y): new state in `trial`, its rate in k[6], its error in `error`.

    Only the first `active` states feed back on the rates and are judged; the books behind them are needed at the end.
    `lean` is the new state less that of the stage before, both at the end of the step.
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
    for m in range(active):
        lean[m] = -trial[m]
    for m in range(y.size):
        a = A[6][0] * k[0, m] + A[6][1] * k[1, m] + A[6][2] * k[2, m] + A[6][3] * k[3, m] + A[6][4] * k[4, m]
        trial[m] = y[m] + step * (a + A[6][5] * k[5, m])
    rates(t_right, trial, command, params, k[6])
    for m in range(active):
        e = E[0] * k[0, m] + E[1] * k[1, m] + E[2] * k[2, m] + E[3] * k[3, m] + E[4] * k[4, m] + E[5] * k[5, m]
        error[m] = step * (e + E[6] * k[6, m])
        lean[m] += trial[m]
    return 6.0


def between(s, step, y, trial, k, middle):
    """State at the fraction `s` of an accepted step, by the cubic through both ends and their rates, into `middle`."""
    a, b = (1.0 + 2.0 * s) * (1.0 - s) ** 2, s * s * (3.0 - 2.0 * s)
    c, d = step * s * (1.0 - s) ** 2, -step * s * s * (1.0 - s)
    for m in range(y.size):
        middle[m] = y[m] * a + trial[m] * b + c * k[0, m] + d * k[6, m]


def turning_value(a, b, rise, fall):
    """Where the cubic from `a` to `b` turns round, its slopes at the ends `rise` and `fall` of opposite sign."""
    c2, c3 = 3.0 * (b - a) - 2.0 * rise - fall, rise + fall - 2.0 * (b - a)
    root = np.sqrt(c2 * c2 - 3.0 * c3 * rise)
    q = -c2 - root if c2 > 0.0 else root - c2
    s = rise / q
    if not 0.0 <= s <= 1.0:
        s = q / (3.0 * c3)
    return a + s * (rise + s * (c2 + s * c3))


def widen(low, high, active, step, y, trial, k):
    """Takes a step into the extremes of all but the books, with where its cubic turns round."""
    for m in range(active):
        low[m] = min(low[m], trial[m])
        high[m] = max(high[m], trial[m])
        if k[0, m] * k[6, m] < 0.0:
            turn = turning_value(y[m], trial[m], step * k[0, m], step * k[6, m])
            low[m] = min(low[m], turn)
            high[m] = max(high[m], turn)
