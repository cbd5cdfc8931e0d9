"""Storage of the controlled chamber, and its largest admissible gain: passivity between two samples.

Source  ours, docs/models/passivity-control.md, where a function names no other.
"""

from typing import NamedTuple

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.errors import ParameterError
from vvdp.base.kinds import Energy, ExchangedPower
from vvdp.base.select import maximum
from vvdp.control.chamber import (
    ChamberDrive,
    ChamberReading,
    DesiredPressure,
    PositionGains,
    chamber_volume,
    desired_pressure,
)
from vvdp.control.passivity import exact_feedforward
from vvdp.control.reference import Reference
from vvdp.fluid.mixture import compression_energy_per_volume


class StorageBalance(NamedTuple):
    """Storage [J], and the rate at which it grows, or, if a law is not exact, may grow [W]."""

    storage: Energy
    supply: ExchangedPower


def pressure_storage(desired: DesiredPressure, reading: ChamberReading, drive: ChamberDrive) -> float:
    """W_P = V(x) W_V(P, P_d) [J], at least 0: the energy of the oil against its desired pressure.

    Source  wang2017, eq. 5.24
    """
    energy = compression_energy_per_volume(reading.pressure, desired.pressure, drive.oil)
    return chamber_volume(reading.position, drive) * energy


def pressure_balance(
    flow: float, desired: DesiredPressure, reading: ChamberReading, drive: ChamberDrive
) -> StorageBalance:
    """W_P [J] and (p + W_V) (Q - Q_d) - p A e_v [W], p = P - P_d, which is its rate with the exact Q_d.

    flow  into the chamber [m^3/s]

    Source  wang2017, eq. 5.27, with Q_d of docs/models/passivity-control.md
    """
    p = reading.pressure - desired.pressure
    storage = pressure_storage(desired, reading, drive)
    effort = p + storage / chamber_volume(reading.position, drive)
    surplus = flow - exact_feedforward(desired, reading, drive)
    return StorageBalance(storage, effort * surplus - p * drive.area * desired.velocity_error)


def loop_balance(
    flow: float, reference: Reference, reading: ChamberReading, gains: PositionGains, drive: ChamberDrive
) -> StorageBalance:
    """W = M e_v^2/2 + (K + K_p) e^2/2 + V W_V of the closed loop [J], and its rate with no load [W].

    The rate is -K_v e_v^2 - l (K + K_p) e^2 - b e_v e' + (p + W_V) (Q - Q_d), with the exact Q_d and the friction b of
    the law; below zero for Q = Q_d - lambda_3 p where b l < 4 (K + K_p). It holds while the desired pressure is not
    held at that of tank or supply.

    flow  into the chamber [m^3/s]

    Source  wang2017, eqs. 5.32 and 5.33; friction ours
    """
    desired = desired_pressure(reference, reading, gains, drive)
    e, ev, stiffness = desired.position_error, desired.velocity_error, drive.stiffness + gains.position_gain
    oil = pressure_balance(flow, desired, reading, drive)
    exchanged = (reading.pressure - desired.pressure) * drive.area * ev
    rubbed = gains.friction * ev * (ev - gains.error_rate * e)
    return StorageBalance(
        storage=0.5 * drive.moving_mass * ev**2 + 0.5 * stiffness * e**2 + oil.storage,
        supply=oil.supply + exchanged - gains.velocity_gain * ev**2 - gains.error_rate * stiffness * e**2 - rubbed,
    )


def storage_excess(before: StorageBalance, after: StorageBalance, interval: float) -> float:
    """Rise of the storage beyond the supplied energy between two samples [J]; above 0 it violates passivity.

    The supply is taken at the greater of its two ends, both with the flow of the interval.

    interval  between the samples [s]
    """
    return after.storage - before.storage - interval * maximum(before.supply, after.supply)


def estimation_storage(error: Array, covariance: Array) -> float:
    """Weight of an observer's error in the Lyapunov function, x' P^-1 x [1].

    error       true state minus its estimate
    covariance  P, as estimated by the observer

    Source  wang2017, eqs. 5.55 and 5.68; its weight is found by `least_estimation_weight`
    """
    return float(error @ np.linalg.solve(covariance, error))


def least_estimation_weight(tracking: Array, estimation: Array, tolerance: float = 0.0) -> float:
    """The smallest c >= 0 with which W + c x' P^-1 x falls from each sample to the next [J].

    tracking    W of the loop with estimated states, one value a sample [J]
    estimation  x' P^-1 x at the same samples [1]
    tolerance   by which W may rise between two samples all the same [J]

    Raises `ParameterError`, with the sample, if W rises where the other does not fall: no weight is large enough then.
    """
    rises, falls = np.diff(tracking) - tolerance, -np.diff(estimation)
    rising = rises > 0.0
    if np.any(rising & (falls <= 0.0)):
        sample = int(np.argmax(rising & (falls <= 0.0))) + 1
        raise ParameterError(
            f"sample {sample}: the tracking storage rises by {rises[sample - 1]:.3g} J while the estimation error "
            f"does not fall ({-falls[sample - 1]:.3g}); no weight makes their sum fall"
        )
    return float(np.max(rises[rising] / falls[rising], initial=0.0))
