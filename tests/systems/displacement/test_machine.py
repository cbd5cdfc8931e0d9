"""The whole machine on prescribed commands: balances, start and stop, idling, powers, what is refused."""

import re

import numpy as np
import pytest
from tests.systems.displacement.machine_texts import (
    GEROTOR,
    IDEAL,
    SPRING,
    change,
    prescribed_text,
    run_of,
    step,
    system_of,
)

from vvdp.base.errors import ConfigError, ParameterError
from vvdp.base.tables import parsed_table
from vvdp.evaluation.summary import run_summary
from vvdp.evaluation.validity import broken_bounds
from vvdp.programs.machine.checks import CylinderDuty, working_pressures
from vvdp.programs.machine.power import PARTS, mean_powers, whole_periods
from vvdp.simulation.balance import balance_between
from vvdp.simulation.values import flat
from vvdp.systems.system import built_system, shipped_systems

STOP = 0.9
"""When everything is switched off [s]."""


@pytest.fixture(scope="module")
def stopped():
    """The cylinder extends with the spool held at 4 mm; then all is de-energised at once."""

    def off(before):
        return step(before, "0", f"{STOP} s")

    commands = {"direction": off("1"), "opening": off("0.8"), "pump": off("1"), "drive": step("0", "-1", f"{STOP} s")}
    text = change(
        prescribed_text(SPRING, **commands),
        initial__axial_position="4 mm",
        initial__chamber_pressure="12.75 bar",  # (211.5 N + 2594 N/m 4 mm)/174 mm2
        run__record_interval="0.2 ms",
    )
    return run_of(text, "1.5 s")


def test_balances_close(stopped):
    found = run_summary(*stopped)
    assert max(abs(found["energy_residual"]), abs(found["mass_residual"])) < 1e-7


def test_motor_starts_and_coasts_down(stopped):
    run = stopped[1]
    speed, after = run.state.pump_motor.speed, run.times > STOP
    rated = 2.0 * np.pi * 30.0
    assert np.interp(0.15, run.times, speed) == pytest.approx(0.5 * rated, rel=1e-4)
    assert np.interp(STOP, run.times, speed) == pytest.approx(rated, rel=1e-6)
    np.testing.assert_allclose(speed[after], rated * np.exp(-(run.times[after] - STOP) / 0.1), rtol=1e-5)


def test_emergency_stop_empties_the_line(stopped):
    """The spring has the spool below 0 after 5.8 ms (specified: 20 at most); the pressure of the line does not rise."""
    run = stopped[1]
    after = run.times > STOP
    below = run.times[after & (run.state.slide.position < 0.0)][0] - STOP
    assert 3e-3 < below < 10e-3
    assert np.max(run.state.line[after]) < np.interp(STOP, run.times, run.state.line) * 1.01
    rod = run.state.rod.position
    assert np.max(rod[after]) - np.interp(STOP, run.times, rod) < 1e-3


def idle(stop: str) -> dict:
    text = change(
        prescribed_text(SPRING),
        axial_stops__lower_end=stop,
        initial__axial_position=stop,
        initial__spool_angle="15 deg",
        valve__jet_exponent="0",
    )
    return run_summary(*run_of(text, "1 s", "0.6 s"))


def test_idling_below_zero_saves_power():
    """434 W and 70.6 Hz at -6.2 mm, 877 W and 67.3 Hz at 0, where the tank port shuts in every period: 861 W and
    67.6 Hz on the prototype."""
    low, zero = idle("-6.2 mm"), idle("0 mm")
    assert low["power_pump_shaft_W"] == pytest.approx(434.0, abs=2.0)
    assert zero["power_pump_shaft_W"] == pytest.approx(861.0, rel=0.03)
    assert zero["power_pump_shaft_W"] - low["power_pump_shaft_W"] > 300.0
    hertz = 3.0 / (2.0 * np.pi)
    assert low["speed_mean_spool_rad_s"] * hertz == pytest.approx(70.6, abs=0.2)
    assert zero["speed_mean_spool_rad_s"] * hertz == pytest.approx(67.6, abs=0.5)
    assert low["loss_relief_valve_W"] == 0.0 < zero["loss_relief_valve_W"]


def test_powers_are_those_of_the_books(stopped):
    """All losses, what the load takes and what is stored are what pump and axial drive give."""
    system, run = stopped
    found = mean_powers(run, 0.2, 0.8)
    losses = sum(value for key, value in found.items() if "_loss_" in key)
    rows = [int(np.argmin(np.abs(run.times - time))) for time in (0.2, 0.8)]
    states = [run.states[row] for row in rows]
    stored = balance_between(system.model, run.case, *states).energy_stored / 0.6
    spool = found["spool_friction_mean_W"] + _mean(run, rows, "to_spool") / 0.6
    given = found["pump_power_mean_W"] + found["load_power_mean_W"]
    assert losses + spool + stored == pytest.approx(given, rel=1e-6)


def _mean(run, rows, loss):
    column = getattr(run.state.books.spent.valve, loss)
    return float(column[rows[1]] - column[rows[0]])


def test_meters_by_another_sum(stopped):
    """Means of the meters against sums over recorded rows, 0.2 ms apart."""
    run = stopped[1]
    chosen = (run.times >= 0.5) & (run.times <= 0.85)
    times, found = run.times[chosen], mean_powers(run, 0.5, 0.85)

    def mean(values):
        return np.trapezoid(values[chosen], times) / (times[-1] - times[0])

    force = run.outputs.cylinder_rod * run.state.rod.velocity
    assert found["actuator_power_mean_W"] == pytest.approx(mean(np.clip(force, 0.0, None)), rel=1e-3)
    into_a = np.clip(run.outputs.directional_valve_a_flow, 0.0, None)
    supplied = mean(into_a * (run.state.chamber_a - 101325.0))
    assert found["ideal_pump_power_mean_W"] == pytest.approx(supplied, rel=1e-2)  # h is P within the oil's compression
    assert 0.0 < found["transition_loss_mean_W"] < _mean_nozzle(run)


def _mean_nozzle(run):
    rows = [int(np.argmin(np.abs(run.times - time))) for time in (0.5, 0.85)]
    return _mean(run, rows, "nozzle") / 0.35


def test_every_power_is_in_the_books():
    """No path of the table leads nowhere in all machines."""
    known = set()
    for circuit in (SPRING, GEROTOR):
        from vvdp.simulation.values import leaves

        case = system_of(prescribed_text(circuit), "1 s").case
        known |= {path for path, _, _ in leaves(case.state.books)}
    assert {path for _, paths in PARTS.values() for path in paths} <= known


def test_whole_periods(stopped):
    assert whole_periods(stopped[1], 0.3, 0.5) == pytest.approx((0.3, 1.3))
    with pytest.raises(ParameterError, match="a whole period from 1 s on takes 8 s"):
        whole_periods(stopped[1], 1.0, 8.0)


def test_every_chamber_that_cavitates_is_told(stopped):
    """Each with its pressure, the lowest first."""
    system, _ = stopped
    found = run_summary(*stopped)
    assert broken_bounds(system, found) == []
    low = found | {"pressure_min_chamber_a_Pa": -0.8e5, "pressure_min_line_Pa": -0.9e5}
    told = broken_bounds(system, low)
    assert [text.partition(":")[0] for text in told] == [
        "lowest absolute pressure, at line",
        "lowest absolute pressure, at chamber a",
    ]


@pytest.mark.parametrize("circuit", [GEROTOR, IDEAL])
def test_other_drives_have_the_same_machine(circuit):
    """Rates of all that the machines share are the same at an instant."""

    def rates(system):
        case = system.case
        return system.model.circuit(0.0, case.state, case.command, case.params)[0]

    one, other = rates(system_of(prescribed_text(SPRING), "1 s")), rates(system_of(prescribed_text(circuit), "1 s"))
    for name in ("inlet", "line", "chamber_a", "chamber_b", "rod", "spool", "pump_motor", "directional_valve"):
        np.testing.assert_allclose(flat(getattr(other, name)), flat(getattr(one, name)), rtol=1e-12)


@pytest.mark.slow
def test_dump_valve_empties_the_line():
    """The gerotor leaves its spool where it was: without the dump valve the coasting pump charges the line."""

    def peak(dump):
        off = step("1", "0", f"{STOP} s")
        commands = {"direction": off, "opening": step("0.8", "0", f"{STOP} s"), "pump": off, "drive": "0", "dump": dump}
        text = change(prescribed_text(GEROTOR, **commands), initial__axial_position="5 mm")
        run = run_of(text, "1.5 s")[1]
        before = np.interp(STOP, run.times, run.state.line)
        return before, float(np.max(run.state.line[run.times > STOP]))

    before, shut = peak("1")
    _, opened = peak(step("1", "0", f"{STOP} s"))
    assert shut > before + 5e5
    assert opened < before + 1e5


def test_working_pressures_by_hand():
    """54 mm/s at 80 % opening: 3.67 bar in the return while extending, 13.0 while retracting."""
    parts = system_of(prescribed_text(SPRING), "1 s").circuit.network.parts
    cylinder, friction, valve = (parts[name].values[0] for name in ("cylinder", "friction", "directional_valve"))
    duty = CylinderDuty(-1000.0, -1000.0, 0.054, 0.8)
    found = working_pressures(duty, cylinder, friction, valve.return_conductance)
    back_b, back_a = (10.77e-4 * 0.054 / 0.96e-7) ** 2, (20.26e-4 * 0.054 / 0.96e-7) ** 2
    assert back_b == pytest.approx(3.67e5, rel=1e-3)
    assert found.extending == pytest.approx((1000.0 + 108.0 + back_b * 10.77e-4) / 20.26e-4, rel=1e-12)
    assert found.retracting == pytest.approx((-1000.0 + 108.0 + back_a * 20.26e-4) / 10.77e-4, rel=1e-12)


@pytest.mark.parametrize(
    ("changes", "key", "message"),
    [
        (
            {"operation__load_force": "-13 kN"},
            "operation.load_force",
            r"extending takes 6\d\.\d+ bar .* opens at 60 bar",
        ),
        ({"line__precharge_pressure": "20 bar"}, "line.precharge_pressure", r"20 bar; the line works at 16\.\d+ bar"),
        ({"chamber_a__oil_volume": "0 l"}, "chamber_a.oil_volume", "0 cc must be greater than 0"),
        ({"cylinder_stops__upper_end": "0.4 m"}, "cylinder_stops.upper_end", "400 mm; the stroke .* 300 mm"),
        ({"axial_stops__upper_end": "20 mm"}, "axial_stops.upper_end", r"20 mm; the stroke ends below 26\.42 mm"),
        ({"pump__displacement": "3 cc/rev"}, "cycle", r"54 mm/s .* 44\.4\d* mm/s"),
    ],
)
def test_impossible_demands_are_told_before_a_run(changes, key, message):
    text = change(shipped_systems()["displacement-control"], **changes)
    with pytest.raises(ConfigError) as problem:
        built_system(parsed_table(text, "machine"), "machine")
    fault = problem.value.faults[0]
    assert fault.key == key or fault.key.startswith(key)
    assert re.search(message, fault.message)
    assert fault.line > 0
