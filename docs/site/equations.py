"""Writes the page of the numbered equations from docs/equations.csv: `python docs/site/equations.py`."""

import csv
from pathlib import Path

DOCS = Path(__file__).parents[1]
TABLE, PAGE = "equations.csv", "equations.md"
HEAD = """# Numbered equations of chapters 2 to 6

All {total} numbered equations of wang2017: where each is in the code, by which test it is worked out, and whether it is
built as printed or corrected ([errata](errata.md)). {filled} have both code and test; {tested} more are not in the
code, but a test works the printed form out and shows what it lacks; {empty} have neither. The data are in
`equations.csv`.

"""


def page_text() -> str:
    """The page: a count, then a table."""
    rows = list(csv.DictReader((DOCS / TABLE).read_text("utf-8").splitlines()))
    filled = sum(bool(row["code"] and row["test"]) for row in rows)
    tested = sum(bool(row["test"] and not row["code"]) for row in rows)
    lines = ["| equation | subject | form | code | test |", "|---|---|---|---|---|"]
    for row in rows:
        code, test = (f"`{row[key]}`" if row[key] else "" for key in ("code", "test"))
        lines.append(f"| ({row['equation']}) | {row['subject']} | {row['form'] or 'not built'} | {code} | {test} |")
    head = HEAD.format(total=len(rows), filled=filled, tested=tested, empty=len(rows) - filled - tested)
    return head + "\n".join(lines) + "\n"


if __name__ == "__main__":
    (DOCS / PAGE).write_text(page_text(), "utf-8")
