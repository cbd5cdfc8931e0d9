"""The amplitude spectrum reads sines as they are and loses no power."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vvdp.numerics.spectrum import NOISE_BANDWIDTH, amplitude_spectrum


@given(st.integers(2, 60), st.floats(0.1, 100.0), st.floats(0.0, 6.0), st.sampled_from([128, 129]))
def test_a_sine_on_a_line_reads_its_amplitude_there_and_half_beside(cycles, amplitude, phase, n):
    interval = 1e-3
    found = amplitude_spectrum(5.0 + amplitude * np.sin(2 * np.pi * cycles * np.arange(n) / n + phase), interval)
    assert found.frequencies[cycles] == pytest.approx(cycles / (n * interval))
    assert found.amplitudes[cycles] == pytest.approx(amplitude, rel=1e-10)
    assert found.amplitudes[cycles - 1] == pytest.approx(0.5 * amplitude, rel=1e-9)
    assert found.amplitudes[0] == pytest.approx(5.0, rel=1e-9)


def test_a_sine_between_two_lines_reads_at_most_fifteen_percent_too_little():
    # Hann at half a line off its centre: sinc(1/2) / (1 - 1/4) = (2 / pi) / 0.75 = 0.8488
    n = 4096
    found = amplitude_spectrum(np.sin(2 * np.pi * 100.5 * np.arange(n) / n), 1.0)
    assert found.amplitudes.max() == pytest.approx(2.0 / np.pi / 0.75, rel=1e-4)


@given(st.integers(0, 2**32 - 1), st.sampled_from([200, 201]))
def test_power_is_that_of_the_windowed_values(seed, n):
    values = np.random.default_rng(seed).normal(size=n)
    values -= values.mean()
    window = 0.5 - 0.5 * np.cos(2 * np.pi * np.arange(n) / n)
    a = amplitude_spectrum(values, 1.0).amplitudes
    edge = np.abs(np.fft.rfft(values * window)[0]) * 2 / window.sum()  # the windowed mean, which line 0 does not hold
    inner = np.sum(a[1:-1] ** 2) + (2 * a[-1] ** 2 if n % 2 == 0 else a[-1] ** 2)
    power = 0.5 * (inner + 0.5 * edge**2)
    # Parseval with sum w = n / 2 and sum w^2 = 3 n / 8, whose ratio n sum w^2 / (sum w)^2 is the noise bandwidth
    assert power == pytest.approx(NOISE_BANDWIDTH * np.sum((values * window) ** 2) / np.sum(window**2), rel=1e-9)


def test_two_sines_are_told_apart_by_size():
    t = np.arange(1000) * 1e-3
    found = amplitude_spectrum(3.0 * np.sin(2 * np.pi * 60 * t) + 0.5 * np.cos(2 * np.pi * 120 * t), 1e-3)
    assert found.amplitudes[60] == pytest.approx(3.0)
    assert found.amplitudes[120] == pytest.approx(0.5)


@pytest.mark.parametrize(("n", "interval"), [(3, 1.0), (10, 0.0)])
def test_what_cannot_be_analysed_is_refused(n, interval):
    with pytest.raises(ValueError, match="expected at least 4"):
        amplitude_spectrum(np.ones(n), interval)
