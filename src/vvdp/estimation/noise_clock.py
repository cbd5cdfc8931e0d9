"""A clock for pollution that is periodic in time, and how it finds the pollution's own frequency.

Where the clock is off, every pair of coefficients turns, the h-th pair h times as fast as the first. Derived in
docs/models/axial-observer.md.

Source  ours, docs/models/axial-observer.md, where a function names no other.
"""

from typing import NamedTuple

from vvdp.base.arrays import Array
from vvdp.base.kinds import Angle, Length, Speed
from vvdp.base.params import Params
from vvdp.base.select import clip
from vvdp.estimation.axial_filter import AxialEstimate, AxialMemory, AxialSeen, Phase
from vvdp.estimation.gerotor_observer import GerotorObserver, gerotor_observer_start, gerotor_observer_step


class NoiseClock(Params):
    """The clock starts with `speed`; it follows the pollution's frequency with `bandwidth`, 0: not at all, within
    `speed_range` of the start, once the pollution is larger than `least_amplitude`."""

    speed: Speed
    bandwidth: Speed = 0.0
    speed_range: Speed = 0.0
    least_amplitude: Length = 1e-5


class ClockMemory(NamedTuple):
    """Phase of the pollution and how fast it goes."""

    angle: Angle
    speed: Speed


class ClockedGerotor(Params):
    """The gerotor drive's observer with a basis in time."""

    observer: GerotorObserver
    clock: NoiseClock


class ClockedMemory(NamedTuple):
    """Of the observer and of its clock."""

    axial: AxialMemory
    clock: ClockMemory


def turned_phase(before: Array, after: Array, first: int, harmonics: int, least_amplitude: float) -> float:
    """By how much the pollution has run ahead of the clock between two beliefs [rad].

    -sum h (a db - b da)/sum h^2 (a^2 + b^2): the rotation that all pairs have in common, by least squares.

    before, after    means of the observer, the coefficients from place `first` on
    least_amplitude  below which a pollution has no phase to be seen [m]
    """
    turned, weight = 0.0, least_amplitude * least_amplitude
    for h in range(1, harmonics + 1):
        i = first + 2 * (h - 1)
        a, b = after[i], after[i + 1]
        turned -= h * (a * (b - before[i + 1]) - b * (a - before[i]))
        weight += h * h * (a * a + b * b)
    return turned / weight


def clocked_gerotor_start(settings: ClockedGerotor, position: float) -> ClockedMemory:
    """The memory before the first sample, with the spool about at `position` [m]."""
    return ClockedMemory(
        axial=gerotor_observer_start(settings.observer, position),
        clock=ClockMemory(angle=0.0, speed=settings.clock.speed),
    )


def clocked_gerotor_step(
    memory: ClockedMemory, seen: AxialSeen, settings: ClockedGerotor
) -> tuple[ClockedMemory, AxialEstimate]:
    """Memory and estimate after a sample; the spool angle that is seen is not used.

    Source  wang2017, eq. 4.10, with the frequency adapted
    """
    observer, clock, c = settings.observer, memory.clock, settings.clock
    angle = clock.angle + clock.speed * observer.sample_period
    in_time = AxialSeen(
        time=seen.time,
        optical=seen.optical,
        phase=Phase(angle=angle, speed=clock.speed, angle_deviation=0.0),
        pressure=seen.pressure,
        flow=seen.flow,
        held=seen.held,
        margin=seen.margin,
        duty=seen.duty,
    )
    axial, estimate = gerotor_observer_step(memory.axial, in_time, observer)
    harmonics = int(observer.pollution.basis.harmonics)
    ahead = turned_phase(memory.axial.mean, axial.mean, 1, harmonics, c.least_amplitude)
    speed = clip(clock.speed + c.bandwidth * ahead, c.speed - c.speed_range, c.speed + c.speed_range)
    return ClockedMemory(axial=axial, clock=ClockMemory(angle=angle, speed=speed)), estimate
