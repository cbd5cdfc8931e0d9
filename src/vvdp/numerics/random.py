"""Random numbers for sampled steps: the generator's state is a value that goes in and comes out.

Two multiplicative congruential generators whose difference is taken (L'Ecuyer). All products stay below 2^53, so
doubles hold them exactly, and the sequence is the same in plain and in compiled code and on every machine.
"""

from typing import NamedTuple

import numpy as np

from vvdp.base.kinds import Number

FIRST_MODULUS, FIRST_FACTOR = 2147483563.0, 40014.0
SECOND_MODULUS, SECOND_FACTOR = 2147483399.0, 40692.0
STIRRING_MODULUS, STIRRINGS = 67108859.0, 8
"""A prime whose square stays below 2^52, and how often a seed is squared into the state."""


class Random(NamedTuple):
    """State of the generator; make it with `random_start`."""

    first: Number
    second: Number


def random_start(seed: float) -> Random:
    """The generator for a whole number `seed` from 0 to 2^53; other seeds give sequences that do not resemble it.

    Both generators are linear: states that differ by d give sequences that differ by the same numbers whatever the
    state, and over seeds 0, 1, 2, ... every draw would run through a lattice. Squares in between undo that.

    Source  ours, docs/models/encoder.md
    """
    whole = np.floor(seed)
    first = whole % (FIRST_MODULUS - 1.0) + 1.0
    second = np.floor(whole / (FIRST_MODULUS - 1.0)) % (SECOND_MODULUS - 1.0) + 1.0
    state = Random(first, second)
    for _ in range(STIRRINGS):
        state, _ = uniform(_next_state(state))
    return state


def _next_state(state: Random) -> Random:
    a, b = state.first % STIRRING_MODULUS, state.second % STIRRING_MODULUS
    first = (a * a + state.second) % (FIRST_MODULUS - 1.0) + 1.0
    second = (b * b + first) % (SECOND_MODULUS - 1.0) + 1.0
    return Random(first, second)


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
