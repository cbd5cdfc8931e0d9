"""`vvdp compare runs`."""

import csv
import json

import h5py
import pytest
from tests.words import wording


def summary(directory):
    return json.loads((directory / "summary.json").read_text())


def test_numbers_stand_side_by_side_with_their_difference(vvdp, here, two_runs, keys_as_described):
    answer = vvdp("compare", "runs", *map(str, two_runs), "--json", "--no-report")
    assert answer.code == 0, answer.err
    found = json.loads(answer.out)
    assert found["run"] == ["slow", "fast"]
    assert found["operation.pump_speed_rad_s"] == pytest.approx([125.66370614359172, 188.49555921538757])
    assert found["operation.duty_ratio"] == pytest.approx([0.4, 0.6])
    assert not any("." in key for key in found.keys() - {"operation.pump_speed_rad_s", "operation.duty_ratio"})
    slow, fast = map(summary, two_runs)
    for key in ("load_power_W", "flow_mean_pump_m3_s", "pressure_mean_inlet_Pa", "speed_mean_spool_rad_s"):
        assert found[key] == [slow[key], fast[key]]
        assert found[f"difference_{key}"] == [0.0, pytest.approx(fast[key] - slow[key])]
    # Flow goes with speed, less what leaks.
    assert found["flow_mean_pump_m3_s"][1] == pytest.approx(1.5 * found["flow_mean_pump_m3_s"][0], rel=1e-2)
    assert found["warnings"] == [] and found["finished"] is True
    assert found["out"].startswith("results/compare-runs-")
    keys_as_described("compare runs", {key for key in found if "." not in key})


def test_screen_and_page(vvdp, here, two_runs):
    answer = vvdp("compare", "runs", *map(str, two_runs), "--out", "found")
    assert answer.code == 0, answer.err
    rows = {line.split("  ")[1].strip(): line.split() for line in answer.out.splitlines() if line.startswith("  ")}
    assert rows["operation.pump_speed"][-3:] == ["1200", "1800", "rpm"]
    assert wording.compare.mean_load_pressure in rows and "steps" not in rows and "duration" not in answer.out
    page = (here / "found" / "report.html").read_text("utf-8")
    assert wording.compare.pressures_over_time in page and wording.compare.parameters_that_differ in page
    assert (here / "found" / "figures" / "flow.svg").is_file()
    for number, run in enumerate(two_runs, 1):
        with (here / "found" / f"series-{number}.csv").open() as file:
            found = [float(row["speed_spool_rad_s"]) for row in csv.DictReader(file)]
        with h5py.File(run / "result.h5") as file:
            assert found == file["states/spool/speed"][:].tolist()
    page_again = here / "found" / "report.html"
    before = page_again.read_bytes()
    assert vvdp("report", "found").code == 0 and page_again.read_bytes() == before
    again = vvdp("compare", "runs", *map(str, two_runs), "--out", "found")
    assert again.code == 2 and wording.files.already_exists in again.err


def test_a_run_and_itself_are_the_same(vvdp, here, two_runs):
    answer = vvdp("compare", "runs", str(two_runs[0]), str(two_runs[0]), "--no-report", "--out", "same")
    assert answer.code == 0, answer.err
    assert wording.compare.differences.format(parameters=0, results=0) in answer.out
    assert not (here / "same" / "report.html").exists()


def test_another_circuit_is_told(vvdp, here, two_runs, other_run):
    answer = vvdp("compare", "runs", str(two_runs[0]), str(other_run), "--json", "--no-report")
    assert answer.code == 0, answer.err
    found = json.loads(answer.out)
    assert found["warnings"] == [wording.compare.another_circuit.format(run="buck", other="slow")]
    assert found["pump.displacement_m3_rad"][1] is None and found["pump.displacement_m3_rad"][0] > 0.0


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["{run}"], wording.files.expected_two_or_more),
        (["{run}", "nowhere"], "nowhere: " + wording.files.no_directory),
        ([], "Missing argument"),
    ],
)
def test_what_cannot_be_compared_is_refused(vvdp, here, two_runs, words, told):
    answer = vvdp("compare", "runs", *(word.format(run=two_runs[0]) for word in words))
    assert answer.code == 2 and told in answer.err
    assert list(here.iterdir()) == []
