"""The numbers of a summary by node and by component, as people read them."""

from collections.abc import Iterator, Mapping
from typing import NamedTuple

from vvdp.base.display import key_suffix, percent, with_unit
from vvdp.base.kinds import GAUGE_PRESSURE, MEAN_POWER, POSITION, SPEED, VELOCITY, Kind
from vvdp.base.signal import Signal
from vvdp.base.units import ATMOSPHERE
from vvdp.evaluation.bench_parts import shows_all
from vvdp.evaluation.bench_report import additions
from vvdp.evaluation.summary import is_closed
from vvdp.evaluation.validity import broken_bounds
from vvdp.network.network import Network, Part
from vvdp.network.nodes import DrivenShaft, HydraulicNode, Rod, Shaft
from vvdp.network.paths import flows_of, moving_parts
from vvdp.network.sense import idle_nodes
from vvdp.simulation.outcome import SETTLED
from vvdp.systems.plausibility import idle_orifices
from vvdp.systems.spool_travel import travel_warnings
from vvdp.systems.system import System

"""Remedy where a file draws another circuit than it names."""


class NodeLine(NamedTuple):
    """A line of a summary about a node: mean, lowest and highest of a quantity [SI; gauge]."""

    name: str
    quantity: str
    kind: Kind
    mean: float | None
    low: float
    high: float


class FlowLine(NamedTuple):
    """A mean flow of a component [tank volumes, m^3/s], with the port where it has several flows. A component that
    `sweeps` has volumes that a shaft or rod moves; what they take or give is none of this flow."""

    component: str
    port: str
    flow: float
    sweeps: bool = False


class LossLine(NamedTuple):
    """Loss of a component [W], whole and by its parts."""

    component: str
    loss: float
    parts: tuple[tuple[str, float], ...]


def inside(network: Network) -> frozenset[str]:
    """The nodes, components and programs inside of pipes and the like, which count as one component."""
    groups = network.groups.values()
    return frozenset(name for group in groups for name in (*group.nodes, *group.parts, *group.programs))


def node_lines(system: System, found: Mapping[str, float | bool]) -> Iterator[NodeLine]:
    """Pressures of hydraulic nodes, speeds of shafts, velocities and positions of rods, positions of other drives."""
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
    for name in moving_parts(network):
        low, high = (float(found[f"position_{which}_{name}_m"]) for which in ("min", "max"))
        yield NodeLine(name=name, quantity="position", kind=POSITION, mean=None, low=low, high=high)


def flow_lines(system: System, found: Mapping[str, float | bool]) -> Iterator[FlowLine]:
    """Mean flows of the components: one through each, or one into each port of those with more than two."""
    network = system.circuit.network
    hidden = inside(network)
    for part in network.parts.values():
        for name, port in flow_ports(part).items() if part.name not in hidden else ():
            flow = float(found[f"flow_mean_{name.removesuffix('_flow')}_m3_s"])
            yield FlowLine(part.name, port, flow, part.component.moves_walls)
    for name in network.groups:
        yield FlowLine(name, "", float(found[f"flow_mean_{name}_m3_s"]))


def flow_ports(part: Part) -> dict[str, str]:
    """The recorded flows of a component with the port that each enters; no port where it goes through."""
    return {f"{part.name}_{name}": name.removesuffix("flow").strip("_") for name in flows_of(part)}


def loss_lines(system: System, found: Mapping[str, float | bool]) -> Iterator[LossLine]:
    """Losses of the components."""
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


def circuit_loss_lines(system: System, found: Mapping[str, float | bool]) -> Iterator[LossLine]:
    """Losses of each part that is a circuit of its own, whole and by what is in it."""
    lines = tuple(loss_lines(system, found))
    for name, circuit in system.circuit.network.circuits.items():
        inner = (line for line in lines if line.component in circuit.names)
        parts = tuple((line.component.removeprefix(f"{name}_"), line.loss) for line in inner)
        yield LossLine(name, float(found[f"loss_{name}_W"]), parts)


def circuit_power_lines(system: System, found: Mapping[str, float | bool]) -> Iterator[tuple[str, float]]:
    """Powers from outside [W] into each part that is a circuit of its own, where there are any."""
    powers = dict(power_lines(system, found))
    for name, circuit in system.circuit.network.circuits.items():
        if inner := [power for source, power in powers.items() if source in circuit.names]:
            yield name, sum(inner)


def power_lines(system: System, found: Mapping[str, float | bool]) -> Iterator[tuple[str, float]]:
    """Powers from outside [W] through nodes and components: positive into the circuit."""
    network = system.circuit.network
    for name in (*network.nodes, *network.parts):
        if f"power_{name}_W" in found:
            yield name, float(found[f"power_{name}_W"])


def warnings(system: System, found: Mapping[str, float | bool]) -> Iterator[str]:
    """Warnings to read before the numbers of a summary, each in one line; the gravest first."""
    if "second_law" in found:
        yield from _impossible(system, found)
    if not found["finished"]:
        yield f"the run was interrupted at {found['duration_s']:.6g} s"
    yield from broken_bounds(system, found)
    for node in idle_nodes(system.circuit.network):
        yield f"{node} is joined to nothing: is a component missing?"
    yield from idle_orifices(system, found)
    reference = system.circuit.network.oil.reference_pressure
    if abs(reference - ATMOSPHERE) > 1.0:
        yield (
            f"pressures are printed above the oil's reference pressure of {reference / 1e5:.5g} bar absolute, and read "
            f"above the atmosphere's {ATMOSPHERE / 1e5:.5g} bar"
        )
    yield from travel_warnings(system)
    if not found["settled"] and expects_steady_state(system, found):
        yield (
            f"not settled: a mean would still change by more than {percent(SETTLED)} if the run went on; let it last "
            "longer (run.until), or average later (run.average_from)"
        )
    if not shows_all(system):
        yield from overloaded_drives(system, found)
    if own := additions(system):
        yield from own.warnings(found)


def overloaded_drives(system: System, found: Mapping[str, float | bool]) -> Iterator[str]:
    """A sentence for each driven shaft whose mean power exceeds the rated power of its drive."""
    for name, node in system.circuit.network.nodes.items():
        if isinstance(node, DrivenShaft) and found.get(f"power_{name}_W", 0.0) > node.rated_power:
            taken, rated = (with_unit(power, MEAN_POWER) for power in (found[f"power_{name}_W"], node.rated_power))
            yield f"{name} takes {taken} on average, more than the {rated} that its drive is rated for"


def _impossible(system: System, found: Mapping[str, float | bool]) -> Iterator[str]:
    """Impossible results of a run: balances that do not close, losses that give energy back."""
    if not is_closed(found):
        yield "the balances do not close: a residual is above the limit; try a tenth of run.relative_tolerance"
    if not found["second_law"]:
        yield f"the run cannot be: {impossible_part(system, found)}"


def impossible_part(system: System, found: Mapping[str, float | bool]) -> str:
    """The losses of a run that break the second law by giving energy back, in words, as far as means show them."""
    names = [
        (f"loss_{part.name}_{loss}_W" if loss else f"loss_{part.name}_W", kind)
        for part in system.circuit.network.parts.values()
        for loss, kind in part.component.losses.items()
    ]
    given = ", ".join(key for key, kind in names if kind and kind.low >= 0.0 and found.get(key, 0.0) < 0.0)
    return f"a loss gives energy back ({given})" if given else "a loss gives energy back, or a state left its range"


def expects_steady_state(system: System, found: Mapping[str, float | bool]) -> bool:
    """Whether a run should be in a steady state where its means are taken: nothing prescribed changes meanwhile, by its
    values or by its purpose.
    """
    window = found["averaged_from_s"], found["averaged_to_s"]
    steady = all(row.value.is_constant_within(*window) for row in system.rows if isinstance(row.value, Signal))
    return steady and ((own := additions(system)) is None or own.STEADY)


def period(system: System) -> str:
    """The word for the interval between two marks of a run."""
    own = additions(system)
    return "period" if own is None else own.PERIOD
