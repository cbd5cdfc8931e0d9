"""What the valve works against while it switches."""

from typing import NamedTuple

from vvdp.base.kinds import Density, Flow, Pressure


class Condition(NamedTuple):
    """Pump flow through the valve, absolute pressures of load, relief valve and tank, and density of the oil."""

    flow: Flow
    load_pressure: Pressure
    relief_pressure: Pressure
    tank_pressure: Pressure
    density: Density
