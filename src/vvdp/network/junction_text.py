"""Writes how the pressure of a junction is found: the laws of its parts are asked again and again within a circuit."""

from vvdp.base.errors import NetworkError
from vvdp.base.select import maximum, minimum
from vvdp.fluid.oil import Oil
from vvdp.hydraulics.junction import ROUNDS, TOLERANCE, PressureSearch, begin_search, next_search
from vvdp.network.folding import indent
from vvdp.network.heat import heat_balance
from vvdp.network.network import Part
from vvdp.network.nodes import Junction, has_free_air
from vvdp.network.sense import is_ideal
from vvdp.network.text import Text


def is_found(search: PressureSearch) -> bool:
    """Whether the search ends. Traced graphs cannot branch: they go through all rounds, and it stays where it is."""
    return search.rounds >= ROUNDS


def is_found_compiled(search: PressureSearch) -> bool:
    """What stands for `is_found` in compiled code: rounds that change nothing are left out."""
    return search.rounds >= 2.0 and (search.high - search.low <= TOLERANCE or search.rounds >= ROUNDS)


def junction_lines(text: Text, name: str) -> list[str]:
    """Lines that calculate a junction and all parts that it joins.

    Raises NetworkError where a part needs oil there.
    """
    network, node = text.network, text.network.nodes[name]
    assert isinstance(node, Junction)
    parts = list(dict.fromkeys(met.part.name for met in text.places.ports_at(name)))
    for part in parts:
        _refuse(text, name, network.parts[part])
    around = _around(text, name, node.oil, parts)
    search = f"search_{name}"
    rounds = [
        f"{name} = {text.state_of(node.oil)}({search}.guess, {text.places.path(node.oil)})",
        *(f"{part} = {text.call(network.parts[part], network.parts[part].component.law)}" for part in parts),
        f"{search} = {text.use(next_search)}({search}, {text.inflow_sum(name)})",
        f"if {text.use(is_found)}({search}):",
        "    break",
    ]
    low, high = (_extreme_of(text.use(function), around) for function in (minimum, maximum))
    return [
        f"{search} = {text.use(begin_search)}({low}, {high})",
        "while True:",
        *indent(rounds),
    ]


def _around(text: Text, name: str, oil: Oil, parts: list[str]) -> list[str]:
    """The pressures at the other hydraulic ports of the parts at a junction; that of the tank without any."""
    all_parts = text.network.parts
    nodes = dict.fromkeys(
        all_parts[part].nodes[port] for part in parts for port in all_parts[part].component.hydraulic_ports
    )
    reference = f"{text.places.path(oil)}.reference_pressure"
    return [f"{node}.pressure" for node in nodes if node != name] or [reference]


def _extreme_of(function: str, values: list[str]) -> str:
    first, *others = values
    return f"{function}({first}, {_extreme_of(function, others)})" if others else first


def _refuse(text: Text, name: str, part: Part) -> None:
    """Raises NetworkError where a part at a junction needs oil there, or where another unknown stands beside it."""
    nodes = text.network.nodes
    others = [other for port in part.component.hydraulic_ports if (other := part.nodes[port]) != name]
    unknown = [other for other in others if isinstance(nodes[other], Junction)]
    at_walls = any(part.nodes[port] == name for port in part.component.wall_ports)
    if at_walls or is_ideal(part):
        why = (
            "moves a wall there"
            if at_walls
            else "is ideal (override_pressure 0): it takes what is left over in a volume"
        )
        raise NetworkError(f"{part.name} {why}, and the junction {name!r} holds no oil; make it a volume")
    if unknown:
        raise NetworkError(
            f"{part.name} joins the junctions {name!r} and {unknown[0]!r}, whose pressures would have to be found "
            "together; make one of them a volume, such as 10 cc"
        )
    if heat_balance(text.network) or any(has_free_air(each) for each in nodes.values()):
        raise NetworkError(f"{name}: where heat or dissolved air is carried, each node needs oil; make it a volume")
