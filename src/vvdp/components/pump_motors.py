"""The motor of a pump, as a part of its own speed that a driven shaft follows."""

from typing import NamedTuple

from vvdp.base.kinds import Fraction, Kink, Speed
from vvdp.hydraulics.pump_motor import PumpMotor, PumpMotorState, motor_acceleration
from vvdp.network.component import Component


class PumpMotorMotion(NamedTuple):
    """The rate of a motor's speed, and where on its ramp it stands."""

    rates: PumpMotorState
    ramp: Kink


def pump_motor(command: Fraction, rated_speed: Speed, state: PumpMotorState, values: PumpMotor) -> PumpMotorMotion:
    """A motor that a command of 1 starts and 0 stops; a shaft is driven at "pump_motor.speed", whatever it takes."""
    found = motor_acceleration(command, state.speed, rated_speed, values)
    return PumpMotorMotion(PumpMotorState(found.rate), found.ramp)


PUMP_MOTOR = Component(pump_motor, symbol="electric_motor")
