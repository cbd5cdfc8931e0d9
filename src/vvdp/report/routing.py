"""The heights of a diagram: bands of symbols, the lines of nodes between them, and where the nodes' names stand."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise, permutations

from vvdp.report.blocks import Block, Label, Piece
from vvdp.report.leads import Lead, Point
from vvdp.report.lettering import extent
from vvdp.report.symbol import Box

MARGIN, CLEAR, TRACK = 14.0, 9.0, 20.0
"""Around the drawing, between bands and lines, and between lines of one level [px]."""


@dataclass(frozen=True)
class Wire:
    """The drawn line from a component's port to its node, or to a tank that is drawn at its end."""

    owner: str
    port: str
    node: str
    points: tuple[Point, ...]
    tank: bool
    pilot: bool = False


@dataclass
class Rail:
    """The junction line of a node."""

    node: str
    level: int
    tops: list[float] = field(default_factory=list)
    """Where lines come from above."""
    bottoms: list[float] = field(default_factory=list)
    """Where lines come from below."""
    y: float = 0.0
    more: tuple[float, ...] = ()
    """Further places it reaches, for its name."""

    @property
    def ends(self) -> tuple[float, float]:
        """Its left and right end."""
        xs = [*self.tops, *self.bottoms, *self.more]
        return min(xs), max(xs)


@dataclass(frozen=True)
class Plan:
    """A diagram with the place of everything."""

    width: float
    height: float
    pieces: tuple[Piece, ...]
    links: tuple[tuple[Point, ...], ...]
    wires: tuple[Wire, ...]
    rails: tuple[Rail, ...]
    names: Mapping[str, Label]
    """The labels of the rails, by node."""


def plan(
    blocks: Sequence[Block], level: Mapping[str, int], places: Sequence[float], texts: Mapping[str, Sequence[str]]
) -> Plan:
    """Everything in its place; `places` are the x of blocks, `texts` the labels of nodes that are drawn as lines."""
    rails = _rails(blocks, level, places)
    tracks = {lv: _tracks([r for r in rails.values() if r.level == lv]) for lv in sorted({*level.values()})}
    axes, height = _heights(blocks, tracks, texts)
    pieces, links, wires = [], [], []
    for block, x in zip(blocks, places, strict=True):
        y = axes[block.band]
        pieces += [piece.translate(x, y) for piece in block.pieces]
        links += [tuple((a + x, b + y) for a, b in link) for link in block.links]
    for piece in pieces:
        wires += [_wire(lead, rails) for lead in piece.leads]
    names = _names(rails, pieces, wires, texts)
    boxes = [*(piece.box for piece in pieces), *(label.box for label in names.values())]
    left = min([0.0, *(box[0] for box in boxes), *(r.ends[0] for r in rails.values())])
    right = max([0.0, *(box[2] for box in boxes), *(r.ends[1] for r in rails.values())])
    made = Plan(
        width=right - left,
        height=height,
        pieces=tuple(pieces),
        links=tuple(links),
        wires=tuple(wires),
        rails=tuple(rails.values()),
        names=names,
    )
    return _shift(made, MARGIN - left, MARGIN)


def _shift(given: Plan, dx: float, dy: float) -> Plan:
    def to(point: Point) -> Point:
        return point[0] + dx, point[1] + dy

    for rail in given.rails:
        rail.y += dy
        rail.tops, rail.bottoms = [x + dx for x in rail.tops], [x + dx for x in rail.bottoms]
        rail.more = tuple(x + dx for x in rail.more)
    names = {
        node: Label(label.lines, (label.box[0] + dx, label.box[1] + dy, label.box[2] + dx, label.box[3] + dy))
        for node, label in given.names.items()
    }
    return Plan(
        width=given.width + 2 * MARGIN,
        height=given.height + 2 * MARGIN,
        pieces=tuple(piece.translate(dx, dy) for piece in given.pieces),
        links=tuple(tuple(to(p) for p in link) for link in given.links),
        wires=tuple(replace(wire, points=tuple(to(p) for p in wire.points)) for wire in given.wires),
        rails=given.rails,
        names=names,
    )


def _rails(blocks: Sequence[Block], level: Mapping[str, int], places: Sequence[float]) -> dict[str, Rail]:
    rails: dict[str, Rail] = {}
    for block, x in zip(blocks, places, strict=True):
        for lead in block.leads:
            if not lead.tank:
                rail = rails.setdefault(lead.node, Rail(lead.node, level[lead.node]))
                (rail.bottoms if lead.up else rail.tops).append(round(x + lead.x, 3))
    return rails


def _tracks(rails: list[Rail]) -> list[list[Rail]]:
    """The rails of a level as rows from the top, in the order with the fewest crossings."""
    orders = permutations(rails) if len(rails) <= 5 else iter([tuple(rails)])
    return min((_pack(order) for order in orders), key=_crossings, default=[])


def _pack(order: Sequence[Rail]) -> list[list[Rail]]:
    rows: list[list[Rail]] = []
    for rail in order:
        begin, end = rail.ends
        free = rows and all(end + 30 < other.ends[0] or begin > other.ends[1] + 30 for other in rows[-1])
        if free:
            rows[-1].append(rail)
        else:
            rows.append([rail])
    return rows


def _crossings(rows: Sequence[Sequence[Rail]]) -> tuple[int, int]:
    """How often lines to the rails cross other rails of the level, and the number of rows."""
    count = 0
    for i, upper in enumerate(rows):
        for lower in rows[i + 1 :]:
            for a in upper:
                for b in lower:
                    count += sum(b.ends[0] <= x <= b.ends[1] for x in a.bottoms)
                    count += sum(a.ends[0] <= x <= a.ends[1] for x in b.tops)
    return count, len(rows)


def _heights(
    blocks: Sequence[Block], tracks: Mapping[int, list[list[Rail]]], texts: Mapping[str, Sequence[str]]
) -> tuple[dict[int, float], float]:
    """The axis of each band and the height of all; sets the heights of the rails."""
    axes: dict[int, float] = {}
    y = 0.0
    for band in range(max([b.band for b in blocks] + [lv + 1 for lv in tracks], default=0), -1, -1):
        boxes = [block.box for block in blocks if block.band == band]
        above, below = max([-b[1] for b in boxes], default=0.0), max([b[3] for b in boxes], default=0.0)
        axes[band] = y + max(above, 0.0)
        y = axes[band] + max(below, 0.0)
        for row in tracks.get(band - 1, []):
            labels = [extent(texts.get(rail.node, ()))[1] for rail in row]
            y += CLEAR + max([TRACK - CLEAR, *(high + 6.0 if high else 0.0 for high in labels)])
            for rail in row:
                rail.y = y
        y += CLEAR + 3.0 if tracks.get(band - 1) else 0.0
    return axes, y


def _wire(lead: Lead, rails: Mapping[str, Rail]) -> Wire:
    end = () if lead.tank else ((lead.x, rails[lead.node].y),)
    points = (*lead.points, *end)
    return Wire(owner=lead.owner, port=lead.port, node=lead.node, points=points, tank=lead.tank, pilot=lead.pilot)


def _names(
    rails: Mapping[str, Rail], pieces: Sequence[Piece], wires: Sequence[Wire], texts: Mapping[str, Sequence[str]]
) -> dict[str, Label]:
    """A label for each rail that has a text, above it where nothing else is; the rail is lengthened to reach it."""
    found: dict[str, Label] = {}
    for node, rail in rails.items():
        lines = texts.get(node, ())
        if not lines:
            continue
        wide, high = extent(lines)
        x = _free(rail, (wide, high), rails, pieces, wires, [label.box for label in found.values()])
        found[node] = Label(tuple(lines), (x, rail.y - 4 - high, x + wide, rail.y - 4))
        begin, end = rail.ends
        if x in (end + 7, begin - wide - 7):
            continue
        if x > end - 12:
            rail.more = (x + wide,)
        elif x + wide < begin + 12:
            rail.more = (x,)
    return found


def _free(
    rail: Rail,
    size: tuple[float, float],
    rails: Mapping[str, Rail],
    pieces: Sequence[Piece],
    wires: Sequence[Wire],
    taken: Sequence[Box],
) -> float:
    """Where a label above a rail stands free, on the rail where it can, else as near as possible."""
    (begin, end), (wide, high) = rail.ends, size
    segments = [(*a, *b) for wire in wires for a, b in pairwise(wire.points)]
    segments += [(*_span(other), other.y) for other in rails.values() if other is not rail]
    solid = [*taken, *(piece.box for piece in pieces)]

    def is_blocked(x: float) -> bool:
        box = (x - 5, rail.y - high - 5, x + wide + 5, rail.y - 1)
        return any(_cut(s, box) for s in segments) or any(overlap(box, other) for other in solid)

    first = begin + 7.0
    tries = [first + 4.0 * i for i in range(int(max(0.0, end - begin - wide) // 4.0) + 1)]
    further = [x for i in range(400) for x in (end + 7 + 4.0 * i, begin - wide - 7 - 4.0 * i)]
    return next((x for x in [*tries, *further] if not is_blocked(x)), end + 7)


def _span(rail: Rail) -> tuple[float, float, float]:
    return rail.ends[0], rail.y, rail.ends[1]


def _cut(segment: tuple[float, float, float, float], box: Box) -> bool:
    x0, y0, x1, y1 = segment
    return overlap((min(x0, x1), min(y0, y1), max(x0, x1), max(y0, y1)), box, True)


def overlap(a: Box, b: Box, closed: bool = False) -> bool:
    """Whether two boxes have common area, or a common edge where `closed`."""
    if closed:
        return a[0] <= b[2] and b[0] <= a[2] and a[1] <= b[3] and b[1] <= a[3]
    return a[0] < b[2] and b[0] < a[2] and a[1] < b[3] and b[1] < a[3]
