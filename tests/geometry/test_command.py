"""`vvdp geometry`: its files, what it tells, its page, and the page made anew."""

import io
import json
import re
import shutil
from collections.abc import Mapping
from contextlib import redirect_stdout
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
from tests.report.browser import running
from tests.words import wording

from vvdp.base.files import list_all
from vvdp.cli.main import main
from vvdp.geometry.files import read_stl
from vvdp.geometry.mesh import components, open_edges, volume
from vvdp.geometry.solids import COARSEST, spool
from vvdp.report.geometry_report import write_geometry_report
from vvdp.report.shading import lying_frame, shade
from vvdp.results.store import read_result
from vvdp.valve.geometry import port_openings

pytestmark = pytest.mark.thorough


class Made(NamedTuple):
    folder: Path
    told: Mapping[str, Any]


@pytest.fixture(scope="module")
def made(tmp_path_factory) -> Made:
    """A geometry with a coarse mesh and a short film; not to be written to."""
    folder = tmp_path_factory.mktemp("geometry") / "made"
    words = ["--out", str(folder), "--fineness", "10", "--frames", "2", "--angle", "21 deg", "--json"]
    out = io.StringIO()
    with redirect_stdout(out), pytest.raises(SystemExit) as ended:
        main(["geometry", "prototype", *words])
    assert not ended.value.code
    return Made(folder, json.loads(out.getvalue()))


def test_the_command_makes_and_tells_everything(made, keys_as_described):
    told = made.told
    keys_as_described("geometry", told)
    assert told["finished"] is True
    assert abs(told["openings_difference"]) < 0.02
    assert told["rail_volume_m3"] == pytest.approx(12.7e-6, abs=0.05e-6)
    assert told["rail_volume_measured_m3"] == pytest.approx(told["rail_volume_m3"], rel=0.02)
    folder = made.folder
    for name in ("spool.stl", "sleeve.stl", "spool.glb", "geometry.toml", "openings.csv", "period.gif", "report.html"):
        assert (folder / name).is_file(), name
    figures = {path.stem for path in (folder / "figures").glob("*.svg")}
    assert figures == {"unwrapped", "openings-over-angle", "solids", "oil"}
    described = json.loads((folder / "oil" / "domains.json").read_text("utf-8"))
    assert set(described) == {"rail", "without-spool", "centre", "turbine", "valve", "turbine-tank"}
    for name, each in described.items():
        mesh = read_stl(folder / "oil" / each["file"])
        assert (components(mesh), open_edges(mesh)) == (1, 0), name
        assert volume(mesh) == pytest.approx(each["volume_m3"])
        assert set(mesh.names) == set(each["patch_area_m2"])
    assert set(described["valve"]["turning_patches"]) == {"spool", "windows", "chamber", "channels"}


def test_the_command_refuses_with_all_faults(command):
    said = command("prototype", "--set", "geometry.hub_radius=13 mm", "--set", "geometry.nozzle_arm=12.6 mm")
    assert said.code == 2
    assert "hub_radius = 13 mm; " + wording.files.expected_less_than.format(limit="12.7 mm") in said.err
    assert "nozzle_arm = 12.6 mm; " + wording.files.expected_less_than.format(limit="12.32 mm") in said.err


def test_the_command_refuses_a_valve_that_cannot_be(command):
    said = command("prototype", "--set", "valve.nozzle_area=2000 mm^2")
    assert said.code == 2
    assert wording.geometry.pitch.format(pitch="26.6 mm") in said.err


def test_an_interruption_keeps_what_is_made(command, tmp_path, monkeypatch):
    from vvdp.geometry import product

    def stop(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(product, "sleeve", stop)
    said = command("prototype", "--out", "made", "--fineness", "10", "--frames", "2", "--json")
    assert said.code == 130
    assert json.loads(said.out)["finished"] is False
    assert (tmp_path / "made" / "spool.stl").is_file()
    assert wording.progress.partial_page in (tmp_path / "made" / "report.html").read_text("utf-8")


def test_the_command_refuses_early(command, tmp_path):
    """Before anything is made: an angle without unit, a position that the sleeve does not allow."""
    said = command("prototype", "--angle", "3")
    assert said.code == 2
    assert said.err.startswith("--angle: '3' " + wording.files.has_no_unit)
    said = command("prototype", "--set", "operation.duty_ratio=1.2")
    assert said.code == 2
    assert wording.geometry.outside_stroke.format(position="24.38 mm", low=0, high="20.32 mm") in said.err
    assert list(tmp_path.iterdir()) == []


def test_the_result_agrees_with_the_files_and_the_formulas(made, built_valve):
    result = read_result(made.folder)
    bodies, patches, openings = (result.tables[name] for name in ("bodies", "patches", "openings"))
    for file, enclosed in zip(bodies["file"], bodies["volume_m3"], strict=True):
        assert volume(read_stl(made.folder / str(file))) == pytest.approx(enclosed, rel=1e-5), file
    described = json.loads((made.folder / "oil" / "domains.json").read_text("utf-8"))
    of_rail = patches["area_m2"][patches["volume"] == "inlet rail"]
    assert of_rail.sum() == pytest.approx(sum(described["rail"]["patch_area_m2"].values()))
    position = result.numbers["axial_position_m"].value
    load, tank = np.array([port_openings(float(a), position, built_valve) for a in openings["spool_angle_rad"]]).T
    assert openings["load_formula"] == pytest.approx(load)
    assert openings["tank_mesh"] - openings["tank_difference"] == pytest.approx(tank)
    worst = max(abs(openings["load_mesh"] - load).max(), abs(openings["tank_mesh"] - tank).max())
    assert result.numbers["openings_difference"].value == pytest.approx(worst)
    assert result.listings["comparison"].rows[0].values[0] == pytest.approx(built_valve.nozzle_area)
    assert "wang2017" in result.references


def test_shut_volumes_are_named(made):
    assert any(
        wording.geometry.shut_to_this_side in each.text and wording.geometry.of_the_tank in each.text
        for each in read_result(made.folder).findings
    )


def test_the_page_is_the_same_when_made_anew(made, tmp_path):
    folder = shutil.copytree(made.folder, tmp_path / "again")
    before = (folder / "report.html").read_bytes()
    (folder / "report.html").unlink()
    shutil.rmtree(folder / "figures")
    with pytest.raises(SystemExit) as ended:
        main(["report", str(folder)])
    assert not ended.value.code
    assert (folder / "report.html").read_bytes() == before


def test_the_page_shows_what_lies_in_the_directory(made, tmp_path):
    """Without the volumes of oil there is no picture of them, and all else stays."""
    folder = shutil.copytree(made.folder, tmp_path / "less")
    assert 'src="data:image/gif' in (folder / "report.html").read_text("utf-8")
    description = json.loads((folder / "result.json").read_text("utf-8"))
    gone = (wording.geometry.one_period, wording.geometry.volumes_of_oil)
    description["sections"] = [each for each in description["sections"] if each["title"] not in gone]
    (folder / "result.json").write_text(json.dumps(description))
    (folder / "period.gif").unlink()
    shutil.rmtree(folder / "oil")
    list_all(folder)
    page = write_geometry_report(folder).read_text("utf-8")
    assert "image/gif" not in page
    assert {path.stem for path in (folder / "figures").iterdir()} == {"unwrapped", "openings-over-angle", "solids"}


def test_the_page_loads_nothing(made):
    page = (made.folder / "report.html").read_text("utf-8")
    assert "default-src 'none'" in page
    sources = re.findall(r'<(?:img|image|script|link)[^>]*(?:src|href)="([^"]*)"', page)
    assert sources
    assert all(source.startswith("data:") for source in sources)
    assert len(re.search(r'id="solids-data">(.*?)</script>', page)[1]) < 200_000


OPENED = "new Promise((done) => setInterval(() => window.solids && done(true), 20))"
COVERED = """(() => {
  const { gl, canvas } = solids;
  solids.draw();
  const pixels = new Uint8Array(4 * canvas.width * canvas.height);
  gl.readPixels(0, 0, canvas.width, canvas.height, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
  let count = 0;
  for (let i = 0; i < pixels.length; i += 4) if (pixels[i] + pixels[i + 1] + pixels[i + 2] < 765) count++;
  return [count, canvas.width];
})()"""


@pytest.fixture(scope="module")
def browser(chromium, tmp_path_factory):
    with running(chromium, tmp_path_factory.mktemp("browser")) as it:
        yield it


def test_solids_in_the_page_are_as_large_as_in_the_picture(made, browser, built_shape, built_valve):
    """The spool alone, its area as seen in the page against that of the picture, which another program projects."""
    browser.open(made.folder / "report.html")
    assert (
        browser.ask(
            "new Promise((done) => setInterval(() => window.solids && done(solids.described.parts.length), 20))"
        )
        == 2
    )
    browser.ask("document.querySelector('#solids label:nth-of-type(2) input').click()")
    covered, width = browser.ask(COVERED)
    mesh = spool(built_shape, built_valve, COARSEST)
    frame = lying_frame(30.0, 30.0)
    assert np.allclose(browser.ask("solids.described.turn"), frame)
    picture, (left, right, _, _) = shade([mesh], dict.fromkeys(mesh.names, (0.5, 0.5, 0.5)), frame, 1000)
    area = (picture < 0.99).any(-1).sum() * ((right - left) / 1000) ** 2
    longest = float(np.ptp(mesh.vertices[:, 2]))  # the spool is longer than the sleeve
    pixel = 2.0 * longest / 1.85 / width
    assert covered * pixel**2 == pytest.approx(area, rel=0.03)


def test_solids_turn_when_dragged_and_come_back(made, browser):
    browser.open(made.folder / "report.html")
    browser.ask("document.querySelectorAll('details.fold').forEach((each) => { each.open = true; })")
    browser.ask(OPENED)
    browser.ask("solids.canvas.scrollIntoView()")
    left, top = browser.ask("(() => { const r = solids.canvas.getBoundingClientRect(); return [r.left, r.top]; })()")
    before, turn = browser.ask(COVERED), np.array(browser.ask("solids.turn"))
    browser.drag((left + 300.0, top + 200.0), (left + 360.0, top + 230.0))
    turned = np.array(browser.ask("solids.turn"))
    assert np.allclose(turned @ turned.T, np.eye(3))
    assert np.linalg.det(turned) == pytest.approx(1.0)
    assert not np.allclose(turned, turn, atol=0.1)
    assert browser.ask(COVERED) != before
    browser.click(left + 300.0, top + 200.0, times=2)
    assert np.allclose(browser.ask("solids.turn"), turn)
    assert browser.ask(COVERED) == before
    assert not [each for each in browser.named("Log.entryAdded") if each["entry"]["level"] == "error"]
    requests = [each["request"]["url"] for each in browser.named("Network.requestWillBeSent")]
    assert all(url.startswith(("file:", "data:", "blob:")) for url in requests)


def test_one_of_several_valves_is_made(command, tmp_path):
    """The valve of the second unit stands at 6 of the 20 mm of its helix; its page can be made anew."""
    folder = tmp_path / "swing"
    words = ["--part", "swing_unit", "--out", str(folder), "--fineness", "10", "--frames", "0", "--json"]
    told = json.loads(command("two-cylinders", *words).out)
    assert told["duty_ratio"] == pytest.approx(0.3)
    assert write_geometry_report(folder).exists()
