"""`vvdp map`: files, numbers, bad input, going on."""

import json

SMALL = ("--duty", "0.4", "0.8", "2", "--pressure", "40 bar", "80 bar", "2")


def test_analytic_map_leaves_table_pictures_and_page(vvdp, here):
    answer = vvdp("map", "prototype", "--analytic", *SMALL, "--speed", "1500 rpm")
    assert answer.code == 0, answer.err
    folder = here / "results" / "analytic-map-prototype"
    assert {path.name for path in folder.iterdir()} == {
        "figures", "map.csv", "meta.json", "numbers.json", "report.html", "rig.json", "system.toml",
    }  # fmt: skip
    assert {path.name for path in (folder / "figures").iterdir()} == {
        "efficiency.png", "efficiency.svg", "flow.png", "flow.svg",
    }  # fmt: skip
    page = (folder / "report.html").read_text()
    for words in ("in the manner of ISO 17559 and ISO 4409", "Left out", "44.18 mm²/s", "1500 rpm", "40 to 80 bar"):
        assert words in page
    assert "overall efficiency" in answer.out


def test_simulated_map_in_si(vvdp, here, keys_as_described):
    first = vvdp("map", "prototype-constant-load", *SMALL, "--json", "--no-report", "--out", "m")
    found = json.loads(first.out)
    quick = vvdp("map", "prototype", "--analytic", *SMALL, "--json", "--no-report", "--out", "a")
    keys_as_described("map", found, json.loads(quick.out))
    assert found["points"] == 4
    assert found["load_pressure_Pa"] == [4e6, 4e6, 8e6, 8e6]
    assert found["duty_ratio"] == [0.4, 0.8, 0.4, 0.8]
    assert all(0.3 < value < 0.9 for value in found["overall_efficiency"])
    again = vvdp("map", "prototype-constant-load", *SMALL, "--json", "--no-report", "--out", "m")
    assert json.loads(again.out)["overall_efficiency"] == found["overall_efficiency"]
    assert "4 of 4 points are finished already" in again.err
    assert not (here / "m" / "report.html").exists()


def test_one_pressure_gives_lines(vvdp, here):
    answer = vvdp("map", "prototype", "--analytic", "--duty", "0.2", "1", "5", "--pressure", "80 bar", "80 bar", "1")
    assert answer.code == 0, answer.err
    assert (here / "results" / "analytic-map-prototype" / "figures" / "efficiency.png").stat().st_size > 5000


def test_all_faults_of_options_at_once(vvdp, here):
    answer = vvdp("map", "prototype", "--duty", "a", "1", "3", "--pressure", "1 lpm", "2 bar", "0", "--speed", "50 Hz")
    assert answer.code == 2
    for words in ("--duty", "--pressure", "--speed", "write 3000 rpm"):
        assert words in answer.err
    assert not (here / "results").exists()


def test_an_analytic_map_needs_no_workers(vvdp, here):
    answer = vvdp("map", "prototype", "--analytic", "--on", "dask")
    assert answer.code == 2
    assert "--on: 'dask'; an analytic map is worked out at once, here" in answer.err
    assert not (here / "results").exists()


def test_a_map_on_dask_is_the_map_here(vvdp, here):
    small = ("prototype-constant-load", "--duty", "0.4", "0.8", "2", "--pressure", "40 bar", "40 bar", "1", "--json")
    at_home = json.loads(vvdp("map", *small, "--no-report", "--out", "one").out)
    done = vvdp("map", *small, "--no-report", "--out", "two", "--on", "dask", "--workers", "1")
    assert done.code == 0, done.err
    assert json.loads(done.out) == at_home | {"out": "two"}
    assert "0 of 2 points\n" in done.err and "2 of 2 points\n" in done.err


def test_levels_that_go_down_are_refused(vvdp, here):
    answer = vvdp("map", "prototype", "--pressure", "80 bar", "40 bar", "3")
    assert answer.code == 2
    assert "expected increasing values" in answer.err


def test_directory_of_something_else_is_left_alone(vvdp, here):
    (here / "mine").mkdir()
    (here / "mine" / "notes.txt").write_text("keep")
    answer = vvdp("map", "prototype", "--analytic", "--out", "mine")
    assert answer.code == 2
    assert "holds something else than a map" in answer.err
    assert (here / "mine" / "notes.txt").read_text() == "keep"


def test_pump_at_rest_is_refused(vvdp, here):
    answer = vvdp("map", "prototype", "--set", "operation.pump_speed=0 rpm")
    assert answer.code == 2
    assert "expected more than 0 rad/s" in answer.err
