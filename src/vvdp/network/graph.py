"""Components of a circuit and their connections: the graph that is drawn and listed, without its physics."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from enum import Enum
from types import MappingProxyType

from vvdp.base.errors import NetworkError

Position = tuple[float, float]
"""A place in a drawing [grid units]: columns to the right, rows upward."""


class NodeKind(Enum):
    """Content of a node."""

    VOLUME = "volume"
    ACCUMULATOR = "accumulator"
    """A volume with gas."""
    TANK = "tank"
    PRESSURE = "pressure"
    """An ideal pressure source."""
    SHAFT = "shaft"
    """A free inertia."""
    DRIVEN_SHAFT = "driven shaft"
    """A prescribed speed: a motor."""
    ROD = "rod"
    """A free mass."""
    DRIVEN_ROD = "driven rod"
    """A prescribed position."""

    @property
    def is_mechanical(self) -> bool:
        """Whether it turns or slides, rather than holds a pressure."""
        return self in (NodeKind.SHAFT, NodeKind.DRIVEN_SHAFT, NodeKind.ROD, NodeKind.DRIVEN_ROD)


@dataclass(frozen=True)
class GraphNode:
    """A node of a circuit. `labels` are further lines of text; `position` places its symbol or its line by hand."""

    name: str
    kind: NodeKind
    labels: tuple[str, ...] = ()
    position: Position | None = None


@dataclass(frozen=True)
class GraphComponent:
    """A component of a circuit: `ports` lead to names of nodes, `connections` name what each input follows.

    An input follows a signal, as text, or another's output, as "component.output". `designation` is the mark of the
    component in the drawing, such as P1; where it is empty the drawing numbers it. `opens` is the anchor of the drawing
    of what is in it, empty for a component that is none of parts.
    """

    name: str
    symbol: str
    ports: Mapping[str, str]
    connections: Mapping[str, str] = field(default_factory=lambda: MappingProxyType({}))
    designation: str = ""
    labels: tuple[str, ...] = ()
    position: Position | None = None
    opens: str = ""


@dataclass(frozen=True)
class GraphProgram:
    """A program of the control: what it reads and what it commands, each "component.name"."""

    name: str
    reads: tuple[str, ...] = ()
    commands: tuple[str, ...] = ()


@dataclass(frozen=True)
class Graph:
    """A circuit.

    Raises NetworkError where two parts have one name or a port ends at no node.
    """

    title: str
    nodes: tuple[GraphNode, ...]
    components: tuple[GraphComponent, ...] = ()
    programs: tuple[GraphProgram, ...] = ()

    def __post_init__(self) -> None:
        faults = [*_duplicates(self._names())]
        faults += _marked_twice(self.components)
        known = {node.name for node in self.nodes}
        for component in self.components:
            faults += [
                f"port '{port}' of '{component.name}' ends at '{node}', which is no node"
                for port, node in component.ports.items()
                if node not in known
            ]
        if faults:
            raise NetworkError(f"circuit '{self.title}': " + "; ".join(faults))

    def _names(self) -> list[str]:
        nodes, components = [n.name for n in self.nodes], [c.name for c in self.components]
        return [*nodes, *components, *(program.name for program in self.programs)]

    def node(self, name: str) -> GraphNode:
        """The node of that name."""
        return next(node for node in self.nodes if node.name == name)

    def component(self, name: str) -> GraphComponent:
        """The component of that name."""
        return next(component for component in self.components if component.name == name)


def _duplicates(names: Iterable[str]) -> list[str]:
    seen: set[str] = set()
    found = []
    for name in names:
        if name in seen:
            found.append(f"two parts are named '{name}'")
        seen.add(name)
    return found


def _marked_twice(components: Iterable[GraphComponent]) -> list[str]:
    marks = [component.designation for component in components if component.designation]
    return [f"two components are marked '{mark}'" for mark in sorted({m for m in marks if marks.count(m) > 1})]
