"""How far the numbers of a run still move with its tolerance, which no balance sees: it holds along any path."""

from collections.abc import Mapping
from typing import NamedTuple

from vvdp.systems.extras import Summary

FINER = 0.1
"""Tolerance of the second run of a check, over that of the first."""
SMALL = 1e-3
"""Share of the largest value of its unit below which a value is judged as if it had that size."""
OF_THE_RUN = frozenset(
    (
        *("duration_s", "averaged_from_s", "averaged_to_s", "averaged_periods", "wall_time_s"),
        "real_time_factor",
        *("steps", "rejected_steps", "evaluations", "energy_residual", "mass_residual"),
    )
)
"""Keys that say how a run was done, not what came of it."""

COARSE = ("cavitation_port_share", "_cavitation_share", "wave_roughness_")
"""What is in keys of shares of the time in which something holds, which jump, and of differences between neighbours:
they are known to about a hundredth of themselves."""


class Move(NamedTuple):
    """How a value of a summary changes with the tolerance, over the value."""

    key: str
    value: float
    change: float


def is_coarse(key: str) -> bool:
    """Whether a number is known to about a hundredth of itself."""
    return any(word in key for word in COARSE)


def moves(found: Summary, finer: Summary, units: Mapping[str, str]) -> tuple[Move, ...]:
    """The changes of all numbers from one summary to that of a finer run, the largest first.

    A change is over the value itself or, where that is smaller, over 1/1000 of the largest value of the same unit;
    `units` are those of the keys.
    """
    values = {
        key: float(value)
        for key, value in finer.items()
        if not isinstance(value, bool) and key in found and key not in OF_THE_RUN and not is_coarse(key)
    }
    largest: dict[str, float] = {}
    for key, value in values.items():
        unit = units.get(key, key)
        largest[unit] = max(largest.get(unit, 0.0), abs(value))
    changes = []
    for key, value in values.items():
        size = max(abs(value), SMALL * largest[units.get(key, key)])
        changes.append(Move(key, value, abs(float(found[key]) - value) / size if size > 0.0 else 0.0))
    return tuple(sorted(changes, key=lambda move: -move.change))
