"""Spool of a proportional valve: first or second order, with rate limit, hysteresis and flow forces.

Source  ours, docs/models/components.md, where a function names no other.
"""

from typing import Annotated, NamedTuple

import numpy as np

from vvdp.base.kinds import Compliance, Fraction, Frequency, Kind, Rate, Ratio, Time
from vvdp.base.modes import between
from vvdp.base.params import Params
from vvdp.base.rules import refuse, require_positive
from vvdp.base.select import clip, select

SIGNED_RATE = Kind("signed rate", "1/s", -1e6, 1e6, "150 1/s", units=("1/s",))
SPOOL_POSITION = Kind("spool position", "1", -2.0, 2.0, "0.5", scale=1e-2)
"""Beyond 1 as far as a spool overshoots."""
SpoolPosition = Annotated[float, SPOOL_POSITION]
SignedRate = Annotated[float, SIGNED_RATE]


class ProportionalSpool(Params):
    """The position, -1 to 1, follows its command, never faster than `largest_rate` strokes per second.

    It is a system of second order, of `natural_frequency` and `damping_ratio`; with a natural frequency of 0 one of
    first order, of `response_time`. Of two commands that lead to one position, the rising is `hysteresis` above the
    falling one. Flow forces push it back by `flow_yield` times the opening of each edge times its drop.
    """

    natural_frequency: Frequency
    damping_ratio: Ratio = 0.7
    response_time: Time = 0.0
    largest_rate: Rate
    hysteresis: Fraction = 0.0
    flow_yield: Compliance = 0.0

    def check(self) -> None:
        require_positive(self, "damping_ratio", "largest_rate")
        if (self.natural_frequency > 0.0) == (self.response_time > 0.0):
            rule = "must be greater than 0, or else 0 with a response_time (first order)"
            refuse(self, "natural_frequency", rule)


class ValveSpool(NamedTuple):
    """Position of a spool, 1 forward and -1 backward, and the rate that its drive demands, in strokes per second."""

    position: SpoolPosition
    wanted_rate: SignedRate


def spool_error(command: float, position: float, pushed_back: float, valve: ProportionalSpool) -> float:
    """Error that moves a spool [1]: e = u - x - x_f, minus half the hysteresis; 0 as long as |e| stays below that.

    command      u, held between -1 and 1 [1]
    position     x [1]
    pushed_back  x_f, by which flow forces push the spool back [1]

    >>> valve = ProportionalSpool(natural_frequency=0.0, response_time=0.02, largest_rate=1e4, hysteresis=0.04)
    >>> print([round(spool_error(u, 0.5, 0.0, valve), 3) for u in (0.47, 0.51, 0.55)])
    [-0.01, 0.0, 0.03]
    """
    error = clip(command, -1.0, 1.0) - position - pushed_back
    half = 0.5 * valve.hysteresis
    moving: float = error - clip(error, -half, half)
    return moving


def error_side(command: float, position: float, pushed_back: float, valve: ProportionalSpool) -> float:
    """Whether a command moves a spool, either way, or lies within its hysteresis [1]; see `base.modes.between`.

    command, position, pushed_back  as in `spool_error`
    """
    error = clip(command, -1.0, 1.0) - position - pushed_back
    width = valve.hysteresis
    return between(select(width > 0.0, 0.5 + error / select(width > 0.0, width, 1.0), 0.5))


def spool_motion(moving: float, spool: ValveSpool, valve: ProportionalSpool) -> ValveSpool:
    """Rates of a spool's position [1/s] and of the rate that its drive demands [1/s^2].

    x' = clip(v, +-r), v' = omega^2 e - 2 zeta omega v: below the largest rate r a second-order system; at it v is held
    there, and does not wind up. Of first order: x' = clip(e/T, +-r).

    moving  e, as `spool_error` gives it [1]
    """
    T, r = valve.response_time, valve.largest_rate
    first = T > 0.0
    omega, zeta = 2.0 * np.pi * valve.natural_frequency, valve.damping_ratio
    v = clip(spool.wanted_rate, -r, r)
    acceleration = omega * omega * moving - 2.0 * zeta * omega * v
    beyond = spool.wanted_rate - v
    rate = select(first, clip(moving / select(first, T, 1.0), -r, r), v)
    return ValveSpool(rate, acceleration - omega * beyond)


def rate_side(moving: float, spool: ValveSpool, valve: ProportionalSpool) -> float:
    """Whether a spool moves at its largest rate, either way, or below it [1]; see `base.modes.between`.

    moving  as in `spool_motion`
    """
    T = valve.response_time
    wanted = select(T > 0.0, moving / select(T > 0.0, T, 1.0), spool.wanted_rate)
    return between(0.5 + 0.5 * wanted / valve.largest_rate)
