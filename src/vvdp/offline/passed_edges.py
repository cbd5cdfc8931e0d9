"""The edges of a log that a fit is made of, out of result.h5."""

from collections import Counter
from typing import Any, NamedTuple

import numpy as np

from vvdp.base.arrays import Array
from vvdp.offline.estimate_result import portions

MOST_EDGES = 4096
"""Edges that a fit is made of, at most."""
FEWEST_FITTED = 64
"""Edges below which nothing is fitted."""


class Passed(NamedTuple):
    """Edges of a log that have numbers: arrays of one length, in the order of time within each piece."""

    times: Array  # [s]
    numbers: Array
    angles: Array  # where the wheel has them [rad]
    sampling_variances: Array  # [rad^2]
    pieces: Array


def longest_pieces(file: Any, edge_variance: float) -> Passed | None:
    """The settled edges of the longest pieces of result.h5, `MOST_EDGES` at most; None where they are too few.

    edge_variance  is taken off their variances [rad^2]: what is left is from sampling
    """
    sizes, firsts, before = Counter[float](), dict[float, int](), 0
    for piece, settled, number in portions(file, "edges/", "piece", "settled", "number"):
        chosen = np.flatnonzero((settled > 0.0) & np.isfinite(number))
        each, places, lengths = np.unique(piece[chosen], return_index=True, return_counts=True)
        sizes.update(dict(zip(each.tolist(), lengths.tolist(), strict=True)))
        firsts = dict(zip(each.tolist(), (before + chosen[places]).tolist(), strict=True)) | firsts
        before += piece.size
    found: list[Passed] = []
    total, room = 0, MOST_EDGES
    for longest in sorted(sizes, key=lambda each: -min(sizes[each], MOST_EDGES)):
        if total >= MOST_EDGES:
            break
        own = _first_edges(file, firsts[longest], longest, room, edge_variance)
        found += [own] if own.times.size > 2 else []
        total, room = total + min(sizes[longest], MOST_EDGES), room - (own.times.size if own.times.size > 2 else 0)
    return Passed(*map(np.concatenate, zip(*found, strict=True))) if MOST_EDGES - room >= FEWEST_FITTED else None


def _first_edges(file: Any, first: int, wanted: float, most: int, edge_variance: float) -> Passed:
    """The first edges of the piece `wanted` that can be used; the first of them stands in row `first`."""
    names = ("time", "number", "angle", "variance", "piece")
    columns = [file[f"edges/{name}"][first : first + 4 * MOST_EDGES] for name in names]
    own = np.flatnonzero((columns[4] == wanted) & np.isfinite(columns[1]))[:MOST_EDGES]
    own = own[np.diff(columns[0][own], prepend=-np.inf) > 0.0][:most]
    t, numbers, angles, variances, pieces = (column[own] for column in columns)
    sampled = np.fmax(variances - edge_variance, 0.0)
    sampled[sampled < 1e-9 * edge_variance] = 0.0  # a difference's rounding
    return Passed(t, numbers, angles, sampled, pieces)
