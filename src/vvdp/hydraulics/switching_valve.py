"""Switching valve on a pulse train: one pressure port that a spool joins to a first or a second port.

Source  ours, docs/models/components.md, where a function names no other.
"""

from typing import NamedTuple

import numpy as np

from vvdp.base.display import value_text
from vvdp.base.kinds import LENGTH, Area, Fraction, Frequency, Kink, Length, Mode, Position, Ratio, Velocity
from vvdp.base.modes import side
from vvdp.base.params import Params
from vvdp.base.rules import refuse, require_positive
from vvdp.base.select import clip, minimum, select

STOP_DAMPING = 50.0
"""Rate at which an end stop takes the spool's speed, over the natural angular frequency: an impact without rebound."""


class SwitchingValve(Params):
    """Spool of second order between the positions 0 (second port open) and `stroke` (first port open).

    The areas grow in proportion from where the lands part to `full_area` at the end of the stroke. `lap` is how far
    the spool travels either way from its centre before a port opens; negative (underlap): both are open around it, at
    minus half the stroke each over the whole of it.
    """

    natural_frequency: Frequency
    damping_ratio: Ratio = 0.7
    stroke: Length
    lap: Position = 0.0
    full_area: Area

    def check(self) -> None:
        require_positive(self, "natural_frequency", "stroke")
        half = 0.5 * self.stroke
        if not -half <= self.lap < half:
            text = value_text(half, LENGTH)
            refuse(self, "lap", f"must lie between -{text} and {text} (half the stroke)")


class SpoolState(NamedTuple):
    """Position from the second port's end of the stroke, and velocity."""

    position: Position
    velocity: Velocity


class PortAreas(NamedTuple):
    """Areas from the pressure port to the first and to the second port."""

    first: Area
    second: Area


class SpoolEnds(NamedTuple):
    """Whether the ends of the stroke where the first and the second port are open hold the spool."""

    first: Mode
    second: Mode


class PortSides(NamedTuple):
    """Whether the ports are closed or open; `base.modes.side`."""

    first: Kink
    second: Kink


class PulseClock(Params):
    """Pulses begin at 0, 1/f, 2/f ..."""

    frequency: Frequency

    def check(self) -> None:
        require_positive(self, "frequency")


class PulseTrain(PulseClock):
    """Pulses of value 1 that begin at 0, 1/f, 2/f ... and last for the duty ratio of the period."""

    duty_ratio: Fraction


def spool_rate(
    command: float, spool: SpoolState, at_first: float, at_second: float, valve: SwitchingValve
) -> SpoolState:
    """Rates of position [m/s] and velocity [m/s^2] of a switching spool.

    x'' = omega^2 (u stroke - x) - 2 zeta omega x'. An end of the stroke holds the position and takes the outward
    velocity within 1/(50 omega), so that the spool does not rebound and leaves as soon as it is called back. An
    excess beyond an end, by rounding, does not pull it back.

    command              u: 0 to the second port, 1 to the first [1]
    spool                position and velocity
    at_first, at_second  1 while the end of the stroke where that port is open holds the spool, else 0
    """
    x, v = spool
    omega, zeta = 2.0 * np.pi * valve.natural_frequency, valve.damping_ratio
    held = at_first + at_second
    inside = clip(x, 0.0, valve.stroke)
    acceleration = omega**2 * (command * valve.stroke - inside) - 2.0 * zeta * omega * v
    return SpoolState((1.0 - held) * v, acceleration - held * STOP_DAMPING * omega * v)


def spool_frequency(switching_time: float, damping_ratio: float) -> float:
    """Natural frequency of a spool that is at its other end so long after a command at rest [Hz].

    x = 1 - exp(-zeta w t) (cos(v t) + zeta w/v sin(v t)) with v = w root(1 - zeta^2) is 1 first where tan(v t) is
    -v/(zeta w): w t = (pi - arccos zeta)/root(1 - zeta^2).

    switching_time  from the command to the end of the stroke [s]
    damping_ratio   zeta, between 0 and 1 [1]

    >>> print(round(spool_frequency(1e-3, 0.7), 1))
    522.9
    """
    root = np.sqrt(1.0 - damping_ratio * damping_ratio)
    frequency: float = (np.pi - np.arccos(damping_ratio)) / (2.0 * np.pi * switching_time * root)
    return frequency


def spool_ends(spool: SpoolState, at_first: float, at_second: float, valve: SwitchingValve) -> SpoolEnds:
    """Whether an end of the stroke holds a switching spool, from when it comes there until it leaves [1].

    spool, at_first, at_second  as in `spool_rate`
    """
    travel = spool.position / valve.stroke
    outward = spool.velocity / (2.0 * np.pi * valve.natural_frequency * valve.stroke)
    return SpoolEnds(
        side(select(at_first > 0.5, outward, minimum(outward, travel - 1.0))),
        side(select(at_second > 0.5, -outward, minimum(-outward, -travel))),
    )


def port_areas(position: float, valve: SwitchingValve) -> PortAreas:
    """Areas of the two ports [m^2]: A (±(x - c) - lap)/(c - lap) between 0 and A, with the centre c = stroke/2.

    position  x [m]
    """
    first, second = _travels(position, valve)
    return PortAreas(valve.full_area * clip(first, 0.0, 1.0), valve.full_area * clip(second, 0.0, 1.0))


def port_sides(position: float, valve: SwitchingValve) -> PortSides:
    """Whether the two ports are closed or open [1]; at the ends of the stroke, where one is fully open, the spool
    stops.

    position  x [m]
    """
    first, second = _travels(position, valve)
    return PortSides(side(first), side(second))


def _travels(position: float, valve: SwitchingValve) -> tuple[float, float]:
    """Travels from where each port begins to open, over those to where it is fully open."""
    centre = 0.5 * valve.stroke
    travel = centre - valve.lap
    return (position - centre - valve.lap) / travel, (centre - position - valve.lap) / travel


def pulse_train(t: float, train: PulseTrain) -> float:
    """Command of a pulse train [1]: 1 from k/f up to (k + d)/f, else 0; at an edge, the value after it.

    The edges are the floating-point numbers nearest to k/f and (k + d)/f, the same that `pulse_stop` gives.

    t  time [s]
    """
    return pulse_value(t, train.duty_ratio, train.frequency)


def pulse_stop(t: float, train: PulseTrain) -> float:
    """The next time [s] after `t` at which a pulse train rises or falls; infinity where it never does.

    t  time [s]
    """
    return pulse_edge(t, train.duty_ratio, train.frequency)


def pulse_value(t: float, duty_ratio: float, frequency: float) -> float:
    """Command [1] of pulses whose duty ratio is held between samples: 1 from k/f up to (k + d)/f, else 0.

    A duty ratio that changes within a period acts at once; one that is to count from the next period on has to wait
    where it is made.

    t           time [s]
    duty_ratio  d, held between 0 and 1 [1]
    frequency   f, greater than zero [Hz]
    """
    k = _cycle(t, frequency)
    value: float = select(t < (k + clip(duty_ratio, 0.0, 1.0)) / frequency, 1.0, 0.0)
    return value


def pulse_edge(t: float, duty_ratio: float, frequency: float) -> float:
    """The next edge [s] after `t` of pulses with a constant duty ratio; infinity at a duty ratio of 0 or 1.

    t           time [s]
    duty_ratio  d, held between 0 and 1 [1]
    frequency   f, greater than zero [Hz]
    """
    k, d = _cycle(t, frequency), clip(duty_ratio, 0.0, 1.0)
    fall = (k + d) / frequency
    edge: float = select(d * (1.0 - d) > 0.0, select(t < fall, fall, (k + 1.0) / frequency), np.inf)
    return edge


def pulse_periods(t: float, clock: PulseClock) -> float:
    """Periods of pulses since t = 0 [1]; its floor changes at k/f, as `pulse_edge` has it.

    t  time [s]
    """
    k = _cycle(t, clock.frequency)
    return k + clip(t * clock.frequency - k, 0.0, 0.9999999999)


def _cycle(t: float, f: float) -> float:
    """Number k of the cycle with k/f <= t < (k + 1)/f, where t f alone may round over an edge."""
    k = np.floor(t * f)
    k = select(t < k / f, k - 1.0, k)
    cycle: float = select(t >= (k + 1.0) / f, k + 1.0, k)
    return cycle
