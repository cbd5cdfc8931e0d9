"""Where the values of a drawn circuit stand among its parameters, by their paths in the file, and how they change."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from vvdp.base.errors import ParameterError
from vvdp.base.params import Params, field_names
from vvdp.base.signal import Signal, constant
from vvdp.network.build import Circuit
from vvdp.network.network import Part
from vvdp.network.nodes import Connection, Node, OilVolume

STARTS = ("start", "angle", "speed", "position", "velocity")
"""Keys of a node that say where a run starts, where no source prescribes them."""


def value_place(circuit: Circuit, path: str) -> str:
    """Where a value stands among the parameters, such as `pump_shaft_speed` or `relief_valve.cracking_pressure`.

    path  full path in the file: `nodes.pump_shaft.speed`, `components.relief_valve.cracking_pressure`, `oil.density`,
          `operation.oil_temperature`; without a key that of all values of a node or component

    Raises ParameterError if there is no such value.
    """
    group, _, rest = path.partition(".")
    name, _, key = rest.partition(".")
    network = circuit.network
    found = None
    if group == "oil":
        found = _within(circuit, network.oil, rest)
    elif path == "operation.oil_temperature":
        found = circuit.place(network.temperature)
    elif group == "nodes" and name in network.nodes:
        found = _node_place(circuit, network.nodes[name], key)
    elif group == "components" and name in network.parts:
        found = _part_place(circuit, network.parts[name], key)
    if found is None:
        raise ParameterError(f"{path}: the circuit has no such value")
    return found


def _node_place(circuit: Circuit, node: Node, key: str) -> str | None:
    """That of a value of a node: where it starts, what prescribes it, or how large it is."""
    given = getattr(node, key, None) if key else None
    if isinstance(given, Signal):
        return circuit.place(given)
    if key in STARTS and isinstance(given, float):
        return f"start.{node.name}" if isinstance(node, OilVolume) else f"start.{node.name}_{key}"
    return _within(circuit, getattr(node, "values", None), key)


def _part_place(circuit: Circuit, part: Part, key: str) -> str | None:
    """That of a value of a component, of an input, or of what a file says instead of an input."""
    for name, source in part.inputs.items():
        other = part.component.alternatives.get(name)
        is_other = other is not None and other.name == key
        if is_other and isinstance(source, Connection) and isinstance(first := source.sources[0], Signal):
            return circuit.place(first)
        if name == key and isinstance(source, Signal):
            return circuit.place(source)
    found = (_within(circuit, value, key) for value in part.values)
    return next(filter(None, found), None)


def _within(circuit: Circuit, values: Params | None, key: str) -> str | None:
    """The place of a field of a parameter class, or of all of them; None if it has no such field."""
    if values is None or (key and key not in field_names(type(values))):
        return None
    return circuit.place(values) + (f".{key}" if key else "")


def value_at(params: Any, place: str) -> Any:
    """The value at a place among parameters."""
    for name in place.split("."):
        params = getattr(params, name)
    return params


def changed_values(params: Any, changes: Mapping[str, Any]) -> Any:
    """Parameters with other values by their places; a number [SI] may stand for a signal that does not change.

    Raises ParameterError if they contradict each other.
    """
    if not changes:
        return params
    tables: dict[str, dict[str, Any]] = {}
    for place, value in changes.items():
        is_held = isinstance(value_at(params, place), Signal) and not isinstance(value, Signal)
        table, _, key = place.partition(".")
        tables.setdefault(table, {})[key] = constant(float(value)) if is_held else value
    wholes = {name: inner.pop("", getattr(params, name)) for name, inner in tables.items()}
    return replace(params, **{name: replace(wholes[name], **inner) if inner else wholes[name]
                              for name, inner in tables.items()})  # fmt: skip
