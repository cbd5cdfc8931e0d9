"""Pressure drop against flow: published and worked-out numbers, laws, and what is said of it."""

import numpy as np
import pytest

from vvdp.rigs.pressure_drop import pressure_drop
from vvdp.valve.branch import branch_flow

LPM = 1e-3 / 60.0


@pytest.fixture(scope="module")
def found(source_stand):
    return pressure_drop(source_stand, flows=[10 * LPM, 20 * LPM, 40 * LPM, 60 * LPM])


def column(found, name, opening=1.0):
    table = found.tables["pressure-drop"]
    return table[name][table["opening"] == opening]


def test_worked_numbers(found):
    """Bar at 10, 20, 40, 60 lpm: nozzles 876/2 (Q/(0.61 36.5e-6))^2, and so on; sums 0.424, 1.682, 6.677, 14.957."""
    total = column(found, "pressure_drop_total_Pa") / 1e5
    np.testing.assert_allclose(total, [0.424, 1.6822, 6.6765, 14.9568], rtol=1e-3)
    np.testing.assert_allclose(column(found, "pressure_drop_nozzle_Pa")[2] / 1e5, 3.9269, rtol=1e-4)
    np.testing.assert_allclose(column(found, "pressure_drop_centre_section_Pa")[2] / 1e5, 0.8105, rtol=1e-3)
    np.testing.assert_allclose(column(found, "pressure_drop_outlet_turbine_Pa")[2] / 1e5, 1.9392, rtol=1e-3)


def test_published_drop(found):
    """wang2017, section 2.6: 6.61 bar at 40 lpm, with rounded coefficients: 2 %."""
    assert found.numbers["pressure_drop_total_Pa"].value == pytest.approx(6.61e5, rel=0.02)


def test_sections_add_up_and_loss_is_flow_times_drop(found):
    table = found.tables["pressure-drop"]
    parts = sum(table[f"pressure_drop_{name}_Pa"] for name in ("nozzle", "centre_section", "outlet_turbine"))
    np.testing.assert_allclose(parts, table["pressure_drop_total_Pa"])
    np.testing.assert_allclose(table["loss_W"], table["flow_m3_s"] * table["pressure_drop_total_Pa"])


def test_flow_law_gives_the_flow_back(source_stand, found):
    table, valve = found.tables["pressure-drop"], source_stand.bench.valve
    back = branch_flow(table["pressure_drop_total_Pa"], table["opening"], 876.0, valve).flow
    # The flow law is smoothed: with transition pressure eps it gives q (1 - eps^2/(4 dp^2)) and less.
    shares = (valve.transition_pressure / table["pressure_drop_total_Pa"]) ** 2
    np.testing.assert_allclose(1.0 - back / table["flow_m3_s"], 0.25 * shares, rtol=0.1, atol=1e-7)


def test_drops_are_not_smoothed_at_small_flows(source_stand):
    """The nozzles at 2 lpm: 876/2 (3.333e-5/(0.61 36.5e-6))^2 = 982 Pa, and exactly a quarter of it at 1 lpm."""
    table = pressure_drop(source_stand, flows=[1 * LPM, 2 * LPM], openings=[1.0]).tables["pressure-drop"]
    low, high = table["pressure_drop_nozzle_Pa"]
    assert high == pytest.approx(981.7, rel=2e-3)
    assert low == pytest.approx(0.25 * high, rel=1e-12)


def test_drop_grows_with_flow_and_as_ports_close(found):
    for opening in (1.0, 0.5, 0.25):
        assert np.all(np.diff(column(found, "pressure_drop_total_Pa", opening)) > 0.0)
    wide, half = (column(found, "pressure_drop_nozzle_Pa", opening) for opening in (1.0, 0.5))
    np.testing.assert_allclose(half, 4.0 * wide, rtol=1e-12)


def test_temperature_acts_through_density_alone(source_stand):
    """Over density the nozzles' drop is the same at 20 and 60 degC; the Reynolds number grows as the oil thins."""
    found = pressure_drop(source_stand, flows=[40 * LPM], temperatures=[293.15, 333.15], openings=[1.0])
    cold, warm = found.tables["pressure-drop"]["pressure_drop_nozzle_Pa"]
    # 7e-4 1/K over 40 K: 2.8 % less dense.
    assert warm / cold == pytest.approx(1.0 - 7e-4 * 40.0, rel=2e-3)
    reynolds = found.tables["pressure-drop"]["nozzle_reynolds_number"]
    assert reynolds[1] > 2.0 * reynolds[0]


def test_manner_and_doubt_are_stated(found):
    assert "ISO 4411" in found.manner
    assert any("below 2300" in finding.text for finding in found.findings)
    assert found.references == ("iso4411",)
