"""The bibliography: BibTeX entries and how a reader sees them."""

import re
import unicodedata
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from importlib import resources

_HEAD = re.compile(r"@(\w+)\s*\{\s*([^\s,{}]+)\s*,")
_FIELD = re.compile(r"\s*([A-Za-z]+)\s*=\s*\{")


@dataclass(frozen=True)
class Reference:
    """One entry of a bibliography."""

    key: str
    sort: str
    fields: Mapping[str, str]

    @property
    def authors(self) -> str:
        """The authors as they are printed: H. Name, H. Name and H. Name."""
        names = [_natural(name.strip()) for name in re.split(r"\s+and\s+", self.fields.get("author", ""))]
        return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"

    @property
    def place(self) -> str:
        """Where it appeared: journal, volume and pages, or publisher, or number of the standard."""
        f = {name: _plain(text) for name, text in self.fields.items()}
        volume = f.get("volume", "") + (f"({f['number']})" if "volume" in f and "number" in f else "")
        if self.sort == "phdthesis":
            return f"PhD thesis, {f['school']}"
        if self.sort == "techreport":
            return (
                f.get("number", "") if f["institution"] == self.authors else f"{f['institution']} {f.get('number', '')}"
            )
        parts = [f.get("journal", ""), volume, f.get("booktitle", ""), f.get("edition", "") and f"{f['edition']} ed."]
        parts += [f.get("publisher", ""), f.get("address", ""), f.get("pages", "") and f"p. {f['pages']}"]
        return ", ".join(part for part in parts if part)

    @property
    def title(self) -> str:
        """The title without the braces of BibTeX."""
        return _plain(self.fields.get("title", ""))

    @property
    def year(self) -> str:
        """The year of publication."""
        return self.fields.get("year", "")


def bibliography() -> dict[str, Reference]:
    """The references that come with vvdp, by key."""
    return {
        r.key: r
        for r in parsed_references(resources.files("vvdp.report").joinpath("references.bib").read_text("utf-8"))
    }


def parsed_references(text: str) -> Iterator[Reference]:
    """The entries of BibTeX `text`, whose values stand in braces. Raises ValueError where a brace is left open."""
    at = 0
    while head := _HEAD.search(text, at):
        fields: dict[str, str] = {}
        at = head.end()
        while field := _FIELD.match(text, at):
            end = _closing(text, field.end())
            fields[field[1].lower()] = re.sub(r"\s+", " ", text[field.end() : end])
            at = end + 1
            if match := re.compile(r"\s*,").match(text, at):
                at = match.end()
        yield Reference(head[2], head[1].lower(), fields)


def _closing(text: str, begin: int) -> int:
    depth = 1
    for i in range(begin, len(text)):
        depth += (text[i] == "{") - (text[i] == "}")
        if depth == 0:
            return i
    raise ValueError(f"a brace is left open after {text[begin - 30 : begin]!r}")


def _natural(name: str) -> str:
    if name.startswith("{"):
        return _plain(name)
    last, comma, first = name.partition(", ")
    return _plain(f"{first} {last}" if comma else last)


ACCENTS = {"'": "\u0301", "`": "\u0300", "^": "\u0302", '"': "\u0308", "~": "\u0303"}


def _plain(text: str) -> str:
    text = text.replace("{", "").replace("}", "").replace(r"\&", "&").replace("--", "–")
    return re.sub(r"\\(['`^\"~])(\w)", lambda match: unicodedata.normalize("NFC", match[2] + ACCENTS[match[1]]), text)
