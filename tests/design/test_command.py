"""`vvdp design SYSTEM`: what it prints, writes and refuses."""

import json

import pytest
from tests.words import wording

from vvdp.design.quantities import quantities, setup
from vvdp.results.result import Grade
from vvdp.results.store import read_result
from vvdp.systems.system import load_system

pytestmark = pytest.mark.heavy

FIXED = ("--minimise", "pressure_drop_total", "--subject-to", "pwm_frequency >= 72 Hz")
CLEARANCE = ("--bound", "radial_clearance <= 22.5 um")


def test_the_published_optimum(designing, tmp_path, keys_as_described):
    code, out, err = designing("prototype", *FIXED, *CLEARANCE, "--json", "--out", "there")
    assert code == 0, err
    found = json.loads(out)
    keys_as_described("design optimum", found)
    assert found["pressure_drop_total_Pa"] == pytest.approx(2.48e5, abs=0.03e5)
    assert found["spool_radius_m"] == pytest.approx(10.88e-3, rel=0.02)
    assert found["nozzle_area_m2"] == pytest.approx(88.2e-6, rel=0.02)
    assert found["outlet_area_m2"] == pytest.approx(94.6e-6, rel=0.02)
    assert found["radial_clearance_m"] == pytest.approx(22.5e-6, rel=1e-9)
    assert found["pwm_frequency_Hz"] == pytest.approx(72.0, rel=1e-5)
    assert found["transition_fraction"] == pytest.approx(0.504, rel=0.01)
    assert found["after_simulated_trusted"] is True
    assert found["after_simulated_loss_total_W"] < found["before_simulated_loss_total_W"]

    system = load_system(str(tmp_path / "there" / "optimum.toml"))
    # At the flow of the design: less drop leaves the pump's leakage another pressure.
    at = setup(system)._replace(flow=setup(load_system("prototype")).flow)
    assert quantities(at).pressure_drop_total == pytest.approx(found["pressure_drop_total_Pa"], rel=1e-8)
    assert wording.design.optimised.format(quantity="pressure_drop_total") in next(
        row.note for row in system.rows if (row.table, row.key) == ("valve", "nozzle_area")
    )
    page = (tmp_path / "there" / "report.html").read_text("utf-8")
    assert wording.design.published_bounds.format(drop="2.48 bar", source="wang2017") in page
    assert wording.design.is_published_value in page
    assert "System <b>prototype</b>" in page
    assert wording.design.frequency_limit.format(frequency="72 Hz") in page
    assert "pwm_frequency &gt;=" not in page
    for name in ("before-and-after", "between-bounds", "limits"):
        assert (tmp_path / "there" / "figures" / f"{name}.svg").is_file()


def test_what_a_person_sees(designing, tmp_path):
    code, out, err = designing("prototype", *FIXED, *CLEARANCE, "--no-simulation", "--starts", "3")
    assert code == 0
    for words in (
        wording.design.spool_radius,
        "22.50",
        wording.design.held_by,
        wording.design.frequency_limit.format(frequency="72 Hz"),
        wording.design.held_by_geometry.format(count=3),
    ):
        assert words in out
    assert wording.design.run_it_with.format(place="results/design-prototype-") in out
    assert wording.progress.count.format(done=4, all=4, what="starts") in err
    assert "optimum" in (next((tmp_path / "results").iterdir()) / "optimum.toml").read_text("utf-8")


@pytest.mark.thorough
def test_least_loss_keeps_the_frequency_and_holds_in_simulation(designing, tmp_path):
    code, out, err = designing("prototype", "--starts", "2", "--json", "--out", "there")
    assert code == 0, err
    found = json.loads(out)
    assert found["pwm_frequency_Hz"] == pytest.approx(72.0, abs=0.01)
    assert found["after_simulated_loss_total_W"] == pytest.approx(found["loss_total_W"], rel=0.1)
    assert found["after_simulated_loss_total_W"] < 0.75 * found["before_simulated_loss_total_W"]
    assert not any("simulat" in text.lower() for text in found["warnings"])
    page = (tmp_path / "there" / "report.html").read_text("utf-8")
    assert wording.design.frequency_limit.format(frequency="72.0012 Hz") + wording.design.usual in page
    assert wording.design.goes_to_simulated.format(before="1932 W") in page
    assert wording.design.not_borne_out not in page
    assert wording.design.analytic_map in page


@pytest.mark.thorough
def test_an_optimum_that_only_closed_forms_believe_in(designing, tmp_path):
    """5.5 Hz against an accumulator of 50 cc: two fifths of the loss in closed form, four fifths in the simulation."""
    code, out, _ = designing("prototype", "--starts", "2", "--no-usual-limits", "--out", "there")
    assert code == 0
    assert wording.design.goes_from_to_analytic.format(before="1867 W", after="746.5 W") in out
    assert wording.design.goes_from_to_simulated.format(before="1932 W", after="1557 W") in out
    refuted = "warning: " + wording.design.not_borne_out
    warnings = [line for line in out.splitlines() if line.startswith("warning: ")]
    assert warnings[0].startswith(
        f"{refuted}: "
        + wording.design.simulated_and_analytic.format(simulated="1557 W", analytic="746.5 W", difference="+108.5 %")
    )
    assert wording.design.not_relied_on.format(share="10 %") in warnings[0]
    assert any(wording.design.has_not_settled in line for line in warnings[:4])
    findings = read_result(tmp_path / "there").findings
    assert sum(each.grade is Grade.BAD for each in findings) == 2
    page = (tmp_path / "there" / "report.html").read_text("utf-8")
    assert wording.design.not_borne_out in page


@pytest.mark.thorough
def test_shape_that_cannot_be_built_with_usual_lengths_is_told(designing, tmp_path):
    code, out, _ = designing("prototype", *FIXED, *CLEARANCE, "--no-simulation", "--starts", "1", "--json")
    assert code == 0
    warnings = " ".join(json.loads(out)["warnings"])
    assert wording.design.shape_does_not_fit in warnings
    assert wording.design.root_length.format(length="15.37 mm", limit="8.852 mm") in warnings


@pytest.mark.thorough
def test_options_may_stand_first(designing):
    code, out, _ = designing("--no-simulation", "--starts", "1", "--json", *FIXED, "prototype")
    assert code == 0
    assert json.loads(out)["system"] == "prototype"


def test_infeasible_is_said_and_nothing_is_left(designing, tmp_path):
    code, out, err = designing("prototype", *FIXED, "--subject-to", "pressure_drop_total <= 0.5 bar", *CLEARANCE)
    assert (code, out) == (1, "")
    assert wording.design.no_design_together in err
    assert not list((tmp_path / "results").iterdir())


def test_bad_input_is_refused_whole(designing, tmp_path):
    code, _, err = designing("prototype", "--minimise", "cost", "--bound", "clearance <= 3 um")
    assert code == 2
    assert "--minimise: cost: " + wording.design.unknown_quantity in err
    assert "--bound: clearance: " + wording.design.unknown_variable in err
    assert not (tmp_path / "results").exists()


def test_a_directory_is_not_replaced(designing, tmp_path):
    (tmp_path / "there").mkdir()
    code, _, err = designing("prototype", "--out", "there", "--no-simulation")
    assert code == 2
    assert wording.files.already_exists in err


def test_interrupted_before_anything_is_found_leaves_nothing(designing, tmp_path, monkeypatch):
    from vvdp.design.solver import Traced

    def stopped(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(Traced, "solve", stopped)
    code, _, _ = designing("prototype", "--no-simulation", "--starts", "1", "--out", "there")
    assert code == 130
    assert not (tmp_path / "there").exists()


@pytest.mark.thorough
@pytest.mark.parametrize("where", ["vvdp.design.optimise._global_search", "vvdp.design.proof.simulate"])
def test_interrupted_later_keeps_what_was_found(designing, tmp_path, monkeypatch, where):
    """In the global search, and in the simulation of the optimum."""

    def stopped(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr(where, stopped)
    code, out, err = designing("prototype", *FIXED, *CLEARANCE, "--starts", "1", "--out", "there", "--json")
    assert code == 130
    assert json.loads(out)["pressure_drop_total_Pa"] == pytest.approx(2.48e5, abs=0.03e5)
    assert wording.progress.found_written in err
    assert load_system(str(tmp_path / "there" / "optimum.toml"))
    assert (tmp_path / "there" / "report.html").is_file()


@pytest.mark.thorough
def test_interrupted_while_limits_are_moved_keeps_the_simulations(designing, tmp_path, monkeypatch):
    """In the first of the optima with a limit moved: no curve is whole, all else is there."""

    def stopped(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr("vvdp.design.sensitivity._least", stopped)
    code, out, err = designing("prototype", *FIXED, *CLEARANCE, "--starts", "1", "--out", "there", "--json")
    assert code == 130
    assert json.loads(out)["after_simulated_trusted"] is True
    assert wording.progress.found_written in err
    found = read_result(tmp_path / "there")
    assert not found.finished
    assert "curves" not in found.tables
    assert "simulated" in found.listings
    assert load_system(str(tmp_path / "there" / "optimum.toml"))
    assert (tmp_path / "there" / "report.html").is_file()


@pytest.mark.thorough
def test_a_limit_of_zero_is_shown_without_an_elasticity(designing, tmp_path):
    arguments = ("prototype", "--minimise", "load_pulsation", "--subject-to", "relief_margin >= 0 bar", *CLEARANCE)
    code, out, err = designing(*arguments, "--no-simulation", "--starts", "1", "--out", "there")
    assert code == 0, err
    line = next(
        each
        for each in out.splitlines()
        if each.strip().startswith(wording.design.relief_margin_limit.format(margin="0 bar"))
    )
    assert line.split()[-3:-1] == ["limit", "–"]
    assert float(line.split()[-1].partition("·")[0]) > 0.0
    assert wording.design.moved_optima.format(done=30, all=30) in err
    result = read_result(tmp_path / "there")
    (told,) = (
        each
        for each in result.listings["held"].rows
        if each.label == wording.design.relief_margin_limit.format(margin="0 bar")
    )
    assert told.values[:2] == ("limit", "–")
    assert not any(wording.design.relief_margin in words for words in result.tables["curves"]["moved"])


@pytest.mark.thorough
def test_cycle(designing, tmp_path):
    (tmp_path / "cycle.toml").write_text(
        '[[points]]\nweight = 2\n"operation.duty_ratio" = "0.4"\n'
        '[[points]]\nweight = 1\n"operation.duty_ratio" = "0.6"\n'
    )
    code, out, _ = designing(
        "prototype", "--minimise", "loss_total", "--cycle", "cycle.toml", "--starts", "1", "--no-simulation"
    )
    assert code == 0
    assert wording.design.weighted_mean.format(count=2) in out


def test_help_names_the_questions(designing):
    code, out, _ = designing("--help")
    assert code == 0
    assert "optimum" in out
