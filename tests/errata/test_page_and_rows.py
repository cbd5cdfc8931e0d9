"""Errata and rows of the reproduction are linked in one table: neither changes its claim without the other.

`docs/errata-rows.csv` has, for each row of `vvdp reproduce` that bears on an erratum, what its page claims (source,
verdict, remark) and what the erratum says is printed. After a change of either, both are read again and the table is
renewed.
"""

import csv
import re
from pathlib import Path

import pytest

from vvdp.reproduction.expectation import expected_rows
from vvdp.results.verdict import Verdict

DOCS = Path(__file__).parents[2] / "docs"


@pytest.fixture(scope="module")
def links():
    return list(csv.DictReader((DOCS / "errata-rows.csv").read_text("utf-8").splitlines()))


@pytest.fixture(scope="module")
def claims():
    """What the pages say of each row."""
    found, item = {}, ""
    for page in sorted((DOCS / "reproduction").glob("chapter-*.md")):
        for line in page.read_text("utf-8").splitlines():
            if line.startswith("## "):
                item = line.removeprefix("## ").partition(":")[0]
            cells = [cell.strip() for cell in re.split(r"(?<!\\)\|", line.strip("|"))]
            if len(cells) == 7 and cells[5].startswith("*"):
                what, _, source, _, _, verdict, remark = cells
                claim = "; ".join(filter(None, (source, verdict.strip("*"), remark)))
                found[item, what.replace("\\|", "|")] = claim
    return found


def test_every_row_claims_what_was_compared_with_its_erratum(links, claims):
    assert {(link["item"], link["what"]): link["claim"] for link in links} == {
        (link["item"], link["what"]): claims.get((link["item"], link["what"]), "no such row") for link in links
    }


def test_every_erratum_says_what_was_compared_with_its_rows(links, rows):
    printed = {(row.place, row.text.split(" | ")[0]) for row in rows}
    assert [link for link in links if (link["place"], link["printed"]) not in printed] == []


def test_every_inconsistent_row_has_an_erratum(links):
    linked = {(link["item"], link["what"]) for link in links}
    inconsistent = {key for key, row in expected_rows().items() if row.verdict == Verdict.INCONSISTENT}
    assert inconsistent - linked == set()
