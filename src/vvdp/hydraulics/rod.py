"""Forces on a rod besides those of oil and friction: end stops, springs, weights.

Source  ours, docs/models/components.md, where a function names no other.
"""

from typing import Annotated, NamedTuple

import numpy as np

from vvdp.base.kinds import Angle, Force, Kind, Kink, Mass, Position, Power, Stiffness
from vvdp.base.modes import side
from vvdp.base.params import Params
from vvdp.base.rules import refuse, require_less, require_positive
from vvdp.base.select import maximum

IMPACT_DAMPING = Kind("impact damping", "s/m", 0.0, 1e4, "1 s/m")
ImpactDamping = Annotated[float, IMPACT_DAMPING]
GRAVITY = 9.80665
"""Standard acceleration of free fall [m/s^2]."""
ACCELERATION = Kind("acceleration", "m/s^2", 0.0, 1e4, "9.81 m/s^2")
Acceleration = Annotated[float, ACCELERATION]


class EndStop(Params):
    """Two elastic stops, the rod moves freely from `lower_end` to `upper_end`.

    A stop gives `stop_stiffness` times the depth, more by `stop_damping` times the speed going in and less coming out.
    """

    lower_end: Position
    upper_end: Position
    stop_stiffness: Stiffness
    stop_damping: ImpactDamping

    def check(self) -> None:
        require_less(self, "lower_end", "upper_end")
        require_positive(self, "stop_stiffness")


class StopForce(NamedTuple):
    """Force of the end stops on the rod: `force` in the direction of the position; `loss`, power dissipated."""

    force: Force
    loss: Power


class Spring(Params):
    """A straight spring that draws the rod back: it gives `preload` at `rest_position`, more beyond.

    A negative preload pushes the rod forward; what counts is the force on the rod, whichever side the spring sits on.
    """

    stiffness: Stiffness
    preload: Force
    rest_position: Position


class Weight(Params):
    """A mass that moves with the rod, uphill by `slope` over the horizontal where the position grows.

    Slope 0: the mass alone; a quarter turn: straight up.
    """

    mass: Mass
    slope: Angle
    gravity: Acceleration = GRAVITY

    def check(self) -> None:
        if abs(self.slope) > 0.5 * np.pi:
            refuse(self, "slope", "must lie between -90 deg and 90 deg (upright)")


def stop_force(position: float, velocity: float, stop: EndStop) -> StopForce:
    """Force of the end stops on the rod [N] and their loss [W], never negative.

    At depth s, going in with s': k s max(1 + c s', 0) outward, of which k s is given back. The force begins and ends
    at zero and never holds the rod.

    position  [m]
    velocity  [m/s]

    Source  hunt1975; without pull: ours, docs/models/components.md
    """
    k, c = stop.stop_stiffness, stop.stop_damping
    near = maximum(stop.lower_end - position, 0.0)
    far = maximum(position - stop.upper_end, 0.0)
    damped_near = maximum(-c * velocity, -1.0)
    damped_far = maximum(c * velocity, -1.0)
    return StopForce(
        k * near * (1.0 + damped_near) - k * far * (1.0 + damped_far),
        k * velocity * (far * damped_far - near * damped_near),
    )


class StopSides(NamedTuple):
    """Whether a rod touches its end stops; `base.modes.side`."""

    near: Kink
    far: Kink


def stop_sides(position: float, stop: EndStop) -> StopSides:
    """Whether a rod touches its end stops [1].

    position  [m]
    """
    travel = stop.upper_end - stop.lower_end
    return StopSides(side((stop.lower_end - position) / travel), side((position - stop.upper_end) / travel))


def stop_energy(position: float, stop: EndStop) -> float:
    """Energy in the end stops [J]: k s^2/2 at depth s.

    position  [m]
    """
    depth = maximum(stop.lower_end - position, 0.0) + maximum(position - stop.upper_end, 0.0)
    return 0.5 * stop.stop_stiffness * depth * depth


def spring_force(position: float, spring: Spring) -> float:
    """Force of a spring on the rod [N], in the direction of the position: -F_0 - k (x - x_0).

    position  x [m]
    """
    return -spring.preload - spring.stiffness * (position - spring.rest_position)


def spring_energy(position: float, spring: Spring) -> float:
    """Energy in a spring above that at its rest position [J]: F_0 (x - x_0) + k (x - x_0)^2/2.

    position  x [m]
    """
    reach = position - spring.rest_position
    return reach * (spring.preload + 0.5 * spring.stiffness * reach)


def weight_force(weight: Weight) -> float:
    """Force of a weight on the rod [N], in the direction of the position: -m g sin(slope)."""
    force: float = -weight.mass * weight.gravity * np.sin(weight.slope)
    return force


def weight_energy(position: float, weight: Weight) -> float:
    """Energy of height of a weight above position 0 [J]: m g x sin(slope).

    position  x [m]
    """
    return -weight_force(weight) * position
