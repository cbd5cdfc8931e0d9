"""How far the pressure of a load line swings with the pulses of a switching valve.

Source  ours, docs/rigs.md
"""

from vvdp.fluid.mixture import fluid_state
from vvdp.fluid.oil import Oil
from vvdp.hydraulics.volume import Vessel, pressure_rate


def vessel_capacity(pressure: float, line: Vessel, oil: Oil) -> float:
    """Tank volume that a load line takes in over the pressure that it gains [m^3/Pa].

    pressure  absolute [Pa]
    """
    return float(1.0 / pressure_rate(1.0, 0.0, fluid_state(pressure, oil), line, oil.reference_pressure))


def estimated_ripple(delivered: float, pump_flow: float, pwm_frequency: float, capacity: float) -> float:
    """Peak-to-peak pressure of a line that is filled in pulses and emptied evenly, q (1 - q/Q) / (f C) [Pa].

    Pulses of the pump flow Q last q/(Q f), and more than the load takes flows in by Q - q meanwhile.

    delivered, pump_flow  mean [m^3/s]
    pwm_frequency         [Hz]
    capacity              of the line [m^3/Pa]
    """
    return delivered * (1.0 - delivered / pump_flow) / (pwm_frequency * capacity)
