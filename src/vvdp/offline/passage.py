"""The constant-speed Kalman filter from edge to edge, which the settings of a log are fitted with.

Derived in docs/logs.md.
"""

from typing import NamedTuple

from vvdp.numerics.kalman import AngleSpeed, predict, update

FAR = 4.0
"""Standard deviations beyond which an edge is an outlier."""


class Noise(NamedTuple):
    """What a log is explained by: q [rad^2/s^3] of the acceleration, and R_2 [rad^2] of an edge's angle."""

    acceleration_density: float
    edge_variance: float


class Passage(NamedTuple):
    """From one edge to the next: time [s], angle [rad], the variance of the angle from sampling alone [rad^2], and
    whether a piece begins here (1, else 0)."""

    duration: float
    angle: float
    sampling_variance: float
    first: float


class PassageMemory(NamedTuple):
    """The belief at the last edge, its angle counted from where that edge lies; `seen` edges of the piece, up to 2."""

    belief: AngleSpeed
    seen: float


class Surprise(NamedTuple):
    """By how much an edge differed from what was expected [rad], and the variance of that; 0 where nothing was."""

    innovation: float
    variance: float


def passage_start() -> PassageMemory:
    """Memory before the first edge."""
    return PassageMemory(AngleSpeed(0.0, 0.0, 1.0, 0.0, 0.0), 0.0)


def passage_step(memory: PassageMemory, passage: Passage, noise: Noise) -> tuple[PassageMemory, Surprise]:
    """The constant-speed Kalman filter over one more edge.

    Nothing is known before the first two edges of a piece: they settle the belief and say nothing of the noise,
    P11 = R, P12 = R/h, P22 = (R + R_before)/h^2 + q h/3.

    Source  ours, docs/logs.md
    """
    h, q = passage.duration, noise.acceleration_density
    R = passage.sampling_variance + noise.edge_variance
    if passage.first > 0.0 or memory.seen == 0.0:
        return PassageMemory(AngleSpeed(0.0, 0.0, R, 0.0, 0.0), 1.0), Surprise(0.0, 0.0)
    if memory.seen == 1.0:
        P22 = (R + memory.belief.angle_variance) / (h * h) + q * h / 3.0
        return PassageMemory(AngleSpeed(0.0, passage.angle / h, R, R / h, P22), 2.0), Surprise(0.0, 0.0)
    prior = predict(memory.belief, h, q)
    innovation = passage.angle - prior.angle
    b = update(prior, innovation, R)
    after = AngleSpeed(b.angle - passage.angle, b.speed, b.angle_variance, b.covariance, b.speed_variance)
    return PassageMemory(after, 2.0), Surprise(innovation, prior.angle_variance + R)


class Restart(NamedTuple):
    """Whether nothing before this edge shows where it should be (1, else 0)."""

    here: float


def restarting_step(memory: PassageMemory, passage: Passage, noise: Noise) -> tuple[PassageMemory, Restart]:
    """The same filter, which begins again at each edge that lies beyond `FAR` standard deviations: the speed changed
    at once there, or the edge is not the one it is taken for.

    Source  ours, docs/logs.md
    """
    after, told = passage_step(memory, passage, noise)
    if told.innovation * told.innovation > FAR * FAR * told.variance:
        first = Passage(passage.duration, passage.angle, passage.sampling_variance, 1.0)
        begun, _ = passage_step(memory, first, noise)
        return begun, Restart(1.0)
    return after, Restart(passage.first)
