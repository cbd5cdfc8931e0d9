"""A poppet on a seat, held by a spring: a check valve or a relief valve by its measures, with jet and friction.

Source  ours, docs/models/components.md, where a function names no other.
"""

from typing import NamedTuple

import numpy as np

from vvdp.base.kinds import Angle, Force, FrictionForce, Length, Stiffness, Time
from vvdp.base.modes import between
from vvdp.base.rules import refuse, require_less, require_positive
from vvdp.base.select import clip, maximum
from vvdp.hydraulics.orifice import Orifice


class PoppetValve(Orifice):
    """A cone of half angle `cone_angle` on a seat of `seat_diameter`, lifted by up to `largest_lift`.

    `preload` is the force of its spring on the seat, `stiffness` what that gains with the lift, and
    `poppet_friction` what holds the poppet where it is. It follows with the time constants `opening_time` and
    `closing_time`, at once without the former; without the latter it closes as it opens.
    """

    seat_diameter: Length
    cone_angle: Angle
    largest_lift: Length
    preload: Force
    stiffness: Stiffness
    poppet_friction: FrictionForce = 0.0
    opening_time: Time = 0.0
    closing_time: Time = 0.0

    def check(self) -> None:
        require_positive(self, "seat_diameter", "largest_lift", "stiffness", "cone_angle")
        require_less(self, "largest_lift", "seat_diameter")
        if self.preload < 0.0:
            refuse(self, "preload", "must be at least 0: a spring pushes the poppet onto its seat")
        if not self.cone_angle <= 0.5 * np.pi:
            refuse(self, "cone_angle", "must be at most 90 deg, a flat seat")
        if self.opening_time <= 0.0 < self.poppet_friction + self.closing_time:
            refuse(self, "opening_time", "must be greater than 0 with poppet_friction or closing_time")


class LiftRange(NamedTuple):
    """Lifts at which a poppet may stand, the same without friction."""

    low: Length
    high: Length


def poppet_area(lift: float, valve: PoppetValve) -> float:
    """Area between poppet and seat [m^2]: pi d x sin(alpha).

    lift  x [m]
    """
    area: float = np.pi * valve.seat_diameter * np.sin(valve.cone_angle) * lift
    return area


def free_lift(pressure_drop: float, hindrance: float, valve: PoppetValve) -> float:
    """Lift at which a poppet is in balance, not held between its ends [m]: (A dp - F_0 - F)/(k + k_jet).

    On the poppet acts A dp with A = pi d^2/4, against the spring, F_0 + k x, and against its own jet, which leaves
    along the cone: k_jet x = 2 C (pi d x sin(alpha)) cos(alpha) dp.

    pressure_drop  dp [Pa]
    hindrance      F [N]

    >>> valve = PoppetValve(seat_diameter=0.01, cone_angle=np.pi / 2, largest_lift=1e-3, preload=785.398,
    ...                     stiffness=1e5)
    >>> print(round(1e3 * free_lift(1.1e7, 0.0, valve), 3))  # 1 MPa above 10 MPa: 78.5 N over 100 N/mm
    0.785
    """
    d, ahead = valve.seat_diameter, maximum(pressure_drop, 0.0)
    jet = np.pi * d * valve.discharge_coefficient * np.sin(2.0 * valve.cone_angle) * ahead
    lift: float = (0.25 * np.pi * d * d * pressure_drop - valve.preload - hindrance) / (valve.stiffness + jet)
    return lift


def lift_range(pressure_drop: float, valve: PoppetValve) -> LiftRange:
    """Lifts between which friction lets a poppet stand [m].

    pressure_drop  [Pa]
    """
    low = clip(free_lift(pressure_drop, valve.poppet_friction, valve), 0.0, valve.largest_lift)
    return LiftRange(low, clip(free_lift(pressure_drop, -valve.poppet_friction, valve), 0.0, valve.largest_lift))


def poppet_side(pressure_drop: float, valve: PoppetValve) -> float:
    """Whether a poppet is to be on its seat, in between or fully lifted [1]; see `base.modes.between`.

    pressure_drop  [Pa]
    """
    return between(free_lift(pressure_drop, 0.0, valve) / valve.largest_lift)
