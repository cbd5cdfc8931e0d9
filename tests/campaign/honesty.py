"""What must be true of the pooled errors of a class."""

from tests.campaign.scoring import Honesty

COVERED = 0.90, 0.99
FEW = 0.035
"""By so much the coverage of a few records may lie below: four have some 100 independent errors, three deviations of
the share within two."""


def covers(found: Honesty, *, few: bool) -> bool:
    """Whether two deviations cover as many errors of speed and of angle as they should; a `few` records say less."""
    low, high = COVERED[0] - FEW * few, COVERED[1] + 0.01 * few
    return low <= found.speed_coverage <= high and low <= found.angle_coverage <= high


def is_calibrated(found: Honesty, *, few: bool) -> bool:
    """Whether errors of speed and angle are as large as stated: their mean squares over what is stated lie within the
    band; of a `few` records, not all of them alike, within half and twice it."""
    low, high = found.low * (1.0 - 0.5 * few), found.high * (1.0 + few)
    return low <= found.speed_nees <= high and low <= found.angle_nees <= high
