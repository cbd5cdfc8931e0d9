"""Traditional backstepping of the chamber, for comparison: the pressure error counts as lambda_2/2 (P - P_d)^2.

Source  ours, docs/models/passivity-control.md, where a function names no other.
"""

from typing import Annotated

from vvdp.base.display import value_text
from vvdp.base.errors import ParameterError
from vvdp.base.kinds import CONDUCTANCE, Conductance, Kind
from vvdp.base.rules import require_positive
from vvdp.control.chamber import (
    ChamberDrive,
    ChamberFlow,
    ChamberReading,
    PositionGains,
    desired_pressure,
    volume_compliance,
)
from vvdp.control.reference import Reference

VOLUME_COMPLIANCE = Kind("volume over pressure", "m^3/Pa", 0.0, 1e-6, "3e-12 m^3/Pa")

VolumeCompliance = Annotated[float, VOLUME_COMPLIANCE]


class BacksteppingGains(PositionGains):
    """Gains of backstepping: `pressure_weight` lambda_2 and `flow_gain` lambda_3.

    Raises `ParameterError` for a weight or a flow gain of zero.
    """

    pressure_weight: VolumeCompliance
    flow_gain: Conductance

    def check(self) -> None:
        require_positive(self, "pressure_weight", "flow_gain")


def backstepping_law(
    reference: Reference, reading: ChamberReading, gains: BacksteppingGains, drive: ChamberDrive
) -> ChamberFlow:
    """The flow Q = A v - V/beta (A e_v/lambda_2 - P_d1') - lambda_3 (P - P_d), V/beta at the chamber's pressure.

    Source  wang2017, eqs. 5.39 (of which k is K) and 5.40
    """
    desired = desired_pressure(reference, reading, gains, drive)
    compliance = volume_compliance(reading.position, reading.pressure, drive)
    back = drive.area * desired.velocity_error / gains.pressure_weight
    feedforward = drive.area * reading.velocity - compliance * (back - desired.known_rate)
    flow = feedforward - gains.flow_gain * (reading.pressure - desired.pressure)
    return ChamberFlow(flow, feedforward, desired)


def velocity_share(gains: PositionGains, flow_gain: float, drive: ChamberDrive) -> float:
    """k = lambda_3 (M lambda_p + K_v)/A^2 [1]: share of A v that comes back through the desired pressure.

    flow_gain  lambda_3 [m^3/(s Pa)]
    """
    damping = drive.moving_mass * gains.error_rate + gains.velocity_gain
    return flow_gain * damping / drive.area**2


def refuse_flow_gain(gains: BacksteppingGains, drive: ChamberDrive) -> None:
    """Raises `ParameterError` for k of 1 and more: with any lambda_2 the flow then depends on the measured velocity."""
    best_pressure_weight(1.0, gains, gains.flow_gain, drive)


def best_pressure_weight(compliance: float, gains: PositionGains, flow_gain: float, drive: ChamberDrive) -> float:
    """The lambda_2 [m^3/Pa] with which the flow does not depend on the measured velocity: (V/beta)/(1 - k).

    The velocity enters the flow as A v (1 - (V/beta)/lambda_2 - k). Raises `ParameterError` for k of 1 and more, where
    it does so with any weight.

    compliance  V/beta [m^3/Pa]
    flow_gain   lambda_3 [m^3/(s Pa)]
    """
    k = velocity_share(gains, flow_gain, drive)
    if not k < 1.0:
        highest = drive.area**2 / (drive.moving_mass * gains.error_rate + gains.velocity_gain)
        raise ParameterError(
            f"flow_gain: {value_text(flow_gain, CONDUCTANCE)} must be less than A^2/(M lambda_p + K_v) = "
            f"{value_text(highest, CONDUCTANCE)}: beyond it the flow depends on the measured velocity with any "
            f"pressure_weight, k = {k:.3g}"
        )
    return compliance / (1.0 - k)
