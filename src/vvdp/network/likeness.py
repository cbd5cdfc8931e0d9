"""Whether a network contains another one."""

from collections.abc import Iterator
from itertools import chain

from vvdp.base.params import field_kinds
from vvdp.base.rules import shown_value
from vvdp.network.network import Network, Part
from vvdp.network.nodes import Tank


def lacks(drawn: Network, rig: Network) -> Iterator[str]:
    """Sentences on what a network lacks to contain a rig: its nodes and components, joined in the same way and with
    equal values, with nothing else at its nodes but at tanks.
    """
    for name, node in rig.nodes.items():
        if name not in drawn.nodes:
            yield f"there is no node {name!r}"
        elif type(drawn.nodes[name]) is not type(node):
            yield f"node {name!r} is of another type"
    differing = (_differences(drawn.parts.get(name), part) for name, part in rig.parts.items())
    yield from chain.from_iterable(differing)
    for name, part in drawn.parts.items():
        for end in () if name in rig.parts else part.nodes.values():
            if end in rig.nodes and not isinstance(rig.nodes[end], Tank):
                yield f"{name!r} is joined to {end!r} as well"


def _differences(drawn: Part | None, part: Part) -> Iterator[str]:
    name = part.name
    if drawn is None:
        yield f"there is no component {name!r}"
        return
    if drawn.component != part.component:
        yield f"component {name!r} is of another type"
        return
    for port, node in part.nodes.items():
        if drawn.nodes[port] != node:
            yield f"port {port!r} of {name!r} is joined to {drawn.nodes[port]!r} instead of {node!r}"
    for cls, own, other in zip(part.component.params, part.values, drawn.values, strict=True):
        for key, kind in field_kinds(cls).items():  # a table may hold more
            here, there = getattr(other, key), getattr(own, key)
            if here != there:
                values = f": {shown_value(here, kind)} instead of {shown_value(there, kind)}" if kind else ""
                yield f"{name}.{key} is another one{values}"
