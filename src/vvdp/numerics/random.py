"""Random numbers for sampled steps: the generator's state is a value that goes in and comes out.

Two multiplicative congruential generators whose difference is taken (L'Ecuyer). All products stay below 2^53, so
doubles hold them exactly, and the sequence is the same in plain and in compiled code and on every machine.
"""

from typing import NamedTuple

import numpy as np

FIRST_MODULUS, FIRST_FACTOR = 2147483563.0, 40014.0
SECOND_MODULUS, SECOND_FACTOR = 2147483399.0, 40692.0
SPREAD = 69621.0
"""Multiplier that keeps the states of neighbouring seeds apart."""


class Random(NamedTuple):
    """State of the generator; make it with `random_start`."""

    first: float
    second: float


def random_start(seed: float) -> Random:
    """The generator for a whole number `seed` >= 0; different seeds give sequences that do not resemble each other."""
    first = np.floor(seed) % (FIRST_MODULUS - 1.0) + 1.0
    second = (np.floor(seed) * SPREAD) % (SECOND_MODULUS - 1.0) + 1.0
    state = Random(first, second)
    for _ in range(20):
        state, _ = uniform(state)
    return state


def uniform(state: Random) -> tuple[Random, float]:
    """The next state, and a number evenly distributed between 0 and 1, ends excluded.

    Source  lecuyer1988, fig. 3
    """
    first = (FIRST_FACTOR * state.first) % FIRST_MODULUS
    second = (SECOND_FACTOR * state.second) % SECOND_MODULUS
    difference = (first - second) % (FIRST_MODULUS - 1.0)
    number = (difference + 0.5) / (FIRST_MODULUS - 1.0)
    return Random(first, second), number


def normal(state: Random) -> tuple[Random, float]:
    """The next state, and a number of the standard normal distribution (Box and Muller).

    Source  box1958
    """
    state, u = uniform(state)
    state, v = uniform(state)
    return state, np.sqrt(-2.0 * np.log(u)) * np.cos(2.0 * np.pi * v)
