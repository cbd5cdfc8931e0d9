"""Prime movers that respond to their load: an electric motor with speed control, a diesel engine with a governor."""

from typing import NamedTuple

from vvdp.base.kinds import Kink, Power, Speed, Torque
from vvdp.hydraulics.friction import shaft_friction_torque
from vvdp.hydraulics.ports import ExchangedPower, ShaftSpeed
from vvdp.hydraulics.prime_mover import (
    DieselEngine,
    ElectricMotor,
    GovernedMover,
    GovernorState,
    RackState,
    copper_loss,
    engine_torque,
    governed_share,
    governed_side,
    governor_rate,
    motor_limit,
)
from vvdp.network.component import Component


class ElectricLosses(NamedTuple):
    """Losses of a motor in its windings and by friction."""

    copper: Power
    friction: Power


class ElectricEffect(NamedTuple):
    """Torque of a motor on its shaft, its losses and electric power, what its control adds up, and where it stands."""

    shaft: Torque
    losses: ElectricLosses
    supplied: ExchangedPower
    rates: GovernorState
    side: Kink


class EngineEffect(NamedTuple):
    """Torque of an engine on its shaft, its friction and indicated power, its governor and rack, and its mode."""

    shaft: Torque
    loss: Power
    supplied: ExchangedPower
    rates: RackState
    side: Kink


def electric_motor(shaft: ShaftSpeed, speed: Speed, state: GovernorState, values: ElectricMotor) -> ElectricEffect:
    """An electric motor whose control holds `speed` as far as its torque and its power reach, driving or braking."""
    shortfall = speed - shaft.speed
    torque = governed_share(shortfall, state.held, -1.0, values) * motor_limit(shaft.speed, values)
    friction = shaft_friction_torque(shaft.speed, values)
    copper = copper_loss(torque, values)
    return ElectricEffect(
        shaft=torque - friction,
        losses=ElectricLosses(copper, friction * shaft.speed),
        supplied=torque * shaft.speed + copper,
        rates=GovernorState(governor_rate(shortfall, state.held, -1.0, values)),
        side=governed_side(shortfall, state.held, -1.0, values),
    )


def diesel_engine(shaft: ShaftSpeed, speed: Speed, state: RackState, values: DieselEngine) -> EngineEffect:
    """A diesel engine whose governor holds `speed` as far as its torque curve reaches."""
    shortfall = speed - shaft.speed
    drag = shaft_friction_torque(shaft.speed, values)
    torque = engine_torque(shaft.speed, state.rack, drag, values)
    wanted = governed_share(shortfall, state.held, 0.0, values)
    return EngineEffect(
        shaft=torque - drag,
        loss=drag * shaft.speed,
        supplied=torque * shaft.speed,
        rates=RackState(governor_rate(shortfall, state.held, 0.0, values), (wanted - state.rack) / values.rack_time),
        side=governed_side(shortfall, state.held, 0.0, values),
    )


def mover_inertia(values: GovernedMover) -> float:
    """Moment of inertia that a prime mover adds to its shaft [kg m^2]."""
    return values.inertia


ELECTRIC_MOTOR = Component(electric_motor, symbol="electric_motor", inertia=mover_inertia)
DIESEL_ENGINE = Component(diesel_engine, symbol="combustion_engine", inertia=mover_inertia)
