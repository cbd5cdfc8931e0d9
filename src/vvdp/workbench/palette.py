"""What a circuit may be drawn from: each type with its symbol, its ports, and the lines that a file needs of it."""

from collections.abc import Iterator, Mapping
from functools import cache
from typing import Any, get_origin

from vvdp.base.kinds import Kind
from vvdp.base.params import Params, default_values, field_kinds, field_types
from vvdp.components.library import COMPONENTS
from vvdp.network.assembly import Assembly
from vvdp.network.component import Component, Role
from vvdp.network.graph import NodeKind
from vvdp.report.symbol_set import LONELY, entry, generic, picture
from vvdp.report.symbol_set import NODES as NODE_SYMBOLS
from vvdp.systems.drawing import NODES

OIL, SHAFT, ROD = "oil", "shaft", "rod"
"""What can be joined: a port to a node of the same word."""
ROLES = {Role.PORT: OIL, Role.SHAFT: SHAFT, Role.SHAFT_SPEED: SHAFT, Role.ROD: ROD}
NODE_KINDS: Mapping[str, tuple[NodeKind, str]] = {
    "volume": (NodeKind.VOLUME, OIL),
    "vessel": (NodeKind.ACCUMULATOR, OIL),
    "tank": (NodeKind.TANK, OIL),
    "pressure-source": (NodeKind.PRESSURE, OIL),
    "shaft": (NodeKind.SHAFT, SHAFT),
    "driven-shaft": (NodeKind.DRIVEN_SHAFT, SHAFT),
    "rod": (NodeKind.ROD, ROD),
}
WITHOUT_VALUES = frozenset({"tank"})
"""Nodes whose values may all be left out, though their class has no defaults."""
BESIDE: Mapping[str, str] = {
    "rated_drop": '"10 bar"',
    "maximum_drop": '"10 bar"',
    "upper_end": '"100 mm"',
    "cushion_end": '"20 mm"',
    "tank_height": '"500 mm"',
    "modulus": '"7"',
    "commands": '["0", "1"]',
    "flows": '["0 lpm", "40 lpm"]',
}
"""Examples of values that must differ from those of another key."""
MASS = 'mass = "0.5 kg"'
"""What a rod needs if nothing on it has a mass."""


@cache
def palette() -> list[dict[str, Any]]:
    """All types of nodes and components, in the order of `vvdp list --components`."""
    return [*_nodes(), *_components()]


def _nodes() -> Iterator[dict[str, Any]]:
    for name, node in NODES.items():
        kind, joins = NODE_KINDS[name]
        symbol = {**LONELY, **NODE_SYMBOLS}[kind]()
        lines = [MASS] if joins == ROD else [] if name in WITHOUT_VALUES else list(_value_lines(node.table))
        yield {"table": "nodes", "type": name, "symbol": picture(symbol), "joins": joins, "ports": {}, "lines": lines}


def _components() -> Iterator[dict[str, Any]]:
    for name, part in COMPONENTS.items():
        found = entry(part.symbol)
        yield {
            "table": "components",
            "type": name,
            "symbol": picture(found.draw() if found else generic(part.symbol, {})),
            "ports": _ports(part),
            "lines": list(_lines(part)),
        }


def _ports(part: Component | Assembly) -> dict[str, str]:
    if isinstance(part, Assembly):
        return dict.fromkeys(part.ports, OIL)
    return {name: ROLES[role] for name, role in part.ports.items()}


def _lines(part: Component | Assembly) -> Iterator[str]:
    """The values that a file has to give, each with an example; the ports are left out."""
    if isinstance(part, Assembly):
        yield from _value_lines(part.params)
        yield 'start = "0 bar"'
        return
    for each in part.inputs:
        if each.default is None:
            yield f"{each.name} = {_example(each.kind)}"
    for cls in part.params:
        yield from _value_lines(cls)


def _value_lines(cls: type[Params]) -> Iterator[str]:
    usual, types = default_values(cls), field_types(cls)
    for name, kind in field_kinds(cls).items():
        if name not in usual:
            example = _example(kind)
            several = f"[{example}, {example}]" if get_origin(types[name]) is tuple else example
            yield f"{name} = {BESIDE.get(name, several)}"


def _example(kind: Kind | None) -> str:
    return '"0"' if kind is None else f'"{kind.example}"'
