"""Machines between two volumes and a shaft: fixed and variable pump, hydraulic motor."""

from typing import NamedTuple

from vvdp.base.kinds import Flow, Fraction, Kink, Power, Pressure, Torque
from vvdp.fluid.mixture import FluidState
from vvdp.hydraulics.flow import passage
from vvdp.hydraulics.friction import shaft_friction_torque
from vvdp.hydraulics.motor import Motor, motor_compression_loss, motor_flow, motor_torque
from vvdp.hydraulics.ports import ShaftSpeed, ShaftState
from vvdp.hydraulics.pump import Pump, against, delivery, is_ideal, pump_friction_power, tank_displacement
from vvdp.hydraulics.variable_pump import PumpControl, SwivelState, held_level, swivel_rate, swivel_share, swivel_side
from vvdp.network.component import Component


class PumpLosses(NamedTuple):
    """Powers that a pump dissipates: its leakage's and its friction's."""

    leakage: Power
    friction: Power


class ChamberLosses(NamedTuple):
    """Powers that a pump dissipates: its leakage's, its friction's, and where chambers meet another pressure."""

    leakage: Power
    friction: Power
    compression: Power


class PumpEffect(NamedTuple):
    """Flows of a pump to its ports, its losses, and the tank volumes that leak back."""

    inlet: Flow
    outlet: Flow
    shaft: Torque
    losses: PumpLosses
    leakage_flow: Flow


class ChamberEffect(NamedTuple):
    """Flows of a pump to its ports, losses of it and of its chambers, and the tank volumes that leak back."""

    inlet: Flow
    outlet: Flow
    shaft: Torque
    losses: ChamberLosses
    leakage_flow: Flow


class ControlledPumpEffect(NamedTuple):
    """As `ChamberEffect`, with the share of its displacement, the rate of its control, and at which end that stands."""

    inlet: Flow
    outlet: Flow
    shaft: Torque
    losses: ChamberLosses
    leakage_flow: Flow
    share: Fraction
    rates: SwivelState
    side: Kink


class MotorLosses(NamedTuple):
    """Powers that a motor dissipates: its leakage's, its friction's, and where chambers meet the other pressure."""

    leakage: Power
    friction: Power
    compression: Power


class MotorEffect(NamedTuple):
    """Effect of a motor on its ports, its losses, and the tank volumes that leak from port a to port b."""

    a: Flow
    b: Flow
    shaft: Torque
    losses: MotorLosses
    leakage_flow: Flow


def pump(inlet: FluidState, outlet: FluidState, shaft: ShaftState, values: Pump) -> PumpEffect:
    """A pump that fills at its inlet's pressure, gives all it displaces to its outlet, and leaks back to its inlet.

    It displaces D omega (1 + r sin(z theta)), counted at the inlet: over nu there, in tank volumes.
    """
    displacement = tank_displacement(shaft.angle, inlet, values)
    q = displacement * shaft.speed
    leak = passage(values.leakage_conductance * (outlet.pressure - inlet.pressure), outlet, inlet)
    torque = displacement * (outlet.enthalpy - inlet.enthalpy) + against(values.friction_torque, shaft.speed)
    return PumpEffect(
        inlet=leak.flow - q,
        outlet=q - leak.flow,
        shaft=-torque,
        losses=PumpLosses(leak.loss, pump_friction_power(shaft.speed, values)),
        leakage_flow=leak.flow,
    )


def chamber_pump(inlet: FluidState, outlet: FluidState, shaft: ShaftState, values: Pump) -> ChamberEffect:
    """A pump whose chambers keep some oil, or meet the line at another pressure; see `delivery`.

    What fills chambers from the outlet that were not compressed before is lost, forwards and backwards.
    """
    return _at_swivel(inlet, outlet, shaft, 1.0, values)


def controlled_pump(
    inlet: FluidState,
    outlet: FluidState,
    shaft: ShaftState,
    load_pressure: Pressure,
    state: SwivelState,
    values: Pump,
    control: PumpControl,
    second_pressure: Pressure = 0.0,
    third_pressure: Pressure = 0.0,
) -> ControlledPumpEffect:
    """Load-sensing variable pump: its outlet is held a margin above the highest of up to three load pressures.

    At a share of its displacement it leaks and rubs as at the full one.
    """
    shortfall = held_level(control, load_pressure, second_pressure, third_pressure) - outlet.pressure
    swivel = swivel_share(shortfall, state.swivel, control)
    done = _at_swivel(inlet, outlet, shaft, swivel, values)
    return ControlledPumpEffect(
        inlet=done.inlet,
        outlet=done.outlet,
        shaft=done.shaft,
        losses=done.losses,
        leakage_flow=done.leakage_flow,
        share=swivel,
        rates=SwivelState(swivel_rate(shortfall, state.swivel, control)),
        side=swivel_side(shortfall, state.swivel, control),
    )


def _at_swivel(inlet: FluidState, outlet: FluidState, shaft: ShaftState, swivel: float, values: Pump) -> ChamberEffect:
    """Effect of a pump at a share of its displacement."""
    displacement, unused = delivery(shaft.angle, inlet, outlet, values, swivel)
    q = displacement * shaft.speed
    leak = passage(values.leakage_conductance * (outlet.pressure - inlet.pressure), outlet, inlet)
    hindrance = against(values.friction_torque + unused, shaft.speed)
    return ChamberEffect(
        inlet=leak.flow - q,
        outlet=q - leak.flow,
        shaft=-displacement * (outlet.enthalpy - inlet.enthalpy) - hindrance,
        losses=ChamberLosses(leak.loss, pump_friction_power(shaft.speed, values), unused * abs(shaft.speed)),
        leakage_flow=leak.flow,
    )


def motor(a: FluidState, b: FluidState, shaft: ShaftSpeed, values: Motor) -> MotorEffect:
    """A hydraulic motor: oil that goes from a to b turns it forward, and it leaks from the higher to the lower side.

    It displaces D omega, counted at the side that the oil comes from, with the torque D (P_a - P_b).
    """
    displaced = passage(motor_flow(shaft.speed, values), a, b)
    leak = passage(values.leakage_conductance * (a.pressure - b.pressure), a, b)
    q = displaced.flow + leak.flow
    friction = shaft_friction_torque(shaft.speed, values)
    compression = motor_compression_loss(shaft.speed, a, b, values)
    return MotorEffect(
        a=-q,
        b=q,
        shaft=motor_torque(a, b, values) - friction,
        losses=MotorLosses(leak.loss, friction * shaft.speed, compression),
        leakage_flow=leak.flow,
    )


def motor_inertia(values: Motor) -> float:
    """Moment of inertia that a motor adds to its shaft [kg m^2]."""
    return values.inertia


CHAMBER_PUMP = Component(chamber_pump, symbol="pump", averages=("leakage_flow",), offered=False)
CONTROLLED_PUMP = Component(controlled_pump, symbol="variable_pump", averages=("leakage_flow", "share"))


def suited_pump(values: Pump) -> Component:
    """The simpler of the two pumps that does for its values."""
    return PUMP if is_ideal(values) else CHAMBER_PUMP


PUMP = Component(pump, symbol="pump", averages=("leakage_flow",), suited=suited_pump)
MOTOR = Component(motor, symbol="motor", inertia=motor_inertia, averages=("leakage_flow",))
