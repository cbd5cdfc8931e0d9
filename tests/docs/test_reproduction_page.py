"""The pages of the reproduction have every statement with the verdict that is expected, and count them right."""

import re
from collections import Counter
from pathlib import Path

import pytest

from vvdp.reproduction.expectation import expected_rows, expected_verdicts
from vvdp.reproduction.items import ITEMS
from vvdp.results.verdict import Verdict

DOCS = Path(__file__).parents[2] / "docs"
CHAPTERS = {item.name: item.chapter for item in ITEMS}
MADE_TWICE = re.compile(r"[|`]")


def rows_of(page):
    """(item, what, verdict) of every row of a page."""
    item = ""
    for line in page.splitlines():
        if line.startswith("## "):
            item = line.removeprefix("## ").partition(":")[0]
        cells = [cell.strip() for cell in re.split(r"(?<!\\)\|", line.strip("|"))]
        if len(cells) == 7 and cells[5].startswith("*"):
            yield item, MADE_TWICE.sub("", cells[0].replace("\\|", "|")), cells[5].strip("*")


@pytest.mark.parametrize("chapter", sorted({*CHAPTERS.values()}))
def test_every_statement_stands_on_its_page(chapter):
    page = (DOCS / "reproduction" / f"chapter-{chapter}.md").read_text("utf-8")
    expected = [
        (item, MADE_TWICE.sub("", what), verdict)
        for (item, what), verdict in expected_verdicts().items()
        if CHAPTERS[item] == chapter
    ]
    assert sorted(rows_of(page)) == sorted(expected)


def test_the_counts_of_the_first_page():
    page = (DOCS / "reproduction.md").read_text("utf-8")
    expected = expected_verdicts()
    counts = Counter(expected.values())
    row = [len(ITEMS), len(expected), *(counts[verdict] for verdict in Verdict)]
    assert f"| all | {' | '.join(map(str, row))} |" in page


def test_the_headline_stands_on_the_first_page_and_in_the_readme():
    rows = [row for row in expected_rows().values() if row.is_independent]
    held = sum(row.verdict == Verdict.REPRODUCED for row in rows)
    text = f"Of {len(rows)} simulated or computed numbers that are compared with printed numbers and could have failed"
    for path in (DOCS / "reproduction.md", DOCS.parent / "README.md"):
        assert f"{text}, {held} are reproduced" in " ".join(path.read_text("utf-8").split())


def test_every_picture_of_the_pages_is_there_and_no_other():
    pages = [path.read_text("utf-8") for path in sorted((DOCS / "reproduction").glob("*.md"))]
    shown = {name for page in pages for name in re.findall(r"images/reproduction/([^)]+)\)", page)}
    assert shown == {path.name for path in (DOCS / "images" / "reproduction").iterdir()}
