"""The control of a gerotor drive as a part of a network: the program with its values, from the tables of a system."""

from dataclasses import dataclass
from typing import Any

from vvdp.base.params import Params
from vvdp.base.signal import Signal
from vvdp.control.feedforward_pi import FeedforwardPI, SquareRate
from vvdp.control.reference import Rate, ReferenceFilter
from vvdp.estimation.gerotor_observer import GerotorObserver
from vvdp.hydraulics.gerotor_drive import GerotorDrive
from vvdp.programs.axial_loop import AxialObserverTable
from vvdp.programs.axial_sensor import AxialSensorTable, axial_sensor_of
from vvdp.programs.gerotor_control import gerotor_observer_of
from vvdp.programs.gerotor_loop import (
    DriveBelief,
    GerotorSequence,
)


class PIGains(Params):
    """The [position_control] table: both gains over the area of the spool's end, K_p/A_s and K_i/A_s."""

    proportional_rate: Rate
    integral_rate: SquareRate


@dataclass(frozen=True)
class GerotorTables:
    """The tables of the control of a gerotor drive, and the `wanted` position [m]."""

    sensor: AxialSensorTable
    observer: AxialObserverTable
    gains: PIGains
    calibration: DriveBelief
    reference: ReferenceFilter
    sequence: GerotorSequence
    helix_length: float
    wanted: Signal


def control_values(tables: GerotorTables, drive: GerotorDrive) -> dict[str, Any]:
    """The fields of `GerotorLoop`."""
    belief = tables.calibration
    law = FeedforwardPI(
        area=drive.area,
        proportional_rate=tables.gains.proportional_rate,
        integral_rate=tables.gains.integral_rate,
        lowest_flow=-belief.backward_gain * belief.largest_flow,
        highest_flow=belief.largest_flow,
    )
    return {
        "sensor": axial_sensor_of(tables.sensor),
        "law": law,
        "calibration": belief,
        "reference": tables.reference,
        "sequence": tables.sequence,
        "sample_period": tables.observer.sample_period,
        "stop_position": drive.lower_end,
        "wanted": tables.wanted,
    }


def periodic_observer(table: AxialObserverTable, drive: GerotorDrive, helix_length: float) -> GerotorObserver:
    """The periodic Kalman filter of a table; `helix_length` [m]."""
    return gerotor_observer_of(table, drive.area, drive.lower_end, helix_length)
