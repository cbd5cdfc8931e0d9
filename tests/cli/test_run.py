"""`vvdp run`: what it writes, prints and answers. Runs are short; the physics is tested elsewhere."""

import dataclasses
import json
import re

import pytest
from tests.words import wording

from vvdp.base.errors import RunError
from vvdp.runs import simulate
from vvdp.simulation.results import read_results
from vvdp.systems.system import load_system, shipped_systems

RANGED = ("--until", "0.06 s", "--no-report")
SHORT = (*RANGED, "--no-ranges")
"""Ranges run each assumed parameter at both ends: left out where nothing is read of them."""


def test_what_is_written_and_printed(vvdp, here):
    answer = vvdp("run", "prototype", *SHORT, "--set", "operation.duty_ratio=0.4", "--out", "deep/down")
    assert answer.code == 0, answer.err
    assert wording.run.results_in.format(folder="deep/down") in answer.out
    assert wording.run.pwm_frequency in answer.out
    kept = read_results(here / "deep" / "down")
    assert kept.record.times[-1] == pytest.approx(0.06)
    assert kept.meta["command"][0] == "vvdp"
    assert kept.meta["system"] == "prototype"
    assert load_system(str(here / "deep" / "down" / "system.toml")).stepping.until == pytest.approx(0.06)
    assert not [p for p in (here / "deep").iterdir() if p.name.startswith(".")]


def test_resolved_system_gives_the_same_run(vvdp, here):
    first = vvdp("run", "prototype", *SHORT, "--set", "operation.duty_ratio=0.4", "--out", "first", "--json")
    again = vvdp("run", "first/system.toml", "--no-report", "--no-ranges", "--out", "again", "--json")
    same = [json.loads(answer.out) for answer in (first, again)]
    for content in same:
        for word in ("system", "out", "wall_time_s"):
            content.pop(word)
    assert same[0] == same[1]


def test_json_is_one_flat_object_and_the_summary_kept(vvdp, here):
    answer = vvdp("run", "prototype-constant-load", *RANGED, "--json", "--out", "out")
    found = json.loads(answer.out)
    ranges, warnings = found.pop("ranges"), found.pop("warnings")
    assert all(isinstance(text, str) for text in warnings)
    assert all(isinstance(value, float | int) for key, value in found.items() if key not in ("system", "out"))
    assert all(each["low"] <= found[key] <= each["high"] for key, each in ranges.items())
    assert found.pop("system") == "prototype-constant-load"
    assert found.pop("out") == "out"
    assert read_results(here / "out").summary == found
    assert read_results(here / "out").meta["ranges"] == ranges


def test_a_number_that_is_none_becomes_null(vvdp, here, monkeypatch):
    whole = simulate.summary
    monkeypatch.setattr(simulate, "summary", lambda *both: whole(*both) | {"efficiency": float("nan")})
    answer = vvdp("run", "prototype", *SHORT, "--json", "--out", "out")
    assert json.loads(answer.out)["efficiency"] is None
    assert json.loads((here / "out" / "summary.json").read_text())["efficiency"] is None
    line = next(x for x in vvdp("run", "prototype", *SHORT, "--out", "other").out.splitlines() if "efficiency" in x)
    assert "–" in line


def test_untrusted_results_are_kept_and_told(vvdp, here, monkeypatch):
    whole = simulate.summary
    monkeypatch.setattr(simulate, "summary", lambda *both: whole(*both) | {"energy_residual": 2e-6, "trusted": False})
    answer = vvdp("run", "prototype", *SHORT, "--out", "out")
    assert answer.code == 3
    assert wording.run.not_trusted in answer.err
    assert wording.run.balances_do_not_close in answer.out
    assert "2.0e-06" in answer.out
    kept = read_results(here / "out")
    assert kept.summary["trusted"] is False
    assert kept.meta["trusted"] is False
    assert vvdp("run", "prototype", *SHORT, "--out", "out2", "--json").code == 3


def test_a_run_that_fails_leaves_nothing(vvdp, here):
    # a speed at which the step vanishes
    answer = vvdp("run", "prototype", *SHORT, "--set", "operation.pump_speed=-1e5 rad/s", "--out", "out")
    assert answer.code == 1
    assert answer.err.splitlines()[-1].startswith(wording.run.cannot_go_on)
    assert not list(here.iterdir())


def test_an_interrupt_keeps_what_was_reached(vvdp, here, monkeypatch):
    whole = simulate.simulate

    def stopped(model, case, stepping, **others):
        return dataclasses.replace(whole(model, case, stepping, **others), finished=False)

    monkeypatch.setattr(simulate, "simulate", stopped)
    answer = vvdp("run", "prototype", *SHORT, "--out", "out")
    assert answer.code == 130
    assert wording.run.interrupted in answer.out
    assert read_results(here / "out").summary["finished"] is False


def test_an_interrupt_before_anything_was_reached_leaves_nothing(vvdp, here, monkeypatch):
    def stopped(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr(simulate, "simulate", stopped)
    assert vvdp("run", "prototype", *SHORT, "--out", "out").code == 130
    assert not list(here.iterdir())


def test_a_full_disk_is_told_in_a_line(vvdp, here, monkeypatch):
    def full(*_, **__):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(simulate, "write_results", full)
    answer = vvdp("run", "prototype", *SHORT, "--out", "out")
    assert answer.code == 1
    assert answer.err.splitlines() == ["out: " + wording.files.cannot_write + " (No space left on device)"]
    assert not list(here.iterdir())


def test_the_output_is_checked_before_the_run(vvdp, here, monkeypatch):
    def never(*_, **__):
        raise RunError("was run")

    monkeypatch.setattr(simulate, "simulate", never)
    (here / "out").mkdir()
    assert wording.files.already_exists in vvdp("run", "prototype", "--out", "out").err


def test_force_replaces_results_and_only_those(vvdp, here):
    assert vvdp("run", "prototype", *SHORT, "--out", "out").code == 0
    before = (here / "out" / "meta.json").stat().st_mtime_ns
    assert vvdp("run", "prototype", *SHORT, "--out", "out").code == 2
    assert (here / "out" / "meta.json").stat().st_mtime_ns == before
    assert vvdp("run", "prototype", *SHORT, "--out", "out", "--force").code == 0
    assert (here / "out" / "meta.json").stat().st_mtime_ns != before


@pytest.mark.thorough
def test_default_directories_do_not_collide(vvdp, here):
    outs = {json.loads(vvdp("run", "prototype", *SHORT, "--json").out)["out"] for _ in range(3)}
    assert len(outs) == 3
    assert all(name.startswith("results/prototype-") for name in outs)
    assert {str(p.relative_to(here)) for p in (here / "results").iterdir()} == outs


def test_warnings_of_a_run(vvdp, here):
    brief = vvdp("run", "prototype", "--until", "0.01 s", "--no-report", "--no-ranges", "--out", "a")
    assert wording.run.no_whole_period in brief.out
    weak = vvdp("run", "prototype", *SHORT, "--out", "c", "--set", "motor.rated_power=1 kW")
    assert wording.run.exceeds_motor.format(power="1000 W") in weak.out
    drawn = vvdp("run", "prototype", *SHORT, "--out", "b", "--set", "limits.cavitation_pressure=10 bar")
    lowest = wording.systems.lowest_pressure.format(place="tank", pressure="1.013 bar", limit="11.01 bar")
    assert f"warning: {lowest}; {wording.run.cavitates}" in drawn.out
    assert drawn.code == 3


def test_a_pump_that_delivers_nothing_has_no_closed_form(vvdp, here):
    answer = vvdp("run", "prototype", *SHORT, "--json", "--set", "pump.displacement=0 cc/rev", "--out", "out")
    assert answer.code == 0, answer.err
    assert not [key for key in json.loads(answer.out) if key.startswith("analytic")]


def test_report_of_a_run_and_again(vvdp, here):
    answer = vvdp("run", "prototype", "--until", "0.06 s", "--no-ranges", "--out", "out")
    assert answer.code == 0, answer.err
    line = next(line for line in answer.out.splitlines() if line.startswith("report: "))
    path = here / line.removeprefix("report: ")
    assert path.is_file()
    path.unlink()
    again = vvdp("report", "out")
    assert again.code == 0
    assert path.is_file()
    assert again.out.strip() == line.removeprefix("report: ")


def test_counts_are_whole_numbers_in_json(vvdp, here):
    text = vvdp("run", "prototype", "--until", "0.02 s", "--no-report", "--no-ranges", "--json").out
    found = json.loads(text)
    for key in ("steps", "rejected_steps", "evaluations", "averaged_periods"):
        assert isinstance(found[key], int), key
    assert isinstance(found["duration_s"], float)
    assert found["finished"] is True


def test_ranges_are_made_where_that_is_quick_or_wanted(vvdp, here, monkeypatch):
    def run(*options):
        answer = vvdp(
            "run", "prototype-constant-load", "--until", "0.1 s", "--no-report", "--out", "out", "--force", *options
        )
        assert answer.code == 0, answer.err
        return answer

    assert wording.run.ranges.format(count=12) in run().out
    unasked = run("--no-ranges")
    assert "ranges" not in unasked.out + unasked.err
    monkeypatch.setattr("vvdp.runs.ranges.MOST_EVALUATIONS", 1e3)
    assert wording.run.ranges_on_request.format(count=12) in run().err
    assert "ranges" not in json.loads(run("--json").out)
    found = json.loads(run("--ranges", "--json").out)
    assert found["ranges"]["efficiency"]["by"].keys() == found["ranges"]["loss_total_W"]["by"].keys()


def test_ranges_of_a_run_never_wait_for_the_loop_for_lanes(vvdp, here, monkeypatch):
    monkeypatch.setattr("vvdp.simulation.batch.side_by_side", lambda *_: pytest.fail("lanes were compiled"))
    options = "--until", "0.1 s", "--ranges", "--no-report", "--json", "--out", "out"
    found = json.loads(vvdp("run", "prototype-constant-load", *options).out)
    efficiency = found["ranges"]["efficiency"]
    assert efficiency["low"] < found["efficiency"] < efficiency["high"]


def test_ranges_that_are_interrupted_leave_the_run(vvdp, here, monkeypatch):
    monkeypatch.setattr("vvdp.runs.ranges.run_ranges", lambda run, say: None)
    answer = vvdp("run", "prototype-constant-load", *RANGED, "--out", "out")
    assert answer.code == 0
    assert wording.run.ranges_interrupted in answer.err
    assert "ranges" not in read_results(here / "out").meta


def test_a_range_in_a_file_of_ones_own(vvdp, here):
    """From the file to the page: the longer the tube, the less oil flows through it."""
    text = shipped_systems()["buck-converter"]
    length = re.search(r"^length = .*$", text, re.MULTILINE)[0]
    (here / "mine.toml").write_text(text.replace(length, 'length = { value = "2.5 m", range = ["2 m", "3 m"] }'))
    answer = vvdp("run", "mine.toml", "--until", "0.1 s", "--out", "out")
    assert answer.code == 0, answer.err
    assert wording.run.range_of_one in answer.out
    page = (here / "out" / "report.html").read_text("utf-8")
    assert wording.report.rests_on in page
    assert wording.systems.tube_length in page
    bad = (here / "mine.toml").read_text().replace('"2 m", "3 m"', '"3 m", "4 m"')
    (here / "bad.toml").write_text(bad)
    line = next(number for number, each in enumerate(bad.splitlines(), 1) if each.startswith("length"))
    refused = vvdp("run", "bad.toml")
    assert refused.code == 2
    assert (
        f"bad.toml:{line}: components.tube.length: "
        + wording.files.expected_range_of.format(value="2500 mm", low="3 m", high="4 m")
        in refused.err
    )
