"""What a network writes of oils that boil and of oils whose air dissolves; nothing of others."""

from collections.abc import Iterator

from vvdp.base.select import maximum
from vvdp.fluid.parts import vapour_side
from vvdp.hydraulics.aeration import air_change, mixed_air, vapour_volume
from vvdp.hydraulics.pipe import LinePipe, piece_volume
from vvdp.hydraulics.volume import oil_held
from vvdp.network.folding import negative
from vvdp.network.network import Part
from vvdp.network.nodes import Chamber, HydraulicNode, OilVolume, can_boil, free_air_name, has_free_air
from vvdp.network.text import Text
from vvdp.simulation.values import names


def aerated_volumes(text: Text) -> dict[str, OilVolume]:
    """The volumes whose free air is a state, by name."""
    nodes = text.network.nodes.items()
    return {name: node for name, node in nodes if isinstance(node, OilVolume) and has_free_air(node)}


def air_lines(text: Text) -> Iterator[str]:
    """Lines that say how the free air of each volume changes."""
    volumes = aerated_volumes(text)
    for part in text.network.parts.values():
        if volumes.keys() & part_flows(part).keys():
            yield f"air_{part.name} = {_mean_of_drawn(text, part)}"
    for name, node in volumes.items():
        own = f"s.{free_air_name(name)}"
        terms = [
            f"{text.use(maximum)}({flow}, 0.0) * (air_{part.name} - {own})"
            for part in text.network.parts.values()
            for where, flow in part_flows(part).items()
            if where == name
        ]
        volume, oil = oil_volume(text, name, node), text.places.path(node.oil)
        inflow = " + ".join(terms) or "0.0"
        yield f"{free_air_name(name)} = {text.use(air_change)}({inflow}, {volume}, {name}, {own}, {oil})"


def part_flows(part: Part) -> dict[str, str]:
    """Oil that a part gives to the nodes at its ports [tank volumes]."""
    component, found = part.component, dict[str, str]()
    for number, port in enumerate(component.hydraulic_ports):
        if port in component.ends:
            flow = f"{part.name}.flow" if number else f"-{part.name}.flow"
        elif port in names(component.result):
            flow = f"{part.name}.{port}"
        else:
            continue
        node = part.nodes[port]
        found[node] = f"{found[node]} + {flow}" if node in found else flow
    return found


def _mean_of_drawn(text: Text, part: Part) -> str:
    """The free air of what a part gives."""
    drawn = {
        node: f"{text.use(maximum)}({negative(flow) if ' ' not in flow else f'-({flow})'}, 0.0)"
        for node, flow in part_flows(part).items()
    }
    air = " + ".join(f"{flow} * {_free_air(text, node)}" for node, flow in drawn.items())
    return f"{text.use(mixed_air)}({air}, {' + '.join(drawn.values())})"


def _free_air(text: Text, name: str) -> str:
    node = text.network.nodes[name]
    assert isinstance(node, HydraulicNode)
    return f"s.{free_air_name(name)}" if has_free_air(node) else f"{text.places.path(node.oil)}.air_fraction"


def oil_volume(text: Text, name: str, node: OilVolume) -> str:
    """The volume of the oil in a node."""
    values, reference = text.places.path(node.values), f"{text.places.path(node.oil)}.reference_pressure"
    if isinstance(node.values, LinePipe):
        return f"{text.use(piece_volume)}({name}.pressure, {values}, {reference})"
    swept = text.walls(name, "volume")
    own = f"{values}.volume"
    if not isinstance(node.values, Chamber):
        own = f"{text.use(oil_held)}({name}.pressure, {values}, {reference})"
    return f"{own} + {swept}" if swept else own


def boiling_outputs(text: Text) -> dict[str, str]:
    """Names and texts of the volumes of vapour."""
    found = {}
    for name, node in text.network.nodes.items():
        if isinstance(node, OilVolume) and can_boil(node):
            volume, oil = oil_volume(text, name, node), text.places.path(node.oil)
            found[f"{name}_vapour"] = f"{text.use(vapour_volume)}({volume}, {name}, {oil})"
    return found


def boiling_modes(text: Text) -> dict[str, str]:
    """Names and texts of the kinks at which oil begins and ends to boil."""
    return {
        f"{name}_vapour": f"{text.use(vapour_side)}({name}.pressure, {text.places.path(node.oil)})"
        for name, node in text.network.nodes.items()
        if isinstance(node, OilVolume) and can_boil(node)
    }
