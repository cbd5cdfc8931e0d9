"""Parts of a drawn circuit: each type with its symbol, its ports, and the lines that a file needs of it."""

from collections.abc import Iterator, Mapping
from functools import cache
from typing import Any

from vvdp.base.params import Params, default_values, field_kinds
from vvdp.components.library import COMPONENTS
from vvdp.network.assembly import Assembly
from vvdp.network.component import Component, Role
from vvdp.network.graph import NodeKind
from vvdp.report.symbol_set import LONELY, entry, generic, picture
from vvdp.report.symbol_set import NODES as NODE_SYMBOLS
from vvdp.systems.drawing import NODES
from vvdp.systems.library_pages import library_page
from vvdp.systems.part_files import shipped_part, shipped_parts
from vvdp.systems.part_offers import part_ports, part_values

OIL, SHAFT, ROD = "oil", "shaft", "rod"
"""Words for what can be joined: a port to a node of the same word."""
ROLES = {Role.PORT: OIL, Role.SHAFT: SHAFT, Role.SHAFT_SPEED: SHAFT, Role.ROD: ROD}
NODE_KINDS: Mapping[str, tuple[NodeKind, str]] = {
    "volume": (NodeKind.VOLUME, OIL),
    "vessel": (NodeKind.ACCUMULATOR, OIL),
    "junction": (NodeKind.VOLUME, OIL),
    "tank": (NodeKind.TANK, OIL),
    "pressure-source": (NodeKind.PRESSURE, OIL),
    "shaft": (NodeKind.SHAFT, SHAFT),
    "driven-shaft": (NodeKind.DRIVEN_SHAFT, SHAFT),
    "rod": (NodeKind.ROD, ROD),
}
WITHOUT_VALUES = frozenset({"tank"})
"""Nodes whose values may all be left out, though their class has no defaults."""
NEEDED = {"rod": 'mass = "0.5 kg"', "shaft": 'inertia = "4e-5 kg*m^2"'}
"""Inertia of a rod or a shaft, assumed if nothing on it has a mass or an inertia."""


@cache
def palette() -> list[dict[str, Any]]:
    """All types of nodes, components and shipped parts, in the order of `vvdp list --components`."""
    return [*_nodes(), *_components(), *_parts()]


def _nodes() -> Iterator[dict[str, Any]]:
    for name, node in NODES.items():
        kind, joins = NODE_KINDS[name]
        symbol = {**LONELY, **NODE_SYMBOLS}[kind]()
        own = [] if name in WITHOUT_VALUES else [*_value_lines(node.table)]
        lines = [NEEDED[name]] if name in NEEDED else own
        yield {"table": "nodes", "type": name, "symbol": picture(symbol), "joins": joins, "ports": {}, "lines": lines}


def _components() -> Iterator[dict[str, Any]]:
    for name, part in COMPONENTS.items():
        found = entry(part.symbol)
        yield {
            "table": "components",
            "type": name,
            "symbol": picture(found.draw() if found else generic(part.symbol, {})),
            "ports": _ports(part),
            "lines": list(_lines(name)),
        }


def _parts() -> Iterator[dict[str, Any]]:
    for name in shipped_parts():
        file = shipped_part(name)
        needed = ((key, each.kind) for key, each in part_values(file).items() if not each.default)
        yield {
            "table": "parts",
            "type": name,
            "symbol": picture(generic(name, {})),
            "ports": part_ports(file),
            "lines": [f'{key} = "{kind.example if kind else 0}"' for key, kind in needed],
        }


def _ports(part: Component | Assembly) -> dict[str, str]:
    if isinstance(part, Assembly):
        return dict.fromkeys(part.ports, OIL)
    return {name: ROLES[role] for name, role in part.ports.items()}


def _lines(kind: str) -> Iterator[str]:
    """The values that a file has to give, each as in the example of the library; the ports are left out."""
    page = library_page(kind)
    yield from (f"{each.name} = {each.example}" for each in (*page.inputs, *page.values) if not each.usual)


def _value_lines(cls: type[Params]) -> Iterator[str]:
    usual = default_values(cls)
    yield from (f'{name} = "{kind.example}"' for name, kind in field_kinds(cls).items() if kind and name not in usual)
