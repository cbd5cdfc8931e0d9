"""Symbols of hydraulic circuit diagrams in the manner of ISO 1219-1, as SVG.

Every function takes the place of the symbol in the drawing and says where its connections are. Lines are drawn in the
colour and width of the group that the symbols stand in.
"""

from collections.abc import Sequence
from html import escape

INK = "#1b1f24"
QUIET = "#5b6570"

Point = tuple[float, float]


def _n(value: float) -> str:
    return f"{value:.2f}".rstrip("0").rstrip(".")


def pipe(*points: Point, pilot: bool = False) -> str:
    """A working line through `points`; dashed as a pilot line."""
    dashes = ' stroke-dasharray="5 4" stroke-width="1.3"' if pilot else ""
    return f'<polyline points="{" ".join(f"{_n(x)},{_n(y)}" for x, y in points)}"{dashes}/>'


def junction(x: float, y: float) -> str:
    """The dot where lines are joined."""
    return f'<circle cx="{_n(x)}" cy="{_n(y)}" r="3.6" fill="{INK}" stroke="none"/>'


def filled_polygon(*points: Point) -> str:
    """A solid polygon."""
    corners = " ".join(f"{_n(x)},{_n(y)}" for x, y in points)
    return f'<polygon points="{corners}" fill="{INK}" stroke="none"/>'


def arrow_head(x: float, y: float, along: Point, size: float = 9.0) -> str:
    """A solid arrow head with its tip at (x, y), pointing along a unit vector."""
    (u, v), wide = along, 0.38 * size
    return filled_polygon(
        (x, y), (x - size * u - wide * v, y - size * v + wide * u), (x - size * u + wide * v, y - size * v - wide * u)
    )


def arrow(begin: Point, end: Point, size: float = 9.0) -> str:
    """A line with an arrow head at its end."""
    (x0, y0), (x1, y1) = begin, end
    length = ((x1 - x0) ** 2 + (y1 - y0) ** 2) ** 0.5
    along = ((x1 - x0) / length, (y1 - y0) / length)
    shaft = (x1 - 0.8 * size * along[0], y1 - 0.8 * size * along[1])
    return pipe(begin, shaft) + arrow_head(x1, y1, along, size)


def label(x: float, y: float, lines: Sequence[str], anchor: str = "start") -> str:
    """Text with its first line, the name, in bold; `anchor` is start, middle or end."""
    first, *rest = lines
    spans = f'<tspan x="{_n(x)}" font-weight="600" fill="{INK}">{escape(first)}</tspan>'
    spans += "".join(f'<tspan x="{_n(x)}" dy="17">{escape(line)}</tspan>' for line in rest)
    return f'<text x="{_n(x)}" y="{_n(y)}" text-anchor="{anchor}" fill="{QUIET}" stroke="none">{spans}</text>'


def letter(x: float, y: float, text: str, size: float = 15.0) -> str:
    """A letter inside a symbol or beside a port, centred on (x, y)."""
    return (
        f'<text x="{_n(x)}" y="{_n(y + 0.35 * size)}" text-anchor="middle" font-size="{_n(size)}" fill="{INK}" '
        f'stroke="none">{escape(text)}</text>'
    )


def tank(x: float, y: float) -> str:
    """A tank; the line ends in it at (x, y)."""
    return pipe((x - 22, y - 9), (x - 22, y + 11), (x + 22, y + 11), (x + 22, y - 9))


def pump(x: float, y: float) -> str:
    """A pump of fixed displacement with centre (x, y): outlet at (x, y - 30), suction at (x, y + 30)."""
    return f'<circle cx="{_n(x)}" cy="{_n(y)}" r="30"/>' + filled_polygon(
        (x, y - 30), (x - 10, y - 13), (x + 10, y - 13)
    )


def electric_motor(x: float, y: float) -> str:
    """An electric motor with centre (x, y); its shaft leaves at (x + 26, y)."""
    return f'<circle cx="{_n(x)}" cy="{_n(y)}" r="26"/>' + letter(x, y, "M", 20)


def shaft(x0: float, x1: float, y: float) -> str:
    """A turning shaft between x0 and x1, with the arrow of its rotation."""
    middle = 0.5 * (x0 + x1)
    lines = pipe((x0, y - 3), (x1, y - 3)) + pipe((x0, y + 3), (x1, y + 3))
    turn = f'<path d="M {_n(middle - 3)} {_n(y - 15)} A 15 15 0 0 1 {_n(middle - 1)} {_n(y + 13)}" stroke-width="1.4"/>'
    return lines + turn + arrow_head(middle - 4, y + 16, (-0.72, 0.69), 8)


def spring(x0: float, x1: float, y: float) -> str:
    """A spring between x0 and x1 at height y."""
    step = (x1 - x0) / 6
    return pipe((x0, y), *((x0 + step * (i + 0.5), y + (8 if i % 2 else -8)) for i in range(6)), (x1, y))


def relief_valve(x: float, y: float) -> str:
    """A relief valve with centre (x, y): inlet at (x, y - 24), outlet at (x, y + 24), piloted from (x, y - 44)."""
    box = f'<rect x="{_n(x - 24)}" y="{_n(y - 24)}" width="48" height="48"/>'
    piloted = pipe((x, y - 44), (x - 40, y - 44), (x - 40, y), (x - 24, y), pilot=True)
    setting = spring(x + 24, x + 52, y) + arrow((x + 28, y + 17), (x + 50, y - 17), 8)
    return box + arrow((x - 9, y - 24), (x - 9, y + 24)) + piloted + setting


def rotary_valve(x: float, y: float) -> str:
    """A 3-way valve of two positions that a rotating spool runs through, with the boxes' common edge at (x, y).

    The lines stand on the right box: load port A at (x + 18, y - 32), pump P at (x + 18, y + 32), tank T at
    (x + 46, y + 32). Right, P goes to A; left, P goes to T. Drives join at (x - 64, y) and (x + 64, y).
    """
    ports = letter(x + 8, y - 41, "A", 12) + letter(x + 8, y + 42, "P", 12) + letter(x + 58, y + 42, "T", 12)
    return rotary_valve_body(x, y) + ports


def rotary_valve_body(x: float, y: float) -> str:
    """The boxes of `rotary_valve` without the letters of its ports."""
    boxes = "".join(f'<rect x="{_n(left)}" y="{_n(y - 32)}" width="64" height="64"/>' for left in (x - 64, x))
    to_load = arrow((x + 18, y + 32), (x + 18, y - 32)) + blocked_port(x + 46, y + 32, up=True)
    to_tank = pipe((x - 46, y + 32), (x - 46, y + 2), (x - 18, y + 2), (x - 18, y + 24))
    to_tank += arrow_head(x - 18, y + 32, (0, 1)) + blocked_port(x - 46, y - 32, up=False)
    return boxes + to_load + to_tank


def blocked_port(x: float, y: float, *, up: bool) -> str:
    """A closed port at the edge (x, y) of a valve's box."""
    inner = y - 11 if up else y + 11
    return pipe((x, y), (x, inner)) + pipe((x - 7, inner), (x + 7, inner))


def rotary_drive(x: float, y: float) -> str:
    """The mark of a spool that turns on and on, to the left of a valve whose edge is at (x, y); 46 wide."""
    turn = f'<path d="M {_n(x - 15.5)} {_n(y - 9.5)} A 12 12 0 1 0 {_n(x - 11)} {_n(y + 1.5)}"/>'
    box = f'<rect x="{_n(x - 46)}" y="{_n(y - 20)}" width="46" height="40"/>'
    return box + turn + arrow_head(x - 10.6, y - 4.5, (0.1, -1.0), 8)


def set_position(x: float, y: float) -> str:
    """The mark of a spool that is set along its axis, to the right of a valve whose edge is at (x, y); 46 wide."""
    box = f'<rect x="{_n(x)}" y="{_n(y - 20)}" width="46" height="40"/>'
    both = arrow((x + 23, y), (x + 39, y), 7) + arrow((x + 23, y), (x + 7, y), 7)
    return box + both + pipe((x + 7, y - 9), (x + 7, y + 9)) + pipe((x + 39, y - 9), (x + 39, y + 9))


def check_valve(x: float, y: float) -> str:
    """A check valve with centre (x, y) in a line from left, (x - 18, y), to right, (x + 18, y)."""
    ball = f'<circle cx="{_n(x - 4)}" cy="{_n(y)}" r="8"/>'
    seat = pipe((x - 6, y - 14), (x - 17, y), (x - 6, y + 14))
    return ball + seat + pipe((x - 18, y), (x - 17, y)) + pipe((x + 4, y), (x + 18, y))


def hose(x0: float, x1: float, y: float) -> str:
    """A flexible hose between two points on one height."""
    middle, sag = 0.5 * (x0 + x1), 30
    curve = f'<path d="M {_n(x0)} {_n(y)} Q {_n(middle)} {_n(y + 2 * sag)} {_n(x1)} {_n(y)}"/>'
    return curve + junction(x0, y) + junction(x1, y)


def accumulator(x: float, y: float) -> str:
    """An accumulator with its gas behind a bladder, standing on its connection (x, y); 62 high, 30 wide."""
    body = f'<rect x="{_n(x - 15)}" y="{_n(y - 62)}" width="30" height="62" rx="15"/>'
    bladder = pipe((x - 15, y - 27), (x + 15, y - 27))
    gas = (
        f'<polygon points="{_n(x)},{_n(y - 34)} {_n(x - 7)},{_n(y - 47)} {_n(x + 7)},{_n(y - 47)}" stroke-width="1.3"/>'
    )
    return body + bladder + gas


def gauge(x: float, y: float) -> str:
    """A pressure gauge standing on its connection (x, y); 36 high."""
    return f'<circle cx="{_n(x)}" cy="{_n(y - 18)}" r="18"/>' + arrow((x + 9, y - 9), (x - 10, y - 28), 8)


def throttle(x: float, y: float, *, adjustable: bool = False) -> str:
    """An orifice with centre (x, y) in a vertical line from (x, y - 26) to (x, y + 26)."""
    left = f'<path d="M {_n(x - 13)} {_n(y - 15)} Q {_n(x - 1)} {_n(y)} {_n(x - 13)} {_n(y + 15)}"/>'
    right = f'<path d="M {_n(x + 13)} {_n(y - 15)} Q {_n(x + 1)} {_n(y)} {_n(x + 13)} {_n(y + 15)}"/>'
    hand = arrow((x - 20, y + 20), (x + 20, y - 20), 8) if adjustable else ""
    return left + right + pipe((x, y - 26), (x, y + 26)) + hand


def pressure_source(x: float, y: float) -> str:
    """A source that holds a pressure, standing on its connection (x, y) with the line coming from above."""
    return (
        f'<circle cx="{_n(x)}" cy="{_n(y + 26)}" r="26"/>'
        + filled_polygon((x, y), (x - 10, y + 17), (x + 10, y + 17))
        + letter(x, y + 33, "p", 17)
    )
