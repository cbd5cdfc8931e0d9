"""Up to where the laws of the rotary valve hold: the numbers, and on what each rests. docs/design.md shows them all.

Source  ours, docs/design.md, "Where the model leaves its range", where a number names no other.
"""

from vvdp.fluid.mixture import mean_bulk_modulus
from vvdp.fluid.oil import Oil
from vvdp.valve.geometry import transition_fraction
from vvdp.valve.rotary import RotaryValve

TURBULENT = 2300.0
"""Reynolds number of a nozzle below which its discharge coefficient is in doubt: the usual limit of a duct."""
LAMINAR = 20.0
"""Reynolds number below which a nozzle's drop is no longer quadratic: twice the (0.61/0.2)^2 at which the two
laws of merritt1967 meet, below which C_d = 0.2 sqrt(Re)."""
CAVITATION_PRESSURE = 3e4
"""Pressure below which oil is assumed to cavitate if a system gives no other [Pa, absolute]."""
CAVITATION_NUMBER = 0.4
"""Cavitation number of a nozzle below which oil evaporates behind it; assumed, between the 0.2 and 1 of reports."""
TAYLOR_NUMBER = 41.2
"""Taylor number from which on vortices stand in the clearance and friction is more than linear; taylor1923."""
SHEAR_WARMING = 5.0
"""Warming of the film by its own shear [K] from which it is thinner than the oil; it changes viscosity by a fifth."""
ECCENTRICITY = 0.9
"""Eccentricity at which a tenth of the clearance is left, about the roughness of ground steel: above it the spool
touches."""
CURVATURE = 0.01
"""Clearance over radius; plane films and journal are laws of its lowest order, so that they are off by as much."""
SLOT_LENGTH = 10.0
"""Breadth of the barriers over the clearance below which their gap is an orifice rather than a slot; assumed."""
WAVE_TRANSITS = 10.0
"""Times that a pressure wave must cross the valve during a transition for volumes under one pressure."""


def wave_transits(pwm_frequency: float, pressure: float, density: float, oil: Oil, valve: RotaryValve) -> float:
    """Number of times that a pressure wave crosses the valve while a port opens or closes, kappa a/(f_pwm L) [1].

    L is the helix length, the longest way in the valve, a the speed of sound sqrt(K/rho).

    pwm_frequency  above 0 [Hz]
    pressure       of the oil, absolute [Pa]
    density        [kg/m^3]
    """
    sound: float = (mean_bulk_modulus(pressure, oil) / density) ** 0.5
    return transition_fraction(valve) * sound / (pwm_frequency * valve.helix_length)
