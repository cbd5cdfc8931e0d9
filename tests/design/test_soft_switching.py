"""Soft switching: its means against closed forms that know nothing of angles, and what the page says of the circuit."""

import re
from pathlib import Path

import numpy as np
import pytest
from tests.words import wording

from vvdp.base.errors import ConfigError, ParameterError
from vvdp.base.select import minimum
from vvdp.base.tables import parsed_table
from vvdp.design.levers import levers
from vvdp.design.problem import problem
from vvdp.design.quantities import quantities, setup, switching_condition
from vvdp.design.soft_switching import (
    Softening,
    SoftMeans,
    best_chamber,
    soft_means,
    soft_quantities,
    soft_rig,
    usual_bypass,
)
from vvdp.evaluation.bench import rotary_bench
from vvdp.evaluation.bench_parts import is_bench
from vvdp.hydraulics.check_valve import CheckValve
from vvdp.hydraulics.soft_switching import Mouth, SwitchChamber, released_area
from vvdp.simulation.values import flat
from vvdp.steady.steady_states import steady_states
from vvdp.steady.test_stand import stand
from vvdp.systems.system import built_system, load_system, source_text
from vvdp.valve.geometry import nozzle_width, pitch
from vvdp.valve.losses import full_open_drop, transition_loss

PAGE = (Path(__file__).parents[2] / "docs/models/soft-switching.md").read_text("utf-8")
REFERENCE = 101325.0
FLOW = 40.0 / 6e4


@pytest.fixture(scope="module")
def system():
    return load_system("prototype-constant-load")


@pytest.fixture(scope="module")
def at(system):
    return setup(system)


def with_soft(system, **chamber):
    return soft_rig(system, Softening(usual_bypass(FLOW), SwitchChamber(**chamber) if chamber else None))


def steep_check(level):
    """A check valve that holds its drop at `level` whatever flows."""
    return CheckValve(cracking_pressure=level, rated_drop=1.01 * level, rated_flow=0.1)


def test_an_area_opens_with_the_tank_port():
    mouth = Mouth()
    assert released_area(0.0, mouth) == 0.0
    assert released_area(0.004, mouth) == pytest.approx(0.4e-4)
    assert released_area(0.3, mouth) == 1e-4


def test_a_chamber_that_gives_no_room_is_refused():
    values = {"oil_volume": 1e-6, "hose_compliance": 0.0, "precharge_pressure": 1e6, "gas_exponent": 1.4}
    with pytest.raises(ParameterError, match=wording.design.gives_no_room):
        SwitchChamber(**values, gas_volume=0.0)
    with pytest.raises(
        ParameterError, match="release_opening: " + wording.files.must_be_greater_than_zero.format(value=0)
    ):
        Mouth(mouth_area=1e-4, release_opening=0.0)


def test_a_check_valve_alone_is_a_relief_valve_whose_oil_reaches_the_load(at):
    """L = L_trans(P_L + D) - Q_R (P_L - P_T), with D above the drop of the open valve."""
    level = 10e5
    found = soft_means(at, Softening(steep_check(level), None), angles=600)
    relieved = transition_loss(switching_condition(at)._replace(relief_pressure=at.load_pressure + level), at.valve)
    saved = relieved.relief_flow * (at.load_pressure - at.tank_pressure)
    loss = float(quantities(at).loss_full_open) + relieved.loss - saved
    assert found.loss == pytest.approx(loss, rel=2e-3)
    assert found.held == 0.0


def test_a_chamber_of_constant_pressure_by_quadrature(at):
    """Its volume from the drops alone: filled in both transitions, emptied through the open port."""
    over, level = 15e5, 10e5
    chamber = SwitchChamber(
        oil_volume=1e-6, hose_compliance=0.0, gas_volume=0.05, precharge_pressure=at.tank_pressure + over,
        gas_exponent=1.4,
    )  # fmt: skip
    mouth = Mouth(mouth_area=0.05, release_opening=1e-4)
    found = soft_means(at, Softening(steep_check(level), chamber, mouth), angles=600)
    drops = full_open_drop(at.flow, switching_condition(at).density, at.valve)
    n, r = drops.nozzle, drops.centre_section + drops.outlet_turbine
    ramp = nozzle_width(at.valve) / pitch(at.valve)
    a = (np.arange(20000) + 0.5) / 20000
    passed = a * np.sqrt(over / (n + r * a * a))
    filled = 2.0 * ramp * np.mean(np.clip(1.0 - passed, 0.0, None))
    assert found.held * found.pwm_frequency / at.flow == pytest.approx(filled, rel=0.01)
    while_opening = ramp * np.mean(np.clip(passed - 1.0, 0.0, None))
    emptying = (filled - while_opening) / (passed[-1] - 1.0)
    closing = ramp * np.mean(minimum(n / (a * a) + r, over))
    shut_to_load = ramp * np.mean(minimum(n / (a * a) + r, level))
    is_open = 0.5 - 2.0 * ramp
    tank = closing + ramp * over + emptying * over + (is_open - emptying) * (n + r)
    load = 2.0 * shut_to_load + is_open * (n + r)
    assert found.loss == pytest.approx(at.flow * (tank + load), rel=5e-3)


@pytest.mark.thorough
def test_the_best_precharge_lies_between_its_neighbours(at):
    bypass = usual_bypass(FLOW)
    best = best_chamber(at, bypass)
    least = soft_means(at, Softening(bypass, best), 160).loss
    for share in (0.85, 1.2):
        other = Softening(bypass, SwitchChamber(precharge_pressure=share * best.precharge_pressure))
        assert soft_means(at, other, 160).loss > least
    drop = float(quantities(at).pressure_drop_total)
    assert (best.precharge_pressure - at.tank_pressure) / drop == pytest.approx(1.85, abs=0.15)


def test_what_stays_in_the_chamber_is_lost(at):
    """With less pressure than the open port needs it never empties."""
    drop = float(quantities(at).pressure_drop_total)
    soft = Softening(usual_bypass(FLOW), SwitchChamber(precharge_pressure=at.tank_pressure + 1.01 * drop))
    assert soft_means(at, soft, 160).loss > 1000.0


def test_quantities_follow_the_means(at):
    soft = Softening(usual_bypass(FLOW), None)
    means, found = soft_means(at, soft), soft_quantities(at, soft)
    assert isinstance(means, SoftMeans)
    assert found.loss_full_open + found.loss_transition == pytest.approx(means.loss)
    assert found.load_flow == means.load_flow
    assert found.efficiency == pytest.approx(0.81, abs=0.02)


def test_closed_forms_refuse_a_system_that_is_switched_softly(system):
    soft = with_soft(system, precharge_pressure=13e5)
    with pytest.raises(ConfigError, match=wording.design.soft_no_closed_form):
        problem(soft, "loss_total")
    with pytest.raises(ParameterError, match=wording.design.soft_already):
        levers(soft, simulated=False)
    assert wording.design.in_no_closed_form in next(rotary_bench(soft, "design").unit.average_limits())


def test_the_lines_of_the_page_draw_what_the_levers_calculate(system):
    """The same states and rates at the start."""
    lines = PAGE.partition("```toml\n")[2].partition("```")[0]
    drawn = built_system(parsed_table(f"{source_text(system.name)}\n{lines}", "soft.toml"), "soft")
    soft = with_soft(system, precharge_pressure=12e5 + REFERENCE)
    rates = [flat(each.model.circuit(0.0, each.case.state, each.case.command, each.case.params)[0])
             for each in (drawn, soft)]  # fmt: skip
    assert is_bench(drawn) and drawn.case.state == soft.case.state
    assert rates[0] == pytest.approx(rates[1], rel=1e-12)
    assert "chamber" in drawn.circuit.network.nodes


@pytest.mark.slow
def test_the_page_has_what_periodic_states_say(system):
    """Three circuits at the load of the file, and a check valve with a lag; all balance."""
    circuits = [system, with_soft(system), with_soft(system, precharge_pressure=12e5 + REFERENCE)]
    held = [stand(each) for each in circuits]
    pairs = [[(one, one.set_point)] for one in held]
    lagging = held[2].with_tables(bypass={"opening_time": 1e-4})
    found = [steady_states(each)[0].summary for each in (*pairs, [(lagging, lagging.set_point)])]
    for each in found:
        assert abs(each["energy_residual"]) < 1e-6
        assert abs(each["mass_residual"]) < 1e-6
    table = PAGE.partition("| | loss [W] |")[2].partition("\n\n")[0]
    rows = [[float(cell) for cell in re.findall(r"\| (-?[\d.]+)(?= )", line)] for line in table.splitlines()[2:]]
    assert len(rows) == len(found)
    before = [beyond_open(found[0]), found[0]["loss_total_W"]]
    for row, each in zip(rows, found, strict=True):
        told = (each["loss_total_W"], beyond_open(each), 100.0 * each["efficiency"], each["pwm_frequency_Hz"])
        assert row[:4] == pytest.approx(told, abs=0.51)
        saved = [100.0 * (1.0 - now / was) for now, was in
                 zip((beyond_open(each), each["loss_total_W"]), before, strict=True)]  # fmt: skip
        assert row[4:] == pytest.approx(saved, abs=0.51)


def beyond_open(found):
    """Transitions and compression [W]."""
    return found["loss_total_W"] - found["loss_full_open_W"] - found["loss_valve_leakage_W"]
