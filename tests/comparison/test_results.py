"""The result of a comparison of estimators, and its page."""

import csv
import re

import pytest

from vvdp.comparison.figures import error_key
from vvdp.comparison.result import comparison_result, screen_tables
from vvdp.comparison.trials import compare
from vvdp.report.result_page import write_result_report
from vvdp.results.store import read_result, table_text, write_result


@pytest.fixture
def found(known_contenders, short_scenarios):
    return compare(short_scenarios, known_contenders, 2)


def test_what_was_written_is_read(found, tmp_path):
    result = comparison_result(found)
    write_result(tmp_path, result, "")
    again = read_result(tmp_path)
    assert {name: table_text(each) for name, each in again.tables.items()} == {
        name: table_text(each) for name, each in result.tables.items()
    }
    assert again.charts == result.charts and again.numbers == result.numbers
    assert again.tables["traces"]["slow_speed_rad_s"].tolist() == found.traced.estimated["slow"].tolist()


def test_the_table_has_a_row_for_each_pair(found):
    text = table_text(comparison_result(found).tables["comparison"])
    rows = list(csv.DictReader(text.splitlines()))
    assert [(row["scenario"], row["estimator"]) for row in rows] == [
        ("constant", "slow"), ("constant", "fast"), ("step", "slow"), ("step", "fast"),
    ]  # fmt: skip
    for row in rows:
        for key, (value, error) in found.scores[row["scenario"], row["estimator"]].items():
            assert float(row[key] or "nan") == pytest.approx(value, nan_ok=True, abs=0.0)
            assert float(row[error_key(key)] or "nan") == pytest.approx(error, nan_ok=True, abs=0.0)
    assert rows[0]["settling_median_s"] == ""  # nothing to settle


def test_the_page_has_its_figures_and_is_the_same_again(found, tmp_path):
    write_result(tmp_path, comparison_result(found), "")
    text = write_result_report(tmp_path).read_text("utf-8")
    assert len(re.findall("<figure ", text)) == 5
    assert "always 100 rad/s" in text
    assert "http:" not in re.sub(r'"http://www.w3.org[^"]*"', "", text)
    before = {path.name: path.read_bytes() for path in tmp_path.rglob("*.*")}
    write_result_report(tmp_path)
    assert {path.name: path.read_bytes() for path in tmp_path.rglob("*.*")} == before
    assert {"speed-error.svg", "angle-error.svg", "speeds.svg", "delay.svg", "cost.svg"} <= set(before)


def test_the_least_error_is_named(found):
    """155.2 rad/s: 150 is off by 5.2, 100 by 55.2. Half of the time 68.7, then 150.8 rad/s: 150 is off by 81.3 and
    about 0, 57.5 as root mean square, and 100 by 31.3 and about 50.8, 42."""
    tables = comparison_result(found).tables
    assert tables["speed-1"]["constant_rad_s"] == pytest.approx([55.2, 5.2], abs=0.05)
    assert tables["speed-1"]["estimator"].tolist() == ["slow", "fast"]
    assert tables["least"]["least"].tolist() == ["fast", "slow"]


def test_without_a_step_there_is_no_delay(known_contenders, short_scenarios):
    found = compare(short_scenarios[:1], known_contenders, 1)
    result = comparison_result(found)
    assert "delay" not in result.charts and "cost" in result.charts
    (table,) = screen_tables(found, result).values()
    assert "delay_s" not in table.shown and table.rows == 2


@pytest.mark.parametrize(
    ("key", "expected"),
    [("speed_error_rms_rad_s", "speed_error_rms_se_rad_s"), ("angle_error_95_rad", "angle_error_95_se_rad"),
     ("delay_s", "delay_se_s"), ("nis", "nis_se")],
)  # fmt: skip
def test_a_standard_error_keeps_the_unit_at_the_end(key, expected):
    assert error_key(key) == expected
