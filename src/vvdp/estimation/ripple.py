"""The ripple of the speed that the ports of a rotary valve make: locked to the angle, so many periods a turn.

The spool turns by theta = phi + (a sin N theta - b cos N theta)/N, where phi walks as the event filter has it. An edge
is seen where it lies, so that a ripple looks like edges out of place. Derived in docs/models/event-filter.md, "Ripple".

Source  ours, docs/models/event-filter.md, where a function names no other.
"""

from typing import NamedTuple

import numpy as np

from vvdp.base.kinds import Number, Ratio
from vvdp.numerics.kalman import AngleSpeed


class Ripple(NamedTuple):
    """Belief about the cosine part a and the sine part b of the speed's ripple, each over the mean speed.

    Their covariance, and that with the mean angle [rad] and the mean speed [rad/s].
    """

    cosine: Number
    sine: Number
    cosine_variance: Ratio
    cross: Number
    sine_variance: Ratio
    angle_cosine: Number
    angle_sine: Number
    speed_cosine: Number
    speed_sine: Number


class Place(NamedTuple):
    """An edge of the wheel in the phase of the ripple: the angle by which one unit of a, and of b, moves it [rad]."""

    cosine: Number
    sine: Number


def ripple_start(variance: float) -> Ripple:
    """The ripple before the first edge, of either sign; `variance` of a and of b [1]."""
    return Ripple(
        cosine=0.0,
        sine=0.0,
        cosine_variance=variance,
        cross=0.0,
        sine_variance=variance,
        angle_cosine=0.0,
        angle_sine=0.0,
        speed_cosine=0.0,
        speed_sine=0.0,
    )


def predict_ripple(ripple: Ripple, duration: float, drift: float) -> Ripple:
    """The belief after `duration` [s]; the angle moves with the speed, and a and b drift with the density [1/s]."""
    r, h = ripple, duration
    return r._replace(
        cosine_variance=r.cosine_variance + drift * h,
        sine_variance=r.sine_variance + drift * h,
        angle_cosine=r.angle_cosine + h * r.speed_cosine,
        angle_sine=r.angle_sine + h * r.speed_sine,
    )


def without_covariance(ripple: Ripple) -> Ripple:
    """The ripple beside a belief about the course that begins again."""
    r = ripple
    return r._replace(angle_cosine=0.0, angle_sine=0.0, speed_cosine=0.0, speed_sine=0.0)


def place_of(angle: float, order: float) -> Place:
    """Place of an angle [rad] in a ripple of `order` periods per revolution: (sin N theta, -cos N theta)/N."""
    return Place(np.sin(order * angle) / order, -np.cos(order * angle) / order)


def place_beside(place: Place, angle: float, order: float) -> Place:
    """The place an `angle` [rad] further on that is small beside a period: to the third order, without a sine."""
    turn = order * angle
    less, more = 1.0 - 0.5 * turn * turn, turn - turn * turn * turn / 6.0
    return Place(less * place.cosine - more * place.sine, less * place.sine + more * place.cosine)


def displacement(ripple: Ripple, place: Place) -> float:
    """Displacement of the spool from its mean course by the ripple [rad]."""
    return ripple.cosine * place.cosine + ripple.sine * place.sine


def with_displacement(belief: AngleSpeed, ripple: Ripple, place: Place) -> tuple[float, float, float, float]:
    """Covariances P H of mean angle, mean speed, a and b with the mean angle and the displacement at a place.

    H = (1, 0, sin N theta/N, -cos N theta/N); [rad^2, rad^2/s, rad, rad]
    """
    b, r, s, c = belief, ripple, place.cosine, place.sine
    return (
        b.angle_variance + s * r.angle_cosine + c * r.angle_sine,
        b.covariance + s * r.speed_cosine + c * r.speed_sine,
        r.angle_cosine + s * r.cosine_variance + c * r.cross,
        r.angle_sine + s * r.cross + c * r.sine_variance,
    )


def seen_variance(belief: AngleSpeed, ripple: Ripple, place: Place) -> float:
    """Variance of the angle, ripple included [rad^2]: H' P H."""
    g1, _, g3, g4 = with_displacement(belief, ripple, place)
    return g1 + place.cosine * g3 + place.sine * g4


def update_with_ripple(
    belief: AngleSpeed, ripple: Ripple, place: Place, innovation: float, measurement_variance: float
) -> tuple[AngleSpeed, Ripple]:
    """Belief and ripple after an edge at `place` that differs from where it was expected by `innovation` [rad].

    measurement_variance  R [rad^2]
    """
    b, r, s, c = belief, ripple, place.cosine, place.sine
    g1, g2, g3, g4 = with_displacement(b, r, place)
    S = g1 + s * g3 + c * g4 + measurement_variance
    nu = innovation / S
    after = AngleSpeed(
        b.angle + g1 * nu,
        b.speed + g2 * nu,
        b.angle_variance - g1 * g1 / S,
        b.covariance - g1 * g2 / S,
        b.speed_variance - g2 * g2 / S,
    )
    learnt = Ripple(
        cosine=r.cosine + g3 * nu,
        sine=r.sine + g4 * nu,
        cosine_variance=r.cosine_variance - g3 * g3 / S,
        cross=r.cross - g3 * g4 / S,
        sine_variance=r.sine_variance - g4 * g4 / S,
        angle_cosine=r.angle_cosine - g1 * g3 / S,
        angle_sine=r.angle_sine - g1 * g4 / S,
        speed_cosine=r.speed_cosine - g2 * g3 / S,
        speed_sine=r.speed_sine - g2 * g4 / S,
    )
    return after, learnt


def of_the_instant(belief: AngleSpeed, ripple: Ripple, order: float) -> AngleSpeed:
    """Angle and speed with the ripple in them: theta = phi + delta(theta), omega/(1 - delta'(theta)).

    Theta by two steps from phi, with an error of the third order in the ripple; the covariance by the gradients
    of both with respect to the mean angle, the mean speed, a and b.
    """
    b, r, N = belief, ripple, order
    place = place_of(b.angle, N)
    place = place_beside(place, displacement(r, place), N)
    s, c = place.cosine, place.sine
    along, across = -N * c, N * s  # cos N theta, sin N theta
    g = 1.0 / (1.0 - r.cosine * along - r.sine * across)
    speed = g * b.speed
    # Covariances with phi + delta at this place, of which the angle has g times.
    u1, u2, u3, u4 = with_displacement(b, r, place)
    own = u1 + s * u3 + c * u4
    bend = speed * g * g * N * (r.sine * along - r.cosine * across)
    p, q = speed * g * along, speed * g * across
    mixed = g * u2 + p * u3 + q * u4
    steady = g * b.speed_variance + 2.0 * (p * r.speed_cosine + q * r.speed_sine)
    shape = p * p * r.cosine_variance + 2.0 * p * q * r.cross + q * q * r.sine_variance
    return AngleSpeed(
        b.angle + displacement(r, place),
        speed,
        g * g * own,
        g * (bend * own + mixed),
        bend * (bend * own + 2.0 * mixed) + g * steady + shape,
    )
