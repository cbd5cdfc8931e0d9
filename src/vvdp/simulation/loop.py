"""The compiled loop: one for all circuits. Flat vectors in, and pointers to the linked functions.

It is compiled once per installation and cached. What a run has reached is in `clock` (and in the vectors that it
changes in place), so a run can be handed back at any step and taken up again with the same result to the last bit.
"""

import numpy as np
from numba import float64, int64, njit, prange, types

from vvdp.numerics.tableaus import RODAS4_A, RODAS4_B, RODAS4_C, RODAS4_D, RODAS4_GAMMA, TSIT5_A, TSIT5_C, TSIT5_E

VECTOR = float64[::1]
MATRIX = float64[:, ::1]
FLAT = types.void(float64, VECTOR, VECTOR, VECTOR, VECTOR)
RATES = types.FunctionType(FLAT)
SAMPLE = types.FunctionType(FLAT)
MARK = types.FunctionType(float64(float64, VECTOR, VECTOR))
STOP = types.FunctionType(float64(float64, VECTOR))

# What `run` returns.
DONE, PAUSED, MARKS_FULL, NOT_FINITE, STEP_TOO_SMALL = 0, 1, 2, 3, 4

# Places in `clock`.
TIME, STEP, SAMPLES, STEPS, REJECTED, EVALUATIONS, RECORDS, MARKS, STORED, METHOD = range(10)
WINDOW_TIME, WINDOW_COST, OTHER_COST, TRIAL, REVIEW, SWITCHES, REFUSED = range(10, 17)
CLOCK = 17

EXPLICIT, STIFF = 0.0, 1.0
AUTOMATIC, ONLY_EXPLICIT, ONLY_STIFF = 0, 1, 2

# The automatic choice: an explicit window that costs more than this many evaluations per sample period is worth a
# trial of the stiff method; a window ends after so many periods or so many evaluations, whichever comes first.
TRIAL_COST = 900.0
WINDOW_PERIODS = 20.0
WINDOW_EVALUATIONS = 40000.0
REVIEW_WINDOWS = 20.0

# After so many refusals in a row a step is tried with the explicit method: at a jump of the rates the stiff one's
# Jacobian by differences is the jump over a hair's breadth, and no step is short enough for it.
PATIENCE = 6.0


# As tuples, whose entries compiled code knows as constants; the sums below are written out for speed.
TSIT5_ROWS = tuple(tuple(float(x) for x in row) for row in TSIT5_A)
TSIT5_ERROR = tuple(float(x) for x in TSIT5_E)


@njit(cache=True, error_model="numpy")
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


@njit(cache=True, error_model="numpy")
def chosen_method(t, period, clock):
    """Reviews the automatic choice of method: tries the other one when the present one is dear, keeps the cheaper."""
    elapsed, spent = t - clock[WINDOW_TIME], clock[EVALUATIONS] - clock[WINDOW_COST]
    if elapsed < WINDOW_PERIODS * period and spent < WINDOW_EVALUATIONS:
        return
    cost = spent / elapsed * period
    clock[WINDOW_TIME], clock[WINDOW_COST] = t, clock[EVALUATIONS]
    if clock[TRIAL] == 1.0:
        clock[TRIAL] = 0.0
        clock[REVIEW] = REVIEW_WINDOWS
        if cost > clock[OTHER_COST]:
            clock[METHOD] = STIFF - clock[METHOD]
        else:
            clock[SWITCHES] += 1.0
        return
    clock[REVIEW] -= 1.0
    if clock[REVIEW] <= 0.0 and (clock[METHOD] == STIFF or cost > TRIAL_COST):
        clock[TRIAL], clock[OTHER_COST] = 1.0, cost
        clock[METHOD] = STIFF - clock[METHOD]


RUN = int64(
    RATES, SAMPLE, MARK, STOP,
    VECTOR, VECTOR, VECTOR, VECTOR, VECTOR, VECTOR, VECTOR, VECTOR, VECTOR,
    int64, float64, float64, float64, int64, float64, int64,
    VECTOR, MATRIX, MATRIX, VECTOR, MATRIX, VECTOR, VECTOR,
)  # fmt: skip


@njit(RUN, cache=True, error_model="numpy")
def run(
    rates, sample, mark, stop,
    y, command, memory, params, settings, atol, rtol, scale, clock,
    active, period, t_end, marks_from, method, budget, overwrite,
    record_times, record, record_command, mark_times, mark_states, low, high,
):  # fmt: skip
    """Carries a run on from where `clock` stands, to `t_end` or until `budget` evaluations are spent.

    Every step ends at the latest on the next sample (multiples of `period`, where `sample` may change `command`) and
    on the next time that `stop` names; rates at a step's right end are taken just before that instant. States at
    `record_times` go to `record`, at each change of the floor of `mark` (from `marks_from` on) to `mark_states`; when
    that is full the run is handed back, or with `overwrite` the last row is kept up to date.
    """
    n = y.size
    trial, error, middle, k = np.zeros(n), np.zeros(n), np.zeros(n), np.zeros((7, n))
    jacobian, matrix, pivots = np.zeros((n, active)), np.zeros((active, active)), np.zeros(active)
    t, h = clock[TIME], clock[STEP]
    enough = clock[EVALUATIONS] + budget
    rates(t, y, command, params, k[0])
    g0 = mark(t, y, params)
    t_stop = stop(t, params)
    t_sample = min((clock[SAMPLES] + 1.0) * period, t_end)
    while t < t_end:
        if clock[EVALUATIONS] >= enough:
            return PAUSED
        t_next = min(t_sample, t_stop)
        last = t + h * (1.0 + 1e-9) >= t_next
        step = t_next - t if last else h
        t_right = np.nextafter(t_next, -np.inf) if last else t + step
        if clock[METHOD] == STIFF and clock[REFUSED] < PATIENCE:
            cost = stiff_step(
                rates, t, step, t_right, y, command, params, active, scale, k, trial, error, jacobian, matrix, pivots
            )
            exponent = -0.25
        else:
            cost = explicit_step(rates, t, step, t_right, y, command, params, active, k, trial, error)
            exponent = -0.2
        clock[EVALUATIONS] += cost
        clock[STEPS] += 1.0
        size, finite = 0.0, True
        for m in range(active):
            e = abs(error[m]) / (atol[m] + rtol[m] * max(abs(y[m]), abs(trial[m])))
            finite = finite and e < 1e300
            size += e * e
        size = np.sqrt(size / active)
        if not finite or size > 1.0:
            clock[REJECTED] += 1.0
            clock[REFUSED] += 1.0
            h = step * (max(0.2, 0.9 * size**exponent) if finite else 0.1)
            clock[STEP] = h
            if h < 1e-14 * max(t, period):
                return STEP_TOO_SMALL if finite else NOT_FINITE
            continue
        t_new = t_next if last else t + step
        g1 = mark(t_new, trial, params)
        change = np.floor(g1) - np.floor(g0)
        if overwrite == 0 and clock[STORED] + abs(change) > mark_times.size:
            # The step is taken again when there is room, however many marks it passes.
            clock[EVALUATIONS] -= cost
            clock[STEPS] -= 1.0
            return MARKS_FULL
        for i in range(int(abs(change))):
            goal = np.floor(g0) + 1.0 + i if change > 0.0 else np.floor(g0) - i
            lo, hi = 0.0, 1.0
            for _ in range(50):
                s = 0.5 * (lo + hi)
                between(s, step, y, trial, k, middle)
                if (mark(t + s * step, middle, params) < goal) == (g0 < goal):
                    lo = s
                else:
                    hi = s
            clock[MARKS] += 1.0
            if t + hi * step >= marks_from:
                row = min(int(clock[STORED]), mark_times.size - 1)
                between(hi, step, y, trial, k, mark_states[row])
                mark_times[row] = t + hi * step
                clock[STORED] = row + 1.0
        row = int(clock[RECORDS])
        while row < record_times.size and record_times[row] <= t_new:
            between((record_times[row] - t) / step, step, y, trial, k, record[row])
            record_command[row, :] = command
            row += 1
        clock[RECORDS] = row
        for m in range(n):
            low[m] = min(low[m], trial[m])
            high[m] = max(high[m], trial[m])
            if k[0, m] * k[6, m] < 0.0:
                turn = turning_value(y[m], trial[m], step * k[0, m], step * k[6, m])
                low[m] = min(low[m], turn)
                high[m] = max(high[m], turn)
        t, g0 = t_new, g1
        y[:] = trial
        # A step that was refused once stands before a kink: growing at once would only have the next one refused.
        grown = step * min(1.0 if clock[REFUSED] > 0.0 else 5.0, max(0.2, 0.9 * (size + 1e-12) ** exponent))
        h = max(h, grown) if last else grown
        clock[REFUSED] = 0.0
        if last:
            if t >= t_sample:
                clock[SAMPLES] += 1.0
                t_sample = min((clock[SAMPLES] + 1.0) * period, t_end)
                sample(t, memory, y, settings, command)
            t_stop = stop(t, params)
            rates(t, y, command, params, k[0])
        else:
            k[0, :] = k[6]
        clock[TIME], clock[STEP] = t, h
        if method == AUTOMATIC:
            chosen_method(t, period, clock)
    return DONE


BATCH = types.void(
    RATES, SAMPLE, MARK, STOP,
    MATRIX, MATRIX, MATRIX, MATRIX, MATRIX, VECTOR, VECTOR, VECTOR,
    int64, float64, float64, float64, float64, int64,
    MATRIX, float64[:, :, ::1], MATRIX, MATRIX, MATRIX, int64[::1],
)  # fmt: skip


@njit(BATCH, cache=True, error_model="numpy", nogil=True, parallel=True)
def batch(
    rates, sample, mark, stop,
    y, command, memory, params, settings, atol, rtol, scale,
    active, period, t_end, marks_from, step, method,
    mark_times, mark_states, low, high, clocks, status,
):  # fmt: skip
    """Runs one case per row of `params` and `y` on all cores; of the marks keeps the first and the last.

    `y`, `command` and `memory` are changed in place.
    """
    for case in prange(params.shape[0]):
        n = y.shape[1]
        low[case, :] = y[case]
        high[case, :] = y[case]
        clocks[case, STEP] = step
        clocks[case, METHOD] = STIFF if method == ONLY_STIFF else EXPLICIT
        status[case] = run(
            rates, sample, mark, stop,
            y[case], command[case], memory[case], params[case], settings[case], atol, rtol, scale, clocks[case],
            active, period, t_end, marks_from, method, 1e300, 1,
            np.zeros(0), np.zeros((0, n)), np.zeros((0, command.shape[1])), mark_times[case], mark_states[case],
            low[case], high[case],
        )  # fmt: skip
