"""Dictionaries as OpenFOAM reads them, from plain values."""

from collections.abc import Iterator, Mapping, Sequence
from typing import TypeAlias

Entry: TypeAlias = str | bool | int | float | Sequence["Entry"] | Mapping[str, "Entry"]
"""A text stands as it is, a truth value as yes or no, a sequence as a list, a mapping as a dictionary below its key."""
INDENT = "    "


def dictionary_text(content: Mapping[str, Entry], name: str, kind: str = "dictionary") -> str:
    """A file of OpenFOAM: the header with its `name` and class `kind`, then every entry."""
    head = {"version": "2.0", "format": "ascii", "class": kind, "object": name}
    return "\n".join([*_lines({"FoamFile": head, **content}, 0), ""])


def _lines(content: Mapping[str, Entry], depth: int) -> Iterator[str]:
    """Entries, a line each; dictionaries in braces of their own. Blanks stand round every brace."""
    indent = depth * INDENT
    for key, value in content.items():
        if isinstance(value, Mapping):
            yield f"{indent}{key}"
            yield f"{indent}{{"
            yield from _lines(value, depth + 1)
            yield f"{indent}}}"
        else:
            yield f"{indent}{key} {_token(value)};"


def _token(value: Entry) -> str:
    """A value in one line, with blanks round parentheses and braces: a word would swallow one that follows."""
    if isinstance(value, str):
        return value
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, int | float):
        return repr(value if isinstance(value, int) else float(value))  # NumPy's floats say more
    if isinstance(value, Mapping):
        return "{ " + " ".join(_inline(key, item) for key, item in value.items()) + " }"
    return "( " + " ".join(_token(item) for item in value) + " )"


def _inline(key: str, value: Entry) -> str:
    return f"{key} {_token(value)}" + ("" if isinstance(value, Mapping) else ";")
