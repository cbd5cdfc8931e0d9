"""Every row states its kind and the arithmetic of its tolerance, and a number that is moved fails."""

import random
from dataclasses import replace

import pytest

from vvdp.reproduction.expectation import expected_rows
from vvdp.reproduction.items import ITEMS, chosen_items
from vvdp.results.verdict import Evidence, Verdict

CHEAP = ("equation-2.3", "equation-2.4", "equation-2.5", "equation-2.6", "equation-2.7", "equation-2.9", "table-2.1")
CHEAP += ("figure-2.11", "section-2.3", "section-2.7", "section-2.8", "equation-3.4", "section-3.3", "section-3.5")
CHEAP += ("equation-4.6", "equation-4.9", "equation-5.14", "equation-5.31", "equation-6.12", "equation-6.19")
BROKEN, SEED = 20, 39


def test_every_row_states_its_kind():
    kinds = {each.value for each in Evidence}
    assert {key: row.evidence for key, row in expected_rows().items() if row.evidence not in kinds} == {}


def test_every_row_names_its_place_in_the_source():
    """The item is the place: a figure, a table, an equation or a section of the source."""
    assert {item for item, _ in expected_rows()} == {item.name for item in ITEMS}


def test_every_width_is_arithmetic(width_of):
    assert all(width_of(row.width) > 0.0 for row in expected_rows().values() if row.width)


def test_what_is_calibrated_is_no_evidence():
    for row in expected_rows().values():
        assert (row.verdict == Verdict.CALIBRATED) <= (row.evidence == Evidence.CALIBRATED)
        assert (row.evidence == Evidence.CALIBRATED) <= (row.verdict != Verdict.REPRODUCED)


@pytest.fixture(scope="module")
def reproduced():
    """Rows of quick items that are reproduced within a tolerance."""
    rows = [each for item in chosen_items(CHEAP) for each in item.work().statements]
    return [each for each in rows if each.verdict is Verdict.REPRODUCED and each.tolerance]


def test_a_number_that_is_moved_by_three_tolerances_is_not_reproduced(reproduced):
    chosen = random.Random(SEED).sample(reproduced, BROKEN)
    for each in chosen:
        moved = replace(each, found=each.found + 3.0 * each.tolerance, note="a remark", inconsistency="another")
        assert moved.verdict is Verdict.NOT_REPRODUCED, each.what


def test_no_remark_changes_a_verdict(reproduced):
    for each in reproduced:
        moved = replace(each, found=each.found + 3.0 * each.tolerance)
        assert replace(moved, assumption="any", inconsistency="any", note="any").verdict is moved.verdict
