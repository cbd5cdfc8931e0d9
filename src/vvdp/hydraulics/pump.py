"""Fixed displacement pump with flow ripple, leakage and friction.

Source  ours, docs/models/components.md, where a function names no other.
"""

import numpy as np

from vvdp.base.kinds import Conductance, Count, Displacement, Fraction, Torque
from vvdp.base.params import Params
from vvdp.base.select import select
from vvdp.fluid.mixture import FluidState


class Pump(Params):
    """A pump; its flow swings by `ripple_amplitude` of the mean, `ripple_count` times per revolution.

    `friction_torque` is what the shaft takes beyond the hydraulic torque, whatever the pressure and speed.
    """

    displacement: Displacement
    leakage_conductance: Conductance
    ripple_amplitude: Fraction = 0.0
    ripple_count: Count = 9.0
    friction_torque: Torque


def tank_displacement(shaft_angle: float, inlet: FluidState, pump: Pump) -> float:
    """What a pump displaces per angle [tank volumes, m^3/rad]: D (1 + r sin(z theta))/nu_in.

    It fills at its inlet's pressure, so what it displaces is counted there and does not depend on the pressure it is
    pushed against. Times the speed it is the flow, times h_out - h_in the hydraulic torque.

    shaft_angle  theta [rad]
    inlet        oil where the pump fills
    """
    return pump.displacement * (1.0 + flow_ripple(shaft_angle, pump)) * (1.0 / inlet.volume_ratio)


def flow_ripple(shaft_angle: float, pump: Pump) -> float:
    """How far the flow of a pump is from its mean, over the mean [1]: r sin(z theta).

    shaft_angle  theta [rad]
    """
    swing: float = pump.ripple_amplitude * np.sin(pump.ripple_count * shaft_angle)
    return swing


def flow_ripple_compiled(shaft_angle: float, pump: Pump) -> float:
    """The same as `flow_ripple`, which it replaces in compiled code: no sine is worked out for a pump without ripple.

    shaft_angle  theta [rad]
    """
    if pump.ripple_amplitude == 0.0:
        return 0.0
    swing: float = pump.ripple_amplitude * np.sin(pump.ripple_count * shaft_angle)
    return swing


def pump_friction_power(shaft_speed: float, pump: Pump) -> float:
    """Power that the friction of a pump turns to heat [W]: T_f |omega|.

    shaft_speed  omega [rad/s]
    """
    return pump.friction_torque * abs(shaft_speed)


def pump_friction_torque(shaft_speed: float, pump: Pump) -> float:
    """Friction of a pump [N m], against the speed: T_f with the sign of omega, none at rest.

    shaft_speed  omega [rad/s]
    """
    forward = select(shaft_speed > 0.0, pump.friction_torque, 0.0)
    backward = select(shaft_speed < 0.0, pump.friction_torque, 0.0)
    return forward - backward
