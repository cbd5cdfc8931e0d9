"""The numbers of a summary by node and by component, as a person reads them."""

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

from vvdp.base.display import key_suffix
from vvdp.base.kinds import GAUGE_PRESSURE, POSITION, SPEED, VELOCITY, Kind
from vvdp.network.network import Network, Part
from vvdp.network.nodes import HydraulicNode, OilVolume, Rod, Shaft
from vvdp.network.paths import flows_of
from vvdp.systems.system import System


class NodeLine(NamedTuple):
    """What a summary says of a node: mean, lowest and highest of a quantity [SI; gauge]."""

    name: str
    quantity: str
    kind: Kind
    mean: float | None
    low: float
    high: float


class FlowLine(NamedTuple):
    """A mean flow of a component [tank volumes, m^3/s], with the port where it has several flows."""

    component: str
    port: str
    flow: float


class LossLine(NamedTuple):
    """What a component turns to heat [W], whole and by its parts."""

    component: str
    loss: float
    parts: tuple[tuple[str, float], ...]


def inside(network: Network) -> frozenset[str]:
    """The nodes and components inside of pipes and the like, which count as one component."""
    return frozenset(name for group in network.groups.values() for name in (*group.nodes, *group.parts))


def node_lines(system: System, found: Mapping[str, Any]) -> Iterator[NodeLine]:
    """Pressures of hydraulic nodes, speeds of shafts, velocities and positions of rods."""
    network = system.circuit.network
    hidden = inside(network)
    for name, node in network.nodes.items():
        if name in hidden:
            continue
        if isinstance(node, HydraulicNode):
            mean, low, high = (float(found[f"pressure_{which}_{name}_Pa"]) for which in ("mean", "min", "max"))
            yield NodeLine(name=name, quantity="pressure", kind=GAUGE_PRESSURE, mean=mean, low=low, high=high)
        elif isinstance(node, Shaft | Rod):
            rate, kind = ("speed", SPEED) if isinstance(node, Shaft) else ("velocity", VELOCITY)
            ending = f"{name}{key_suffix(kind)}"
            mean, low, high = (float(found[f"{rate}_{which}_{ending}"]) for which in ("mean", "min", "max"))
            yield NodeLine(name=name, quantity=rate, kind=kind, mean=mean, low=low, high=high)
        if isinstance(node, Rod):
            low, high = (float(found[f"position_{which}_{name}_m"]) for which in ("min", "max"))
            yield NodeLine(name=name, quantity="position", kind=POSITION, mean=None, low=low, high=high)


def flow_lines(system: System, found: Mapping[str, Any]) -> Iterator[FlowLine]:
    """Mean flows of the components: one through each, or one into each port of those with more than two."""
    network = system.circuit.network
    hidden = inside(network)
    for part in network.parts.values():
        for name, port in flow_ports(part).items() if part.name not in hidden else ():
            yield FlowLine(part.name, port, float(found[f"flow_mean_{name.removesuffix('_flow')}_m3_s"]))
    for name in network.groups:
        yield FlowLine(name, "", float(found[f"flow_mean_{name}_m3_s"]))


def flow_ports(part: Part) -> dict[str, str]:
    """The recorded flows of a component with the port that each enters; no port where it goes through."""
    return {f"{part.name}_{name}": name.removesuffix("flow").strip("_") for name in flows_of(part)}


def loss_lines(system: System, found: Mapping[str, Any]) -> Iterator[LossLine]:
    """What the components turn to heat."""
    network = system.circuit.network
    hidden = inside(network)
    for part in network.parts.values():
        whole = f"loss_{part.name}_W"
        if whole in found and part.name not in hidden:
            inner = ((name, f"loss_{part.name}_{name}_W") for name in part.component.losses if name)
            parts = tuple((name, float(found[key])) for name, key in inner)
            yield LossLine(part.name, float(found[whole]), parts if len(parts) > 1 else ())
    for name in network.groups:
        yield LossLine(name, float(found[f"loss_{name}_W"]), ())


def power_lines(system: System, found: Mapping[str, Any]) -> Iterator[tuple[str, float]]:
    """What nodes and components give from outside [W]: positive into the circuit."""
    network = system.circuit.network
    for name in (*network.nodes, *network.parts):
        if f"power_{name}_W" in found:
            yield name, float(found[f"power_{name}_W"])


def lowest_volume(system: System, found: Mapping[str, Any]) -> tuple[str, float] | None:
    """The volume whose pressure fell lowest, and that pressure [Pa, absolute]; None in a circuit without volumes."""
    volumes = {n: node for n, node in system.circuit.network.nodes.items() if isinstance(node, OilVolume)}
    low = {n: float(found[f"pressure_min_{n}_Pa"]) + node.oil.reference_pressure for n, node in volumes.items()}
    name = min(low, key=lambda n: low[n], default=None)
    return None if name is None else (name, low[name])


def warnings(system: System, found: Mapping[str, Any]) -> Iterator[str]:
    """What a person has to know before the numbers of a summary, each in one line; the gravest first."""
    if not found.get("trusted", True):
        yield "the balances do not close: a residual is above the limit; try a tenth of run.relative_tolerance"
    if not found["finished"]:
        yield f"the run was interrupted at {found['duration_s']:.6g} s"
    lowest = lowest_volume(system, found)
    if found["cavitation"] and lowest is not None:
        yield f"the {lowest[0].replace('_', ' ')} pressure falls below the cavitation limit"
    if system.extras is not None:
        yield from system.extras.warnings(found)


def period(system: System) -> str:
    """What passes between two marks of a run."""
    return "period" if system.extras is None else system.extras.PERIOD
