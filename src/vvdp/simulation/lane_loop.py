"""The compiled loop for many cases at once: as many as a vector of the processor has numbers, each in a lane.

Each lane has a time, a step and events of its own; only the stages of the explicit method are worked out for all at
once. What happens seldom (the search for an event, samples, modes, marks) is done lane by lane with what the loop for
one case is made of. A lane whose case ends takes the next from a queue. No lane reads what is another's, so a case
ends with the same bits in any company.

Vectors are flat: number m of lane l is at m * WIDTH + l.
"""

from typing import Any, NamedTuple

import numpy as np
from llvmlite import ir
from numba import extending, float64, int64, njit, types
from numba.core import cgutils
from numba.np.arrayobj import make_array

from vvdp.numerics.tableaus import TSIT5_C
from vvdp.simulation.lane_code import host_width
from vvdp.simulation.landing import follow, hold, is_left, lateness, positions, settle
from vvdp.simulation.loop import (
    BENCH,
    CUBE,
    EVENT_LIST,
    INTS,
    MANY,
    MATRIX,
    RATES,
    SAMPLE,
    STIFF_FROM,
    STOP,
    TRIES,
    VECTOR,
    first_change,
)
from vvdp.simulation.marks import pass_marks
from vvdp.simulation.pace import grow, next_step, note_event, note_jump, refuse
from vvdp.simulation.places import (
    AIMED,
    BARE,
    BEGUN,
    DONE,
    EVALUATIONS,
    HAIR,
    HANDED,
    HASTY,
    LANDED,
    MARK_BEFORE,
    PERIOD,
    REFUSED,
    REJECTED,
    STEP,
    STEP_BEFORE,
    STEPS,
    TIME,
)
from vvdp.simulation.schedule import begin, instant, next_due
from vvdp.simulation.steps import TSIT5_ERROR, TSIT5_ROWS, copy, turning_value

intrinsic: Any = extending.intrinsic
WIDTH = host_width()
W1, W2, W3, W4, W5, W6 = (TSIT5_ROWS[i][:i] for i in range(1, 7))

# What a lane knows of its case besides the clock: where its step ends, whether that is a stop, how often it was tried
# for one event, the step to try again, whether it is aimed at an event or ends on one, when it must stop and sample,
# what has become of the step, for how many steps it has been at the edge of its stability, and its error.
T_NEW, LAST_STEP, TRIED, AGAIN, AIMS, EVENT, T_STOP, T_DUE, VERDICT, EDGE, SIZE = range(11)
OWN = 11
IDLE, TAKEN, TO_REPEAT, LOST = 0.0, 1.0, 2.0, 3.0

# A case that is at the edge of stability for so many steps, less those that are not, is stiff for good.
STIFF_FOR_GOOD = 2000.0


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
    t_end: Any
    longest: Any
    marks_from: Any
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
    own: Any  # (WIDTH, OWN)
    before: Any  # (WIDTH, positions), as the next two
    reached: Any
    held: Any
    case: Any  # (WIDTH,), -1 where there is none



CASES = types.NamedTuple(
    [MATRIX] * 4 + [CUBE, float64[:, :, :, ::1], MATRIX, CUBE, MATRIX, CUBE, MATRIX, MATRIX, INTS, INTS], Cases
)
RULES = types.NamedTuple([MATRIX] + [VECTOR] * 4 + [float64] * 4, Rules)
LANES = types.NamedTuple([VECTOR] * 8 + [MATRIX] + [VECTOR] * 9 + [MATRIX] * 4 + [INTS], Lanes)
SIGNALS = types.FunctionType(types.void(float64, VECTOR, VECTOR))


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
def take(typing, queue):
    """The first number of `queue`, which is one more afterwards, whoever else takes one at the same time."""

    def generate(context, builder, signature, arguments):
        place = make_array(signature.args[0])(context, builder, arguments[0]).data
        return builder.atomic_rmw("add", place, ir.Constant(ir.IntType(64), 1), "monotonic")

    return types.int64(queue), generate


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


@njit(**BARE, inline="always")
def aim(cases, rules, lanes):
    """Chooses the step of each lane."""
    end = rules.t_end + HAIR * abs(rules.t_end)
    for lane in range(WIDTH):
        case, own = lanes.case[lane], lanes.own[lane]
        own[VERDICT] = IDLE
        if case < 0:
            continue
        clock = cases.clocks[case]
        t = clock[TIME]
        t_next = min(own[T_STOP], own[T_DUE] if own[T_DUE] <= end else rules.t_end)
        if own[TRIED] == 0.0:
            step, aimed = next_step(clock, cases.course[case], lanes.before[lane], lanes.held[lane], rules.grain)
            own[AIMS] = 1.0 if aimed else 0.0
        else:
            step, own[AIMS] = own[AGAIN], 0.0
        last = t + step * (1.0 + 1e-9) >= t_next
        own[LAST_STEP] = 1.0 if last else 0.0
        lanes.time[lane] = t
        lanes.h[lane] = t_next - t if last else step
        own[T_NEW] = t_next if last else t + step


@njit(**BARE)
def is_late(rates, events, cases, rules, lanes, bench, y, trial, first, last, lane):
    """Whether a step over an event must be taken again to end nearer behind it; then with which step."""
    case, own, before, x, held = lanes.case[lane], lanes.own[lane], bench.before, bench.x, bench.held
    clock, step = cases.clocks[case], lanes.h[lane]
    for i in range(x.size):
        before[i], x[i], held[i] = lanes.before[lane, i], lanes.reached[lane, i], lanes.held[lane, i]
        bench.grain[i] = rules.grain[i]
    late, near = lateness(before, x, held, rules.grain, rules.width, step, max(clock[STEP], step))
    if late <= 1.0:
        return False
    cube(cases, lanes, bench, y, trial, first, last, lane)
    s, sure, evaluations = first_change(
        rates, events, lanes.time[lane], step, cases.y[case], cases.command[case], cases.params[case],
        0.2 * near if own[TRIED] > 0.0 else max(0.2 * near, 1e-5), bench,
    )  # fmt: skip
    clock[EVALUATIONS] += evaluations
    if 1.0 - sure <= near:
        return False
    own[AGAIN] = step * min(s + 0.5 * near, 1.0 - 0.1 * near)
    return True


@njit(**BARE)
def cube(cases, lanes, bench, y, trial, first, last, lane):
    """Gathers what the cubic of a lane's step takes."""
    gather(cases.y[lanes.case[lane]], y, lane)
    gather(bench.trial, trial, lane)
    gather(bench.k[0], lanes.k[first], lane)
    gather(bench.k[6], lanes.k[last], lane)


@njit(**BARE, inline="always")
def judge(rates, events, cases, rules, lanes, bench, y, trial, first, last, lane):
    """What becomes of a lane's step; stores the marks that it passes."""
    case, own = lanes.case[lane], lanes.own[lane]
    clock, active = cases.clocks[case], lanes.error.size // WIDTH
    clock[EVALUATIONS] += 6.0
    clock[STEPS] += 1.0
    step, t_new = lanes.h[lane], own[T_NEW]
    total = lanes.error[lanes.error.size - WIDTH + lane]
    size = own[SIZE] = np.sqrt(total / active)
    if not size <= 1.0:
        own[TRIED] = 0.0
        h = refuse(clock, step, size, total < np.inf, -0.2)
        return LOST if h < 1e-14 * max(abs(clock[TIME]), rules.plan[0, PERIOD]) else TO_REPEAT
    reached = lanes.reached[lane]
    gather(reached, lanes.x, lane)
    event = is_left(reached, lanes.held[lane], rules.grain)
    own[EVENT] = 1.0 if event else 0.0
    if (
        event
        and step > 4.0 * HAIR * abs(t_new)
        and own[TRIED] < TRIES
        and is_late(rates, events, cases, rules, lanes, bench, y, trial, first, last, lane)
    ):
        own[TRIED] += 1.0
        clock[REJECTED] += 1.0
        return TO_REPEAT
    if np.floor(reached[0]) != np.floor(clock[MARK_BEFORE]):
        cube(cases, lanes, bench, y, trial, first, last, lane)
        pass_marks(
            events, clock, clock[TIME], step, cases.y[case], cases.command[case], cases.params[case], bench.trial,
            bench.k, bench.middle, bench.g, reached[0], rules.marks_from, cases.mark_times[case],
            cases.mark_states[case],
        )  # fmt: skip
    clock[MARK_BEFORE] = reached[0]
    return TAKEN


@njit(**BARE, inline="always")
def widen_all(lanes, y_before, y, k_before, k):
    """Takes the steps into the extremes; a lane that repeats its step has the same state and rates before and after."""
    low, high, product = lanes.low, lanes.high, lanes.error
    for i in range(low.size):
        low[i] = min(low[i], y[i])
        high[i] = max(high[i], y[i])
        product[i] = k_before[i] * k[i]
    for i in range(low.size):
        if product[i] < 0.0:
            h = lanes.h[i % WIDTH]
            turn = turning_value(y_before[i], y[i], h * k_before[i], h * k[i])
            low[i] = min(low[i], turn)
            high[i] = max(high[i], turn)


@njit(**BARE, inline="always")
def go_on(cases, rules, lanes, lane):
    """Brings clock and course of a lane to the end of its step; whether something is due there."""
    case, own = lanes.case[lane], lanes.own[lane]
    clock, reached, step = cases.clocks[case], lanes.reached[lane], lanes.h[lane]
    at = lanes.error.size - WIDTH + lane
    note_jump(clock, own[T_NEW])
    follow(cases.course[case], lanes.before[lane], reached, step, clock[STEP_BEFORE])
    clock[STEP_BEFORE] = step
    clock[TIME] = own[T_NEW]
    landed = own[LAST_STEP] > 0.0 or own[EVENT] > 0.0
    cut = landed or step < clock[STEP]
    clock[STEP] = grow(clock, own[SIZE], step, clock[STEP], -0.2, cut, rules.longest)
    if lanes.turned[at] > STIFF_FROM**2 * lanes.lean[at]:
        own[EDGE] += 1.0
    elif not cut:
        own[EDGE] = max(0.0, own[EDGE] - 1.0)
    clock[REFUSED], own[TRIED] = 0.0, 0.0
    clock[LANDED] = 1.0 if landed else 0.0
    clock[AIMED] = 1.0 if own[AIMS] > 0.0 and own[EVENT] == 0.0 else 0.0
    copy(lanes.before[lane], reached)
    return landed


@njit(**BARE)
def land(rates, sample, events, stop, cases, rules, lanes, bench, lane):
    """All that happens at the instant that a lane has reached, its state in its row. False where its case is lost."""
    case, own = lanes.case[lane], lanes.own[lane]
    y, u, m, p = cases.y[case], cases.command[case], cases.memory[case], cases.params[case]
    clock, agenda, course = cases.clocks[case], cases.agenda[case], cases.course[case]
    t, g, held = clock[TIME], bench.g, lanes.held[lane]
    if clock[BEGUN] == 0.0:
        clock[BEGUN], clock[LANDED] = 1.0, 1.0
        events(t, y, u, p, g)
        clock[MARK_BEFORE] = g[0]
        if not begin(sample, events, t, y, u, m, p, rules.plan, agenda, cases.waiting[case], g):
            return False
    else:
        if own[EVENT] > 0.0:
            note_event(clock, t)
        events(t, y, u, p, g)
        if not instant(sample, events, t, y, u, m, p, rules.plan, agenda, cases.waiting[case], g):
            return False
    rate = bench.k[0]
    if settle(rates, t, y, u, p, rules.plan, rate) >= 0 or clock[HASTY] > MANY:
        return False
    positions(events, t, y, u, p, rate, lanes.before[lane])
    hold(rules.plan, agenda, u, course, held)
    own[T_STOP], own[T_DUE] = stop(t, u, p), next_due(rules.plan, agenda)
    return own[T_STOP] > t


@njit(**BARE)
def load(rates, sample, events, stop, signals, cases, rules, lanes, bench, queue, y, first, lane):
    """Puts the next case that can begin into a lane; False where none is left, and the lane then rests."""
    n, active, own, held = cases.y.shape[1], lanes.low.size // WIDTH, lanes.own[lane], lanes.held[lane]
    while True:
        case = take(queue)
        if case >= cases.status.size:
            lanes.case[lane], lanes.h[lane] = -1, 0.0
            return False
        lanes.case[lane] = case
        for i in range(OWN):
            own[i] = 0.0
        for i in range(held.size):
            held[i] = 0.0
        clock, start = cases.clocks[case], cases.y[case]
        if clock[TIME] < rules.t_end and land(rates, sample, events, stop, cases, rules, lanes, bench, lane):
            break
        cases.status[case] = HANDED
    scatter(y, lane, start)
    scatter(lanes.low, lane, start[:active])
    scatter(lanes.high, lane, start[:active])
    for m in range(n):
        cases.low[case, m] = cases.high[case, m] = start[m]
    scatter(lanes.p, lane, cases.params[case, : lanes.p.size // WIDTH])
    scatter(lanes.u, lane, cases.command[case])
    scatter(lanes.k[first], lane, bench.k[0])
    signals(clock[TIME], cases.params[case], lanes.values)
    scatter(lanes.s, lane, lanes.values)
    return True


@njit(**BARE, inline="always")
def unload(cases, lanes, status, lane):
    """Keeps what a case has come to, its state in its row already."""
    case, active = lanes.case[lane], lanes.low.size // WIDTH
    gather(cases.low[case, :active], lanes.low, lane)
    gather(cases.high[case, :active], lanes.high, lane)
    cases.status[case] = status


@njit(**BARE, inline="always")
def put_back(lanes, y, y_before, k, k_before, lane):
    """Leaves a lane where it was before its step."""
    for i in range(lane, y.size, WIDTH):
        y[i] = y_before[i]
    for i in range(lane, k.size, WIDTH):
        k[i] = k_before[i]


RUN_LANES = types.void(
    int64, int64, SIGNALS, RATES, SAMPLE, EVENT_LIST, STOP, CASES, RULES, LANES, BENCH, INTS
)  # fmt: skip


@njit(RUN_LANES, **BARE, nogil=True)
def run_lanes(all_rates, all_events, signals, rates, sample, events, stop, cases, rules, lanes, bench, queue):
    """Carries cases from the queue to `t_end`, each in a lane; `status` says which are to be run by themselves.

    all_rates, all_events  addresses of the code for all lanes
    queue                  the number of the next case, shared with others who do the same with lanes of their own
    """
    y, trial, first, last, live = lanes.y, lanes.trial, 0, 6, 0
    modes = bench.rate.size - cases.y.shape[1]
    end = rules.t_end - HAIR * abs(rules.t_end)
    for lane in range(WIDTH):
        live += load(rates, sample, events, stop, signals, cases, rules, lanes, bench, queue, y, first, lane)
    while live > 0:
        aim(cases, rules, lanes)
        sweep(all_rates, signals, cases, lanes, y, trial, first, last)
        norms(rules, lanes, y, trial)
        for lane in range(WIDTH):
            lanes.stage[lane] = lanes.own[lane, T_NEW]
        tell(signals, cases, lanes)
        call(all_events, lanes.stage, trial, lanes.u, lanes.p, lanes.s, lanes.x)
        behind = lanes.x.size - modes * WIDTH
        for i in range(modes * WIDTH):
            lanes.x[behind + i] = lanes.k[last, y.size + i]
        for lane in range(WIDTH):
            if lanes.case[lane] >= 0:
                lanes.own[lane, VERDICT] = judge(
                    rates, events, cases, rules, lanes, bench, y, trial, first, last, lane
                )
        y, trial = trial, y
        first, last = last, first
        for lane in range(WIDTH):
            if lanes.own[lane, VERDICT] != TAKEN:
                put_back(lanes, y, trial, lanes.k[first], lanes.k[last], lane)
        widen_all(lanes, trial, y, lanes.k[last], lanes.k[first])
        for lane in range(WIDTH):
            case, verdict = lanes.case[lane], lanes.own[lane, VERDICT]
            if verdict == IDLE or verdict == TO_REPEAT:
                continue
            ended = False
            if verdict == TAKEN:
                landed = go_on(cases, rules, lanes, lane)
                ended = cases.clocks[case, TIME] >= end
                if landed or ended:
                    gather(cases.y[case], y, lane)
                if landed:
                    if not land(rates, sample, events, stop, cases, rules, lanes, bench, lane):
                        verdict = LOST
                    scatter(lanes.u, lane, cases.command[case])
                    scatter(lanes.k[first], lane, bench.k[0])
                if lanes.own[lane, EDGE] > rules.stiff_from:
                    verdict = LOST
            if ended or verdict == LOST:
                unload(cases, lanes, HANDED if verdict == LOST else DONE, lane)
                live -= 1
                live += load(rates, sample, events, stop, signals, cases, rules, lanes, bench, queue, y, first, lane)
