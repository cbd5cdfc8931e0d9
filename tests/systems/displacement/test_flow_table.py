"""The flow map of the machine: the specification's table, the mean of a period, and what the circuit delivers."""

from functools import cache

import numpy as np
import pytest
from tests.systems.displacement.machine_texts import SPRING, change, prescribed_text, run_of, system_of

from vvdp.control.flow_map import FlowMap, flow_for_duty
from vvdp.evaluation.summary import run_summary
from vvdp.fluid.oil import density
from vvdp.programs.machine.flow_table import duty_ratios, flow_map_of, valve_condition
from vvdp.valve.flow_map import delivered_flows, quasi_steady_mean

TANK, BAR, LPM = 101325.0, 1e5, 1.0 / 6e4
DUTIES = (0.05, 0.10, 0.12, 0.15, 0.20, 0.30, 0.50, 0.70, 0.90, 1.0, 1.1, 1.25)
TABLE = {
    5.0: (0.15, 1.15, 1.97, 3.72, 6.35, 10.34, 18.31, 26.29, 34.26, 38.24, 39.85, 39.86),
    20.0: (0.13, 0.99, 1.70, 3.23, 6.06, 10.04, 17.98, 25.91, 33.85, 37.82, 39.67, 39.68),
    45.0: (0.08, 0.65, 1.12, 2.11, 4.50, 8.84, 16.71, 24.59, 32.47, 36.41, 39.33, 39.38),
}
"""Mean flow [lpm] over duty ratio, by load pressure [bar], as measured on a prototype."""


@cache
def condition():
    network = system_of(prescribed_text(SPRING), "1 s").circuit.network
    pump, valve, relief = (network.parts[name].values[0] for name in ("pump", "valve", "relief_valve"))
    flow = pump.displacement * network.parts["pump_motor"].inputs["rated_speed"].base
    return valve, valve_condition(flow, density(313.15, network.oil), TANK, pump, relief)


@cache
def the_map() -> FlowMap:
    return flow_map_of(*condition())


@pytest.mark.parametrize("pressure", TABLE)
def test_specified_table(pressure):
    """Within 0.06 lpm, of 40: the specification's own map is read between points that lie further apart."""
    found = [flow_for_duty(d, TANK + pressure * BAR, the_map()) / LPM for d in DUTIES]
    np.testing.assert_allclose(found, TABLE[pressure], atol=0.06)


def test_table_is_the_mean_of_a_period():
    """Between its points too, at all pressures: within 0.02 lpm of four times as many angles; 0.06 near full flow."""
    valve, at = condition()
    for duty in (0.033, 0.077, 0.145, 0.217, 0.455, 0.951, 1.066):
        for pressure in (1.5, 8.0, 33.0):
            mean = quasi_steady_mean(duty, at._replace(load_pressure=TANK + pressure * BAR), valve).load_flow
            found = flow_for_duty(duty, TANK + pressure * BAR, the_map())
            assert abs(found - mean) < (0.02 if duty < 0.5 else 0.06) * LPM


def test_many_duty_ratios_at_once_are_as_one_by_one():
    valve, at = condition()
    here = at._replace(load_pressure=TANK + 20.0 * BAR)
    one_by_one = [quasi_steady_mean(d, here, valve).load_flow for d in DUTIES]
    np.testing.assert_allclose(delivered_flows(np.array(DUTIES), here, valve), one_by_one, atol=2e-4 * at.flow)


def test_many_pressures_at_once_have_the_bits_of_one_by_one():
    valve, at = condition()
    duties, pressures = np.array(DUTIES), TANK + BAR * np.array([0.0, 5.0, 20.0, 45.0])
    one_by_one = [delivered_flows(duties, at._replace(load_pressure=p), valve) for p in pressures]
    together = delivered_flows(duties, at._replace(load_pressure=pressures[:, np.newaxis]), valve)
    assert np.array_equal(together, one_by_one)


def test_map_goes_from_no_flow_to_all_of_it():
    flows = np.array(the_map().flows).reshape(-1, len(the_map().duty_ratios))
    assert np.all(flows[:, 0] == 0.0)
    assert duty_ratios(0.3)[[0, -1]] == pytest.approx([-0.3, 1.3])
    leak = condition()[1].flow - flows[0, -1]
    assert 0.0 < leak < 0.2 * LPM  # the pump's own at the pressure of the open valve


def delivered(duty: float, opening: float) -> tuple[float, float]:
    """Mean flow [lpm] and line pressure [bar] of the circuit while the cylinder extends, its spool held at a stop."""
    stop = duty * 20.32 + 211.5 / 2e7 * 1e3  # the spring presses it in so far
    text = change(
        prescribed_text(SPRING, direction="1", opening=f"{opening}"),
        axial_stops__lower_end=f"{stop:.5f} mm",
        initial__axial_position=f"{stop:.5f} mm",
        initial__spool_angle="15 deg",
    )
    found = run_summary(*run_of(text, "1.4 s", "0.9 s"))
    return found["flow_mean_valve_load_m3_s"] / LPM, found["pressure_mean_line_Pa"] / BAR


@pytest.mark.parametrize(("duty", "opening", "within"), [(0.12, 0.3, 0.02), (0.2, 0.8, 0.015), (0.5, 0.9, 0.005)])
def test_circuit_delivers_what_the_map_says(duty, opening, within):
    """1.6, 1.1 and 0.2 % more: while a port opens, the rail gives back what it stored."""
    flow, pressure = delivered(duty, opening)
    mapped = flow_for_duty(duty, TANK + pressure * BAR, the_map()) / LPM
    assert flow == pytest.approx(mapped, rel=within)
