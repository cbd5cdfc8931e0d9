"""What a machine cannot do, reported before it is run, with numbers.

Source  ours, docs/models/whole-machine.md
"""

from typing import NamedTuple

from vvdp.base.errors import ParameterError
from vvdp.components.directional_valves import ThrottledDirectionalValve
from vvdp.hydraulics.cylinder import Cylinder
from vvdp.hydraulics.friction import RodFriction
from vvdp.hydraulics.relief_valve import ReliefValve
from vvdp.hydraulics.rod import EndStop
from vvdp.hydraulics.volume import Vessel


class CylinderDuty(NamedTuple):
    """What a cylinder is asked to do: the force on its rod at its least and at its greatest, in the direction of the
    position [N], and the speed [m/s]; its return valve is open by `opening` [1]."""

    least_force: float
    greatest_force: float
    speed: float
    opening: float


class WorkingPressures(NamedTuple):
    """Supply pressures that extending and retracting take, over the tank's [Pa]."""

    extending: float
    retracting: float


def working_pressures(
    duty: CylinderDuty, cylinder: Cylinder, friction: RodFriction, valve: ThrottledDirectionalValve
) -> WorkingPressures:
    """Supply pressures at the most that a cylinder needs to move steadily [Pa], none below zero.

    P_s A_s = F + b v + F_c + P_r A_r with the return at P_r = (A_r v / (u K_r))^2, F what the load takes that way.

    >>> duty = CylinderDuty(-1000.0, -1000.0, 0.054, 0.8)
    >>> print([round(pressure / 1e5, 1) for pressure in working_pressures(duty, cylinder, friction, valve)])  # bar
    [7.4, 16.1]
    """
    resistance = friction.viscous_friction * duty.speed + friction.coulomb_friction

    def supply(load: float, area: float, other: float) -> float:
        back = (other * duty.speed / (duty.opening * valve.return_conductance)) ** 2
        return max((load + resistance + back * other) / area, 0.0)

    return WorkingPressures(
        extending=supply(-duty.least_force, cylinder.area_a, cylinder.area_b),
        retracting=supply(duty.greatest_force, cylinder.area_b, cylinder.area_a),
    )


def refuse_load(pressures: WorkingPressures, relief_valve: ReliefValve, tank_pressure: float) -> None:
    """Raises ParameterError where the load takes more than the relief valve lets the pump give.

    tank_pressure  absolute [Pa]
    """
    limit = relief_valve.cracking_pressure - tank_pressure
    for name, pressure in pressures._asdict().items():
        if pressure >= limit:
            raise ParameterError(
                f"operation.load_force: {name} takes {pressure / 1e5:.4g} bar in the supply; the relief valve opens at "
                f"{limit / 1e5:.4g} bar"
            )


def refuse_precharge(working_pressure: float, line: Vessel, tank_pressure: float) -> None:
    """Raises ParameterError where an accumulator is charged above all that the line ever works at: it would stay
    closed.

    working_pressure  highest of the line, over the tank's [Pa]
    tank_pressure     absolute [Pa]
    """
    precharge = line.precharge_pressure - tank_pressure
    if line.gas_volume > 0.0 and precharge >= working_pressure:
        raise ParameterError(
            f"line.precharge_pressure: {precharge / 1e5:.4g} bar; the line works at {working_pressure / 1e5:.4g} bar "
            "at most, at which no oil would enter the accumulator"
        )


def refuse_stops(cylinder: Cylinder, stops: EndStop) -> None:
    """Raises ParameterError where end stops let a cylinder leave its stroke."""
    if stops.lower_end < 0.0 or stops.upper_end > cylinder.stroke:
        raise ParameterError(
            f"cylinder_stops.upper_end: from {1e3 * stops.lower_end:.4g} to {1e3 * stops.upper_end:.4g} mm; the stroke "
            f"of the cylinder is {1e3 * cylinder.stroke:.4g} mm"
        )
