"""Pump and motor of variable displacement, whose setting something outside asks for."""

from typing import NamedTuple

from vvdp.base.kinds import Flow, Kink, SignedFraction, Torque
from vvdp.components.machines import MotorLosses
from vvdp.fluid.mixture import FluidState
from vvdp.hydraulics.flow import passage
from vvdp.hydraulics.friction import shaft_friction_torque
from vvdp.hydraulics.motor import motor_compression_loss, motor_flow, motor_torque
from vvdp.hydraulics.ports import ShaftSpeed
from vvdp.hydraulics.variable_machine import (
    SettingState,
    VariableMachine,
    pressure_friction_torque,
    setting_rate,
    setting_side,
)
from vvdp.network.component import Component


class MachineEffect(NamedTuple):
    """What a variable motor gives to its ports, what it loses, its leakage in tank volumes, and its setting."""

    a: Flow
    b: Flow
    shaft: Torque
    losses: MotorLosses
    leakage_flow: Flow
    setting: SignedFraction
    rates: SettingState
    side: Kink


class PumpingEffect(NamedTuple):
    """As `MachineEffect`, between the inlet and the outlet of a pump."""

    inlet: Flow
    outlet: Flow
    shaft: Torque
    losses: MotorLosses
    leakage_flow: Flow
    setting: SignedFraction
    rates: SettingState
    side: Kink


def variable_motor(
    a: FluidState,
    b: FluidState,
    shaft: ShaftSpeed,
    setting: SignedFraction,
    state: SettingState,
    values: VariableMachine,
) -> MachineEffect:
    """Motor whose displacement follows `setting`; below zero oil that goes from a to b turns it backward.

    It displaces s D omega, counted at the side that the oil comes from, with the torque s D (P_a - P_b).
    """
    s = state.setting
    displacing = s * shaft.speed
    displaced = passage(motor_flow(displacing, values), a, b)
    leak = passage(values.leakage_conductance * (a.pressure - b.pressure), a, b)
    friction = shaft_friction_torque(shaft.speed, values) + pressure_friction_torque(shaft.speed, a, b, values)
    q = displaced.flow + leak.flow
    return MachineEffect(
        a=-q,
        b=q,
        shaft=s * motor_torque(a, b, values) - friction,
        losses=MotorLosses(leak.loss, friction * shaft.speed, motor_compression_loss(displacing, a, b, values)),
        leakage_flow=leak.flow,
        setting=s,
        rates=SettingState(setting_rate(setting, s, values)),
        side=setting_side(setting, s, values),
    )


def variable_pump(
    inlet: FluidState,
    outlet: FluidState,
    shaft: ShaftSpeed,
    setting: SignedFraction,
    state: SettingState,
    values: VariableMachine,
) -> PumpingEffect:
    """Pump whose displacement follows `setting`; below zero it takes from its outlet and gives to its inlet."""
    done = variable_motor(inlet, outlet, shaft, setting, state, values)
    return PumpingEffect(
        inlet=done.a,
        outlet=done.b,
        shaft=done.shaft,
        losses=done.losses,
        leakage_flow=-done.leakage_flow,
        setting=done.setting,
        rates=done.rates,
        side=done.side,
    )


def setting_start(values: VariableMachine) -> SettingState:
    """At its initial setting."""
    return SettingState(values.initial_setting)


def machine_inertia(values: VariableMachine) -> float:
    """Moment of inertia that a machine adds to its shaft [kg m^2]."""
    return values.inertia


AVERAGES = ("leakage_flow", "setting")
VARIABLE_PUMP = Component(
    variable_pump, symbol="overcentre_pump", start=setting_start, inertia=machine_inertia, averages=AVERAGES
)
VARIABLE_MOTOR = Component(
    variable_motor, symbol="overcentre_motor", start=setting_start, inertia=machine_inertia, averages=AVERAGES
)
