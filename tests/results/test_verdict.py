"""The verdict follows from the numbers, and from what is known of the text."""

import pytest

from vvdp.base.kinds import FREQUENCY, GAUGE_PRESSURE, PRESSURE_DIFFERENCE, TEMPERATURE
from vvdp.results.verdict import (
    Verdict,
    bound_statement,
    drawing_statement,
    missing_statement,
    number_statement,
    verdict_table,
)


@pytest.mark.parametrize(
    ("found", "more", "verdict"),
    [
        (6.74e5, {}, Verdict.REPRODUCED),
        (6.75e5, {}, Verdict.NOT_REPRODUCED),
        (6.75e5, {"contradiction": ("2.6: 6.61 bar", "(2.3) to (2.5): 6.75 bar")}, Verdict.INCONSISTENT),
        (6.74e5, {"contradiction": ("2.6: 6.61 bar", "(2.3) to (2.5): 6.74 bar")}, Verdict.REPRODUCED),
        (6.75e5, {"inconsistency": "its parts make 6.75 bar"}, Verdict.NOT_REPRODUCED),
        (6.74e5, {"assumption": "a clearance of 22.5 um", "other": 9.0e5}, Verdict.UNDETERMINED),
        (9.0e5, {"assumption": "a clearance of 12.7 um", "other": 6.74e5}, Verdict.UNDETERMINED),
        (6.74e5, {"assumption": "a clearance of 22.5 um", "other": 6.73e5}, Verdict.REPRODUCED),
        (9.0e5, {"assumption": "a clearance of 12.7 um", "other": 9.1e5}, Verdict.NOT_REPRODUCED),
        (6.74e5, {"calibration": "the arm of the jets"}, Verdict.CALIBRATED),
        (6.75e5, {"calibration": "the arm of the jets"}, Verdict.NOT_REPRODUCED),
        (9.0e5, {"assumption": "a clearance of 22.5 um"}, Verdict.NOT_REPRODUCED),
    ],
)
def test_number_of_6_61_bar_within_2_per_cent(found, more, verdict):
    """0.02 x 6.61 = 0.1322 bar."""
    statement = number_statement("drop", 6.61e5, found, PRESSURE_DIFFERENCE, share=0.02, because="digits", **more)
    assert statement.verdict is verdict
    assert statement.tolerance_text == "2 %"
    assert statement.source_text == "6.61 bar"


def test_a_band_and_its_ends():
    for found, verdict in ((70.4, Verdict.REPRODUCED), (82.5, Verdict.REPRODUCED), (83.1, Verdict.NOT_REPRODUCED)):
        each = bound_statement("frequency", found, FREQUENCY, low=70.4, high=82.0, tolerance=1.0)
        assert each.verdict is verdict
        assert each.source_text == "70.4 to 82 Hz"
        assert each.tolerance_text == "1 Hz"
    assert bound_statement("frequency", 1.0, FREQUENCY, high=2.0).source_text == "at most 2 Hz"
    assert bound_statement("frequency", 1.0, FREQUENCY, low=2.0).verdict is Verdict.NOT_REPRODUCED


def test_what_was_not_found_never_holds():
    assert missing_statement("grid", "995 983 cells", "no stored table").verdict is Verdict.NOT_REPRODUCED
    assert number_statement("drop", 1.0, float("nan"), tolerance=1e9).verdict is Verdict.NOT_REPRODUCED
    assert drawing_statement("circuit", "drawn from the model").verdict is Verdict.DRAWING


def test_a_tolerance_has_no_datum():
    """2 K is 2 of the degrees in which a temperature is shown, and 1 bar one of those of a gauge pressure."""
    warm = bound_statement("oil", 313.15, TEMPERATURE, low=310.0, high=312.0, tolerance=2.0)
    assert warm.tolerance_text == "2 °C" and warm.holds
    assert bound_statement("load", 1e7, GAUGE_PRESSURE, low=0.0, high=1e7, tolerance=1e5).tolerance_text == "1 bar"


def test_the_table_has_a_line_for_each_and_no_empty_verdict():
    each = drawing_statement("circuit", "drawn from the model")
    table = verdict_table([("figure-1.1", each), ("figure-1.4", each)])
    assert table["item"].tolist() == ["figure-1.1", "figure-1.4"]
    assert table["verdict"].tolist() == ["drawing, nothing to reproduce"] * 2
