"""`vvdp run --live` and `vvdp report --live`."""

import json
from pathlib import Path

STARVED = Path(__file__).parents[1] / "web" / "starved.toml"


def model(directory: Path):
    """What the scripts of a report's page are given."""
    page = (directory / "report.html").read_text("utf-8")
    return json.loads(page.partition('id="model">')[2].partition("</script>")[0])


def test_a_live_report_repeats_the_line_of_the_run(vvdp, here):
    setting = 'nodes.shaft.speed="200 rpm"'
    done = vvdp("run", str(STARVED), "--set", setting, "--until", "0.3 s", "--live", "--out", "run", "--no-ranges")
    assert done.code == 0, done.err
    found = model(here / "run")
    assert found["command"] == f"vvdp run {STARVED} --set '{setting}' --until '0.3 s'"
    assert found["stepping"]["until"] == 0.3
    first = (here / "run" / "report.html").stat().st_size
    assert vvdp("report", "run").code == 0
    assert "wasm" not in (here / "run" / "report.html").read_text("utf-8")
    assert (here / "run" / "report.html").stat().st_size < first
    assert vvdp("report", "run", "--live").code == 0
    again = model(here / "run")
    assert again["command"] == "vvdp run run/system.toml"
    assert {key: again[key] for key in ("cells", "texts", "series", "summary", "modules")} == {
        key: found[key] for key in ("cells", "texts", "series", "summary", "modules")
    }


def test_only_the_report_of_a_run_takes_live(vvdp, here):
    for name, area in (("one", "100 mm^2"), ("other", "90 mm^2")):
        vvdp("run", str(STARVED), "--set", f'components.inlet.area="{area}"', "--no-report", "--out", name)
    assert vvdp("compare", "runs", "one", "other", "--out", "both").code == 0
    done = vvdp("report", "both", "--live")
    assert done.code == 2
    assert "both: holds no run; only the report of a run takes --live" in " ".join(done.err.split())


def test_what_cannot_be_live_is_refused(vvdp, here):
    for option in (["--no-report"], ["--cycle", "log.csv"]):
        done = vvdp("run", str(STARVED), "--live", *option)
        assert done.code == 2
        assert f"leave out {option[0]}" in " ".join(done.err.split())
    assert vvdp("run", str(STARVED), "--live", "--watch").code == 2
    assert not list(here.iterdir())
