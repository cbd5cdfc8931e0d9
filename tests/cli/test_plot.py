"""`vvdp plot`."""

import json
import xml.etree.ElementTree as ET

import numpy as np
import pytest
from tests.words import wording

from vvdp.report.chosen import chosen_chart, open_drawable


def test_names_are_listed(vvdp, here, two_runs, keys_as_described):
    answer = vvdp("plot", str(two_runs[0]))
    assert answer.code == 0, answer.err
    assert "cycle-time" in answer.out and "load_pressure" in answer.out and "states.spool.speed" in answer.out
    listed = json.loads(vvdp("plot", str(two_runs[0]), "--list", "--json").out)
    assert {"run", "spectrum"} <= set(listed["charts"]) and "outputs.pump_flow" in listed["series"]
    drawn = json.loads(vvdp("plot", str(two_runs[0]), "run", "--json").out)
    keys_as_described("plot", listed, drawn)
    assert [path.name for path in here.iterdir()] == ["run.png"]


@pytest.mark.parametrize(
    ("ending", "begins"), [("png", b"\x89PNG"), ("svg", b"<?xml"), ("pdf", b"%PDF"), ("PNG", b"\x89PNG")]
)
def test_the_ending_is_the_form_and_the_bytes_come_again(vvdp, here, two_runs, ending, begins):
    words = ("plot", str(two_runs[0]), "load_pressure", "--out")
    answer = vvdp(*words, f"one.{ending}")
    assert answer.code == 0 and answer.out.strip() == f"one.{ending}", answer.err
    assert vvdp(*words, f"two.{ending}").code == 0
    one, two = ((here / f"{name}.{ending}").read_bytes() for name in ("one", "two"))
    assert one.startswith(begins) and one == two
    if ending == "svg":
        assert ET.fromstring(one).tag.endswith("svg")


def test_several_names_share_one_axis(two_runs):
    result = open_drawable(two_runs[0])
    chart = chosen_chart(result, ["run", "spool_speed", "states.load_line"], (0.05, None))
    assert [panel.lines[0].x for panel in chart.panels] == ["time_s"] * len(chart.panels)
    last = float(result.tables["series"]["time_s"][-1])
    assert {(panel.left, panel.right) for panel in chart.panels} == {(0.05, last)}
    assert [panel.lines[0].y for panel in chart.panels[-2:]] == ["spool_speed_rad_s", "states.load_line_Pa"]
    drawn, recorded = (result.tables[panel.table] for panel in chart.panels[-2:])
    assert np.array_equal(drawn["spool_speed_rad_s"], recorded["states.spool.speed_rad_s"])
    assert chosen_chart(result, ["run"]) == result.charts["run"]
    assert chosen_chart(result, ["states.load_line_Pa"]).panels[0].lines == chart.panels[-1].lines


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["load_presure"], "plot: load_presure: " + wording.plot.unknown_name.format(meant="load_pressure")),
        (["zzz"], wording.plot.list_shows_names),
        (["run", "losses-cause"], wording.plot.no_common_axis),
        (["run", "--out", "a.gif"], wording.plot.picture_name),
        (["load_pressure", "--from", "900 s"], "plot: 900 s to "),
        (["load_pressure", "--from", "900 s", "--to", "901 s"], wording.plot.span_of_result),
        (["run", "--from", "3"], "--from: '3' " + wording.files.has_no_unit),
        (["run", "--out", "missing/a.png"], "missing/a.png: " + wording.files.cannot_write),
    ],
)
def test_what_cannot_be_drawn_is_refused(vvdp, here, two_runs, words, told):
    answer = vvdp("plot", str(two_runs[0]), *words)
    assert answer.code in (1, 2) and told in answer.err
    assert list(here.iterdir()) == []


def test_nothing_is_replaced_without_force(vvdp, here, two_runs):
    (here / "run.png").write_text("mine")
    refused = vvdp("plot", str(two_runs[0]), "run")
    assert refused.code == 2 and wording.files.already_exists in refused.err
    assert (here / "run.png").read_text() == "mine"
    assert vvdp("plot", str(two_runs[0]), "run", "--force").code == 0
    assert (here / "run.png").read_bytes().startswith(b"\x89PNG")
    assert vvdp("plot", "nowhere", "run").code == 2
