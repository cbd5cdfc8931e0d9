"""Docstrings as Markdown: aligned arguments become a table, formulas a block, the source a line of its own."""

import re
from typing import Any

from griffe import Extension, Object

ARGUMENT = re.compile(r"^(\w[\w, ]*?) {2,}(\S.*)$")
PAGE = re.compile(r"\bdocs/([\w/-]+)\.md")
CODE = re.compile(r"^(?:>>> |import |\w+ = \w+\.\w+\()")
FORMULA = re.compile(r"^\S.* = |^[^a-z]*[\w ]*[*/^√∫]|\bsqrt\(")


class PlainDocstrings(Extension):
    """Changes every docstring before it is shown."""

    def on_instance(self, *, obj: Object, **kwargs: Any) -> None:  # noqa: ARG002 - Griffe's signature
        """Called for each module, class, function and attribute."""
        if obj.docstring:
            obj.docstring.value = markdown(obj.docstring.value)


def markdown(text: str) -> str:
    """A docstring of this project as Markdown."""
    paragraphs = re.split(r"\n\s*\n", text.strip("\n"))
    return PAGE.sub(r"[\g<0>](../../\1.md)", "\n\n".join(_paragraph(each.strip("\n")) for each in paragraphs))


def _paragraph(text: str) -> str:
    lines = text.splitlines()
    head, _, rest = text.partition("  ")
    if head in ("Source", "Holds", "Error"):
        return f"*{head}:* " + " ".join(rest.split())
    if CODE.match(text):
        return "```python\n" + text + "\n```"
    if ARGUMENT.match(lines[0]):
        return _table(lines)
    if len(lines) <= 3 and FORMULA.search(lines[0]) and not lines[0].endswith("."):
        return "```text\n" + text + "\n```"
    return text


def _table(lines: list[str]) -> str:
    rows: list[list[str]] = []
    for line in lines:
        match = ARGUMENT.match(line)
        if match:
            rows.append([match[1], match[2]])
        else:
            rows[-1][1] += " " + line.strip()
    body = [f"| `{name}` | {meaning.replace('|', chr(92) + '|')} |" for name, meaning in rows]
    return "\n".join(["| argument | |", "| --- | --- |", *body])
