"""The lines that leave a symbol: straight where they can, else around it through lanes beside it."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

from vvdp.report.symbol import Box, Side, Terminal

Point = tuple[float, float]
LANE, LEAD, TRACK = 11.0, 12.0, 8.0
"""Distance of lanes, how far a line leaves a symbol straight, and distance of lines above or below it [px]."""
TANK_WIDTH, TANK_HEIGHT = 12.0, 16.0
"""Half the width of a tank and what it needs below the end of its line [px]."""


@dataclass(frozen=True)
class Lead:
    """The line of a port from its terminal to where it goes up or down to its node, or to a tank of its own."""

    owner: str
    port: str
    node: str
    points: tuple[Point, ...]
    up: bool
    tank: bool = False
    pilot: bool = False

    @property
    def x(self) -> float:
        """Where it goes up or down."""
        return self.points[-1][0]


@dataclass(frozen=True)
class Exit:
    """A port to be led away: its node, its terminal, and whether the node is above or a tank."""

    port: str
    node: str
    terminal: Terminal
    up: bool
    tank: bool
    pilot: bool

    @property
    def is_sideways(self) -> bool:
        """Whether it leaves the symbol to the left or right."""
        return self.terminal.side in (Side.LEFT, Side.RIGHT)

    @property
    def is_straight(self) -> bool:
        """Whether it leaves the symbol toward its node."""
        return not self.is_sideways and (self.terminal.side is Side.TOP) == self.up


@dataclass
class Lanes:
    """The lanes to the left and right of a symbol, and the lines above and below it, as they are taken."""

    inner: Box
    below: float
    lane: dict[Side, float] = field(default_factory=dict)
    track: dict[Side, float] = field(default_factory=dict)

    def way(self, given: Exit, side: Side) -> tuple[Point, ...]:
        """The way from a terminal to the next lane on a side."""
        outward = 1.0 if side is Side.RIGHT else -1.0
        x = self.lane.get(side, self.inner[2 if side is Side.RIGHT else 0])
        x += outward * (LANE + 6.0 if given.tank else LANE)
        self.lane[side] = x + outward * (10.0 if given.tank else 0.0)
        begin = (given.terminal.x, given.terminal.y)
        if given.is_sideways:
            return begin, (x, begin[1])
        top = given.terminal.side is Side.TOP
        y = self.track.get(given.terminal.side, self.inner[1] - LEAD if top else self.below)
        self.track[given.terminal.side] = y - TRACK if top else y + TRACK
        return begin, (begin[0], y), (x, y)


def lead_lines(owner: str, exits: Iterable[Exit], inner: Box, to_right: bool) -> tuple[Lead, ...]:
    """The lines of a symbol in the order of its ports; `inner` holds the symbol and its label.

    What must go around the symbol goes on the nearer side, or all on the right where `to_right`.
    """
    exits = list(exits)
    tanks = any(each.tank for each in exits)
    lanes = Lanes(inner, inner[3] + (LEAD + TANK_HEIGHT if tanks else LEAD))
    middle = 0.5 * (inner[0] + inner[2])
    lowest = max((each.terminal.y + LEAD for each in exits if each.is_sideways), default=inner[1])
    found: dict[str, Lead] = {}
    for each in _in_order(exits, middle):
        t = each.terminal
        points: tuple[Point, ...] = ((t.x, t.y),)
        if not each.is_straight:
            right = t.side is Side.RIGHT or (t.side is not Side.LEFT and (t.x > middle or to_right))
            points = lanes.way(each, Side.RIGHT if right else Side.LEFT)
        if each.tank:
            down = points[-1][1] + LEAD if each.is_straight else max(points[-1][1] + LEAD, inner[3] - LEAD, lowest)
            points = (*points, (points[-1][0], down))
        found[each.port] = Lead(
            owner=owner,
            port=each.port,
            node=each.node,
            points=points,
            up=each.up,
            tank=each.tank,
            pilot=each.pilot,
        )
    return tuple(found[each.port] for each in exits)


def _in_order(exits: Sequence[Exit], middle: float) -> list[Exit]:
    """Exits in the order in which they take lanes, the inner ones first, so that lines beside a symbol do not cross."""
    sideways = [each for each in exits if each.is_sideways]
    corner = [each for each in exits if not each.is_sideways and not each.is_straight]
    return [
        *(each for each in exits if each.is_straight),
        *sorted((each for each in sideways if not each.up), key=lambda each: -each.terminal.y),
        *sorted((each for each in sideways if each.up), key=lambda each: each.terminal.y),
        *sorted(corner, key=lambda each: -abs(each.terminal.x - middle)),
    ]


def reach(lead: Lead) -> Box:
    """The box around a line and the tank at its end."""
    xs, ys = [x for x, _ in lead.points], [y for _, y in lead.points]
    if lead.tank:
        return min(*xs, lead.x - TANK_WIDTH), min(ys), max(*xs, lead.x + TANK_WIDTH), max(ys) + TANK_HEIGHT
    return min(xs) - 3, min(ys), max(xs) + 3, max(ys)
