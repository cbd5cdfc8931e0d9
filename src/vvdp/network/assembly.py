"""A component that a network makes of several: drawn, named and counted as one."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from vvdp.base.kinds import Kind
from vvdp.base.params import Params


@dataclass(frozen=True)
class Assembly:
    """A component of several parts and nodes.

    params  class of its values
    ports   names of its hydraulic ports
    symbol  of the diagram
    add     add(network, name, values, nodes by port, start) draws it; `start` is the pressure of the volumes in it
            [Pa, absolute], None where it holds no oil
    inputs  names of its inputs and their kinds; `add` receives their sources beside the nodes
    """

    name: str
    params: type[Params]
    ports: tuple[str, ...]
    symbol: str
    add: Callable[..., None]
    inputs: Mapping[str, Kind] = field(default_factory=dict)
    holds_oil: bool = True


@dataclass(frozen=True)
class Group:
    """An assembly in a network: its parts from the first port to the last, the nodes and the programs inside."""

    assembly: Assembly
    values: Params
    ports: Mapping[str, str]
    parts: tuple[str, ...]
    nodes: tuple[str, ...]
    programs: tuple[str, ...] = ()


@dataclass(frozen=True)
class InnerCircuit:
    """A circuit that is one part of another: the file it came from, the nodes at its ports, the names of all in it."""

    source: str
    ports: Mapping[str, str]
    names: frozenset[str]
