"""The control of a gerotor drive as a part of a network: the program with its values, from the tables of a system."""

from dataclasses import dataclass
from typing import Any

from vvdp.base.errors import ParameterError
from vvdp.base.kinds import Length, Speed, Time
from vvdp.base.params import Params
from vvdp.base.signal import Signal
from vvdp.control.feedforward_pi import FeedforwardPI, SquareRate
from vvdp.control.reference import Rate, ReferenceFilter
from vvdp.estimation.gerotor_observer import GerotorObserver
from vvdp.estimation.noise_clock import ClockedGerotor, NoiseClock
from vvdp.estimation.signal_generator import (
    GeneratorDesign,
    GeneratorObserver,
    LumpedObserver,
    generator_observer,
    samples_in_period,
)
from vvdp.hydraulics.gerotor_drive import GerotorDrive
from vvdp.network.network import Network
from vvdp.network.program import ProgramType
from vvdp.programs.axial_loop import PROGRAM, UNKNOWN, AxialObserverTable
from vvdp.programs.axial_sensor import AxialSensorTable, axial_sensor_of
from vvdp.programs.gerotor_control import gerotor_observer_of
from vvdp.programs.gerotor_loop import (
    DriveBelief,
    GerotorControl,
    GerotorLoop,
    GerotorPlace,
    GerotorSequence,
    WatchedGerotor,
    gerotor_loop_start,
    gerotor_step,
    watched_gerotor_start,
    watched_gerotor_step,
)
from vvdp.programs.spool_encoder import WatchSettings
from vvdp.systems.gerotor_filters import (
    ClockedLoop,
    GeneratorLoop,
    LumpedLoop,
    clocked_loop_start,
    clocked_step,
    generator_loop_start,
    generator_step,
    lumped_loop_start,
    lumped_step,
)


class PIGains(Params):
    """The [position_control] table: both gains over the area of the spool's end, K_p/A_s and K_i/A_s."""

    proportional_rate: Rate
    integral_rate: SquareRate


class ClockedTable(AxialObserverTable):
    """The [axial_observer] table with a basis in time: of a pollution that comes back with `noise_speed`."""

    noise_speed: Speed


class LumpedTable(Params):
    """The [axial_observer] table of the lumped filter, which takes the pollution for noise."""

    sample_period: Time
    bandwidth: Speed


class GeneratorTable(Params):
    """The [axial_observer] table of the signal generator; drifts are deviations of a sample."""

    sample_period: Time
    noise_period: Time
    sensor_deviation: Length
    position_drift: Length
    generator_drift: Length

    def check(self) -> None:
        samples_in_period(self.noise_period, self.sample_period)  # here, where the line of the table is known


ObserverTable = AxialObserverTable | ClockedTable | LumpedTable | GeneratorTable


@dataclass(frozen=True)
class GerotorTables:
    """The tables of the control of a gerotor drive, and the `wanted` position [m]."""

    sensor: AxialSensorTable
    observer: ObserverTable
    gains: PIGains
    calibration: DriveBelief
    reference: ReferenceFilter
    sequence: GerotorSequence
    helix_length: float
    wanted: Signal


def control_values(tables: GerotorTables, drive: GerotorDrive) -> dict[str, Any]:
    """The fields of `GerotorControl`. Raises ParameterError where the drive's ends do not reach what is wanted."""
    low, high = tables.wanted.extremes
    if not drive.lower_end <= low <= high <= drive.upper_end:
        raise ParameterError(
            f"operation.duty_ratio: {1e3 * low:.4g} to {1e3 * high:.4g} mm are asked for, the drive goes from "
            f"{1e3 * drive.lower_end:.4g} to {1e3 * drive.upper_end:.4g} mm"
        )
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


def generator_of(table: GeneratorTable, drive: GerotorDrive) -> GeneratorObserver:
    """The signal generator of a table, with the gains that follow from it."""
    design = GeneratorDesign(
        area=drive.area,
        sample_period=table.sample_period,
        noise_period=table.noise_period,
        sensor_deviation=table.sensor_deviation,
        position_drift=table.position_drift,
        generator_drift=table.generator_drift,
        stop_position=drive.lower_end,
    )
    return generator_observer(design)


def gerotor_loop(tables: GerotorTables, drive: GerotorDrive) -> tuple[ProgramType, GerotorControl]:
    """The program that goes with a table of an observer, the spool's angle known, and its values."""
    table, values = tables.observer, control_values(tables, drive)
    if isinstance(table, LumpedTable):
        observer = LumpedObserver(
            area=drive.area,
            sample_period=table.sample_period,
            bandwidth=table.bandwidth,
            stop_position=drive.lower_end,
        )
        return _program(lumped_step, lumped_loop_start, LumpedLoop(observer=observer, **values))
    if isinstance(table, GeneratorTable):
        loop = GeneratorLoop(observer=generator_of(table, drive), **values)
        return _program(generator_step, generator_loop_start, loop)
    periodic = periodic_observer(table, drive, tables.helix_length)
    if isinstance(table, ClockedTable):
        clocked = ClockedGerotor(observer=periodic, clock=NoiseClock(speed=table.noise_speed))
        return _program(clocked_step, clocked_loop_start, ClockedLoop(observer=clocked, **values))
    return _program(gerotor_step, gerotor_loop_start, GerotorLoop(observer=periodic, **values))


def _program(step: Any, start: Any, loop: GerotorControl) -> tuple[ProgramType, GerotorControl]:
    return ProgramType(step, GerotorPlace, UNKNOWN, type(loop), start), loop


def add_gerotor_control(net: Network, tables: GerotorTables, drive: GerotorDrive, spool: str) -> None:
    """Add the program that controls a gerotor drive whose spool turns with the shaft `spool`, its angle known."""
    kind, loop = gerotor_loop(tables, drive)
    net.program(PROGRAM, kind, loop, reads=_reads(spool), period=loop.sample_period)


def add_watched_gerotor(
    net: Network, tables: GerotorTables, drive: GerotorDrive, spool: str, watch: WatchSettings
) -> None:
    """The same with the periodic Kalman filter and the spool watched by an encoder."""
    assert isinstance(tables.observer, AxialObserverTable)
    observer = periodic_observer(tables.observer, drive, tables.helix_length)
    loop = GerotorLoop(observer=observer, **control_values(tables, drive))
    kind = ProgramType(watched_gerotor_step, GerotorPlace, UNKNOWN, WatchedGerotor, watched_gerotor_start)
    settings = WatchedGerotor(watch=watch, loop=loop)
    net.program(PROGRAM, kind, settings, reads=_reads(spool), period=loop.sample_period)


def _reads(spool: str) -> dict[str, str]:
    return {"time": "t", "angle": f"{spool}.angle", "speed": f"{spool}.speed", "position": "gerotor.position"}
