"""The motor of a pump, as a part of its own speed that a driven shaft follows."""

from typing import NamedTuple

from vvdp.base.kinds import Fraction, Kink, Speed
from vvdp.hydraulics.pump_motor import PumpMotor, PumpMotorState, motor_acceleration, ramp_side
from vvdp.network.component import Component


class PumpMotorMotion(NamedTuple):
    """The rate of a motor's speed, and where on its ramp it stands."""

    rates: PumpMotorState
    ramp: Kink


def pump_motor(command: Fraction, rated_speed: Speed, state: PumpMotorState, values: PumpMotor) -> PumpMotorMotion:
    """A motor that a command of 1 starts and 0 stops; a shaft is driven at "pump_motor.speed", whatever it takes."""
    rate = motor_acceleration(command, state.speed, rated_speed, values)
    return PumpMotorMotion(PumpMotorState(rate), ramp_side(command, state.speed, rated_speed))


PUMP_MOTOR = Component(pump_motor, symbol="electric_motor")
