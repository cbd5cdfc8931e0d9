"""Whether the laws of a system hold at what a run came to: bounds, each with its source, and sentences from them."""

from collections.abc import Iterator, Mapping

from vvdp.base.kinds import POSITION, PRESSURE_DIFFERENCE, TEMPERATURE
from vvdp.evaluation.bench_report import additions
from vvdp.evaluation.control_stages import reach_bounds, waiting_bounds
from vvdp.evaluation.heat_numbers import COLDEST, HOTTEST, temperature_bounds
from vvdp.evaluation.pipe_waves import wave_bounds
from vvdp.evaluation.sound_speeds import sound_bounds
from vvdp.evaluation.tank_levels import level_bounds
from vvdp.evaluation.valve_numbers import placed_valve_bounds
from vvdp.hydraulics.cylinder import Cylinder
from vvdp.network.nodes import HydraulicNode
from vvdp.systems.bound import Bound
from vvdp.systems.extras import LoadedSystem
from vvdp.systems.plausibility import plausible_bounds
from vvdp.systems.system import System
from vvdp.valve.validity import CAVITATION_PRESSURE

STOP_GIVES = 0.01
"""Of the stroke, by which end stops may give way: theirs are springs."""


def bounds(system: System, found: Mapping[str, float | bool]) -> Iterator[Bound]:
    """The bounds of all laws at what a run has `found`."""
    coldest, hottest = system.circuit.network.temperature.extremes
    yield Bound(
        label="oil temperature",
        kind=TEMPERATURE,
        low=coldest,
        high=hottest,
        least=COLDEST,
        most=HOTTEST,
        otherwise="the data sheet does not show the viscosity there",
    )
    least = -float("inf") if system.circuit.network.oil.vapour_pressure > 0.0 else cavitation_pressure(system)
    for number, (node, lowest) in enumerate(lowest_pressures(system, found) or [("", float("nan"))]):
        if number == 0 or lowest < least:
            yield Bound(
                label=f"lowest absolute pressure, at {node.replace('_', ' ')}",
                kind=PRESSURE_DIFFERENCE,
                low=lowest,
                high=lowest,
                least=least,
                otherwise="the oil cavitates, which its law leaves out; oil.vapour_pressure brings it in",
            )
    yield from plausible_bounds(system, found)
    yield from temperature_bounds(system, found)
    yield from wave_bounds(found)
    yield from sound_bounds(system, found)
    yield from level_bounds(system, found)
    yield from placed_valve_bounds(system, found)
    yield from waiting_bounds(system, found)
    yield from reach_bounds(system)
    yield from _strokes(system, found)
    if own := additions(system):
        yield from own.bounds(found)


def _strokes(system: LoadedSystem, found: Mapping[str, float | bool]) -> Iterator[Bound]:
    """Rods within the strokes of their cylinders; what an end stop gives way is none of it."""
    for part in system.circuit.network.parts.values():
        for cylinder in (each for each in part.values if isinstance(each, Cylinder)):
            rod, give = part.nodes["rod"], STOP_GIVES * cylinder.stroke
            low, high = (float(found[f"position_{end}_{rod}_m"]) for end in ("min", "max"))
            yield Bound(
                label=f"position of {rod.replace('_', ' ')}",
                kind=POSITION,
                low=0.0 if -give < low < 0.0 else low,
                high=cylinder.stroke if 0.0 < high - cylinder.stroke < give else high,
                least=0.0,
                most=cylinder.stroke,
                otherwise=f"the stroke of {part.name} is over there and only an end-stop holds the rod",
            )


def broken_bounds(system: System, found: Mapping[str, float | bool]) -> list[str]:
    """A sentence for every law that is used outside its range; empty where none is."""
    return [bound.sentence for bound in bounds(system, found) if not bound.is_kept]


def lowest_pressures(system: LoadedSystem, found: Mapping[str, float | bool]) -> list[tuple[str, float]]:
    """All nodes with oil, prescribed ones included, and how low they fell [Pa, absolute], the lowest first."""
    nodes = system.circuit.network.nodes.items()
    low = [
        (name, float(found[f"pressure_min_{name}_Pa"]) + node.oil.reference_pressure)
        for name, node in nodes
        if isinstance(node, HydraulicNode)
    ]
    return sorted(low, key=lambda each: each[1])


def lowest_pressure(system: LoadedSystem, found: Mapping[str, float | bool]) -> tuple[str, float]:
    """The node whose pressure fell lowest, prescribed ones included, and that pressure [Pa, absolute]."""
    return next(iter(lowest_pressures(system, found)), ("", float("nan")))


def cavitation_pressure(system: LoadedSystem) -> float:
    """Below which the oil of a system is held to cavitate [Pa, absolute]."""
    limits = system.tables.get("limits")
    return CAVITATION_PRESSURE if limits is None else float(limits.cavitation_pressure)
