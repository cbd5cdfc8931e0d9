"""`vvdp map`: files, numbers, bad input, going on."""

import json

import pytest
from tests.words import wording

SMALL = ("--duty", "0.4", "0.8", "2", "--pressure", "40 bar", "80 bar", "2")


def test_analytic_map_leaves_table_pictures_and_page(vvdp, here):
    answer = vvdp("map", "prototype", "--analytic", *SMALL, "--speed", "1500 rpm")
    assert answer.code == 0, answer.err
    folder = here / "results" / "analytic-map-prototype"
    assert {path.name for path in folder.iterdir()} == {
        "figures", "map.csv", "meta.json", "report.html", "result.json", "system.toml", "vvdp.json",
    }  # fmt: skip
    assert {path.name for path in (folder / "figures").iterdir()} >= {"efficiency.svg", "flow.svg"}
    page = (folder / "report.html").read_text()
    for words in (wording.map.standards, wording.report.left_out, "44.18 cSt", "1500 rpm", "40 to 80 bar"):
        assert words in page
    assert wording.map.efficiency in answer.out
    assert "80 bar" in answer.out


def test_simulated_map_in_si(vvdp, here, keys_as_described):
    first = vvdp("map", "prototype-constant-load", *SMALL, "--json", "--no-report", "--out", "m")
    found = json.loads(first.out)
    quick = vvdp("map", "prototype", "--analytic", *SMALL, "--json", "--no-report", "--out", "a")
    keys_as_described("map", found, json.loads(quick.out))
    assert found["points"] == 4
    assert found["load_pressure_Pa"] == [4e6, 4e6, 8e6, 8e6]
    assert found["duty_ratio"] == [0.4, 0.8, 0.4, 0.8]
    assert all(0.3 < value < 0.9 for value in found["overall_efficiency"])
    assert wording.map.points.format(points=4, more=10, pressures=5) + "\n" in first.err
    assert wording.progress.count.format(done=0, all=14, what="points") + ", about " in first.err
    again = vvdp("map", "prototype-constant-load", *SMALL, "--json", "--no-report", "--out", "m")
    assert json.loads(again.out)["overall_efficiency"] == found["overall_efficiency"]
    assert wording.progress.finished_already.format(done=14, all=14, what="points") in again.err
    assert not (here / "m" / "report.html").exists()


def test_one_pressure_gives_lines(vvdp, here):
    answer = vvdp("map", "prototype", "--analytic", "--duty", "0.2", "1", "5", "--pressure", "80 bar", "80 bar", "1")
    assert answer.code == 0, answer.err
    assert (here / "results" / "analytic-map-prototype" / "figures" / "efficiency.svg").stat().st_size > 5000


def test_all_faults_of_options_at_once(vvdp, here):
    answer = vvdp("map", "prototype", "--duty", "a", "1", "3", "--pressure", "1 lpm", "2 bar", "0", "--speed", "50 Hz")
    assert answer.code == 2
    for words in ("--duty", "--pressure", "--speed", wording.files.write_instead.format(value="3000 rpm")):
        assert words in answer.err
    assert not (here / "results").exists()


def test_an_analytic_map_needs_no_workers(vvdp, here):
    answer = vvdp("map", "prototype", "--analytic", "--on", "dask")
    assert answer.code == 2
    assert "--on: " + wording.map.analytic_here.format(engine="dask") in answer.err
    assert not (here / "results").exists()


@pytest.mark.thorough
def test_a_map_on_dask_is_the_map_here(vvdp, here):
    small = ("prototype-constant-load", "--duty", "0.4", "0.8", "2", "--pressure", "40 bar", "40 bar", "1", "--json")
    at_home = json.loads(vvdp("map", *small, "--no-report", "--out", "one").out)
    done = vvdp("map", *small, "--no-report", "--out", "two", "--on", "dask", "--workers", "1")
    assert done.code == 0, done.err
    assert json.loads(done.out) == at_home | {"out": "two"}
    assert (
        wording.progress.count.format(done=0, all=12, what="points") + ", about " in done.err
        and wording.progress.count.format(done=12, all=12, what="points") + "\n" in done.err
    )


def test_levels_that_go_down_are_refused(vvdp, here):
    answer = vvdp("map", "prototype", "--pressure", "80 bar", "40 bar", "3")
    assert answer.code == 2
    assert wording.files.expected_increasing in answer.err


def test_directory_of_something_else_is_left_alone(vvdp, here):
    (here / "mine").mkdir()
    (here / "mine" / "notes.txt").write_text("keep")
    answer = vvdp("map", "prototype", "--analytic", "--out", "mine")
    assert answer.code == 2
    assert wording.map.something_else in answer.err
    assert (here / "mine" / "notes.txt").read_text() == "keep"


def test_pump_at_rest_is_refused(vvdp, here):
    answer = vvdp("map", "prototype", "--set", "operation.pump_speed=0 rpm")
    assert answer.code == 2
    assert wording.files.greater_than_zero in answer.err


def test_axes_in_the_units_of_the_reader(vvdp, here):
    """Gauge, as they were written, and duty ratios from 0 to 1 only."""
    answer = vvdp("map", "prototype", "--pressure", "100 bar", "10 bar", "4", "--duty", "0.2", "1.5", "4")
    assert answer.code == 2
    assert "--pressure: '100 bar' to '10 bar'; " + wording.files.expected_increasing in answer.err
    assert "--duty: " + wording.files.outside_range.format(value="'1.5'", low=0, high=1) in answer.err
    assert (
        wording.files.outside_range.format(value="'-0.2'", low=0, high=1)
        in vvdp("map", "prototype", "--duty", "-0.2", "1", "4").err
    )
    assert (
        wording.files.expected_numbers_above.format(value="-1000 rpm", limit="0 rpm")
        in vvdp("map", "prototype", "--speed", "-1000 rpm").err
    )
    assert not (here / "results").exists()


def test_every_speed_and_temperature_has_its_table(vvdp, here):
    axes = ("--speed", "1000 rpm", "--speed", "1500 rpm", "--temperature", "20 degC", "--temperature", "50 degC")
    answer = vvdp("map", "prototype", "--analytic", *SMALL, *axes, "--no-report")
    for words in ("1000 rpm, 20 °C", "1500 rpm, 20 °C", "1000 rpm, 50 °C", "1500 rpm, 50 °C"):
        assert f"{wording.map.efficiency}, {words}" in answer.out


def test_spool_that_cannot_turn_is_refused(vvdp, here):
    answer = vvdp("map", "prototype-constant-load", "--set", "valve.friction_area=0.9 m^2", *SMALL)
    assert answer.code == 2
    assert wording.map.friction.format(friction="0.442 N*m*s", area="0.9 m^2") in answer.err


def test_analytic_and_simulated_maps_do_not_replace_each_other(vvdp, here):
    one = ("--duty", "0.5", "0.5", "1", "--pressure", "40 bar", "40 bar", "1", "--no-report", "--out")
    assert vvdp("map", "prototype-constant-load", *one, "m").code == 0
    before = (here / "m" / "map.csv").read_text()
    answer = vvdp("map", "prototype-constant-load", "--analytic", *one, "m")
    assert answer.code == 2
    assert "m: " + wording.map.holds_simulated in answer.err
    assert (here / "m" / "map.csv").read_text() == before
    assert vvdp("map", "prototype-constant-load", "--analytic", *one, "a").code == 0
    assert wording.map.holds_analytic in vvdp("map", "prototype-constant-load", *one, "a").err


def test_force_replaces_another_map_and_nothing_else(vvdp, here):
    quick = ("map", "prototype", "--analytic", *SMALL, "--no-report", "--out", "m")
    assert vvdp(*quick).code == 0
    (here / "m" / "own.txt").write_text("beside the map")
    refused = vvdp(*quick, "--force")
    assert refused.code == 2 and "own.txt" in refused.err
    (here / "m" / "own.txt").unlink()
    before = (here / "m" / "meta.json").stat().st_mtime_ns
    assert vvdp(*quick, "--force").code == 0
    assert (here / "m" / "meta.json").stat().st_mtime_ns != before
    (here / "mine").mkdir()
    (here / "mine" / "thesis.txt").write_text("years of work")
    assert vvdp(*quick[:-1], "mine", "--force").code == 2
    assert (here / "mine" / "thesis.txt").is_file()
