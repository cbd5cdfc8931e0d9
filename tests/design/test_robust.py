"""The robust front: scenarios, cases, refusals; a small search that is simulated, resumed and repeated."""

import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from tests.words import wording

from vvdp.base.errors import ConfigError
from vvdp.design.pareto import is_undominated
from vvdp.design.quantities import quantities
from vvdp.design.robust import (
    CLEARANCE,
    OIL_TEMPERATURE,
    Candidate,
    Effort,
    Robust,
    Runs,
    _can_be_made,
    _children,
    _judge,
    _Trials,
    robust_problem,
    scenarios,
)
from vvdp.design.robust_result import robust_result
from vvdp.design.variables import with_variables
from vvdp.evaluation.bench import rotary_bench
from vvdp.results.result import Grade
from vvdp.systems.system import load_system

WARM = (303.15, 333.15)
PAGE = (Path(__file__).parents[2] / "docs/design.md").read_text("utf-8")


@pytest.fixture(scope="module")
def asked():
    return robust_problem(load_system("prototype-constant-load"))


@pytest.fixture(scope="module")
def met(asked):
    return scenarios(asked, None, WARM, (), Effort(draws=4))


def candidate(loss, size, refusal=""):
    return Candidate(
        values={}, size=size, loss=loss, largest_loss=loss, pwm_frequency=80.0, efficiency=0.7, refusal=refusal
    )


def test_scenarios_are_every_point_with_every_draw(met):
    found, taken = met
    assert len(found) == 3 * 4
    assert sum(each.weight for each in found) == pytest.approx(1.0)
    assert [each.settings["operation.duty_ratio"] for each in found] == ["0.4"] * 4 + ["0.5"] * 4 + ["0.6"] * 4
    assert found[0].draws == found[4].draws == found[8].draws
    temperatures = [each.draws[OIL_TEMPERATURE] for each in found[:4]]
    assert all(WARM[0] < t < WARM[1] for t in temperatures)
    # Sobol's sequence has a draw in each quarter.
    assert sorted(int(4 * (t - WARM[0]) / (WARM[1] - WARM[0])) for t in temperatures) == [0, 1, 2, 3]
    names = {each.setting for each in taken}
    assert CLEARANCE in names
    assert "valve.lap_ratio" not in names, "a variable of the design is not uncertain"


def test_a_cycle_of_ones_own_takes_the_place_of_a_draw(asked, tmp_path):
    path = tmp_path / "cycle.toml"
    path.write_text('[[points]]\nweight = 3\n"operation.oil_temperature" = "50 degC"\n[[points]]\n', "utf-8")
    found, _ = scenarios(asked, path, WARM, (), Effort(draws=2))
    assert [each.weight for each in found] == [0.375, 0.375, 0.125, 0.125]
    assert OIL_TEMPERATURE not in found[0].draws
    assert OIL_TEMPERATURE in found[2].draws
    path.write_text('[[points]]\n"valve.lap_ratio" = "0.5"\n', "utf-8")
    with pytest.raises(ConfigError, match=wording.design.no_operating_setting):
        scenarios(asked, path, WARM, (), Effort(draws=2))


def test_a_case_cuts_the_design_to_its_tolerance(asked, met, tmp_path):
    """The clearance is off by as much as drawn, what follows the radius in proportion, the viscosity at both points."""
    found, taken = met
    trials = _Trials(asked, found, taken, Effort(), Runs(tmp_path))
    one = replace(found[0], draws={CLEARANCE: 14.2e-6, "valve.inlet_radius": 12.065e-3, "oil.viscosity_40": 4.2e-5})
    case = trials.case({"radial_clearance": 20e-6, "spool_radius": 10e-3}, one)
    assert case["valve.radial_clearance"] == "21.5 um"
    assert float(case["valve.inlet_radius"].split()[0]) == pytest.approx(9.5)
    assert float(case["oil.viscosity_100"].split()[0]) == pytest.approx(6.65 * 42.0 / 44.1780822)
    assert case["operation.duty_ratio"] == "0.4"
    assert case["valve.spool_radius"] == "10 mm"


def test_the_front_is_what_is_confirmed_and_not_beaten(asked):
    found = [candidate(900.0, 2e-5), candidate(950.0, 1e-5), candidate(960.0, 1.5e-5), candidate(500.0, 1e-6, "failed")]
    state = Robust(
        problem=asked, scenarios=(), taken=(), before=candidate(1700.0, 2e-5), nominal=candidate(990.0, 0.5e-5),
        candidates=tuple(found), runs=0, finished=True,
    )  # fmt: skip
    assert [each.loss for each in state.front] == [900.0, 950.0, 990.0]
    assert [each.loss for each in state.rejects] == [500.0]
    assert "47.1 % less" in robust_result(state).findings[0].text
    nothing = replace(state, candidates=(), nominal=candidate(990.0, 1e-5, "failed"))
    assert robust_result(nothing).findings[0].grade is Grade.WARNING


def test_a_slower_valve_is_refused():
    assert not _judge(candidate(900.0, 1e-5), 80.0).refusal
    assert wording.design.below.format(limit="81 Hz") in _judge(candidate(900.0, 1e-5), 81.0).refusal


def test_children_can_be_made_and_stay_within_bounds(asked):
    rng = np.random.default_rng(4)
    found = _children(asked, [asked.start], 20, rng)
    assert len(found) == 20
    for values in found:
        assert all(b.low <= values[b.variable.name] <= b.high for b in asked.bounds)
    wide = {**asked.start, "nozzle_area": 3.3 * 36.5e-6, "spool_radius": 0.6 * 12.7e-3, "lap_ratio": 2.0}
    assert not _can_be_made(asked, wide)
    small = robust_problem(asked.system, ["spool_volume <= 15 cm^3"])
    assert not _can_be_made(small, asked.start)


@pytest.mark.slow
def test_a_small_search_resumes_and_repeats(designing, tmp_path, keys_as_described):
    words = ("robust", "prototype-constant-load", "--draws", "2", "--designs", "4", "--generations", "2")
    code, out, err = designing(*words, "--json", "--out", "there")
    assert code == 0, err
    told = json.loads(out)
    keys_as_described("design robust", told)
    assert told["scenarios"] == 6
    assert told["simulated_designs"] == 10
    costs = np.array([told["front_mean_loss_W"], told["front_spool_volume_m3"]]).T
    assert np.all(is_undominated(costs))
    assert np.all(np.diff(costs[:, 0]) > 0.0)
    assert told["loss_robust_W"] == costs[0, 0] < 0.6 * told["loss_before_W"]
    assert all(
        largest >= mean for mean, largest in zip(told["front_mean_loss_W"], told["front_largest_loss_W"], strict=True)
    )
    systems = sorted((tmp_path / "there" / "systems").iterdir())
    assert len(systems) == told["designs"]
    at = robust_problem(load_system("prototype-constant-load")).points[0].setup
    units = {"spool_radius": "m", "nozzle_area": "m2", "outlet_area": "m2", "radial_clearance": "m"}
    values = {name: told[f"front_{name}_{unit}"][0] for name, unit in units.items()}
    assert quantities(with_variables(at, values)).spool_volume == pytest.approx(told["front_spool_volume_m3"][0])
    assert rotary_bench(load_system(str(systems[0])), "test").valve.spool_radius == pytest.approx(
        values["spool_radius"]
    )

    code, out, err = designing(*words, "--json", "--out", "there")
    assert code == 0
    assert wording.progress.finished_already.format(done=12, all=12, what="cases") in err
    assert json.loads(out) == told


@pytest.mark.slow
def test_the_page_has_what_the_search_finds(designing):
    words = ("robust", "prototype-constant-load", "--draws", "4", "--designs", "8", "--generations", "4")
    assert f"vvdp design {' '.join(words)}" in PAGE
    code, out, err = designing(*words, "--json", "--no-report", "--out", "there")
    assert code == 0, err
    told = json.loads(out)
    table = PAGE.partition("| design | mean loss [W] | spool volume [cm³] |")[2].partition("\n\n")[0]
    rows = [[float(cell) for cell in line.strip("|").split("|")[1:]] for line in table.splitlines()[2:]]
    last = told["designs"] - 1
    found = [(told[f"{name}_mean_loss_W"][k], 1e6 * told[f"{name}_spool_volume_m3"][k])
             for name, k in (("before", 0), ("nominal", 0), ("front", 0), ("front", last))]  # fmt: skip
    for row, each in zip(rows, found, strict=True):
        assert row == pytest.approx(each, rel=0.02)
    assert told["loss_robust_W"] < 0.97 * told["loss_nominal_W"]


def test_the_page_tells_of_the_defaults():
    effort = Effort()
    text = PAGE.partition("## A robust optimum")[2].partition("\n## ")[0]
    assert re.search(rf"`--draws` \({effort.draws}\)", text)
    assert re.search(rf"`--designs` \({effort.designs}\)", text)
    assert re.search(rf"`--generations` \({effort.generations}\)", text)
