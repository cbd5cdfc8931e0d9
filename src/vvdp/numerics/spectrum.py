"""Amplitude spectrum of sampled values that repeat themselves."""

from typing import NamedTuple

import numpy as np

from vvdp.base.arrays import Array


class Spectrum(NamedTuple):
    """One-sided spectrum."""

    frequencies: Array  # [1 / unit of the interval], (n // 2 + 1,)
    amplitudes: Array  # in the unit of the values, (n // 2 + 1,)


def line_spectrum(values: Array, interval: float) -> Spectrum:
    """Amplitudes of the sines in `values`, sampled every `interval` over a whole number of periods.

    There is no window: over whole periods each harmonic reads its amplitude at its own line and nothing beside it, and
    the sum of a**2 / 2 is the variance. Line 0 is the size of the mean. Raises ValueError for fewer than 4 values.
    """
    n = values.size
    if n < 4 or not interval > 0.0:
        raise ValueError(f"{n} values every {interval:g}; expected at least 4; the interval must be greater than 0")
    amplitudes = np.asarray(2.0 / n * np.abs(np.fft.rfft(values)), float)
    amplitudes[0] *= 0.5
    if n % 2 == 0:
        amplitudes[-1] *= 0.5
    return Spectrum(np.asarray(np.fft.rfftfreq(n, interval), float), amplitudes)
