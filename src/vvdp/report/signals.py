"""Signal lines from one component to another, drawn where they are short and free; labels name all of them."""

from collections.abc import Iterator
from itertools import pairwise

from vvdp.network.graph import Graph
from vvdp.report.blocks import Piece
from vvdp.report.routing import Plan, overlap
from vvdp.report.symbol import Box

SHORT = 180.0
"""Longest signal line that is drawn [px]."""


def signal_lines(graph: Graph, made: Plan) -> Iterator[tuple[float, float, float, str]]:
    """Left end, right end, height and name of each signal line that is drawn."""
    pieces = {piece.name: piece for piece in made.pieces}
    for component in graph.components:
        for put, source in component.connections.items():
            begin, dot, _ = source.rpartition(".")
            if dot and begin in pieces and begin != component.name:
                place = _free(made, pieces[begin], pieces[component.name])
                if place:
                    yield (*place, f"{source} → {component.name}.{put}")


def _free(made: Plan, begin: Piece, end: Piece) -> tuple[float, float, float] | None:
    """From where to where a line goes to the right between two pieces of one height, where nothing is between them."""
    x0, x1, y = begin.box[2] + 3.0, end.body[0], begin.at[1]
    if begin.at[1] != end.at[1] or not 12.0 < x1 - x0 < SHORT:
        return None
    way = (x0, y - 3.0, x1 - 1.0, y + 3.0)
    return None if any(overlap(way, box, True) for box in _solid(made, end)) else (x0, x1, y)


def _solid(made: Plan, end: Piece) -> Iterator[Box]:
    """All that a signal line must not touch."""
    yield from (piece.box for piece in made.pieces if piece is not end)
    yield from (label.box for label in made.names.values())
    lines = [*(wire.points for wire in made.wires), *made.links]
    lines += [((rail.ends[0], rail.y), (rail.ends[1], rail.y)) for rail in made.rails]
    for points in lines:
        for (a, b), (c, d) in pairwise(points):
            yield min(a, c), min(b, d), max(a, c), max(b, d)
