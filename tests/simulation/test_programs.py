"""Programs at their own rates, phases and latencies, and programs that events call: sequences worked out by hand."""

from dataclasses import replace
from typing import Annotated, NamedTuple

import numpy as np
import pytest
from tests.words import wording

from vvdp.base.conservation import NOTHING, Nothing
from vvdp.base.errors import RunError
from vvdp.base.kinds import Fraction, Frequency, Kind, Time
from vvdp.base.params import Params
from vvdp.hydraulics.switching_valve import pulse_stop, pulse_train
from vvdp.simulation.model import Case, Model, Program, initial_case
from vvdp.simulation.run import Method, Stepping, simulate

Plain = Annotated[float, Kind("plain number", "1", -1e9, 1e9, "1")]
METHODS = [Method.EXPLICIT, Method.STIFF, Method.AUTOMATIC]


def stepping(until: float, **others) -> Stepping:
    return Stepping(until=until, **{"record_interval": until / 100, "window_interval": until / 100} | others)


class Sum(NamedTuple):
    x: Plain


# Two programs at different rates, phases and latencies


class Drive(NamedTuple):
    level: Plain


class Chain(NamedTuple):
    fast: Drive
    slow: Drive


class Log(NamedTuple):
    calls: Plain
    times: Annotated[np.ndarray, Kind("plain number", "1", -1e9, 1e9, "1")]
    seen: Annotated[np.ndarray, Kind("plain number", "1", -1e9, 1e9, "1")]


class Seen(NamedTuple):
    fast: Plain
    slow: Plain


def summed(t: float, s: Sum, u: Chain, p: Nothing) -> tuple[Sum, Seen]:
    return Sum(u.fast.level + 100.0 * u.slow.level), Seen(u.fast.level, u.slow.level)


def see_slow(t: float, s: Sum, o: Seen, p: Nothing) -> Seen:
    return Seen(o.fast, o.slow)


def log(t: float, memory: Log, r: Seen, settings: Nothing) -> tuple[Log, Drive]:
    """Keeps when it was called and what it saw of the other; its command is the number of its calls."""
    times, seen, n = memory.times.copy(), memory.seen.copy(), int(memory.calls)
    times[n], seen[n] = t, r.fast + 100.0 * r.slow
    return Log(memory.calls + 1.0, times, seen), Drive(memory.calls + 1.0)


def blank_log(settings: Nothing) -> Log:
    return Log(0.0, np.full(16, -1.0), np.full(16, -1.0))


def logged(until: float, fast: dict, slow: dict, **others):
    program = Program(see_slow, log, Drive(0.0), blank_log)
    model = Model(summed, programs={"fast": replace(program, **fast), "slow": replace(program, **slow)})
    case = replace(initial_case(replace(model, start=at_zero), Chain, Nothing()))
    return simulate(model, case, stepping(until, sample_period=10.0, **others))


def at_zero(params: object) -> Sum:
    return Sum(0.0)


def entries(memory: Log) -> list[tuple[float, float]]:
    n = int(memory.calls)
    return [
        (pytest.approx(float(t), abs=1e-12), float(s)) for t, s in zip(memory.times[:n], memory.seen[:n], strict=True)
    ]


@pytest.mark.parametrize("method", METHODS)
def test_two_programs_with_period_phase_and_latency(method):
    """fast at 0, 0.2, 0.4, 0.6, 0.8; slow at 0.1, 0.4, 0.7, its command 0.25 s later, at 0.35, 0.65 and 0.95.

    fast's command acts at once: k from (k - 1)/5 s on, so that its sum to 1 s is 0.2 (1 + 2 + 3 + 4 + 5) + 6 * 0 = 3.
    At 0.4 fast comes first: it sees its own 2 and slow's first; slow sees fast's third already.
    slow: 100 (1 * 0.3 + 2 * 0.3 + 3 * 0.05) = 105.
    """
    run = logged(0.99, {"period": 0.2}, {"period": 0.3, "phase": 0.1, "latency": 0.25}, method=method)
    memory = run.final_memory
    assert entries(memory["fast"]) == [(0.0, 0.0), (0.2, 1.0), (0.4, 102.0), (0.6, 103.0), (0.8, 204.0)]
    assert entries(memory["slow"]) == [(0.1, 1.0), (0.4, 103.0), (0.7, 204.0)]
    assert run.calls == {"fast": 5, "slow": 3}
    expected = 0.2 * (1 + 2 + 3 + 4) + 0.19 * 5 + 100.0 * (1 * 0.3 + 2 * 0.3 + 3 * 0.04)
    assert run.final[0] == pytest.approx(expected, abs=1e-11)


def test_a_command_due_at_a_sample_acts_before_any_program_is_called():
    """latency = period: slow's first command, of t = 0, acts at 0.2, where both programs see it already."""
    run = logged(0.3, {"period": 0.2}, {"period": 0.2, "latency": 0.2})
    assert entries(run.final_memory["fast"]) == [(0.0, 0.0), (0.2, 101.0)]
    assert entries(run.final_memory["slow"]) == [(0.0, 1.0), (0.2, 102.0)]


def test_samples_of_two_periods_meet_however_they_round():
    """7 periods of 1/7 of 0.03 s and one of 0.03 s are one instant: order holds, and no step is a rounding long."""
    run = logged(0.061, {"period": 0.03}, {"period": 0.03 / 7})
    slow = run.final_memory["slow"]
    # slow is called after fast at 0, 7 and 14, and sees its new command there
    seen = [int(x) % 100 for x in slow.seen[: int(slow.calls)]]
    assert seen == [1] * 7 + [2] * 7 + [3]


def test_sample_times_do_not_drift():
    run = logged(1.5, {"period": 0.1}, {"period": 0.1})
    assert run.final_memory["fast"].times[:16].tolist() == [n * 0.1 for n in range(16)]


# A PWM whose duty ratio a program sets: its edges are landed on


class Train(NamedTuple):
    frequency: Frequency
    duty_ratio: Fraction


class Pwm(NamedTuple):
    valve: Train


class Wished(Params):
    frequency: Frequency
    duty_ratio: Fraction


def pulsed(t: float, s: Sum, u: Pwm, p: Nothing) -> tuple[Sum, Nothing]:
    return Sum(pulse_train(t, u.valve)), Nothing(0.0)


def edge(t: float, u: Pwm, p: Nothing) -> float:
    return pulse_stop(t, u.valve)


def see_nothing(t: float, s: Sum, o: Nothing, p: Nothing) -> Nothing:
    return NOTHING


def set_duty(t: float, memory: Nothing, r: Nothing, settings: Wished) -> tuple[Nothing, Train]:
    return memory, Train(settings.frequency, settings.duty_ratio)


def taken_in(ratio: float, frequency: float, period: float, stop, **others):
    first = Train(frequency, 0.0)
    model = Model(pulsed, programs={"valve": Program(see_nothing, set_duty, first)}, stop=stop)
    settings = Wished(frequency=frequency, duty_ratio=ratio)
    case = Case(Sum(0.0), Nothing(), Pwm(first), {"valve": NOTHING}, {"valve": settings})
    return simulate(model, case, stepping(5.0, sample_period=period, **others))


SLOW = [
    (0.5, 100.0, 0.02),
    (0.25, 100.0, 0.02),
    (0.05, 100.0, 0.02),
    (0.013, 100.0, 1e-2),
    (0.013, 100.0, 1e-3),
    (0.2, 50.0, 0.04),
]


@pytest.mark.parametrize(("ratio", "frequency", "period"), SLOW)
def test_edges_that_a_program_sets_are_landed_on(ratio, frequency, period):
    """Slow system: what is taken in over 5 s is the duty ratio times 5 s, to rounding. Without it: up to 50 % off."""
    run = taken_in(ratio, frequency, period, edge)
    assert run.final[0] == pytest.approx(5.0 * ratio, rel=1e-9)
    assert run.remarks == ()


def never(t: float, u: Pwm, p: Nothing) -> float:
    return np.inf


def test_edges_that_nobody_names_are_found_by_short_steps_only():
    """With steps of a fiftieth of a period no pulse is missed, and what refuses steps in series is remarked."""
    missed = taken_in(0.25, 100.0, 0.02, never)
    assert abs(missed.final[0] / 1.25 - 1.0) > 0.01
    run = taken_in(0.25, 100.0, 0.02, never, longest_step=2e-4, relative_tolerance=1e-8)
    # Of 1000 edges each is passed within about a hundredth of a step, 2 us; were all late, 2 ms of 1.25 s.
    assert run.final[0] == pytest.approx(1.25, abs=2e-3)
    assert run.steps >= 5.0 / 2e-4
    assert len(run.remarks) == 1
    assert wording.simulation.rates_jump + "0." in run.remarks[0] and wording.simulation.no_stop_names in run.remarks[0]


# Events


class Heater(NamedTuple):
    power: Plain


class Relay(NamedTuple):
    relay: Heater


class Switches(NamedTuple):
    power: Plain
    count: Plain
    last: Time


class Limits(Params):
    low: Plain
    high: Plain


def warmed(t: float, s: Sum, u: Relay, p: Limits) -> tuple[Sum, Nothing]:
    return Sum(u.relay.power - s.x), Nothing(0.0)


def between_limits(t: float, s: Sum, u: Relay, p: Limits, settings: object) -> float:
    """0 to 1 between the limits."""
    return (s.x - p.low) / (p.high - p.low)


def see_level(t: float, s: Sum, o: Nothing, p: Limits) -> Sum:
    return Sum(s.x)


def switched(t: float, memory: Switches, r: Sum, limits: Limits) -> tuple[Switches, Heater]:
    middle = 0.5 * (limits.low + limits.high)
    power = 2.0 if r.x < middle else 0.0
    changed = 1.0 if power != memory.power else 0.0
    return Switches(power, memory.count + changed, t if changed else memory.last), Heater(power)


LIMITS = Limits(low=0.5, high=1.25)


def relay_run(until: float, latency: float = 0.0, **others):
    program = Program(see_level, switched, Heater(2.0), trigger=between_limits, latency=latency)
    case = Case(Sum(0.75), LIMITS, Relay(Heater(2.0)), {"relay": Switches(2.0, 0.0, 0.0)}, {"relay": LIMITS})
    return simulate(Model(warmed, programs={"relay": program}), case, stepping(until, sample_period=0.5, **others))


RISE, FALL = np.log(1.5 / 0.75), np.log(1.25 / 0.5)
"""x' = 2 - x from 0.5 to 1.25, and x' = -x back."""


@pytest.mark.parametrize("method", METHODS)
def test_relay_with_hysteresis_switches_at_its_limits(method):
    """x rises from 0.75 to 1.25 in ln(1.25/0.75), then falls and rises in turn: N switches, the last at a known time.

    A switch is where the run's own x crosses, to a share of 1e-12 of the step; x itself has the tolerance, 1e-9.
    """
    run = relay_run(20.0, relative_tolerance=1e-9, method=method)
    times, t = [], np.log(1.25 / 0.75)
    while t < 20.0:
        times.append(t)
        t += FALL if len(times) % 2 else RISE
    memory = run.final_memory["relay"]
    assert memory.count == len(times)
    assert memory.last == pytest.approx(times[-1], abs=1e-7)
    assert run.low[0] == pytest.approx(0.5, abs=1e-9)
    assert run.high[0] == pytest.approx(1.25, abs=1e-9)
    assert run.calls["relay"] <= 2 * len(times)


@pytest.mark.parametrize("method", METHODS)
def test_relay_with_latency_overshoots_by_as_much(method):
    """The command acts 0.1 s after the limit: x goes on to 2 - 0.75 e^-0.1, and down to 0.5 e^-0.1."""
    run = relay_run(20.0, 0.1, relative_tolerance=1e-9, method=method)
    assert run.high[0] == pytest.approx(2.0 - 0.75 * np.exp(-0.1), abs=1e-8)
    assert run.low[0] == pytest.approx(0.5 * np.exp(-0.1), abs=1e-8)


class Ball(NamedTuple):
    height: Plain
    speed: Plain


class Sign(NamedTuple):
    sign: Plain


class Floor(NamedTuple):
    bounce: Sign


class Tally(NamedTuple):
    sign: Plain
    count: Plain
    times: Annotated[np.ndarray, Kind("plain number", "1", -1e9, 1e9, "1")]


def turned(t: float, s: Sum, u: Floor, p: Nothing) -> tuple[Sum, Nothing]:
    return Sum(u.bounce.sign * 3.0), Nothing(0.0)


def whole(t: float, s: Sum, u: Floor, p: Nothing, settings: object) -> float:
    return s.x


def see_sum(t: float, s: Sum, o: Nothing, p: Nothing) -> Sum:
    return Sum(s.x)


def tallied(t: float, memory: Tally, r: Sum, settings: Nothing) -> tuple[Tally, Sign]:
    times = memory.times.copy()
    times[int(memory.count)] = t
    return Tally(memory.sign, memory.count + 1.0, times), Sign(memory.sign)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_many_events_in_one_step_come_one_by_one(sign):
    """x = 0.5 + 3 t passes n at (n - 0.5)/3, and -3 t the same: each once, in order, whatever the steps would be."""
    program = Program(see_sum, tallied, Sign(sign), trigger=whole)
    case = Case(Sum(0.5), Nothing(), Floor(Sign(sign)), {"bounce": Tally(sign, 0.0, np.zeros(32))}, {"bounce": NOTHING})
    run = simulate(Model(turned, programs={"bounce": program}), case, stepping(10.0, sample_period=10.0))
    memory = run.final_memory["bounce"]
    assert memory.count == 30
    assert memory.times[:30] == pytest.approx((np.arange(30) + 0.5) / 3.0, abs=1e-10)
    assert run.steps < 250


# One program hears another's command


class Mode(NamedTuple):
    mode: Plain


class Modes(NamedTuple):
    chief: Mode
    helper: Mode


class Calls(NamedTuple):
    count: Plain
    last: Time


def still(t: float, s: Sum, u: Modes, p: Nothing) -> tuple[Sum, Nothing]:
    return Sum(1.0), Nothing(0.0)


def chief_mode(t: float, s: Sum, u: Modes, p: Nothing, settings: object) -> float:
    return u.chief.mode


def chief_step(t: float, m: Calls, r: Sum, settings: Nothing) -> tuple[Calls, Mode]:
    return Calls(m.count + 1.0, t), Mode(np.floor(t / 0.25))


def helper_step(t: float, m: Calls, r: Sum, settings: Nothing) -> tuple[Calls, Mode]:
    return Calls(m.count + 1.0, t), Mode(m.count + 1.0)


def test_a_program_is_called_where_anothers_command_trips_its_trigger():
    """The chief counts quarters of a second in steps of 0.1 s; the helper hears 0.3, 0.5 and 0.8 s, at that instant."""
    chief = Program(see_sum, chief_step, Mode(0.0), period=0.1)
    helper = Program(see_sum, helper_step, Mode(0.0), trigger=chief_mode)
    memory = {"chief": Calls(0.0, 0.0), "helper": Calls(0.0, 0.0)}
    case = Case(Sum(0.0), Nothing(), Modes(Mode(0.0), Mode(0.0)), memory, {"chief": NOTHING, "helper": NOTHING})
    for programs in ({"chief": chief, "helper": helper}, {"helper": helper, "chief": chief}):
        ordered = replace(case, memory={n: memory[n] for n in programs}, settings=dict.fromkeys(programs, NOTHING))
        run = simulate(Model(still, programs=programs), ordered, stepping(0.95, sample_period=1.0))
        assert run.calls["helper"] == 3
        assert run.final_memory["helper"].last == pytest.approx(0.8)


def test_commands_that_pile_up_are_refused():
    program = Program(see_sum, tallied, Sign(1.0), trigger=whole, latency=20.0)
    case = Case(Sum(0.5), Nothing(), Floor(Sign(1.0)), {"bounce": Tally(1.0, 0.0, np.zeros(32))}, {"bounce": NOTHING})
    with pytest.raises(RunError, match=wording.simulation.too_many_commands.format(count=16)):
        simulate(Model(turned, programs={"bounce": program}), case, stepping(10.0, sample_period=10.0))


# Going on


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("at", [0.5, 3.0, 10.0])
def test_a_run_that_goes_on_is_the_unbroken_run_to_the_last_bit(at, method):
    """Event counts, waiting commands and the choice of method are carried over; the break is at a sample."""
    whole_run = relay_run(20.0, 0.1, method=method)
    first = relay_run(at, 0.1, method=method)
    second = simulate(first.model, first.case, replace(whole_run.stepping), continue_from=first)
    assert second.stepping.begin == at
    assert np.array_equal(second.final, whole_run.final)
    assert second.end == whole_run.end
    assert second.final_memory == whole_run.final_memory
    assert first.steps + second.steps == whole_run.steps
    assert first.evaluations + second.evaluations == pytest.approx(whole_run.evaluations, abs=1)  # they count by halves
    later = whole_run.times > at + 1e-9
    rows = second.times > at + 1e-9
    assert np.array_equal(second.states[rows], whole_run.states[later])
    assert np.array_equal(second.commands[rows], whole_run.commands[later])
    assert min(first.low[0], second.low[0]) == whole_run.low[0]
    assert second.calls["relay"] + first.calls["relay"] == whole_run.calls["relay"]


def test_a_run_goes_on_with_other_parameters():
    """Start-up, then normal: the same circuit, whose relay has other limits from 5 s on."""
    first = relay_run(5.0)
    limits = Limits(low=0.9, high=1.1)
    second = simulate(
        first.model,
        replace(first.case, params=limits, settings={"relay": limits}),
        stepping(20.0, sample_period=0.5),
        continue_from=first,
    )
    assert second.times[0] == 5.0
    assert second.states[second.times > 8.0, 0].max() == pytest.approx(1.1, abs=0.05)
    assert second.states[second.times > 8.0, 0].min() == pytest.approx(0.9, abs=0.05)


def test_a_run_may_begin_later():
    """Samples are at the multiples of the period from `begin` on."""
    run = logged(1.0, {"period": 0.3, "phase": 0.1}, {"period": 0.2}, begin=0.45)
    assert entries(run.final_memory["fast"])[0][0] == 0.7
    assert entries(run.final_memory["slow"])[0][0] == 0.6
    assert run.times[0] == 0.45
