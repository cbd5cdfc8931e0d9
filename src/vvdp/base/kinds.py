"""The kinds of quantity: SI unit, plausible range, and how a user writes one.

A range says "plausible for hydraulics at all", not "right for this valve"; it is there to stop a slipped decimal or a
forgotten conversion. `scale` is the size below which differences of a *state* of this kind no longer matter: the
simulation's absolute tolerance is the relative one times it.
"""

import math
from dataclasses import dataclass, replace
from functools import cache
from typing import Annotated, TypeAlias

from vvdp.base.signal import Signal


@dataclass(frozen=True)
class Kind:
    """Unit and plausible range of a quantity.

    `units` lists the only units that a user may write, where conversion by dimension would be wrong or misleading.
    `accumulates` marks a state that grows for as long as a run lasts (an angle, an energy): its error is judged
    against `scale` alone.
    """

    name: str
    unit: str
    low: float
    high: float
    example: str
    scale: float = 1.0
    accumulates: bool = False
    units: tuple[str, ...] = ()

    @property
    def with_article(self) -> str:
        """The name with its article."""
        return f"{'an' if self.name[0] in 'aeiou' else 'a'} {self.name}"

    @property
    def display_unit(self) -> str:
        """The unit in which a user is shown the value."""
        return self.example.partition(" ")[2]

    def fault(self, value: float) -> str | None:
        """The fault of `value` [SI] in words, or None."""
        if self.low <= value <= self.high:  # False for nan too
            return None
        unit = "" if self.unit == "1" else f" {self.unit}"
        if not math.isfinite(value):
            return f"{value:g} is not a finite number; expected {self.with_article}, for example {self.example!r}"
        return f"{value:g}{unit} is outside {self.low:g} to {self.high:g}{unit} for {self.with_article}"


SPEED_UNITS = ("rpm", "rev/s", "rad/s", "deg/s")

PRESSURE_LEVEL = Kind("pressure level", "Pa", 0.0, 1e9, "100 bar", scale=1e5)
FINE_PRESSURE = replace(PRESSURE_LEVEL, name="pressure of oil that may boil", scale=100.0)
"""Of oil that may boil: at its vapour pressure, little pressure is much vapour."""
PRESSURE_DIFFERENCE = Kind("pressure difference", "Pa", 0.0, 1e9, "5 bar", scale=1e5)
FLOW = Kind("volume flow", "m^3/s", -1.0, 1.0, "40 lpm", scale=1e-5)
VOLUME = Kind("volume", "m^3", 0.0, 1.0, "12.7 cc", scale=1e-5)
AREA = Kind("area", "m^2", 0.0, 1.0, "36.5 mm^2", scale=1e-6)
LENGTH = Kind("length", "m", 0.0, 100.0, "12.7 mm", scale=1e-3)
POSITION = Kind("position", "m", -5e3, 5e3, "10 mm", scale=1e-3)  # a vehicle is a rod as well
CLEARANCE = Kind("clearance", "m", 1e-7, 1e-3, "12.7 um")
VELOCITY = Kind("velocity", "m/s", -100.0, 100.0, "0.1 m/s", scale=1e-2)
MASS = Kind("mass", "kg", 0.0, 1e6, "0.5 kg")
INERTIA = Kind("moment of inertia", "kg*m^2", 1e-9, 1e3, "4e-5 kg*m^2")
FORCE = Kind("force", "N", -1e8, 1e8, "1000 N")
STIFFNESS = Kind("stiffness", "N/m", 0.0, 1e12, "2.6 kN/m")
VISCOUS_FRICTION = Kind("viscous friction coefficient", "N*s/m", 0.0, 1e8, "2000 N*s/m")
ANGLE = Kind("angle", "rad", -1e9, 1e9, "90 deg", accumulates=True, units=("rad", "deg", "rev"))
SPEED = Kind("rotational speed", "rad/s", -1e5, 1e5, "1800 rpm", units=SPEED_UNITS)
RATE = Kind("rate", "1/s", 0.0, 1e6, "150 1/s", units=("1/s",))
FREQUENCY = Kind("frequency", "Hz", 0.0, 1e6, "72 Hz", units=("Hz", "kHz", "1/s"))
TIME = Kind("time", "s", 0.0, 1e6, "10 ms")
TEMPERATURE = Kind("temperature", "K", 223.15, 423.15, "40 degC", units=("degC", "K", "degF"))
TEMPERATURE_DIFFERENCE = Kind("temperature difference", "K", -1e4, 1e4, "5 K", units=("K",))
SPECIFIC_HEAT = Kind("specific heat", "J/(kg*K)", 1.0, 1e5, "1900 J/(kg*K)")
THERMAL_CONDUCTIVITY = Kind("thermal conductivity", "W/(m*K)", 1e-3, 1e3, "0.13 W/(m*K)")
DENSITY = Kind("density", "kg/m^3", 500.0, 2000.0, "876 kg/m^3")
KINEMATIC_VISCOSITY = Kind("kinematic viscosity", "m^2/s", 1e-7, 1e-1, "44.2 cSt")
DYNAMIC_VISCOSITY = Kind("dynamic viscosity", "Pa*s", 1e-4, 1e2, "0.0387 Pa*s")
THERMAL_EXPANSION = Kind("thermal expansion coefficient", "1/K", 0.0, 1e-2, "7e-4 1/K")
FALL = Kind("relative fall over temperature", "1/K", 0.0, 0.1, "5.5e-3 1/K")
# Far above any real oil on purpose: limit studies make the oil stiff to recover volume-counting formulas.
BULK_MODULUS = Kind("bulk modulus", "Pa", 1e6, 1e13, "1.4 GPa")
COMPLIANCE = Kind("elastic compliance", "1/Pa", 0.0, 1e-6, "3e-10 1/Pa")
CONDUCTANCE = Kind("laminar conductance", "m^3/(s*Pa)", 0.0, 1e-6, "2e-12 m^3/(s*Pa)")
DISPLACEMENT = Kind(
    "displacement", "m^3/rad", 0.0, 1e-2, "22.8 cc/rev", units=("cc/rev", "cm^3/rev", "in^3/rev", "m^3/rad")
)
DISCHARGE_COEFFICIENT = Kind("discharge coefficient", "1", 0.3, 1.0, "0.61")
AIR_FRACTION = Kind("volume fraction of free air", "1", 0.0, 0.5, "1 %")
POLYTROPIC = Kind("polytropic exponent", "1", 1.0, 1.7, "1.4")
FRACTION = Kind("fraction", "1", 0.0, 1.0, "0.5", scale=1e-2)
OPENING = Kind("opening", "1", 0.0, 1e6, "0.5", scale=1e-2)
"""Of a valve, 1 at its rated point, beyond which a relief valve opens further."""
SIGNED_FRACTION = Kind("signed fraction", "1", -1.0, 1.0, "0.5", scale=1e-2)
DUTY_RATIO = Kind("duty ratio", "1", -1.0, 2.0, "0.5")
COUNT = Kind("count", "1", 0.0, 1e6, "3")
RATIO = Kind("ratio", "1", 0.0, 1e6, "1.0")
POWER = Kind("power", "W", 0.0, 1e9, "5.6 kW")
ENERGY = Kind("energy", "J", -1e12, 1e12, "10 J", scale=1.0, accumulates=True)
# Energy that a shaft, say, hands on to a neighbour, or takes from it: may fall where losses may not.
EXCHANGED_ENERGY = Kind("energy handed on", "J", -1e12, 1e12, "10 J", scale=1.0, accumulates=True)
EXCHANGED_POWER = Kind("power handed on", "W", -1e9, 1e9, "10 W")
TANK_VOLUME = Kind("volume at tank conditions", "m^3", -1e6, 1e6, "1 l", scale=1e-6, accumulates=True)
TORQUE = Kind("torque", "N*m", -1e6, 1e6, "1.5 N*m")
FRICTION_FORCE = Kind("friction force", "N", 0.0, 1e9, "50 N")
FRICTION_TORQUE = Kind("friction torque", "N*m", 0.0, 1e6, "1.5 N*m")
FLOW_COEFFICIENT = Kind("flow coefficient", "m^3/(s*Pa^0.5)", 0.0, 1e-2, "1.2e-7 m^3/(s*Pa^0.5)")
ENERGY_DENSITY = Kind("energy per volume", "J/m^3", -1e12, 1e12, "10 MJ/m^3", scale=1e5)
PRESSURE_TIME = Kind("pressure over time", "Pa*s", -1e15, 1e15, "1 bar*s", accumulates=True)
DURATION = Kind("duration", "s", -1e9, 1e9, "1 s", accumulates=True)
# The radian has no dimension, so that a deviation would pass for a variance.
ANGULAR_VARIANCE = Kind("angular variance", "rad^2", 0.0, 1e6, "3.5e-3 rad^2", units=("rad^2", "deg^2"))
SPEED_VARIANCE = Kind(
    "variance of a rotational speed", "rad^2/s^2", 0.0, 1e10, "1000 rad^2/s^2", units=("rad^2/s^2", "rpm^2")
)
ANGLE_SPEED_COVARIANCE = Kind(
    "covariance of an angle and its speed", "rad^2/s", -1e10, 1e10, "1 rad^2/s", units=("rad^2/s",)
)
ACCELERATION_DENSITY = Kind(
    "spectral density of an angular acceleration", "rad^2/s^3", 0.0, 1e12, "0.25 rad^2/s^3", units=("rad^2/s^3",)
)
DRIFT = Kind("relative drift", "1", -0.1, 0.1, "1e-4")
RATIO_DRIFT = Kind("spectral density of the rate of a ratio", "1/s", 0.0, 1e6, "1e-3 1/s")
COUPLING = Kind("rotational damping", "N*m*s", 0.0, 1e3, "0.01 N*m*s")

NUMBER = Kind("number", "1", -1e300, 1e300, "0")
"""Of whatever a program counts with: the state of a generator, a flag, an evidence."""

# Of results: what is found may have a sign or a size that no one would prescribe.
GAUGE_PRESSURE = Kind("gauge pressure", "Pa", -1e9, 1e12, "100 bar", scale=1e5)
"""A pressure level that is kept as gauge already."""
SIGNED_PRESSURE = Kind("signed pressure difference", "Pa", -1e12, 1e12, "5 bar", scale=1e5)
MEAN_POWER = Kind("mean power", "W", -1e12, 1e12, "750 W")
EFFICIENCY = Kind("efficiency", "1", -1e300, 1e300, "61 %")
LEVEL = Kind("level", "dB", -1e300, 1e300, "-3 dB")
"""A ratio of amplitudes in decibels."""
ANGLE_ERROR = Kind("angle error", "rad", -1e300, 1e300, "0.1 rad", units=("rad", "deg"))
SPEED_ERROR = Kind("speed error", "rad/s", -1e300, 1e300, "0.1 rad/s", units=("rad/s", "rpm"))
SAMPLE_COST = Kind("computing time of a sample", "s", 0.0, 1e6, "60 ns")
FLAG = Kind("flag", "1", 0.0, 1.0, "1")
"""Whether something holds: 1 or 0, shown as yes or no."""

MODE = Kind("mode", "1", -1e300, 1e300, "1")
"""Where a law stands among its modes: the floor is the mode. Taken as an argument it is the mode that holds."""
KINK = Kind("side of a kink", "1", -1e300, 1e300, "1")
"""Like a mode that its law does not need to know: rates go on over a kink, and only their slopes change."""

Scalar: TypeAlias = float
"""A float in formulas. Arrays of one shape and CasADi symbols pass through the same text."""

Pressure = Annotated[float, PRESSURE_LEVEL]
FinePressure = Annotated[float, FINE_PRESSURE]
PressureDifference = Annotated[float, PRESSURE_DIFFERENCE]
Flow = Annotated[float, FLOW]
Volume = Annotated[float, VOLUME]
Area = Annotated[float, AREA]
Length = Annotated[float, LENGTH]
Position = Annotated[float, POSITION]
Clearance = Annotated[float, CLEARANCE]
Velocity = Annotated[float, VELOCITY]
Mass = Annotated[float, MASS]
Inertia = Annotated[float, INERTIA]
AddedInertia = Annotated[float, replace(INERTIA, low=0.0)]
Force = Annotated[float, FORCE]
Stiffness = Annotated[float, STIFFNESS]
ViscousFriction = Annotated[float, VISCOUS_FRICTION]
Angle = Annotated[float, ANGLE]
Speed = Annotated[float, SPEED]
Rate = Annotated[float, RATE]
Frequency = Annotated[float, FREQUENCY]
Time = Annotated[float, TIME]
Temperature = Annotated[float, TEMPERATURE]
TemperatureDifference = Annotated[float, TEMPERATURE_DIFFERENCE]
SpecificHeat = Annotated[float, SPECIFIC_HEAT]
ThermalConductivity = Annotated[float, THERMAL_CONDUCTIVITY]
Density = Annotated[float, DENSITY]
KinematicViscosity = Annotated[float, KINEMATIC_VISCOSITY]
DynamicViscosity = Annotated[float, DYNAMIC_VISCOSITY]
ThermalExpansion = Annotated[float, THERMAL_EXPANSION]
Fall = Annotated[float, FALL]
BulkModulus = Annotated[float, BULK_MODULUS]
Compliance = Annotated[float, COMPLIANCE]
Conductance = Annotated[float, CONDUCTANCE]
Displacement = Annotated[float, DISPLACEMENT]
DischargeCoefficient = Annotated[float, DISCHARGE_COEFFICIENT]
AirFraction = Annotated[float, AIR_FRACTION]
Polytropic = Annotated[float, POLYTROPIC]
Fraction = Annotated[float, FRACTION]
Opening = Annotated[float, OPENING]
SignedFraction = Annotated[float, SIGNED_FRACTION]
DutyRatio = Annotated[float, DUTY_RATIO]
Count = Annotated[float, COUNT]
Ratio = Annotated[float, RATIO]
Power = Annotated[float, POWER]
Energy = Annotated[float, ENERGY]
ExchangedEnergy = Annotated[float, EXCHANGED_ENERGY]
ExchangedPower = Annotated[float, EXCHANGED_POWER]
TankVolume = Annotated[float, TANK_VOLUME]
Torque = Annotated[float, TORQUE]
FrictionForce = Annotated[float, FRICTION_FORCE]
FrictionTorque = Annotated[float, FRICTION_TORQUE]
FlowCoefficient = Annotated[float, FLOW_COEFFICIENT]
EnergyDensity = Annotated[float, ENERGY_DENSITY]
PressureTime = Annotated[float, PRESSURE_TIME]
Duration = Annotated[float, DURATION]
Coupling = Annotated[float, COUPLING]
Drift = Annotated[float, DRIFT]
RatioDrift = Annotated[float, RATIO_DRIFT]
AngularVariance = Annotated[float, ANGULAR_VARIANCE]
Number = Annotated[float, NUMBER]
Mode = Annotated[float, MODE]
Kink = Annotated[float, KINK]
SpeedVariance = Annotated[float, SPEED_VARIANCE]
AngleSpeedCovariance = Annotated[float, ANGLE_SPEED_COVARIANCE]
AccelerationDensity = Annotated[float, ACCELERATION_DENSITY]

PressureSignal = Annotated[Signal, PRESSURE_LEVEL]
FlowSignal = Annotated[Signal, FLOW]
AreaSignal = Annotated[Signal, AREA]
PositionSignal = Annotated[Signal, POSITION]
ForceSignal = Annotated[Signal, FORCE]
SpeedSignal = Annotated[Signal, SPEED]
TemperatureSignal = Annotated[Signal, TEMPERATURE]
FractionSignal = Annotated[Signal, FRACTION]
SignedFractionSignal = Annotated[Signal, SIGNED_FRACTION]
DutySignal = Annotated[Signal, DUTY_RATIO]


@cache
def _kinds_by_name() -> dict[str, Kind]:
    return {kind.name: kind for kind in reversed(globals().values()) if isinstance(kind, Kind)}


def kind_named(name: str) -> Kind | None:
    """The kind of that name in this module, or None."""
    return _kinds_by_name().get(name)
