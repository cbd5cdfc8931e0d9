"""What a run does at samples, corners, marks and interruptions, against closed forms."""

from typing import Annotated, NamedTuple

import numpy as np
import pytest
from tests.words import wording

from vvdp.base import signal as signals
from vvdp.base.arrays import Array
from vvdp.base.conservation import Nothing
from vvdp.base.errors import ParameterError, RunError
from vvdp.base.kinds import Kind, Ratio
from vvdp.base.params import Params
from vvdp.base.signal import Signal, signal_stop, signal_value
from vvdp.hydraulics.switching_valve import PulseTrain, pulse_stop, pulse_train
from vvdp.simulation import run as runs
from vvdp.simulation.model import Case, Model, Program
from vvdp.simulation.run import Method, Stepping, long_run, simulate

Plain = Annotated[float, Kind("plain number", "1", -1e9, 1e9, "1")]
PlainSignal = Annotated[Signal, Kind("plain number", "1", -1e9, 1e9, "1")]
METHODS = [Method.EXPLICIT, Method.STIFF]


class Level(NamedTuple):
    x: Plain


class Given(Params):
    inflow: PlainSignal


def filled(t: float, s: Level, u: Nothing, p: Given) -> tuple[Level, Level]:
    return Level(signal_value(t, p.inflow)), Level(s.x)


def filled_stop(t: float, u: Nothing, p: Given) -> float:
    return signal_stop(t, p.inflow)


FILLED = Model(filled, stop=filled_stop)


def stepping(until: float, **others) -> Stepping:
    given = {"sample_period": 0.1, "record_interval": 0.05, "window_interval": 0.05} | others
    return Stepping(until=until, **given)


SIGNALS = {
    # x(1) by hand
    "step inside a sample": (signals.step(1.0, 3.0, 0.537), 0.537 + 3.0 * 0.463),
    "step on a sample": (signals.step(1.0, 3.0, 0.5), 0.5 + 1.5),
    "ramp": (signals.ramp(0.0, 2.0, 0.213, 0.713), 0.5 * 0.5 * 2.0 + 2.0 * 0.287),
    "table with a jump": (
        signals.table([0.1, 0.3, 0.3, 0.65], [0.0, 1.0, 5.0, 0.0]),
        0.5 * 0.2 * 1.0 + 0.5 * 0.35 * 5.0,
    ),
    "sine": (signals.sine(0.5, 2.0, 3.25), 0.5 + 2.0 * (1.0 - np.cos(6.5 * np.pi)) / (6.5 * np.pi)),
}


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("name", SIGNALS)
def test_integral_of_a_prescribed_signal_is_exact(name, method):
    """x' = u(t). Straight pieces are integrated exactly by both methods if, and only if, steps end on every corner.

    A missed jump would leave an error of the order of the tolerance at best; straight pieces leave rounding, the sine
    the tolerance.
    """
    signal, expected = SIGNALS[name]
    run = simulate(
        FILLED, Case(Level(0.0), Given(inflow=signal)), stepping(1.0, relative_tolerance=1e-6, method=method)
    )
    allowed = 2e-6 if signal.amplitude else 1e-12
    assert run.final[0] == pytest.approx(expected, abs=allowed)


def test_corner_that_is_not_announced_costs_accuracy():
    """The same circuit without its stops: the test above does test something."""
    signal, expected = SIGNALS["step inside a sample"]
    run = simulate(Model(filled), Case(Level(0.0), Given(inflow=signal)), stepping(1.0, relative_tolerance=1e-6))
    assert abs(run.final[0] - expected) > 1e-12


class Pulsed(Params):
    train: PulseTrain


def pulsed(t: float, s: Level, u: Nothing, p: Pulsed) -> tuple[Level, Nothing]:
    return Level(pulse_train(t, p.train)), Nothing(0.0)


def pulsed_stop(t: float, u: Nothing, p: Pulsed) -> float:
    return pulse_stop(t, p.train)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(("frequency", "duty"), [(72.3, 0.317), (10.0, 0.5), (30.0, 1.0), (30.0, 0.0)])
def test_pulse_train_of_a_user_circuit_is_integrated_exactly(frequency, duty, method):
    """Whole periods and the part of the last; rounding of a few hundred sums of numbers below 1."""
    params = Pulsed(train=PulseTrain(frequency=frequency, duty_ratio=duty))
    run = simulate(Model(pulsed, stop=pulsed_stop), Case(Level(0.0), params), stepping(1.0, method=method))
    whole, part = divmod(frequency, 1.0)
    expected = (whole * duty + min(part, duty)) / frequency
    assert run.final[0] == pytest.approx(expected, abs=1e-12)


# Marks


class Turning(NamedTuple):
    x: Plain
    v: Plain


class Rate(Params):
    angular: Plain


def oscillator(t: float, s: Turning, u: Nothing, p: Rate) -> tuple[Turning, Nothing]:
    return Turning(s.v, -p.angular * p.angular * s.x), Nothing(0.0)


def five_levels(t: float, s: Turning, u: Nothing, p: Rate) -> float:
    return 5.0 * s.x


def test_marks_are_located_in_both_directions():
    """x = sin(w t) crosses 0.2, 0.4 ... 0.8 upward and, at the mirrored times, downward; 0 both ways.

    The time error is the state's over its slope, plus that of the cubic: h^4/384 w^4 over w cos(w t), where the
    slope at 0.8 is 0.6 w. With records at every step (h <= 5e-3, w = 2 pi): 4e-11/0.6, below 1e-8/w.
    """
    w = 2.0 * np.pi
    chosen = stepping(2.0, relative_tolerance=1e-10, sample_period=5e-3)
    run = simulate(Model(oscillator, mark=five_levels), Case(Turning(0.0, w), Rate(angular=w)), chosen)
    times = []
    for k in range(2):
        for level in (0.2, 0.4, 0.6, 0.8):
            rise = np.arcsin(level) / w
            times += [k + rise, k + 0.5 - rise, k + 0.5 + rise, k + 1.0 - rise]
        times += [k + 0.5, *([k + 1.0] if k == 0 else [])]
    expected = np.sort(times)
    marks = run.mark_times[(run.mark_times > 1e-6) & (run.mark_times < 2.0 - 1e-6)]
    assert marks.size == expected.size
    assert marks == pytest.approx(expected, abs=1e-8)
    assert run.mark_states[:, 0] * 5.0 == pytest.approx(np.round(run.mark_states[:, 0] * 5.0), abs=1e-6)


class Crossing(NamedTuple):
    angle: Plain


def steady(t: float, s: Crossing, u: Nothing, p: Rate) -> tuple[Crossing, Nothing]:
    return Crossing(p.angular), Nothing(0.0)


def whole_turns(t: float, s: Crossing, u: Nothing, p: Rate) -> float:
    return s.angle


@pytest.mark.parametrize("rate", [7000.3, -7000.3])
def test_more_marks_than_the_first_buffer_holds(rate):
    """A straight line: the mark k is at k/rate to rounding, and none is missing beyond 256, 512, ... of them."""
    chosen = stepping(1.0, sample_period=1e-3)
    run = simulate(Model(steady, mark=whole_turns), Case(Crossing(0.5), Rate(angular=rate)), chosen)
    first = 0.5 / abs(rate)
    expected = (np.arange(run.mark_times.size) + 0.5) / abs(rate)
    assert run.mark_times.size == int(np.floor(abs(rate) + 0.5))
    assert run.mark_times[0] == pytest.approx(first, abs=1e-12)
    assert run.mark_times == pytest.approx(expected, abs=1e-12)


def test_many_marks_in_one_step():
    """A step of 0.1 s passes 700 of them: all are found, however many the buffer has room for."""
    run = simulate(Model(steady, mark=whole_turns), Case(Crossing(0.5), Rate(angular=7000.0)), stepping(1.0))
    assert run.mark_times.size == 7000
    assert run.mark_times == pytest.approx((np.arange(7000) + 0.5) / 7000.0, abs=1e-12)


# Programs: see also test_programs


class Counted(NamedTuple):
    calls: Plain
    history: Annotated[Array, Kind("plain number", "1", -1e9, 1e9, "1")]


class Push(NamedTuple):
    force: Plain


class Pushed(NamedTuple):
    counter: Push


class Gain(Params):
    increment: Plain


def pushed(t: float, s: Level, u: Pushed, p: Nothing) -> tuple[Level, Level]:
    return Level(u.counter.force), Level(u.counter.force)


def seen(t: float, s: Level, outputs: Level, p: Nothing) -> Level:
    return Level(s.x)


def counting(t: float, memory: Counted, reading: Level, settings: Gain) -> tuple[Counted, Push]:
    history = memory.history.copy()
    history[int(memory.calls) % 4] = reading.x
    calls = memory.calls + 1.0
    return Counted(calls, history), Push(settings.increment * calls)


COUNTER = Program(seen, counting, Push(0.0))


def counted(until: float, period: float, **others):
    case = Case(
        Level(0.0),
        Nothing(),
        Pushed(Push(0.0)),
        {"counter": Counted(0.0, np.zeros(4))},
        {"counter": Gain(increment=2.0)},
    )
    chosen = stepping(until, sample_period=period, record_interval=period, window_interval=period, **others)
    return simulate(Model(pushed, programs={"counter": COUNTER}), case, chosen)


@pytest.mark.parametrize("method", METHODS)
def test_program_is_called_at_zero_and_at_each_sample_and_its_command_held(method):
    """From sample k on, 0 the first, the command is 2 (k + 1): x at sample n is dt n (n + 1), exactly."""
    run = counted(1.0, 1.0 / 64.0, method=method)
    n = np.arange(65)
    assert run.samples == run.calls["counter"] == 65
    assert run.times * 64.0 == pytest.approx(n)
    assert run.states[:, 0] == pytest.approx(n * (n + 1) / 64.0, rel=1e-12, abs=1e-12)
    # a record on a sample still has the command and the memory that were held until then
    assert run.command.counter.force[1:] == pytest.approx(2.0 * n[1:])
    assert run.memory["counter"].calls[1:] == pytest.approx(n[1:])
    assert run.outputs.x == pytest.approx(run.command.counter.force)
    assert run.readings["counter"].x == pytest.approx(run.states[:, 0])


def test_what_a_program_remembers_is_recorded_in_its_shape():
    """An array of the memory has time as its last axis; what was seen at sample k stands at k modulo 4."""
    run = counted(1.0, 1.0 / 64.0)
    history = run.memory["counter"].history
    assert history.shape == (4, 65)
    n = np.arange(65)
    assert history[0, 1:] == pytest.approx(run.states[(n[1:] - 1) // 4 * 4, 0])
    assert run.final_memory["counter"].calls == 65.0
    assert run.final_memory["counter"].history == pytest.approx(run.states[[64, 61, 62, 63], 0])
    assert run.final_command.counter.force == 130.0
    assert run.final_case.memory["counter"].calls == 65.0


@pytest.mark.parametrize(("until", "period", "samples"), [(0.3, 1e-3, 301), (1.0, 1e-4, 10001), (0.0105, 1e-3, 11)])
def test_number_of_samples(until, period, samples):
    """One at 0 and one per period; rounding adds none."""
    run = counted(until, period)
    assert run.samples == samples
    assert run.end == until


# Interruption


def growing(t: float, s: Level, u: Nothing, p: Nothing) -> tuple[Level, Nothing]:
    return Level(s.x * s.x), Nothing(0.0)


@pytest.mark.parametrize("method", [*METHODS, Method.AUTOMATIC])
def test_state_that_becomes_infinite_ends_the_run_with_an_error(method):
    """x' = x^2 from 1 is 1/(1 - t): infinite at 1 s."""
    with pytest.raises(RunError, match=r"at t = (1|0\.99\d*) s.*state: x = ") as caught:
        simulate(Model(growing), Case(Level(1.0), Nothing()), stepping(2.0, method=method))
    assert "\n" not in str(caught.value)


def rooted(t: float, s: Level, u: Nothing, p: Nothing) -> tuple[Level, Nothing]:
    return Level(-1.0 - np.sqrt(s.x)), Nothing(0.0)


@pytest.mark.parametrize("method", [*METHODS, Method.AUTOMATIC])
def test_rate_that_is_no_number_ends_the_run_with_an_error(method):
    """x' = -1 - sqrt(x): x reaches 0 at 2 (1 - ln 2) s = 0.614 s from x = 1, and no further."""
    with pytest.raises(RunError, match=r"t = 0\.61\d* s: a rate is " + wording.simulation.no_longer_finite + ".*x = "):
        simulate(Model(rooted), Case(Level(1.0), Nothing()), stepping(2.0, method=method))


def test_interrupted_run_keeps_what_was_reached():
    heard = []

    def interrupt(t: float) -> None:
        heard.append(t)
        if t > 0.5:
            raise KeyboardInterrupt

    case = Case(Turning(0.0, 60.0), Rate(angular=60.0))
    chosen = stepping(1.0, sample_period=1e-2, record_interval=1e-2, window_interval=1e-2)
    run = simulate(Model(oscillator), case, chosen, progress=interrupt, portion=100.0)
    whole = simulate(Model(oscillator), case, chosen)
    assert not run.finished and whole.finished
    assert 0.5 < run.end < 0.6
    assert heard[-1] == run.end
    assert np.all(np.diff(heard) >= 0.0)
    rows = run.times.size
    assert run.times[-1] <= run.end < run.times[-1] + 1e-2
    assert np.array_equal(run.states, whole.states[:rows])


@pytest.mark.parametrize("method", [*METHODS, Method.AUTOMATIC])
@pytest.mark.parametrize("portion", [1.0, 37.0, 400.0])
def test_portions_do_not_change_a_single_bit(portion, method):
    """Stops, marks, records, a full mark buffer and the choice of method, handed back at every possible step."""

    def run(portion):
        case = Case(Turning(0.0, 60.0), Rate(angular=60.0))
        chosen = stepping(1.0, sample_period=3e-2, record_interval=7e-3, window_interval=1.3e-3, method=method)
        model = Model(oscillator, mark=hundred_levels)
        return simulate(model, case, chosen, portion=portion)

    parts, whole = run(portion), run(1e12)
    for name in ("times", "states", "commands", "memories", "mark_times", "mark_states", "final", "low", "high"):
        assert np.array_equal(getattr(parts, name), getattr(whole, name)), name
    assert (parts.steps, parts.rejected, parts.evaluations, parts.samples) == (
        whole.steps,
        whole.rejected,
        whole.evaluations,
        whole.samples,
    )
    assert whole.mark_times.size > 256


def hundred_levels(t: float, s: Turning, u: Nothing, p: Rate) -> float:
    return 20.0 * s.x


def test_records_between_steps_are_as_exact_as_the_cubic():
    """Cubic through both ends of a step: h^4/384 max|x''''|, with h up to the sample period of 0.02 s and w = 10 1/s:
    (0.2)^4/384 = 4.2e-6 of the amplitude, and not a hundredth of it at half the points either."""
    w, h = 10.0, 0.02
    case = Case(Turning(0.0, w), Rate(angular=w))
    chosen = stepping(1.0, relative_tolerance=1e-9, sample_period=h, record_interval=1e-3, window_interval=1e-3)
    run = simulate(Model(oscillator), case, chosen)
    error = np.max(np.abs(run.states[:, 0] - np.sin(w * run.times)))
    assert error < (w * h) ** 4 / 384 + 1e-8


def test_extremes_are_those_of_all_steps():
    case = Case(Turning(0.0, 10.0), Rate(angular=10.0))
    run = simulate(Model(oscillator), case, stepping(1.0, sample_period=1e-3, record_interval=1.0, window=0.0))
    # the ends of steps of 1 ms miss the top by up to (5e-3)^2/2
    assert run.high[0] == pytest.approx(1.0, abs=1.3e-5)
    assert run.low[0] == pytest.approx(-1.0, abs=1.3e-5)


# Stiff


class Stiffness(Params):
    rate: Ratio


def follower(t: float, s: Level, u: Nothing, p: Stiffness) -> tuple[Level, Nothing]:
    return Level(-p.rate * (s.x - np.cos(t)) - np.sin(t)), Nothing(0.0)


@pytest.mark.parametrize("method", [Method.AUTOMATIC, Method.STIFF])
def test_stiff_follower_of_a_smooth_curve(method):
    """Prothero and Robinson: x = cos t for any rate. At 1e8 1/s an explicit method would need 3e7 steps a second."""
    chosen = stepping(3.0, sample_period=1e-2, relative_tolerance=1e-8, method=method)
    run = simulate(Model(follower), Case(Level(1.0), Stiffness(rate=1e6)), chosen)
    assert run.stiff
    assert run.evaluations < 3e5
    assert run.final[0] == pytest.approx(np.cos(3.0), abs=1e-7)


@pytest.mark.parametrize(
    ("values", "told"),
    [
        ({"until": 0.0}, "until"),
        ({"until": 1.0, "sample_period": 0.0}, "sample_period"),
        ({"until": 1.0, "relative_tolerance": 0.1}, "relative_tolerance"),
        ({"until": 1.0, "window_interval": 1e-9}, "at most 2e7"),
        ({"until": 1.0, "begin": 1.0}, wording.simulation.after_begin.format(begin="1000 ms")),
        ({"until": 1.0, "longest_step": 0.0}, "longest_step"),
        ({"until": "1 s"}, "Stepping.until: '1 s' is a text; .*vvdp.base.units.parse"),
    ],
)
def test_impossible_stepping_is_refused(values, told):
    with pytest.raises(ParameterError, match=told):
        Stepping(**values)


def test_record_times_are_increasing_and_end_with_the_run():
    chosen = Stepping(until=0.3, window=0.05, window_interval=2e-5)
    times = chosen.record_times
    assert np.all(np.diff(times) > 1e-8)
    assert times[0] == 0.0
    assert times[-1] == 0.3
    assert times.size == pytest.approx(300 + 1 + 2500 - 50, abs=2)


def test_a_run_that_takes_long_says_so_and_why():
    """By hand: in 2 s it came 1 ms of 10 s far, in 5000 steps and 50 periods."""
    before, now = runs.Count(0.0, 100.0, 0.0), runs.Count(1e-3, 5100.0, 50.0)
    words = long_run(10.0, 2.0, before, now)
    assert words == wording.simulation.will_take_about + wording.simulation.periods.format(
        time="5.55 h", periods="5e+04", steps=100
    )
    assert wording.simulation.steps.format(time="5.55 h", steps="5e+06") in long_run(
        10.0, 2.0, before, now._replace(marks=0.0)
    )
    assert long_run(10.0, 2.0, before, runs.Count(1.0, 5100.0, 50.0)) == ""


def test_it_is_said_once_and_before_the_end(monkeypatch, switching):
    model, case = switching
    monkeypatch.setattr(runs, "SOON", 0.0)
    monkeypatch.setattr(runs, "LONG", 0.0)
    said = []
    simulate(model, case(3e6), Stepping(until=0.05), say=said.append, portion=200.0)
    assert len([words for words in said if words.startswith(wording.simulation.will_take_about)]) == 1
