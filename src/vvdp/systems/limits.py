"""Bounds of a circuit that are watched and reported."""

from vvdp.base.kinds import Pressure, Speed, Velocity
from vvdp.base.params import Params
from vvdp.valve.validity import CAVITATION_PRESSURE

LARGEST_PRESSURE = 701.01325e5
"""Absolute pressure [Pa] beyond which no result is to be trusted where a system says nothing else: 700 bar, twice what
pumps and hoses of industry are rated for; assumed."""
LARGEST_SPEED = 2000.0
"""Speed of a shaft [rad/s] beyond which none is to be trusted where a system says nothing else: 19 000 rpm, twice what
small axial piston machines are rated for; assumed."""
LARGEST_VELOCITY = 30.0
"""Mean velocity of the oil in a line above which no result is to be trusted [m/s]: three times that of short ones."""


class Limits(Params):
    """Bounds that are watched and reported; beyond one of them no result is to be trusted."""

    cavitation_pressure: Pressure = CAVITATION_PRESSURE
    largest_pressure: Pressure = LARGEST_PRESSURE
    largest_speed: Speed = LARGEST_SPEED
    largest_velocity: Velocity = LARGEST_VELOCITY
