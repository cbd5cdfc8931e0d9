"""How good the estimate of a watched spool is."""

from collections.abc import Mapping

import numpy as np

from vvdp.base.arrays import Array

SETTLED = 0.5
"""From this time of a run on the errors of the estimate are counted [s]: the filter has found speed and index."""


def estimate_errors(estimate: Mapping[str, Array], sampled: Mapping[str, Array]) -> tuple[Array, Array]:
    """Errors of the estimate of the last sample: of the angle, within half a turn [rad], and of the speed [rad/s].

    The wheel cannot tell which way it turns: they are against the angle turned through and the magnitude of the speed.

    estimate  columns of `Estimate` over the recorded rows
    sampled   the spool's `angle` [rad] and `speed` [rad/s] at the last sample, over the same rows
    """
    angle = sampled["angle"]
    turned = angle[0] + np.concatenate([[0.0], np.cumsum(np.abs(np.diff(angle)))])
    error = estimate["angle"] - turned
    return np.pi - np.mod(np.pi - error, 2.0 * np.pi), estimate["speed"] - np.abs(sampled["speed"])
