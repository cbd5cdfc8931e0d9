"""Fixed displacement pump with flow ripple, leakage and friction."""

from typing import NamedTuple

import numpy as np

from vvdp.base.kinds import Conductance, Count, Displacement, Flow, Fraction, Torque
from vvdp.base.params import Params
from vvdp.base.select import select
from vvdp.fluid.mixture import FluidState


class Pump(Params):
    """A pump; its flow swings by `ripple_amplitude` of the mean, `ripple_count` times per revolution.

    `friction_torque` is what the shaft takes beyond the hydraulic torque, whatever the pressure and speed.
    """

    displacement: Displacement
    leakage_conductance: Conductance
    ripple_amplitude: Fraction
    ripple_count: Count
    friction_torque: Torque


class PumpFlow(NamedTuple):
    """`ideal`: what the pump displaces, in tank volumes per second. `leakage`: actual flow at the outlet pressure."""

    ideal: Flow
    leakage: Flow


def pump_flow(shaft_angle: float, shaft_speed: float, pressure_drop: float, pump: Pump) -> PumpFlow:
    """Flow that a pump displaces [tank volumes, m^3/s] and what leaks back at the outlet pressure [m^3/s].

    ideal = D omega (1 + r sin(z theta)), leakage = G dp. The pump fills at tank pressure, so what it displaces is
    counted there and does not depend on the pressure it is pushed against.

    shaft_angle    theta [rad]
    shaft_speed    omega [rad/s]
    pressure_drop  outlet less tank [Pa]

    Source  ours, docs/models/components.md
    """
    ripple = 1.0 + flow_ripple(shaft_angle, pump)
    return PumpFlow(pump.displacement * shaft_speed * ripple, pump.leakage_conductance * pressure_drop)


def flow_ripple(shaft_angle: float, pump: Pump) -> float:
    """How far the flow of a pump is from its mean, over the mean [1]: r sin(z theta).

    shaft_angle  theta [rad]

    Source  ours, docs/models/components.md
    """
    swing: float = pump.ripple_amplitude * np.sin(pump.ripple_count * shaft_angle)
    return swing


def flow_ripple_compiled(shaft_angle: float, pump: Pump) -> float:
    """The same as `flow_ripple`, which it replaces in compiled code: no sine is worked out for a pump without ripple.

    shaft_angle  theta [rad]

    Source  ours, docs/models/components.md
    """
    if pump.ripple_amplitude == 0.0:
        return 0.0
    swing: float = pump.ripple_amplitude * np.sin(pump.ripple_count * shaft_angle)
    return swing


def pump_friction_power(shaft_speed: float, pump: Pump) -> float:
    """Power that the friction of a pump turns to heat [W]: T_f |omega|.

    shaft_speed  omega [rad/s]

    Source  ours, docs/models/components.md
    """
    return pump.friction_torque * abs(shaft_speed)


def shaft_power(ideal_flow: float, shaft_speed: float, inlet: FluidState, outlet: FluidState, pump: Pump) -> float:
    """Power that the shaft of a pump takes [W]: hydraulic and friction, q (h_out - h_in) + T_f |omega|.

    Leakage costs no extra here: it has been displaced, and loses its power on the way back to the tank.

    ideal_flow   q, displaced [tank volumes, m^3/s]
    shaft_speed  omega [rad/s]
    inlet        oil where the pump fills, the tank
    outlet       oil where it delivers

    Source  ours, docs/models/components.md
    """
    return ideal_flow * (outlet.enthalpy - inlet.enthalpy) + pump_friction_power(shaft_speed, pump)


def pump_torque(shaft_angle: float, inlet: FluidState, outlet: FluidState, pump: Pump) -> float:
    """Hydraulic torque that a pump takes from its shaft [N m]: D (1 + r sin(z theta)) (h_out - h_in)/nu_in.

    Times the speed it is the power that the displaced oil gains, q (h_out - h_in).

    shaft_angle  theta [rad]
    inlet        oil where the pump fills
    outlet       oil where it delivers

    Source  ours, docs/models/components.md
    """
    gain = (outlet.enthalpy - inlet.enthalpy) / inlet.volume_ratio
    return pump.displacement * (1.0 + flow_ripple(shaft_angle, pump)) * gain


def pump_friction_torque(shaft_speed: float, pump: Pump) -> float:
    """Friction of a pump [N m], against the speed: T_f with the sign of omega, none at rest.

    shaft_speed  omega [rad/s]

    Source  ours, docs/models/components.md
    """
    forward = select(shaft_speed > 0.0, pump.friction_torque, 0.0)
    backward = select(shaft_speed < 0.0, pump.friction_torque, 0.0)
    return forward - backward
