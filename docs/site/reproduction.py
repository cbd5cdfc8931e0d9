"""Writes the verdicts and pictures of the reproduction into its page, and the list of expected verdicts.

`vvdp reproduce all --out DIR`, then `python docs/site/reproduction.py DIR`
"""

import csv
import io
import re
import sys
from collections.abc import Iterator, Sequence
from itertools import groupby
from pathlib import Path
from typing import Any

from PIL import Image

from vvdp.reproduction.expectation import expectation_text
from vvdp.reproduction.item import Item
from vvdp.reproduction.items import ITEMS

DOCS = Path(__file__).parents[1]
PAGE, PICTURES = DOCS / "reproduction.md", DOCS / "images" / "reproduction"
EXPECTED = DOCS.parent / "src" / "vvdp" / "reproduction" / "expected.csv"
BEGIN, END = "<!-- made by docs/site/reproduction.py -->\n", "<!-- to here -->\n"
TITLES = {
    1: "Digital hydraulics and its valves",
    2: "The rotary valve, its flow and its torque",
    3: "Angle and speed from a coarse encoder",
    4: "The axial position under a periodic noise",
    5: "Passivity-based control of the axial position",
    6: "Displacement control of a cylinder",
    7: "What is proposed for later",
}
COLOURS = 48
Rows = Sequence[dict[str, Any]]


def read_verdicts(folder: Path) -> Rows:
    """The lines of the verdict table of a finished run."""
    return list(csv.DictReader(io.StringIO((folder / "verdicts.csv").read_text("utf-8"))))


def cell(text: str) -> str:
    """A text as it stands in a table of Markdown."""
    return text.replace("|", "\\|").replace("`", "")


def item_lines(item: Item, rows: Rows, pictures: Sequence[str]) -> Iterator[str]:
    """An item: its verdicts, then its pictures."""
    yield f"#### {item.name}: {item.title}\n"
    yield "| | source | vvdp | tolerance | verdict | remark |"
    yield "|---|---|---|---|---|---|"
    for row in rows:
        tolerance = ", ".join(filter(None, (row["tolerance"], row["tolerance_source"])))
        cells = (row["what"], row["source"], row["found"], tolerance, f"*{row['verdict']}*", row["remark"])
        yield f"| {' | '.join(map(cell, cells))} |"
    yield ""
    for picture in pictures:
        yield f"![{item.title}](images/reproduction/{picture})\n"


def keep_pictures(item: Item, folder: Path, pictures: Path) -> list[str]:
    """Copies the pictures of an item, in few colours; their names."""
    names = []
    for path in sorted((folder / item.name).glob("*.png")):
        with Image.open(path) as picture:
            few = picture.convert("RGB").quantize(COLOURS, Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE)
            few.save(pictures / path.name, "PNG", optimize=True)
        names.append(path.name)
    return names


def chapters(rows: Rows, folder: Path, pictures: Path) -> Iterator[str]:
    """All items by chapter, and at the end how many there are."""
    for chapter, items in groupby(ITEMS, key=lambda item: item.chapter):
        yield f"## Chapter {chapter}: {TITLES[chapter]}\n"
        for item in items:
            own = [row for row in rows if row["item"] == item.name]
            yield from item_lines(item, own, keep_pictures(item, folder, pictures))
    yield f"{len(ITEMS)} items, {len(rows)} statements.\n"


def main(folder: Path, docs: Path = DOCS, expected: Path = EXPECTED) -> None:
    """Writes page, pictures and expectation from the run in `folder`."""
    rows = read_verdicts(folder)
    pictures = docs / PICTURES.relative_to(DOCS)
    pictures.mkdir(parents=True, exist_ok=True)
    text = "\n".join(chapters(rows, folder, pictures))
    page = PAGE.read_text("utf-8")
    pattern = re.compile(f"{re.escape(BEGIN)}.*{re.escape(END)}", re.DOTALL)
    (docs / PAGE.name).write_text(pattern.sub(lambda _: f"{BEGIN}\n{text}\n{END}", page), "utf-8")
    expected.write_text(expectation_text({(row["item"], row["what"]): row["verdict"] for row in rows}), "utf-8")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
