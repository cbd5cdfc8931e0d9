"""Two observers with constant gains for the gerotor drive: the discrete signal generator, and a lumped filter.

The generator remembers a whole period of the periodic sensor error, sample by sample, but for the one that follows
from its mean of zero; the lumped filter takes the periodic sensor error for noise. Derived in
docs/models/axial-observer.md.

Source  ours, docs/models/axial-observer.md, where a function names no other.
"""

from typing import Annotated, NamedTuple

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.errors import ParameterError
from vvdp.base.kinds import NUMBER, TIME, Area, Length, Number, Position, Speed, Time
from vvdp.base.params import Params
from vvdp.base.rules import require_positive, require_positive_value
from vvdp.estimation.axial_filter import AxialEstimate, AxialSeen
from vvdp.estimation.noise_basis import TURN

SAME = 1e-4
"""Share by which the turn of a spool may differ from the period that a generator is made for [1]; assumed.

A generator of 20 states remembers some 20 turns: the periodic sensor error is then where it was within 0.01 rad. At
2e-2 the error is 25 times the stated one (230 um, 9.3 um): up to 8e-4 it is smaller than that, at 1e-4 an eighth of
it."""


class GeneratorDesign(Params):
    """Data from which the gains of a signal generator follow; drifts are standard deviations per sample, that of the
    generator enters its last state."""

    area: Area
    sample_period: Time
    noise_period: Time
    sensor_deviation: Length
    position_drift: Length
    generator_drift: Length
    stop_position: Position = 0.0

    def check(self) -> None:
        require_positive(
            self, "sensor_deviation", "position_drift", "generator_drift", why="without process noise a gain falls to 0"
        )
        samples_in_period(self.noise_period, self.sample_period)


class GeneratorObserver(Params):
    """The drive, and the gains of the position and of the N - 1 states of the generator; those at the stop, of the
    generator alone; the position's deviation that they keep."""

    area: Area
    sample_period: Time
    gain: Annotated[tuple[float, ...], NUMBER]
    held_gain: Annotated[tuple[float, ...], NUMBER]
    position_deviation: Length
    stop_position: Position


class GeneratorMemory(NamedTuple):
    """Position and the generator's states [m], and the velocity of the flow at the last sample."""

    mean: Annotated[Array, NUMBER]
    drive_input: Number


def samples_in_period(noise_period: float, sample_period: float) -> int:
    """N = T/T_s [1]. Raises ParameterError where that is no whole number of at least 2; both [s]."""
    require_positive_value("sample period", sample_period, TIME)
    ratio = noise_period / sample_period
    count = round(ratio)
    if count < 2 or abs(ratio - count) > 1e-6 * count:
        raise ParameterError(
            f"a noise period of {noise_period:g} s has {ratio:.6g} samples of {sample_period:g} s; a signal generator "
            f"needs a whole number of at least 2, for example a sample every {noise_period / max(count, 2):.6g} s"
        )
    return count


def signal_generator(samples: int) -> tuple[Array, Array]:
    """Transition (N - 1, N - 1) and observation (N - 1,) of a signal with period N and mean 0.

    Source  wang2017, eq. 4.3
    """
    A, C = np.eye(samples - 1, k=1), np.zeros(samples - 1)
    A[-1], C[0] = -1.0, 1.0
    return A, C


def generator_observer(design: GeneratorDesign) -> GeneratorObserver:
    """The observer with the steady gains of the Kalman filter, from SciPy's Riccati equation.

    Source  wang2017, eqs. 4.5 and 4.13
    """
    d, N = design, samples_in_period(design.noise_period, design.sample_period)
    A, C = np.eye(N), np.ones(N)
    A[1:, 1:], C[1:] = signal_generator(N)
    q = np.zeros(N)
    q[0], q[-1] = d.position_drift**2.0, d.generator_drift**2.0
    gain, P = steady_gain(A, C, q, d.sensor_deviation**2.0)
    held_gain, _ = steady_gain(A[1:, 1:], C[1:], q[1:], d.sensor_deviation**2.0)
    return GeneratorObserver(
        area=d.area,
        sample_period=d.sample_period,
        gain=tuple(gain.tolist()),
        held_gain=tuple(held_gain.tolist()),
        position_deviation=float(np.sqrt(P[0, 0])),
        stop_position=d.stop_position,
    )


def steady_gain(transition: Array, observation: Array, drift: Array, variance: float) -> tuple[Array, Array]:
    """Gain (n,) and covariance after a measurement (n, n) of a filter that has settled.

    drift     variances of a sample (n,)
    variance  of the measurement, R
    """
    from scipy.linalg import solve_discrete_are

    scale = 1.0 / variance  # in the sensor's own unit
    C = observation[:, None]
    P = solve_discrete_are(transition.T, C, np.diag(drift * scale), np.eye(1))
    gain = P @ C / (C.T @ P @ C + 1.0)
    return gain[:, 0], variance * (P - gain @ C.T @ P)


def generator_start(settings: GeneratorObserver, position: float) -> GeneratorMemory:
    """The memory before the first sample, with the spool about at `position` [m]."""
    mean = np.zeros(len(settings.gain))
    mean[0] = position
    return GeneratorMemory(mean=mean, drive_input=0.0)


def generator_observer_step(
    memory: GeneratorMemory, seen: AxialSeen, settings: GeneratorObserver
) -> tuple[GeneratorMemory, AxialEstimate]:
    """Memory and estimate after a sample. It uses no angle: the period is that of its design, whatever the speed.

    Its deviation holds for that period alone: it is NaN where the spool turns with another speed.

    Source  wang2017, eq. 4.13
    """
    n, velocity = memory.mean.size, seen.flow / settings.area
    mean = np.empty(n)
    mean[0] = memory.mean[0] + 0.5 * settings.sample_period * (memory.drive_input + velocity)
    mean[1:-1] = memory.mean[2:]
    mean[n - 1] = -np.sum(memory.mean[1:])
    if seen.held > 0.0:
        mean[0] = settings.stop_position
    innovation = seen.optical - mean[0] - mean[1]
    if seen.optical != seen.optical:
        innovation = 0.0
    elif seen.held > 0.0:
        for i in range(1, n):
            mean[i] += settings.held_gain[i - 1] * innovation
    else:
        for i in range(n):
            mean[i] += settings.gain[i] * innovation
    turned = seen.phase.speed * n * settings.sample_period / TURN
    is_its_own = turned == 0.0 or abs(turned - 1.0) < SAME
    deviation = settings.position_deviation if is_its_own else np.nan
    estimate = plain_estimate(mean[0], velocity, mean[1], innovation, seen, deviation)
    return GeneratorMemory(mean=mean, drive_input=velocity), estimate


class LumpedObserver(Params):
    """A filter of first order, which takes the periodic sensor error for white noise; `bandwidth` is its gain L."""

    area: Area
    sample_period: Time
    bandwidth: Speed
    stop_position: Position = 0.0


class LumpedMemory(NamedTuple):
    """The position, and the velocity of the flow at the last sample."""

    position: Position
    drive_input: Number


def lumped_observer_step(
    memory: LumpedMemory, seen: AxialSeen, settings: LumpedObserver
) -> tuple[LumpedMemory, AxialEstimate]:
    """Memory and estimate after a sample: x' = Q/A_s + L (y - x), exact for a signal that is held.

    Source  wang2017, eq. 4.24
    """
    velocity = seen.flow / settings.area
    position = memory.position + 0.5 * settings.sample_period * (memory.drive_input + velocity)
    innovation = seen.optical - position
    if seen.held > 0.0:
        position = settings.stop_position
    elif seen.optical == seen.optical:
        position += (1.0 - np.exp(-settings.bandwidth * settings.sample_period)) * innovation
    else:
        innovation = 0.0
    return LumpedMemory(position, velocity), plain_estimate(position, velocity, 0.0, innovation, seen, np.nan)


def plain_estimate(
    position: float, velocity: float, pollution: float, innovation: float, seen: AxialSeen, deviation: float
) -> AxialEstimate:
    """The estimate of an observer that never freezes and has no margin; `deviation` of the position [m]."""
    return AxialEstimate(
        position=position,
        velocity=velocity,
        position_deviation=deviation,
        velocity_deviation=np.nan,
        pollution=pollution,
        innovation=innovation,
        innovation_deviation=np.nan,
        lost=1.0 if seen.optical != seen.optical else 0.0,
        frozen=0.0,
        warned=0.0,
    )
