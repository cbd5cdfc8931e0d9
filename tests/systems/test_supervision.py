"""What watches the whole machine, on signals made by hand: nothing is told of a healthy one, each fault by its name."""

from dataclasses import replace

import numpy as np
import pytest

from vvdp.base.errors import ParameterError
from vvdp.base.signal import constant
from vvdp.control.capacities import CircuitPressures, CylinderModel, SupplyLine
from vvdp.control.supervision import alarm_start, alarm_step, repeat_start, repeat_step
from vvdp.programs.machine.supervision import (
    WATCHED,
    MachineSight,
    SpoolSpring,
    Supervised,
    Supervision,
    differences,
    supervise,
    supervision_start,
)

ATM, H = 101325.0, 1e-3
LIMITS = Supervision(
    pressure_jump=7e5,
    position_margin=5e-3, lowest_pressure=0.5e5, highest_pressure=150e5, repeats=20.0, position_jump=1e-3,
    line_difference=2e5, return_difference=5e-6, return_share=0.1, settle_time=0.2, averaging_time=0.03,
    optical_jump=1.2e-3, spring_difference=1e-3, spool_error=3e-3, lowest_spool_speed=40.0, lowest_pump_share=0.95,
    brief_time=2.5e-3, patience=0.03,
)  # fmt: skip
LINE = SupplyLine(oil_volume=4e-4, hose_compliance=3e-10, gas_volume=5e-5, precharge_pressure=5e5, gas_exponent=1.3)
CYLINDER = CylinderModel(
    area_a=20.26e-4, area_b=10.77e-4, oil_volume_a=6e-4, oil_volume_b=8e-4, lowest_position=0.0, highest_position=0.3,
    moving_mass=100.0, viscous_friction=2000.0, bulk_modulus=7e8, line=LINE, return_conductance=1.2e-7,
    tank_pressure=ATM,
)  # fmt: skip
SPRING = SpoolSpring(stiffness=2594.0, preload=211.5, area=174e-6, reference_pressure=ATM)
HELD = ATM + (211.5 + 2594.0 * 4.2e-3) / 174e-6
"""At the spool, 4.2 mm from where the preload counts [Pa]."""
SETTINGS = Supervised(
    watches=1.0, limits=LIMITS, cylinder=CYLINDER, spring=SPRING, pump_speed=constant(188.5), sample_period=H
)
BACK = 3.67e5
"""(10.77e-4 m2 * 0.054 m/s / (1.2e-7 * 0.8))^2 [Pa]."""


def sight(t, rng, **changes):
    """A healthy sample while the cylinder extends at 54 mm/s, its pressures with 0.2 bar of noise."""
    x, (a, b, line) = 0.1 + 0.054 * (t % 2.0), ATM + np.array([9e5, BACK, 9.1e5])
    noise = 0.2e5 * rng.standard_normal(3)
    spool = 4.2e-3 + 20e-6 * rng.standard_normal()
    values = {
        "time": t, "watched": 1.0, "position": x + 1e-5 * rng.standard_normal(), "expected": x, "velocity": 0.054,
        "fast": CircuitPressures(a + noise[0], b + noise[1], line + noise[2]),
        "slow": CircuitPressures(a, b, line), "direction": 1.0, "opening": 0.8,
        "spool_measured": spool + 1e-3 * np.sin(150.0 * t), "spool_position": 4.2e-3,
        "chamber_pressure": HELD + 0.1e5 * rng.standard_normal(),
        "spool_reference": 4.2e-3, "spool_speed": 155.0, "pump_speed": 188.5,
    }  # fmt: skip
    return MachineSight(**(values | changes))


def told(fault, begin=1.0, until=1.3, settings=SETTINGS):
    """Name of the alarm and after how long it is told [s], with `fault(t)` from `begin` on; None without."""
    rng, memory = np.random.default_rng(7), supervision_start()
    for k in range(round(until / H)):
        t = k * H
        first = {"watched": 0.0} if k == 0 else {}
        memory = supervise(memory, sight(t, rng, **(first | (fault(t) if t >= begin else {}))), settings)
        if memory.alarm.alarm:
            return WATCHED[int(memory.alarm.alarm) - 1], memory.alarm.time - begin
    return None


def pressures(a=9e5, b=BACK, line=9.1e5):
    p = CircuitPressures(ATM + a, ATM + b, ATM + line)
    return {"slow": p, "fast": p._replace(pressure_a=p.pressure_a)}


def noisy(**slow):
    """Averages as given; the raw readings keep their noise."""
    return lambda t: {"slow": pressures(**slow)["slow"]}


def test_the_return_pressure_by_hand():
    """Q = 10.77e-4 * 0.054 = 5.82e-5 m3/s; 5.82e-5/(1.2e-7 * 0.8) = 606; squared 3.67 bar."""
    seen = sight(1.0, np.random.default_rng(1))
    off = differences(seen, seen.slow, SETTINGS)
    assert off.swept == pytest.approx(10.77e-4 * 0.054)
    assert off.line == pytest.approx(0.1e5) and abs(off.flow) < 1e-3 * off.swept
    # 1 bar/s more in a chamber of 8e-4 - 10.77e-4 * 0.154 = 6.34e-4 m3 at 0.7 GPa keeps 9.06e-8 m3/s
    before = seen.slow._replace(pressure_b=seen.slow.pressure_b - 100.0)
    assert differences(seen, before, SETTINGS).flow - off.flow == pytest.approx(9.06e-8, rel=2e-3)


def test_nothing_is_told_of_a_healthy_machine():
    assert told(lambda t: {}, until=20.0) is None


def test_a_machine_without_a_chamber_has_no_reading_of_it():
    """Its other sensors are watched as before; no spring is compared."""
    settings = replace(SETTINGS, spring=replace(SPRING, stiffness=0.0))
    none = {"chamber_pressure": np.nan}
    frozen, lost = CircuitPressures(1e6, 4.7e5, 10e5), CircuitPressures(0.0, 5e5, 10e5)
    assert told(lambda t: none, begin=0.0, until=5.0, settings=settings) is None
    for fast, name in ((frozen, WATCHED[3]), (lost, WATCHED[1])):
        moved = {"line_pressure": fast.line_pressure, "pressure_b": fast.pressure_b}

        def fault(t, fast=fast, moved=moved):
            return none | {"fast": fast._replace(**{key: value + t for key, value in moved.items()})}

        assert told(fault, settings=settings)[0] == name


FAULTS = {
    "lost position": (lambda t: {"position": -0.06}, WATCHED[0], 0.005),
    "lost pressure": (
        lambda t: {"fast": CircuitPressures(0.0, 5e5 + t, 10e5 + t), "chamber_pressure": HELD + t},
        WATCHED[1],
        0.005,
    ),
    "frozen position": (lambda t: {"position": 0.1541, "expected": 0.1541}, WATCHED[2], 0.03),
    "frozen pressure": (lambda t: {"fast": CircuitPressures(1e6, 4.7e5 + t, 10e5 + t)}, WATCHED[3], 0.03),
    "frozen light": (lambda t: {"spool_measured": 4e-3}, WATCHED[4], 0.03),
    "biased position": (lambda t: {"expected": 0.1 + 0.054 * t - 5e-3}, WATCHED[5], 0.002),
    "biased pressure": (
        lambda t: {"fast": CircuitPressures(ATM + 19e5, ATM + BACK + t, ATM + 9e5)},
        WATCHED[13],
        0.001,
    ),
    "biased supply": (noisy(a=14e5), WATCHED[6], 0.1),
    "biased return": (noisy(b=BACK + 8e5), WATCHED[7], 0.1),
    "biased light": (lambda t: {"spool_measured": 6.6e-3 + 1e-5 * t}, WATCHED[8], 0.001),
    "wrong place": (lambda t: {"spool_position": 5.4e-3, "spool_reference": 5.4e-3}, WATCHED[12], 0.15),
    "stuck pilot valve": (lambda t: {"spool_reference": 9e-3}, WATCHED[9], 0.04),
    "stalled spool": (lambda t: {"spool_speed": 5.0}, WATCHED[10], 0.005),
    "lost power": (lambda t: {"pump_speed": 188.5 * np.exp(-(t - 1.0) / 0.1)}, WATCHED[11], 0.02),
    "no number": (lambda t: {"spool_speed": np.nan}, WATCHED[10], 0.005),
}


@pytest.mark.parametrize("name", FAULTS)
def test_each_fault_is_told_by_its_name_and_soon(name):
    fault, expected, soon = FAULTS[name]
    found, after = told(fault)
    assert found == expected
    assert 0.0 <= after <= soon


def test_pressures_are_not_compared_about_a_change_of_direction():
    """What disagrees for 0.2 s from the change on is not told; it is when it lasts."""

    def turned(t):
        return {"direction": -1.0, "velocity": 0.0} | {"slow": pressures(b=1e5)["slow"]}

    brief, lasting = told(turned, until=1.19), told(turned, until=1.4)
    assert brief is None and lasting is not None
    assert lasting[0] in (WATCHED[6], WATCHED[7]) and 0.2 < lasting[1] < 0.26


def test_nothing_is_watched_before_control():
    assert told(lambda t: {"watched": 0.0, "spool_speed": 0.0, "pump_speed": 0.0, "position": np.nan}) is None


def test_an_alarm_stays_and_keeps_its_name():
    memory = alarm_start(2)
    for k in range(10):
        memory = alarm_step(memory, k * H, np.array([0.0, 2.0 if k < 5 else 0.0]), (0.0, 2.5e-3), H)
    assert (memory.alarm, memory.time) == (2.0, 2.0 * H)  # the third sample in a row
    memory = alarm_step(memory, 1.0, np.array([5.0, 0.0]), (0.0, 0.0), H)
    assert (memory.alarm, memory.time) == (2.0, 2.0 * H)


def test_repeats_by_hand():
    memory = repeat_start(1)
    for value, count in ((1.0, 0.0), (1.0, 1.0), (1.0, 2.0), (2.0, 0.0), (2.0, 1.0)):
        memory = repeat_step(memory, np.array([value]))
        assert memory.repeats[0] == count


def test_limits_are_refused():
    from dataclasses import replace

    with pytest.raises(ParameterError, match=r"Supervision\.repeats"):
        replace(LIMITS, repeats=0.0)
    with pytest.raises(ParameterError, match="lowest_pressure"):
        replace(LIMITS, lowest_pressure=2e7)
