"""Why a log gave no estimate."""

from collections.abc import Iterator

import numpy as np

from vvdp.offline.bridging import LONGEST_BRIDGED
from vvdp.offline.config import Estimation
from vvdp.offline.cutting import FEWEST_EDGES
from vvdp.offline.edges import JUMPING, CountEdges, WaveEdges
from vvdp.offline.sums import Tally


def explain_no_result(tally: Tally, wanted: Estimation) -> str:
    """The reason why there is no estimate: the first one that holds."""
    return next(text for holds, text in _reasons(tally, wanted) if holds)


def _reasons(tally: Tally, wanted: Estimation) -> Iterator[tuple[bool, str]]:
    channel, finder, edges = wanted.source.channel, tally.finder, f"{tally.edges:g} edges were found"
    needed = f"an estimate needs at least {FEWEST_EDGES} on one clock"
    if isinstance(finder, WaveEdges):
        yield (
            not tally.edges and finder.jumps > JUMPING,
            f"channel {channel!r} goes through {100.0 * finder.jumps:.0f} % of its range from one sample to the next: "
            "there are too few samples for each sector (three at least are needed to see where the wave rises and "
            "falls), or it is noise; sample faster, or give threshold.level in a config",
        )
        yield (
            not np.isfinite(finder.level),
            f"channel {channel!r} does not go up and down between two levels, so there is no threshold and no edge; "
            "name the right channel, or give threshold.level in a config",
        )
    yield not tally.samples, f"channel {channel!r} has no samples"
    if isinstance(finder, CountEdges):
        yield (
            finder.fractions > 0,
            f"{edges} in channel {channel!r}, and {finder.fractions} of its {tally.samples} values are no whole "
            "numbers, so it is no counter; if it is a wave, name it with --wave",
        )
    ranged = wanted.begin is not None or wanted.end is not None
    yield not tally.edges and ranged, f"no edges of {channel!r} lie in the time range that was asked for"
    yield (
        tally.backward > 0,
        f"{edges} in channel {channel!r}, but time runs backwards there, {tally.backward} times; {needed}, and in the "
        "order of time",
    )
    apart = (tally.end - tally.begin) / (tally.edges - 1.0) if tally.edges > FEWEST_EDGES else np.nan
    yield (
        isinstance(finder, CountEdges) and apart < LONGEST_BRIDGED,
        f"{edges} in channel {channel!r}, in only {tally.left_out} steps; {needed}, so read the counter faster",
    )
    yield (
        bool(np.isfinite(apart)),
        f"{edges} in channel {channel!r}, {apart:.4g} s apart on average: the spool is not rotating; look at the unit "
        f"of the times ({needed} with less than {LONGEST_BRIDGED:g} s between them)",
    )
    yield True, f"{edges} in channel {channel!r}; {needed}"
