"""Pump and motor of variable displacement, whose setting is an input; their losses by a law or measured."""

from typing import NamedTuple

from vvdp.base.kinds import Flow, FrictionTorque, Kink, SignedFraction, Torque
from vvdp.components.machines import MotorLosses
from vvdp.fluid.mixture import FluidState
from vvdp.hydraulics.flow import passage
from vvdp.hydraulics.friction import smooth_sign
from vvdp.hydraulics.measured_machine import MeasuredMachine, measured_losses
from vvdp.hydraulics.motor import motor_compression_loss, motor_flow, motor_torque
from vvdp.hydraulics.ports import Medium, ShaftSpeed
from vvdp.hydraulics.variable_machine import (
    SettingDrive,
    SettingState,
    VariableMachine,
    drag_torque,
    setting_rate,
    setting_side,
    slip_flow,
)
from vvdp.network.component import Component


class MachineEffect(NamedTuple):
    """Flows of a variable motor to its ports, its losses, its leakage in tank volumes, and its setting."""

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


class Asked(NamedTuple):
    """Command of a setting, and its actual value."""

    wanted: SignedFraction
    now: SignedFraction


class Wear(NamedTuple):
    """Leakage of a machine at the higher pressure, and the torque that it takes from its shaft."""

    leakage: Flow
    drag: FrictionTorque


def variable_motor(
    a: FluidState,
    b: FluidState,
    shaft: ShaftSpeed,
    setting: SignedFraction,
    state: SettingState,
    medium: Medium,
    values: VariableMachine,
) -> MachineEffect:
    """Motor whose displacement follows `setting`; below zero oil that goes from a to b turns it backward.

    It displaces s D omega, counted at the side that the oil comes from, with the torque s D (P_a - P_b).
    """
    drop = a.pressure - b.pressure
    wear = Wear(slip_flow(drop, medium, values), drag_torque(shaft.speed, drop, state.setting, medium, values))
    return _turning_machine(a, b, shaft.speed, Asked(setting, state.setting), wear, values)


def variable_pump(
    inlet: FluidState,
    outlet: FluidState,
    shaft: ShaftSpeed,
    setting: SignedFraction,
    state: SettingState,
    medium: Medium,
    values: VariableMachine,
) -> PumpingEffect:
    """Pump whose displacement follows `setting`; below zero it takes from its outlet and gives to its inlet."""
    return _as_pump(variable_motor(inlet, outlet, shaft, setting, state, medium, values))


def measured_motor(
    a: FluidState,
    b: FluidState,
    shaft: ShaftSpeed,
    setting: SignedFraction,
    state: SettingState,
    values: MeasuredMachine,
) -> MachineEffect:
    """Motor whose displacement follows `setting`, with efficiencies that were measured as a motor."""
    return _measured_machine(a, b, shaft, Asked(setting, state.setting), 0.0, values)


def measured_pump(
    inlet: FluidState,
    outlet: FluidState,
    shaft: ShaftSpeed,
    setting: SignedFraction,
    state: SettingState,
    values: MeasuredMachine,
) -> PumpingEffect:
    """Pump whose displacement follows `setting`, with efficiencies that were measured as a pump."""
    return _as_pump(_measured_machine(inlet, outlet, shaft, Asked(setting, state.setting), 1.0, values))


def _measured_machine(
    a: FluidState, b: FluidState, shaft: ShaftSpeed, asked: Asked, pumps: float, values: MeasuredMachine
) -> MachineEffect:
    """A machine with measured efficiencies, those of a pump where `pumps` is 1."""
    drop = a.pressure - b.pressure
    lost = measured_losses(shaft.speed, drop, asked.now, pumps, values)
    wear = Wear(lost.conductance * drop, lost.friction_torque * smooth_sign(shaft.speed, values.coulomb_speed))
    return _turning_machine(a, b, shaft.speed, asked, wear, values)


def _turning_machine(
    a: FluidState, b: FluidState, speed: float, asked: Asked, wear: Wear, values: VariableMachine | MeasuredMachine
) -> MachineEffect:
    """A motor at a speed, with its wear, whose setting follows the demand."""
    s = asked.now
    displacing = s * speed
    displaced, leak = passage(motor_flow(displacing, values), a, b), passage(wear.leakage, a, b)
    q = displaced.flow + leak.flow
    return MachineEffect(
        a=-q,
        b=q,
        shaft=s * motor_torque(a, b, values) - wear.drag,
        losses=MotorLosses(leak.loss, wear.drag * speed, motor_compression_loss(displacing, a, b, values)),
        leakage_flow=leak.flow,
        setting=s,
        rates=SettingState(setting_rate(asked.wanted, s, values)),
        side=setting_side(asked.wanted, s, values),
    )


def _as_pump(done: MachineEffect) -> PumpingEffect:
    """A motor between the inlet and the outlet of a pump."""
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


def setting_start(values: SettingDrive) -> SettingState:
    """At its initial setting."""
    return SettingState(values.initial_setting)


def machine_inertia(values: VariableMachine) -> float:
    """Moment of inertia that a machine adds to its shaft [kg m^2]."""
    return values.inertia


def measured_inertia(values: MeasuredMachine) -> float:
    """Moment of inertia that a machine adds to its shaft [kg m^2]."""
    return values.inertia


AVERAGES = ("leakage_flow", "setting")
VARIABLE_PUMP = Component(
    variable_pump, symbol="overcentre_pump", start=setting_start, inertia=machine_inertia, averages=AVERAGES
)
VARIABLE_MOTOR = Component(
    variable_motor, symbol="overcentre_motor", start=setting_start, inertia=machine_inertia, averages=AVERAGES
)
MEASURED_PUMP = Component(
    measured_pump, symbol="variable_pump", start=setting_start, inertia=measured_inertia, averages=AVERAGES
)
MEASURED_MOTOR = Component(
    measured_motor, symbol="variable_motor", start=setting_start, inertia=measured_inertia, averages=AVERAGES
)
