"""The classes of the campaign: what moves, what is watched with, what goes wrong, each drawn from a seed."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from tests.campaign.generator import (
    Course,
    Disc,
    Passages,
    constant,
    course,
    dip,
    disc,
    jam,
    passages,
    ramp,
    rippled,
    step,
    stop,
    swing,
    wandering,
    with_faults,
)

UNTIL = 3.5
RATE = 1000.0
INDEX_SHIFT = 0.25
MOST_IN_A_SAMPLE = 0.6
"""Edges; faster ones are stamped, but for a class of their own."""
DENSITY = 0.25
"""White acceleration of every motion, that which the filter reckons with by default [rad^2/s^3]."""
EDGES_TO_KNOW = 4.0
"""Edges that must have come, or failed to come, before a sudden change can be known."""
JITTER = 0.075
"""Of an edge, in sectors: 0.059 rad at 8 sectors, the filter's default."""


class Case(NamedTuple):
    """A record with what is true, and what the filter is told of it."""

    name: str
    seed: int
    motion: Course
    wheel: Disc
    seen: Passages
    usual: float  # speed [rad/s]
    stamped: bool
    told: bool  # the polarity
    indexed: bool
    density: float  # of the acceleration [rad^2/s^3]
    edge_variance: float  # [rad^2]
    ripple_order: float
    ripple_variance: float
    crowded: bool  # with edges faster than samples
    sudden: tuple[tuple[float, float], ...]
    """From when to when nobody can know of a change yet [s]."""


class Draw(NamedTuple):
    """What a class changes of a record at a steady speed."""

    speed: Callable[[np.ndarray], np.ndarray]
    density: float = DENSITY
    ripple: float = 0.0
    missed: float = 0.0
    double: float = 0.0
    uneven: float = 0.0
    sudden: tuple[tuple[float, float], ...] = ()
    """When the speed begins to change, and when it has changed [s]."""
    sectors: int = 0
    """0: any."""
    sampled: bool = False


def steady(w: float, rng: np.random.Generator) -> Draw:
    return Draw(constant(w))


def slope(w: float, rng: np.random.Generator) -> Draw:
    return Draw(ramp(w, w * rng.uniform(0.5, 1.5), 1.3, 2.3))


def step_of_speed(w: float, rng: np.random.Generator) -> Draw:
    after, at = w * rng.choice([0.55, 0.8, 1.25, 1.9]), rng.uniform(1.2, 1.7)
    return Draw(step(w, after, at, 0.028), sudden=((at, at + 3.0 * 0.028),))


def stopped(w: float, rng: np.random.Generator) -> Draw:
    at = rng.uniform(1.2, 1.5)
    restart = at + rng.uniform(0.4, 1.2)
    return Draw(stop(w, at, 0.05, restart), sudden=((at, at + 0.05), (restart, restart + 0.05)))


def jammed(w: float, rng: np.random.Generator) -> Draw:
    at = rng.uniform(1.2, 2.7)
    return Draw(jam(w, at), sudden=((at, at),))


def reversed_(w: float, rng: np.random.Generator) -> Draw:
    begin, lasting = rng.uniform(1.2, 1.5), rng.uniform(0.1, 0.8)
    return Draw(ramp(w, -w, begin, begin + lasting), sudden=((begin, begin + lasting),))


def slow_passage(w: float, rng: np.random.Generator) -> Draw:
    return Draw(dip(w, w * rng.uniform(0.02, 0.2), 1.9, rng.uniform(0.4, 1.2)))


def ripple(w: float, rng: np.random.Generator) -> Draw:
    return Draw(constant(w), ripple=rng.uniform(0.01, 0.05))


def swinging(w: float, rng: np.random.Generator) -> Draw:
    """1 Hz by 5 %; its density is that with which errors are as large as stated, as a fit would find it."""
    amplitude = 0.05 * w
    return Draw(swing(w, amplitude, 1.0, rng.uniform(0.0, 6.28)), density=0.03 * (2.0 * np.pi * amplitude) ** 2)


def walking(w: float, rng: np.random.Generator) -> Draw:
    return Draw(constant(w), density=25.0)


def missed(w: float, rng: np.random.Generator) -> Draw:
    return Draw(constant(w), missed=rng.uniform(0.02, 0.45))


def double(w: float, rng: np.random.Generator) -> Draw:
    return Draw(constant(w), double=rng.uniform(0.02, 0.1))


def crowded(w: float, rng: np.random.Generator) -> Draw:
    """Several edges in a sample."""
    return Draw(constant(w), sectors=int(rng.choice([40, 50, 60])), sampled=True)


def uneven(w: float, rng: np.random.Generator) -> Draw:
    return Draw(constant(w), uneven=rng.uniform(0.05, 0.2))


CLASSES: dict[str, Callable[[float, np.random.Generator], Draw]] = {
    "steady": steady,
    "ramp": slope,
    "step": step_of_speed,
    "stop": stopped,
    "jam": jammed,
    "reversal": reversed_,
    "slow": slow_passage,
    "ripple": ripple,
    "swing": swinging,
    "walk": walking,
    "missed": missed,
    "double": double,
    "uneven": uneven,
    "crowded": crowded,
}


def shows_index(sectors: int, speed: float, interval: float) -> bool:
    """Whether the noise of edges, and the `interval` [s] in which they are known, leave the index to be seen."""
    pitch = 2.0 * np.pi / sectors
    return bool((INDEX_SHIFT * pitch / 3.0) ** 2 > (JITTER * pitch) ** 2 + (speed * interval) ** 2 / 12.0)


def case(name: str, seed: int) -> Case:
    """Record `seed` of a class."""
    rng = np.random.default_rng([*name.encode(), seed])
    w = rng.uniform(40.0, 180.0)
    drawn = CLASSES[name](w, rng)
    sectors = drawn.sectors or int(rng.choice([2, 4, 6, 8, 8, 8, 12, 16, 24, 40, 60]))
    pitch = 2.0 * np.pi / sectors
    stamped, told = rng.random(2) < 0.5
    is_crowded = sectors * w / (2.0 * np.pi * RATE) > MOST_IN_A_SAMPLE
    stamped = (stamped or is_crowded) and not drawn.sampled
    visible = shows_index(sectors, w, 0.0 if stamped else 1.0 / RATE)
    indexed = bool(sectors >= 4 and drawn.uneven == 0.0 and visible and rng.random() < 0.5)
    wheel = disc(sectors, INDEX_SHIFT if indexed else 0.0, drawn.uneven, rng)
    motion_of = drawn.speed
    density = drawn.density if name != "swing" else DENSITY
    motion = course(wandering(motion_of, density, w, rng), UNTIL, rng.uniform(0.0, 2.0 * np.pi))
    order = 0.0
    if drawn.ripple > 0.0:
        order = float(rng.integers(1, 9))
        motion = rippled(motion, drawn.ripple, order, rng.uniform(0.0, 2.0 * np.pi))
    seen = passages(motion, wheel, JITTER * pitch, rng)
    seen = with_faults(seen, drawn.missed, drawn.double, rng)
    return Case(
        name=name,
        seed=seed,
        motion=motion,
        wheel=wheel,
        seen=seen,
        usual=w,
        stamped=bool(stamped),
        told=bool(told),
        indexed=indexed,
        density=drawn.density,
        edge_variance=(JITTER * pitch) ** 2 + float(np.mean((wheel.made - wheel.meant) ** 2)),
        ripple_order=order,
        ripple_variance=0.5 * drawn.ripple**2,
        crowded=bool(is_crowded),
        sudden=tuple((begin, end + EDGES_TO_KNOW * pitch / w) for begin, end in drawn.sudden),
    )
