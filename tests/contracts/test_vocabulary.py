"""The words of the project: what the pages and the packages listed here no longer say, and what they say instead.

A rule is a pattern and its replacement. To add a rule, mend its hits first. Code, formulas and links are not looked at.
"""

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

RULES = {
    r"\bshuts?\b|\bshutting\b": "closed, closes (ISO 5598)",
    r"\banew\b": "again, from the start",
    r"\b(?:whoever|somebody|anybody|nobody)\b": "you, the process; a passive sentence",
    r"\bbeforehand\b": "before",
    r"\bpollution\b": "periodic sensor error; contamination means particles in oil (ISO 4406)",
    r"\btest (?:stand|bench)\w*\b": "test rig",
    r"\b(?:set|working) points?\b": "operating point; the setpoint of a controller",
    r"\bopen share\b": "open fraction",
    r"\bone's own\b": "your own, custom, user-defined",
    r"\bhangs? on\b": "depends on",
    r"\bpump over centre\b": "overcentre pump",
    r"\bwork(?:s|ed)? (?:it |them )?out\b": "calculated",
    r"\breturn throttles?\b|\bthrottles? in the return\b": "meter-out throttle",
    r"\b(?:two|stated) deviations?\b": "±2σ; stated standard deviation",
    r"\b(?:is|are|was|were|be) told\b|\btold (?:by|before|apart|from)\b": "is reported, detected, known from",
    r"\b(?:says so|is said)\b": "states, reports; is stated",
    r"\bswivel\w*": "stroke, destroke; displacement ratio",
    r"\bwhole or absent\b": "complete or not there",
    r"\b(?:error|estimate|position|drawn) less (?:the|truth|reference|returned)\b": "minus",
    r"\bwhat (?:it|they|a \w+|the \w+|\w+) comes? to\b": "result",
    r"\bdear end\b|\breckon\w*\b|\bfree sight\b|\blet rest\b|\bhands on the cylinder\b": "no metaphor, no archaism",
    r"\ba person\b": "you, the user",
}
OTHER_PAGES = {
    "CHANGELOG.md": "what was said then",
    "docs/errata.md": "made from rows that quote the sources",
    "docs/reproduction.md": "made from the rows of the reproduction",
    "docs/gallery.md": "titles of the shipped systems",
    "docs/how-vvdp-compiles.md": "shows texts of the code",
    "docs/keys.md": "labels of the results as they are",
    "docs/components.md": "first sentences of the laws",
    "docs/programs.md": "first sentences of the steps",
}
"""Pages that are not looked at, with the reason."""
UNFINISHED = (
    "logs.md",
    "fmu-export.md",
    "workbench.md",
    "interactive-pages.md",
    "exercises",
    "reproduction/",
    "notebooks/",
)
"""Pages that are still to be gone through."""
PACKAGES = ("fitting",)
"""Packages whose docstrings and texts keep the rules; a package is added once it does."""
SILENT = re.compile(r"`[^`]*`|\$[^$]*\$|\]\([^)]*\)")


def prose_of_page(text: str) -> Iterator[tuple[int, str]]:
    """Number and words of each line of a page, without code, formulas and links."""
    is_code = is_formula = False
    for number, line in enumerate(text.splitlines(), 1):
        if line.strip().startswith("```"):
            is_code = not is_code
        elif line.strip().startswith("$$") or line.strip().endswith("$$"):
            is_formula ^= line.count("$$") == 1
        elif not (is_code or is_formula or line.startswith("    ")):
            yield number, SILENT.sub(" ", line)


def prose_of_module(text: str) -> Iterator[tuple[int, str]]:
    """Number and words of each line of the docstrings and of the texts with a space in a module."""
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and " " in node.value:
            for n, line in enumerate(node.value.splitlines()):
                yield node.lineno + n, SILENT.sub(" ", line)


def hits(name: str, prose: Iterator[tuple[int, str]]) -> list[str]:
    return [
        f"{name}:{number}: {found[0]!r}; use {instead}"
        for number, line in prose
        for pattern, instead in RULES.items()
        for found in re.finditer(pattern, line, re.IGNORECASE)
    ]


def pages(root: Path) -> Iterator[Path]:
    for path in sorted([*root.glob("*.md"), *(root / "docs").rglob("*.md")]):
        name = path.relative_to(root).as_posix()
        if name not in OTHER_PAGES and not any(part in name for part in UNFINISHED):
            yield path


def test_pages_keep_the_vocabulary(root):
    found = [
        hit for path in pages(root) for hit in hits(path.relative_to(root), prose_of_page(path.read_text("utf-8")))
    ]
    assert not found, "\n".join(found)


@pytest.mark.parametrize("package", PACKAGES)
def test_packages_keep_the_vocabulary(source, package):
    modules = sorted((source / package).rglob("*.py"))
    found = [hit for path in modules for hit in hits(path.name, prose_of_module(path.read_text("utf-8")))]
    assert modules and not found, "\n".join(found)


def test_exceptions_exist_and_are_needed(root):
    for name in OTHER_PAGES:
        assert hits(name, prose_of_page((root / name).read_text("utf-8"))), f"{name} needs no exception any more"


def test_code_and_formulas_are_left_alone():
    code, formula = "```toml\n# shut\n```\n    $ shut\n", "$$\nQ_\\text{shut}\n$$\n`shut` [x](shut.md) $shut$\n"
    page = f"A valve that shuts.\n\n{code}\n{formula}"
    assert hits("page", prose_of_page(page)) == ["page:1: 'shuts'; use closed, closes (ISO 5598)"]
