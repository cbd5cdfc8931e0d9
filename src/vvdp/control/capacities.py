"""Controller model of a single-rod cylinder behind a directional valve, and the effect of a flow on its force.

The chamber that the pump feeds is the supply chamber, the other the return chamber; direction 1 feeds chamber a.

Source  ours, docs/models/displacement-control.md, where a function names no other.
"""

from typing import Annotated, NamedTuple

import numpy as np

from vvdp.base.kinds import (
    Area,
    BulkModulus,
    Compliance,
    FlowCoefficient,
    Kind,
    Mass,
    Position,
    Pressure,
    ViscousFriction,
    Volume,
)
from vvdp.base.params import Params, field_values
from vvdp.base.rules import POSITIVE, refuse, require_less, require_positive
from vvdp.base.select import clip, maximum, select
from vvdp.hydraulics.volume import GasExponent, GasPressure, VesselSize, wall_capacity

HYDRAULIC_STIFFNESS = Kind("hydraulic stiffness", "N/m", 0.0, 1e15, "3e6 N/m")
FORCE_PER_VOLUME = Kind("force per volume", "N/m^3", -1e15, 1e15, "1e9 N/m^3")

HydraulicStiffness = Annotated[float, HYDRAULIC_STIFFNESS]
ForcePerVolume = Annotated[float, FORCE_PER_VOLUME]


class SupplyLine(VesselSize):
    """The line from pump to directional valve, with its accumulator; an `oil_volume` of 0 is without line."""


class CylinderBelief(Params):
    """Controller model of the oil, the load and the return valve of a cylinder: m x'' = F_H - b x' + F_L.

    `oil_volume_a` and `oil_volume_b` are those of the chambers with their hoses at position 0; chamber a grows with
    the position. `return_conductance` is K_v of the return valve, fully open.
    """

    oil_volume_a: Volume
    oil_volume_b: Volume
    moving_mass: Mass
    viscous_friction: ViscousFriction
    bulk_modulus: BulkModulus
    return_conductance: FlowCoefficient


class CylinderEnds(Params):
    """Areas of a cylinder on its sides a and b, and the positions of its ends."""

    area_a: Area
    area_b: Area
    lowest_position: Position
    highest_position: Position


class CylinderModel(CylinderBelief, CylinderEnds):
    """Controller model of a cylinder, with the line to it. `reference_pressure` acts on the rod.

    Raises `ParameterError` where an area, the mass, the return valve or a volume within `stroke` is not above 0.
    """

    line: SupplyLine
    tank_pressure: Pressure
    reference_pressure: Pressure = 101325.0

    def check(self) -> None:
        require_positive(self, "area_a", "area_b", "moving_mass", "return_conductance")
        require_less(self, "lowest_position", "highest_position")
        least_a = self.oil_volume_a + self.area_a * self.lowest_position
        least_b = self.oil_volume_b - self.area_b * self.highest_position
        for name, volume in (("oil_volume_a", least_a), ("oil_volume_b", least_b)):
            if not volume > 0.0:
                left = f"{1e6 * volume:g} cc"
                refuse(self, name, f"is too little: the chamber has {left} at the end of the stroke, which {POSITIVE}")


class LineBelief(Params):
    """Controller model of the line from pump to directional valve, with its accumulator."""

    line_volume: Volume
    hose_compliance: Compliance
    gas_volume: Volume
    precharge_pressure: GasPressure
    gas_exponent: GasExponent


def cylinder_model(belief: CylinderBelief, ends: CylinderEnds, line: LineBelief, tank_pressure: float) -> CylinderModel:
    """The cylinder of a controller, from its tables.  tank_pressure: absolute [Pa]. Raises ParameterError."""
    known = field_values(CylinderBelief, belief) | field_values(CylinderEnds, ends)
    supply_line = SupplyLine(
        oil_volume=line.line_volume,
        hose_compliance=line.hose_compliance,
        gas_volume=line.gas_volume,
        precharge_pressure=line.precharge_pressure,
        gas_exponent=line.gas_exponent,
    )
    return CylinderModel(line=supply_line, tank_pressure=tank_pressure, **known)


class CircuitPressures(NamedTuple):
    """Pressures of both chambers and of the line, absolute."""

    pressure_a: Pressure
    pressure_b: Pressure
    line_pressure: Pressure


class Capacities(NamedTuple):
    """Effect of flows and motion on the force of the oil: F_H' = H Q + G Psi u - S x'.

    `supply_gain` H and `return_gain` G have the sign of the direction; `stiffness` S is beta L of a bare cylinder.
    """

    supply_gain: ForcePerVolume
    return_gain: ForcePerVolume
    stiffness: HydraulicStiffness


class Sides(NamedTuple):
    """Areas and pressures of the supply and of the return chamber."""

    supply_area: Area
    return_area: Area
    supply_pressure: Pressure
    return_pressure: Pressure


def sides(direction: float, pressures: CircuitPressures, cylinder: CylinderModel) -> Sides:
    """The chambers by what they are connected to.  direction: 1 or -1 [1]."""
    a, b = cylinder.area_a, cylinder.area_b
    Pa, Pb = pressures.pressure_a, pressures.pressure_b
    extends = direction > 0.0
    return Sides(select(extends, a, b), select(extends, b, a), select(extends, Pa, Pb), select(extends, Pb, Pa))


def capacities(direction: float, position: float, line_pressure: float, cylinder: CylinderModel) -> Capacities:
    """H = A_s/C_s, G = A_r/C_r and S = A_s^2/C_s + A_r^2/C_r; C_s = (V_s + V_L)/beta + C_L(P_L), C_r = V_r/beta.

    C_L is the room that the line's walls and its gas give per pressure.

    direction      1 or -1 [1]
    position       [m]
    line_pressure  absolute [Pa]

    Source  wang2017, eqs. 6.4 and 6.5; with line and accumulator ours, docs/models/displacement-control.md
    """
    beta, line = cylinder.bulk_modulus, cylinder.line
    x = clip(position, cylinder.lowest_position, cylinder.highest_position)
    Va, Vb = cylinder.oil_volume_a + cylinder.area_a * x, cylinder.oil_volume_b - cylinder.area_b * x
    extends = direction > 0.0
    As, Ar = select(extends, cylinder.area_a, cylinder.area_b), select(extends, cylinder.area_b, cylinder.area_a)
    Vs, Vr = select(extends, Va, Vb), select(extends, Vb, Va)
    Cs, Cr = (Vs + line.oil_volume) / beta + wall_capacity(line_pressure, line), Vr / beta
    return Capacities(direction * As / Cs, direction * Ar / Cr, As * As / Cs + Ar * Ar / Cr)


def oil_force(pressures: CircuitPressures, cylinder: CylinderModel) -> float:
    """F_H = (P_a - P_0) A_a - (P_b - P_0) A_b [N].

    Source  wang2017, eq. 6.3
    """
    P0 = cylinder.reference_pressure
    return (pressures.pressure_a - P0) * cylinder.area_a - (pressures.pressure_b - P0) * cylinder.area_b


def return_flow(return_pressure: float, least_flow: float, cylinder: CylinderModel) -> float:
    """Psi [m^3/s]: flow through the return valve, fully open; at least `least_flow`, so that it can be divided by.

    return_pressure  of the return chamber, absolute [Pa]
    least_flow       above 0 [m^3/s]

    Source  wang2017, eq. 6.5; the floor is ours, docs/models/displacement-control.md
    """
    drop = return_pressure - cylinder.tank_pressure
    return maximum(cylinder.return_conductance * np.sqrt(maximum(drop, 0.0)), least_flow)
