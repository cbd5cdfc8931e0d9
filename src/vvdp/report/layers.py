"""The levels of a circuit's nodes, from the sources upward, and the bands between them in which components stand.

Level n lies between the bands n and n + 1; what hangs below the lowest level is in band 0.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from vvdp.network.graph import Graph, GraphComponent, NodeKind
from vvdp.report.symbol import Side
from vvdp.report.symbol_set import Fitted, entry

Edge = tuple[str, str, int]
"""Lower node, upper node and the number of levels that at least lie between."""


@dataclass(frozen=True)
class Stand:
    """A component's band and whether it is upside down there."""

    band: int
    flipped: bool


def node_levels(graph: Graph, fits: Mapping[str, Fitted]) -> dict[str, int]:
    """The level of each hydraulic node that is no tank."""
    kinds = {node.name: node.kind for node in graph.nodes}
    names = [name for name, kind in kinds.items() if not kind.is_mechanical and kind is not NodeKind.TANK]
    edges = _edges(graph, fits, frozenset(names))
    level = dict.fromkeys(names, 0)
    for _ in names:
        for low, high, apart in edges:
            level[high] = max(level[high], level[low] + apart)
    entered = {high for _, high, _ in edges}
    for name in names:
        above = [level[high] - apart for low, high, apart in edges if low == name]
        if name not in entered and above:
            level[name] = min(above)
    fixed = {node.name: round(node.position[1]) for node in graph.nodes if node.position and node.name in level}
    return level | {name: max(row, 0) for name, row in fixed.items()}


def _edges(graph: Graph, fits: Mapping[str, Fitted], names: frozenset[str]) -> list[Edge]:
    """Edges without a cycle: what would close one is turned around."""
    order = sorted(graph.components, key=lambda c: found.order if (found := entry(c.symbol)) else 2)
    edges: list[Edge] = []
    for component in order:
        for low, high, apart in _wishes(component, fits[component.name], names):
            if low == high:
                continue
            edges.append((high, low, apart) if _leads(edges, high, low) else (low, high, apart))
    return edges


def _wishes(component: GraphComponent, fit: Fitted, names: frozenset[str]) -> Iterable[Edge]:
    sides: dict[Side, list[str]] = {side: [] for side in Side}
    for port in fit.terminals:
        if component.ports[port] in names:
            sides[fit.terminal(port).side].append(component.ports[port])
    yield from ((low, high, 1) for low in sides[Side.BOTTOM] for high in sides[Side.TOP])
    yield from ((low, high, 0) for low in sides[Side.LEFT] for high in sides[Side.RIGHT])


def _leads(edges: Iterable[Edge], begin: str, end: str) -> bool:
    """Whether the edges lead from one node to another."""
    reached, edges = {begin}, list(edges)
    for _ in edges:
        reached |= {high for low, high, _ in edges if low in reached}
    return end in reached


def stands(
    group: Iterable[tuple[GraphComponent, Fitted]], level: Mapping[str, int], row: float | None = None
) -> dict[str, Stand]:
    """How the components of a group stand that share one band; `row` is that band where it is given by hand."""
    members = list(group)
    met = [level[n] for c, fit in members for p in fit.terminals if (n := c.ports[p]) in level] or [0]
    bands = [max(round(row), 0)] if row is not None else list(range(min(met), max(met) + 2))

    def cost(band: int) -> float:
        return sum(min(_discomfort(c, fit, level, Stand(band, f)) for f in (False, True)) for c, fit in members)

    band = min(bands, key=lambda b: (cost(b), b))
    return {
        c.name: min((Stand(band, f) for f in (False, True)), key=lambda s: _discomfort(c, fit, level, s))
        for c, fit in members
    }


def _discomfort(component: GraphComponent, fit: Fitted, level: Mapping[str, int], stand: Stand) -> float:
    """How badly a component stands: lines that leave on the wrong side count ten, being upside down a half."""
    total = 0.5 * stand.flipped
    for port in fit.terminals:
        side, node = fit.terminal(port).side, component.ports[port]
        below = node not in level or level[node] < stand.band
        if node in level:
            total += stand.band - 1 - level[node] if below else level[node] - stand.band
        if side in (Side.TOP, Side.BOTTOM):
            total += 10.0 * (((side is Side.BOTTOM) != stand.flipped) != below)
        elif not below:
            total += 0.1
    return total
