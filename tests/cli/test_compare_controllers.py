"""`vvdp compare controllers`."""

import csv
import json
import shlex
from pathlib import Path

import pytest
from tests.words import wording

from vvdp.comparison import loop_trials

pytestmark = pytest.mark.heavy

DOCUMENTS = Path(__file__).parents[2] / "docs"
QUICK = ("--controller", "passivity", "--scenario", "nominal", "--scenario", "noise-free", "--seeds", "2")


def test_what_there_is_is_listed(vvdp, here):
    answer = vvdp("compare", "controllers", "--list")
    assert answer.code == 0
    for name in ("passivity", "printed", "best-backstepping", "raw", "polluted", "air-trace", "frozen-sensor"):
        assert f"  {name} " in answer.out
    assert list(here.iterdir()) == []


@pytest.mark.thorough
def test_files_and_page(vvdp, here):
    answer = vvdp("compare", "controllers", *QUICK, "--out", "found")
    assert answer.code == 0, answer.err
    assert (
        wording.compare.tracking_rms in answer.out
        and wording.progress.count.format(done=4, all=4, what="runs") in answer.err
    )
    names = {path.name for path in (here / "found").rglob("*.*")}
    assert {"comparison.csv", "controllers.csv", "tracking-1.csv", "report.html", "noise.svg", "errors.svg"} <= names
    rows = list(csv.DictReader((here / "found" / "comparison.csv").open()))
    assert [row["scenario"] for row in rows] == ["nominal", "noise-free"]
    assert all(float(row["tracking_error_rms_m"]) < 1e-5 for row in rows)
    page = here / "found" / "report.html"
    before = page.read_bytes()
    page.unlink()
    assert vvdp("report", "found").code == 0 and page.read_bytes() == before
    assert vvdp("compare", "controllers", *QUICK, "--out", "found").code == 2


def test_json_alone_on_stdout(vvdp, here, keys_as_described):
    found = json.loads(vvdp("compare", "controllers", *QUICK, "--json", "--no-report").out)
    keys_as_described("compare controllers", found)
    assert (found["seeds"], found["runs"], found["finished"]) == (2, 4, True)
    noisy, clean = found["comparison_effort_change_rms"]
    assert found["controllers_noise_sensitivity"] == [pytest.approx(noisy - clean)]
    assert noisy > clean


def test_the_example_of_the_guide_is_real(vvdp, here):
    guide = (DOCUMENTS / "command-line.md").read_text("utf-8")
    command, _, rest = guide.partition("    $ vvdp compare controllers ")[2].partition("\n")
    shown = [line.strip() for line in rest.partition("\nNoise sensitivity")[0].splitlines() if line.strip()]
    answer = vvdp("compare", "controllers", *shlex.split(command))
    assert len(shown) > 10
    assert [line for line in shown if line not in {line.strip() for line in answer.out.splitlines()}] == []


@pytest.mark.parametrize(
    ("options", "told"),
    [
        (("--scenario", "air-traces"), wording.files.did_you_mean.format(name="air-trace")),
        (("--controller", "pid"), "pid"),
        (("--seeds", "0"), "--seeds"),
    ],
)
def test_what_cannot_be_is_refused(vvdp, here, options, told):
    answer = vvdp("compare", "controllers", *options)
    assert answer.code == 2 and told in answer.err
    assert list(here.iterdir()) == []


def test_an_interrupt_keeps_what_is_done(vvdp, here, monkeypatch):
    def interrupted(*arguments, **options):
        heard = options["progress"]

        def stop(done, total):
            heard(done, total)
            if done:
                raise KeyboardInterrupt

        return compare_controllers(*arguments, **{**options, "progress": stop})

    compare_controllers = loop_trials.compare_controllers
    monkeypatch.setattr(loop_trials, "compare_controllers", interrupted)
    answer = vvdp("compare", "controllers", *QUICK[:-1], "200", "--out", "found", "--cores", "1")
    assert answer.code == 130 and wording.progress.interrupted_after in answer.err
    assert json.loads((here / "found" / "result.json").read_text())["finished"] is False
    assert wording.progress.incomplete_page in (here / "found" / "report.html").read_text("utf-8")
