"""The words of the project: what pages, code, messages and help do not say, and what they say instead.

A rule is a pattern and its replacement. To add a rule, mend its hits first. Code, formulas and links are not looked at.
"""

import ast
import io
import re
import tokenize
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path

from tests.contracts.conftest import tree_of

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
    r"\btold\b|\btells?\b": "reported, given, known from; shows, distinguishes",
    r"\b(?:says so|is said)\b": "states, reports; is stated",
    r"\bswivel(?:s|led|ling)\b": "stroke, destroke; displacement ratio",
    r"\bwhole or absent\b": "complete or not there",
    r"\b(?:error|estimate|position|drawn) less (?:the|truth|reference|returned)\b": "minus",
    r"\bwhat (?:it|they|a \w+|the \w+|\w+) comes? to\b": "result",
    r"\bdear end\b|\breckon\w*\b|\bfree sight\b|\blet rest\b|\bhands on the cylinder\b": "no metaphor, no archaism",
    r"\b(?:lest|whence|thence|thereof|wherein|therein|hitherto|upon|for ever)\b": "no archaism",
    r"\ba person\b": "you, the user",
    r"\bin the place of\b": "instead of",
    r"\bturn(?:s|ed)? to heat\b": "dissipates, dissipated",
    r"\bpower put in\b|\bgiven to the outside\b": "input power; output power",
    r"\b(?:in|into|out of) store\b": "stored energy; is stored",
    r"\bhears?\b|\bheard\b|\bin sight\b": "receives, detects; things do not hear or see",
    r"\blost speeds?\b": "unobservable speed",
    r"\b(?:of it noise|rests on what is assumed|held to evaporate|chance density)\b": "a label that stands alone",
    r"\bassisting load\b": "overrunning load",
    r"\bremarks?\b": "note (info), warning, error",
}
OTHER_PAGES = {
    "CHANGELOG.md": "reports keys and labels as they were called then",
    "docs/errata.md": "made from rows that quote the sources",
    "docs/programs.md": "its table has the names of commands as files have them",
}
"""Pages that are not looked at, with the reason."""
NAMES_AS_STORED = "pollution, swivels, told, heard, set point, remark, return throttle"
"""Words that names keep: they are parts of keys in files and results, or short names inside of one function."""
SILENT = re.compile(r"`[^`]*`|\"tuple\[[^\"]*\"|\$[^$]*\$|\]\([^)]*\)|\{[^{}]*\}")


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
    """Number and words of each line of the docstrings, comments and texts with a space in a module."""
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type == tokenize.COMMENT or (token.type == tokenize.STRING and " " in token.string):
            for n, line in enumerate(token.string.splitlines()):
                yield token.start[0] + n, SILENT.sub(" ", line)


def names_of_module(tree: ast.AST) -> Iterator[tuple[int, str]]:
    """Line and words of each name that a module gives to a function, class, argument or variable."""
    for node in ast.walk(tree):
        match node:
            case ast.FunctionDef(name=name) | ast.ClassDef(name=name) | ast.arg(arg=name):
                yield node.lineno, re.sub(r"(?<=[a-z])(?=[A-Z])|_", " ", name)
            case ast.Name(id=name, ctx=ast.Store()):
                yield node.lineno, re.sub(r"(?<=[a-z])(?=[A-Z])|_", " ", name)


def hits(name: object, prose: Iterable[tuple[int, str]], rules: Mapping[str, str] = RULES) -> list[str]:
    any_rule = re.compile("|".join(rules), re.IGNORECASE)
    return [
        f"{name}:{number}: {found[0]!r}; use {instead}"
        for number, line in prose
        if any_rule.search(line)
        for pattern, instead in rules.items()
        for found in re.finditer(pattern, line, re.IGNORECASE)
    ]


def pages(root: Path) -> Iterator[Path]:
    for path in sorted([*root.glob("*.md"), *(root / "docs").rglob("*.md")]):
        name = path.relative_to(root).as_posix()
        if name not in OTHER_PAGES:
            yield path


def test_pages_keep_the_vocabulary(root):
    found = [
        hit for path in pages(root) for hit in hits(path.relative_to(root), prose_of_page(path.read_text("utf-8")))
    ]
    assert not found, "\n".join(found)


def test_notebooks_keep_the_vocabulary(root):
    """Their scripts: the notebooks are made from them."""
    scripts = sorted((root / "docs" / "notebooks").glob("*.py"))
    found = [hit for path in scripts for hit in hits(path.name, prose_of_module(path.read_text("utf-8")))]
    assert not found, "\n".join(found)
    assert len(scripts) >= 5


def test_code_keeps_the_vocabulary(source):
    found, lines = [], 0
    for path in sorted(source.rglob("*.py")):
        prose = list(prose_of_module(path.read_text("utf-8")))
        found += hits(path.relative_to(source), prose)
        lines += len(prose)
    assert not found, "\n".join(found)
    assert lines > 10_000


def test_names_keep_the_vocabulary(source):
    found, rules = [], {rule: use for rule, use in RULES.items() if not re.search(rule, NAMES_AS_STORED)}
    for path in sorted(source.rglob("*.py")):
        found += hits(path.relative_to(source), names_of_module(tree_of(path)), rules)
    assert not found, "\n".join(found)


def test_exceptions_exist_and_are_needed(root):
    for name in OTHER_PAGES:
        assert hits(name, prose_of_page((root / name).read_text("utf-8"))), f"{name} needs no exception any more"


def test_code_and_formulas_are_left_alone():
    code, formula = "```toml\n# shut\n```\n    $ shut\n", "$$\nQ_\\text{shut}\n$$\n`shut` [x](shut.md) $shut$\n"
    page = f"A valve that shuts.\n\n{code}\n{formula}"
    assert hits("page", prose_of_page(page)) == ["page:1: 'shuts'; use closed, closes (ISO 5598)"]
