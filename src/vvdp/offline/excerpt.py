"""The last turns of a record in the middle of the log, as they were sampled, for the charts."""

import numpy as np

from vvdp.logs.channel import Portion
from vvdp.offline.charts import Excerpt
from vvdp.offline.edges import CountEdges, Edges, WaveEdges

EXCERPT_TURNS = 3
LARGEST_EXCERPT = 20_000


def excerpt(
    samples: Portion, found: Edges, finder: WaveEdges | CountEdges, pressure: Portion | None, sectors: int
) -> Excerpt:
    """The last turns of a stretch of `samples` in which edges were `found`, with the pressure meanwhile."""
    shown = Edges(*(column[-EXCERPT_TURNS * sectors :] for column in found))
    margin = float(shown.times[-1] - shown.times[0]) / shown.times.size
    begin, end = np.searchsorted(samples.times, [shown.times[0] - margin, shown.times[-1] + margin])
    begin = max(begin, end - LARGEST_EXCERPT)
    wave = isinstance(finder, WaveEdges)
    part = slice(begin, end) if wave else slice(0)
    return Excerpt(
        times=samples.times[part].copy(),
        values=samples.values[part].copy(),
        level=finder.level if isinstance(finder, WaveEdges) else np.nan,
        band=finder.band if isinstance(finder, WaveEdges) else np.nan,
        edges=shown,
        pressure=None if pressure is None else _between(pressure, samples.times[begin], samples.times[end - 1]),
    )


def _between(samples: Portion, begin: float, end: float) -> Portion:
    first, last = np.searchsorted(samples.times, [begin, end])
    chosen = slice(max(first, last - LARGEST_EXCERPT), last)
    return Portion(samples.times[chosen].copy(), samples.values[chosen].copy())
