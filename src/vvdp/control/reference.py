"""Reference of a position: a raw command, smoothed so that its derivatives up to the jerk are known exactly.

The raw command is a `Signal`, such as those of `base.signal`, or a straight line from point to point (`trapezoid`).

Source  ours, docs/models/passivity-control.md, where a function names no other.
"""

from itertools import accumulate
from typing import Annotated, NamedTuple

from vvdp.base.kinds import RATE, Kind, Position, Time, Velocity
from vvdp.base.params import Params
from vvdp.base.powers import expm1
from vvdp.base.rules import require_positive

SIGNED_ACCELERATION = Kind("acceleration in either direction", "m/s^2", -1e6, 1e6, "9.81 m/s^2")
JERK = Kind("jerk", "m/s^3", -1e12, 1e12, "10 m/s^3")

Rate = Annotated[float, RATE]
SignedAcceleration = Annotated[float, SIGNED_ACCELERATION]
Jerk = Annotated[float, JERK]


class Reference(NamedTuple):
    """A position that is wanted, with its first three derivatives."""

    position: Position
    velocity: Velocity
    acceleration: SignedAcceleration
    jerk: Jerk


class ReferenceFilter(Params):
    """Four equal poles: the position follows a raw one as (w/(s + w))^4, w the `filter_rate`, 4/w late.

    Raises `ParameterError` for a rate of zero.
    """

    filter_rate: Rate

    def check(self) -> None:
        require_positive(self, "filter_rate", why="the reference would never move")


def reference_at_rest(position: float) -> Reference:
    """The reference that stands still at a position [m]."""
    return Reference(position, 0.0, 0.0, 0.0)


def reference_ahead(reference: Reference, interval: float) -> Reference:
    """The reference an `interval` [s] later if its jerk stays as it is."""
    x, v, a, j = reference
    t = interval
    return Reference(x + t * (v + t * (a / 2.0 + t * j / 6.0)), v + t * (a + t * j / 2.0), a + t * j, j)


def reference_step(reference: Reference, wanted: float, interval: float, settings: ReferenceFilter) -> Reference:
    """The reference one interval later, the raw position being held meanwhile; exact for any interval.

    With y the distance to the raw position and z_k = (d/dt + w)^k y, e^(w t) y has the derivatives e^(w t) z_k, of
    which the fourth is zero: y(t) = e^(-w t) (z_0 + z_1 t + z_2 t^2/2 + z_3 t^3/6), and so on for z_1, z_2, z_3.

    reference  at the beginning of the interval
    wanted     the raw position [m]
    interval   its length [s]
    """
    w = settings.filter_rate
    p, v, a, j = (
        reference.position - wanted,
        reference.velocity / w,
        reference.acceleration / w**2,
        reference.jerk / w**3,
    )
    z1, z2, z3 = p + v, p + 2.0 * v + a, p + 3.0 * v + 3.0 * a + j
    t = w * interval
    fading = 1.0 + expm1(-t)
    y0 = fading * (p + t * (z1 + t * (z2 / 2.0 + t * z3 / 6.0)))
    y1 = fading * (z1 + t * (z2 + t * z3 / 2.0))
    y2 = fading * (z2 + t * z3)
    y3 = fading * z3
    return Reference(
        position=wanted + y0,
        velocity=w * (y1 - y0),
        acceleration=w**2 * (y2 - 2.0 * y1 + y0),
        jerk=w**3 * (y3 - 3.0 * y2 + 3.0 * y1 - y0),
    )


Point = tuple[float, float]
"""A time [s] and the value at it."""


class Pauses(NamedTuple):
    """How long a trapezoid stays at its lower and at its upper end."""

    low: Time
    high: Time


def trapezoid(low: float, high: float, pauses: Pauses, ramp: float, periods: int) -> tuple[Point, ...]:
    """Corners of a course that pauses at `low`, rises to `high` in a straight line, pauses there, and falls back.

    ramp     time of the rise and of the fall [s]
    periods  how often; it stays at `low` afterwards

    Source  wang2017, eq. 4.16, corrected (docs/errata.md)
    """
    times = accumulate([0.0, *((pauses.low, ramp, pauses.high, ramp) * periods)])
    return tuple(zip(times, (low, *((low, high, high, low) * periods)), strict=True))
