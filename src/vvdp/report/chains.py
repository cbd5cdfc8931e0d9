"""Symbols that form a block: those on one shaft or rod stand in a row, the others alone."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from vvdp.network.graph import Graph, GraphComponent, GraphNode, NodeKind
from vvdp.report.blocks import Beside, Block, Piece, piece
from vvdp.report.layers import Stand, node_levels, stands
from vvdp.report.leads import Point
from vvdp.report.symbol import Side, Symbol
from vvdp.report.symbol_set import LONELY, NODES, Fitted, fit_symbol, is_source

SPACE, ROW = 20.0, 12.0
"""Space between the symbols of a chain, along it and between its rows [px]."""
COLUMN = 120.0
"""Width of a column of positions given by hand [px]."""


@dataclass(frozen=True)
class Setting:
    """What blocks are made from."""

    graph: Graph
    texts: Callable[[str], tuple[str, ...]]
    fits: Mapping[str, Fitted]
    level: Mapping[str, int]
    kinds: Mapping[str, NodeKind]
    positions: Mapping[str, tuple[float, float] | None]

    def on(self, node: str) -> list[GraphComponent]:
        """The components on a shaft or rod."""
        return [c for c in self.graph.components if any(c.ports[port] == node for port in self.fits[c.name].links)]

    def shafts(self, component: GraphComponent) -> list[str]:
        """The shafts and rods of a component."""
        return list(dict.fromkeys(component.ports[port] for port in self.fits[component.name].links))


def setting(graph: Graph, texts: Callable[[str], tuple[str, ...]]) -> Setting:
    """The symbols of a graph's components and the levels of its nodes; `texts` gives the label of a part."""
    kinds = {node.name: node.kind for node in graph.nodes}
    fed = frozenset(name for name, kind in kinds.items() if kind is NodeKind.PRESSURE) | {
        node for component in graph.components if is_source(component.symbol) for node in component.ports.values()
    }
    fits = {component.name: fit_symbol(component, kinds, fed) for component in graph.components}
    positions = {n.name: n.position for n in graph.nodes} | {c.name: c.position for c in graph.components}
    levels = node_levels(graph, fits)
    return Setting(graph=graph, texts=texts, fits=fits, level=levels, kinds=kinds, positions=positions)


def blocks(given: Setting) -> list[Block]:
    """All blocks, in the order of the graph."""
    made = [_alone(given, c) for c in given.graph.components if not given.fits[c.name].links]
    done: set[str] = set()
    chained = [c for c in given.graph.components if given.fits[c.name].links]
    for group in _groups(given, chained):
        row = next((c.position[1] for c in group if c.position), None)
        where = stands([(c, given.fits[c.name]) for c in group], given.level, row)
        while begin := _begin(given, group, done):
            chain = Chain(given, where, done)
            chain.run(begin)
            made.append(chain.block())
    for node in given.graph.nodes:
        if node.kind in NODES and node.name not in done:
            made.append(_store(given, node))
        elif node.kind in LONELY and _stands_alone(given, node):
            alone = Fitted(LONELY[node.kind](), {}, ())
            shown = piece(node.name, alone, {}, given.texts(node.name), Beside.RIGHT, ({}, 0))
            made.append(Block((shown,), (), 0, _column(node)))
    return made


def _stands_alone(given: Setting, node: GraphNode) -> bool:
    """Whether a node needs its own symbol: nothing leads to it, or it is a tank with more to show than its name."""
    used = any(node.name in component.ports.values() for component in given.graph.components)
    return not used or (node.kind is NodeKind.TANK and len(given.texts(node.name)) > 1)


def _alone(given: Setting, component: GraphComponent) -> Block:
    fit = given.fits[component.name]
    row = component.position[1] if component.position else None
    stand = stands([(component, fit)], given.level, row)[component.name]
    sides = {fit.terminal(port).side for port in fit.terminals}
    beside = Beside.ABOVE if sides and sides <= {Side.LEFT, Side.RIGHT} else Beside.RIGHT
    made = _component_piece(given, component, stand, beside)
    return Block((made,), (), stand.band, component.position[0] * COLUMN if component.position else None)


def _component_piece(given: Setting, component: GraphComponent, stand: Stand, beside: Beside) -> Piece:
    fit = given.fits[component.name]
    oriented = Fitted(fit.symbol.upside_down() if stand.flipped else fit.symbol, fit.terminals, fit.links)
    return piece(
        component.name, oriented, component.ports, given.texts(component.name), beside, (given.level, stand.band)
    )


def _store(given: Setting, node: GraphNode) -> Block:
    """A node with a symbol of its own: a shaft that nothing is on, an accumulator, a source of pressure."""
    symbol = NODES[node.kind]()
    if node.kind.is_mechanical:
        return Block((_plain(node.name, symbol, given.texts(node.name)),), (), 0, _column(node))
    level = given.level[node.name]
    fed = any(_feeds(given, c, node.name) for c in given.graph.components)
    band = level if node.kind is NodeKind.PRESSURE and not fed else level + 1
    fit = Fitted(symbol, {"port": "port"}, ())
    if node.kind is NodeKind.PRESSURE and fed:
        fit = Fitted(symbol.upside_down(), {"port": "port"}, ())
    where = (given.level, band)
    made = piece(node.name, fit, {"port": node.name}, given.texts(node.name), Beside.RIGHT, where)
    return Block((made,), (), band, _column(node))


def _feeds(given: Setting, component: GraphComponent, node: str) -> bool:
    """Whether a component stands below a node, so that flow comes up to it."""
    lows = [given.level[n] for n in component.ports.values() if n in given.level and n != node]
    return node in component.ports.values() and any(low < given.level[node] for low in lows)


def _column(node: GraphNode) -> float | None:
    return node.position[0] * COLUMN if node.position else None


def _groups(given: Setting, chained: list[GraphComponent]) -> list[list[GraphComponent]]:
    """Components that shafts and rods join, directly or through others."""
    groups: list[list[GraphComponent]] = []
    for component in chained:
        shafts = set(given.shafts(component))
        joined = [g for g in groups if any(shafts & set(given.shafts(other)) for other in g)]
        groups = [g for g in groups if g not in joined] + [[*(c for g in joined for c in g), component]]
    return groups


def _begin(given: Setting, group: list[GraphComponent], done: set[str]) -> str:
    """Where a chain begins at the left: what is driven, a component with lines, else any; empty when all are done."""
    rest = [c for c in group if c.name not in done]
    if not rest:
        return ""
    nodes = [n for c in rest for n in given.shafts(c) if n not in done]
    driven = [n for n in nodes if given.kinds[n] in (NodeKind.DRIVEN_SHAFT, NodeKind.DRIVEN_ROD)]
    lined = [c.name for c in rest if given.fits[c.name].terminals and given.fits[c.name].symbol.axis[1] is not None]
    return [*driven, *lined, *nodes, rest[0].name][0]


@dataclass
class Chain:
    """Symbols in a row from left to right, as they are met."""

    given: Setting
    where: Mapping[str, Stand]
    done: set[str]
    pieces: list[Piece] = field(default_factory=list)
    links: list[tuple[Point, ...]] = field(default_factory=list)
    right: float = 0.0
    end: float | None = None
    """Right edge of what is placed, and where the double line goes on."""

    def run(self, begin: str) -> None:
        """Places everything from `begin` on."""
        if begin in self.given.kinds:
            self._node(begin)
        else:
            self._component(self.given.graph.component(begin), None)

    def block(self) -> Block:
        """What was placed."""
        positions = [p for piece in self.pieces if (p := self.given.positions[piece.name])]
        column = positions[0][0] * COLUMN - self.pieces[0].at[0] if positions else None
        band = next(iter(self.where.values())).band
        return Block(tuple(self.pieces), tuple(self.links), band, column)

    def _node(self, name: str) -> None:
        if name in self.done:
            self._add(_mark(name))
            return
        self.done.add(name)
        self._add(_plain(name, NODES[self.given.kinds[name]](), self.given.texts(name)))
        rest = [c for c in self.given.on(name) if c.name not in self.done]
        single = [c for c in rest if len(self.given.shafts(c)) == 1]
        lined = [c for c in single if self.given.fits[c.name].terminals]
        passing = [c for c in lined if None not in self.given.fits[c.name].symbol.axis]
        onward = [c for c in rest if c not in single] + [c for c in lined if c not in passing]
        leaves = [c for c in single if c not in lined]
        while passing and (len(passing) > 1 or leaves or onward):
            self._component(passing.pop(0), name)
        last = [*passing, *onward][:1]
        if len(leaves) > 1 or (leaves and last):
            self._rows(leaves, centred=not last)
        elif leaves:
            self._component(leaves[0], name)
        for component in last:
            self._component(component, name)

    def _component(self, component: GraphComponent, came: str | None) -> None:
        self.done.add(component.name)
        fit = self.given.fits[component.name]
        shafts = [n for n in self.given.shafts(component) if n != came]
        mirrored = came is not None and fit.symbol.axis[0] is None
        last = came is not None and not shafts and all(c.name in self.done for c in self.given.on(came))
        stand = self.where[component.name]
        beside = _beside(fit, flipped=stand.flipped, last=last)
        self._add(_mirror(self.given, component, stand, beside, mirrored), linked=came is not None)
        for node in shafts[:1]:
            self._node(node)

    def _add(self, made: Piece, linked: bool = True) -> None:
        """Puts a piece to the right of all others and draws the double line to it."""
        x = self.right + (SPACE if self.pieces else 0.0) - min(made.box[0], made.symbol.box[0])
        self.pieces.append(made.translate(x, 0.0))
        left, right = made.symbol.axis
        if self.end is not None and linked and left is not None:
            self.links.append(((self.end, 0.0), (x + left, 0.0)))
        self.end = None if right is None else x + right
        self.right = x + made.box[2]

    def _rows(self, leaves: list[GraphComponent], centred: bool) -> None:
        """Several components that end a rod or shaft, one below the other."""
        self.done |= {c.name for c in leaves}
        made = [_mirror(self.given, c, self.where[c.name], Beside.RIGHT, False) for c in leaves]
        highs = [max(30.0, p.box[3] - p.box[1]) + ROW for p in made]
        y = -0.5 * sum(highs) if centred else max(20.0, self.pieces[-1].box[3])
        bar = max((self.end or self.right) + 0.5 * SPACE, self.right + 6.0)
        ys, wide = [], bar
        for each, high in zip(made, highs, strict=True):
            middle = y + 0.5 * high
            x = bar + SPACE - each.symbol.box[0]
            self.pieces.append(each.translate(x, middle))
            self.links.append(((bar, middle), (x + (each.symbol.axis[0] or 0.0), middle)))
            ys.append(middle)
            wide, y = max(wide, x + each.box[2]), y + high
        self.links.append(((self.end or bar, 0.0), (bar, 0.0)))
        self.links.append(((bar, min([*ys, 0.0])), (bar, max([*ys, 0.0]))))  # last, it covers the ends of the others
        self.end, self.right = bar, wide


def _plain(name: str, symbol: Symbol, lines: tuple[str, ...]) -> Piece:
    return piece(name, Fitted(symbol, {}, ()), {}, lines, Beside.BELOW, ({}, 0))


def _mark(name: str) -> Piece:
    """A name in place of a shaft or rod that is drawn elsewhere."""
    return _plain(name, Symbol((-4, -8, 4, 8), "", {}, (-4, 4)), (f"→ {name}",))


def _beside(fit: Fitted, *, flipped: bool, last: bool) -> Beside:
    """Where the label of a component in a chain stands: behind the last one, else away from its lines."""
    sides = {fit.terminal(port).side for port in fit.terminals}
    if len(sides) == 1 and sides <= {Side.BOTTOM, Side.TOP}:
        return Beside.BELOW if (Side.TOP in sides) != flipped else Beside.ABOVE
    if last:
        return Beside.RIGHT
    return Beside.ABOVE_RIGHT if sides else Beside.BELOW


def _mirror(given: Setting, component: GraphComponent, stand: Stand, beside: Beside, mirrored: bool) -> Piece:
    """A component's piece, with left and right exchanged where its shaft would come from the wrong side."""
    fit = given.fits[component.name]
    symbol = fit.symbol.upside_down() if stand.flipped else fit.symbol
    turned = Fitted(symbol.mirror() if mirrored else symbol, fit.terminals, fit.links)
    texts, where = given.texts(component.name), (given.level, stand.band)
    return piece(component.name, turned, component.ports, texts, beside, where)
