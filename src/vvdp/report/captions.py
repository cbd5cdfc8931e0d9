"""The lines of text beside the parts of a diagram."""

import re
from collections.abc import Mapping
from dataclasses import dataclass

from vvdp.network.graph import Graph, NodeKind
from vvdp.report.lettering import wrap_parts

Lines = tuple[str, ...]


@dataclass(frozen=True)
class Limits:
    """How many characters stand in one line: of a mark with its name, of other text, of a line's name."""

    name: int = 17
    text: int = 24
    rail: int = 34


USUAL, NARROW = Limits(), Limits(11, 14, 24)


def captions(graph: Graph, values: Mapping[str, Lines], marks: Mapping[str, str], limits: Limits) -> dict[str, Lines]:
    """The label of every part: its mark and name, its own lines, what its inputs follow and the given values."""
    texts = {}
    for component in graph.components:
        follows = [f"{put}: {source}" for put, source in component.connections.items()]
        lines = wrap_parts((*component.labels, *values.get(component.name, ()), *follows), limits.text)
        texts[component.name] = (*heading(marks[component.name], component.name, limits.name), *lines)
    for node in graph.nodes:
        limit = limits.rail if node.kind is NodeKind.VOLUME else limits.text
        texts[node.name] = (node.name, *wrap_parts((*node.labels, *values.get(node.name, ())), limit))
    return texts


def heading(mark: str, name: str, limit: int) -> list[str]:
    """A mark and a name in one line, or the name below the mark where that is long."""
    whole = name if name.lower() == mark.lower() else f"{mark} {name}"
    if len(whole) <= limit or whole == name:
        return [whole]
    lines = [mark]
    for word in re.split(r"(?<=[_\s-])", name):
        if len(lines) > 1 and len((lines[-1] + word).rstrip()) <= limit:
            lines[-1] += word
        else:
            lines.append(word)
    return [line.rstrip() for line in lines]
