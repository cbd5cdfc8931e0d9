"""Every key that the code and the shipped systems cite is in the bibliography."""

import re
from pathlib import Path

import pytest
from tests.words import wording

import vvdp
from vvdp.report.references import bibliography, parsed_references
from vvdp.systems.system import load_system, shipped_systems

KEY = re.compile(r"\b[a-z]+(?:-[a-z])?(?:\d{4}|-d341|1219)\b")
ROOT = Path(vvdp.__file__).parent
KNOWN = bibliography()


def test_every_entry_has_author_title_place_and_year():
    assert len(KNOWN) >= 14
    for reference in KNOWN.values():
        assert reference.authors and reference.title and reference.place
        assert re.fullmatch(r"\d{4}", reference.year)
        assert not re.search(r"[{}\\]", reference.authors + reference.title + reference.place)


def test_no_entry_stands_twice():
    keys = [entry.key for entry in parsed_references((ROOT / "report" / "references.bib").read_text("utf-8"))]
    assert [key for key in KNOWN if keys.count(key) > 1] == []


@pytest.mark.parametrize("name", shipped_systems())
def test_the_shipped_systems_cite_known_literature(name):
    assert {row.source for row in load_system(name).rows} - {""} <= set(KNOWN)


def test_source_lines_cite_known_literature():
    lines = [
        (path, line)
        for path in ROOT.rglob("*.py")
        for line in re.findall(r"^ +Source  (.+)$", path.read_text("utf-8"), re.MULTILINE)
    ]
    assert len(lines) > 50
    for path, line in lines:
        cited = set(KEY.findall(line))
        assert cited or "ours" in line, (path, line)
        assert cited <= set(KNOWN), (path, line)


def test_the_documentation_has_the_same_file():
    linked = ROOT.parents[1] / "docs" / "references.bib"
    if linked.parent.exists():
        assert linked.is_symlink() and linked.read_bytes() == (ROOT / "report" / "references.bib").read_bytes()


def test_an_entry_is_read():
    text = "@article{a2001,\n author = {One, A. and {Two Ltd} and Three, B.},\n"
    text += " title = {The {ABC} of\n it},\n"
    text += " journal = {J},\n volume={3}, number={2}, pages = {1--2},\n year={2001}\n}"
    (entry,) = parsed_references(text)
    assert entry.authors == "A. One, Two Ltd and B. Three"
    assert entry.title == "The ABC of it"
    assert entry.place == "J, 3(2), p. 1–2"


def test_an_open_brace_is_refused():
    with pytest.raises(ValueError, match=wording.report.left_open):
        list(parsed_references("@book{a, title = {never"))
