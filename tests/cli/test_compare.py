"""`vvdp compare estimators`."""

import csv
import json
import shlex
from pathlib import Path

import pytest
from tests.words import wording

from vvdp.comparison import trials
from vvdp.comparison.estimators import contenders
from vvdp.comparison.scenarios import scenarios

DOCUMENTS = Path(__file__).parents[2] / "docs"

QUICK = ("--estimator", "inverse-time", "--estimator", "m-over-t", "--scenario", "constant", "--seeds", "2")


def test_what_there_is_is_listed(vvdp, here):
    answer = vvdp("compare", "estimators", "--list")
    assert answer.code == 0
    for name in ("event-filter", "no-manoeuvres", "tracking-loop", "smoother", "missed-edges", "dropout", "captured"):
        assert f"  {name} " in answer.out
    assert list(here.iterdir()) == []


def test_files_and_table(vvdp, here):
    answer = vvdp("compare", "estimators", *QUICK, "--out", "found")
    assert answer.code == 0, answer.err
    assert "inverse-time" in answer.out and "24.7 Hz" in answer.out and wording.compare.time_of_a_sample in answer.out
    assert wording.compare.sectors_lost in answer.out
    assert wording.progress.count.format(done=2, all=2, what="runs") in answer.err
    names = {path.name for path in (here / "found").rglob("*.*")}
    assert {
        "comparison.csv",
        "result.json",
        "estimators.csv",
        "traces.csv",
        "meta.json",
        "report.html",
        "cost.svg",
    } <= names
    rows = list(csv.DictReader((here / "found" / "comparison.csv").open()))
    assert [row["estimator"] for row in rows] == ["inverse-time", "m-over-t"]
    # One sector is 5.06 ms, timed as 4, 5 or 6: 196.3, 157.1 or 130.9 rad/s, at least 24 rad/s off where not 5.
    assert 10.0 < float(rows[0]["speed_error_rms_rad_s"]) < 40.0
    again = vvdp("compare", "estimators", *QUICK, "--out", "found")
    assert again.code == 2 and wording.files.already_exists in again.err
    assert vvdp("compare", "estimators", *QUICK, "--out", "found", "--force").code == 0
    page = here / "found" / "report.html"
    written = page.read_bytes()
    page.unlink()
    assert vvdp("report", "found").code == 0 and page.read_bytes() == written


def test_the_example_of_the_guide_is_real(vvdp, here):
    """All but the times that it took, which are those of a machine."""
    guide = (DOCUMENTS / "command-line.md").read_text("utf-8")
    command, _, rest = guide.partition("    $ vvdp compare estimators ")[2].partition("\n")
    shown = [line.strip() for line in rest.partition("errors are estimate")[0].splitlines() if line.strip()]
    answer = vvdp("compare", "estimators", *shlex.split(command))
    assert len(shown) == 5
    assert [line for line in shown if line not in {line.strip() for line in answer.out.splitlines()}] == []


def test_all_is_explained(vvdp, here):
    page = (DOCUMENTS / "comparison.md").read_text("utf-8")
    for each in (*scenarios(), *contenders()):
        assert f"`{each.name}`" in page, each.name


def test_json_alone_on_stdout(vvdp, here, keys_as_described):
    answer = vvdp("compare", "estimators", *QUICK, "--json", "--rate", "2 kHz", "--sectors", "16")
    found = json.loads(answer.out)
    assert (found["rate_Hz"], found["sectors"], found["finished"]) == (2000.0, 16, True)
    keys_as_described("compare estimators", found)
    assert len(found["comparison_scenario"]) == 2
    assert found["out"].startswith("results/compare-estimators-")
    assert (here / found["out"] / "comparison.csv").is_file()


def _scores(found):
    return {key: values for key, values in found.items() if key.startswith("comparison_")}


@pytest.mark.thorough
def test_a_comparison_on_dask_is_the_comparison_here(vvdp, here):
    at_home = json.loads(vvdp("compare", "estimators", *QUICK, "--json").out)
    done = vvdp("compare", "estimators", *QUICK, "--json", "--on", "dask", "--workers", "1")
    assert done.code == 0, done.err
    assert _scores(json.loads(done.out)) == _scores(at_home)


@pytest.mark.parametrize(
    ("options", "told"),
    [
        (("--scenario", "stepp"), wording.files.did_you_mean.format(name="step")),
        (("--estimator", "kalman"), "kalman"),
        (("--rate", "1000"), "--rate: '1000' " + wording.files.has_no_unit),
        (("--rate", "0 Hz"), wording.files.expected_range.format(low="100 Hz", high="100000 Hz")),
        (("--sectors", "7"), wording.estimate.sectors.format(count=7)),
        (("--seeds", "0"), "--seeds"),
        (("--workers", "2"), "--workers: " + wording.engine.workers.format(count=2, engine="here")),
    ],
)
def test_what_cannot_be_is_refused(vvdp, here, options, told):
    answer = vvdp("compare", "estimators", *options)
    assert answer.code == 2
    assert told in answer.err
    assert list(here.iterdir()) == []


def test_an_interrupt_keeps_what_is_done(vvdp, here, monkeypatch):
    def interrupted(*arguments, **options):
        heard = options["progress"]

        def stop(done, total):
            heard(done, total)
            if done >= 3:
                raise KeyboardInterrupt

        return trials_compare(*arguments, **{**options, "progress": stop})

    trials_compare = trials.compare
    monkeypatch.setattr(trials, "compare", interrupted)
    answer = vvdp("compare", "estimators", *QUICK[:-1], "500", "--out", "found", "--cores", "1")
    assert answer.code == 130
    assert wording.progress.interrupted_after in answer.err
    assert json.loads((here / "found" / "result.json").read_text())["finished"] is False
    assert wording.progress.incomplete_page in (here / "found" / "report.html").read_text("utf-8")
