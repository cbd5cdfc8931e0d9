"""Fixed displacement pump with flow ripple, leakage and friction.

Source  ours, docs/models/components.md, where a function names no other.
"""

from typing import Annotated, NamedTuple

import numpy as np

from vvdp.base.kinds import Conductance, Count, Displacement, Fraction, FrictionTorque
from vvdp.base.params import Params, without_effect
from vvdp.base.select import minimum, select
from vvdp.fluid.mixture import FluidState


class Pump(Params):
    """A pump; its flow swings by `ripple_amplitude` of the mean, `ripple_count` (vanes, pistons) times per revolution.

    `friction_torque` is the torque of the shaft beyond the hydraulic torque, independent of pressure and speed.
    `dead_volume` is the oil that stays behind in all chambers in one revolution, and expands before they fill.
    `precompression` is the share of the compression in closed chambers: at 1 they open at their own pressure, at 0 a
    chamber at one pressure is joined with the other, and the energy of the oil that fills it is lost.
    """

    displacement: Displacement
    leakage_conductance: Conductance
    ripple_amplitude: Fraction = 0.0
    ripple_count: Annotated[Count, without_effect("ripple_amplitude")] = 9.0
    friction_torque: FrictionTorque
    dead_volume: Displacement = 0.0
    precompression: Fraction = 1.0


class Delivery(NamedTuple):
    """Displacement of a pump per angle [tank volumes, m^3/rad], and the torque that goes into no oil [N m]."""

    displacement: Displacement
    unused_torque: FrictionTorque


def is_ideal(pump: Pump) -> bool:
    """Whether the chambers of a pump neither lose nor keep oil, so that `tank_displacement` describes them fully."""
    return pump.dead_volume == 0.0 and pump.precompression == 1.0


def tank_displacement(shaft_angle: float, inlet: FluidState, pump: Pump) -> float:
    """Displacement of a pump without dead volume per angle [tank volumes, m^3/rad]: D (1 + r sin(z theta))/nu_in.

    It fills at its inlet's pressure, so its displacement is counted there and does not depend on the outlet
    pressure. Times the speed it is the flow, times h_out - h_in the hydraulic torque.

    shaft_angle  theta [rad]
    inlet        oil where the pump fills
    """
    return pump.displacement * (1.0 + flow_ripple(shaft_angle, pump)) * (1.0 / inlet.volume_ratio)


def delivery(shaft_angle: float, inlet: FluidState, outlet: FluidState, pump: Pump, swivel: float = 1.0) -> Delivery:
    """Displacement of a pump per angle, and the torque of its chambers that goes into no oil.

    d = D (1 + r sin(z theta))/nu_in - V_d (1/nu_out - 1/nu_in), not below zero: what its dead volume V_d held more at
    the outlet's pressure is not taken in. The oil takes the torque d (h_out - h_in). Without precompression the shaft
    works against the whole difference of pressure: (1 - c) (D (1 + r) (P_out - P_in) - d (h_out - h_in)) is lost, never
    negative, c the precompression. A variable pump has s D in place of D, and the same dead volume.

    shaft_angle  theta [rad]
    inlet        oil where the pump fills
    outlet       oil where it delivers
    swivel       s, share of its displacement to which it is stroked [1]

    >>> from vvdp.fluid.mixture import fluid_state
    >>> inlet, outlet = fluid_state(1e5, oil), fluid_state(100e5, oil)
    >>> pump = Pump(displacement=3.63e-6, leakage_conductance=0.0, friction_torque=0.0, precompression=0.0)
    >>> print(round(delivery(0.0, inlet, outlet, pump).unused_torque / (3.63e-6 * 99e5), 4))  # of the work
    0.0126
    """
    filled = swivel * tank_displacement(shaft_angle, inlet, pump)
    swept = filled * inlet.volume_ratio
    kept = pump.dead_volume * (1.0 / outlet.volume_ratio - 1.0 / inlet.volume_ratio)
    d = filled - minimum(kept, filled)
    work = swept * (outlet.pressure - inlet.pressure) - d * (outlet.enthalpy - inlet.enthalpy)
    return Delivery(d, (1.0 - pump.precompression) * work)


def flow_ripple(shaft_angle: float, pump: Pump) -> float:
    """Deviation of the flow of a pump from its mean, over the mean [1]: r sin(z theta).

    shaft_angle  theta [rad]
    """
    swing: float = pump.ripple_amplitude * np.sin(pump.ripple_count * shaft_angle)
    return swing


def flow_ripple_compiled(shaft_angle: float, pump: Pump) -> float:
    """The same as `flow_ripple`, which it replaces in compiled code: no sine is calculated for a pump without ripple.

    shaft_angle  theta [rad]
    """
    if pump.ripple_amplitude == 0.0:
        return 0.0
    swing: float = pump.ripple_amplitude * np.sin(pump.ripple_count * shaft_angle)
    return swing


def pump_friction_power(shaft_speed: float, pump: Pump) -> float:
    """Power that the friction of a pump dissipates [W]: T_f |omega|.

    shaft_speed  omega [rad/s]
    """
    return pump.friction_torque * abs(shaft_speed)


def against(torque: float, shaft_speed: float) -> float:
    """A torque against the speed [N m]: with the sign of the speed, none at rest.

    torque       its size [N m]
    shaft_speed  omega [rad/s]
    """
    return select(shaft_speed > 0.0, torque, 0.0) - select(shaft_speed < 0.0, torque, 0.0)
