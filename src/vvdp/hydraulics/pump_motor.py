"""The motor that turns a pump at a speed of its own: it starts along a ramp and coasts down when it is switched off.

Source  ours, docs/models/whole-machine.md, where a function names no other.
"""

from typing import NamedTuple

from vvdp.base.kinds import Speed, Time
from vvdp.base.modes import side
from vvdp.base.params import Params
from vvdp.base.rules import require_positive
from vvdp.base.select import clip, select

NEAR = 0.02
"""Share of the rated speed within which a motor's control brings it to that speed, not along the ramp any more."""


class PumpMotor(Params):
    """A motor: `start_time` from rest to its rated speed; off, it slows down with the time constant `coast_time`."""

    start_time: Time
    coast_time: Time

    def check(self) -> None:
        require_positive(self, "start_time", "coast_time")


class PumpMotorState(NamedTuple):
    """Its speed."""

    speed: Speed


def motor_acceleration(command: float, speed: float, rated_speed: float, motor: PumpMotor) -> float:
    """Rate of the speed of a pump's motor [rad/s^2].

    Switched on: omega_r/t_start until 2 % are missing, those with a time constant of 2 % of t_start; likewise
    downwards where the rated speed has fallen. Switched off: -omega/tau, so that omega = omega_0 exp(-t/tau).

    command      1 on, 0 off
    speed        omega, now [rad/s]
    rated_speed  omega_r [rad/s]

    >>> motor = PumpMotor(start_time=0.3, coast_time=0.1)
    >>> motor_acceleration(1.0, 0.0, 180.0, motor), motor_acceleration(0.0, 180.0, 180.0, motor)
    (600.0, -1800.0)
    """
    driven = clip(ramp_distance(speed, rated_speed), -1.0, 1.0) * rated_speed / motor.start_time
    rate: float = select(command > 0.5, driven, -speed / motor.coast_time)
    return rate


def ramp_distance(speed: float, rated_speed: float) -> float:
    """Shortfall of the speed, over the 2 % of the rated speed at which the ramp ends [1]; -1 without a rated speed.

    speed, rated_speed  [rad/s]
    """
    rated = rated_speed > 0.0
    size = select(rated, rated_speed, 1.0)
    return select(rated, (rated_speed - speed) / (NEAR * size), -1.0)


def ramp_side(command: float, speed: float, rated_speed: float) -> float:
    """Whether a motor stands on its ramp, or near its rated speed or without current [1]; see `side`.

    command              1 on, 0 off
    speed, rated_speed   [rad/s]
    """
    return side(select(command > 0.5, abs(ramp_distance(speed, rated_speed)) - 1.0, -1.0))
