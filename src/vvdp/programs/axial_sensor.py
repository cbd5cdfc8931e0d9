"""The axial optical sensor of a system: its table, and the program that reads it."""

from dataclasses import replace
from typing import Annotated, NamedTuple

from vvdp.base.errors import ParameterError
from vvdp.base.kinds import ANGLE, FRACTION, POSITION, RATIO, Count, Fraction, Length, Position, Time
from vvdp.base.params import Params
from vvdp.base.rules import refuse_rows
from vvdp.network.program import ProgramType
from vvdp.programs.generic import GenericProgram
from vvdp.sensing.axial_sensor import (
    AxialSensor,
    LightCurve,
    Pollution,
    SpoolPlace,
    axial_sensor_start,
    axial_sensor_step,
)
from vvdp.sensing.instrument import InstrumentMemory, ideal_instrument


class AxialSensorTable(Params):
    """The [axial_sensor] table: calibration, periodic sensor error, noise [m], bias [m], and when the signal is
    frozen or lost.

    `noise` and `bias` are those of the position where the light changes by its mean slope. The periodic sensor error
    at the far end of the calibration is that of the near end unless it is given.
    """

    positions: Annotated[tuple[float, ...], POSITION]
    light: Annotated[tuple[float, ...], FRACTION]
    pollution_scale: Length
    pollution_amplitudes: Annotated[tuple[float, ...], RATIO]
    pollution_phases: Annotated[tuple[float, ...], ANGLE]
    far_amplitudes: Annotated[tuple[float, ...], RATIO] = ()
    far_phases: Annotated[tuple[float, ...], ANGLE] = ()
    noise: Length
    seed: Count
    bias: Position = 0.0
    freeze_begin: Time = 0.0
    freeze_end: Time = 0.0
    dropout_begin: Time = 0.0
    dropout_end: Time = 0.0

    def check(self) -> None:
        try:
            axial_sensor_of(self)  # here, where the line of the table is known
        except ParameterError as problem:
            field, _, message = str(problem).partition(": ")
            refuse_rows(self, _KEYS.get(field, field), message)


_KEYS = {
    "LightCurve.positions": "positions",
    "LightCurve.light": "light",
    "Pollution.phases": "pollution_phases",
    "Instrument.freeze_end": "freeze_end",
    "Instrument.dropout_end": "dropout_end",
}
"""Key of the table, by the field of the sensor that a fault names."""


class AxialSignal(NamedTuple):
    """Output of the axial sensor."""

    position: Position
    light: Fraction


def axial_sensor_of(table: AxialSensorTable) -> AxialSensor:
    """The sensor that a table describes. Raises ParameterError where its calibration cannot show a position."""
    curve = LightCurve(positions=table.positions, light=table.light)
    near = Pollution(scale=table.pollution_scale, amplitudes=table.pollution_amplitudes, phases=table.pollution_phases)
    far = near
    if table.far_amplitudes:
        far = Pollution(scale=table.pollution_scale, amplitudes=table.far_amplitudes, phases=table.far_phases)
    slope = (table.light[-1] - table.light[0]) / (table.positions[-1] - table.positions[0])
    instrument = replace(
        ideal_instrument(0.0, 1.0),
        offset=slope * table.bias,
        noise=abs(slope) * table.noise,
        seed=table.seed,
        freeze_begin=table.freeze_begin,
        freeze_end=table.freeze_end,
        dropout_begin=table.dropout_begin,
        dropout_end=table.dropout_end,
    )
    return AxialSensor(curve=curve, calibration=curve, near=near, far=far, instrument=instrument)


def sensor_step(
    t: float, memory: InstrumentMemory, reading: SpoolPlace, settings: AxialSensor
) -> tuple[InstrumentMemory, AxialSignal]:
    """Position of a spool as the light off its end shows it, polluted with every turn."""
    remembered, seen = axial_sensor_step(memory, reading, settings)
    return remembered, AxialSignal(seen.position, seen.light)


AXIAL_SENSOR = GenericProgram(
    ProgramType(sensor_step, SpoolPlace, AxialSignal(0.0, 0.0), AxialSensorTable, axial_sensor_start),
    made=axial_sensor_of,
)
