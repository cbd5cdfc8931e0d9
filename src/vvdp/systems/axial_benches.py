"""The axial drives of a spool on their own: drive, sensor, and a spool that is turned at a prescribed speed.

The functions that return a `Network` are what a system file names as its circuit; their arguments are its tables.
"""

from typing import TypeVar

from vvdp.base.errors import ParameterError
from vvdp.base.signal import map_signal
from vvdp.components.axial_drive import (
    add_gerotor_drive,
)
from vvdp.components.library import UsualOil
from vvdp.control.reference import ReferenceFilter
from vvdp.hydraulics.gerotor_drive import GerotorCalibration, GerotorDrive, GerotorMap
from vvdp.network.network import Network
from vvdp.programs.axial_loop import PROGRAM, AxialObserverTable
from vvdp.programs.axial_sensor import AxialSensorTable, add_axial_sensor
from vvdp.programs.gerotor_loop import DriveBelief, GerotorSequence
from vvdp.systems.axial_tables import (
    AxialStroke,
    ControlledGerotor,
    GerotorOperation,
    InitialPosition,
)
from vvdp.systems.gerotor_control import (
    ClockedTable,
    GeneratorTable,
    GerotorTables,
    LumpedTable,
    ObserverTable,
    PIGains,
    add_gerotor_control,
)
from vvdp.systems.gerotor_numbers import GerotorHeld

Given = TypeVar("Given")


def _require(name: str, table: Given | None) -> Given:
    if table is None:
        raise ParameterError(f"table {name!r} is missing; a duty ratio is held by an observer, a reference and a law")
    return table


def axial_gerotor(
    gerotor: GerotorDrive,
    characteristic: GerotorMap | GerotorCalibration,
    stroke: AxialStroke,
    axial_sensor: AxialSensorTable,
    operation: ControlledGerotor | GerotorOperation,
    initial: InitialPosition,
    axial_observer: AxialObserverTable | ClockedTable | LumpedTable | GeneratorTable | None = None,
    calibration: DriveBelief | None = None,
    position_control: PIGains | None = None,
    axial_reference: ReferenceFilter | None = None,
    axial_sequence: GerotorSequence | None = None,
) -> Network:
    """A gerotor pump between both ends of the spool: on a prescribed command, or controlled to a duty ratio."""
    net = Network(UsualOil(), operation=operation)
    net.driven_shaft("spool", operation.spool_speed)
    if isinstance(operation, GerotorOperation):
        position = add_gerotor_drive(net, gerotor, characteristic, operation.command, initial.axial_position)
        add_axial_sensor(net, position, "spool", axial_sensor)
        return net
    net.extras = GerotorHeld
    observer: ObserverTable = _require("axial_observer", axial_observer)  # type: ignore[assignment]
    add_gerotor_drive(net, gerotor, characteristic, f"{PROGRAM}.drive", initial.axial_position)
    tables = GerotorTables(
        sensor=axial_sensor,
        observer=observer,
        gains=_require("position_control", position_control),
        calibration=_require("calibration", calibration),
        reference=_require("axial_reference", axial_reference),
        sequence=_require("axial_sequence", axial_sequence),
        helix_length=stroke.helix_length,
        wanted=map_signal(operation.duty_ratio, lambda d: d * stroke.helix_length),
    )
    add_gerotor_control(net, tables, gerotor, "spool")
    return net
