"""The phases of the whole machine, in a table: what each waits for, what it switches on."""

import pytest

from vvdp.base.errors import ParameterError
from vvdp.programs.machine.phases import (
    CONTROL,
    EMERGENCY,
    HOLD,
    HOME,
    LEARN,
    PRECHARGE,
    REST,
    RETURN,
    SPIN,
    MachineSequence,
    Orders,
    Phase,
    Progress,
    next_phase,
    orders_of,
)

BAR = 1e5
SEQUENCE = MachineSequence(
    precharge_flow=2.0 / 6e4,
    precharge_margin=0.3 * BAR,
    hold_time=0.6,
    return_tolerance=0.2e-3,
    stop_time=10.0,
    emergency_time=20.0,
)
NOTHING = Progress(homed=0.0, known=0.0, learned=0.0, line_pressure=2 * BAR, supply=6 * BAR, above_stop=10e-3)
HOMED = NOTHING._replace(homed=1.0)
KNOWN = HOMED._replace(known=1.0)
LEARNED = KNOWN._replace(learned=1.0)
CHARGED = LEARNED._replace(line_pressure=5.71 * BAR)

TABLE = [
    (HOME, 1.0, NOTHING, HOME),
    (HOME, 1.0, HOMED, SPIN),
    (HOME, 1.0, CHARGED, CONTROL),
    (SPIN, 1.0, HOMED, SPIN),
    (SPIN, 1.0, KNOWN, LEARN),
    (LEARN, 1.0, KNOWN, LEARN),
    (LEARN, 1.0, LEARNED, PRECHARGE),
    (PRECHARGE, 1.0, LEARNED._replace(line_pressure=5.69 * BAR), PRECHARGE),
    (PRECHARGE, 1.0, CHARGED, CONTROL),
    (CONTROL, 1.0, NOTHING, CONTROL),
    (CONTROL, 10.0, CHARGED, HOLD),
    (LEARN, 10.0, KNOWN, RETURN),
    (HOLD, 1.5, CHARGED, HOLD),
    (HOLD, 1.7, CHARGED, RETURN),
    (RETURN, 2.0, CHARGED, RETURN),
    (RETURN, 2.0, CHARGED._replace(above_stop=0.1e-3), REST),
    (REST, 2.0, CHARGED, REST),
    (CONTROL, 20.0, CHARGED, EMERGENCY),
    (REST, 20.0, CHARGED, EMERGENCY),
    (EMERGENCY, 3.0, CHARGED, EMERGENCY),
]


@pytest.mark.parametrize(("number", "time", "progress", "then"), TABLE)
def test_each_phase_ends_with_what_it_waits_for(number: float, time: float, progress: Progress, then: float) -> None:
    found = next_phase(Phase(number, 1.0), time, progress, SEQUENCE)
    assert found == Phase(then, 1.0 if then == number else time)


def test_a_line_that_is_not_charged_first_is_not_waited_for() -> None:
    sequence = MachineSequence(precharge_flow=0.0, precharge_margin=0.0, hold_time=0.6, return_tolerance=2e-4)
    assert next_phase(Phase(LEARN, 0.5), 1.0, LEARNED, sequence) == Phase(CONTROL, 1.0)


@pytest.mark.parametrize(
    ("number", "orders"),
    [
        (HOME, Orders(0.0, 1.0, 0.0)),
        (SPIN, Orders(1.0, 1.0, 0.0)),
        (LEARN, Orders(1.0, 1.0, 0.0)),
        (PRECHARGE, Orders(1.0, 1.0, 0.0)),
        (CONTROL, Orders(1.0, 1.0, 1.0)),
        (HOLD, Orders(1.0, 1.0, 1.0)),
        (RETURN, Orders(1.0, 1.0, 0.0)),
        (REST, Orders(0.0, 1.0, 0.0)),
        (EMERGENCY, Orders(0.0, 0.0, 0.0)),
    ],
)
def test_what_a_phase_switches_on(number: float, orders: Orders) -> None:
    assert orders_of(number) == orders


def test_a_tolerance_of_nothing_is_refused() -> None:
    with pytest.raises(ParameterError, match="return_tolerance"):
        MachineSequence(precharge_flow=0.0, precharge_margin=0.0, hold_time=0.6, return_tolerance=0.0)
