"""What the loop for many cases at once works with: its arrays, code for all lanes, and a step of all of them.

Vectors are flat: number m of lane l is at m * WIDTH + l.
"""

from typing import Any, NamedTuple

import numpy as np
from llvmlite import ir
from numba import extending, njit, types
from numba.core import cgutils
from numba.np.arrayobj import make_array

from vvdp.numerics.tableaus import TSIT5_C
from vvdp.simulation.lane_code import host_width
from vvdp.simulation.places import BARE
from vvdp.simulation.steps import TSIT5_ERROR, TSIT5_ROWS

intrinsic: Any = extending.intrinsic
WIDTH = host_width()
W1, W2, W3, W4, W5, W6 = (TSIT5_ROWS[i][:i] for i in range(1, 7))

# What a lane knows of its case besides the clock: where its step ends, whether that is a stop, how often it was tried
# for one event, the step to try again, whether it is aimed at an event or ends on one, when it must stop and sample,
# what has become of the step, for how many steps it has been at the edge of its stability, its error, and
# the step of the try before.
T_NEW, LAST_STEP, TRIED, AGAIN, AIMS, EVENT, T_STOP, T_DUE, VERDICT, EDGE, SIZE, STEP_TRIED = range(12)
OWN = 12
IDLE, TAKEN, TO_REPEAT, LOST = 0.0, 1.0, 2.0, 3.0


class Cases(NamedTuple):
    """What is kept of each case, a row for each."""

    y: Any
    command: Any
    memory: Any
    params: Any
    agenda: Any
    waiting: Any
    clocks: Any
    course: Any
    mark_times: Any
    mark_states: Any
    span_states: Any
    low: Any
    high: Any
    status: Any
    moving: Any  # whether any of its signals moves


class Rules(NamedTuple):
    """What holds for all cases."""

    plan: Any
    atol: Any  # (active * WIDTH,)
    rtol: Any  # (active * WIDTH,)
    width: Any
    grain: Any
    floor: Any
    t_end: Any
    longest: Any
    marks_from: Any
    span_times: Any
    reads: Any  # the places of the commands on which rates and events depend
    stiff_from: Any  # from so many steps at the edge of stability on a case is handed over


class Lanes(NamedTuple):
    """Room for what is in the lanes: vectors for all of them, then a row for each."""

    y: Any  # (n * WIDTH,), as the next two
    trial: Any
    nothing: Any  # zeros
    error: Any  # (active * WIDTH,), as the next four
    lean: Any
    turned: Any
    low: Any
    high: Any
    k: Any  # (7, (n + modes) * WIDTH)
    u: Any
    p: Any
    s: Any
    x: Any  # (positions * WIDTH,)
    time: Any  # (WIDTH,), as the next three
    stage: Any
    h: Any
    one: Any  # ones
    values: Any  # (signals,) of one lane
    command: Any  # (reads,), likewise
    own: Any  # (WIDTH, OWN)
    before: Any  # (WIDTH, positions), as the next three
    reached: Any
    held: Any
    tried: Any
    case: Any  # (WIDTH,), -1 where there is none


@intrinsic
def call(typing, place, t, y, u, p, s, result):
    """Calls the code for all lanes (`lane_code`) that lies at `place`."""

    def generate(context, builder, signature, arguments):
        given = zip(signature.args[1:], arguments[1:], strict=True)
        pointers = [make_array(kind)(context, builder, value).data for kind, value in given]
        kind = ir.FunctionType(ir.VoidType(), [pointer.type for pointer in pointers])
        builder.call(builder.inttoptr(arguments[0], ir.PointerType(kind)), pointers)
        return context.get_dummy_value()

    return types.void(types.int64, t, y, u, p, s, result), generate


@intrinsic
def combine(typing, result, place, y, h, weights, stages):
    """Writes y + h * (weights[0] * stages[0] + ...) for all lanes of the number that begins at `place`.

    As a loop it would not become vector code: the compiler cannot know that no two of so many arrays overlap.
    """

    def generate(context, builder, signature, arguments):
        vector, kinds = ir.VectorType(ir.DoubleType(), WIDTH), signature.args

        def pointer(kind, array, place):
            first = builder.gep(make_array(kind)(context, builder, array).data, [place])
            return builder.bitcast(first, ir.PointerType(vector))

        def numbers(kind, array, place):
            return builder.load(pointer(kind, array, place), align=8)

        def everywhere(number):
            one = builder.insert_element(ir.Constant(vector, ir.Undefined), number, ir.Constant(ir.IntType(32), 0))
            mask = ir.Constant(ir.VectorType(ir.IntType(32), WIDTH), [0] * WIDTH)
            return builder.shuffle_vector(one, ir.Constant(vector, ir.Undefined), mask)

        target, place, y, h = arguments[:4]
        weights, stages = (cgutils.unpack_tuple(builder, given) for given in arguments[4:])
        total = None
        for kind, weight, array in zip(kinds[5], weights, stages, strict=True):
            part = builder.fmul(everywhere(weight), numbers(kind, array, place))
            total = part if total is None else builder.fadd(total, part)
        nothing = ir.Constant(place.type, 0)
        moved = builder.fadd(numbers(kinds[2], y, place), builder.fmul(numbers(kinds[3], h, nothing), total))
        builder.store(moved, pointer(kinds[0], target, place), align=8)
        return context.get_dummy_value()

    return types.void(result, place, y, h, weights, stages), generate


@njit(**BARE, inline="always")
def gather(row, vectors, lane):
    """The numbers of one lane."""
    for m in range(row.size):
        row[m] = vectors[m * WIDTH + lane]


@njit(**BARE, inline="always")
def scatter(vectors, lane, row):
    """Writes the numbers of one lane."""
    for m in range(row.size):
        vectors[m * WIDTH + lane] = row[m]


@njit(**BARE, inline="always")
def tell(signals, cases, lanes):
    """Works out the signals that move, each lane's at the time of its stage."""
    for lane in range(WIDTH):
        case = lanes.case[lane]
        if case >= 0 and cases.moving[case]:
            signals(lanes.stage[lane], cases.params[case], lanes.values)
            scatter(lanes.s, lane, lanes.values)


@njit(**BARE, inline="always")
def stage(rates, signals, cases, lanes, c, trial, k):
    """Rates of all lanes at the share `c` of their steps; at their ends just before the next instant."""
    if c < 1.0:
        for lane in range(WIDTH):
            lanes.stage[lane] = lanes.time[lane] + c * lanes.h[lane]
    else:
        for lane in range(WIDTH):
            own = lanes.own[lane]
            lanes.stage[lane] = np.nextafter(own[T_NEW], -np.inf) if own[LAST_STEP] else own[T_NEW]
    tell(signals, cases, lanes)
    call(rates, lanes.stage, trial, lanes.u, lanes.p, lanes.s, k)


@njit(**BARE, inline="always")
def sweep(rates, signals, cases, lanes, y, trial, first, last):
    """An explicit step of each lane as in `steps.explicit_step`; leaves the error, and what tells of stiffness."""
    C = TSIT5_C
    h, k, active = lanes.h, lanes.k, lanes.error.size
    k0, k1, k2, k3, k4, k5, k6 = k[first], k[1], k[2], k[3], k[4], k[5], k[last]
    for i in range(0, active, WIDTH):
        combine(trial, i, y, h, W1, (k0,))
    stage(rates, signals, cases, lanes, C[1], trial, k1)
    for i in range(0, active, WIDTH):
        combine(trial, i, y, h, W2, (k0, k1))
    stage(rates, signals, cases, lanes, C[2], trial, k2)
    for i in range(0, active, WIDTH):
        combine(trial, i, y, h, W3, (k0, k1, k2))
    stage(rates, signals, cases, lanes, C[3], trial, k3)
    for i in range(0, active, WIDTH):
        combine(trial, i, y, h, W4, (k0, k1, k2, k3))
    stage(rates, signals, cases, lanes, C[4], trial, k4)
    for i in range(0, active, WIDTH):
        combine(trial, i, y, h, W5, (k0, k1, k2, k3, k4))
    stage(rates, signals, cases, lanes, 1.0, trial, k5)
    for i in range(active):
        lanes.lean[i] = -trial[i]
    for i in range(0, y.size, WIDTH):
        combine(trial, i, y, h, W6, (k0, k1, k2, k3, k4, k5))
    stage(rates, signals, cases, lanes, 1.0, trial, k6)
    for i in range(0, active, WIDTH):
        combine(lanes.error, i, lanes.nothing, h, TSIT5_ERROR, (k0, k1, k2, k3, k4, k5, k6))
        combine(lanes.turned, i, lanes.nothing, h, (1.0, -1.0), (k6, k5))
        combine(lanes.lean, i, lanes.lean, lanes.one, (1.0,), (trial,))


@njit(**BARE, inline="always")
def norms(rules, lanes, y, trial):
    """Leaves the sums of squares of each lane in the last places of `error`, `lean` and `turned`."""
    error, lean, turned = lanes.error, lanes.lean, lanes.turned
    for i in range(error.size):
        tolerance = 1.0 / (rules.atol[i] + rules.rtol[i] * max(abs(y[i]), abs(trial[i])))
        e, l, d = error[i] * tolerance, lean[i] * tolerance, turned[i] * tolerance
        error[i], lean[i], turned[i] = e * e, l * l, d * d
    for i in range(WIDTH, error.size):
        error[i] += error[i - WIDTH]
        lean[i] += lean[i - WIDTH]
        turned[i] += turned[i - WIDTH]
