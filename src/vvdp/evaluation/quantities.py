"""Meaning of the keys of a summary: the kind of each and a user's words for it, by the names of the circuit."""

from collections.abc import Iterator, Mapping

from vvdp.base.kinds import (
    COUNT,
    DURATION,
    FLAG,
    FLOW,
    GAUGE_PRESSURE,
    LENGTH,
    MEAN_POWER,
    NUMBER,
    POSITION,
    RATIO,
    SPEED,
    VELOCITY,
    VOLUME,
    Kind,
)
from vvdp.evaluation.bench_report import additions
from vvdp.evaluation.control_stages import sequences
from vvdp.evaluation.heat_numbers import heat_quantities
from vvdp.evaluation.tank_levels import reservoirs
from vvdp.evaluation.valve_forms import placed_form_quantities
from vvdp.evaluation.valve_numbers import driven_spools, valve_quantities
from vvdp.fluid.dissolving import FREE_AIR
from vvdp.network.nodes import HydraulicNode, Rod, Shaft, can_boil, free_air_name, has_free_air
from vvdp.network.paths import flows_of, moving_parts
from vvdp.results.result import Number
from vvdp.systems.system import System

OF_ANY_RUN: Mapping[str, tuple[Kind, str]] = {
    "duration_s": (DURATION, "simulated time"),
    "finished": (FLAG, "finished"),
    "averaged_from_s": (DURATION, "start of the averaging window"),
    "averaged_to_s": (DURATION, "end of the averaging window"),
    "averaged_periods": (COUNT, "periods averaged"),
    "settled": (FLAG, "settled"),
    "stored_power_W": (MEAN_POWER, "power stored in the circuit"),
    "energy_residual": (NUMBER, "energy residual, of the throughput"),
    "mass_residual": (NUMBER, "oil residual, of the throughput"),
    "second_law": (FLAG, "no loss gives energy back, every state is possible"),
    "cavitation_volume": (FLAG, "a pressure falls below the cavitation limit"),
    "within_validity": (FLAG, "all laws within their range"),
    "trusted": (FLAG, "balances close, second law holds, laws within their range"),
    "steps": (COUNT, "steps"),
    "rejected_steps": (COUNT, "rejected steps"),
    "evaluations": (COUNT, "evaluations of the circuit"),
    "stiff_method": (FLAG, "stiff method at the end"),
    "wall_time_s": (DURATION, "wall time"),
}
"""Keys that every run has."""
EXTREMES = {"mean": "mean", "min": "lowest", "max": "highest"}


def quantities(system: System) -> dict[str, tuple[Kind, str]]:
    """Kind and label of every key that a summary of the system may have."""
    own = {} if (more := additions(system)) is None else dict(more.QUANTITIES)
    of_network = dict(_of_nodes(system)) | dict(_of_parts(system)) | dict(_of_tanks(system))
    of_network |= dict(heat_quantities(system)) | dict(_of_drives(system))
    return dict(OF_ANY_RUN) | of_network | dict(valve_quantities(system)) | dict(placed_form_quantities(system)) | own


def summary_units(system: System) -> dict[str, str]:
    """The SI unit of every key that a summary of the system may have."""
    return {key: kind.unit for key, (kind, _) in quantities(system).items()}


def summary_numbers(system: System, found: Mapping[str, float | bool]) -> dict[str, Number]:
    """The values of a summary with their kinds; what a user's own circuit adds without a kind is a plain number."""
    known = quantities(system)
    return {key: Number(float(value), *known.get(key, (NUMBER, key.replace("_", " ")))) for key, value in found.items()}


def _of_nodes(system: System) -> Iterator[tuple[str, tuple[Kind, str]]]:
    for name, node in system.circuit.network.nodes.items():
        words = name.replace("_", " ")
        if can_boil(node):
            yield f"vapour_mean_{name}_m3", (VOLUME, f"vapour in {words}, mean")
        if has_free_air(node):
            yield f"free_air_mean_{name}", (FREE_AIR, f"free air in {words} per tank volume, mean")
            yield f"loss_{free_air_name(name)}_W", (MEAN_POWER, f"{words} loss by air that dissolves and comes out")
        for which, label in EXTREMES.items():
            if isinstance(node, HydraulicNode):
                yield f"pressure_{which}_{name}_Pa", (GAUGE_PRESSURE, f"{words} pressure, {label}")
            elif isinstance(node, Shaft) or name in driven_spools(system.circuit.network):
                yield f"speed_{which}_{name}_rad_s", (SPEED, f"{words} speed, {label}")
            elif isinstance(node, Rod):
                yield f"velocity_{which}_{name}_m_s", (VELOCITY, f"{words} velocity, {label}")
                yield f"position_{which}_{name}_m", (POSITION, f"{words} position, {label}")


def _of_parts(system: System) -> Iterator[tuple[str, tuple[Kind, str]]]:
    network = system.circuit.network
    for name in (*network.nodes, *network.parts):
        yield f"power_{name}_W", (MEAN_POWER, f"power given by {name.replace('_', ' ')}")
    for part in network.parts.values():
        for flow in (*flows_of(part), *(name for name in part.component.outputs if name.endswith("_flow"))):
            key = f"{part.name}_{flow}".removesuffix("_flow")
            yield f"flow_mean_{key}_m3_s", (FLOW, f"{key.replace('_', ' ')} flow, mean")
        yield f"flow_mean_{part.name}_m3_s", (FLOW, f"{part.name.replace('_', ' ')} flow, mean")
        for flow in flows_of(part):
            key = f"{part.name}_{flow}".removesuffix("_flow")
            yield f"flow_actual_mean_{key}_m3_s", (FLOW, f"{key.replace('_', ' ')} actual flow, mean")
        for loss in ("", *part.component.losses):
            key = "_".join(filter(None, (part.name, loss)))
            yield f"loss_{key}_W", (MEAN_POWER, f"{key.replace('_', ' ')} loss")
    for name in moving_parts(network):
        for which in ("min", "max"):
            yield f"position_{which}_{name}_m", (POSITION, f"{name.replace('_', ' ')} position, {EXTREMES[which]}")
    for circuit in network.circuits:
        yield f"loss_{circuit}_W", (MEAN_POWER, f"{circuit.replace('_', ' ')} loss")
    for whole in network.groups:
        yield f"flow_mean_{whole}_m3_s", (FLOW, f"{whole.replace('_', ' ')} flow, mean")
        yield f"flow_actual_mean_{whole}_m3_s", (FLOW, f"{whole.replace('_', ' ')} actual flow, mean")
        yield f"loss_{whole}_W", (MEAN_POWER, f"{whole.replace('_', ' ')} loss")
        yield f"wave_roughness_{whole}", (RATIO, f"roughness of the waves in {whole.replace('_', ' ')}")


def _of_drives(system: System) -> Iterator[tuple[str, tuple[Kind, str]]]:
    for name in sequences(system.circuit.network):
        label = f"time in which {name.replace('_', ' ')} did not control its drive"
        yield f"uncontrolled_time_{name}_s", (DURATION, label)


def _of_tanks(system: System) -> Iterator[tuple[str, tuple[Kind, str]]]:
    for name in reservoirs(system.circuit.network):
        for which in ("min", "max"):
            yield f"level_{which}_{name}_m", (LENGTH, f"{name.replace('_', ' ')} level, {EXTREMES[which]}")
