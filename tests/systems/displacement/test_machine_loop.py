"""The outer loop of the whole machine, sample by sample in plain Python, with what it is told made up."""

from functools import cache

import numpy as np
import pytest

from vvdp.base.errors import ConfigError
from vvdp.control.flow_map import flow_for_duty
from vvdp.programs.axial_stages import LEARN as LEARNS
from vvdp.programs.axial_stages import RUN as FOLLOWS
from vvdp.programs.machine.loop import MachineCommand, MachinePlace, machine_start, machine_step
from vvdp.programs.machine.phases import CONTROL, EMERGENCY, HOLD, HOME, LEARN, PRECHARGE, REST, RETURN, SPIN
from vvdp.systems.system import load_system

BAR, LPM, H = 1e5, 1.0 / 6e4, 1e-3
ATMOSPHERE = 101325.0


@cache
def settings_of(*settings: str):
    unwatched = (
        "supervision.patience=100 s",
        "supervision.brief_time=100 s",
        "supervision.repeats=1e6",
    )  # what is told stands still
    system = load_system("displacement-control", [*unwatched, *settings])
    return system.circuit.network.programs["displacement"].settings


def place(t: float, **told: float) -> MachinePlace:
    """A cylinder that stands at 5 cm under its load, and a spool at its stop."""
    usual = {
        "position": 0.05,
        "pressure_a": ATMOSPHERE + 6.53 * BAR,
        "pressure_b": ATMOSPHERE + 3.0 * BAR,
        "line_pressure": ATMOSPHERE + 2.0 * BAR,
        "chamber_pressure": ATMOSPHERE,
        "pump_speed": 188.5,
        "spool_speed": 157.0,
        "spool_position": -6.2e-3,
    }
    zeros = dict.fromkeys(MachinePlace._fields, 0.0)
    return MachinePlace(**{**zeros, **usual, **told, "time": t})


def settled(loop):
    """The memory after the spool has homed for so long that the load is known."""
    memory = machine_start(loop)
    for k in range(-500, 0):
        memory, _ = machine_step(k * H, memory, place(k * H), loop)
    return memory


def commands(rows: list[MachinePlace], *settings: str) -> list[MachineCommand]:
    loop = settings_of(*settings)
    memory, found = settled(loop), []
    for row in rows:
        memory, command = machine_step(row.time, memory, row, loop)
        found.append(command)
    return found


STANDING = {"spool_stage": FOLLOWS, "spool_known": 1.0, "line_pressure": ATMOSPHERE + 6.5 * BAR}


def test_start_up_in_order():
    rows = [
        place(0.0),
        place(H, spool_stage=LEARNS),
        place(2 * H, spool_stage=LEARNS, spool_known=1.0),
        place(3 * H, spool_stage=FOLLOWS, spool_known=1.0),
        place(4 * H, **STANDING),
    ]
    found = commands(rows)
    assert [each.phase for each in found] == [HOME, SPIN, LEARN, PRECHARGE, CONTROL]
    assert [each.pump for each in found] == [0.0, 1.0, 1.0, 1.0, 1.0]
    assert [each.direction for each in found] == [0.0, 0.0, 0.0, 0.0, 1.0]
    assert [each.spool_position for each in found[:3]] == pytest.approx([-6.2e-3] * 3)


def test_the_line_is_charged_with_the_flow_that_the_table_says():
    found = commands([place(0.0, spool_stage=FOLLOWS, spool_known=1.0)])[0]
    loop = settings_of()
    assert found.flow == pytest.approx(2.0 * LPM)
    duty = found.spool_position / loop.spool.helix_length
    assert flow_for_duty(duty, ATMOSPHERE + 2.0 * BAR, loop.flow_map) == pytest.approx(2.0 * LPM, rel=1e-6)


def test_a_reference_is_held_and_the_spool_returns_when_a_stop_is_asked_for():
    rows = [place(k * H, **STANDING) for k in range(60)]
    found = commands(rows, "machine_sequence.stop_time=20 ms", "machine_sequence.hold_time=10 ms")
    phases = [each.phase for each in found]
    assert phases[19] == CONTROL and phases[21] == HOLD and phases[32] == REST
    held = [each.wanted for each in found if each.phase == HOLD]
    assert held == [found[19].wanted] * len(held) and len(held) >= 10
    assert all(each.direction == 0.0 and each.spool_position < -6.1e-3 for each in found if each.phase >= RETURN)
    assert found[-1].pump == 0.0


def test_an_emergency_stop_takes_everything_away_at_once():
    found = commands([place(k * H, **STANDING) for k in range(20)], "machine_sequence.emergency_time=10 ms")[11]
    assert found.phase == EMERGENCY
    assert (found.direction, found.opening, found.pump, found.dump, found.energised) == (0.0, 0.0, 0.0, 0.0, 0.0)


def test_the_reference_is_the_filtered_cycle():
    """The cycle's slope is 21.6 cm in 4 s; the filter's lag is 4/25 s, less half a sample."""
    found = commands([place(k * H, **STANDING) for k in range(900)])
    assert found[-1].wanted == pytest.approx(0.05 + 0.054 * 0.899)
    assert found[-1].reference == pytest.approx(0.05 + 0.054 * (0.899 - 0.16), abs=4e-5)
    assert found[-1].reference_velocity == pytest.approx(0.054, rel=1e-3)
    seen = commands([place(k * H, **STANDING) for k in range(900)], "cycle.preview=160 ms")
    assert seen[-1].reference == pytest.approx(0.05 + 0.054 * 0.899, abs=4e-5)


def test_slow_signals_are_means_over_a_pwm_period():
    """75 Hz at 157 rad/s: a ripple of 2 bar in the line is gone."""
    rows = [
        place(k * H, **{**STANDING, "line_pressure": ATMOSPHERE + (10.0 + np.sin(3.0 * 157.0 * k * H)) * BAR})
        for k in range(60)
    ]
    means = [each.line_pressure for each in commands(rows)[30:]]
    assert means == pytest.approx([ATMOSPHERE + 10.0 * BAR] * 30, abs=0.05 * BAR)


def test_a_gain_below_one_opens_the_spool_further():
    rows = [place(k * H, **STANDING) for k in range(100)]
    loop = settings_of()
    memory = settled(loop)
    low = memory._replace(gain=memory.gain._replace(gain=0.6))
    for row in rows:
        memory, usual = machine_step(row.time, memory, row, loop)
        low, wider = machine_step(row.time, low, row, loop)
    assert usual.flow == pytest.approx(wider.flow, rel=0.2)
    assert wider.duty_ratio > usual.duty_ratio


@pytest.mark.parametrize(
    ("setting", "message"),
    [
        ("cycle.stroke=400 mm", "50 to 450 mm are asked for; the cylinder goes from 0 to 300 mm"),
        ("cycle.stroke_time=0.5 s", "row 2: 432 mm/s are asked for; pump and cylinder reach 329.1 mm/s"),
    ],
)
def test_a_cycle_that_cannot_be_followed_is_refused(setting: str, message: str):
    with pytest.raises(ConfigError, match=message):
        load_system("displacement-control", [setting])
