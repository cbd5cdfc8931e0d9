"""Whether pump, valves and cylinder can follow a cycle at all: reported before a run, with numbers.

Source  ours, docs/models/displacement-chapter6.md, where a function names no other.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from vvdp.base.errors import ParameterError
from vvdp.base.kinds import VOLUME, Pressure
from vvdp.base.rules import require_positive_value
from vvdp.base.signal import Signal
from vvdp.components.directed_flows import ReturnThrottle
from vvdp.control.flow_split import FlowSplit
from vvdp.control.pressure_modes import PressureBounds
from vvdp.fluid.oil import Oil
from vvdp.hydraulics.cylinder import Cylinder
from vvdp.hydraulics.flow_source import LaggingSource
from vvdp.hydraulics.friction import RodFriction, rod_friction_force
from vvdp.network.nodes import Chamber, Load
from vvdp.programs.machine.cycle import OwnCycle, Points, Triangle, points_of


@dataclass(frozen=True, kw_only=True)
class Chapter6Plant:
    """What moves a load: cylinder with what oil is left at its ends, friction, pump, return valve, and the oil."""

    cylinder: Cylinder
    chamber_a: Chamber
    chamber_b: Chamber
    load: Load
    friction: RodFriction
    pump: LaggingSource
    flow_split: FlowSplit
    return_valve: ReturnThrottle
    oil: Oil


class SteadyPressures(NamedTuple):
    """Pressures of supply and return chamber at a steady speed, gauge."""

    supply: Pressure
    returned: Pressure


def refuse_impossible(
    plant: Chapter6Plant, cycle: Triangle | OwnCycle, bounds: PressureBounds, load: Signal, start: float
) -> None:
    """Raises ParameterError for dead volumes of zero, a stroke outside the cylinder, a speed beyond pump or return
    valve, and a load that takes more than the highest pressure.

    start  position at which a run begins [m]
    """
    for name, chamber in (("chamber_a", plant.chamber_a), ("chamber_b", plant.chamber_b)):
        require_positive_value(f"{name}.volume", chamber.volume, VOLUME)
    points = points_of(cycle)
    refuse_stroke(plant, cycle, points, start)
    rows = zip(np.diff(points.times), np.diff(points.positions), strict=True)
    for row, (time, way) in enumerate(rows, 2):
        if way != 0.0:
            _refuse_speed(plant, way / time, "" if isinstance(cycle, Triangle) else f"row {row}: ")
            for force in load.extremes:
                _refuse_load(plant, way / time, force, bounds)


def refuse_stroke(plant: Chapter6Plant, cycle: Triangle | OwnCycle, points: Points, start: float) -> None:
    """Raises ParameterError where a cycle, or the position at which a run begins, lies outside the cylinder [m]."""
    keys = ("lower_end", "stroke") if isinstance(cycle, Triangle) else ("positions", "positions")
    asked = (("cycle." + keys[0], min(points.positions)), ("cycle." + keys[1], max(points.positions)))
    for key, position in (("initial.position", start), *asked):
        if not 0.0 <= position <= plant.cylinder.stroke:
            raise ParameterError(
                f"{key}: {1e3 * position:.4g} mm is asked for; the cylinder goes from 0 mm to "
                f"{1e3 * plant.cylinder.stroke:.4g} mm"
            )


def _refuse_speed(plant: Chapter6Plant, velocity: float, row: str) -> None:
    area = plant.cylinder.area_a if velocity > 0.0 else plant.cylinder.area_b
    fastest = plant.flow_split.largest_flow / area
    if abs(velocity) > fastest:
        raise ParameterError(
            f"cycle.{'times' if row else 'stroke_time'}: {row}{1e3 * abs(velocity):.4g} mm/s take "
            f"{6e4 * area * abs(velocity):.4g} lpm; at most {6e4 * plant.flow_split.largest_flow:.4g} lpm "
            f"are asked of the pump (flow_split.largest_flow), {1e3 * fastest:.4g} mm/s"
        )


def steady_pressures(plant: Chapter6Plant, velocity: float, load: float, lowest: float) -> SteadyPressures:
    """Lowest pressures at which the cylinder goes at a steady speed [Pa, gauge].

    The return valve is open as far as it goes, unless the supply chamber would fall below `lowest`:
    P_s A_s - P_r A_r = b |v| - u_d F_L, P_r >= (A_r v/K_v)^2.

    velocity  [m/s]
    load      F_L, in the direction of the position [N]
    lowest    pressure of the supply chamber [Pa, gauge]
    """
    a, b = plant.cylinder.area_a, plant.cylinder.area_b
    supply_area, return_area = (a, b) if velocity > 0.0 else (b, a)
    needed = abs(rod_friction_force(velocity, plant.friction)) - np.sign(velocity) * load
    open_valve = (return_area * velocity / plant.return_valve.conductance) ** 2
    supply = max((needed + open_valve * return_area) / supply_area, lowest)
    return SteadyPressures(supply, (supply * supply_area - needed) / return_area)


def _refuse_load(plant: Chapter6Plant, velocity: float, load: float, bounds: PressureBounds) -> None:
    reference = plant.oil.reference_pressure
    highest, lowest = bounds.highest_pressure - reference, bounds.lowest_pressure - reference
    found = steady_pressures(plant, velocity, load, lowest)
    for chamber, pressure in (("supply", found.supply), ("return", found.returned)):
        if pressure > highest:
            raise ParameterError(
                f"operation.load_force: {load:.4g} N at {1e3 * velocity:.4g} mm/s takes {pressure / 1e5:.4g} bar in "
                f"the {chamber} chamber; pressure_bounds.highest_pressure is {highest / 1e5:.4g} bar"
            )
