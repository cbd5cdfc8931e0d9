"""The order of blocks from left to right and their places, so that lines are short and cross little."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial

from vvdp.report.blocks import Block
from vvdp.report.leads import Lead

GAP, NEAR, STEP = 22.0, 13.0, 16.0
"""Space between blocks; verticals of different nodes are further apart than NEAR; a block steps aside by STEP [px]."""
CROSSING, BACKWARD, PINNED = 130.0, 2.0, 50.0
"""What a crossing, a flow to the left and a missed position cost, in px of length."""
ASIDE = 30.0
"""How far a block may stand out beyond the others where that makes a line straight [px]."""
STRAIGHT, JOG = 8.0, 25.0
"""What a straight line gains and a small step costs [px]."""
FEW = 14
"""Up to so many blocks any block is tried at any place, above only beside its neighbours."""


class Occupied:
    """Blocks with what they occupy: from where to where in each band, and the lines that lead out of them."""

    def __init__(self, blocks: Sequence[Block], level: Mapping[str, int]) -> None:
        self.blocks, self.level = blocks, level
        self.spans = [spans(block, level) for block in blocks]
        self.leads = [[lead for lead in block.leads if not lead.tank] for block in blocks]

    def compact(self, order: Sequence[int]) -> list[float]:
        """The blocks as far to the left as they go in that order."""
        edge: dict[int, float] = {}
        places = [0.0] * len(self.blocks)
        placed: list[int] = []
        for i in order:
            x = max([0.0, *(edge[b] + GAP - low for b, (low, _) in self.spans[i].items() if b in edge)])
            x = max([x, *(-low for b, (low, _) in self.spans[i].items() if b not in edge)])
            places[i] = max(x, self.blocks[i].column or 0.0)
            while any(self.touch(i, places[i], j, places[j]) for j in placed):
                places[i] += STEP
            placed.append(i)
            for band, (_, high) in self.spans[i].items():
                edge[band] = places[i] + high
        return places

    def touch(self, i: int, x: float, j: int, y: float) -> bool:
        """Whether lines of two blocks that belong to different nodes would run over each other."""
        return any(
            abs(x + a.x - y - b.x) < NEAR and a.node != b.node and self._meet(i, a, j, b)
            for a in self.leads[i]
            for b in self.leads[j]
        )

    def _meet(self, i: int, a: Lead, j: int, b: Lead) -> bool:
        (low, high), (lower, higher) = self.crossed_levels(i, a), self.crossed_levels(j, b)
        return low <= higher and lower <= high

    def crossed_levels(self, i: int, lead: Lead) -> tuple[int, int]:
        """The lowest and highest level that a line reaches."""
        band, level = self.blocks[i].band, self.level[lead.node]
        return (band, level) if lead.up else (level, band - 1)

    def leads_of(self, node: str) -> Iterator[tuple[int, Lead]]:
        """The lines to a node, each with its block."""
        for i, leads in enumerate(self.leads):
            for lead in leads:
                if lead.node == node:
                    yield i, lead

    def width(self, places: Sequence[float]) -> float:
        """The right end of the blocks at these places [px]."""
        highs = [x + high for x, span in zip(places, self.spans, strict=True) for _, high in span.values()]
        return max(highs, default=0.0)


def place_blocks(blocks: Sequence[Block], level: Mapping[str, int], sends: frozenset[tuple[str, str]]) -> list[float]:
    """The x of each block; `sends` are (component, port) through which flow leaves."""
    these = Occupied(blocks, level)
    order = _best_order(these, sends)
    places = these.compact(order)
    width = these.width(places)
    for sweep in range(10):
        for i in order if sweep % 2 else reversed(order):
            places[i] = _best_place(these, i, order, places, width)
    return places


def _best_order(these: Occupied, sends: frozenset[tuple[str, str]]) -> list[int]:
    """The blocks from left to right."""
    order, cost_of = _first_order(these), partial(_cost, these, sends)
    best = cost_of(order)
    for _ in range(6):
        before = best
        for moved in list(order):
            order, best = _move_block(order, best, moved, cost_of)
        if best >= before - 1e-6:
            break
    return order


def _first_order(these: Occupied) -> list[int]:
    """By the mean place of the neighbours, from the order of the graph; pinned blocks by their columns."""
    place = {i: float(i) for i in range(len(these.blocks))}
    for _ in range(8):
        means: dict[str, list[float]] = {}
        for i, leads in enumerate(these.leads):
            for lead in leads:
                means.setdefault(lead.node, []).append(place[i])
        for i, leads in enumerate(these.leads):
            near = [sum(means[lead.node]) / len(means[lead.node]) for lead in leads]
            place[i] = 0.5 * (place[i] + (sum(near) / len(near) if near else place[i]))
    order = sorted(place, key=lambda i: (round(place[i], 6), i))
    pinned = sorted((i for i in order if these.blocks[i].column is not None), key=lambda i: these.blocks[i].column or 0)
    spots = iter(pinned)
    return [next(spots) if these.blocks[i].column is not None else i for i in order]


def _move_block(
    order: list[int], best: float, block: int, cost_of: Callable[[Sequence[int]], float]
) -> tuple[list[int], float]:
    """The order with one block where it costs least."""
    at = order.index(block)
    rest = [i for i in order if i != block]
    places = range(len(order)) if len(order) <= FEW else range(max(0, at - 3), min(len(order), at + 4))
    for place in places:
        tried = [*rest[:place], block, *rest[place:]]
        if place != at and (cost := cost_of(tried)) < best - 1e-6:
            order, best = tried, cost
    return order, best


def _ease_right(these: Occupied, order: Sequence[int]) -> list[float]:
    """The blocks as far to the right of there as brings them nearer to what they are joined to."""
    places = these.compact(order)
    width = these.width(places)
    on: dict[str, list[float]] = {}
    for i in order:
        for lead in these.leads[i]:
            on.setdefault(lead.node, []).append(places[i] + lead.x)
    mean = {node: sum(xs) / len(xs) for node, xs in on.items()}
    edge: dict[int, float] = {}
    for i in reversed(order):
        high = min(edge.get(band, width + GAP) - GAP - span[1] for band, span in these.spans[i].items())
        wishes = [mean[lead.node] - lead.x for lead in these.leads[i]]
        if wishes and these.blocks[i].column is None:
            places[i] = max(places[i], min(high, sum(wishes) / len(wishes)))
        for band, (low, _) in these.spans[i].items():
            edge[band] = places[i] + low
    return places


def _best_place(these: Occupied, i: int, order: Sequence[int], places: list[float], width: float) -> float:
    """Where a block would best be, between those beside it."""
    if these.blocks[i].column is not None:
        return places[i]
    low, high = _room(these, i, order, places, width)
    met = [(lead.x, [places[j] + b.x for j, b in these.leads_of(lead.node) if j != i]) for lead in these.leads[i]]
    met = [(x, others) for x, others in met if others]
    if not met or high < low:
        return places[i]
    tries = {min(max(other - x, low), high) for x, others in met for other in others}
    tries |= {place + aside for place in tries for aside in (-STEP, STEP)} | {places[i]}
    middle = sum(sum(others) / len(others) - x for x, others in met) / len(met)
    for place in sorted(tries, key=lambda place: (_strain(place, met), abs(place - middle), place)):
        if low <= place <= high and not any(these.touch(i, place, j, places[j]) for j in order if j != i):
            return place
    return places[i]


def _room(these: Occupied, i: int, order: Sequence[int], places: list[float], width: float) -> tuple[float, float]:
    at = order.index(i)
    low = max(-span[0] for span in these.spans[i].values()) - ASIDE
    high = min(width - span[1] for span in these.spans[i].values()) + ASIDE
    for place, j in enumerate(order):
        for band in these.spans[i].keys() & these.spans[j].keys() if j != i else ():
            (mine, end), (begin, other) = these.spans[i][band], these.spans[j][band]
            if place < at:
                low = max(low, places[j] + other + GAP - mine)
            else:
                high = min(high, places[j] + begin - GAP - end)
    return low, high


def _cost(these: Occupied, sends: frozenset[tuple[str, str]], order: Sequence[int]) -> float:
    """Length of lines, crossings, flow to the left and missed positions of an order."""
    places = _ease_right(these, order)
    rails: dict[str, list[float]] = {}
    into: dict[str, list[float]] = {}
    out: dict[str, list[float]] = {}
    verticals = []
    for i in order:
        for lead in these.leads[i]:
            x = places[i] + lead.x
            rails.setdefault(lead.node, []).append(x)
            way = into if (lead.owner, lead.port) in sends else out
            way.setdefault(lead.node, []).append(x)
            verticals.append((x, *these.crossed_levels(i, lead), lead.node))
    ends = {node: (min(xs), max(xs)) for node, xs in rails.items()}
    cost = sum(high - low for low, high in ends.values())
    for x, low, high, own in verticals:
        for node, (begin, end) in ends.items():
            if node != own and begin - 4.0 < x < end + 4.0 and low <= these.level[node] <= high:
                passed = low < these.level[node] < high or these.level[own] != these.level[node]
                cost += CROSSING if passed else 0.4 * CROSSING
    for node in into.keys() & out.keys():
        pairs = [max(0.0, a - b) for a in into[node] for b in out[node]]
        cost += BACKWARD * sum(pairs) / len(pairs)
    cost += sum(PINNED * abs(places[i] - c) for i in order if (c := these.blocks[i].column) is not None)
    width = these.width(places)
    return cost + 1.5 * width + 0.02 * sum(places)


def _strain(place: float, met: Sequence[tuple[float, list[float]]]) -> float:
    """How far a block's lines are from the others on their nodes, less where one is straight, more for a small step."""
    total = 0.0
    for x, others in met:
        at = place + x
        total += max(0.0, min(others) - at, at - max(others))
        nearest = min(abs(at - other) for other in others)
        total += -STRAIGHT if nearest < 0.01 else JOG if nearest < NEAR else 0.0
    return total


def spans(block: Block, level: Mapping[str, int]) -> dict[int, tuple[float, float]]:
    """From where to where a block reaches in each band, by its symbols in its own and by its lines in others."""
    box = block.box
    found = {block.band: (box[0], box[2])}
    for lead in block.leads:
        if lead.tank:
            continue
        passed = range(block.band + 1, level[lead.node] + 1) if lead.up else range(level[lead.node] + 1, block.band)
        for band in passed:
            low, high = found.get(band, (lead.x, lead.x))
            found[band] = (min(low, lead.x - 8.0), max(high, lead.x + 8.0))
    return found
