"""Tracking errors of a cylinder, added up sample by sample inside the program that controls it.

Every sample counts, so the numbers do not depend on the recorded rows.

Source  ours, docs/models/displacement-chapter6.md
"""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Annotated, NamedTuple

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.kinds import (
    COUNT,
    EFFICIENCY,
    LENGTH,
    NUMBER,
    SIGNED_PRESSURE,
    Count,
    Fraction,
    Position,
    SignedFraction,
    Time,
)
from vvdp.control.pressure_modes import PressureMode
from vvdp.programs.report import Quantities

SETTLED = 1.0
"""Time after the start of control from which on errors count [s]."""

MODES = (1.0, 2.0, 2.5, 3.0, 3.5, 4.0, 4.5, 5.0, 5.5)
"""The pressure modes."""

WORDS = {
    1.0: "no bound near",
    2.0: "supply chamber below its lower bound",
    2.5: "supply chamber near its lower bound",
    3.0: "return chamber below its lower bound",
    3.5: "return chamber near its lower bound",
    4.0: "supply chamber above its upper bound",
    4.5: "supply chamber near its upper bound",
    5.0: "return chamber above its upper bound",
    5.5: "return chamber near its upper bound",
}


def share_key(mode: float) -> str:
    """The key of the share of the time in a mode."""
    return f"mode_{mode:g}_share".replace(".", "_")


TRACKING: Quantities = MappingProxyType(
    {
        "tracking_error_max_m": (LENGTH, "largest error against the filtered reference"),
        "tracking_error_rms_m": (LENGTH, "error against the filtered reference"),
        "tracking_error_first_second_m": (LENGTH, "largest error in the first second of control"),
        "directional_switches": (COUNT, "switches of the directional valve"),
        "return_opening_mean": (EFFICIENCY, "opening of the return valve, mean"),
        "saturated_share": (EFFICIENCY, "time with the return valve at an end"),
        "below_tank_share": (EFFICIENCY, "time with a chamber below tank pressure"),
        **{share_key(mode): (EFFICIENCY, f"time in mode {mode:g}: {WORDS[mode]}") for mode in MODES},
    }
)
"""Kind and label of the results of `tracking_numbers`."""

TOGETHER: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {
        f"time with {words}": tuple(share_key(m) for m in MODES if int(m) == mode)
        for mode, words in (
            (1, "no bound near"),
            (2, "the supply chamber low"),
            (3, "the return chamber low"),
            (4, "the supply chamber high"),
            (5, "the return chamber high"),
        )
    }
)
"""Keys of a mode and its transition, by what both are called together."""

Sum = Annotated[float, NUMBER]
SignedPressure = Annotated[float, SIGNED_PRESSURE]
Counts = Annotated[Array, NUMBER]


class Tracking(NamedTuple):
    """Sums over the samples since `SETTLED` after the `begin` of control, and the largest error before.

    `squares` of errors [m^2], `openings` of the return valve [1]; `modes` has a count for each of `MODES`.
    """

    begin: Time
    early_peak: Position
    peak: Position
    samples: Count
    squares: Sum
    direction: Sum
    switches: Count
    openings: Sum
    saturated: Count
    below_tank: Count
    modes: Counts


class Followed(NamedTuple):
    """Tracking of a sample under control: the true error, and the lower pressure of the two chambers minus that of the
    tank."""

    time: Time
    error: Position
    least_pressure: SignedPressure


class Actuated(NamedTuple):
    """Commands at a sample, as far as they are counted; see `DisplacementDemand`."""

    direction: SignedFraction
    opening: Fraction
    mode: PressureMode
    saturated: Fraction


def tracking_start() -> Tracking:
    """Nothing added up yet."""
    return Tracking(
        begin=np.inf,
        early_peak=0.0,
        peak=0.0,
        samples=0.0,
        squares=0.0,
        direction=0.0,
        switches=0.0,
        openings=0.0,
        saturated=0.0,
        below_tank=0.0,
        modes=np.zeros(len(MODES)),
    )


def tracking_step(memory: Tracking, followed: Followed, demand: Actuated) -> Tracking:
    """Add a sample under control.

    demand  what was commanded there
    """
    begin = min(memory.begin, followed.time)
    error = abs(followed.error)
    late = 1.0 if followed.time >= begin + SETTLED else 0.0
    modes = memory.modes.copy()
    modes[max(int(2.0 * demand.mode) - 3, 0)] += late
    is_switch = demand.direction != memory.direction and memory.direction != 0.0
    return Tracking(
        begin=begin,
        early_peak=max(memory.early_peak, (1.0 - late) * error),
        peak=max(memory.peak, late * error),
        samples=memory.samples + late,
        squares=memory.squares + late * error * error,
        direction=demand.direction,
        switches=memory.switches + (late if is_switch else 0.0),
        openings=memory.openings + late * demand.opening,
        saturated=memory.saturated + late * demand.saturated,
        below_tank=memory.below_tank + (late if followed.least_pressure < 0.0 else 0.0),
        modes=modes,
    )


def tracking_numbers(found: Tracking) -> dict[str, float]:
    """Numbers of the sums; empty before control, and only the first second where control was not longer.

    Switches, openings and shares are those of the time from which on errors count.
    """
    if found.begin == np.inf:
        return {}
    numbers = {"tracking_error_first_second_m": found.early_peak}
    if found.samples == 0.0:
        return numbers
    numbers |= {
        "tracking_error_max_m": found.peak,
        "tracking_error_rms_m": float(np.sqrt(found.squares / found.samples)),
        "directional_switches": found.switches,
        "return_opening_mean": found.openings / found.samples,
        "saturated_share": found.saturated / found.samples,
        "below_tank_share": found.below_tank / found.samples,
    }
    shares = found.modes / found.samples
    return numbers | {share_key(mode): float(share) for mode, share in zip(MODES, shares, strict=True)}
