"""Whether pump, valves and cylinder can follow a cycle at all: reported before a run, with numbers.

Source  ours, docs/models/displacement-chapter6.md, where a function names no other.
"""

from typing import NamedTuple, TypeVar

import numpy as np

from vvdp.base.errors import ParameterError
from vvdp.base.kinds import VOLUME, Pressure
from vvdp.base.params import Params
from vvdp.base.rules import require_positive_value
from vvdp.base.signal import Signal
from vvdp.control.displacement import DisplacementSettings
from vvdp.control.reference import ReferenceFilter
from vvdp.hydraulics.cylinder import Cylinder
from vvdp.hydraulics.friction import RodFriction, rod_friction_force
from vvdp.network.network import Network, Part, ProgramPart
from vvdp.network.nodes import Chamber, OilVolume, Rod, Source
from vvdp.programs.pulses import Cycle
from vvdp.programs.report import origin

Values = TypeVar("Values", bound=Params)


class SteadyPressures(NamedTuple):
    """Pressures of supply and return chamber at a steady speed, gauge."""

    supply: Pressure
    returned: Pressure


class Move(NamedTuple):
    """A line of a cycle: its speed [m/s], the key of the file that sets it, and its row, empty in a triangle."""

    velocity: float
    path: str
    row: str


def refuse_out_of_reach(network: Network, name: str) -> None:
    """Raises ParameterError for dead volumes of zero, and, where the law reads the rod of a cylinder and the reference
    of a cycle, for a stroke outside the cylinder, a speed beyond the pump, and a load that takes more than the highest
    pressure."""
    law = network.programs[name]
    refuse_empty_chambers(network, law)
    rod = network.nodes.get(str(law.reads["position"]).removesuffix(".position"))
    if not isinstance(rod, Rod):
        return
    parts = [part for part in network.parts.values() if rod.name in part.nodes.values()]
    cylinder = next(filter(None, (values_of(Cylinder, part) for part in parts)), None)
    cycle = cycle_behind(network, law.reads["reference"])
    if cylinder is not None and cycle is not None:
        refuse_stroke(network, rod, cycle, cylinder)
        reach = Reach(law, cylinder, tuple(parts), network.oil.reference_pressure)
        for move in moves_of(cycle):
            refuse_speed(reach, move)
            refuse_loads(reach, move)


def values_of(cls: type[Values], part: Part) -> Values | None:
    """The values of a class that a component has; None without."""
    return next((values for values in part.values if isinstance(values, cls)), None)


def cycle_behind(network: Network, source: Source) -> ProgramPart | None:
    """The program `cycle` that a source is, or that a reference filter there reads; None without."""
    program, _ = origin(network, source)
    if program is not None and isinstance(program.settings, ReferenceFilter):
        program, _ = origin(network, program.reads["reads"])
    return program if program is not None and isinstance(program.settings, Cycle) else None


class Reach(NamedTuple):
    """A law with its cylinder, the components at its rod, and the pressure outside, absolute [Pa]."""

    law: ProgramPart
    cylinder: Cylinder
    parts: tuple[Part, ...]
    reference_pressure: float

    @property
    def settings(self) -> DisplacementSettings:
        """Settings of the law."""
        settings = self.law.settings
        assert isinstance(settings, DisplacementSettings)
        return settings


def refuse_empty_chambers(network: Network, law: ProgramPart) -> None:
    """Raises ParameterError where a chamber that a law reads has no volume."""
    for key in ("pressure_a", "pressure_b"):
        node = network.nodes.get(str(law.reads[key]).removesuffix(".pressure"))
        if isinstance(node, OilVolume) and isinstance(node.values, Chamber):
            require_positive_value(f"nodes.{node.name}.volume", node.values.volume, VOLUME)


def refuse_stroke(network: Network, rod: Rod, cycle: ProgramPart, cylinder: Cylinder) -> None:
    """Raises ParameterError where a cycle, or the position at which a run begins, lies outside the cylinder."""
    assert isinstance(cycle.settings, Cycle)
    positions = cycle.settings.values
    low, high = ("lower_end", "stroke") if cycle.settings.stroke_time > 0.0 else ("values", "values")
    for path, position in (
        (f"nodes.{rod.name}.position", network.start_value(rod.position)),
        (f"programs.{cycle.name}.{low}", min(positions)),
        (f"programs.{cycle.name}.{high}", max(positions)),
    ):
        if not 0.0 <= position <= cylinder.stroke:
            raise ParameterError(
                f"{path}: {1e3 * position:.4g} mm is asked for; the cylinder goes from 0 mm to "
                f"{1e3 * cylinder.stroke:.4g} mm"
            )


def moves_of(cycle: ProgramPart) -> list[Move]:
    """The lines of a cycle along which something moves."""
    assert isinstance(cycle.settings, Cycle)
    is_triangle = cycle.settings.stroke_time > 0.0
    path = f"programs.{cycle.name}.{'stroke_time' if is_triangle else 'times'}"
    speeds = enumerate(np.diff(cycle.settings.values) / np.diff(cycle.settings.times), 2)
    return [Move(float(v), path, "" if is_triangle else f"row {row}: ") for row, v in speeds if v != 0.0]


def refuse_speed(reach: Reach, move: Move) -> None:
    """Raises ParameterError if a line of a cycle needs more flow than the law can command."""
    area = reach.cylinder.area_a if move.velocity > 0.0 else reach.cylinder.area_b
    largest, speed = reach.settings.split.largest_flow, abs(move.velocity)
    if speed > largest / area:
        raise ParameterError(
            f"{move.path}: {move.row}{1e3 * speed:.4g} mm/s take {6e4 * area * speed:.4g} lpm; at most "
            f"{6e4 * largest:.4g} lpm are asked of the pump (largest_flow of {reach.law.name}), "
            f"{1e3 * largest / area:.4g} mm/s"
        )


def steady_pressures(reach: Reach, velocity: float, load: float) -> SteadyPressures:
    """Lowest pressures at which the cylinder goes at a steady speed [Pa, gauge].

    The return valve is open as far as it goes, unless the supply chamber would fall below its lower bound P_lo:
    P_s A_s - P_r A_r = b |v| - u_d F_L, P_r >= (A_r v/K_v)^2, P_s >= P_lo.

    velocity  [m/s]
    load      F_L, in the direction of the position [N]
    """
    a, b, settings = reach.cylinder.area_a, reach.cylinder.area_b, reach.settings
    supply_area, return_area = (a, b) if velocity > 0.0 else (b, a)
    frictions = filter(None, (values_of(RodFriction, part) for part in reach.parts))
    needed = abs(sum(rod_friction_force(velocity, each) for each in frictions)) - np.sign(velocity) * load
    open_valve = (return_area * velocity / settings.cylinder.return_conductance) ** 2
    lowest = settings.bounds.lowest_pressure - reach.reference_pressure
    supply = max((needed + open_valve * return_area) / supply_area, lowest)
    return SteadyPressures(supply, (supply * supply_area - needed) / return_area)


def refuse_loads(reach: Reach, move: Move) -> None:
    """Raises ParameterError where a prescribed force on the rod takes more than the highest pressure."""
    highest = reach.settings.bounds.highest_pressure - reach.reference_pressure
    forces = {part.name: part.inputs.get("force") for part in reach.parts}
    for name, force in forces.items():
        for load in force.extremes if isinstance(force, Signal) else ():
            for chamber, pressure in steady_pressures(reach, move.velocity, load)._asdict().items():
                if pressure > highest:
                    raise ParameterError(
                        f"components.{name}.force: {load:.4g} N at {1e3 * move.velocity:.4g} mm/s takes "
                        f"{pressure / 1e5:.4g} bar in the {CHAMBERS[chamber]} chamber; highest_pressure of "
                        f"{reach.law.name} is {highest / 1e5:.4g} bar"
                    )


CHAMBERS = {"supply": "supply", "returned": "return"}
"""Words for the chambers of `SteadyPressures`."""
