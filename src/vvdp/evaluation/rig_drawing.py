"""The drawing of a test rig of a rotary valve: its nodes and components, and the paths of its values in a file."""

from collections.abc import Collection, Mapping
from types import MappingProxyType
from typing import Any

from vvdp.network.network import Network

NODES: Mapping[str, str] = MappingProxyType({
    "tank": "tank",
    "load_line": "vessel",
    "inlet": "volume",
    "pump_shaft": "driven-shaft",
    "spool_motor": "driven-shaft",
    "spool": "shaft",
})  # fmt: skip
"""Types of the nodes; without a load line, a pressure source has its name."""
COMPONENTS: Mapping[str, Mapping[str, str]] = MappingProxyType({
    "pump": {"type": "pump", "inlet": "tank", "outlet": "inlet", "shaft": "pump_shaft"},
    "valve": {"type": "rotary-valve", "inlet": "inlet", "load": "load_line", "tank": "tank", "spool": "spool"},
    "relief_valve": {"type": "relief-valve", "a": "inlet", "b": "tank"},
    "coupling": {"type": "drive-coupling", "motor": "spool_motor", "spool": "spool"},
    "bypass": {"type": "check-valve", "a": "inlet", "b": "load_line"},
    "mouth": {"type": "released-orifice", "a": "inlet", "b": "chamber"},
    "load": {"type": "orifice", "a": "load_line", "b": "tank"},
})  # fmt: skip
"""Types of the components and the node at each port."""
PATHS: Mapping[str, str] = MappingProxyType({
    "check_valve": "components.valve",
    "spool_drive": "components.coupling",
    "motor.rated_power": "nodes.pump_shaft.rated_power",
    "load.pressure": "nodes.load_line.pressure",
    "operation.pump_speed": "nodes.pump_shaft.speed",
    "operation.duty_ratio": "components.valve.duty_ratio",
    "operation.axial_position": "components.valve.axial_position",
    "operation.spool_motor_speed": "nodes.spool_motor.speed",
    "operation.tank_pressure": "nodes.tank.pressure",
    "initial.inlet_pressure": "nodes.inlet.start",
    "initial.load_pressure": "nodes.load_line.start",
    "initial.spool_speed": "nodes.spool.speed",
    "initial.spool_angle": "nodes.spool.angle",
    "limits.cavitation_pressure": "components.valve.cavitation_pressure",
})  # fmt: skip
"""Full paths of the values and tables that do not stand under the name of a node or component."""


def full_path(path: str, network: Network) -> str:
    """The full path of a value or table of a rig."""
    table, dot, key = path.partition(".")
    if path in PATHS:
        return PATHS[path]
    if table in PATHS:
        return PATHS[table] + dot + key
    groups: dict[str, Collection[str]] = {"nodes": network.nodes, "components": network.parts}
    return next((f"{group}.{path}" for group, names in groups.items() if table in names), path)


def drawing(components: Collection[str], *, has_line: bool) -> dict[str, dict[str, Any]]:
    """The tables [nodes], [components] and [values] of a rig with these components, and with a line and its orifice or
    a source.
    """
    own, source = {*components, *(["load"] if has_line else [])}, {} if has_line else {"load_line": "pressure-source"}
    values: dict[str, Any] = {}
    for path, full in PATHS.items():
        table, _, key = path.partition(".")
        if not key:
            values[table] = full
        elif path != ("load.pressure" if has_line else "initial.load_pressure"):
            values.setdefault(table, {})[key] = full
    return {
        "nodes": {name: {"type": kind} for name, kind in {**NODES, **source}.items()},
        "components": {name: dict(each) for name, each in COMPONENTS.items() if name in own},
        "values": values,
    }
