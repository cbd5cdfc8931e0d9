"""`vvdp study` and its guide."""

import csv
import json
import re
from pathlib import Path

import numpy as np
import pytest
from tests.words import wording

from vvdp.results.store import read_result
from vvdp.studies.engine import all_cores

GUIDE = (Path(__file__).parents[2] / "docs" / "studies.md").read_text(encoding="utf-8")
FREQUENCY = {"pwm_frequency_Hz"}


def blocks(language):
    return re.findall(rf"```{language}\n(.*?)```", GUIDE, re.DOTALL)


def test_grid_of_the_guide(vvdp, here, keys_as_described):
    (here / "duty.toml").write_text(blocks("toml")[0])
    done = vvdp("study", "duty.toml", "--json")
    assert done.code == 0, done.err
    found = json.loads(done.out)
    assert found["operation.duty_ratio"] == pytest.approx([0.3, 0.3, 0.5, 0.5, 0.7, 0.7])
    flow = np.array(found["mean_load_flow_m3_s"])
    assert np.all(np.diff(flow[::2]) > 0.0)  # more load flow with more duty
    rows = list(csv.reader((here / "results" / "duty" / "study.csv").open()))
    assert len(rows) == 1 + 6
    assert rows[0][:3] == ["case", "operation.duty_ratio", "oil.air_fraction"] and rows[0][-1] == "failure"
    assert [float(row[rows[0].index("mean_load_flow_m3_s")]) for row in rows[1:]] == found["mean_load_flow_m3_s"]
    keys_as_described(
        "study", {key for key in found if "." not in key} - {"efficiency", "mean_load_flow_m3_s"} - FREQUENCY
    )
    again = vvdp("study", "duty.toml")
    assert wording.study.cases_run.format(count=0) in again.err
    assert wording.progress.count.format(done=6, all=6, what="cases") in again.err
    # A line for each of the two fractions of air over the three duty ratios.
    page = (here / "results" / "duty" / "report.html").read_text("utf-8")
    assert (
        page.count("<figure ") == 3
        and wording.study.chart.format(first="operation.duty_ratio", second="oil.air_fraction") in page
    )
    drawn = read_result(here / "results" / "duty").charts["over-efficiency"].panels[0]
    assert [(line.label, line.rows) for line in drawn.lines] == [("0.5 %", (0, 2, 4)), ("2 %", (1, 3, 5))]
    written = (here / "results" / "duty" / "report.html").read_bytes()
    assert vvdp("report", "results/duty").code == 0
    assert (here / "results" / "duty" / "report.html").read_bytes() == written


def test_random_spreads_of_the_guide(vvdp, here):
    (here / "spread.toml").write_text(blocks("toml")[1].replace("count = 20", "count = 3"))
    done = vvdp("study", "spread.toml", "--out", "kept", "--cores", "1")
    assert done.code == 0, done.err
    assert wording.study.cases_run.format(count=3) in done.err
    assert (here / "kept" / "study.csv").is_file()


def test_python_of_the_guide(here):
    scope: dict[str, object] = {}
    exec(blocks("python")[0], scope)
    efficiency = scope["results"].outputs["efficiency"].values
    assert np.all((efficiency > 0.0) & (efficiency < 1.0))


def test_what_does_not_fit_is_refused(vvdp, here):
    text = 'system = "prototype"\nuntil = "0.1 s"\noutputs = ["efficiency"]\n[grid]\n"operation.duty_ratio" = ["0.5"]\n'
    (here / "bad.toml").write_text(text.replace("efficiency", "efficienc"))
    refused = vvdp("study", "bad.toml")
    assert refused.code == 2
    assert "efficienc" in refused.err
    assert vvdp("study", "nowhere.toml").code == 2
    assert vvdp("study", "bad.toml", "--cores", "0").code == 2


def test_engine_of_the_guide():
    scope: dict[str, object] = {}
    exec(blocks("python")[1], scope)
    cores = scope["engine"].cores or all_cores()
    assert scope["found"] == {item: divmod(item, cores) for item in (7, 8, 9)}


@pytest.mark.thorough
def test_a_study_on_dask_is_the_study_here(vvdp, here):
    (here / "duty.toml").write_text(blocks("toml")[0])
    at_home = json.loads(vvdp("study", "duty.toml", "--json", "--out", "one").out)
    done = vvdp("study", "duty.toml", "--json", "--out", "two", "--on", "dask", "--workers", "1")
    assert done.code == 0, done.err
    assert json.loads(done.out) == at_home | {"out": "two"}
    assert (
        wording.progress.count.format(done=0, all=6, what="cases") + "\n" in done.err
        and wording.progress.count.format(done=6, all=6, what="cases") + "\n" in done.err
    )


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--on", "moon"], "--on: " + wording.engine.engines.format(engine="moon")),
        (["--workers", "2"], "--workers: " + wording.engine.workers.format(count=2, engine="here")),
        (
            ["--on", "tcp://127.0.0.1:9", "--cores", "2"],
            "--cores: " + wording.engine.cores_of_workers.format(count=2),
        ),
        (["--on", "dask", "--sbatch=--mem=1G"], "--sbatch: " + wording.engine.no_sbatch.format(engine="dask")),
        (["--cores", "5000"], wording.engine.too_many_cores.format(count=5000)),
    ],
)
def test_engines_that_cannot_be_are_refused(vvdp, here, words, message):
    (here / "duty.toml").write_text(blocks("toml")[0])
    refused = vvdp("study", "duty.toml", *words)
    assert refused.code == 2 and message in refused.err
    assert not (here / "results").exists()


def test_force_starts_a_study_over_once_it_can_begin(vvdp, here):
    good = (
        'system = "prototype"\nuntil = "0.01 s"\noutputs = ["duration_s"]\n[grid]\n"operation.duty_ratio" = ["0.5"]\n'
    )
    (here / "one.toml").write_text(good)
    assert vvdp("study", "one.toml", "--out", "kept").code == 0
    assert wording.study.cases_run.format(count=0) in vvdp("study", "one.toml", "--out", "kept").err
    (here / "bad.toml").write_text(good.replace("duration_s", "duratio"))
    assert vvdp("study", "bad.toml", "--out", "kept", "--force").code == 2
    assert wording.study.cases_run.format(count=0) in vvdp("study", "one.toml", "--out", "kept").err
    assert wording.study.cases_run.format(count=1) in vvdp("study", "one.toml", "--out", "kept", "--force").err
    assert {path.name for path in here.iterdir()} == {"one.toml", "bad.toml", "kept"}
    (here / "mine").mkdir()
    (here / "mine" / "thesis.txt").write_text("years of work")
    assert vvdp("study", "one.toml", "--out", "mine", "--force").code == 2
    assert (here / "mine" / "thesis.txt").is_file()
