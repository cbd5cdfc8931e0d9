"""A comparison on disk, and its page."""

import csv
import json
import math
import re

import pytest

from vvdp.base.errors import ConfigError
from vvdp.comparison.results import read_comparison, write_comparison
from vvdp.comparison.trials import compare
from vvdp.report.comparison import size, write_comparison_report
from vvdp.report.comparison_figures import comparison_figures

ROW = r'<tr><td class="u">(.*?)</td>(.*?)</tr>'


@pytest.fixture
def comparison_directory(known_contenders, short_scenarios, tmp_path):
    write_comparison(tmp_path, compare(short_scenarios, known_contenders, 2))
    return tmp_path


def test_what_was_written_is_read(known_contenders, short_scenarios, tmp_path):
    found = compare(short_scenarios, known_contenders, 2)
    write_comparison(tmp_path, found)
    again = read_comparison(tmp_path)
    assert again.content == found.content
    assert again.traced.estimated["slow"] == pytest.approx(found.traced.estimated["slow"])
    assert math.isnan(again.scores["constant", "slow"]["settling_median_s"].value)


def test_the_table_has_a_row_for_each_pair(comparison_directory):
    rows = list(csv.DictReader((comparison_directory / "comparison.csv").open()))
    assert [(row["scenario"], row["estimator"]) for row in rows] == [
        ("constant", "slow"), ("constant", "fast"), ("step", "slow"), ("step", "fast"),
    ]  # fmt: skip
    content = json.loads((comparison_directory / "comparison.json").read_text())
    assert float(rows[0]["speed_error_rms_rad_s"]) == content["scores"][0]["speed_error_rms_rad_s"]


def test_the_page_has_its_figures_and_is_the_same_again(comparison_directory):
    page = write_comparison_report(comparison_directory)
    text = page.read_text("utf-8")
    assert len(re.findall("<figure ", text)) == 4
    assert "constant" in text and "always 100 rad/s" in text
    assert "<script" not in text and "http" not in re.sub(r'"http://www.w3.org[^"]*"', "", text)
    before = {path.name: path.read_bytes() for path in comparison_directory.rglob("*.*")}
    write_comparison_report(comparison_directory)
    assert {path.name: path.read_bytes() for path in comparison_directory.rglob("*.*")} == before
    assert {"speed-error.png", "angle-error.svg", "traces.png", "delay-and-cost.svg"} <= set(before)


def test_the_least_error_is_bold(comparison_directory):
    """155.2 rad/s: 150 is off by 5.2, 100 by 55.2. Half of the time 68.7, then 150.8 rad/s: 150 is off by 81.3 and
    about 0, 57.5 as root mean square, and 100 by 31.3 and about 50.8, 42."""
    text = write_comparison_report(comparison_directory).read_text("utf-8")
    table = text.partition("<h2>Error of the speed</h2>")[2].partition("</table>")[0]
    rows = {name: re.findall(r'<td class="n">(.*?)</td>', cells) for name, cells in re.findall(ROW, table)}
    assert rows["slow"][0] == "55" and rows["fast"][0] == "<b>5.2</b>"
    assert "<b>" in rows["slow"][1] and "<b>" not in rows["fast"][1]


def test_without_a_step_there_is_no_delay(known_contenders, short_scenarios):
    drawn = {each.name: each.caption for each in comparison_figures(compare(short_scenarios[:1], known_contenders, 1))}
    assert "Delay" not in drawn["delay-and-cost"]


@pytest.mark.parametrize(("value", "shown"), [(0.0, "0"), (3e-9, "< 10⁻⁶"), (-3e-9, "< 10⁻⁶"), (0.0854, "0.0854")])
def test_rounding_errors_are_not_shown(value, shown):
    assert size(value) == shown
    assert size(math.inf) == "–"


def test_other_folders_are_refused(comparison_directory, tmp_path):
    with pytest.raises(ConfigError, match=r"comparison.json missing"):
        read_comparison(tmp_path / "nowhere")
    path = comparison_directory / "comparison.json"
    path.write_text(path.read_text().replace('"format": 1', '"format": 99'))
    with pytest.raises(ConfigError, match="format 99"):
        read_comparison(comparison_directory)
    path.write_text("{}")
    with pytest.raises(ConfigError, match="damaged"):
        read_comparison(comparison_directory)
