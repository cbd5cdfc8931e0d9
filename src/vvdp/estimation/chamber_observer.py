"""Observer of the spool position, chamber drive: a periodic Kalman filter with the chamber pressure as input.

The measured pressure is the input; between two samples it is taken as a line, for which the transition of the damped
oscillator is exact. Derived in docs/models/axial-observer.md.

Source  ours, docs/models/axial-observer.md, where a function names no other.
"""

from typing import NamedTuple

import numpy as np

from vvdp.base.display import value_text
from vvdp.base.kinds import (
    VISCOUS_FRICTION,
    Area,
    Force,
    Length,
    Mass,
    Position,
    Pressure,
    Stiffness,
    Time,
    Velocity,
    ViscousFriction,
)
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
    take_optical,
)
from vvdp.numerics.kalman import move_leading


class SpringDrive(Params):
    """The spool as a mass between chamber and spring: M x'' = A (P - P_0) - K x - F_0 - b x'."""

    moving_mass: Mass
    stiffness: Stiffness
    preload: Force
    viscous_friction: ViscousFriction
    area: Area
    reference_pressure: Pressure = 101325.0

    def check(self) -> None:
        M, K, b = self.moving_mass, self.stiffness, self.viscous_friction
        require_positive(self, "moving_mass", "stiffness", "area")
        if not b * b < 4.0 * K * M:
            limit = value_text(2.0 * np.sqrt(K * M), VISCOUS_FRICTION)
            refuse(self, "viscous_friction", f"must be less than 2 sqrt(K M) = {limit}, or the spool creeps")


class ChamberObserver(Params):
    """The periodic Kalman filter of the chamber drive.

    Position and velocity drift by `position_drift` and `velocity_drift` a sample, and are known to their deviations at
    first.
    """

    drive: SpringDrive
    pollution: PollutionModel
    sample_period: Time
    position_drift: Length
    velocity_drift: Velocity
    position_deviation: Length
    velocity_deviation: Velocity
    stop_position: Position

    def check(self) -> None:
        require_positive(
            self, "sample_period", "position_drift", "velocity_drift", why="without process noise a gain falls to 0"
        )


class OscillatorStep(NamedTuple):
    """Step of position and velocity over a time: the transition, the response to an acceleration of 1 m/s^2, and the
    response to one that grows by 1 m/s^2 in a second."""

    position: tuple[float, float]
    velocity: tuple[float, float]
    constant: tuple[float, float]
    growing: tuple[float, float]


def oscillator_step(duration: float, drive: SpringDrive) -> OscillatorStep:
    """The exact transition of the damped oscillator over `duration` [s].

    With s = b/(2M), w_d^2 = K/M - s^2, e = exp(-s h): F = e [[c + s S, S], [-K/M S, c - s S]], c = cos w_d h,
    S = sin(w_d h)/w_d; an acceleration that is held adds ((1 - F_11) M/K, F_12), one that grows
    ((h - F_12 - 2 s (1 - F_11) M/K) M/K, (1 - F_11) M/K). A negative duration goes back.
    """
    h, stiff = duration, drive.stiffness / drive.moving_mass
    decay = 0.5 * drive.viscous_friction / drive.moving_mass
    swing = np.sqrt(stiff - decay * decay)
    e, c, s = np.exp(-decay * h), np.cos(swing * h), np.sin(swing * h) / swing
    F11, F12 = e * (c + decay * s), e * s
    held = (1.0 - F11) / stiff
    return OscillatorStep(
        position=(F11, F12),
        velocity=(-stiff * F12, e * (c - decay * s)),
        constant=(held, F12),
        growing=((h - F12 - 2.0 * decay * held) / stiff, held),
    )


def driving_acceleration(pressure: float, drive: SpringDrive) -> float:
    """Acceleration of the spool by chamber and preload alone [m/s^2]; `pressure` absolute [Pa]."""
    force = drive.area * (pressure - drive.reference_pressure) - drive.preload
    return force / drive.moving_mass


def chamber_observer_start(settings: ChamberObserver, position: float) -> AxialMemory:
    """The memory before the first sample, with the spool about at `position` [m]."""
    s = settings
    deviations = np.array([s.position_deviation, s.velocity_deviation])
    return axial_start(np.array([position, 0.0]), deviations, s.pollution)


def chamber_observer_step(
    memory: AxialMemory, seen: AxialSeen, settings: ChamberObserver
) -> tuple[AxialMemory, AxialEstimate]:
    """Memory and estimate after a sample.

    Source  wang2017, eqs. 5.44, 5.52 and 5.53, corrected and exact in time: docs/errata.md
    """
    draft, turn = draft_of(memory, 2), memory.turn
    a = driving_acceleration(seen.pressure, settings.drive)
    if seen.held > 0.0:
        hold_position(draft, settings.stop_position)
    else:
        move_chamber(draft, memory.drive_input, a, settings)
    if not is_frozen(seen):
        turn = drift_in_turn(draft, turn, settings.pollution)
    sight = take_optical(draft, seen, settings.pollution, settings.sample_period)
    if needs_duty(seen):
        travelled = look_back(draft, seen.duty.age, a, settings.drive)
        take_duty(draft, seen, travelled, settings.pollution)
    estimate = estimate_of(draft, draft.mean[1], seen, sight)
    return AxialMemory(mean=draft.mean, factors=draft.factors, drive_input=a, turn=turn), estimate


def move_chamber(draft: Draft, before: float, now: float, settings: ChamberObserver) -> None:
    """Step the belief on by a sample, in place; the driving acceleration goes from `before` to `now` [m/s^2]."""
    step = oscillator_step(settings.sample_period, settings.drive)
    noise, F = np.empty(2), np.empty((2, 2))
    noise[0] = settings.position_drift * settings.position_drift
    noise[1] = settings.velocity_drift * settings.velocity_drift
    F[0, 0], F[0, 1] = step.position
    F[1, 0], F[1, 1] = step.velocity
    move_leading(draft.mean, draft.factors, F, noise)
    slope = (now - before) / settings.sample_period
    draft.mean[0] += step.constant[0] * before + step.growing[0] * slope
    draft.mean[1] += step.constant[1] * before + step.growing[1] * slope


def look_back(draft: Draft, age: float, acceleration: float, drive: SpringDrive) -> float:
    """Write the position `age` [s] ago into the draft's row, in terms of the present state; returns its change since by
    the driving `acceleration` [m/s^2], taken as held [m]."""
    step = oscillator_step(-age, drive)
    draft.row[:] = 0.0
    draft.row[0], draft.row[1] = step.position
    return -step.constant[0] * acceleration
