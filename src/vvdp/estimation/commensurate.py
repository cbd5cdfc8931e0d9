"""Whether edges are commensurate with the sampling, so that part of the angle's error hides from every estimator.

Edges that are only sampled fall at a place within the sampling period that cannot be seen. When p edges take exactly q
samples, only p different places occur, indefinitely, and their mean error does not die out. Derived in
docs/models/simple-estimators.md, "Edges in step with the samples".

Source  ours, docs/models/simple-estimators.md, where a function names no other.
"""

from typing import NamedTuple

import numpy as np

from vvdp.base.display import value_text
from vvdp.base.errors import ParameterError
from vvdp.base.kinds import FREQUENCY, TIME
from vvdp.base.rules import POSITIVE, require_positive_value


class Commensurate(NamedTuple):
    """`edges` edges take very nearly `samples` samples, in lowest terms; rates in 1/s."""

    edges: int
    samples: int
    edge_rate: float
    sample_rate: float


def commensurate_clock(
    edge_rate: float, sample_rate: float, tolerance: float = 1e-3, memory: float = 0.2, largest: int = 11
) -> Commensurate | None:
    """The fraction p/q, q <= `largest`, of the sampling rate that the edge rate is, or None where it is none.

    None also where the edge rate is 0, or the sampling rate or more: edges are lost, and nothing can be said.
    Edges that a capture unit stamps are free of all this. The usual values suit the event filter as published.

    edge_rate    edges a second of the whole wheel [1/s]
    sample_rate  [1/s]
    tolerance    relative deviation of the edge rate that still counts as in step
    memory       of the estimator [s]; it follows the hidden error, in step or not, where the beat lasts longer
    Raises ParameterError for a sampling rate or memory that is not positive, a tolerance below 0, `largest` below 1.
    """
    require_positive_value("sampling rate", sample_rate, FREQUENCY)
    if not memory > 0.0:  # without end for one that forgets nothing
        raise ParameterError(f"memory: {value_text(memory, TIME)} {POSITIVE}")
    if not (tolerance >= 0.0 and largest >= 1):
        raise ParameterError(f"tolerance {tolerance:g} must be at least 0, and largest {largest} at least 1")
    if not 0.0 < edge_rate < sample_rate:
        return None
    ratio = edge_rate / sample_rate
    for samples in range(1, largest + 1):  # the first that fits is in lowest terms, and hides most
        edges = round(ratio * samples)
        found = Commensurate(edges, samples, edge_rate, sample_rate)
        if edges and (abs(ratio * samples / edges - 1.0) <= tolerance or beat_time(found) >= memory):
            return found
    return None


def hidden_angle(found: Commensurate, sector_width: float) -> float:
    """The largest constant error of the angle that stays hidden [rad]: sector / (2 q) = omega dT / (2 p).

    For equal sectors; one edge out of place among n changes it by at most omega dT / n.
    Evenly distributed between plus and minus this, depending on where in the sampling period the edges fall.
    """
    return sector_width / (2.0 * found.samples)


def hidden_speed(found: Commensurate, sector_width: float) -> float:
    """Excess of the speed shown between two jumps of the hidden angle [rad/s]: sector (p/q f_s - f_e).

    The speed shown is the one exactly in step.
    """
    return sector_width * (found.edges * found.sample_rate / found.samples - found.edge_rate)


def beat_time(found: Commensurate) -> float:
    """Time after which the hidden error has gone through all its values [s]: 1/|q f_e - p f_s|, infinite in step.

    A mean of the error over a time T >= this keeps at most beat / (4 T) of the hidden angle.
    """
    beat = abs(found.samples * found.edge_rate - found.edges * found.sample_rate)
    return 1.0 / beat if beat > 0.0 else np.inf


def commensurate_warning(found: Commensurate, sector_width: float) -> str:
    """A sentence for people on the hidden error, with numbers; the angle in rad and as a share of a sector."""
    p, q, beat = found.edges, found.samples, beat_time(found)
    off = abs(found.edge_rate * q / (p * found.sample_rate) - 1.0)
    places = "one place" if p == 1 else f"{p} places"
    if np.isinf(beat):
        lasting = "no average removes it"
    else:
        lasting = (
            f"it takes all its values once in {beat:.3g} s, an average over {2.5 * beat:.3g} s removes nine tenths"
        )
    return (
        f"The edge rate of {found.edge_rate:.6g}/s is {p}/{q} of the sampling rate of {found.sample_rate:.6g}/s within "
        f"{off:.2g}: edges fall on {places} in the sampling period, which hides an error of the angle of up to "
        f"{hidden_angle(found, sector_width):.3g} rad (1/{2 * q} of a sector); {lasting}. "
        "Stamp the edges with a capture unit, or sample at another rate."
    )
