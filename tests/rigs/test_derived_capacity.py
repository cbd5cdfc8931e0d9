"""Derived capacity and the efficiencies against it: by hand, by laws, simulated beside averages."""

from dataclasses import replace

import numpy as np
import pytest
from tests.words import wording

from vvdp.fluid.mixture import enthalpy, specific_volume_ratio
from vvdp.rigs.capacity import (
    averaged_flows,
    capacity_points,
    capacity_pressures,
    derived_capacities,
    zero_pressure_flow,
)
from vvdp.rigs.derived_capacity import derived_capacity
from vvdp.rigs.map_axes import Axes
from vvdp.rigs.map_result import map_result
from vvdp.rigs.maps import analytic_map, simulated_map
from vvdp.steady.test_stand import stand
from vvdp.systems.system import load_system

ZERO, SPEED = 101325.0, 188.49555921538757
Q = 40e-3 / 60.0
THREE = Axes((0.25, 0.5, 0.75), (ZERO + 100e5,), (SPEED,), (313.15,))


@pytest.fixture(scope="module")
def found(source_stand):
    return derived_capacity(source_stand, (0.25, 0.5, 0.75, 1.0))


def averaged_capacity(held, duty_ratios):
    points = capacity_points(held, duty_ratios, (held.set_point.pump_speed,), (313.15,))
    return derived_capacities(held, points, averaged_flows(held, points))


def test_line_by_hand():
    """Flows 10, 9 and 8 at 1, 2 and 3 begin at 11; 10, 9 and 9.5 have the slope -0.25 about 9.5 at 2: 10. What is
    missing stays so, and leaves the others alone."""
    flows = np.array([[10.0, 9.0, 8.0], [10.0, 9.0, 9.5], [np.nan, 9.0, 8.0]])
    np.testing.assert_allclose(zero_pressure_flow(flows, np.array([1.0, 2.0, 3.0])), [11.0, 10.0, np.nan], rtol=1e-14)


def test_pressures_are_spread_evenly(source_stand):
    np.testing.assert_allclose(capacity_pressures(source_stand) - ZERO, np.array([4e5, 8e5, 12e5, 16e5, 20e5]))


def test_capacity_is_what_the_averages_deliver_without_load(source_stand):
    """Quasi-steady flow over d D omega at no load: 0.891, 0.945, 0.964 and 0.973, by an independent program; the
    straight line through the low pressures begins within 1e-3 of it."""
    d = (0.25, 0.5, 0.75, 1.0)
    over = averaged_capacity(source_stand, d) / np.array(d) / source_stand.bench.pump.displacement
    np.testing.assert_allclose(over, [0.891, 0.945, 0.964, 0.973], atol=1e-3)


def test_capacity_grows_with_the_duty_ratio_and_falls_with_the_speed(found):
    table = found.tables["speeds"]
    over = table["averaged_over_commanded"].reshape(5, 4)
    assert np.all(np.diff(over, axis=0) < 0.0)
    assert np.all(np.diff(over, axis=1) > 0.0)
    # What is lost without load grows with the square of the flow: its share of it with the flow, but for the centre
    # section, whose exponent is 1.91, and the swing of a*, which depends on the relief setting over the drop.
    lost = 1.0 - over[:, 1]
    np.testing.assert_allclose(lost / table["pump_speed_rad_s"].reshape(5, 4)[:, 1], lost[-1] / SPEED, rtol=0.02)


def test_simulated_beside_averages(found, source_stand):
    """The inlet takes up oil that the ideal relief valve would pass, so that a little more is delivered than on
    average, most at small duty ratios; with stiff oil nothing of that is left."""
    table = found.tables["capacity"]
    np.testing.assert_allclose(table["derived_over_commanded"], [0.910, 0.953, 0.968, 0.977], atol=6e-4)
    more = table["derived_capacity_m3_rad"] / table["averaged_capacity_m3_rad"] - 1.0
    assert np.all(np.diff(more) < 0.0)
    assert np.all((more > 0.0) & (more < 0.025))
    stiff = source_stand.with_tables(oil={"air_fraction": 0.0, "liquid_bulk_modulus": 1.4e11})
    both = derived_capacity(stiff, (0.5,)).numbers
    assert both["derived_capacity_m3_rad"].value == pytest.approx(both["averaged_capacity_m3_rad"].value, rel=1e-3)


def test_numbers_are_those_of_the_system_itself(found, source_stand):
    """Duty ratio 0.5: a row of the table, and half the displacement commanded."""
    table = found.tables["capacity"]
    row = int(np.flatnonzero(table["duty_ratio"] == 0.5)[0])
    for key, number in found.numbers.items():
        assert number.value == table[key][row]
    commanded = found.numbers["commanded_capacity_m3_rad"].value
    assert commanded == pytest.approx(0.5 * source_stand.bench.pump.displacement, rel=1e-12)
    assert wording.rig.of_commanded.format(share="95.3 %", displacement="11.11 cm³/rev") in found.findings[0].text


def test_a_lag_of_the_relief_valve_is_said():
    changes = ["relief_valve.override_pressure=10 bar", "relief_valve.opening_time=5 ms"]
    lagging = stand(load_system("prototype-constant-load", changes))
    (told,) = map_result(analytic_map(lagging, THREE)).flat["warnings"]
    assert told.startswith(wording.rig.averages_do_not_hold.format(lag="5 ms"))


def test_three_points_by_hand(source_stand):
    """Duty ratios 0.25, 0.5 and 0.75 against 100 bar: the closed forms of docs/models/rotary-valve.md, step by step.

    Drops of the open valve at 40 lpm: nozzles n = 3.9269 bar, the rest r = 0.8105 + 1.9392 = 2.7497 bar. A ramp takes
    kappa/2 = 0.15005 of a period; the load misses 2 x 0.15005 (a* - Qv) = 0.3001 (a* - Qv) of the pump flow.

    at 100 bar, H = 20 bar: a* = root(3.9269/(20 - 2.7497)) = 0.47712
        Qv = root(20) 0.47712^2/(root(3.9269 + 2.7497 x 0.47712^2) + root(3.9269))
           = 1.01805/(2.13374 + 1.98164) = 0.24738
        missed 0.3001 x 0.22974 = 0.06894
    at no load, H = 120 bar: a* = root(3.9269/(120 - 2.7497)) = 0.18301
        Qv = root(120) 0.18301^2/(root(3.9269 + 2.7497 x 0.18301^2) + root(3.9269))
           = 0.36687/(2.00474 + 1.98164) = 0.09203
        missed 0.3001 x 0.09098 = 0.02730
    """
    missed, missed_unloaded = 0.06894, 0.02730
    # Through the load port, in parts of the pump flow, and without load.
    through = np.array([0.25 - missed, 0.5 - missed, 0.75 - missed])  # 0.18106, 0.43106, 0.68106
    unloaded = np.array([0.25 - missed_unloaded, 0.5 - missed_unloaded, 0.75 - missed_unloaded])  # 0.2227 ...
    # The valve leaks 26.3 W at 100 bar, 26.3/(100e5 x 6.6667e-4) = 0.003945 of the pump flow.
    delivered = through - 0.003945  # 0.17712, 0.42712, 0.67712
    # Load power: delivered x 6666.7 W. Lost: open valve 445.1 W, transitions 1333.2 W, leakage 26.3 W.
    load_power = delivered * 6666.7  # 1180.8, 2847.5, 4514.2 W
    loss = 445.1 + 1333.2 + 26.3  # 1804.6 W
    input_power = load_power + loss  # 2985.4, 4652.1, 6318.8 W

    quick = analytic_map(source_stand, THREE)
    columns = quick.columns
    np.testing.assert_allclose(columns["delivered_flow_m3_s"], delivered * Q, rtol=5e-4)
    # Outside kappa to 1 - kappa = 0.3001 to 0.6999 a port never opens fully; that costs 0.1 % of the loss.
    np.testing.assert_allclose(columns["loss_total_W"], loss, rtol=1.2e-3)
    np.testing.assert_allclose(columns["input_power_W"], input_power, rtol=1e-3)
    np.testing.assert_allclose(columns["input_power_W"], columns["load_power_W"] + columns["loss_total_W"], rtol=1e-12)
    # Commanded: delivered over 0.25, 0.5 and 0.75. Through the port alone, 0.724, 0.862 and 0.908.
    np.testing.assert_allclose(through / [0.25, 0.5, 0.75], [0.724, 0.862, 0.908], atol=5e-4)
    np.testing.assert_allclose(columns["volumetric_efficiency_commanded"], [0.7085, 0.8542, 0.9028], atol=2e-4)
    # ISO: delivered over what the setting delivers without load. Through the port alone, 0.813, 0.912 and 0.942.
    np.testing.assert_allclose(through / unloaded, [0.813, 0.912, 0.942], atol=5e-4)
    np.testing.assert_allclose(columns["volumetric_efficiency_iso"], delivered / unloaded, rtol=1e-3)
    np.testing.assert_allclose(columns["volumetric_efficiency_iso"], [0.7953, 0.9036, 0.9369], atol=5e-4)
    # Overall: 0.3955, 0.6121, 0.7144; hydromechanical the quotient of the two.
    for key in ("overall_efficiency", "overall_efficiency_iso"):
        np.testing.assert_allclose(columns[key], [0.3955, 0.6121, 0.7144], atol=5e-4)
    np.testing.assert_allclose(columns["hydromechanical_efficiency_commanded"], [0.5582, 0.7166, 0.7913], atol=1e-3)
    np.testing.assert_allclose(columns["hydromechanical_efficiency_iso"], [0.4973, 0.6774, 0.7625], atol=1e-3)


def test_outlet_volume_and_power_of_a_simulated_point(source_stand, tmp_path):
    """At 100 bar with 1 % air the oil has 0.9834 of its volume. ISO's power is that volume flow times the pressure,
    which is less than the enthalpy by what the oil stores: P/(2 beta) = 100e5/(2 x 1.2e9) = 0.42 % of it."""
    one = replace(THREE, duty_ratios=(0.5,))
    found = {name: values[0] for name, values in simulated_map(source_stand, one, tmp_path).columns.items()}
    oil = source_stand.bench.oil
    ratio = specific_volume_ratio(ZERO + 100e5, oil)
    assert ratio == pytest.approx(0.9834, abs=1e-4)
    assert found["outlet_flow_m3_s"] == pytest.approx(ratio * found["delivered_flow_m3_s"], rel=1e-9)
    commanded, iso = found["volumetric_efficiency_commanded"], found["volumetric_efficiency_iso"]
    capacity = found["derived_capacity_m3_rad"] / (0.5 * source_stand.bench.pump.displacement)
    assert iso == pytest.approx(commanded * ratio / capacity, rel=1e-9)
    share = ratio * 100e5 / (enthalpy(ZERO + 100e5, oil) - enthalpy(ZERO, oil))
    assert found["overall_efficiency_iso"] / found["overall_efficiency"] == pytest.approx(share, rel=1e-4)
    assert share == pytest.approx(1.0 - 0.0042, abs=1e-4)
