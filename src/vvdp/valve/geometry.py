"""Openings of the nozzles to the load and the tank pockets of the spool, from its angle and its axial position.

Derived in docs/models/rotary-valve.md, "Port openings".

Source  ours, docs/models/rotary-valve.md, where a function names no other.
"""

from typing import NamedTuple

import numpy as np

from vvdp.base.kinds import Count, Fraction, Kink, Length, SignedFraction
from vvdp.base.modes import side
from vvdp.base.select import clip, minimum, select
from vvdp.valve.rotary import RotaryValve


class Openings(NamedTuple):
    """Open fraction of the nozzle area towards the load and towards the tank."""

    load: Fraction
    tank: Fraction


class PortShape(NamedTuple):
    """All that the openings depend on besides the spool's angle and position; widths in pitches."""

    sections: Count
    helix_length: Length
    nozzle_width: Fraction
    barrier_width: Fraction


def port_shape(valve: RotaryValve) -> PortShape:
    """The shape of the ports, for many calls of `shape_openings`."""
    ramp = nozzle_width(valve) / pitch(valve)
    return PortShape(valve.sections, valve.helix_length, ramp, valve.lap_ratio * ramp)


def pitch(valve: RotaryValve) -> float:
    """Arc of one section on the spool surface [m]: 2 pi R / N."""
    return 2.0 * np.pi * valve.spool_radius / valve.sections


def helix_slope(valve: RotaryValve) -> float:
    """Axial rise of a barrier over its circumferential run, tan(alpha) = 2 L / pitch [1]."""
    return 2.0 * valve.helix_length / pitch(valve)


def nozzle_width(valve: RotaryValve) -> float:
    """Circumferential diagonal of one rhombic nozzle, d_c = sqrt(2 A_1 / tan(alpha)) with A_1 = A_in / N [m]."""
    width: float = np.sqrt(2.0 * valve.nozzle_area / (valve.sections * helix_slope(valve)))
    return width


def nozzle_length(valve: RotaryValve) -> float:
    """Axial diagonal of one rhombic nozzle, d_a = d_c tan(alpha) [m]."""
    return nozzle_width(valve) * helix_slope(valve)


def nozzle_hydraulic_diameter(valve: RotaryValve) -> float:
    """Four times the area of one nozzle over its perimeter [m]."""
    side: float = 0.5 * np.sqrt(nozzle_width(valve) ** 2.0 + nozzle_length(valve) ** 2.0)
    return valve.nozzle_area / valve.sections / side


def barrier_width(valve: RotaryValve) -> float:
    """Circumferential width of a barrier, lap ratio times nozzle width [m]."""
    return valve.lap_ratio * nozzle_width(valve)


def transition_fraction(valve: RotaryValve) -> float:
    """Part of a PWM period that one transition takes, kappa = (d_c + b) / pitch [1].

    Source  ours, docs/models/rotary-valve.md; tu2012 gives 2.8 ms at 100 Hz
    """
    return (nozzle_width(valve) + barrier_width(valve)) / pitch(valve)


def wedge_opening(distance: float, half_width: float, ramp: float) -> float:
    """Fraction of a nozzle that lies inside any of a row of wedges, one per pitch [1].

    a = u d + n (1 - d), each factor the fraction of the nozzle past one edge: u and d the near wedge's own edges,
    n the first edge of the next wedge; exact while the nozzle is narrower than the pitch.

    distance    of the nozzle's centre from the middle of the nearest wedge, 0 to 1/2 [pitches]
    half_width  of a wedge at the height of the nozzle's centre, may be negative [pitches]
    ramp        nozzle width [pitches]
    """
    u, d, n = passed_edges(distance, half_width, ramp)
    return u * d + n * (1.0 - d)


class PassedEdges(NamedTuple):
    """Fractions of a nozzle past the near wedge's first edge, before its second, and past the next wedge's first."""

    entered: Fraction
    remaining: Fraction
    following: Fraction


def passed_edges(distance: float, half_width: float, ramp: float) -> PassedEdges:
    """The three fractions that decide how far a nozzle looks into a row of wedges [1].

    distance    of the nozzle's centre from the middle of the nearest wedge, 0 to 1/2 [pitches]
    half_width  of a wedge at the height of the nozzle's centre, may be negative [pitches]
    ramp        nozzle width [pitches]
    """
    slope = 1.0 / ramp  # one division, which both ports share in compiled code
    return PassedEdges(
        entered=clip(0.5 + slope * (half_width + distance), 0.0, 1.0),
        remaining=clip(0.5 + slope * (half_width - distance), 0.0, 1.0),
        following=clip(0.5 + slope * (half_width + distance - 1.0), 0.0, 1.0),
    )


class JetSkews(NamedTuple):
    """Excess of a jet's effect over its opening, load and tank, because the barrier covers its nozzle from one side
    more than from the other."""

    load: SignedFraction
    tank: SignedFraction


EVEN = JetSkews(0.0, 0.0)
"""Jets that do not mind from which side their nozzles are covered; also the mean over a whole period."""


def jet_skews(spool_angle: float, axial_position: float, asymmetry: float, shape: PortShape) -> JetSkews:
    """Contribution of the asymmetry of the jets to the openings [1]; an odd function about the middle of each wedge.

    eps_j a (1 - a) while the load's barrier closes over the nozzle, - eps_j a (1 - a) while it opens, nothing where it
    covers both sides alike.

    spool_angle     any number of turns [rad]
    axial_position  any value [m]
    asymmetry       eps_j, 0 to 1 [1]
    """
    return uneven_skews(spool_angle, axial_position, asymmetry, shape)


def jet_skews_compiled(spool_angle: float, axial_position: float, asymmetry: float, shape: PortShape) -> JetSkews:
    """The same as `jet_skews`, which it replaces in compiled code: without asymmetry it costs nothing.

    spool_angle     any number of turns [rad]
    axial_position  any value [m]
    asymmetry       eps_j, 0 to 1 [1]
    """
    if asymmetry == 0.0:
        return JetSkews(0.0, 0.0)
    return uneven_skews(spool_angle, axial_position, asymmetry, shape)


def uneven_skews(spool_angle: float, axial_position: float, asymmetry: float, shape: PortShape) -> JetSkews:
    """The law of `jet_skews` [1].

    spool_angle     any number of turns [rad]
    axial_position  any value [m]
    asymmetry       eps_j, 0 to 1 [1]
    """
    turn = shape.sections * spool_angle / (2.0 * np.pi)
    offset = turn - np.floor(turn + 0.5)
    half_duty, half_barrier = 0.5 * axial_position / shape.helix_length, 0.5 * shape.barrier_width
    closing = asymmetry * select(offset < 0.0, -1.0, 1.0)
    load = wedge_skew(abs(offset), half_duty - half_barrier, shape.nozzle_width)
    tank = wedge_skew(abs(offset), half_duty + half_barrier, shape.nozzle_width)
    return JetSkews(closing * load, -closing * tank)


def wedge_skew(distance: float, half_width: float, ramp: float) -> float:
    """Opening towards a row of wedges, or of the space between them, times the unevenness with which its two sides
    cover a nozzle [1].

    S = (u - d)(u d - n)(1 - n), with u, d and n as in `wedge_opening`: a (1 - a) where one edge lies over the nozzle,
    0 where two cover it alike, and never more than the opening a, nor than 1 - a.

    distance    of the nozzle's centre from the middle of the nearest wedge, 0 to 1/2 [pitches]
    half_width  of a wedge at the height of the nozzle's centre, may be negative [pitches]
    ramp        nozzle width [pitches]
    """
    u, d, n = passed_edges(distance, half_width, ramp)
    return (u - d) * (u * d - n) * (1.0 - n)


class PortEdges(NamedTuple):
    """Sides of the kinks of the port openings; `base.modes.side`."""

    load_near: Kink
    load_far: Kink
    tank_near: Kink
    tank_far: Kink


def port_openings(spool_angle: float, axial_position: float, valve: RotaryValve) -> Openings:
    """Open fractions of the nozzles towards load and tank [1].

    The load pocket is a wedge whose apex line passes the nozzle at angle 0, 2 pi/N, ...; at axial position x it is
    x/L of the pitch wide between the centre lines of its barriers.

    spool_angle     any number of turns [rad]
    axial_position  0 is duty ratio 0, helix_length is duty ratio 1; any value [m]
    """
    return shape_openings(spool_angle, axial_position, port_shape(valve))


def shape_openings(spool_angle: float, axial_position: float, shape: PortShape) -> Openings:
    """Open fractions of the nozzles towards load and tank [1]; see `port_openings`.

    spool_angle     any number of turns [rad]
    axial_position  any value [m]
    """
    turn = shape.sections * spool_angle / (2.0 * np.pi)
    distance = abs(turn - np.floor(turn + 0.5))
    ramp = shape.nozzle_width
    half_duty = 0.5 * axial_position / shape.helix_length
    half_barrier = 0.5 * shape.barrier_width
    load = wedge_opening(distance, half_duty - half_barrier, ramp)
    tank = 1.0 - wedge_opening(distance, half_duty + half_barrier, ramp)
    return Openings(load, tank)


def port_edges(spool_angle: float, axial_position: float, shape: PortShape) -> PortEdges:
    """Sides of the angles at which a port begins or ends to be open or closed, on which the spool stands [1].

    The openings have kinks where |2 |w| -/+ d_c|/2 pitches lie between the nozzle's centre and the middle of the
    nearest wedge, w half the width of the load's wedge or of the load's with both barriers, d_c the nozzle's width.

    spool_angle     any number of turns [rad]
    axial_position  any value [m]
    """
    turn = shape.sections * spool_angle / (2.0 * np.pi)
    distance = abs(turn - np.floor(turn + 0.5))
    half_duty = 0.5 * axial_position / shape.helix_length
    load, tank = abs(half_duty - 0.5 * shape.barrier_width), abs(half_duty + 0.5 * shape.barrier_width)
    half_nozzle = 0.5 * shape.nozzle_width
    return PortEdges(
        load_near=side(distance - _fold(load - half_nozzle)),
        load_far=side(distance - _fold(load + half_nozzle)),
        tank_near=side(distance - _fold(tank - half_nozzle)),
        tank_far=side(distance - _fold(tank + half_nozzle)),
    )


def _fold(distance: float) -> float:
    """A distance from the middle of a wedge as one from that of the nearest [pitches]."""
    inner = abs(distance)
    return minimum(inner, 1.0 - inner)
