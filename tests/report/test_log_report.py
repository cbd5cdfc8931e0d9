"""The report of an estimation is whole, stands alone, and is the same each time."""

import re
import shutil
import xml.etree.ElementTree as ET

import numpy as np
import pytest
from tests.words import wording

from vvdp.base.errors import ConfigError
from vvdp.base.files import write_listed
from vvdp.offline.config import Option, load_estimation
from vvdp.offline.estimate import estimate, open_for_estimate
from vvdp.offline.wheel_charts import enlargement
from vvdp.report.result_page import write_result_report
from vvdp.results.store import read_result, write_result

SPEED = 2.0 * np.pi * 24.7


@pytest.fixture(scope="module")
def measured(tmp_path_factory):
    """A result directory of an estimation with everything: wave, pressure, smoother."""
    folder = tmp_path_factory.mktemp("measured")
    t = np.arange(0.0, 2.0, 2e-4)
    angle = 0.3 + SPEED * t
    rng = np.random.default_rng(0)
    wave = 0.4 + 3.0 * np.clip(0.5 + 1.6 * np.sin(4.0 * angle), 0.0, 1.0) + rng.normal(0.0, 0.02, t.size)
    inlet = np.clip(50.0 + 300.0 * np.sin(3.0 * angle), 5.0, 100.0)
    path = folder / "bench <b>.csv"
    np.savetxt(path, np.column_stack([t, wave, inlet]), delimiter=",", fmt="%.7g", comments="",
               header="time [s],photodiode [V],inlet [bar]")  # fmt: skip
    options = {"sensor.wave": "photodiode", "pressure.channel": "inlet", "output.smooth": True}
    wanted = load_estimation(None, [Option(key, key, value) for key, value in options.items()])
    (folder / "run").mkdir()
    with open_for_estimate(path, wanted) as log:
        estimate(log, wanted, folder / "run", more={"written": "2026-01-02T03:04:05+0000"})
    return folder / "run"


@pytest.fixture
def directory(measured, tmp_path):
    return shutil.copytree(measured, tmp_path / "run")


@pytest.fixture(scope="module")
def written(measured, tmp_path_factory):
    """The same with its report; not to be written to."""
    directory = shutil.copytree(measured, tmp_path_factory.mktemp("written") / "run")
    write_result_report(directory)
    return directory


def test_the_page_stands_alone_with_every_figure(written):
    directory, page = written, (written / "report.html").read_text("utf-8")
    for name in ("wave", "speed", "speed-detail", "innovations", "wheel", "pressure", "pressure-angle"):
        ET.parse(directory / "figures" / f"{name}.svg")
        assert f'id="figure-{name}"' in page
    # pictures inside of an SVG are data, nothing is fetched
    assert not re.search(r"url\((?!#)|@import|<iframe|<link", page)
    assert all(target.startswith(("#", "data:")) for target in re.findall(r'(?:src|href)="([^"]*)"', page))
    identifiers = re.findall(r'\bid="([^"]+)"', page)
    assert len(identifiers) == len(set(identifiers))
    assert not list(directory.rglob("*.tmp"))


def test_it_tells_numbers_findings_and_settings(written):
    page = (written / "report.html").read_text("utf-8")
    said = re.sub(r"<[^>]*>", "", page.partition("<body>")[2])
    assert "1482" in said and wording.report.frequency_of.format(frequency="74.1 Hz") in said and "2026-01-02" in said
    assert wording.report.filter_settings in said and wording.report.speed_deviation in said
    assert "threshold [V]" in said and "rad/s" not in said.partition("Settings")[0]
    assert "wave = &quot;photodiode&quot;" in said
    assert "bench &lt;b&gt;.csv" in said and "<b>.csv" not in page


def test_made_again_it_has_the_same_bytes_and_stale_figures_go(written, directory):
    with write_listed(directory, ["figures/old.svg"], pages=True):
        (directory / "figures" / "old.svg").write_text("<svg/>")
    write_result_report(directory)
    one, two = ({path.name: path.read_bytes() for path in place.rglob("*") if path.is_file()}
                for place in (written, directory))  # fmt: skip
    assert one == two


def test_the_result_comes_back_from_its_files(written, tmp_path):
    result = read_result(written)
    write_result(tmp_path, result, "")
    for name in ("result.json", *(f"{name}.csv" for name in result.tables)):
        assert (tmp_path / name).read_bytes() == (written / name).read_bytes()
    assert result.numbers["sectors"].value == 8.0 and result.seconds > 0.0 and result.finished


def test_tables_hold_what_the_figures_draw(written):
    tables = read_result(written).tables
    # Edges of the wave lie on its threshold, half of them rising; the fold goes from 5 to 100 bar, gauge.
    edges = tables["wave-edges"]
    assert np.count_nonzero(edges["rising"] > 0.0) == np.count_nonzero(edges["falling"] > 0.0) == 12
    assert edges["threshold"] == pytest.approx(1.9, abs=0.02)
    fold = tables["pressure-fold"]
    assert np.nanmin(fold["pressure_low_Pa"]) == pytest.approx(601325.0)
    assert np.nanmax(fold["pressure_high_Pa"]) == pytest.approx(10101325.0)
    # A normal variable is beyond two deviations in 4.55 % of all cases.
    squares = tables["innovation-squares"]
    by_chance = squares["expected_density"][:-1] * np.diff(squares["square"])
    assert np.sum(by_chance) == pytest.approx(1.0)
    assert np.sum(by_chance[squares["square"][:-1] > 3.99]) == pytest.approx(0.0455, abs=1e-4)
    # 24.7 turns a second: a band of two deviations about that, and edges that say the same one by one.
    course, alone = tables["speed-course"], tables["speed-sectors"]
    late = course["time_s"] > 0.5
    assert course["speed_rad_s"][late] == pytest.approx(SPEED, rel=1e-3)
    within = (course["speed_low_rad_s"] < SPEED) & (course["speed_high_rad_s"] > SPEED)
    assert np.mean(within[late]) > 0.9545
    assert np.mean(alone["speed_rad_s"]) == pytest.approx(SPEED, rel=1e-3)


@pytest.mark.thorough
def test_a_long_record_is_thinned_and_its_page_stays_small(tmp_path):
    path = tmp_path / "long.csv"
    jitter = np.random.default_rng(3).normal(0.0, 0.05, 40_000)
    path.write_text(
        "edge [s]\n" + "\n".join(f"{x:.7f}" for x in (np.arange(40_000) * np.pi / 4 + jitter) / SPEED) + "\n"
    )
    wanted = load_estimation(None, [Option("sensor.edges", "--edges", "edge")])
    (tmp_path / "run").mkdir()
    with open_for_estimate(path, wanted) as log:
        result = estimate(log, wanted, tmp_path / "run")
    assert result.numbers["output_rate_Hz"].value * result.numbers["duration_s"].value > 200_000
    assert all(table.rows <= 3001 for table in result.tables.values())
    assert result.tables["speed-course"]["time_s"][-1] == pytest.approx(result.numbers["duration_s"].value, abs=0.2)
    assert write_result_report(tmp_path / "run").stat().st_size < 1_000_000


def test_small_offsets_are_not_blown_up():
    # A quarter of a sector of 8 is 0.196 rad: 0.1 rad twice as large, 3 mrad no more than ten times.
    assert enlargement(np.array([0.1, -0.05]), 8) == pytest.approx(0.25 * np.pi / 4.0 / 0.1)
    assert enlargement(np.array([3e-3]), 8) == 10.0
    assert enlargement(np.empty(0), 8) == 1.0


def test_the_captions_say_what_is_left_out_or_put_together(written):
    page = (written / "report.html").read_text("utf-8")
    assert wording.report.left_out_errors in page and wording.report.last_step.format(offset=7.8) in page


def test_what_is_no_estimation_is_refused(tmp_path):
    with pytest.raises(ConfigError, match=wording.files.holds_no_result):
        write_result_report(tmp_path)
    with pytest.raises(ConfigError, match=wording.files.no_directory):
        write_result_report(tmp_path / "none")


def test_a_short_record_of_stamps_still_gives_a_report(tmp_path):
    path = tmp_path / "few.csv"
    path.write_text("edge [s]\n" + "\n".join(f"{0.1 + 0.005 * k:.4f}" for k in range(5)) + "\n")
    wanted = load_estimation(None, [Option("sensor.edges", "--edges", "edge")])
    (tmp_path / "run").mkdir()
    with open_for_estimate(path, wanted) as log:
        estimate(log, wanted, tmp_path / "run")
    page = write_result_report(tmp_path / "run").read_text("utf-8")
    assert wording.report.too_short in page and wording.report.filter_not_settled in page
    assert not (tmp_path / "run" / "figures" / "wave.svg").exists()
