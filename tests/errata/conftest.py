"""The page of errata, row by row."""

import re
from pathlib import Path
from typing import NamedTuple

import pytest

PAGE = Path(__file__).parents[2] / "docs" / "errata.md"


class Row(NamedTuple):
    """One row of the tables of misprints; `tests` are the functions that its last column names."""

    place: str
    text: str
    tests: tuple[str, ...]


def rows_of(page: str) -> list[Row]:
    """Rows of all tables whose last column is `test`."""
    found, inside = [], False
    for line in page.splitlines():
        cells = [cell.strip() for cell in line.strip("|").split("|")] if line.startswith("|") else []
        if not cells:
            inside = False
        elif cells[-1] == "test":
            inside = True
        elif inside and not set(line) <= set("|- "):
            found.append(Row(cells[0], " | ".join(cells[1:-1]), tuple(re.findall(r"`(\w+)`", cells[-1]))))
    return found


@pytest.fixture(scope="session")
def page() -> str:
    return PAGE.read_text("utf-8")


@pytest.fixture(scope="session")
def rows(page) -> list[Row]:
    return rows_of(page)


@pytest.fixture
def told(request, rows) -> str:
    """What the rows say that name the test which asks: a number of theirs stands there as the test has it."""
    name = request.node.originalname
    texts = [row.text for row in rows if name in row.tests]
    assert texts, f"no row of docs/errata.md names {name}"
    return "\n".join(texts)
