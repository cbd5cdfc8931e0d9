"""Storage of a controlled cylinder: errors of motion, and oil compressed against the force that it should give.

For chambers without a line between pump and valve. Where the force of the oil is off, the piston is off the position
x_F at which the same oil would give the desired force; the energy stored in the oil is counted from there.

Source  ours, docs/models/displacement-control.md, where a function names no other.
"""

import numpy as np

from vvdp.control.capacities import CylinderModel
from vvdp.control.cylinder_force import DesiredForce, ForceGains, Motion
from vvdp.control.storage import StorageBalance

MOST = 100
"""Limit of the iterations: more than halving needs to reach rounding."""


def force_measure(position: float, cylinder: CylinderModel) -> float:
    """h = A_a ln(V_a + A_a x) - A_b ln(V_b - A_b x) [m^2], whose slope is L: oil enclosed gives F_H = -beta h + const.

    position  [m]

    Source  wang2017, eq. 6.11, corrected: docs/errata.md
    """
    a, b = cylinder.area_a, cylinder.area_b
    measure: float = a * np.log(cylinder.oil_volume_a + a * position) - b * np.log(cylinder.oil_volume_b - b * position)
    return measure


def displaced_measure(distance: float, position: float, cylinder: CylinderModel) -> float:
    """h(x + d) - h(x) [m^2], without cancellation.  distance: d [m]; position: x [m]."""
    a, b = cylinder.area_a, cylinder.area_b
    za, zb = (
        a * distance / (cylinder.oil_volume_a + a * position),
        b * distance / (cylinder.oil_volume_b - b * position),
    )
    measure: float = a * np.log1p(za) - b * np.log1p(-zb)
    return measure


def force_distance(force_error: float, position: float, cylinder: CylinderModel) -> float:
    """d = x_F - x [m], by which the piston is off: h(x + d) - h(x) = (F_H - F_v)/beta.

    Newton's steps between two ends that close in; h rises from minus to plus infinity, so that there is one answer.

    force_error  F_H - F_v [N]
    position     x [m]

    Source  wang2017, eq. 6.12
    """
    a, b, beta = cylinder.area_a, cylinder.area_b, cylinder.bulk_modulus
    Va, Vb = cylinder.oil_volume_a + a * position, cylinder.oil_volume_b - b * position
    low, high, wanted, d = -Va / a, Vb / b, force_error / beta, 0.0
    for _ in range(MOST):
        excess = displaced_measure(d, position, cylinder) - wanted
        if excess > 0.0:
            high = d
        else:
            low = d
        step = d - excess / (a * a / (Va + a * d) + b * b / (Vb - b * d))
        following = step if low < step < high else 0.5 * (low + high)
        if following == d:
            break
        d = following
    return d


def force_storage(distance: float, position: float, cylinder: CylinderModel) -> float:
    """W_F = beta sum of V (z - ln(1 + z)) [J], z_a = A_a d/V_a, z_b = -A_b d/V_b: at least 0.

    The closed form of beta int_{x_F}^x (h(s) - h(x_F)) ds.

    distance  d = x_F - x [m]
    position  x [m]

    Source  wang2017, eq. 6.13; closed form ours, docs/models/displacement-control.md
    """
    a, b = cylinder.area_a, cylinder.area_b
    Va, Vb = cylinder.oil_volume_a + a * position, cylinder.oil_volume_b - b * position
    za, zb = a * distance / Va, -b * distance / Vb
    storage: float = cylinder.bulk_modulus * (Va * (za - np.log1p(za)) + Vb * (zb - np.log1p(zb)))
    return storage


def cylinder_balance(
    effort: float, desired: DesiredForce, motion: Motion, force: float, gains: ForceGains, cylinder: CylinderModel
) -> StorageBalance:
    """W = m e_v^2/2 + K_p e^2/2 + W_F [J] and its rate -K_v e_v^2 - lambda K_p e^2 - r (F_H - F_v) + d (U - F_v') [W].

    effort  U as delivered [N/s]; with U* the last two terms are about -lambda_3 (F_H - F_v)^2/L
    force   of the oil, F_H [N]

    Source  wang2017, eqs. 6.17 and 6.18
    """
    e, ev = desired.position_error, desired.velocity_error
    error = force - desired.force
    d = force_distance(error, motion.position, cylinder)
    storage = 0.5 * motion.moving_mass * ev * ev + 0.5 * gains.position_gain * e * e
    lost = gains.velocity_gain * ev * ev + gains.error_rate * gains.position_gain * e * e
    return StorageBalance(
        storage=storage + force_storage(d, motion.position, cylinder),
        supply=d * (effort - desired.rate) - desired.reference_velocity * error - lost,
    )
