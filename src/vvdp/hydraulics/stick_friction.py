"""Dry friction that truly sticks: it holds a rod like a stiff spring until it breaks away, and does not creep.

Source  ours, docs/models/components.md, where a function names no other.
"""

from typing import NamedTuple

from vvdp.base.kinds import Force, FrictionForce, Position, Power, Stiffness, Velocity, ViscousFriction
from vvdp.base.modes import side
from vvdp.base.params import Params
from vvdp.base.rules import require_positive
from vvdp.base.select import minimum, select


class StickFriction(Params):
    """Friction up to `dry_friction`, held by surfaces that give way by `stick_stiffness` with `stick_damping`."""

    dry_friction: FrictionForce
    stick_stiffness: Stiffness
    stick_damping: ViscousFriction

    def check(self) -> None:
        require_positive(self, "dry_friction", "stick_stiffness")


class StickState(NamedTuple):
    """Elastic deflection of the surfaces."""

    give: Position


class StickForce(NamedTuple):
    """Force against the motion, its loss, and how fast the surfaces give way."""

    force: Force
    loss: Power
    rate: Velocity


SLOW = 1e-3
"""Velocity over which the end of sliding is looked for [m/s]."""


def stick_force(velocity: float, give: float, sliding: float, friction: StickFriction) -> StickForce:
    """Friction against the motion [N]: k z + d z' with z' = v while it sticks, k z with z' = 0 while it slides.

    velocity  v [m/s]
    give      z [m]
    sliding   1 while it slides, else 0

    >>> dry = StickFriction(dry_friction=100.0, stick_stiffness=1e6, stick_damping=0.0)
    >>> stick_force(0.5, 1e-4, 1.0, dry)  # N, W, m/s
    StickForce(force=100.0, loss=50.0, rate=0.0)
    """
    rate = select(sliding > 0.5, 0.0, velocity)
    held = friction.stick_stiffness * give
    damped = friction.stick_damping * rate
    return StickForce(held + damped, held * (velocity - rate) + damped * rate, rate)


def stick_mode(velocity: float, give: float, sliding: float, friction: StickFriction) -> float:
    """Whether it is to slide [1], see `base.modes.side`: from breaking away until the motion turns round.

    velocity  [m/s]
    give      [m]
    sliding   1 while it slides, else 0
    """
    ahead = velocity * select(give < 0.0, -1.0, 1.0) / SLOW
    beyond = friction.stick_stiffness * abs(give) / friction.dry_friction - 1.0
    return side(select(sliding > 0.5, ahead, minimum(beyond, ahead)))


def stick_energy(give: float, friction: StickFriction) -> float:
    """Energy in the surfaces [J]: k z^2/2.

    give  z [m]
    """
    return 0.5 * friction.stick_stiffness * give * give
