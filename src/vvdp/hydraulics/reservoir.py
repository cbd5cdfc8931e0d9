"""Tank whose level rises and falls: air above the oil, the head below it, a suction mouth that may run dry.

Source  ours, docs/models/components.md, where a function names no other.
"""

import numpy as np

from vvdp.base.conservation import Stored
from vvdp.base.kinds import (
    Area,
    DischargeCoefficient,
    Fraction,
    Length,
    Polytropic,
    Position,
    Pressure,
    PressureDifference,
    Volume,
)
from vvdp.base.modes import side
from vvdp.base.params import Params
from vvdp.base.powers import power
from vvdp.base.rules import refuse, require_less, require_positive
from vvdp.base.select import clip, select
from vvdp.hydraulics.rod import GRAVITY


class Reservoir(Params):
    """A tank of straight walls. Its suction mouth lies `suction_height` above the bottom, and is as wide as its area.

    `elevation` is the height of the bottom over the connected ports, such as the inlet of a pump. Vented, the air
    keeps `air_pressure` (absolute); `sealed` 1 closes it in, and it has that pressure at the first `tank_volume`.
    """

    base_area: Area
    tank_height: Length
    tank_volume: Volume
    suction_height: Length
    port_area: Area
    elevation: Position = 0.0
    air_pressure: Pressure = 101325.0
    sealed: Fraction = 0.0
    air_exponent: Polytropic = 1.0
    discharge_coefficient: DischargeCoefficient = 0.61
    transition_pressure: PressureDifference = 100.0

    def check(self) -> None:
        require_positive(self, "base_area", "port_area", "air_pressure", "transition_pressure")
        require_less(self, "suction_height", "tank_height")
        if self.tank_volume >= self.base_area * self.tank_height:
            refuse(self, "tank_volume", f"must leave room for air in {1e3 * self.base_area * self.tank_height:g} l")


def reservoir_level(volume: float, tank: Reservoir) -> float:
    """Height of the oil over the bottom of a tank [m]: V/A.

    volume  of oil in it [m^3]
    """
    return volume / tank.base_area


def enclosed_ratio(volume: float, tank: Reservoir) -> float:
    """Room of the air at first over its room now [1]; 1 where it is vented.

    volume  of oil in the tank [m^3]
    """
    full = tank.base_area * tank.tank_height
    return select(tank.sealed > 0.5, (full - tank.tank_volume) / (full - volume), 1.0)


def reservoir_air(volume: float, tank: Reservoir) -> float:
    """Pressure of the air in a tank [Pa, absolute]: p_0 (U_0/U)^k, U its room.

    volume  of oil in it [m^3]

    >>> tank = Reservoir(
    ...     base_area=0.1, tank_height=0.4, tank_volume=0.02, suction_height=0.0, port_area=1e-3, sealed=1.0
    ... )
    >>> print(round(reservoir_air(0.03, tank)))  # half the room, twice the pressure
    202650
    """
    pressure: float = tank.air_pressure * power(enclosed_ratio(volume, tank), tank.air_exponent)
    return pressure


def reservoir_head(volume: float, density: float, reference_pressure: float, tank: Reservoir) -> float:
    """Pressure that a tank holds against its ports, over the reference [Pa]: p_air - ref + rho g (V/A + elevation).

    Its oil is taken as stiff, so that this is its enthalpy per tank volume as well.

    volume              of oil in it [m^3]
    density             of the oil [kg/m^3]
    reference_pressure  of the oil, absolute [Pa]

    >>> tank = Reservoir(base_area=0.1, tank_height=0.4, tank_volume=0.02, suction_height=0.0, port_area=1e-3)
    >>> print(round(reservoir_head(0.02, 870.0, 101325.0, tank)))  # 0.2 m of oil
    1706
    """
    height = reservoir_level(volume, tank) + tank.elevation
    return reservoir_air(volume, tank) - reference_pressure + density * GRAVITY * height


def reservoir_flow(drop: float, density: float, tank: Reservoir) -> float:
    """Flow through the mouth of a port of a tank [tank volumes, m^3/s]: Cd A root(2 drop/rho), straight about 0.

    drop     enthalpy per tank volume at the port less that in the tank [J/m^3]
    density  of the oil [kg/m^3]

    Source  merritt1967, ch. 3 (root law)
    """
    smooth = np.sqrt(drop * drop + tank.transition_pressure * tank.transition_pressure)
    flow: float = tank.discharge_coefficient * tank.port_area * drop / np.sqrt(0.5 * density * smooth)
    return flow


def dipped_share(volume: float, tank: Reservoir) -> float:
    """Share of a tank's suction mouth that oil covers [1]: 0 from its lower edge down, 1 a diameter above.

    volume  of oil in it [m^3]
    """
    return clip((reservoir_level(volume, tank) - tank.suction_height) / mouth_width(tank), 0.0, 1.0)


def mouth_width(tank: Reservoir) -> float:
    """Diameter of the mouth of a port of a tank [m]."""
    width: float = np.sqrt(4.0 * tank.port_area / np.pi)
    return width


def dry_side(volume: float, tank: Reservoir) -> float:
    """Whether oil covers the whole suction mouth of a tank [1], see `base.modes.side`.

    volume  of oil in it [m^3]
    """
    return side((reservoir_level(volume, tank) - tank.suction_height - mouth_width(tank)) / tank.tank_height)


def reservoir_stored(volume: float, density: float, reference_pressure: float, tank: Reservoir) -> Stored:
    """Energy [J] and oil [tank volumes, m^3] in a tank: that of height, and that put into the air from the first on.

    rho g V (V/(2 A) + elevation) + int (p_air - ref) dV, the air's work in closed form.

    volume              of oil in it [m^3]
    density             of the oil [kg/m^3]
    reference_pressure  of the oil, absolute [Pa]
    """
    L, k = np.log(enclosed_ratio(volume, tank)), tank.air_exponent
    growth = select(k > 1.0, np.expm1((k - 1.0) * L) / select(k > 1.0, k - 1.0, 1.0), L)
    room = tank.base_area * tank.tank_height - tank.tank_volume
    work = select(tank.sealed > 0.5, room * growth, volume - tank.tank_volume)
    height = 0.5 * reservoir_level(volume, tank) + tank.elevation
    energy = density * GRAVITY * volume * height + tank.air_pressure * work - reference_pressure * volume
    return Stored(energy, volume)
