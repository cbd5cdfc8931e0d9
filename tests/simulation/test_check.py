"""Every mistake that a person makes in a circuit of their own is told in one line, before anything runs."""

import math
import re
from dataclasses import replace
from typing import Annotated, NamedTuple

import numpy as np
import pytest
from tests.words import wording

from vvdp.base.conservation import NOTHING, Books, Stored
from vvdp.base.errors import ParameterError, RunError
from vvdp.base.kinds import Energy, Kind, Pressure, Volume
from vvdp.base.params import Params
from vvdp.simulation.check import check_model, check_times
from vvdp.simulation.model import Case, Model, Program
from vvdp.simulation.run import Stepping, simulate

Plain = Annotated[float, Kind("plain number", "1", -1e9, 1e9, "1")]
PlainRow = Annotated[np.ndarray, Kind("plain number", "1", -1e9, 1e9, "1")]


class Spent(NamedTuple):
    leak: Energy


class Supplied(NamedTuple):
    pump: Energy


class Vessel(NamedTuple):
    inlet: Pressure
    load: Pressure
    books: Books


class Seen(NamedTuple):
    inlet: Pressure


class Order(NamedTuple):
    force: Plain


class Command(NamedTuple):
    valve: Order


class Memory(NamedTuple):
    sum: Plain


class Values(Params):
    flow: Plain
    volume: Volume


BOOKS = Books(Supplied(0.0), Spent(0.0), 0.0, 0.0)
VALUES = Values(flow=2.0, volume=1e-3)
CASE = Case(Vessel(1e5, 2e5, BOOKS), VALUES, Command(Order(0.0)), {"valve": Memory(0.0)}, {"valve": NOTHING})


def books(power: float) -> Books:
    return Books(Supplied(power), Spent(0.0), 0.0, 0.0, NOTHING)


def circuit(t, s, u, p):
    return Vessel(u.valve.force - p.flow, 0.0, books(1.0)), Seen(s.inlet)


def measure(t, s, o, p):
    return Seen(o.inlet)


def step(t, memory, reading, settings):
    return Memory(memory.sum + reading.inlet), Order(1.0)


def stored(s, p):
    return Stored(s.inlet * p.volume, p.volume)


PROGRAM = Program(measure, step, Order(0.0))
MODEL = Model(circuit, stored, programs={"valve": PROGRAM})


def told(model: Model = MODEL, case: Case = CASE) -> str:
    with pytest.raises(RunError) as caught:
        check_model(model, case)
    message = str(caught.value)
    assert "\n" not in message
    return message


def with_circuit(function) -> str:
    return told(replace(MODEL, circuit=function))


def with_program(**changes) -> str:
    return told(replace(MODEL, programs={"valve": replace(PROGRAM, **changes)}))


def test_a_sound_model_passes():
    check_model(MODEL, CASE)
    check_times(MODEL, 1e-3)


# The state


class Bare(NamedTuple):
    inlet: float
    load: Pressure
    books: Books


class Early(NamedTuple):
    inlet: Pressure
    books: Books
    load: Pressure


STATES = [
    (Vessel(5.0, 2e5, BOOKS), "state 'inlet' starts wrongly: 5 Pa absolute .* in Pa, absolute: was it meant in bar"),
    (
        Vessel(-1e5, 2e5, BOOKS),
        "state 'inlet' starts wrongly: -100000 Pa is outside 0 to 1e.09 Pa for a pressure level",
    ),
    (Vessel(np.nan, 2e5, BOOKS), "state 'inlet' starts wrongly: nan is not a finite number"),
    (
        Vessel("5 bar", 2e5, BOOKS),
        r"state 'inlet' = '5 bar' is a text.*vvdp.base.units.parse\('5 bar', PRESSURE_LEVEL\)",
    ),
    (Vessel(None, 2e5, BOOKS), "state 'inlet' = None; expected a number"),
    (Vessel(np.zeros(3), 2e5, BOOKS), "state 'inlet' is an array"),
    (Bare(1e5, 2e5, BOOKS), "state 'inlet' has no kind; annotate it, for example `inlet: Pressure`"),
    (Early(1e5, BOOKS, 2e5), "books must be the last field"),
    (1e5, "expected a NamedTuple"),
]


@pytest.mark.parametrize(("state", "message"), STATES)
def test_a_state_that_cannot_be_meant_is_refused(state, message):
    assert re.search(message, told(case=replace(CASE, state=state)))


# The circuit


def only_rates(t, s, u, p):
    return Vessel(0.0, 0.0, books(0.0))


def returns_nothing(t, s, u, p):
    Vessel(0.0, 0.0, books(0.0))


def forgets_a_rate(t, s, u, p):
    return Vessel(0.0, books(0.0)), Seen(s.inlet)


def misspells(t, s, u, p):
    return Vessel(p.flwo, 0.0, books(0.0)), Seen(s.inlet)


def takes_three(t, s, p):
    return Vessel(0.0, 0.0, books(0.0)), Seen(s.inlet)


def uses_math(t, s, u, p):
    return Vessel(math.sqrt(s.inlet), 0.0, books(0.0)), Seen(s.inlet)


def chooses_by_time(t, s, u, p):
    flow = 1.0 if t > 0.5 else 0.0
    return Vessel(flow, 0.0, books(0.0)), Seen(s.inlet)


def chooses_by_state(t, s, u, p):
    return Vessel(max(s.inlet, 1.0), 0.0, books(0.0)), Seen(s.inlet)


def chooses_by_command(t, s, u, p):
    return Vessel(1.0 if u.valve.force > 0.0 else 0.0, 0.0, books(0.0)), Seen(s.inlet)


def throws_dice(t, s, u, p):
    return Vessel(np.random.default_rng().random(), 0.0, books(0.0)), Seen(s.inlet)


def reads_books(t, s, u, p):
    return Vessel(s.books.taken_in, 0.0, books(0.0)), Seen(s.inlet)


def infinite(t, s, u, p):
    return Vessel(np.log(s.inlet - s.inlet), 0.0, books(0.0)), Seen(s.inlet)


def plain_outputs(t, s, u, p):
    return Vessel(0.0, 0.0, books(0.0)), (s.inlet, s.load)


class Unkinded(NamedTuple):
    inlet: float


def unkinded_outputs(t, s, u, p):
    return Vessel(0.0, 0.0, books(0.0)), Unkinded(s.inlet)


TABLE = [1.0, 2.0]


def helper(x):
    return x * TABLE[0]


def reads_a_list(t, s, u, p):
    return Vessel(helper(s.inlet), 0.0, books(0.0)), Seen(s.inlet)


CIRCUITS = [
    (only_rates, ["returns the rates only", "expected rates and outputs"]),
    (returns_nothing, ["returns nothing"]),
    (
        forgets_a_rate,
        ["Vessel is given too few values", "'books' is missing argument, or one before it", "Vessel(books=...)"],
    ),
    (misspells, ["Values has no field 'flwo'; did you mean 'flow'?", "test_check.py"]),
    (takes_three, ["takes (t, s, p); expected (t, state, command, params)"]),
    (uses_math, ["np.sqrt for math.sqrt", "math.sqrt(s.inlet)"]),
    (chooses_by_time, ["chooses by the time", "select", "stop"]),
    (chooses_by_state, ["chooses by the state", "write the choice with select"]),
    (chooses_by_command, ["chooses by the command", "select"]),
    (throws_dice, ["two answers to the same question", "vvdp.numerics.random"]),
    (reads_books, ["reads its own books"]),
    (infinite, ["no finite rate at the start for inlet"]),
    (plain_outputs, ["expected a NamedTuple"]),
    (unkinded_outputs, ["output of unkinded_outputs: 'inlet' has no kind"]),
    (reads_a_list, ["helper reads 'TABLE', a list of its module", "tuple"]),
]


@pytest.mark.parametrize(("function", "parts"), CIRCUITS, ids=[f.__name__ for f, _ in CIRCUITS])
def test_a_wrong_circuit_is_told_with_what_to_do(function, parts):
    message = with_circuit(function)
    for part in parts:
        assert part in message, message


# Stops, marks, conditions, stored


def stands_still(t, u, p):
    return t


def sticks(t, u, p):
    return 0.5 if t < 0.7 else np.inf


def old_stop(t, p):
    return np.inf


def no_number(t, s, u, p):
    return np.nan


def half_stored(s, p):
    return s.inlet


def conditions(t, p):
    return Seen(1e5)


OTHERS = [
    ({"stop": stands_still}, "stop, stands_still, returns 0.0 when asked at t = 0 s; expected the next time after"),
    ({"stop": sticks}, "stop, sticks, returns 0.5 when asked at t = 0.5 s"),
    ({"stop": old_stop}, "stop, old_stop, takes (t, p); expected (t, command, params)"),
    ({"mark": no_number}, "mark, no_number, returns nan; expected a finite number"),
    ({"mark": old_stop}, "mark, old_stop, takes (t, p); expected (t, state, command, params)"),
    ({"stored": half_stored}, "stored, half_stored, returns 100000.0; expected Stored(energy, volume)"),
    ({"conditions": conditions}, "its command, Command, no field `held`"),
    ({"programs": {"valves": PROGRAM}}, "program 'valves' has no field of its name in the command, Command"),
]


@pytest.mark.parametrize(("changes", "message"), OTHERS)
def test_other_functions_are_tried_as_well(changes, message):
    assert message in told(replace(MODEL, **changes))


# Programs


def reads_totals(t, s, o, p):
    return Seen(s.inlet + s.books.taken_in)


def hands_books_on(t, s, o, p):
    return s.books


def measures_wrong_field(t, s, o, p):
    return Seen(o.inlt)


def measures_by_choice(t, s, o, p):
    return Seen(s.inlet if s.inlet > 2.0 else 0.0)


def measures_a_number(t, s, o, p):
    return s.inlet


def measures_unkinded(t, s, o, p):
    return Unkinded(s.inlet)


class Longer(NamedTuple):
    sum: Plain
    more: Plain


def other_memory(t, memory, reading, settings):
    return Longer(1.0, 2.0), Order(1.0)


def other_command(t, memory, reading, settings):
    return memory, Longer(1.0, 2.0)


def no_command(t, memory, reading, settings):
    return memory


def trigger_on_books(t, s, u, p, settings):
    return s.books.taken_in


PROGRAMS = [
    ({"measure": reads_totals}, "gives no finite 'inlet' without the books; nothing may depend on the books"),
    ({"measure": hands_books_on}, "gives no finite 'supplied.pump' without the books"),
    ({"measure": measures_wrong_field}, "Seen has no field 'inlt'; did you mean 'inlet'?"),
    ({"measure": measures_by_choice}, "chooses by the state; write the choice with select"),
    ({"measure": measures_a_number}, "expected a NamedTuple"),
    ({"measure": measures_unkinded}, "reading of program 'valve': 'inlet' has no kind"),
    ({"step": other_memory}, "the memory that program 'valve' returns and the memory it is given differ in more"),
    ({"step": other_command}, "the command that program 'valve' returns and the command's field 'valve' differ in"),
    ({"step": no_command}, "expected (memory, command)"),
    ({"trigger": trigger_on_books}, "trigger of program 'valve', trigger_on_books, returns nan"),
    ({"command": Longer(0.0, 0.0)}, "the first command of program 'valve'"),
]


@pytest.mark.parametrize(("changes", "message"), PROGRAMS)
def test_a_wrong_program_is_told_with_its_name(changes, message):
    assert message in with_program(**changes)


class UnkindedOrder(NamedTuple):
    force: float


class UnkindedCommand(NamedTuple):
    valve: UnkindedOrder


class UnkindedRow(NamedTuple):
    sum: Plain
    row: np.ndarray


class KindedRow(NamedTuple):
    sum: Plain
    row: PlainRow


def keeps_row(t, memory, reading, settings):
    return memory._replace(sum=memory.sum + 1.0), Order(1.0)


def orders_unkinded(t, memory, reading, settings):
    return memory, UnkindedOrder(1.0)


def test_everything_that_is_recorded_needs_a_kind():
    """A field without one used to vanish from the results without a word."""
    case = replace(CASE, command=UnkindedCommand(UnkindedOrder(0.0)))
    program = replace(PROGRAM, step=orders_unkinded, command=UnkindedOrder(0.0))
    assert "command of program 'valve': 'force' has no kind" in told(replace(MODEL, programs={"valve": program}), case)
    row = replace(MODEL, programs={"valve": replace(PROGRAM, step=keeps_row)})
    case = replace(CASE, memory={"valve": UnkindedRow(0.0, np.zeros(3))})
    assert "memory of program 'valve': 'row' has no kind" in told(row, case)
    check_model(row, replace(CASE, memory={"valve": KindedRow(0.0, np.zeros(3))}))


TIMES = [
    ({"period": 0.0}, "period: 0 s must be greater than 0"),
    ({"period": 0.1, "latency": 0.2}, "latency = 0.2 s; expected 0 s to one period, 0.1 s"),
    ({"phase": -0.1}, "phase = -0.1 s; expected 0 s to below one period, 0.001 s"),
    ({"phase": 1e-3}, "phase = 0.001 s"),
    ({"trigger": no_number, "period": 0.1}, "has a trigger"),
    ({"trigger": no_number, "latency": -1.0}, "latency = -1 s"),
]


@pytest.mark.parametrize(("changes", "message"), TIMES)
def test_times_of_a_program_have_to_fit(changes, message):
    with pytest.raises(RunError) as caught:
        check_times(replace(MODEL, programs={"valve": replace(PROGRAM, **changes)}), 1e-3)
    assert message in str(caught.value)


def late_stop(t, u, p):
    return 1.0 if t < 1.0 else 2.0


def test_a_stop_that_fails_later_ends_the_run_with_its_name():
    model, case = replace(MODEL, stop=late_stop), CASE
    with pytest.raises(RunError, match="at t = 2 s: " + wording.simulation.no_later_time):
        simulate(model, case, Stepping(until=3.0))


def test_a_run_is_checked_before_it_is_compiled():
    with pytest.raises(RunError, match=wording.simulation.meant_in_bar):
        simulate(MODEL, replace(CASE, state=Vessel(5.0, 2e5, BOOKS)), Stepping(until=1.0))


# Parameter classes


def test_a_field_called_check_is_refused_when_it_is_written_down():
    with pytest.raises(ParameterError, match="Bad.check: " + wording.simulation.cannot_be_called):

        class Bad(Params):
            check: Plain


def test_text_for_a_number_names_the_field_and_the_way():
    with pytest.raises(ParameterError, match=r"Values.flow: '40 lpm' is a text; .*vvdp.base.units.parse"):
        Values(flow="40 lpm", volume=1.0)
