"""The compiled loop for many cases at once: as many as a vector of the processor has numbers, each in a lane.

Each lane has a time, a step and events of its own; only the stages of the explicit method are calculated for all at
once. What happens seldom (the search for an event, samples, modes, marks) is done lane by lane with what the loop for
one case is made of. A lane whose case ends takes the next from a queue. No lane reads what is another's, so a case
ends with the same bits in any company.
"""

import numpy as np

from vvdp.generator.kinds import FLOAT, INT, Address, Record
from vvdp.simulation.case_rows import CaseRows
from vvdp.simulation.landing import arc, follow, forget, has_left, hold, is_left, lateness, positions, secant, settle
from vvdp.simulation.lane_vectors import (
    AGAIN,
    AIMS,
    EDGE,
    EVENT,
    IDLE,
    LAST_STEP,
    LOST,
    OWN,
    SIZE,
    STEP_TRIED,
    T_DUE,
    T_NEW,
    T_STOP,
    TAKEN,
    TO_REPEAT,
    TRIED,
    VERDICT,
    WIDTH,
    Lanes,
    Rules,
    call,
    gather,
    norms,
    scatter,
    sweep,
    tell,
)
from vvdp.simulation.loop import (
    BENCH,
    CUBE,
    EVENT_LIST,
    INTS,
    MANY,
    MATRIX,
    RATES,
    SAMPLE,
    STOP,
    TESSERACT,
    TRIES,
    VECTOR,
    first_change,
)
from vvdp.simulation.marks import begin_spans, pass_marks
from vvdp.simulation.pace import STIFF_FROM, grow, next_step, note_event, note_jump, refuse
from vvdp.simulation.places import (
    AIMED,
    BEGUN,
    DONE,
    EVALUATIONS,
    HAIR,
    HALT,
    HANDED,
    HASTY,
    LANDED,
    MARK_BEFORE,
    PAUSED,
    PERIOD,
    REFUSED,
    REJECTED,
    STEP,
    STEP_BEFORE,
    STEPS,
    TIME,
)
from vvdp.simulation.queue import take
from vvdp.simulation.schedule import begin, instant, landing_time, next_due
from vvdp.simulation.steps import below, copy, turning_value

# A case that is at the edge of stability for so many steps, less those that are not, is stiff for good.
STIFF_FOR_GOOD = 2000.0

# For so many tries an event is looked for with the ends of the tries alone, which costs a lane no rates.
QUICK = 6.0


CASES = Record(CaseRows, (*[MATRIX] * 4, CUBE, TESSERACT, MATRIX, CUBE, MATRIX, CUBE, CUBE, MATRIX, MATRIX, INTS, INTS))
RULES = Record(Rules, (MATRIX, *[VECTOR] * 5, *[FLOAT] * 3, VECTOR, INTS, FLOAT))
LANES = Record(Lanes, (*[VECTOR] * 8, MATRIX, *[VECTOR] * 10, *[MATRIX] * 5, INTS))
SIGNALS = Address((FLOAT, VECTOR, VECTOR), None)


def aim(cases, rules, lanes):
    """Chooses the step of each lane."""
    for lane in range(WIDTH):
        case, own = lanes.case[lane], lanes.own[lane]
        own[VERDICT] = IDLE
        if case < 0:
            continue
        clock = cases.clock[case]
        t = clock[TIME]
        t_next = landing_time(own[T_STOP], own[T_DUE], rules.t_end)
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


def is_late(rates, events, cases, rules, lanes, bench, y, trial, first, last, lane):
    """Whether a step over an event must be taken again to end nearer behind it; then with which step."""
    case, own, before, x, held = lanes.case[lane], lanes.own[lane], bench.before, bench.x, bench.held
    clock, step = cases.clock[case], lanes.h[lane]
    for i in range(x.size):
        before[i], x[i], held[i] = lanes.before[lane, i], lanes.reached[lane, i], lanes.held[lane, i]
        bench.grain[i] = rules.grain[i]
    late, near = lateness(before, x, held, rules.grain, rules.width, own[T_NEW], step, max(clock[STEP], step))
    if late <= 1.0:
        return False
    s = 1.0
    for i in range(1, x.size):
        if own[TRIED] < QUICK and has_left(x[i], held[i], rules.grain[i]):
            if own[TRIED] == 0.0:
                found = arc(cases.course[case], i, before[i], x[i], held[i], rules.grain[i], step, clock[STEP_BEFORE])
            else:
                found = secant(lanes.tried[lane, i], x[i], held[i], rules.grain[i], own[STEP_TRIED] / step)
            s = min(s, found)
    if 0.0 < s < 1.0:
        copy(lanes.tried[lane], x)
        own[STEP_TRIED], own[AGAIN] = step, step * min(s + 0.5 * near, 1.0 - 0.1 * near)
        return 1.0 - s > near
    cube(cases, lanes, bench, y, trial, first, last, lane)
    s, sure, evaluations = first_change(
        rates, events, lanes.time[lane], step, cases.state[case], cases.command[case], cases.params[case],
        0.2 * near if own[TRIED] > 0.0 else max(0.2 * near, 1e-3), bench,
    )  # fmt: skip
    clock[EVALUATIONS] += evaluations
    if 1.0 - sure <= near:
        return False
    own[AGAIN] = step * min(s + 0.5 * near, 1.0 - 0.1 * near)
    return True


def cube(cases, lanes, bench, y, trial, first, last, lane):
    """Gathers what the cubic of a lane's step takes."""
    gather(cases.state[lanes.case[lane]], y, lane)
    gather(bench.trial, trial, lane)
    gather(bench.k[0], lanes.k[first], lane)
    gather(bench.k[6], lanes.k[last], lane)


def judge(rates, events, cases, rules, lanes, bench, y, trial, first, last, lane):
    """Verdict on a lane's step, which is accepted or refused; stores the marks that it passes."""
    case, own = lanes.case[lane], lanes.own[lane]
    clock, active = cases.clock[case], lanes.error.size // WIDTH
    clock[EVALUATIONS] += 6.0
    clock[STEPS] += 1.0
    step, t_new = lanes.h[lane], own[T_NEW]
    total = lanes.error[lanes.error.size - WIDTH + lane]
    size = own[SIZE] = np.sqrt(total / max(active, 1))
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
            events, clock, clock[TIME], step, cases.state[case], cases.command[case], cases.params[case], bench.trial,
            bench.k, bench.middle, bench.g, reached[0], rules.marks_from, cases.mark_times[case],
            cases.mark_states[case],
        )  # fmt: skip
    clock[MARK_BEFORE] = reached[0]
    return TAKEN


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


def go_on(cases, rules, lanes, lane):
    """Brings clock and course of a lane to the end of its step; whether something is due there."""
    case, own = lanes.case[lane], lanes.own[lane]
    clock, reached, step = cases.clock[case], lanes.reached[lane], lanes.h[lane]
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


def land(rates, sample, events, stop, cases, rules, lanes, bench, lane):
    """All that happens at the instant that a lane has reached, its state in its row.

    What has become of it: lost, with new rates in the workbench, or with the rates that it had.
    """
    case, own = lanes.case[lane], lanes.own[lane]
    y, u, m, p = cases.state[case], cases.command[case], cases.memory[case], cases.params[case]
    clock, agenda, course = cases.clock[case], cases.agenda[case], cases.course[case]
    t, g, held, same = clock[TIME], bench.g, lanes.held[lane], False
    if below(y, rules.floor, rules.floor.size) >= 0:
        return LOST
    if clock[BEGUN] == 0.0:
        clock[BEGUN], clock[LANDED] = 1.0, 1.0
        settle(rates, t, y, u, p, rules.plan, bench.k[0])
        events(t, y, u, p, g)
        clock[MARK_BEFORE] = g[0]
        if not begin(sample, events, t, y, u, m, p, rules.plan, agenda, cases.waiting[case], g):
            return LOST
    else:
        for i in range(rules.reads.size):
            lanes.command[i] = u[rules.reads[i]]
        if own[EVENT] > 0.0:
            note_event(clock, t)
        events(t, y, u, p, g)
        if not instant(sample, events, t, y, u, m, p, rules.plan, agenda, cases.waiting[case], g):
            return LOST
        same = own[EVENT] == 0.0 and t < own[T_STOP]
        for i in range(rules.reads.size):
            same = same and lanes.command[i] == u[rules.reads[i]]
    if not same:
        rate = bench.k[0]
        if settle(rates, t, y, u, p, rules.plan, rate) >= 0 or clock[HASTY] > MANY:
            return LOST
        positions(events, t, y, u, p, rate, lanes.before[lane])
    copy(g, held)
    hold(rules.plan, agenda, u, held)
    forget(course, held, g)
    t_span = begin_spans(clock, t, y, rules.span_times, cases.span_states[case])
    own[T_STOP], own[T_DUE] = stop(t, u, p), min(next_due(rules.plan, agenda), t_span)
    return LOST if not own[T_STOP] > t else IDLE if same else TAKEN


def load(rates, sample, events, stop, signals, cases, rules, lanes, bench, queue, y, first, lane):
    """Puts the next case that can begin into a lane; False where none is left, and the lane then rests."""
    n, active, own, held = cases.state.shape[1], lanes.low.size // WIDTH, lanes.own[lane], lanes.held[lane]
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
        clock, start = cases.clock[case], cases.state[case]
        begins = clock[TIME] < rules.t_end
        if begins and land(rates, sample, events, stop, cases, rules, lanes, bench, lane) == TAKEN:
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


def unload(cases, rules, lanes, status, lane):
    """Keeps what a case has come to, its state in its row already; one that fell below a floor is handed over."""
    case, active = lanes.case[lane], lanes.low.size // WIDTH
    gather(cases.low[case, :active], lanes.low, lane)
    gather(cases.high[case, :active], lanes.high, lane)
    fell = below(cases.low[case], rules.floor, rules.floor.size) >= 0
    cases.status[case] = HANDED if fell and status == DONE else status


def put_down(cases, rules, lanes, y):
    """Keeps what all lanes have reached by now."""
    for lane in range(WIDTH):
        if lanes.case[lane] >= 0:
            gather(cases.state[lanes.case[lane]], y, lane)
            unload(cases, rules, lanes, PAUSED, lane)


def put_back(lanes, y, y_before, k, k_before, lane):
    """Leaves a lane where it was before its step."""
    for i in range(lane, y.size, WIDTH):
        y[i] = y_before[i]
    for i in range(lane, k.size, WIDTH):
        k[i] = k_before[i]


RUN_LANES = (INT, INT, SIGNALS, RATES, SAMPLE, EVENT_LIST, STOP, CASES, RULES, LANES, BENCH, INTS)


def run_lanes(all_rates, all_events, signals, rates, sample, events, stop, cases, rules, lanes, bench, queue):
    """Carries cases from the queue to `t_end`, each in a lane; `status` says which are to be run by themselves.

    all_rates, all_events  addresses of the code for all lanes
    queue                  the number of the next case, shared with others who do the same with lanes of their own,
                           and whether to stop: what is in the lanes is then put down as it is
    """
    y, trial, first, last, live = lanes.y, lanes.trial, 0, 6, 0
    modes = bench.rate.size - cases.state.shape[1]
    end = rules.t_end - HAIR * abs(rules.t_end)
    for lane in range(WIDTH):
        live += load(rates, sample, events, stop, signals, cases, rules, lanes, bench, queue, y, first, lane)
    while live > 0:
        if queue[HALT] != 0:
            put_down(cases, rules, lanes, y)
            break
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
                lanes.own[lane, VERDICT] = judge(rates, events, cases, rules, lanes, bench, y, trial, first, last, lane)
        y, trial = trial, y
        first, last = last, first
        for lane in range(WIDTH):
            if lanes.own[lane, VERDICT] != TAKEN:
                put_back(lanes, y, trial, lanes.k[first], lanes.k[last], lane)
        widen_all(lanes, trial, y, lanes.k[last], lanes.k[first])
        for lane in range(WIDTH):
            case, verdict = lanes.case[lane], lanes.own[lane, VERDICT]
            if verdict in (IDLE, TO_REPEAT):
                continue
            ended = False
            if verdict == TAKEN:
                landed = go_on(cases, rules, lanes, lane)
                ended = cases.clock[case, TIME] >= end
                if landed or ended:
                    gather(cases.state[case], y, lane)
                if landed:
                    verdict = land(rates, sample, events, stop, cases, rules, lanes, bench, lane)
                    if verdict == TAKEN:
                        scatter(lanes.u, lane, cases.command[case])
                        scatter(lanes.k[first], lane, bench.k[0])
                if lanes.own[lane, EDGE] > rules.stiff_from:
                    verdict = LOST
            if ended or verdict == LOST:
                unload(cases, rules, lanes, HANDED if verdict == LOST else DONE, lane)
                live -= 1
                live += load(rates, sample, events, stop, signals, cases, rules, lanes, bench, queue, y, first, lane)
