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
    terms, begin = divided(value, (" + ", " - ")), value.find("(")
    inside, is_whole = value[begin + 1 : -1], begin >= 0 and len(divided(value[begin:], (" ",))) == 1
    if len(terms) > 1:
        inner, opened = [term.lstrip() for term in terms], "("
    elif is_whole and (begin == 0 or value[:begin].endswith(" * ")):
        inner, opened = [term.lstrip() for term in divided(inside, (" + ", " - "))], value[: begin + 1]
    elif is_whole:
        inner = [f"{part.removeprefix(', ')}," for part in divided(inside, (", ",))]
        opened = value[: begin + 1]
    else:
        return [line]
    folds = [text for part in inner for text in folded(f"{space}    {part}")]
    return [head + opened, *folds, f"{space}){tail}"]


def divided(text: str, marks: tuple[str, ...]) -> list[str]:
    """The parts of a text before the marks that stand in no bracket; each but the first begins with its mark."""
    parts, depth, begin = [], 0, 0
    for place, letter in enumerate(text):
        depth += (letter in "([") - (letter in ")]")
        if depth == 0 and place > begin and text.startswith(marks, place):
            parts.append(text[begin:place])
            begin = place
    return [*parts, text[begin:]]
