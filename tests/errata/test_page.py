"""Every row of the errata names tests, and these exist."""

import ast
import re
from pathlib import Path

TESTS = Path(__file__).parents[1]
NOTHING_TO_WORK_OUT = {"abstract", "[95], [96]"}
"""Places whose misprint is one of the text alone."""
ROWS, PARAGRAPHS = 114, 19


def functions_of_the_tests() -> dict[str, list[str]]:
    """Files in which each function stands whose name begins with test_."""
    found: dict[str, list[str]] = {}
    for path in TESTS.rglob("test_*.py"):
        for node in ast.walk(ast.parse(path.read_text("utf-8"))):
            if isinstance(node, ast.FunctionDef) and node.name.startswith("test_"):
                found.setdefault(node.name, []).append(str(path.relative_to(TESTS)))
    return found


def test_every_row_names_tests_that_exist_once(rows):
    known = functions_of_the_tests()
    named = {test for row in rows for test in row.tests}
    assert {test: known.get(test, []) for test in named if len(known.get(test, [])) != 1} == {}
    assert {row.place for row in rows if not row.tests} == NOTHING_TO_WORK_OUT


def test_every_paragraph_names_tests_that_exist_once(page):
    """Those of the derived models, below the tables: each of their sections and bold paragraphs."""
    known = functions_of_the_tests()
    paragraphs = re.split(r"\n\n(?=\*\*|## )", page[page.index("**Convergence**") :])
    assert len(paragraphs) == PARAGRAPHS
    unnamed = [text[:40] for text in paragraphs if "\n" in text and not re.findall(r"`test_\w+`", text)]
    assert unnamed == []
    named = {test for text in paragraphs for test in re.findall(r"`(test_\w+)`", text)}
    assert {test: known.get(test, []) for test in named if len(known.get(test, [])) != 1} == {}


def test_rows_are_counted(rows, page):
    """None is lost to a table that breaks: every line that begins as a row belongs to a table with a head."""
    assert len(rows) == ROWS
    assert len({(row.place, row.text) for row in rows}) == ROWS
    lines = page.splitlines()
    heads = [i for i, line in enumerate(lines) if i and set(line) <= set("|- ") and line.startswith("|-")]
    for i, line in enumerate(lines):
        if line.startswith("|") and not lines[i - 1].startswith("|"):
            assert i + 1 in heads, line


def test_every_test_of_the_sources_is_named(page):
    """What stands in this folder about the sources is named by the page."""
    named = set(re.findall(r"`(test_\w+)`", page))
    here = {
        node.name
        for path in Path(__file__).parent.glob("test_[!p]*.py")
        for node in ast.parse(path.read_text("utf-8")).body
        if isinstance(node, ast.FunctionDef) and node.name.startswith("test_")
    }
    assert here - named == set()
