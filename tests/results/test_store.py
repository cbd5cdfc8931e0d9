"""What is written of a result comes back as it was."""

import json
from dataclasses import replace

import numpy as np
import pytest
from tests.words import wording

from vvdp.base.errors import ConfigError
from vvdp.base.files import list_all
from vvdp.base.kinds import COUNT, FLAG, FLOW, GAUGE_PRESSURE, MEAN_POWER, PRESSURE_LEVEL, Kind
from vvdp.results.chart import Bars, Chart, Colour, Field, Level, Line, Lines, Stroke
from vvdp.results.result import Column, Finding, Grade, Listing, Number, Result, Row, Section, Table
from vvdp.results.store import read_meta, read_result, table_text, write_result

OWN = Kind("viscous torque gain", "N*m*s", 0.0, 1.0, "0.1 N*m*s")
COLUMNS = {
    "load_pressure_Pa": Column(np.array([1e5 / 3.0, np.nan, -2e7]), GAUGE_PRESSURE, "load"),
    "flow_m3_s": Column(np.array([1e-4, 5e-324, -0.0]), FLOW, "flow", "Q"),
    "gain_N_m_s": Column(np.array([1.0, 2.0, 3.0]), OWN, "gain"),
    "remark": Column(np.array(["", 'a "quoted", word', "two\nlines"]), None, "remark"),
}
LINES = Lines(
    lines=(Line(x="flow_m3_s", y="load_pressure_Pa", rows=(0, 2), stroke=Stroke.MARKED, colour=Colour.LOAD),),
    levels=(Level(value=1e5, label="one bar", upright=True),),
    low=0.0,
    y_log=True,
)
RESULT = Result(
    verb="map",
    title="A <map>",
    system="prototype",
    manner="By hand.",
    references=("iso4409",),
    conditions={"fluid": "oil"},
    left_out=("hoses",),
    numbers={"points": Number(3.0, COUNT, "points"), "loss_W": Number(np.nan, MEAN_POWER, "loss"),
             "settled": Number(1.0, FLAG, "settled")},
    listings={"key": Listing(title="Key", heads=("a", "b"), rows=(Row("p", PRESSURE_LEVEL, (2e5, None)),
                                                                  Row("word", None, ("x", None), group="g")))},
    tables={"map": Table(title="Points", columns=COLUMNS, axes=("flow_m3_s",))},
    charts={
        "flow": Chart(name="flow", caption="Flow.", table="map", panels=(LINES,)),
        "mixed": Chart(name="mixed", caption="Both.", table="map", side_by_side=True,
                       panels=(Bars(names="remark", values=("flow_m3_s",)),
                               Field(x="flow_m3_s", y="gain_N_m_s", z="load_pressure_Pa", steps=(0.0, 1.0)))),
    },
    findings=(Finding(text="It works."), Finding(text="It may not.", grade=Grade.WARNING, title="T", remedy="Do.")),
    sections=(Section(title="All", words=("one", "two"), shows=("flow", "map")),),
    seconds=1.5,
    finished=False,
)  # fmt: skip


def test_a_result_comes_back_to_the_last_bit(tmp_path):
    write_result(tmp_path, RESULT, "[run]\n", ["vvdp", "map", "prototype"])
    back = read_result(tmp_path)
    for key, column in RESULT.tables["map"].columns.items():
        other = back.tables["map"].columns[key]
        assert (other.kind, other.label, other.symbol) == (column.kind, column.label, column.symbol)
        if column.kind is None:
            assert other.values.tolist() == column.values.tolist()
        else:
            assert other.values.tobytes() == column.values.tobytes()
    assert back.charts == RESULT.charts
    assert back.listings == RESULT.listings
    assert back.findings == RESULT.findings
    assert np.isnan(back.numbers["loss_W"].value)
    assert replace(back, tables={}, charts={}, numbers={}) == replace(RESULT, tables={}, charts={}, numbers={})
    assert read_meta(tmp_path)["command"] == ["vvdp", "map", "prototype"]


def test_the_table_is_plain_csv_with_units_and_gauge_marked():
    head, first, *_ = table_text(RESULT.tables["map"]).splitlines()
    assert head == "load_pressure_Pa [gauge],flow_m3_s,gain_N_m_s,remark"
    assert first == "33333.333333333336,0.0001,1.0,"


def test_a_key_that_contradicts_its_kind_is_refused():
    with pytest.raises(ValueError, match="has to end with '_m3_s'"):
        Table(title="", columns={"flow": Column(np.zeros(1), FLOW, "flow")})
    with pytest.raises(ValueError, match="has to end with '_W'"):
        replace(RESULT, numbers={"loss": Number(1.0, MEAN_POWER, "loss")})


def test_a_chart_of_a_table_that_is_not_there_is_refused():
    with pytest.raises(ValueError, match="draws the table 'map'"):
        replace(RESULT, tables={})


def test_flat_has_whole_counts_true_flags_and_warnings_as_a_list():
    flat = RESULT.flat
    assert flat["points"] == 3
    assert isinstance(flat["points"], int)
    assert flat["settled"] is True
    assert flat["warnings"] == ["It may not."]
    assert flat["flow_m3_s"][0] == 1e-4


@pytest.mark.parametrize("damage", ["[]", "{}", '{"format": 1}', "no json"])
def test_a_damaged_result_is_refused_by_name(tmp_path, damage):
    write_result(tmp_path, RESULT, "")
    (tmp_path / "result.json").write_text(damage)
    with pytest.raises(ConfigError, match="result.json: " + wording.directories.has_changed):
        read_result(tmp_path)
    list_all(tmp_path)
    with pytest.raises(
        ConfigError, match=f"{wording.files.is_damaged}|{wording.study.written_in_format.format(format=None)}"
    ):
        read_result(tmp_path)


def test_a_table_that_was_cut_off_is_refused(tmp_path):
    write_result(tmp_path, RESULT, "")
    text = (tmp_path / "map.csv").read_text()
    (tmp_path / "map.csv").write_text(text.replace("33333.333333333336", "3333x"))
    with pytest.raises(ConfigError, match="map.csv: " + wording.directories.has_changed):
        read_result(tmp_path)
    list_all(tmp_path)
    with pytest.raises(ConfigError, match="is damaged"):
        read_result(tmp_path)


def test_another_format_is_named(tmp_path):
    write_result(tmp_path, RESULT, "")
    content = json.loads((tmp_path / "result.json").read_text())
    (tmp_path / "result.json").write_text(json.dumps(content | {"format": 99}))
    list_all(tmp_path)
    with pytest.raises(ConfigError, match=wording.study.written_in_format.format(format=99)):
        read_result(tmp_path)
