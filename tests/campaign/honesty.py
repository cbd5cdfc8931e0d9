"""What must be true of the pooled errors of a class."""

from tests.campaign.scoring import Honesty

COVERED = 0.90, 0.99
FEW = 0.065
"""By so much the coverage of a few records may lie below. Four have some 100 independent errors, three deviations of
their share within two being 0.065; and they are not all alike."""

TENTH = 0.8, 1.25
"""Factors of the mean square by which the deviation is a tenth off: so well it need be known."""

FIFTH = 0.64, 1.56
"""The same for a fifth, where the wheel stops or jumps: what is stated there rests on rates that are assumed."""


def covers(found: Honesty, *, few: bool) -> bool:
    """Whether two deviations cover as many errors of speed and of angle as they should; a `few` records say less."""
    low, high = COVERED[0] - FEW * few, COVERED[1] + 0.01 * few
    return low <= found.speed_coverage <= high and low <= found.angle_coverage <= high


def is_calibrated(found: Honesty, *, few: bool, jumps: bool = False) -> bool:
    """Whether errors of speed and angle are as large as stated, to a tenth, or a fifth of a wheel that `jumps`: their
    mean squares over what is stated lie within so much of the band.

    Of a `few` records, a wheel among them that is easily seen, they lie within a twentieth and twice it.
    """
    below, above = (0.05, 2.0) if few else FIFTH if jumps else TENTH
    low, high = below * found.low, above * found.high
    return low <= found.speed_nees <= high and low <= found.angle_nees <= high
