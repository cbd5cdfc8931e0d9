"""The optical sensor of the spool's axial position: light off the spool's end, polluted once per turn of the spool.

The end is neither even nor square to the axis, so that the light swings with the spool's angle as if the spool moved.
Derived in docs/models/axial-drives.md.

Source  ours, docs/models/axial-drives.md, where a function names no other.
"""

from typing import Annotated, NamedTuple

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.errors import ParameterError
from vvdp.base.kinds import ANGLE, FRACTION, POSITION, RATIO, Angle, Fraction, Length, Position, Time
from vvdp.base.params import Params
from vvdp.base.rules import refuse_rows, require_rising
from vvdp.base.select import clip
from vvdp.numerics.piecewise import piecewise_linear
from vvdp.sensing.instrument import Instrument, InstrumentMemory, instrument_start, instrument_step


class Pollution(Params):
    """Periodic sensor error, added to the measured position: scale sum(a_g sin(g theta + phi_g)), g from 1 on, theta
    the spool's angle."""

    scale: Length
    amplitudes: Annotated[tuple[float, ...], RATIO]
    phases: Annotated[tuple[float, ...], ANGLE]

    def check(self) -> None:
        if len(self.amplitudes) != len(self.phases):
            refuse_rows(self, "phases", f"{len(self.phases)} for {len(self.amplitudes)} amplitudes; expected one each")


class LightCurve(Params):
    """Share of the light that comes back, by position: the mean over a turn, straight lines between the rows."""

    positions: Annotated[tuple[float, ...], POSITION]
    light: Annotated[tuple[float, ...], FRACTION]

    def check(self) -> None:
        if len(self.positions) < 2 or len(self.positions) != len(self.light):
            refuse_rows(
                self,
                "light",
                f"{len(self.light)} rows for {len(self.positions)} positions; expected one for each of at least two",
            )
        require_rising(self, "positions")
        sign = -1.0 if self.light[-1] < self.light[0] else 1.0
        for row in range(1, len(self.light)):
            if not sign * (self.light[row] - self.light[row - 1]) > 0.0:
                refuse_rows(
                    self,
                    "light",
                    f"row {row + 1}, {self.light[row]:g} after {self.light[row - 1]:g}, must keep to the direction "
                    f"from {self.light[0]:g} to {self.light[-1]:g}: a position follows only from light that rises or "
                    "falls throughout",
                )


class AxialSensor(Params):
    """Light curve and calibration, periodic sensor error at the lower and at the upper end of the calibration, and
    instrument.

    Between the ends the periodic sensor error goes over from one to the other. The instrument measures the share of
    light: its offset is a bias, its faults are a frozen and a lost signal.
    """

    curve: LightCurve
    calibration: LightCurve
    near: Pollution
    far: Pollution
    instrument: Instrument


class SpoolPlace(NamedTuple):
    """True position and angle of the spool at a sample."""

    time: Time
    position: Position
    angle: Angle


class AxialReading(NamedTuple):
    """One sample of the axial sensor: the position that its calibration shows, and the share of light."""

    time: Time
    position: Position
    light: Fraction


def pollution_at(angle: float, pollution: Pollution) -> float:
    """Periodic sensor error at an angle of the spool [m]; it repeats with every revolution.

    angle  of the spool [rad]

    Source  wang2017, section 4.2.1
    """
    turn = 2.0 * np.pi
    rest = angle - turn * np.floor(angle / turn)
    added = 0.0
    for g in range(len(pollution.amplitudes)):
        added = added + pollution.amplitudes[g] * np.sin((g + 1.0) * rest + pollution.phases[g])
    return pollution.scale * added


def seen_position(position: float, angle: float, sensor: AxialSensor) -> float:
    """Position whose light comes off the spool [m], with the periodic sensor error there.

    position  of the spool [m]
    angle     of the spool [rad]
    """
    rows = sensor.calibration.positions
    share = clip((position - rows[0]) / (rows[len(rows) - 1] - rows[0]), 0.0, 1.0)
    return position + (1.0 - share) * pollution_at(angle, sensor.near) + share * pollution_at(angle, sensor.far)


def light_at(position: float, curve: LightCurve) -> float:
    """Share of the light that comes back [1].

    position  that is seen [m]
    """
    return piecewise_linear(position, curve.positions, curve.light)


def calibrated_position(light: float, calibration: LightCurve) -> float:
    """Position that a calibration shows [m]; beyond its ends, the end.

    light  share that comes back [1]
    """
    return piecewise_linear(light, calibration.light, calibration.positions)


def axial_sensor_start(sensor: AxialSensor) -> InstrumentMemory:
    """Memory before the first sample; equal seeds give equal noise."""
    return instrument_start(sensor.instrument)


def axial_sensor_step(
    memory: InstrumentMemory, place: SpoolPlace, sensor: AxialSensor
) -> tuple[InstrumentMemory, AxialReading]:
    """Memory and reading after a sample."""
    light = light_at(seen_position(place.position, place.angle, sensor), sensor.curve)
    remembered, measured = instrument_step(memory, place.time, light, sensor.instrument)
    return remembered, AxialReading(place.time, calibrated_position(measured, sensor.calibration), measured)


def calibrate(positions: Array, light: Array) -> LightCurve:
    """The calibration from whole turns, recorded at one position each: the mean over a turn.

    Raises ParameterError where the means neither rise nor fall throughout.

    positions  shape (n,), increasing [m]
    light      shape (n, samples of a turn) [1]
    """
    means = np.mean(light, axis=1)
    return LightCurve(positions=tuple(map(float, positions)), light=tuple(map(float, means)))


def recorded_pollution(record: Array, harmonics: int) -> Pollution:
    """The periodic sensor error that a turn recorded against a hard stop shows: its first harmonics, without the mean.

    Raises ParameterError where the record is too short to show them.

    record  positions seen at even angles from 0 over a turn, shape (samples,) [m]
    """
    if harmonics < 1 or 2 * harmonics >= len(record):
        raise ParameterError(
            f"{harmonics} harmonics of {len(record)} samples of a turn; expected fewer than half of them"
        )
    found = 2.0 * np.fft.rfft(record)[1 : harmonics + 1] / len(record)
    return Pollution(
        scale=1.0,
        amplitudes=tuple(map(float, np.abs(found))),
        phases=tuple(map(float, np.angle(found) + 0.5 * np.pi)),
    )
