"""What a run writes, that it goes on past a failure, and when it says that a verdict has changed."""

import csv
import io
import json
from dataclasses import replace

import numpy as np
import pytest

from vvdp.base.kinds import PRESSURE_DIFFERENCE, TIME
from vvdp.base.manifest import open_directory
from vvdp.cli.main import main
from vvdp.cli.reproduce import usual_seconds
from vvdp.reproduction import items as known
from vvdp.reproduction.expectation import expectation_text, expected_rows, verdict_changes
from vvdp.reproduction.item import Item, ItemKind, Reproduction
from vvdp.reproduction.kept import _read_statements
from vvdp.reproduction.result import verdict_result
from vvdp.reproduction.runner import reproduce
from vvdp.results.chart import Chart, Line, Lines
from vvdp.results.result import Column, Grade, Table
from vvdp.results.store import read_result
from vvdp.results.verdict import number_statement


def drawn():
    time = np.array([0.0, 1.0])
    columns = {"time_s": Column(time, TIME, "time"), "drop_Pa": Column(1e5 * time, PRESSURE_DIFFERENCE, "drop")}
    chart = Chart(
        name="figure-9.1",
        caption="A line.",
        table="drops",
        panels=(Lines(lines=(Line(x="time_s", y="drop_Pa"),)),),
    )
    statement = number_statement("drop", 1e5, 1.01e5, PRESSURE_DIFFERENCE, share=0.02, because="digits")
    return Reproduction(
        statements=(statement,), tables={"drops": Table(title="Drops", columns=columns)}, charts=(chart,)
    )


def fails():
    raise ZeroDivisionError("nothing to divide by")


GOOD = Item(ItemKind.FIGURE, "9.1", "A line", drawn)
BAD = Item(ItemKind.SECTION, "9.2", "A failure", fails)


def test_an_item_writes_picture_and_data_and_the_next_follows_a_failure(tmp_path):
    heard = []
    failed, done = reproduce([BAD, GOOD], tmp_path, heard.append)
    assert failed.failure == "ZeroDivisionError: nothing to divide by" and not done.failure
    assert heard == ["1 of 2: section-9.2, A failure", "2 of 2: figure-9.1, A line"]
    folder = tmp_path / "figure-9.1"
    assert (folder / "figure-9.1.svg").read_bytes().startswith(b"<?xml")
    assert (folder / "figure-9.1.png").read_bytes().startswith(b"\x89PNG")
    result = read_result(folder)
    assert result.tables["drops"]["drop_Pa"].tolist() == [0.0, 1e5]
    assert result.tables["verdicts"]["verdict"].tolist() == ["reproduced"]


def test_a_stopped_run_names_the_items_that_it_lacks(tmp_path):
    outcomes = list(reproduce([GOOD], tmp_path))
    whole, stopped = (verdict_result(outcomes, [], 1.0, missing) for missing in ([], ["figure-9.3", "section-9.4"]))
    assert whole.finished and [each.title for each in whole.findings] == ["", ""]
    first = stopped.findings[0]
    assert not stopped.finished and first.grade is Grade.BAD
    assert (first.title, first.text) == ("Stopped", "2 items missing: figure-9.3, section-9.4.")


def test_ctrl_c_reports_what_is_missing_and_exits_with_130(capsys, tmp_path, monkeypatch):
    def stopped():
        raise KeyboardInterrupt

    chosen = (GOOD, Item(ItemKind.SECTION, "9.2", "Stopped here", stopped), GOOD)
    monkeypatch.setattr(known, "chosen_items", lambda names: chosen)
    with pytest.raises(SystemExit) as ended:
        main(["reproduce", "all", "--json", "--no-report", "--out", str(tmp_path / "out")])
    shown = json.loads(capsys.readouterr().out)
    assert ended.value.code == 130
    assert shown["finished"] is False and shown["missing"] == ["section-9.2", "figure-9.1"]


def test_a_stopped_run_goes_on_where_it_stopped(capsys, tmp_path, monkeypatch):
    worked = []

    def counted():
        worked.append("figure-9.1")
        return drawn()

    def stopped():
        raise KeyboardInterrupt

    first, second = (Item(ItemKind.FIGURE, number, "A line", counted) for number in ("9.1", "9.3"))
    out = tmp_path / "out"
    for place, work in enumerate((stopped, drawn)):
        chosen = (first, Item(ItemKind.SECTION, "9.2", "Stopped once", work), second)
        monkeypatch.setattr(known, "chosen_items", lambda names, chosen=chosen: chosen)
        with pytest.raises(SystemExit):
            main(["reproduce", "all", "--json", "--no-report", "--out", str(out)])
        shown = json.loads(capsys.readouterr().out)
        assert shown["finished"] is bool(place)
    assert len(worked) == 2
    assert [each["item"] for each in shown["items"]] == ["figure-9.1", "section-9.2", "figure-9.3"]
    assert shown["items"][0] | {"item": ""} == shown["items"][2] | {"item": ""}
    assert (out / "figure-9.1" / "figure-9.1.svg").is_file()


def test_statements_are_read_as_they_were_written(tmp_path):
    each = number_statement("drop", 1e5, float("nan"), PRESSURE_DIFFERENCE, other=float("inf"), share=0.02, because="x")
    pair = replace(each, contradiction=("2.6: 1 bar", "2.7: 2 bar"), found=2e5)
    item = replace(GOOD, work=lambda: Reproduction(statements=(each, pair)))
    tuple(reproduce([item], tmp_path))
    found = _read_statements(open_directory(tmp_path / "figure-9.1"))
    assert repr(found) == repr((each, pair)) and found[1] == pair


def test_changes_are_those_of_the_items_that_were_worked_out():
    expected = {("figure-9.1", "drop"): "reproduced", ("figure-9.2", "drop"): "reproduced"}
    assert verdict_changes({("figure-9.1", "drop"): "reproduced"}, expected, ["figure-9.1"]) == []
    found = {("figure-9.1", "drop"): "not reproduced", ("figure-9.1", "other"): "reproduced"}
    assert verdict_changes(found, expected, ["figure-9.1"]) == [
        "figure-9.1, drop: not reproduced; expected reproduced",
        "figure-9.1, other: reproduced; expected no such statement",
    ]
    assert len(verdict_changes({}, expected, ["figure-9.1"])) == 1


def test_the_expectation_is_written_as_it_is_read():
    expected = expected_rows()
    written = csv.DictReader(io.StringIO(expectation_text(expected)))
    assert {(row["item"], row["what"]): (row["verdict"], row["evidence"], row["width"]) for row in written} == expected


def test_list_as_json(capsys):
    with pytest.raises(SystemExit):
        main(["reproduce", "--list", "--json"])
    items = json.loads(capsys.readouterr().out)["items"]
    assert [each["item"] for each in items] == [item.name for item in known.ITEMS]


def test_a_verdict_that_is_expected_exits_with_0_and_another_with_1(capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for out, code in (("as-expected", 0), ("changed", 1)):
        with pytest.raises(SystemExit) as ended:
            main(["reproduce", "equation-3.4", "--json", "--no-report", "--out", out])
        assert ended.value.code == code
        shown = json.loads(capsys.readouterr().out)
        first = shown["items"][0]
        assert {"item", "source_value", "vvdp_value", "tolerance", "verdict"} <= {*first}
        assert first["source_value"] == pytest.approx(first["vvdp_value"], abs=first["tolerance"])
        assert bool(shown["changed"]) is bool(code)
        monkeypatch.setattr("vvdp.reproduction.expectation.expected_verdicts", dict)


def test_the_report_is_named_where_it_was_written(capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SystemExit):
        main(["reproduce", "equation-3.4", "--out", "found"])
    assert "results: found\nreport: found/report.html\n" in capsys.readouterr().out
    assert (tmp_path / "found" / "report.html").exists()


def test_the_usual_time_is_the_sum_of_what_was_timed_and_a_second_for_what_was_not():
    first, *_ = known.ITEMS
    new = replace(first, number="9.99")
    assert usual_seconds([first, new]) == pytest.approx(usual_seconds([first]) + 1.0)
    assert usual_seconds(known.ITEMS) > 60.0  # worth saying before
