"""Telescopic cylinder: stages that run out one after the other, the largest first.

Source  ours, docs/models/components.md, where a function names no other.
"""

from typing import Annotated

from vvdp.base.kinds import AREA, LENGTH, Mass
from vvdp.base.params import Params
from vvdp.base.rules import refuse_rows, require_positive
from vvdp.base.select import clip
from vvdp.hydraulics.ports import Wall


class Telescope(Params):
    """Areas and strokes of the stages, the first to run out first. From one to the next the area falls over the last
    `CHANGE` of a stage's stroke.
    """

    areas: Annotated[tuple[float, ...], AREA]
    strokes: Annotated[tuple[float, ...], LENGTH]
    moving_mass: Mass

    def check(self) -> None:
        if not self.areas or len(self.areas) != len(self.strokes):
            refuse_rows(
                self, "strokes", f"{len(self.strokes)} for {len(self.areas)} areas; expected as many, at least one"
            )
        require_positive(self, "areas", "strokes")


CHANGE = 0.01
"""Share of a stage's stroke over which the area falls to that of the next."""


def telescope_area(position: float, telescope: Telescope) -> float:
    """Area on which the pressure acts [m^2].

    position  of the last stage, from all in [m]

    >>> lift = Telescope(areas=(5e-3, 3e-3), strokes=(1.0, 1.0), moving_mass=50.0)
    >>> telescope_area(0.5, lift), telescope_area(1.5, lift)
    (0.005, 0.003)
    """
    area, end = telescope.areas[0], 0.0
    for i in range(len(telescope.areas) - 1):
        end = end + telescope.strokes[i]
        width = CHANGE * telescope.strokes[i]
        area = area + (telescope.areas[i + 1] - telescope.areas[i]) * clip((position - end + width) / width, 0.0, 1.0)
    return area


def telescope_volume(position: float, telescope: Telescope) -> float:
    """Volume that the stages have left free [m^3], the integral of the area.

    position  [m]
    """
    volume, end = telescope.areas[0] * position, 0.0
    for i in range(len(telescope.areas) - 1):
        end = end + telescope.strokes[i]
        width = CHANGE * telescope.strokes[i]
        u = (position - end + width) / width
        inside = clip(u, 0.0, 1.0)
        volume = volume + (telescope.areas[i + 1] - telescope.areas[i]) * width * inside * (u - 0.5 * inside)
    return volume


def telescope_wall(position: float, velocity: float, telescope: Telescope) -> Wall:
    """Volume that the stages have added to the chamber [m^3], and its rate [m^3/s].

    position  [m]
    velocity  [m/s]
    """
    return Wall(telescope_volume(position, telescope), telescope_area(position, telescope) * velocity)
