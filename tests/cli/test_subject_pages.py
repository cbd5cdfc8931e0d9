"""docs/subjects: the blocks of each page run and print what stands under them, and no number of theirs is made up."""

import re
import shlex
from pathlib import Path

import pytest

from vvdp.generator.source import known_text

DOCS = Path(__file__).parents[2] / "docs"
PAGES = sorted((DOCS / "subjects").glob("*.md"))
BLOCK = re.compile(r"```(python|sh)\n(.*?)```\n(?:\n```text\n(.*?)```\n)?", re.DOTALL)
FENCED = re.compile(r"```\w*\n(.*?)```", re.DOTALL)
LINK = re.compile(r"\]\(([\w./-]+\.md)[^)]*\)")
UNIT = r"(?:bar|Hz|lpm|W|mm/s|mm|cm|um|ms|s|N|kN|%|°C|rpm|cells|rev/s|kHz)"
ONE = r"\d+(?: \d{3})*(?:\.\d+)?"
NUMBER = re.compile(rf"(?<![\w.$^{{-])((?:({ONE}) (?:to|and|or) )?({ONE}) {UNIT})(?![\w/])")
DECIMAL = re.compile(r"(?<![\w.$^{-])\d+\.\d+(?![\w.])")
ANY_NUMBER = re.compile(r"\d+(?:\.\d+)?")


def prose(page: str) -> str:
    """What a page says outside its blocks, in one line."""
    return " ".join(FENCED.sub(" ", page).split())


def numbers_of(blocks: list[str]) -> list[float]:
    """All numbers of the blocks of a page."""
    return [float(each) for block in blocks for each in ANY_NUMBER.findall(block)]


def numbers_said(page: str) -> list[tuple[str, str]]:
    """The numbers of the prose of a page that have a unit or a decimal point, each as it is written there."""
    said = re.sub(r"\$[^$]*\$|\]\([^)]*\)", " ", prose(page))
    units = [(each, text) for text, *pair in NUMBER.findall(said) for each in pair if each]
    return units + [(each, each) for each in DECIMAL.findall(said)]


def stands_in(said: str, shown: list[float]) -> bool:
    """Whether a number is one of those shown, rounded to the digits that it is said with, or as a share in per cent."""
    digits, value = len(said.partition(".")[2]), float(said)
    rounded = [k for k in range(1, 6) if not digits and value % 10**k == 0.0 and value >= 10 ** (k + 1)]
    last = 0.5000001 * 10.0 ** max([-digits, *rounded])
    return any(abs(each * scale - value) <= last for each in shown for scale in (1.0, 100.0))


@pytest.mark.sampled(3)
@pytest.mark.parametrize("path", PAGES, ids=lambda path: path.stem)
def test_the_page_does_what_it_says(path, vvdp, here, is_shown, capsys):
    left, ran = {}, 0
    for kind, block, shown in BLOCK.findall(path.read_text("utf-8")):
        capsys.readouterr()
        if kind == "sh":
            answer = vvdp(*shlex.split(block)[1:])
            assert answer.code == 0, answer.err
            said = answer.out
        else:
            exec(compile(block, known_text(block, path.name), "exec"), left)
            said = capsys.readouterr().out
        assert is_shown(shown, said) if shown else not said, (block, said)
        ran += bool(shown)
    assert ran >= 2


def linked(path: Path, page: str) -> str:
    """The text of the pages that a page links to, which have tests of their own."""
    links = {(path.parent / name).resolve() for name in LINK.findall(page)}
    return " ".join(" ".join(each.read_text("utf-8").split()) for each in sorted(links) if each.is_file())


@pytest.mark.parametrize("path", PAGES, ids=lambda path: path.stem)
def test_every_number_is_shown_or_stands_on_a_page_that_is_linked(path):
    page = path.read_text("utf-8")
    shown, elsewhere = numbers_of(FENCED.findall(page)), linked(path, page)
    found = numbers_said(page)
    assert len(found) >= 5
    assert [
        text for number, text in found if not stands_in(number.replace(" ", ""), shown) and text not in elsewhere
    ] == []


def test_the_check_of_numbers_bites():
    shown = numbers_of(["loss 1336 W, share 0.3001"])
    assert stands_in("1340", shown) and stands_in("30", shown) and stands_in("1336", shown)
    assert not stands_in("1345", shown) and not stands_in("31", shown) and not stands_in("1335", shown)
    page = "from 10 to 20 lpm, 1 500 rpm or 0.3\n```text\n7 bar\n```\n$2.5$"
    assert [text for _, text in numbers_said(page)] == ["10 to 20 lpm", "10 to 20 lpm", "1 500 rpm", "0.3"]


@pytest.mark.parametrize("path", PAGES, ids=lambda path: path.stem)
def test_a_subject_has_pictures_rules_warnings_and_ways_on(path):
    page = path.read_text("utf-8")
    pictures = re.findall(r"!\[[^\]]+\]\(([^)]+)\)", page)
    assert pictures and all((path.parent / picture).resolve().is_file() for picture in pictures)
    for heading in ("Rules of thumb", "What to watch out for", "Where to go from here"):
        assert f"\n## {heading}\n" in page
    ways = page.partition("## Where to go from here")[2]
    for kind in ("models/", "reproduction/chapter-", "keys.md", "reference/python/"):
        assert kind in ways, kind
    assert 60 <= len(page.splitlines()) <= 140
