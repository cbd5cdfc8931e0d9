"""The flow map of a pump unit: what its valve delivers, calculated once for each relief setting and pump speed.

Source  ours, docs/models/whole-machine.md, where a function names no other.
"""

from functools import lru_cache
from typing import Any

import numpy as np

from vvdp.control.flow_map import FlowMap
from vvdp.hydraulics.pump import Pump
from vvdp.hydraulics.relief_valve import ReliefValve
from vvdp.valve.condition import Condition
from vvdp.valve.flow_map import delivered_flows
from vvdp.valve.geometry import transition_fraction
from vvdp.valve.rotary import RotaryValve

FINE, COARSE = 0.01, 0.06
"""Steps of the duty ratio near where one of the ports never opens fully, and between."""

PRESSURES = (0.0, 0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0)
"""Pressures behind the valve, over that of the relief valve."""


def valve_condition(
    flow: float, oil_density: float, tank_pressure: float, pump: Pump, relief_valve: ReliefValve
) -> Condition:
    """Operating conditions of the valve of a pump unit, with the line at tank pressure.

    flow           that the pump displaces [m^3/s]
    oil_density    [kg/m^3]
    tank_pressure  absolute [Pa]
    """
    return Condition(
        flow=flow,
        load_pressure=tank_pressure,
        relief_pressure=relief_valve.cracking_pressure,
        tank_pressure=tank_pressure,
        density=oil_density,
        relief_override=relief_valve.override_pressure,
        relief_rated_flow=relief_valve.rated_flow,
        pump_leakage=pump.leakage_conductance,
    )


@lru_cache(maxsize=64)
def flow_map_of(valve: RotaryValve, at: Condition) -> FlowMap:
    """The flow map of a valve from where it delivers nothing to where it delivers all, up to the relief pressure."""
    duties = duty_ratios(transition_fraction(valve))
    rise = at.relief_pressure - at.tank_pressure
    pressures = [at.tank_pressure + share * rise for share in PRESSURES]
    behind: Any = np.array(pressures)[:, np.newaxis]
    rows = delivered_flows(duties, at._replace(load_pressure=behind), valve)
    flows = np.sort(rows, axis=1)  # what falls does so by rounding alone
    return FlowMap(
        duty_ratios=tuple(map(float, duties)), line_pressures=tuple(pressures), flows=tuple(map(float, flows.ravel()))
    )


def duty_ratios(kappa: float) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    """The duty ratios of a map, from -kappa to 1 + kappa.

    kappa  transition fraction [1]
    """
    low = np.arange(0.0, kappa + FINE, FINE)
    middle = np.arange(kappa + COARSE, 1.0 - 0.5 * kappa, COARSE)
    high = np.arange(1.0 - 0.5 * kappa, 1.0 + 0.5 * kappa, FINE)
    return np.unique(np.concatenate([[-kappa], low, middle, high, [1.0 + 0.5 * kappa, 1.0 + kappa]]))
