"""Means over one period of the PWM: lines are told exactly, harmonics of the window vanish, the ring is bounded."""

import numpy as np
import pytest

from vvdp.estimation.period_average import LONGEST, average_start, average_step, pwm_window


def last_mean(samples, window):
    """The mean after a row of samples of one signal."""
    memory, means = average_start(1), np.empty(1)
    for value in samples:
        memory, means = average_step(memory, np.array([value]), window)
    return float(means[0])


def test_window_by_hand():
    """62 Hz with three sections, 1 kHz: 1000/62 = 16.129 samples; either way of turning; bounded when it stands."""
    speed = 2.0 * np.pi * 62.0 / 3.0
    assert pwm_window(speed, 3.0, 1e-3) == pytest.approx(16.129, rel=1e-4)
    assert pwm_window(-speed, 3.0, 1e-3) == pwm_window(speed, 3.0, 1e-3)
    assert pwm_window(0.0, 3.0, 1e-3) == LONGEST


def test_mean_by_hand():
    """Window 1.5 over 1, 2, 4: (2 + 4)/2 and half an interval from 2 to 1.5, 0.5 1.75: (3 + 0.875)/1.5."""
    assert last_mean([9.0, 1.0, 2.0, 4.0], 1.5) == pytest.approx(3.875 / 1.5)


@pytest.mark.parametrize("window", [1.0, 1.01, 13.7, 16.129, 63.999, 64.0])
def test_a_ramp_is_told_half_a_window_late(window):
    assert last_mean(0.5 * np.arange(200.0), window) == pytest.approx(0.5 * (199.0 - window / 2.0), rel=1e-12)
    assert last_mean(np.full(200, 3.0), window) == pytest.approx(3.0, rel=1e-14)


def test_ripple_of_the_period_vanishes():
    """Whole samples: to rounding. 14.3 samples: what the last, fractional line leaves, below 1e-3 of the amplitude."""
    k = np.arange(500)
    assert abs(last_mean(np.sin(2.0 * np.pi * k / 14.0 + 0.3), 14.0)) < 1e-14
    rest = [abs(last_mean(np.sin(2.0 * np.pi * k / 14.3 + phase), 14.3)) for phase in np.linspace(0.0, 6.0, 9)]
    assert max(rest) < 1e-3
    whole = [abs(last_mean(np.sin(2.0 * np.pi * k / 14.3 + phase), 14.0)) for phase in np.linspace(0.0, 6.0, 9)]
    assert max(whole) > 1e-2


def test_before_the_window_is_full_the_mean_is_over_what_there_is():
    assert last_mean([5.0], 14.0) == 5.0
    assert last_mean([5.0, 7.0], 14.0) == pytest.approx(6.0)
    assert last_mean([5.0, 7.0, 9.0], 14.0) == pytest.approx(7.0)


def test_signals_do_not_mix_and_the_old_memory_is_left_alone():
    memory, _ = average_step(average_start(3), np.array([1.0, 2.0, 3.0]), 4.0)
    kept = memory.samples.copy()
    _, means = average_step(memory, np.array([3.0, 2.0, 1.0]), 4.0)
    assert means == pytest.approx([2.0, 2.0, 2.0])
    assert np.array_equal(memory.samples, kept)
