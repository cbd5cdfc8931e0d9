"""Couplings of two shafts."""

from typing import NamedTuple

from vvdp.base.kinds import Power, Torque
from vvdp.hydraulics.ports import ShaftSpeed
from vvdp.hydraulics.spool_drive import SpoolDrive, coupling_loss, drive_torque
from vvdp.network.component import Component


class CouplingEffect(NamedTuple):
    """Torques of a coupling on its two shafts, and what its slip dissipates."""

    motor: Torque
    spool: Torque
    loss: Power


def drive_coupling(motor: ShaftSpeed, spool: ShaftSpeed, values: SpoolDrive) -> CouplingEffect:
    """A coupling that slips, from a motor to the spool of a rotary valve; see `drive_torque`."""
    torque = drive_torque(motor.speed, spool.speed, values)
    return CouplingEffect(-torque, torque, coupling_loss(motor.speed, spool.speed, values))


DRIVE_COUPLING = Component(drive_coupling, symbol="coupling")
