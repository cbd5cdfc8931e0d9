"""How wide texts are, so that nothing is drawn over them."""

from collections.abc import Iterable, Sequence
from textwrap import wrap

SIZE = 13.0
"""Size of the text in a diagram [px]."""
LEADING = 16.0
"""Distance of its lines [px]."""
NARROW, WIDE = frozenset("iljtfrI.,:;|'!()[] -·"), frozenset("mwMWQO@%")


def width(text: str, size: float = SIZE, bold: bool = False) -> float:
    """Width of a text in the widest of the usual sans-serif fonts."""
    units = sum(0.4 if c in NARROW else 0.95 if c in WIDE else 0.7 if c.isupper() else 0.63 for c in text)
    return size * units * (1.1 if bold else 1.0)


def extent(lines: Sequence[str]) -> tuple[float, float]:
    """Width and height of a label whose first line is bold."""
    if not lines:
        return 0.0, 0.0
    return max(width(line, bold=not i) for i, line in enumerate(lines)), LEADING * len(lines)


def wrap_parts(parts: Iterable[str], limit: int) -> list[str]:
    """The parts joined by commas to lines of at most `limit` characters; longer parts are broken at spaces."""
    lines: list[str] = []
    for part in (piece for whole in parts for piece in wrap(whole, limit, break_long_words=False) or [whole]):
        if lines and len(lines[-1]) + 2 + len(part) <= limit:
            lines[-1] += f", {part}"
        else:
            lines.append(part)
    return lines
