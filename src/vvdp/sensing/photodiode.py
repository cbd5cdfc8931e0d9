"""The light spot on the code wheel, and the wave that the photodiode makes of it.

Source  ours, docs/models/encoder.md, where a function names no other.
"""

import numpy as np

from vvdp.base.kinds import Fraction, Length
from vvdp.base.params import Params
from vvdp.base.rules import require_positive
from vvdp.base.select import clip, select
from vvdp.sensing.wheel import TURN, CodeWheel

NEWTON_STEPS = 8


class LightSpot(Params):
    """A spot of light `width` long on a track of `track_radius`; `roundness` is 0 for a strip, 1 for a disc."""

    width: Length
    track_radius: Length
    roundness: Fraction

    def check(self) -> None:
        require_positive(self, "track_radius")


def ramp_width(spot: LightSpot) -> float:
    """Angle over which an edge of the wheel crosses the spot [rad]: width over track radius."""
    return spot.width / spot.track_radius


def spot_share(distance: float, roundness: float) -> float:
    """Share of the spot that an edge has swept, from 0 to 1 [1].

    Strip: 1/2 + x. Disc: 1/2 + (asin(2x) + 2x sqrt(1 - 4 x^2)) / pi, the segment of a circle.

    distance   x, of the spot's middle beyond the edge over the spot's width; the spot is swept from -0.5 to 0.5
    roundness  0 for a strip, 1 for a disc
    """
    x = clip(2.0 * distance, -1.0, 1.0)
    disc: float = 0.5 + (np.arcsin(x) + x * np.sqrt(1.0 - x * x)) / np.pi
    return (1.0 - roundness) * 0.5 * (1.0 + x) + roundness * disc


def swept_distance(share: float, roundness: float) -> float:
    """Distance at which an edge has swept a `share` of the spot, over the spot's width [1]; inverse of `spot_share`.

    A fixed number of Newton steps from the strip's value; to rounding for shares of 0.01 to 0.99.
    """
    x = clip(share, 0.0, 1.0) - 0.5
    if roundness == 0.0:
        return x
    for _ in range(NEWTON_STEPS):
        c = clip(2.0 * x, -1.0, 1.0)
        slope = (1.0 - roundness) + roundness * 4.0 / np.pi * np.sqrt(1.0 - c * c)
        x = clip(x + (share - spot_share(x, roundness)) / select(slope > 1e-3, slope, 1e-3), -0.5, 0.5)
    return x


def photodiode_signal(angle: float, wheel: CodeWheel, spot: LightSpot) -> float:
    """Share of the spot that lies on bright sectors, 0 to 1 [1]; holds also where sectors are narrower than the spot.

    angle  of the spot's middle on the wheel [rad]
    """
    w = ramp_width(spot)
    rest: float = angle - TURN * np.floor(angle / TURN)
    light: float = 0.0 * rest
    sign = 1.0
    for edge in wheel.edges:
        past = rest - edge
        near = past - TURN * np.floor(past / TURN + 0.5)
        blurred = spot_share(near / w, spot.roundness) - select(near >= 0.0, 1.0, 0.0)
        light = light + sign * (select(past >= 0.0, 1.0, 0.0) + blurred)
        sign = -sign
    return light
