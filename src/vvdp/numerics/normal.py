"""The standard normal distribution, and what is left of a belief of which one side of a bound is cut off."""

import math

from vvdp.numerics.kalman import AngleSpeed


def normal_density(z: float) -> float:
    """Density at z [1]: exp(-z^2/2)/sqrt(2 pi)."""
    return 0.3989422804014327 * math.exp(-0.5 * z * z)


def normal_share(z: float) -> float:
    """Share below z [1]: Phi(z) = erfc(-z/sqrt(2))/2."""
    return 0.5 * math.erfc(-0.7071067811865476 * z)


def truncate(belief: AngleSpeed, low: float, high: float, deviation: float) -> AngleSpeed:
    """Mean and covariance of a belief once the angle is known to lie between two bounds that share one noise.

    With m = (phi(low) - phi(high))/Z, Z = Phi(high) - Phi(low), the angle moves by (P11/s) m and P11 falls by
    (P11/s)^2 (m^2 - (low phi(low) - high phi(high))/Z); the speed follows as far as it is correlated.

    low, high  (bound - angle)/s [1], +-inf where there is none; Z must not be 0
    deviation  s, of a bound from the angle, its own noise included [rad]

    Source  johnson1994, section 13.10.1; docs/models/event-filter.md
    """
    b = belief
    mirrored = low > 0.0  # above the mean both shares are nearly 1, below it both are small: their difference is exact
    Z = normal_share(-low) - normal_share(-high) if mirrored else normal_share(high) - normal_share(low)
    at_low, at_high = normal_density(low), normal_density(high)
    m = (at_low - at_high) / Z
    drawn = (low * at_low if at_low > 0.0 else 0.0) - (high * at_high if at_high > 0.0 else 0.0)
    k1, k2, left = b.angle_variance / deviation, b.covariance / deviation, m * m - drawn / Z
    return AngleSpeed(
        b.angle + k1 * m,
        b.speed + k2 * m,
        b.angle_variance - k1 * k1 * left,
        b.covariance - k1 * k2 * left,
        b.speed_variance - k2 * k2 * left,
    )
