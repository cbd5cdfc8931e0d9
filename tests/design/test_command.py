"""`vvdp design SYSTEM`: what it prints, writes and refuses."""

import json

import pytest

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
    assert "optimised: least pressure_drop_total" in next(
        row.note for row in system.rows if (row.table, row.key) == ("valve", "nozzle_area")
    )
    page = (tmp_path / "there" / "report.html").read_text("utf-8")
    assert "2.48 bar of wang2017 depend on bounds that it does not state" in page
    assert "This optimum is that value" in page
    assert "System <b>prototype</b>" in page
    assert "PWM frequency, fully open ≥ 72 Hz" in page
    assert "pwm_frequency &gt;=" not in page
    for name in ("before-and-after", "between-bounds", "limits"):
        assert (tmp_path / "there" / "figures" / f"{name}.svg").is_file()


def test_what_a_person_sees(designing, tmp_path):
    code, out, err = designing("prototype", *FIXED, *CLEARANCE, "--no-simulation", "--starts", "3")
    assert code == 0
    for words in ("spool radius", "22.50", "Held by", "PWM frequency, fully open ≥ 72 Hz", "3 of them in this one"):
        assert words in out
    assert "run it with: vvdp run results/design-prototype-" in out
    assert "4 of 4 starts" in err
    assert "optimum" in (next((tmp_path / "results").iterdir()) / "optimum.toml").read_text("utf-8")


def test_least_loss_keeps_the_frequency_and_holds_in_simulation(designing, tmp_path):
    code, out, err = designing("prototype", "--starts", "2", "--json", "--out", "there")
    assert code == 0, err
    found = json.loads(out)
    assert found["pwm_frequency_Hz"] == pytest.approx(72.0, abs=0.01)
    assert found["after_simulated_loss_total_W"] == pytest.approx(found["loss_total_W"], rel=0.1)
    assert found["after_simulated_loss_total_W"] < 0.75 * found["before_simulated_loss_total_W"]
    assert not any("simulat" in text.lower() for text in found["warnings"])
    page = (tmp_path / "there" / "report.html").read_text("utf-8")
    assert "PWM frequency, fully open ≥ 72.0012 Hz (usual limit)" in page
    assert "Simulated, it goes from 1932 W to" in page
    assert "does not bear out" not in page
    assert "that of an analytic map leaves compressibility out" in page


def test_an_optimum_that_only_closed_forms_believe_in(designing, tmp_path):
    """5.5 Hz against an accumulator of 50 cc: two fifths of the loss in closed form, four fifths in the simulation."""
    code, out, _ = designing("prototype", "--starts", "2", "--no-usual-limits", "--out", "there")
    assert code == 0
    assert "The total loss goes from 1867 W to 746.5 W, analytically" in out
    assert "Simulated, it goes from 1932 W to 1557 W" in out
    refuted = "warning: The simulation does not bear out the optimum"
    warnings = [line for line in out.splitlines() if line.startswith("warning: ")]
    assert warnings[0].startswith(f"{refuted}: The total loss is 1557 W simulated and 746.5 W analytic, +108.5 %")
    assert "more than 10 % is not to be relied on" in warnings[0]
    assert any("has not settled" in line for line in warnings[:4])
    findings = read_result(tmp_path / "there").findings
    assert sum(each.grade is Grade.BAD for each in findings) == 2
    page = (tmp_path / "there" / "report.html").read_text("utf-8")
    assert "The simulation does not bear out the optimum" in page


def test_shape_that_cannot_be_built_with_usual_lengths_is_told(designing, tmp_path):
    code, out, _ = designing("prototype", *FIXED, *CLEARANCE, "--no-simulation", "--starts", "1", "--json")
    assert code == 0
    warnings = " ".join(json.loads(out)["warnings"])
    assert "The usual lengths of the shape do not fit this valve, vvdp geometry needs others" in warnings
    assert "length of a nozzle's root = 15.37 mm; expected less than 8.852 mm, the rail diameter" in warnings


def test_options_may_stand_first(designing):
    code, out, _ = designing("--no-simulation", "--starts", "1", "--json", *FIXED, "prototype")
    assert code == 0
    assert json.loads(out)["system"] == "prototype"


def test_infeasible_is_said_and_nothing_is_left(designing, tmp_path):
    code, out, err = designing("prototype", *FIXED, "--subject-to", "pressure_drop_total <= 0.5 bar", *CLEARANCE)
    assert (code, out) == (1, "")
    assert "no design meets all of these together" in err
    assert not list((tmp_path / "results").iterdir())


def test_bad_input_is_refused_whole(designing, tmp_path):
    code, _, err = designing("prototype", "--minimise", "cost", "--bound", "clearance <= 3 um")
    assert code == 2
    assert "--minimise: cost: unknown quantity" in err
    assert "--bound: clearance: unknown variable" in err
    assert not (tmp_path / "results").exists()


def test_a_directory_is_not_replaced(designing, tmp_path):
    (tmp_path / "there").mkdir()
    code, _, err = designing("prototype", "--out", "there", "--no-simulation")
    assert code == 2
    assert "already exists" in err


def test_interrupted_before_anything_is_found_leaves_nothing(designing, tmp_path, monkeypatch):
    from vvdp.design.solver import Traced

    def stopped(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(Traced, "solve", stopped)
    code, _, _ = designing("prototype", "--no-simulation", "--starts", "1", "--out", "there")
    assert code == 130
    assert not (tmp_path / "there").exists()


@pytest.mark.parametrize("where", ["vvdp.design.optimise._global_search", "vvdp.design.proof.simulate"])
def test_interrupted_later_keeps_what_was_found(designing, tmp_path, monkeypatch, where):
    """In the global search, and in the simulation of the optimum."""

    def stopped(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr(where, stopped)
    code, out, err = designing("prototype", *FIXED, *CLEARANCE, "--starts", "1", "--out", "there", "--json")
    assert code == 130
    assert json.loads(out)["pressure_drop_total_Pa"] == pytest.approx(2.48e5, abs=0.03e5)
    assert "interrupted; what was found until then is written" in err
    assert load_system(str(tmp_path / "there" / "optimum.toml"))
    assert (tmp_path / "there" / "report.html").is_file()


def test_interrupted_while_limits_are_moved_keeps_the_simulations(designing, tmp_path, monkeypatch):
    """In the first of the optima with a limit moved: no curve is whole, all else is there."""

    def stopped(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr("vvdp.design.sensitivity._least", stopped)
    code, out, err = designing("prototype", *FIXED, *CLEARANCE, "--starts", "1", "--out", "there", "--json")
    assert code == 130
    assert json.loads(out)["after_simulated_trusted"] is True
    assert "interrupted; what was found until then is written" in err
    found = read_result(tmp_path / "there")
    assert not found.finished
    assert "curves" not in found.tables
    assert "simulated" in found.listings
    assert load_system(str(tmp_path / "there" / "optimum.toml"))
    assert (tmp_path / "there" / "report.html").is_file()


def test_a_limit_of_zero_is_shown_without_an_elasticity(designing, tmp_path):
    arguments = ("prototype", "--minimise", "load_pulsation", "--subject-to", "relief_margin >= 0 bar", *CLEARANCE)
    code, out, err = designing(*arguments, "--no-simulation", "--starts", "1", "--out", "there")
    assert code == 0, err
    line = next(each for each in out.splitlines() if each.strip().startswith("relief margin ≥ 0 bar"))
    assert line.split()[-3:-1] == ["limit", "–"]
    assert float(line.split()[-1].partition("·")[0]) > 0.0
    assert "30 of 30 optima with a limit moved" in err
    result = read_result(tmp_path / "there")
    (told,) = (each for each in result.listings["held"].rows if each.label == "relief margin ≥ 0 bar")
    assert told.values[:2] == ("limit", "–")
    assert not any("relief margin" in words for words in result.tables["curves"]["moved"])


def test_cycle(designing, tmp_path):
    (tmp_path / "cycle.toml").write_text(
        '[[points]]\nweight = 2\n"operation.duty_ratio" = "0.4"\n'
        '[[points]]\nweight = 1\n"operation.duty_ratio" = "0.6"\n'
    )
    code, out, _ = designing(
        "prototype", "--minimise", "loss_total", "--cycle", "cycle.toml", "--starts", "1", "--no-simulation"
    )
    assert code == 0
    assert "weighted mean over 2 operating points" in out


def test_help_names_the_questions(designing):
    code, out, _ = designing("--help")
    assert code == 0
    assert "optimum" in out
