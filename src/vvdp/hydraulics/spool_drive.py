"""Drive of a rotary valve's spool besides the flow: none, or a motor through a slipping coupling.

Source  ours, docs/models/components.md, where a function names no other.
"""

from vvdp.base.kinds import Coupling
from vvdp.base.params import Params


class SpoolDrive(Params):
    """`coupling` is the torque per slip; 0 leaves the spool to its own flow (self-spinning)."""

    coupling: Coupling


def drive_torque(motor_speed: float, spool_speed: float, drive: SpoolDrive) -> float:
    """Torque of the drive on the spool [N m]: coupling (omega_motor - omega_spool).

    motor_speed  [rad/s]
    spool_speed  [rad/s]
    """
    return drive.coupling * (motor_speed - spool_speed)


def drive_power(motor_speed: float, spool_speed: float, drive: SpoolDrive) -> float:
    """Power that the motor of a spool drive gives [W]: torque on the spool times its own speed.

    motor_speed  [rad/s]
    spool_speed  [rad/s]
    """
    return drive_torque(motor_speed, spool_speed, drive) * motor_speed


def coupling_loss(motor_speed: float, spool_speed: float, drive: SpoolDrive) -> float:
    """Power that the slip of the coupling dissipates [W]: torque times slip, never negative.

    motor_speed  [rad/s]
    spool_speed  [rad/s]
    """
    return drive_torque(motor_speed, spool_speed, drive) * (motor_speed - spool_speed)
