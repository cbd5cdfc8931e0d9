"""How well a drive is controlled, run by run, and what many runs come to."""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from vvdp.base.arrays import Array
from vvdp.comparison.figures import Measured, mean, quantile, root_mean
from vvdp.machines.drive_tally import Tally

LOST = 2.5e-3
"""An error against the reference [m] beyond which the drive is out of control: half of what it is moved by."""


class LoopScore(NamedTuple):
    """Score of one run of one controller; NaN, and failed, where it broke off or was never controlled.

    Tracking is position minus reference, estimation the estimate minus the position; command and change are those of
    the valve, the change from sample to sample. `storage_rises` counts samples.
    """

    tracking_mean_square: float  # [m^2]
    tracking_worst: float  # [m]
    estimate_mean_square: float  # [m^2]
    effort_mean_square: float  # [1]
    change_mean_square: float  # [1]
    storage_rises: float
    failed: float


def loop_score(tally: Tally, ended: bool) -> LoopScore:
    """The score of a run.

    tally  what was added up
    ended  whether the run came to its end
    """
    if not ended or tally.samples == 0.0:
        return LoopScore(**{**dict.fromkeys(LoopScore._fields, np.nan), "failed": 1.0})
    n = tally.samples
    return LoopScore(
        tracking_mean_square=tally.tracking / n,
        tracking_worst=tally.peak,
        estimate_mean_square=tally.estimation / n,
        effort_mean_square=tally.command / n,
        change_mean_square=tally.change / n,
        storage_rises=tally.rises,
        failed=1.0 if tally.peak > LOST else 0.0,
    )


def loop_summary(scores: Array) -> dict[str, Measured]:
    """Summary of the rows of `scores`, shape (runs, fields of LoopScore); keys end in the unit.

    Runs that broke off count as failed, and in nothing else; without any other all else is NaN.
    """
    column: Mapping[str, Array] = dict(zip(LoopScore._fields, scores.T, strict=True))
    failed = mean(column["failed"])
    if np.isfinite(column["tracking_mean_square"]).any():
        kept = np.isfinite(column["tracking_mean_square"])
        column = {name: values[kept] for name, values in column.items()}
    runs = np.sqrt(column["tracking_mean_square"])
    return {
        "tracking_error_rms_m": root_mean(column["tracking_mean_square"]),
        "tracking_error_rms_low_m": quantile(runs, 0.05),
        "tracking_error_rms_high_m": quantile(runs, 0.95),
        "tracking_error_worst_m": Measured(float(np.max(column["tracking_worst"]))),
        "estimate_error_rms_m": root_mean(column["estimate_mean_square"]),
        "effort_rms": root_mean(column["effort_mean_square"]),
        "effort_change_rms": root_mean(column["change_mean_square"]),
        "storage_rises": mean(column["storage_rises"]),
        "failed": failed,
    }
