"""Recognise the test rig of a rotary valve in a network: a pump unit that works on a load."""

from collections.abc import Mapping
from types import MappingProxyType

from vvdp.base.params import Params
from vvdp.base.signal import Signal, constant
from vvdp.evaluation.rig_drawing import COMPONENTS
from vvdp.hydraulics.check_valve import CheckValve
from vvdp.hydraulics.orifice import Orifice
from vvdp.hydraulics.pump import Pump
from vvdp.hydraulics.relief_valve import ReliefValve
from vvdp.hydraulics.soft_switching import Mouth
from vvdp.hydraulics.spool_drive import SpoolDrive
from vvdp.hydraulics.volume import Vessel
from vvdp.network.network import Network, Part
from vvdp.network.nodes import Chamber, Connection, DrivenShaft, OilVolume, PressureSource, Shaft, Tank
from vvdp.systems.extras import LoadedSystem
from vvdp.valve.rotary import RotaryValve

KINDS: Mapping[str, type[Params]] = MappingProxyType({
    "pump": Pump,
    "valve": RotaryValve,
    "relief_valve": ReliefValve,
    "coupling": SpoolDrive,
    "bypass": CheckValve,
    "mouth": Mouth,
    "load": Orifice,
})  # fmt: skip
"""Classes of the values of the components of a rig."""
UNIT = ("pump", "valve", "relief_valve")
"""Components that every rig has."""
SOFTENING = ("bypass", "mouth")
"""Those that switch it softly, which lose power beside the valve."""
SHAFTS = ("pump_shaft", "spool_motor")


def is_bench(system: LoadedSystem) -> bool:
    """Whether the network of a system is a test rig of a rotary valve, and its duty ratio is known.

    Nodes and components are called and joined as in `rig_drawing`, and nothing else joins the nodes but the tank, apart
    from what a fault of the file adds. The load is a vessel with an orifice to the tank, or a pressure source. What is
    prescribed is known over time.
    """
    network = system.circuit.network
    if network.extras is not None or not all(name in network.parts for name in UNIT):
        return False
    own = {name: joints(name) for name in KINDS if name in network.parts}
    inner = {node for nodes in own.values() for node in nodes.values()} - {"tank"}
    failing = {each.name for each in system.faults}
    others = (part for name, part in network.parts.items() if name not in own and name not in failing)
    return (
        all(_fits(network.parts[name], KINDS[name], nodes) for name, nodes in own.items())
        and not any(inner & {*part.nodes.values()} for part in others)
        and _has_nodes(network)
        and duty_signal(system) is not None
    )


def joints(name: str) -> dict[str, str]:
    """The node at each port of a component of a rig."""
    return {port: node for port, node in COMPONENTS[name].items() if port != "type"}


def shows_all(system: LoadedSystem) -> bool:
    """Whether what belongs to a system as a whole is all that a user is shown of its valves."""
    return is_bench(system) or (system.extras is not None and system.extras.IS_ALL)


def duty_signal(system: LoadedSystem) -> Signal | None:
    """What prescribes the duty ratio [1] or the axial position [m] of the component `valve`, else the duty ratio for
    which the file asks a program; None if it follows neither.
    """
    source = system.circuit.network.parts["valve"].inputs["axial_position"]
    first = source.sources[0] if isinstance(source, Connection) else source
    return first if isinstance(first, Signal) else asked_duty_ratio(system)


def asked_duty_ratio(system: LoadedSystem) -> Signal | None:
    """The duty ratio that a file states as `operation.duty_ratio` [1]; None if it states none."""
    for row in system.rows:
        if row.setting == "operation.duty_ratio":
            return row.value if isinstance(row.value, Signal) else constant(row.nominal)
    return None


def _fits(part: Part, kind: type[Params], nodes: Mapping[str, str]) -> bool:
    return any(isinstance(each, kind) for each in part.values) and nodes.items() <= part.nodes.items()


def _has_nodes(network: Network) -> bool:
    """Whether the nodes are those of a rig: one oil, a load, and shafts whose speed is known over time."""
    nodes, has_orifice = network.nodes, "load" in network.parts
    inlet, line = nodes["inlet"], nodes["load_line"]
    is_vessel = isinstance(line, OilVolume) and isinstance(line.values, Vessel) and has_orifice
    is_source = isinstance(line, PressureSource) and isinstance(line.pressure, Signal) and not has_orifice
    driven = [nodes[name] for name in SHAFTS if name in nodes]
    return (
        isinstance(inlet, OilVolume)
        and isinstance(inlet.values, Chamber)
        and inlet.oil is network.oil
        and (is_vessel or is_source)
        and isinstance(nodes["tank"], Tank)
        and isinstance(nodes["spool"], Shaft)
        and all(isinstance(each, DrivenShaft) and isinstance(each.speed, Signal) for each in driven)
    )
