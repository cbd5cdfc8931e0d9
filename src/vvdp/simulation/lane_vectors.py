"""Arrays of the loop for many cases at once, code for all lanes, and a step of all of them.

Vectors are flat: number m of lane l is at m * WIDTH + l.
"""

from functools import cache
from typing import Any, NamedTuple

import numpy as np

from vvdp.generator.body import Body
from vvdp.generator.kinds import FLOAT, INT, Intrinsic, Row
from vvdp.generator.unit import intrinsic_word
from vvdp.numerics.tableaus import TSIT5_C
from vvdp.simulation.lane_code import host_width
from vvdp.simulation.steps import TSIT5_ERROR, TSIT5_ROWS

VECTOR = Row(FLOAT, (None,))
WIDTH = host_width()
W1, W2, W3, W4, W5, W6 = (TSIT5_ROWS[i][:i] for i in range(1, 7))

# What a lane knows of its case besides the clock: where its step ends, whether that is a stop, how often it was tried
# for one event, the step to try again, whether it is aimed at an event or ends on one, when it must stop and sample,
# what has become of the step, for how many steps it has been at the edge of its stability, its error, and
# the step of the try before.
T_NEW, LAST_STEP, TRIED, AGAIN, AIMS, EVENT, T_STOP, T_DUE, VERDICT, EDGE, SIZE, STEP_TRIED = range(12)
OWN = 12
IDLE, TAKEN, TO_REPEAT, LOST = 0.0, 1.0, 2.0, 3.0


class Rules(NamedTuple):
    """Values that hold for all cases."""

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


def call(place, t, y, u, p, s, result):
    """Calls the code for all lanes (`lane_code`) at the address `place`."""
    raise NotImplementedError("only compiled code can call an address")


CALL = Intrinsic(
    name="vvdp_call_lanes",
    arguments=(INT, *[VECTOR] * 6),
    text="""\
define internal void @vvdp_call_lanes(i64 %place, ptr %t, i64 %0, ptr %y, i64 %1, ptr %u, i64 %2, ptr %p, i64 %3,
                                      ptr %s, i64 %4, ptr %result, i64 %5) alwaysinline nounwind {
  %code = inttoptr i64 %place to ptr
  call void %code(ptr %t, ptr %y, ptr %u, ptr %p, ptr %s, ptr %result)
  ret void
}""",
    plain=call,
    result=None,
    is_pure=False,
)


def combine(result, place, y, h, weights, stages):
    """Writes y + h * (weights[0] * stages[0] + ...) for all lanes of the number that begins at `place`.

    As a loop it would not become vector code: the compiler cannot know that no two of so many arrays overlap.
    """
    lanes = slice(place, place + WIDTH)
    total = weights[0] * stages[0][lanes]
    for weight, stage in zip(weights[1:], stages[1:], strict=True):
        total = total + weight * stage[lanes]
    result[lanes] = y[lanes] + h * total


def combine_word(body: Body, *values: Any) -> Any:
    """`combine` of these arguments, written in place."""
    *arrays, weights, stages = values
    return intrinsic_word(body.unit, _combination(len(weights)))(body, *arrays, *weights, *stages)


@cache
def _combination(count: int) -> Intrinsic:
    """The sum over so many stages as vector instructions."""
    vector = f"<{WIDTH} x double>"
    name = f"vvdp_combine_{count}"
    rows = ["result", "y", "h", *(f"k{i}" for i in range(count))]
    arguments = ["ptr %result, i64 %n.result", "i64 %place", "ptr %y, i64 %n.y", "ptr %h, i64 %n.h"]
    arguments += [f"double %w{i}" for i in range(count)] + [f"ptr %k{i}, i64 %n.k{i}" for i in range(count)]
    lines = [f"  %at.{row} = getelementptr double, ptr %{row}, i64 %place" for row in rows if row != "h"]
    lines += [f"  %v.{row} = load {vector}, ptr %at.{row}, align 8" for row in rows if row not in ("result", "h")]
    lines += [f"  %v.h = load {vector}, ptr %h, align 8"]
    for i in range(count):
        lines += [f"  %one.{i} = insertelement {vector} poison, double %w{i}, i32 0"]
        lines += [f"  %all.{i} = shufflevector {vector} %one.{i}, {vector} poison, <{WIDTH} x i32> zeroinitializer"]
        lines += [f"  %part.{i} = fmul {vector} %all.{i}, %v.k{i}"]
    for i in range(1, count):
        before = "%part.0" if i == 1 else f"%sum.{i - 1}"
        lines += [f"  %sum.{i} = fadd {vector} {before}, %part.{i}"]
    total = "%part.0" if count == 1 else f"%sum.{count - 1}"
    lines += [f"  %way = fmul {vector} %v.h, {total}", f"  %moved = fadd {vector} %v.y, %way"]
    lines += [f"  store {vector} %moved, ptr %at.result, align 8", "  ret void"]
    head = f"define internal void @{name}({', '.join(arguments)}) alwaysinline nounwind {{"
    return Intrinsic(
        name=name,
        arguments=(VECTOR, INT, VECTOR, VECTOR, *[FLOAT] * count, *[VECTOR] * count),
        text="\n".join([head, *lines, "}"]),
        plain=lambda result, place, y, h, *rest: combine(result, place, y, h, rest[:count], rest[count:]),
        result=None,
        is_pure=False,
    )


def gather(row, vectors, lane):
    """The numbers of one lane."""
    for m in range(row.size):
        row[m] = vectors[m * WIDTH + lane]


def scatter(vectors, lane, row):
    """Writes the numbers of one lane."""
    for m in range(row.size):
        vectors[m * WIDTH + lane] = row[m]


def tell(signals, cases, lanes):
    """Calculates the signals that move, each lane's at the time of its stage."""
    for lane in range(WIDTH):
        case = lanes.case[lane]
        if case >= 0 and cases.moving[case]:
            signals(lanes.stage[lane], cases.params[case], lanes.values)
            scatter(lanes.s, lane, lanes.values)


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


def sweep(rates, signals, cases, lanes, y, trial, first, last):
    """An explicit step of each lane as in `steps.explicit_step`; leaves the error, and what reports stiffness."""
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
