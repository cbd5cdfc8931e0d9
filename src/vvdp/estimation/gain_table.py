"""The gain of the periodic filter, learned once and read from a table over the spool angle.

Once the covariance has settled it comes back with every turn, and so does the gain: a sample then costs the number of
states instead of its square. It belongs to the speed at which it was learned. Derived in docs/models/axial-observer.md.

Source  ours, docs/models/axial-observer.md, where a function names no other.
"""

from typing import Annotated, NamedTuple

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.display import value_text
from vvdp.base.errors import ParameterError
from vvdp.base.kinds import NUMBER, SPEED, Number, Speed
from vvdp.base.params import Params
from vvdp.estimation.axial_filter import AxialEstimate, AxialSeen, draft_of, drift_in_turn
from vvdp.estimation.chamber_observer import (
    ChamberObserver,
    chamber_observer_start,
    driving_acceleration,
    move_chamber,
    oscillator_step,
)
from vvdp.estimation.noise_basis import TURN, write_basis
from vvdp.numerics.kalman import observe, variance_of

POINTS = 256


class TabulatedObserver(Params):
    """The chamber drive's observer with its `gain` at `POINTS` angles, one after the other, and the deviations of
    position and velocity that it keeps, in the mean over a turn."""

    observer: ChamberObserver
    gain: Annotated[tuple[float, ...], NUMBER]
    deviation: Annotated[tuple[float, ...], NUMBER]


class TabulatedMemory(NamedTuple):
    """Mean (n,) of the belief, and the driving acceleration at the last sample."""

    mean: Annotated[Array, NUMBER]
    drive_input: Number


def learn_gain(settings: ChamberObserver, spool_speed: Speed, turns: int = 100) -> TabulatedObserver:
    """The observer with the gains that it settles to at a constant `spool_speed` [rad/s].

    The second half of the `turns` is taken, each sample at the nearest angle; angles without one lie between others.
    Raises ParameterError where a turn has too few samples for a gain over the angle.
    """
    h, basis = settings.sample_period, settings.pollution.basis
    per_turn = TURN / (abs(spool_speed) * h) if spool_speed else np.inf
    memory = chamber_observer_start(settings, settings.stop_position)
    n = memory.mean.size
    if not 2.0 * (n - 2) <= per_turn < np.inf:
        raise ParameterError(
            f"spool speed: {value_text(spool_speed, SPEED)} must give at least {2 * (n - 2)} samples of {h:g} s per "
            f"revolution, for {n} states; it gives {per_turn:.4g}"
        )
    count = int(turns * per_turn)
    gains, variances, seen = np.zeros((POINTS, n)), np.zeros(2), np.zeros(POINTS)
    draft, turn = draft_of(memory, 2), 0.0
    for k in range(count):
        angle = spool_speed * h * k
        move_chamber(draft, 0.0, 0.0, settings)
        turn = drift_in_turn(draft, turn, settings.pollution)
        draft.row[:2] = 1.0, 0.0
        write_basis(angle, basis, draft.row, 2)
        observe(draft.factors, draft.row, settings.pollution.sensor_deviation**2.0, draft.gain)
        if 2 * k > count:
            place = round(angle / TURN * POINTS) % POINTS
            gains[place] += draft.gain
            variances += [variance_of(draft.factors, i) for i in range(2)]
            seen[place] += 1.0
    places = np.arange(POINTS)
    met = seen > 0.0
    mean = gains[met] / seen[met, None]
    filled = np.column_stack([np.interp(places, places[met], column, period=POINTS) for column in mean.T])
    return TabulatedObserver(
        observer=settings,
        gain=tuple(filled.ravel().tolist()),
        deviation=tuple(np.sqrt(variances / np.sum(seen)).tolist()),
    )


def tabulated_start(settings: TabulatedObserver, position: float) -> TabulatedMemory:
    """The memory before the first sample, with the spool about at `position` [m]."""
    return TabulatedMemory(mean=chamber_observer_start(settings.observer, position).mean, drive_input=0.0)


def tabulated_observer_step(
    memory: TabulatedMemory, seen: AxialSeen, settings: TabulatedObserver
) -> tuple[TabulatedMemory, AxialEstimate]:
    """Memory and estimate after a sample; at the stop the coefficients alone follow."""
    observer, n = settings.observer, memory.mean.size
    pollution, row, mean = observer.pollution, np.empty(n), memory.mean.copy()
    a = driving_acceleration(seen.pressure, observer.drive)
    step, before = oscillator_step(observer.sample_period, observer.drive), memory.drive_input
    change = (a - before) / observer.sample_period
    x, v = mean[0], mean[1]
    mean[0] = step.position[0] * x + step.position[1] * v + step.constant[0] * before + step.growing[0] * change
    mean[1] = step.velocity[0] * x + step.velocity[1] * v + step.constant[1] * before + step.growing[1] * change
    if seen.held > 0.0:
        mean[0], mean[1] = observer.stop_position, 0.0
    angle = seen.phase.angle - seen.phase.speed * pollution.optical_delay
    write_basis(angle, pollution.basis, row, 2)
    believed = 0.0
    for i in range(2, n):
        believed += mean[i] * row[i]
    innovation = seen.optical - mean[0] - believed
    if seen.optical != seen.optical:
        innovation = 0.0
    place = n * (int(np.floor(angle / TURN * POINTS + 0.5)) % POINTS)
    for i in range(2 if seen.held > 0.0 else 0, n):
        mean[i] += settings.gain[place + i] * innovation
    return TabulatedMemory(mean=mean, drive_input=a), AxialEstimate(
        position=mean[0],
        velocity=mean[1],
        position_deviation=settings.deviation[0],
        velocity_deviation=settings.deviation[1],
        pollution=believed,
        innovation=innovation,
        innovation_deviation=np.nan,
        lost=1.0 if seen.optical != seen.optical else 0.0,
        frozen=0.0,
        warned=0.0,
    )
