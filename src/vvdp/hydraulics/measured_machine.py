"""Pump or motor whose efficiencies were measured over speed, pressure and setting.

Source  ours, docs/models/components.md, where a function names no other.
"""

from typing import Annotated, NamedTuple

from vvdp.base.kinds import (
    FRACTION,
    PRESSURE_DIFFERENCE,
    SPEED,
    Conductance,
    Displacement,
    FrictionTorque,
    Inertia,
    Speed,
)
from vvdp.base.rules import refuse_rows, require_positive, require_rising
from vvdp.base.select import clip, select
from vvdp.hydraulics.variable_machine import SettingDrive


class MeasuredMachine(SettingDrive):
    """A machine of variable displacement with its measured efficiencies.

    There is one of each kind for every speed, pressure difference and setting: those of the first speed first, among
    them those of the first pressure, among them those of the first setting. Settings count without their sign.
    `coulomb_speed` is where the sign of the friction has reached 71 %.
    """

    displacement: Displacement
    inertia: Inertia
    coulomb_speed: Speed
    speeds: Annotated[tuple[float, ...], SPEED]
    pressures: Annotated[tuple[float, ...], PRESSURE_DIFFERENCE]
    settings: Annotated[tuple[float, ...], FRACTION]
    volumetric_efficiencies: Annotated[tuple[float, ...], FRACTION]
    mechanical_efficiencies: Annotated[tuple[float, ...], FRACTION]

    def check(self) -> None:
        require_positive(self, "displacement", "coulomb_speed")
        count = len(self.speeds) * len(self.pressures) * len(self.settings)
        for name in ("speeds", "pressures", "settings"):
            values = getattr(self, name)
            if not values:
                refuse_rows(self, name, "no rows; expected at least one")
            require_positive(self, name, why="an efficiency at 0 is not defined")
            require_rising(self, name)
        for name in ("volumetric_efficiencies", "mechanical_efficiencies"):
            values = getattr(self, name)
            if len(values) != count:
                refuse_rows(self, name, f"{len(values)} values; expected {count}, one per point")
            require_positive(self, name)


class MeasuredLosses(NamedTuple):
    """Leakage over the pressure difference, and friction, of a machine with measured efficiencies."""

    conductance: Conductance
    friction_torque: FrictionTorque


def _weight(place: float, places: tuple[float, ...], i: int) -> float:
    """Weight of a row in what lies between it and its neighbours [1]; the first and the last hold beyond."""
    weight = 1.0
    if i > 0:
        weight = clip((place - places[i - 1]) / (places[i] - places[i - 1]), 0.0, 1.0)
    if i < len(places) - 1:
        weight = weight - clip((place - places[i]) / (places[i + 1] - places[i]), 0.0, 1.0)
    return weight


def measured_losses(
    shaft_speed: float, pressure_drop: float, setting: float, pumps: float, machine: MeasuredMachine
) -> MeasuredLosses:
    """Conductance of the leakage [m^3/(s Pa)] and size of the friction [N m], linear between the points of the table.

    At a point a pump gives eta_v s D omega and takes s D dp/eta_m, so that G = (1 - eta_v) s D omega/dp and
    T_f = (1/eta_m - 1) s D dp. A motor takes s D omega/eta_v and gives eta_m s D dp: (1/eta_v - 1) and (1 - eta_m).

    shaft_speed    omega, either way [rad/s]
    pressure_drop  dp between the ports, either way [Pa]
    setting        s, either way [1]
    pumps          1 where the efficiencies are those of a pump, 0 of a motor
    """
    speeds, pressures, settings = machine.speeds, machine.pressures, machine.settings
    omega, drop, s = abs(shaft_speed), abs(pressure_drop), abs(setting)
    conductance, friction, row = 0.0, 0.0, 0
    for i in range(len(speeds)):
        at_speed = _weight(omega, speeds, i)
        for j in range(len(pressures)):
            at_pressure = at_speed * _weight(drop, pressures, j)
            for k in range(len(settings)):
                share = at_pressure * _weight(s, settings, k) * settings[k] * machine.displacement
                eta_v, eta_m = machine.volumetric_efficiencies[row], machine.mechanical_efficiencies[row]
                leak = (1.0 - eta_v) / select(pumps > 0.5, 1.0, eta_v)
                rub = (1.0 - eta_m) / select(pumps > 0.5, eta_m, 1.0)
                conductance = conductance + share * leak * speeds[i] / pressures[j]
                friction = friction + share * rub * pressures[j]
                row = row + 1
    return MeasuredLosses(conductance, friction)
