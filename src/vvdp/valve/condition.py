"""Conditions under which the valve switches."""

from typing import NamedTuple

from vvdp.base.kinds import Conductance, Density, Flow, Pressure, PressureDifference


class Condition(NamedTuple):
    """Pump flow through the valve, absolute pressures of load, relief valve and tank, and density of the oil.

    The relief valve cracks at `relief_pressure` and passes `relief_rated_flow` at `relief_override` above it; with an
    override of 0 it is ideal, and the rated flow is not read. `pump_leakage` times the inlet pressure over the tank's
    goes back through the pump. `vapour_pressure` is the oil's, for nozzles that choke.
    """

    flow: Flow
    load_pressure: Pressure
    relief_pressure: Pressure
    tank_pressure: Pressure
    density: Density
    relief_override: PressureDifference = 0.0
    relief_rated_flow: Flow = 0.0
    pump_leakage: Conductance = 0.0
    vapour_pressure: Pressure = 0.0
