"""The motor that turns a pump at a speed of its own: it starts along a ramp and coasts down when it is switched off.

Source  ours, docs/models/whole-machine.md, where a function names no other.
"""

from typing import NamedTuple

from vvdp.base.errors import ParameterError
from vvdp.base.kinds import Kink, Speed, Time
from vvdp.base.modes import side
from vvdp.base.params import Params
from vvdp.base.select import clip, select

NEAR = 0.02
"""Share of the rated speed within which a motor's control brings it to that speed, not along the ramp any more."""


class PumpMotor(Params):
    """A motor: `start_time` from rest to its rated speed; off, it slows down with the time constant `coast_time`."""

    start_time: Time
    coast_time: Time

    def check(self) -> None:
        for name in ("start_time", "coast_time"):
            if getattr(self, name) <= 0.0:
                raise ParameterError(f"PumpMotor.{name}: 0 s; no motor changes its speed at once, expected above zero")


class PumpMotorState(NamedTuple):
    """Its speed."""

    speed: Speed


class Acceleration(NamedTuple):
    """How a motor's speed changes [rad/s^2], and on which side of the end of its ramp it stands."""

    rate: float
    ramp: Kink


def motor_acceleration(command: float, speed: float, rated_speed: float, motor: PumpMotor) -> Acceleration:
    """Rate of the speed of a pump's motor [rad/s^2].

    Switched on: omega_r/t_start until 2 % are missing, those with a time constant of 2 % of t_start; likewise
    downwards where the rated speed has fallen. Switched off: -omega/tau, so that omega = omega_0 exp(-t/tau).

    command      1 on, 0 off
    speed        omega, now [rad/s]
    rated_speed  omega_r [rad/s]
    """
    missing = rated_speed - speed
    size = select(rated_speed > 0.0, rated_speed, 1.0)
    distance = missing / (NEAR * size)
    driven = clip(distance, -1.0, 1.0) * size / motor.start_time
    is_on = command > 0.5
    rate = select(is_on, driven, -speed / motor.coast_time)
    return Acceleration(rate, side(select(is_on, abs(distance) - 1.0, 0.5)))
