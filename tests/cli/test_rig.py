"""`vvdp rig`: every rig from the command line, its files, its page, its numbers, bad input."""

import json
from dataclasses import replace
from pathlib import Path

import pytest
from tests.words import wording

from vvdp.base.files import list_all
from vvdp.results.store import read_result
from vvdp.simulation.run import simulate
from vvdp.steady.test_stand import stand
from vvdp.steady.waveform import whole_run
from vvdp.systems.system import load_system

FILES = {"figures", "meta.json", "report.html", "result.json", "system.toml", "vvdp.json"}


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("verb", "system", "tables", "pictures", "standard"),
    [
        ("pressure-drop", "prototype", {"pressure-drop.csv"}, {"drop-over-flow"}, "ISO 4411"),
        (
            "derived-capacity",
            "prototype",
            {"capacity.csv", "speeds.csv", "flows.csv"},
            {"derived-capacity", "low-pressure-flow"},
            "ISO 8426",
        ),
        (
            "ripple",
            "prototype",
            {"duty.csv", "frequency.csv", "accumulator.csv", "spectrum.csv", "waveform.csv"},
            {"ripple", "harmonics"},
            "ISO 10767",
        ),
        (
            "step",
            "prototype-constant-load",
            {"step_up.csv", "step_down.csv", "frequency.csv"},
            {"step", "frequency-response"},
            "ISO 17559",
        ),
    ],
)
def test_table_pictures_and_page(vvdp, here, keys_as_described, verb, system, tables, pictures, standard):
    answer = vvdp("rig", verb, system, "--out", "r")
    assert answer.code == 0, answer.err
    assert {path.name for path in (here / "r").iterdir()} == FILES | tables
    keys_as_described(f"rig {verb}", {*read_result(here / "r").flat, "out"})
    drawn = {path.name for path in (here / "r" / "figures").iterdir()}
    assert drawn >= {f"{name}.svg" for name in pictures}
    page = (here / "r" / "report.html").read_text()
    for words in (standard, wording.report.left_out, "44.18 cSt", "40 °C", "References"):
        assert words in page
    refused = vvdp("rig", verb, system, "--out", "r")
    assert refused.code == 2
    assert wording.files.already_exists in refused.err


@pytest.mark.thorough
def test_pressures_are_said_to_be_gauge_where_there_are_levels(vvdp, here):
    """Of drops and gains there is none; the table of a sweep of the ripple has the mean load pressure."""
    vvdp("rig", "pressure-drop", "prototype", "--out", "drop")
    assert wording.rig.pressures_are_gauge not in Path("drop/report.html").read_text("utf-8")
    assert "[gauge]" not in Path("drop/pressure-drop.csv").read_text("utf-8")
    vvdp("rig", "step", "prototype-constant-load", "--out", "step")
    assert wording.rig.pressures_are_gauge not in Path("step/report.html").read_text("utf-8")
    vvdp("map", "prototype", "--analytic", "--out", "map")
    assert Path("map/report.html").read_text("utf-8").count(wording.rig.pressures_are_gauge) == 1


def test_numbers_in_si(vvdp, here):
    found = json.loads(vvdp("rig", "pressure-drop", "prototype", "--json", "--no-report", "--out", "r").out)
    assert found["pressure_drop_total_Pa"][0] > 0.0
    assert found["flow_exponent"] == pytest.approx(1.98, abs=0.02)
    # 2.052 lpm, a twentieth of what the pump displaces: 3.9269 bar at 40 lpm
    assert found["pressure_drop_nozzle_Pa"][0] == pytest.approx(392690.0 * (2.052 / 40.0) ** 2, rel=2e-3)
    assert not (here / "r" / "report.html").exists()


def test_pump(vvdp, here, keys_as_described):
    small = ("--duty", "0.3", "0.9", "3", "--pressure", "60 bar", "60 bar", "1", "--speed", "1800 rpm")
    answer = vvdp("rig", "pump", "prototype-constant-load", *small, "--out", "p")
    assert answer.code == 0, answer.err
    names = {path.name for path in (here / "p").iterdir()}
    keys_as_described("rig pump", {*read_result(here / "p").flat, "out"})
    assert FILES | {"points", "steady.csv", "frequency.csv"} <= names
    assert wording.rig.electric_pump in answer.out
    other = vvdp("map", "prototype-constant-load", "--analytic", "--out", "p")
    assert other.code == 2
    assert wording.files.holds_other_command in other.err


def test_what_has_no_load_line_does_not_ripple(vvdp, here):
    answer = vvdp("rig", "ripple", "prototype-constant-load")
    assert answer.code == 2
    assert wording.rig.expected_load_line in answer.err
    assert not list((here / "results").iterdir())


def test_every_rig_takes_cores(vvdp, here):
    """Those that are worked out at once as well, so that one command line fits all."""
    answer = vvdp("rig", "pressure-drop", "prototype", "--cores", "1", "--no-report")
    assert answer.code == 0, answer.err


def test_derived_capacity_in_si(vvdp, here):
    """Half of 22.22 cc/rev, 1.76839e-6 m3/rad, of which 95.3 % are left without load; as many duty ratios as asked for,
    and the system's own."""
    asked = ("--duty", "0.25", "1", "4", "--json", "--no-report", "--cores", "1")
    found = json.loads(vvdp("rig", "derived-capacity", "prototype-constant-load", *asked).out)
    assert found["derived_capacity_m3_rad"] == pytest.approx(0.9535 * 1.76839e-6, rel=1e-3)
    assert found["averaged_capacity_m3_rad"] == pytest.approx(0.9456 * 1.76839e-6, rel=1e-3)
    assert found["capacity_duty_ratio"] == [0.25, 0.5, 0.75, 1.0]
    assert found["capacity_derived_capacity_m3_rad"][1] == found["derived_capacity_m3_rad"]
    assert len(found["flows_simulated_flow_m3_s"]) == 20
    assert found["warnings"] == []


def test_bad_temperature(vvdp, here):
    answer = vvdp("rig", "pressure-drop", "prototype", "--temperature", "40 bar")
    assert answer.code == 2
    assert "--temperature" in answer.err


@pytest.mark.slow
def test_claims(vvdp, here, keys_as_described):
    answer = vvdp("rig", "claims", "prototype", "--out", "c")
    assert answer.code == 0, answer.err
    keys_as_described("rig claims", {*read_result(here / "c").flat, "out"})
    names = {path.name for path in (here / "c" / "figures").iterdir()}
    assert {"throttling-losses.svg", "driven-spool.svg", "actuation-power.svg", "ripple.svg"} <= names
    for words in (
        wording.rig.by_itself,
        wording.rig.drive_power,
        wording.rig.to_the_power.format(exponent=3),
        wording.rig.metering,
    ):
        assert words in answer.out


@pytest.mark.thorough
def test_claims_of_a_system_without_a_load_line(vvdp, here):
    answer = vvdp("rig", "claims", "prototype-constant-load", "--out", "c")
    assert answer.code == 0, answer.err
    assert wording.rig.need_load_line in (here / "c" / "report.html").read_text()


def test_the_page_can_be_written_anew(vvdp, here):
    vvdp("rig", "pressure-drop", "prototype", "--out", "drop", "--no-report")
    assert vvdp("report", "drop").out.strip() == str(Path("drop/report.html"))
    assert "ISO 4411" in Path("drop/report.html").read_text("utf-8")


@pytest.mark.thorough
def test_the_page_of_a_design_can_be_written_anew(vvdp, here):
    vvdp("design", "temperature", "prototype", "--out", "warm")
    page = Path("warm/report.html")
    before = page.read_bytes()
    page.unlink()
    assert vvdp("report", "warm").out.strip() == str(page)
    assert page.read_bytes() == before


@pytest.mark.parametrize(
    ("file", "why"), [("geometry.toml", wording.files.is_no_result), ("result.json", wording.files.is_damaged)]
)
def test_a_page_that_cannot_be_made_is_refused_with_a_reason(vvdp, here, file, why):
    Path("opt").mkdir()
    Path("opt", file).write_text('{"format": 1}')
    assert wording.files.holds_no_result in vvdp("report", "opt").err
    list_all(Path("opt"))
    answer = vvdp("report", "opt")
    assert answer.code == 2
    assert why in answer.err


def interrupt(*_: object, **__: object) -> None:
    raise KeyboardInterrupt


@pytest.mark.parametrize(("verb", "part"), [("ripple", "ripple.steady_states"), ("step", "response.whole_run")])
def test_interrupted_rig_says_that_nothing_is_written(vvdp, here, monkeypatch, verb, part):
    monkeypatch.setattr(f"vvdp.rigs.{part}", interrupt)
    answer = vvdp("rig", verb, "prototype", "--out", "r")
    assert answer.code == 130
    assert wording.progress.nothing_written in answer.err
    assert not (here / "r").exists()


@pytest.mark.slow
def test_interrupted_claims_keep_what_is_worked_out(vvdp, here, monkeypatch):
    monkeypatch.setattr("vvdp.rivals.driving_claim.self_against_driven", interrupt)
    answer = vvdp("rig", "claims", "prototype", "--out", "r")
    assert answer.code == 130
    assert wording.progress.finished_written in answer.err
    found = read_result(here / "r")
    ways = {"supply", "duty_cycles", "supply_assumed"}
    assert set(found.tables) == {"verdicts", "throttling", "actuation", *ways}
    assert "section-1.1" in found.tables["verdicts"]["item"]
    assert not found.finished
    assert wording.rig.claim_interrupted in found.left_out
    assert wording.progress.partial_page in (here / "r" / "report.html").read_text()


def test_a_run_that_was_cut_short_is_no_result(monkeypatch):
    """Ctrl-C ends a simulation early without an exception; means over what is left would be wrong."""
    held = stand(load_system("prototype-constant-load", until="10 ms"))
    case = held.case(held.set_point, held.means(held.set_point))
    whole = simulate(held.model, case, held.stepping)
    monkeypatch.setattr("vvdp.steady.waveform.simulate", lambda *_, **__: replace(whole, finished=False))
    with pytest.raises(KeyboardInterrupt):
        whole_run(held.model, case, held.stepping)
