"""Position of the spool by an observer with the chamber pressure as a further measured state.

P' = beta/V (Q - A x'): the flow that fills the chamber shows the velocity without the optical sensor, and the loss of
observability at the spring's own frequency disappears. Derived in docs/models/axial-observer.md.

Source  ours, docs/models/axial-observer.md, where a function names no other.
"""

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.display import value_text
from vvdp.base.kinds import TIME, BulkModulus, Length, Position, PressureDifference, Time, Velocity, Volume
from vvdp.base.params import Params
from vvdp.base.rules import refuse, require_positive
from vvdp.estimation.axial_filter import (
    AxialEstimate,
    AxialMemory,
    AxialSeen,
    Draft,
    PollutionModel,
    axial_start,
    draft_of,
    drift_in_turn,
    estimate_of,
    hold_position,
    is_frozen,
    needs_duty,
    take_duty,
    take_in,
    take_optical,
)
from vvdp.estimation.chamber_observer import SpringDrive, driving_acceleration, look_back
from vvdp.numerics.kalman import move_leading

TERMS = 18
"""Of the exponential's series: enough to rounding for h w = `MOST_SWING`."""
MOST_SWING = 2.0


class PressureObserver(Params):
    """The periodic Kalman filter of the chamber drive that calculates with the flow into the chamber.

    The chamber holds `chamber_volume` at position 0, with oil of `bulk_modulus` in it. Its pressure is measured to
    `pressure_deviation` and drifts by `pressure_drift` a sample, for what bulk modulus and flow are off.
    """

    drive: SpringDrive
    pollution: PollutionModel
    sample_period: Time
    chamber_volume: Volume
    bulk_modulus: BulkModulus
    position_drift: Length
    velocity_drift: Velocity
    pressure_drift: PressureDifference
    pressure_deviation: PressureDifference
    position_deviation: Length
    velocity_deviation: Velocity
    stop_position: Position

    def check(self) -> None:
        drifts = ("position_drift", "velocity_drift", "pressure_drift", "pressure_deviation")
        require_positive(self, *drifts, "sample_period", "chamber_volume")
        d = self.drive
        stiff = d.stiffness + d.area * d.area * self.bulk_modulus / self.chamber_volume
        swing = self.sample_period * np.sqrt(stiff / d.moving_mass)
        if not swing <= MOST_SWING:
            most = value_text(MOST_SWING * self.sample_period / swing, TIME)
            refuse(
                self,
                "sample_period",
                f"must be at most {most}: spool and oil swing with {swing / self.sample_period:.4g} 1/s",
            )


def pressure_observer_start(settings: PressureObserver, position: float, pressure: float) -> AxialMemory:
    """The memory before the first sample, with the spool about at `position` [m] and a chamber `pressure`, absolute
    [Pa]."""
    s = settings
    deviations = np.array([s.position_deviation, s.velocity_deviation, s.pressure_deviation])
    start = np.array([position, 0.0, pressure - s.drive.reference_pressure])
    return axial_start(start, deviations, s.pollution)


def pressure_observer_step(
    memory: AxialMemory, seen: AxialSeen, settings: PressureObserver
) -> tuple[AxialMemory, AxialEstimate]:
    """Memory and estimate after a sample."""
    draft, turn = draft_of(memory, 3), memory.turn
    gauge = seen.pressure - settings.drive.reference_pressure
    if seen.held > 0.0:
        hold_position(draft, settings.stop_position)
        draft.mean[2] = gauge
    else:
        move_with_pressure(draft, 0.5 * (memory.drive_input + seen.flow), settings)
        draft.row[:] = 0.0
        draft.row[2] = 1.0
        variance = settings.pressure_deviation * settings.pressure_deviation
        take_in(draft, gauge - draft.mean[2], variance, is_frozen(seen))
    if not is_frozen(seen):
        turn = drift_in_turn(draft, turn, settings.pollution)
    sight = take_optical(draft, seen, settings.pollution, settings.sample_period)
    if needs_duty(seen):
        a = driving_acceleration(seen.pressure, settings.drive)
        take_duty(draft, seen, look_back(draft, seen.duty.age, a, settings.drive), settings.pollution)
    estimate = estimate_of(draft, draft.mean[1], seen, sight)
    return AxialMemory(mean=draft.mean, factors=draft.factors, drive_input=seen.flow, turn=turn), estimate


def move_with_pressure(draft: Draft, flow: float, settings: PressureObserver) -> None:
    """Step the belief on by a sample, in place; `flow` into the chamber is its mean over it [m^3/s]."""
    drive, noise = settings.drive, np.empty(3)
    rate = settings.bulk_modulus / (settings.chamber_volume + drive.area * draft.mean[0])
    A = np.zeros((3, 3))
    A[0, 1] = 1.0
    A[1, 0] = -drive.stiffness / drive.moving_mass
    A[1, 1] = -drive.viscous_friction / drive.moving_mass
    A[1, 2] = drive.area / drive.moving_mass
    A[2, 1] = -rate * drive.area
    F, G = exponential_step(A, settings.sample_period)
    noise[0] = settings.position_drift * settings.position_drift
    noise[1] = settings.velocity_drift * settings.velocity_drift
    noise[2] = settings.pressure_drift * settings.pressure_drift
    move_leading(draft.mean, draft.factors, F, noise)
    push = -drive.preload / drive.moving_mass
    for i in range(3):
        draft.mean[i] += G[i, 1] * push + G[i, 2] * rate * flow


def exponential_step(rates: Array, duration: float) -> tuple[Array, Array]:
    """F = exp(A h), and G = int_0^h exp(A s) ds, by which inputs that are held act, both (n, n).

    G is the Taylor series in Horner's form, F = I + A G. Right to rounding while the largest h w is below `MOST_SWING`.

    rates     A (n, n)
    duration  h [s]
    """
    n = rates.shape[0]
    G, F = np.zeros((n, n)), np.zeros((n, n))
    for i in range(n):
        G[i, i] = duration
    for term in range(TERMS, 0, -1):
        # F serves as room for A G.
        for i in range(n):
            for j in range(n):
                F[i, j] = 0.0
                for k in range(n):
                    F[i, j] += rates[i, k] * G[k, j]
        if term == 1:
            break
        for i in range(n):
            for j in range(n):
                G[i, j] = F[i, j] * duration / term
            G[i, i] += duration
    for i in range(n):
        F[i, i] += 1.0
    return F, G
