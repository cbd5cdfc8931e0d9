"""Amplitude spectrum of sampled values."""

from typing import NamedTuple

import numpy as np

from vvdp.base.arrays import Array

NOISE_BANDWIDTH = 1.5
"""Lines over which a Hann window spreads power: the sum of squared amplitudes is this much too large."""


class Spectrum(NamedTuple):
    """One-sided spectrum."""

    frequencies: Array  # [1 / unit of the interval], (n // 2 + 1,)
    amplitudes: Array  # in the unit of the values, (n // 2 + 1,)


def amplitude_spectrum(values: Array, interval: float) -> Spectrum:
    """Amplitudes of the sines in `values`, sampled every `interval`, through a Hann window.

    A sine that fits a whole number of times reads its amplitude at its own line and half of it at both neighbours;
    one that falls between two lines reads up to 15 % too little. The mean is taken off before the window, so that it
    does not spread into the first line; line 0 gives its size. Raises ValueError for fewer than 4 values.
    """
    n = values.size
    if n < 4 or not interval > 0.0:
        raise ValueError(f"{n} values every {interval:g}; expected at least 4, and an interval above 0")
    window = 0.5 - 0.5 * np.cos(2.0 * np.pi * np.arange(n) / n)
    mean = float(np.mean(values))
    amplitudes = np.asarray(2.0 / np.sum(window) * np.abs(np.fft.rfft((values - mean) * window)), float)
    amplitudes[0] = abs(mean)
    if n % 2 == 0:
        amplitudes[-1] *= 0.5
    return Spectrum(np.asarray(np.fft.rfftfreq(n, interval), float), amplitudes)
