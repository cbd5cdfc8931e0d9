"""Networks that fit together and still say nothing: each is refused with its cause."""

from collections.abc import Iterator

from vvdp.base.errors import NetworkError
from vvdp.hydraulics.relief_valve import ReliefValve
from vvdp.network.network import Network, Part
from vvdp.network.nodes import Chamber, Junction, OilVolume, Rod, Shaft
from vvdp.network.paths import takes_surplus


def check_sense(network: Network) -> None:
    """Raises NetworkError where a part can do nothing, or where what it does does not follow from the network."""
    for fault in (*_empty_volumes(network), *_short_circuits(network), *_surplus(network)):
        raise NetworkError(fault)


def idle_nodes(network: Network) -> Iterator[str]:
    """Nodes that nothing joins and nothing prescribes; a tank or a source may wait for a study that joins it."""
    joined = {node for part in network.parts.values() for node in part.nodes.values()}
    for name, node in network.nodes.items():
        if isinstance(node, OilVolume | Junction | Shaft | Rod) and name not in joined:
            yield name


def _empty_volumes(network: Network) -> Iterator[str]:
    """Volumes of 0 m^3 whose pressure would have no finite rate; a moving wall may give them their oil."""
    walled = {
        part.nodes[port]
        for part in network.parts.values()
        if part.component.moves_walls
        for port in part.component.hydraulic_ports
    }
    for name, node in network.nodes.items():
        empty = isinstance(node, OilVolume) and isinstance(node.values, Chamber) and node.values.volume == 0.0
        if empty and name not in walled:
            yield (
                f"{name}.volume: 0 m^3; its pressure would jump: give it the oil of its pipes, such as 10 cc, or make "
                'it a node of type "junction"'
            )


def _short_circuits(network: Network) -> Iterator[str]:
    for part in network.parts.values():
        ends = [part.nodes[port] for port in part.component.hydraulic_ports]
        if len(ends) > 1 and len(set(ends)) == 1:
            yield f"{part.name} has all its ports at {ends[0]!r}, so it moves no oil; join one of them to another node"


def _surplus(network: Network) -> Iterator[str]:
    """Ideal valves at a prescribed pressure, or two at one volume: each takes all that is left over in a volume."""
    first = dict[str, str]()
    for part in filter(is_ideal, network.parts.values()):
        node = part.nodes[part.component.hydraulic_ports[0]]
        if isinstance(network.nodes[node], Junction):
            continue  # `junction_text` refuses it, drawn in a file or not
        if not isinstance(network.nodes[node], OilVolume):
            yield (
                f"{part.name} is ideal (override_pressure 0): it takes what is left over in a volume, and {node!r} "
                "has a prescribed pressure; give it an override_pressure, or join it to a volume"
            )
        elif (other := first.setdefault(node, part.name)) != part.name:
            yield (
                f"{part.name} is ideal (override_pressure 0), as {other} at the same volume {node!r}: which of them "
                "takes what is left over there is given by neither; give one an override_pressure"
            )


def is_ideal(part: Part) -> bool:
    """Whether a part takes whatever is left over in a volume."""
    reliefs = [value for value in part.values if isinstance(value, ReliefValve)]
    return takes_surplus(part) and all(relief.override_pressure == 0.0 for relief in reliefs)
