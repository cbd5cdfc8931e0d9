"""Flow of a throttle over the position of its spool: dead band, then linear or progressive.

Source  ours, docs/models/components.md, where a function names no other.
"""

import numpy as np

from vvdp.base.kinds import Fraction, Ratio
from vvdp.base.modes import between
from vvdp.base.params import Params
from vvdp.base.rules import refuse
from vvdp.base.select import clip, select


class Characteristic(Params):
    """`dead_band` is the share of the stroke without flow; `rangeability` the slope at its end over that at its begin.

    Rangeability 1 is linear.
    """

    dead_band: Fraction
    rangeability: Ratio

    def check(self) -> None:
        if self.dead_band >= 1.0:
            refuse(self, "dead_band", "must be less than 1: the valve would never open")
        if self.rangeability < 1.0:
            refuse(self, "rangeability", "must be at least 1 (linear)")


def flow_share(opening: float, characteristic: Characteristic) -> float:
    """Share of the full flow at a position of the spool [1]: (R^s - 1)/(R - 1), s the travel beyond the dead band.

    opening  position of the spool, held between 0 and 1 [1]
    """
    dead, R = characteristic.dead_band, characteristic.rangeability
    s: float = clip((opening - dead) / (1.0 - dead), 0.0, 1.0)
    L = np.log(R)
    share: float = select(R > 1.0, np.expm1(s * L) / select(R > 1.0, np.expm1(L), 1.0), s)
    return share


def dead_band_side(opening: float, characteristic: Characteristic) -> float:
    """Whether a spool is in its dead band, beyond it or at its end [1], see `base.modes.between`.

    opening  position of the spool [1]
    """
    return between((opening - characteristic.dead_band) / (1.0 - characteristic.dead_band))


def opening_for(share: float, characteristic: Characteristic) -> float:
    """Position of the spool for a share of the full flow [1], the inverse of `flow_share`; at 0 the dead band's end.

    share  of the full flow, held between 0 and 1 [1]
    """
    dead, R = characteristic.dead_band, characteristic.rangeability
    f: float = clip(share, 0.0, 1.0)
    L = np.log(R)
    s = select(R > 1.0, np.log1p(f * np.expm1(L)) / select(R > 1.0, L, 1.0), f)
    return dead + (1.0 - dead) * s
