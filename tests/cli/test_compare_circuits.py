"""`vvdp compare circuits`."""

import csv
import json
import shlex
from pathlib import Path

import pytest
from tests.words import wording

from vvdp.comparison import circuit_trials

DOCUMENTS = Path(__file__).parents[2] / "docs"
QUICK = ("--cycle", "heavy", "--circuit", "throttle", "--circuit", "four-valves")


def test_what_there_is_is_listed(vvdp, here):
    answer = vvdp("compare", "circuits", "--list")
    assert answer.code == 0
    for name in ("triangle", "heavy", "digging", "vvdp", "throttle", "ideal-pump", "shuttle", "four-valves"):
        assert f"  {name} " in answer.out
    assert list(here.iterdir()) == []


def test_the_valve_of_another_system_joins(vvdp, here):
    answer = vvdp("compare", "circuits", "--valve", "prototype", "--list")
    assert "  vvdp-valve " in answer.out and wording.compare.rotary_valve_of.format(system="prototype") in answer.out


def test_files_and_page(vvdp, here):
    answer = vvdp("compare", "circuits", *QUICK, "--out", "found")
    assert answer.code == 0, answer.err
    assert (
        wording.progress.count.format(done=4, all=4, what="runs") in answer.err
        and wording.compare.delivered.format(duty="Heavy", force="10 kN", power="808 W") in answer.out
    )
    names = {path.name for path in (here / "found").rglob("*.*")}
    assert {"comparison.csv", "circuits.csv", "report.html", "powers-heavy.svg", "shares-heavy.svg"} <= names
    assert {"course-heavy.svg", "trace-heavy-throttle.csv"} <= names
    rows = list(csv.DictReader((here / "found" / "comparison.csv").open()))
    assert [row["circuit"] for row in rows] == ["throttle", "four-valves"]
    page = here / "found" / "report.html"
    before = page.read_bytes()
    page.unlink()
    assert vvdp("report", "found").code == 0 and page.read_bytes() == before
    assert vvdp("compare", "circuits", *QUICK, "--out", "found").code == 2


def test_json_alone_on_stdout(vvdp, here, keys_as_described):
    found = json.loads(vvdp("compare", "circuits", *QUICK, "--json", "--no-report").out)
    keys_as_described("compare circuits", found)
    assert (found["runs"], found["finished"]) == (2, True)
    assert found["comparison_power_drawn_W"] == pytest.approx([7431.0, 839.0], rel=2e-3)
    errors = found["error_rms_mm"]
    assert len(errors) == 2 and max(errors) <= 1.05 * min(errors)
    assert errors == pytest.approx([1e3 * each for each in found["comparison_tracking_error_rms_m"]])
    assert errors == pytest.approx([1e3 * found["compared_error_rms_m"]] * 2, rel=0.02)
    assert found["comparison_power_returned_W"] == pytest.approx([0.0, 698.5], abs=2.0)


def test_a_cycle_of_ones_own(vvdp, here):
    (here / "mine.csv").write_text("time,position,force\n0,0.05,-500\n2,0.15,-500\n4,0.05,-500\n")
    answer = vvdp("compare", "circuits", "--own-cycle", "mine.csv", "--circuit", "throttle", "--out", "found")
    assert answer.code == 0, answer.err
    assert (
        wording.compare.own_cycle.format(name="mine", file="mine.csv", count=3) in answer.out
        and "triangle" not in answer.out
    )
    (here / "mine.csv").write_text("time,position,force\n0,0.05,-500\n2,0.15\n")
    answer = vvdp("compare", "circuits", "--own-cycle", "mine.csv", "--circuit", "throttle", "--out", "other")
    assert answer.code == 2 and "mine.csv:3: '2,0.15,' " + wording.compare.not_three_numbers in answer.err
    assert not (here / "other").exists()


@pytest.mark.parametrize(
    ("options", "told"),
    [
        (("--cycle", "triangel"), wording.files.did_you_mean.format(name="triangle")),
        (("--circuit", "hydraulic"), "hydraulic"),
        (("--valve", "throttle-control"), "throttle-control: valve: " + wording.compare.not_one_valve),
        (("--circuit", "throttle", "--error", "0 mm"), "0 mm must be greater than 0"),
        (("--own-cycle", "none.csv"), "none.csv: " + wording.files.cannot_read),
    ],
)
def test_what_cannot_be_is_refused(vvdp, here, options, told):
    answer = vvdp("compare", "circuits", *options)
    assert answer.code == 2 and told in answer.err
    assert list(here.iterdir()) == []


def test_a_cycle_that_no_circuit_can_follow_is_refused(vvdp, here):
    (here / "fast.csv").write_text("time,position,force\n0,0.05,-500\n0.2,0.25,-500\n4,0.05,-500\n")
    answer = vvdp("compare", "circuits", "--own-cycle", "fast.csv", "--circuit", "throttle", "--out", "found")
    assert (
        answer.code == 2 and wording.compare.too_fast.format(row=2, speed="1000 mm/s", reach="329.1 mm/s") in answer.err
    )
    assert not (here / "found").exists()


def test_an_interrupt_keeps_what_is_done(vvdp, here, monkeypatch):
    def interrupted(*arguments, **options):
        heard = options["progress"]

        def stop(done, total):
            heard(done, total)
            if done:
                raise KeyboardInterrupt

        return compare_circuits(*arguments, **{**options, "progress": stop})

    compare_circuits = circuit_trials.compare_circuits
    monkeypatch.setattr(circuit_trials, "compare_circuits", interrupted)
    answer = vvdp("compare", "circuits", *QUICK, "--circuit", "throttle", "--circuit", "shuttle", "--out", "found")
    assert answer.code == 130 and wording.progress.interrupted_after in answer.err
    assert json.loads((here / "found" / "result.json").read_text())["finished"] is False
    assert wording.progress.incomplete_page in (here / "found" / "report.html").read_text("utf-8")


def test_the_example_of_the_guide_is_real(vvdp, here):
    guide = (DOCUMENTS / "command-line.md").read_text("utf-8")
    command, _, rest = guide.partition("    $ vvdp compare circuits ")[2].partition("\n")
    shown = [line.strip() for line in rest.partition("\n*Drawn* is")[0].splitlines() if line.strip()]
    answer = vvdp("compare", "circuits", *shlex.split(command))
    assert len(shown) > 8
    assert [line for line in shown if line not in {line.strip() for line in answer.out.splitlines()}] == []
