"""Prime movers that respond to their load: an electric motor with speed control, a diesel engine with a governor.

Source  ours, docs/models/components.md, where a function names no other.
"""

from typing import Annotated, NamedTuple

from vvdp.base.kinds import (
    FRICTION_TORQUE,
    SPEED,
    Fraction,
    FrictionTorque,
    Inertia,
    Power,
    SignedFraction,
    Speed,
    Time,
)
from vvdp.base.modes import between
from vvdp.base.rules import refuse_rows, require_positive, require_rising
from vvdp.base.select import clip, minimum, select
from vvdp.hydraulics.friction import ShaftFriction
from vvdp.numerics.piecewise import piecewise_linear


class GovernedMover(ShaftFriction):
    """Motor with a governor that holds the speed of a shaft: a speed that is `speed_band` too low raises the torque
    from zero to the maximum.

    `reset_time` > 0: the remaining speed error vanishes with that time constant; 0: it stays, as a droop.
    """

    inertia: Inertia
    speed_band: Speed
    reset_time: Time = 0.0

    def check(self) -> None:
        require_positive(self, "speed_band")


class ElectricMotor(GovernedMover):
    """A motor that gives up to `largest_torque` either way, and no more than `largest_power`.

    Its windings lose `copper_loss` at its largest torque, and with the square of the torque.
    """

    largest_torque: FrictionTorque
    largest_power: Power
    copper_loss: Power = 0.0

    def check(self) -> None:
        require_positive(self, "largest_torque", "largest_power")


class DieselEngine(GovernedMover):
    """An engine that gives at full rack the torques `full_torques` at `speeds`, in straight lines between.

    Beyond the outermost speeds the outermost torques hold. The rack follows with the time constant `rack_time`; without
    fuel the engine's friction drags it.
    """

    speeds: Annotated[tuple[float, ...], SPEED]
    full_torques: Annotated[tuple[float, ...], FRICTION_TORQUE]
    rack_time: Time

    def check(self) -> None:
        require_positive(self, "rack_time")
        if len(self.speeds) < 2 or len(self.speeds) != len(self.full_torques):
            refuse_rows(
                self,
                "full_torques",
                f"{len(self.full_torques)} torques for {len(self.speeds)} speeds; expected one for each of at least "
                "two",
            )
        require_rising(self, "speeds")


class GovernorState(NamedTuple):
    """Integral part of a governor."""

    held: SignedFraction


class RackState(NamedTuple):
    """Integral part of a governor, and position of its rack."""

    held: SignedFraction
    rack: Fraction


def governed_share(shortfall: float, held: float, least: float, mover: GovernedMover) -> float:
    """Share of its torque that a governor demands [1]: x + (omega_r - omega)/band, held between `least` and 1.

    shortfall  omega_r - omega [rad/s]
    held       x, its state [1]
    least      -1 of a mover that also brakes, 0 of one that only drives [1]
    """
    share: float = clip(_wanted_share(shortfall, held, mover), least, 1.0)
    return share


def _wanted_share(shortfall: float, held: float, mover: GovernedMover) -> float:
    return held + shortfall / mover.speed_band


def governed_side(shortfall: float, held: float, least: float, mover: GovernedMover) -> float:
    """Whether a governor demands the least torque, one in between, or the maximum [1]; see `base.modes.between`.

    shortfall, held, least  as in `governed_share`
    """
    return between((_wanted_share(shortfall, held, mover) - least) / (1.0 - least))


def governor_rate(shortfall: float, held: float, least: float, mover: GovernedMover) -> float:
    """Rate of a governor's state [1/s]: (share - x)/T, so that nothing winds up at an end; 0 without a reset time.

    shortfall, held, least  as in `governed_share`
    """
    T = mover.reset_time
    rate = (governed_share(shortfall, held, least, mover) - held) / select(T > 0.0, T, 1.0)
    return select(T > 0.0, rate, 0.0)


def motor_limit(shaft_speed: float, motor: ElectricMotor) -> float:
    """Largest torque of an electric motor [N m]: min(T_max, P_max/|omega|).

    shaft_speed  omega [rad/s]

    >>> motor = ElectricMotor(shaft_damping=0.0, coulomb_torque=0.0, coulomb_speed=1.0, inertia=0.1, speed_band=1.0,
    ...                       largest_torque=100.0, largest_power=15e3)
    >>> motor_limit(100.0, motor), motor_limit(-300.0, motor)
    (100.0, 50.0)
    """
    base = motor.largest_power / motor.largest_torque
    omega = abs(shaft_speed)
    limit: float = motor.largest_torque * minimum(1.0, base / select(omega > base, omega, base))
    return limit


def copper_loss(torque: float, motor: ElectricMotor) -> float:
    """Power that the windings of an electric motor dissipate [W]: P_Cu (T/T_max)^2.

    torque  T [N m]
    """
    share = torque / motor.largest_torque
    return motor.copper_loss * share * share


def engine_torque(shaft_speed: float, rack: float, drag: float, engine: DieselEngine) -> float:
    """Torque that the fuel of a diesel engine gives [N m]: y (T_full + T_drag), so that T_full is left at full rack.

    shaft_speed  [rad/s]
    rack         y [1]
    drag         T_drag of the engine's friction [N m]

    >>> engine = DieselEngine(shaft_damping=0.0, coulomb_torque=0.0, coulomb_speed=1.0, inertia=1.0, speed_band=10.0,
    ...                       speeds=(0.0, 100.0, 200.0), full_torques=(0.0, 400.0, 300.0), rack_time=0.1)
    >>> engine_torque(150.0, 0.5, 20.0, engine)
    185.0
    """
    full: float = piecewise_linear(shaft_speed, engine.speeds, engine.full_torques)
    return rack * (full + drag)
