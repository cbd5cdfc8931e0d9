"""Text of formulas: sums, calls, and lines that are not too long."""

import re
from collections.abc import Iterable, Iterator
from functools import lru_cache

WIDTH = 116


def signed_sum(terms: list[tuple[str, str]]) -> str:
    """A sum of signed terms as text."""
    text = " ".join(f"{sign} {term}" for sign, term in terms) or "0.0"
    return f"-{text[2:]}" if text.startswith("- ") else text.removeprefix("+ ")


def negative(term: str) -> str:
    """The negative of a term as text."""
    return term.removeprefix("-") if term.startswith("-") else f"-{term}"


def indent(lines: Iterable[str]) -> list[str]:
    """Lines, four spaces further in, and folded where they are too long."""
    return [part for line in lines for part in fold(f"    {line}")]


def keyword_call(head: str, cls: type, fields: dict[str, str]) -> Iterator[str]:
    """A call with a keyword on each line."""
    if not fields:
        yield f"{head.partition('=')[0]}=NOTHING,"
        return
    yield f"{head}("
    yield from (f"    {name}={text}," for name, text in fields.items())
    yield "),"


@lru_cache(maxsize=4096)
def fold(line: str) -> tuple[str, ...]:
    """A line of text, on several where it is too long: one for each argument of a call, term of a sum, or factor."""
    if len(line) <= WIDTH or line.endswith("("):
        return (line,)
    space = line[: len(line) - len(line.lstrip())]
    head, value, tail = re.fullmatch(r"(\s*(?:return |\w+ = |\w+=)?)(.*?)(,?)", line).groups()  # type: ignore[union-attr]
    terms, (begin, end) = split_at(value, (" + ", " - ")), first_bracket(value)
    opened, closed = "(", ")"
    if len(terms) == 1 and end:
        inside, opened, closed = value[begin + 1 : end], value[: begin + 1], value[end:]
        is_call = begin > 0 and (value[begin - 1].isalnum() or value[begin - 1] == "_")
        terms = [] if is_call else split_at(inside, (" + ", " - "))
        if is_call:
            terms = [f"{part.removeprefix(', ')}," for part in split_at(inside, (", ",))]
    if len(terms) < 2:
        terms, opened, closed = split_at(value, (" * ",)), "(", ")"
    if len(terms) < 2:
        return (line,)
    folds = [text for term in terms for text in fold(f"{space}    {term.lstrip()}")]
    return (head + opened, *folds, f"{space}{closed}{tail}")


def first_bracket(text: str) -> tuple[int, int]:
    """Where the first bracket of a text opens and closes; 0 and 0 without one."""
    depth = 0
    begin = text.find("(")
    for place in range(max(begin, 0), len(text)):
        depth += (text[place] == "(") - (text[place] == ")")
        if depth == 0 and begin >= 0:
            return begin, place
    return 0, 0


def split_at(text: str, marks: tuple[str, ...]) -> list[str]:
    """The parts of a text before the marks that stand in no bracket; each but the first begins with its mark."""
    parts, depth, begin = [], 0, 0
    for place, letter in enumerate(text):
        depth += (letter in "([") - (letter in ")]")
        if depth == 0 and place > begin and text.startswith(marks, place):
            parts.append(text[begin:place])
            begin = place
    return [*parts, text[begin:]]
