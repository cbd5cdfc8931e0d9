"""Writes the pages of the reproduction, their pictures, and the lists of expected verdicts.

`vvdp reproduce all --out DIR`, then `python docs/site/reproduction.py DIR`; or `chapter-3` for a single chapter
"""

import csv
import io
import re
import sys
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from PIL import Image

from vvdp.reproduction.expectation import FILE, Expected, expectation_text, expected_rows
from vvdp.reproduction.item import Item
from vvdp.reproduction.items import ITEMS
from vvdp.results.verdict import Evidence, Verdict

DOCS = Path(__file__).parents[1]
PAGE, PAGES = "reproduction.md", "reproduction"
PICTURES = "images/reproduction"
PACKAGE = DOCS.parent / "src" / "vvdp" / "reproduction"
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
    yield f"## {item.name}: {item.title}\n"
    yield "| | kind | source | vvdp | tolerance | verdict | note |"
    yield "|---|---|---|---|---|---|---|"
    for row in rows:
        tolerance = ", ".join(filter(None, (row["tolerance"], row["tolerance_source"])))
        cells = (
            row["what"],
            row["evidence"],
            row["source"],
            row["found"],
            tolerance,
            f"*{row['verdict']}*",
            row["remark"],
        )
        yield f"| {' | '.join(map(cell, cells))} |"
    yield ""
    for picture in pictures:
        yield f"![{item.title}](../{PICTURES}/{picture})\n"


def keep_pictures(item: Item, folder: Path, pictures: Path) -> list[str]:
    """Copies the pictures of an item, in few colours; drawings that are lines alone stay SVG. Their names."""
    names = []
    for path in sorted((folder / item.name).glob("*.svg")):
        raster = path.with_suffix(".png")
        if raster.exists():
            with Image.open(raster) as picture:
                few = picture.convert("RGB").quantize(COLOURS, Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE)
                few.save(pictures / raster.name, "PNG", optimize=True)
        else:
            (pictures / path.name).write_bytes(path.read_bytes())
        names.append(raster.name if raster.exists() else path.name)
    return names


def chapter_lines(chapter: int, rows: Rows, folder: Path, docs: Path) -> Iterator[str]:
    """The page of a chapter: all of its items."""
    yield f"# Chapter {chapter}: {TITLES[chapter]}\n"
    yield f"`vvdp reproduce chapter-{chapter}`; [what the verdicts mean](../{PAGE})\n"
    for item in items_of(chapter):
        own = [row for row in rows if row["item"] == item.name]
        yield from item_lines(item, own, keep_pictures(item, folder, docs / PICTURES))


def items_of(chapter: int) -> list[Item]:
    """The items of a chapter."""
    return [item for item in ITEMS if item.chapter == chapter]


def verdicts_of(rows: Rows) -> Iterator[tuple[tuple[str, str], str]]:
    """Item and statement of each line, with its verdict."""
    for row in rows:
        yield (row["item"], row["what"]), row["verdict"]


def kind_lines(expected: Iterable[Expected]) -> Iterator[str]:
    """How many statements of each kind have each verdict; below it the headline."""
    rows = [row for row in expected if not row.is_drawing]
    counts = Counter((row.evidence, row.verdict) for row in rows)
    verdicts = [verdict for verdict in Verdict if verdict is not Verdict.DRAWING]
    yield f"| kind | statements | {' | '.join(verdict.value for verdict in verdicts)} |"
    yield "|---|" + "---|" * (len(verdicts) + 1)
    for kind in Evidence:
        own = [counts[kind.value, verdict.value] for verdict in verdicts]
        yield f"| {kind.value} | {sum(own)} | {' | '.join(map(str, own))} |"
    independent = Counter(row.verdict for row in rows if row.is_independent)
    held = independent[Verdict.REPRODUCED.value]
    yield f"\n**Of {independent.total()} simulated or computed numbers that are compared with printed numbers and could"
    yield f"have failed, {held} are reproduced.**"


def count_lines(expected: Mapping[tuple[str, str], str]) -> Iterator[str]:
    """How many items and statements each chapter has, and how many of each verdict."""
    chapter_of = {item.name: item.chapter for item in ITEMS}
    counts = Counter((chapter_of[item], verdict) for (item, _), verdict in expected.items())
    yield f"| chapter | items | statements | {' | '.join(verdict.value for verdict in Verdict)} |"
    yield "|---|" + "---|" * (len(Verdict) + 2)
    chapters = sorted({*chapter_of.values()})
    for chapter in chapters:
        own = [counts[chapter, verdict.value] for verdict in Verdict]
        name = f"[{chapter}: {TITLES[chapter]}]({PAGES}/chapter-{chapter}.md)"
        yield f"| {name} | {len(items_of(chapter))} | {sum(own)} | {' | '.join(map(str, own))} |"
    sums = [sum(counts[chapter, verdict.value] for chapter in chapters) for verdict in Verdict]
    yield f"| all | {len(ITEMS)} | {sum(sums)} | {' | '.join(map(str, sums))} |"


def clear_pictures(docs: Path) -> None:
    """Takes away the pictures that no page shows any more."""
    pages = "".join(path.read_text("utf-8") for path in (docs / PAGES).glob("*.md"))
    for path in (docs / PICTURES).iterdir():
        if f"{PICTURES}/{path.name})" not in pages:
            path.unlink()


def main(folder: Path, docs: Path = DOCS, package: Path = PACKAGE) -> None:
    """Writes the pages, pictures and expectations of the chapters that were worked out in `folder`."""
    rows = read_verdicts(folder)
    (docs / PICTURES).mkdir(parents=True, exist_ok=True)
    (docs / PAGES).mkdir(exist_ok=True)
    found, known = {row["item"] for row in rows}, expected_rows()
    for chapter in TITLES:
        names = {item.name for item in items_of(chapter)}
        if names and names <= found:
            own = [row for row in rows if row["item"] in names]
            text = "\n".join(chapter_lines(chapter, own, folder, docs))
            (docs / PAGES / f"chapter-{chapter}.md").write_text(text.rstrip("\n") + "\n", "utf-8")
            kept = {key: known.get(key, Expected())._replace(verdict=verdict) for key, verdict in verdicts_of(own)}
            (package / f"chapter_{chapter}" / FILE).write_text(expectation_text(kept), "utf-8")
    clear_pictures(docs)
    expected_rows.cache_clear()
    now = expected_rows()
    lines = (*count_lines({key: row.verdict for key, row in now.items()}), "", *kind_lines(now.values()))
    text = "\n".join(lines)
    page = (DOCS / PAGE).read_text("utf-8")
    pattern = re.compile(f"{re.escape(BEGIN)}.*{re.escape(END)}", re.DOTALL)
    (docs / PAGE).write_text(pattern.sub(lambda _: f"{BEGIN}\n{text}\n\n{END}", page), "utf-8")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
