"""Cushion of a cylinder: a spear that closes the port near the end of the stroke and leaves a throttle.

Source  ours, docs/models/components.md, where a function names no other.
"""

from vvdp.base.kinds import Area, Position
from vvdp.base.rules import refuse, require_positive
from vvdp.base.select import clip, select
from vvdp.hydraulics.orifice import Orifice


class Cushion(Orifice):
    """Cushion of a cylinder: between the positions `cushion_begin` and `cushion_end` the spear reduces the area from
    `port_area` to `throttle_area`. Oil that flows into the chamber has the whole area, through a check valve.
    """

    port_area: Area
    throttle_area: Area
    cushion_begin: Position
    cushion_end: Position

    def check(self) -> None:
        require_positive(self, "port_area")
        if self.throttle_area > self.port_area:
            refuse(self, "throttle_area", "must be at most port_area")
        if self.cushion_begin == self.cushion_end:
            refuse(self, "cushion_end", "must differ from cushion_begin")


def cushion_area(position: float, drop: float, cushion: Cushion) -> float:
    """Area between port and chamber [m^2].

    position  of the rod [m]
    drop      pressure at the port less that in the chamber [Pa]

    >>> cushion = Cushion(port_area=1e-4, throttle_area=2e-6, cushion_begin=0.03, cushion_end=0.01)
    >>> print(round(1e6 * cushion_area(0.02, -1e5, cushion), 3), round(1e6 * cushion_area(0.02, 1e5, cushion), 3))
    51.0 100.0
    """
    inside = clip((position - cushion.cushion_begin) / (cushion.cushion_end - cushion.cushion_begin), 0.0, 1.0)
    narrow = cushion.port_area + inside * (cushion.throttle_area - cushion.port_area)
    return select(drop > 0.0, cushion.port_area, narrow)
