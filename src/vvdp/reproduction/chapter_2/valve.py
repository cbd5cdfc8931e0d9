"""The valve and the oil of chapter 2, as the shipped system has them."""

from functools import cache

import numpy as np

from vvdp.steady.test_stand import Stand
from vvdp.steady.test_stand import stand as stand_of
from vvdp.systems.system import load_system
from vvdp.valve.losses import full_open_drop
from vvdp.valve.rotary import RotaryValve
from vvdp.valve.torque import equilibrium_speed, pwm_frequency

LPM = 1e-3 / 60.0
FLOW = 40.0 * LPM
"""The largest flow of the apparatus [m^3/s]: section 2.2.2."""
DENSITY, VISCOSITY = 876.0, 0.0387
"""Of the oil at 40 degC [kg/m^3, Pa s]: section 2.3.1."""
DIGITS = "digits of the printed coefficients"


@cache
def stand() -> Stand:
    """The prototype against a source that holds the load's pressure."""
    return stand_of(load_system("prototype-constant-load"))


def valve() -> RotaryValve:
    """The prototype's valve."""
    return stand().bench.valve


def open_speed(flow: float = FLOW, viscosity: float = VISCOSITY) -> float:
    """Speed of the fully open valve's spool [rad/s]."""
    return float(equilibrium_speed(flow, DENSITY, viscosity, valve()))


def open_frequency(viscosity: float = VISCOSITY) -> float:
    """PWM frequency of the fully open valve at 40 lpm [Hz]."""
    return float(pwm_frequency(open_speed(viscosity=viscosity), valve()))


def flows(most: float, count: int = 31) -> np.ndarray:
    """Flows up to a largest one [m^3/s]."""
    return np.linspace(most / (count - 1), most, count - 1)


def open_drops(flow: float = FLOW) -> tuple[float, float, float]:
    """Drops of nozzles, centre section and outlet turbine of the fully open valve [Pa]."""
    drops = full_open_drop(flow, DENSITY, valve())
    return float(drops.nozzle), float(drops.centre_section), float(drops.outlet_turbine)
