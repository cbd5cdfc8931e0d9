"""The table of docs/reliability.md: what became of the files of each kind."""

from collections import Counter
from collections.abc import Mapping
from pathlib import Path

from tests.attack.cage import Outcome

PAGE = Path(__file__).parents[2] / "docs" / "reliability.md"
BEGIN, END = "<!-- written by `python -m tests.attack --write` -->", "<!-- end of what is written -->"


def filled_in(page: str, rows: Mapping[str, Counter[Outcome]]) -> str:
    """The page with the counts of all kinds of files."""
    before, rest = page.split(BEGIN)
    _, after = rest.split(END)
    heads = ["files", "number", *Outcome]
    lines = [heads, ["---"] * len(heads)]
    total = sum(rows.values(), Counter[Outcome]())
    for name, counts in {**rows, "**all**": total}.items():
        lines.append([name, str(counts.total()), *(str(counts[outcome]) for outcome in Outcome)])
    table = "\n".join(f"| {' | '.join(cells)} |" for cells in lines)
    return f"{before}{BEGIN}\n\n{table}\n\n{END}{after}"


def read_rows(page: str) -> dict[str, Counter[Outcome]]:
    """The counts that stand in the page, without the last row."""
    table = page.split(BEGIN)[1].split(END)[0].strip().splitlines()[2:-1]
    cells = ([cell.strip() for cell in line.strip("|").split("|")] for line in table)
    return {name: Counter(dict(zip(Outcome, map(int, counts), strict=True))) for name, _, *counts in cells}
