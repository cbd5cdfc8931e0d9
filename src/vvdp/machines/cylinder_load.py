"""The cylinder with what it moves, as a part of any network: chambers, rod, friction, end stops, a force from outside.

Source  wang2017, section 6.1
"""

from vvdp.base.kinds import Position, Pressure
from vvdp.base.params import Params
from vvdp.control.duty_cycle import DutyCycle, resting_pressures
from vvdp.hydraulics.cylinder import Cylinder

LOW_SIDE = 5e5
"""At which a side that carries nothing starts where no supply holds it, gauge [Pa]."""
CHAMBERS = ("chamber_a", "chamber_b")
"""Names of the volumes at both sides of the piston, with their hoses."""


class InitialCylinder(Params):
    """Where a run starts: `position` of the rod, at rest, and the pressures of both chambers and of what feeds them."""

    position: Position
    pressure_a: Pressure
    pressure_b: Pressure
    supply_pressure: Pressure


def start_at_rest(
    cycle: DutyCycle, cylinder: Cylinder, reference_pressure: float, level: float, supply: float | None = None
) -> InitialCylinder:
    """Where a run starts: at rest under the first force of a cycle, the lower side at `level`, absolute [Pa].

    reference_pressure  that of the outside, absolute [Pa]
    supply              pressure of what feeds the cylinder, absolute [Pa]; that of the higher side where none is given
    """
    a, b = resting_pressures(cycle.forces[0], level - reference_pressure, cylinder)
    return InitialCylinder(
        position=cycle.positions[0],
        pressure_a=reference_pressure + a,
        pressure_b=reference_pressure + b,
        supply_pressure=reference_pressure + max(a, b) if supply is None else supply,
    )
