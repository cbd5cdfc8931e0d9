"""Text of formulas: sums, calls, and lines that are not too long."""

import re
from collections.abc import Iterable, Iterator

WIDTH = 116


def added(terms: list[tuple[str, str]]) -> str:
    """A sum of signed terms as text."""
    text = " ".join(f"{sign} {term}" for sign, term in terms) or "0.0"
    return f"-{text[2:]}" if text.startswith("- ") else text.removeprefix("+ ")


def negative(term: str) -> str:
    """The negative of a term as text."""
    return term.removeprefix("-") if term.startswith("-") else f"-{term}"


def indented(lines: Iterable[str]) -> list[str]:
    """Lines, four spaces further in, and folded where they are too long."""
    return [part for line in lines for part in folded(f"    {line}")]


def bracketed(head: str, cls: type, fields: dict[str, str]) -> Iterator[str]:
    """A call with a keyword on each line."""
    if not fields:
        yield f"{head.partition('=')[0]}=NOTHING,"
        return
    yield f"{head}("
    yield from (f"    {name}={text}," for name, text in fields.items())
    yield "),"


def folded(line: str) -> list[str]:
    """A line of text, on several where it is too long: one for each argument of its call, or term of its sum."""
    if len(line) <= WIDTH or line.endswith("("):
        return [line]
    space = line[: len(line) - len(line.lstrip())]
    head, value, tail = re.fullmatch(r"(\s*(?:return |\w+ = |\w+=)?)(.*?)(,?)", line).groups()  # type: ignore[union-attr]
    terms, begin = divided(value, " + "), value.find("(")
    is_product = len(terms) == 1 and " * (" in value[: begin + 1]
    if is_product:
        terms = divided(value[begin + 1 : -1], " + ")
    if is_product or len(terms) > 1:
        inner = [f"{'+ ' if i else ''}{term}" for i, term in enumerate(terms)]
        opened = value[: begin + 1] if is_product else "("
    else:
        inner = [f"{part}," for part in divided(value[begin + 1 : -1], ", ")]
        opened = value[: begin + 1]
    parts = [text for part in inner for text in folded(f"{space}    {part}")]
    return [head + opened, *parts, f"{space}){tail}"]


def divided(text: str, mark: str) -> list[str]:
    """The parts of a text between the marks that stand in no bracket."""
    parts, depth, begin = [], 0, 0
    for place, letter in enumerate(text):
        depth += (letter in "([") - (letter in ")]")
        if depth == 0 and text.startswith(mark, place):
            parts.append(text[begin:place])
            begin = place + len(mark)
    return [*parts, text[begin:]]
