"""Writes the page of the numbered equations from docs/equations.csv: `python docs/site/equations.py`."""

import csv
import re
from pathlib import Path

DOCS = Path(__file__).parents[1]
TABLE, PAGE, ERRATA = "equations.csv", "equations.md", "errata.md"
HEAD = """# Numbered equations of chapters 2 to 6

All {total} numbered equations of wang2017. Each has a place in the code and the tests that calculate or use it, and it
is built as printed or corrected, with a link to the correction. {built} are in the code. {unused} are not used, with
the reason in place of the code; tests show what they lack. {corrected} are corrected. The data are in `equations.csv`.

"""
NUMBER = re.compile(r"\(([2-6])\.(\d+)\)(?: to \([2-6]\.(\d+)\))?")
BESIDE = re.compile(r"below \([^)]*\)|proof of .*")
"""Places beside an equation, which itself is right."""


def equations_of(place: str) -> list[str]:
    """The numbers of the equations that a place in the errata says are misprinted: `(4.21) to (4.23)` are three."""
    found = []
    for chapter, first, last in NUMBER.findall(BESIDE.sub("", place)):
        found += [f"{chapter}.{number}" for number in range(int(first), int(last or first) + 1)]
    return found


def corrections(page: str) -> dict[str, str]:
    """The heading under which the errata correct each equation, the first one, from the rows that name a test."""
    found: dict[str, str] = {}
    heading = ""
    for line in page.splitlines():
        if line.startswith("## "):
            heading = line.removeprefix("## ")
        elif line.startswith("| ") and line.count(" | ") >= 4:
            for equation in equations_of(line.split("|")[1]):
                found.setdefault(equation, heading)
    return found


def anchor(heading: str) -> str:
    """The anchor that the site gives to a heading."""
    return re.sub(r"[-\s]+", "-", re.sub(r"[^\w\s-]", "", heading).strip().lower())


def page_text() -> str:
    """The page: counts, then a table."""
    rows = list(csv.DictReader((DOCS / TABLE).read_text("utf-8").splitlines()))
    headings = corrections((DOCS / ERRATA).read_text("utf-8"))
    lines = ["| equation | subject | form | code | tests |", "|---|---|---|---|---|"]
    for row in rows:
        form = row["form"]
        if form == "corrected":
            form = f"[corrected]({ERRATA}#{anchor(headings[row['equation']])})"
        code = f"`{row['code']}`" if row["code"] else f"not used: {row['reason']}"
        tests = ", ".join(f"`{test}`" for test in row["tests"].split())
        lines.append(f"| ({row['equation']}) | {row['subject']} | {form} | {code} | {tests} |")
    built = sum(bool(row["code"]) for row in rows)
    counts = {"total": len(rows), "built": built, "unused": len(rows) - built}
    return HEAD.format(**counts, corrected=sum(row["form"] == "corrected" for row in rows)) + "\n".join(lines) + "\n"


if __name__ == "__main__":
    (DOCS / PAGE).write_text(page_text(), "utf-8")
