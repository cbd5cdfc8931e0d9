"""Levers on the transition loss: each at its best, borne out by simulation, as the page has it."""

import json
import re
from pathlib import Path

import numpy as np
import pytest
from tests.words import wording

from vvdp.design.levers import LEVERS, LOAD_SHARES, levers, limit_loss, valve_loss
from vvdp.design.levers_result import levers_result
from vvdp.design.quantities import quantities
from vvdp.design.variables import with_variables
from vvdp.systems.system import load_system
from vvdp.valve.losses import best_relief_pressure

pytestmark = pytest.mark.thorough

PAGE = (Path(__file__).parents[2] / "docs/design.md").read_text("utf-8")


@pytest.fixture(scope="module")
def system():
    return load_system("prototype-constant-load")


@pytest.fixture(scope="module")
def closed(system):
    return {each.lever.name: each for each in levers(system, simulated=False)}


def mean_loss(pulled, **changes):
    at = [with_variables(at, {**pulled.values, **changes}) for at in pulled.points]
    return np.mean([float(quantities(each).loss_total) for each in at])


@pytest.mark.parametrize("lever", ["underlap", "underlap, spool and areas"])
def test_no_other_lap_loses_less(closed, lever):
    pulled = closed[lever]
    least = mean_loss(pulled)
    assert all(mean_loss(pulled, lap_ratio=lap) >= least - 1e-6 for lap in np.linspace(0.35, 1.4, 43))


def test_a_relief_setting_that_follows_is_the_best_one_at_each_load(closed):
    """By golden section on the transition loss alone; what else depends on the setting is nothing."""
    pulled = closed["relief setting follows the load"]
    for at in pulled.points:
        rho = 876.0
        best = best_relief_pressure(at.flow, at.load_pressure, at.tank_pressure, rho, at.valve)
        assert at.relief_pressure == pytest.approx(best, rel=2e-3)


def test_every_lever_keeps_the_frequency_and_saves(closed):
    before = closed["as it is"]
    wanted = np.mean([q.pwm_frequency for q in before.closed])
    for pulled in closed.values():
        if pulled.lever.scale != 1.0:
            continue
        assert np.mean([q.pwm_frequency for q in pulled.closed]) >= wanted * (1.0 - 1e-6)
        assert sum(map(valve_loss, pulled.closed)) <= sum(map(valve_loss, before.closed)) + 1e-6
        assert sum(map(limit_loss, pulled.closed)) < sum(map(valve_loss, pulled.closed))
    assert set(closed) == {lever.name for lever in LEVERS}


def test_a_scaled_valve_keeps_its_transitions_and_drops_by_the_fourth_power(closed):
    """kappa = sqrt(2 A / (pi R L)) stays; drops of nozzles and outlet go with 1/A^2, of the centre with 1/D^3.22."""
    was, small = closed["as it is"], closed["a valve of 0.8 times the size"]
    for before, after in zip(was.closed, small.closed, strict=True):
        assert after.transition_fraction == pytest.approx(before.transition_fraction, rel=1e-9)
        for part, power in (("nozzle", 4.0), ("outlet_turbine", 4.0), ("centre_section", 3.22)):
            name = f"pressure_drop_{part}"
            assert getattr(after, name) == pytest.approx(getattr(before, name) * 0.8**-power, rel=1e-9)
    assert sum(map(valve_loss, closed["a valve of 1.25 times the size"].closed)) < sum(map(valve_loss, was.closed))


def test_a_duty_ratio_at_which_no_port_opens_fully_is_refused(designing):
    code, _, err = designing("levers", "prototype-constant-load", "--set", "operation.duty_ratio=0.1")
    assert code == 2
    assert wording.valve.duty_ratio_outside.format(duty=0.1) in err


@pytest.mark.slow
def test_levers_are_borne_out_by_simulation_as_the_page_says(designing, keys_as_described):
    code, out, err = designing("levers", "prototype-constant-load", "--json", "--out", "there")
    assert code == 0, err
    told = json.loads(out)
    keys_as_described("design levers", told)
    assert told["warnings"] == []
    assert np.max(np.abs(told["levers_difference"])) < 6e-3
    stiff, formula = np.array(told["levers_stiff_loss_W"]), np.array(told["levers_closed_loss_W"])
    assert stiff[0] - stiff[1:] == pytest.approx(formula[0] - formula[1:], rel=0.004)
    assert max(told["levers_residual"]) < 1e-8
    assert len(told["loads_loss_W"]) == len(LEVERS) * len(LOAD_SHARES)
    table = PAGE.partition("| lever | loss, simulated [W] |")[2].partition("\n\n")[0]
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in table.splitlines()[2:]]
    assert [float(row[1]) for row in rows] == pytest.approx(told["levers_loss_W"], abs=0.51)
    assert [float(row[3]) for row in rows] == pytest.approx(told["levers_limit_W"], abs=0.51)
    savings = [float(row[2].removesuffix(" %")) for row in rows[1:]]
    assert savings == pytest.approx([100.0 * saving for saving in told["levers_saving"][1:]], abs=0.51)
    assert [float(row[4]) for row in rows] == pytest.approx(told["levers_simulated_pwm_frequency_Hz"], abs=0.51)
    assert re.search(r"lap ratio 0\.59\d", told["levers_values"][3])


def test_the_page_without_simulation_has_the_closed_forms(system, closed):
    result = levers_result(system, list(closed.values()))
    assert "loss_W" not in result.tables["levers"].columns
    assert result.numbers["loss_before_W"].value == pytest.approx(1764.0, abs=0.5)
    assert result.numbers["loss_limit_W"].value == pytest.approx(459.7, abs=0.05)
    assert result.flat["levers_values"][0] == ""
