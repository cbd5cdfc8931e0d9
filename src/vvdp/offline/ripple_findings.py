"""What is said of a ripple of the speed that edges show, and of one that they could not show."""

from collections.abc import Iterator

import numpy as np

from vvdp.base.display import percent, with_unit
from vvdp.base.kinds import SPEED
from vvdp.offline.config import Estimation
from vvdp.offline.noise_fit import Explained, fitted_filter
from vvdp.offline.turn_pattern import SpeedRipple, is_whole
from vvdp.results.result import Finding, Grade

SURE = 3.0
"""Standard errors beyond which a ripple is told of."""


def ripple_words(ripple: SpeedRipple) -> str:
    """What a pattern of the edges is, as far as they tell."""
    return (
        f"a ripple of {percent(ripple.amplitude)} at {ripple.order} per turn, or a wheel with offsets of the same "
        "pattern: edges alone cannot tell"
    )


def ripple_numbers(told: Explained) -> tuple[float, float, float]:
    """Order, amplitude and standard error of the ripple found [1]; 0, NaN and NaN where there is none."""
    ripple = told.ripple
    return (0.0, np.nan, np.nan) if ripple is None else (float(ripple.order), ripple.amplitude, ripple.error)


def ripple_findings(told: Explained, wanted: Estimation) -> Iterator[Finding]:
    """That the filter leaves a ripple out, or that the wheel has too few edges to tell."""
    ripple, edges = told.ripple, told.likelihood.sectors
    sure = ripple is not None and ripple.amplitude > SURE * ripple.error
    if ripple is not None and sure and wanted.filter.ripple_order != ripple.order:
        fitted, swing = fitted_filter(wanted.filter, told), ripple.amplitude * told.likelihood.speed
        yield Finding(
            title="A ripple of the speed, or an uneven wheel",
            text=f"{ripple_words(ripple).capitalize()}. The filter is told of neither: its speed is the mean over a "
            f"ripple, and so is the deviation that it states; the spool's own goes {with_unit(swing, SPEED, 3)} up and "
            "down.",
            remedy=f"Use --fit, which takes it for a ripple, or in the config [filter] ripple_order = {ripple.order}, "
            f"ripple_variance = {fitted.ripple_variance:.3g} and "
            f'ripple_drift = "{fitted.ripple_drift:.3g} 1/s"; if it is the wheel, its widths.',
            grade=Grade.WARNING,
        )
    if told.wheel is not None and ripple is None and not is_whole(wanted.sections, edges):
        yield Finding(
            title="A ripple cannot be seen whole",
            text="What repeats with every turn is taken for the wheel's. It may be a ripple as well: at "
            f"{wanted.sections} per turn it takes more than {2 * wanted.sections} edges in a turn to see it whole, and "
            f"the wheel has {edges}.",
            remedy="Take the speed for its mean over a ripple, or a wheel with more sectors.",
            grade=Grade.WARNING,
        )
