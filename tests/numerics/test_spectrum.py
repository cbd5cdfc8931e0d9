"""The spectrum over whole periods reads sines as they are, has no side lines and loses no power."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vvdp.numerics.spectrum import line_spectrum


@given(st.integers(2, 60), st.floats(0.1, 100.0), st.floats(0.0, 6.0), st.sampled_from([128, 129]))
def test_a_sine_of_whole_periods_reads_its_amplitude_and_has_no_side_lines(cycles, amplitude, phase, n):
    interval = 1e-3
    found = line_spectrum(5.0 + amplitude * np.sin(2 * np.pi * cycles * np.arange(n) / n + phase), interval)
    assert found.frequencies[cycles] == pytest.approx(cycles / (n * interval))
    assert found.amplitudes[cycles] == pytest.approx(amplitude, rel=1e-10)
    assert found.amplitudes[0] == pytest.approx(5.0, rel=1e-9)
    beside = np.delete(found.amplitudes, [0, cycles])
    assert beside.max() < 1e-12 * (5.0 + amplitude)


@given(st.integers(0, 2**32 - 1), st.sampled_from([200, 201]))
def test_half_the_squares_sum_up_to_the_variance(seed, n):
    values = np.random.default_rng(seed).normal(size=n)
    a = line_spectrum(values, 1.0).amplitudes[1:]
    # Parseval; the line at half the sampling rate of an even count is a whole amplitude, not a pair
    power = 0.5 * np.sum(a**2) + (0.5 * a[-1] ** 2 if n % 2 == 0 else 0.0)
    assert power == pytest.approx(np.var(values), rel=1e-9)


def test_two_sines_are_told_apart_by_size():
    t = np.arange(1000) * 1e-3
    found = line_spectrum(3.0 * np.sin(2 * np.pi * 60 * t) + 0.5 * np.cos(2 * np.pi * 120 * t), 1e-3)
    assert found.amplitudes[60] == pytest.approx(3.0)
    assert found.amplitudes[120] == pytest.approx(0.5)


@pytest.mark.parametrize(("n", "interval"), [(3, 1.0), (10, 0.0)])
def test_what_cannot_be_analysed_is_refused(n, interval):
    with pytest.raises(ValueError, match="expected at least 4"):
        line_spectrum(np.ones(n), interval)
