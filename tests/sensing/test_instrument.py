import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.compiled import compiled

from vvdp.base.errors import ParameterError
from vvdp.sensing.instrument import (
    Instrument,
    ideal_instrument,
    instrument_start,
    instrument_step,
    lagged_value,
)

IDEAL = ideal_instrument(-10.0, 10.0)


def changed(**values) -> Instrument:
    return dataclasses.replace(IDEAL, **values)


def readings(settings, times, values):
    memory, shown = instrument_start(settings), []
    for t, value in zip(times, values, strict=True):
        memory, reading = instrument_step(memory, t, value, settings)
        shown.append(reading)
    return np.array(shown), memory


def test_an_ideal_instrument_shows_what_is_there():
    values = np.linspace(-9.0, 9.0, 7)
    shown, memory = readings(IDEAL, np.arange(7.0), values)
    assert np.array_equal(shown, values)
    assert memory.saturated == 0.0


def test_offset_resolution_and_range_by_hand():
    # 1.12 + 0.2 = 1.32, nearest multiple of 0.5: 1.5; 1.04 + 0.2 = 1.24 -> 1.0; 9.9 + 0.2 = 10.1 -> 10; 12 -> 10
    shown, memory = readings(changed(offset=0.2, resolution=0.5), range(4), (1.12, 1.04, 9.9, 12.0))
    assert shown.tolist() == [1.5, 1.0, 10.0, 10.0]
    assert memory.saturated == 1.0  # 10.1 was rounded into the range, 12 was cut
    shown, memory = readings(IDEAL, range(3), (-11.0, 0.0, -10.0))
    assert shown.tolist() == [-10.0, 0.0, -10.0]
    assert memory.saturated == 1.0


def test_lag_by_hand():
    # rest at 0, then a ramp of 1 per second: y = t - tau (1 - e^(-t/tau))
    e = np.exp(-1.0 / 0.5)
    assert lagged_value(0.0, 0.0, 1.0, 1.0, 0.5) == pytest.approx(1.0 - 0.5 * (1.0 - e), rel=1e-14)
    # a constant value of 1 from 0 on: 1 - e^(-h/tau)
    assert lagged_value(0.0, 1.0, 1.0, 1.0, 0.5) == pytest.approx(1.0 - e, rel=1e-14)
    assert lagged_value(0.3, 0.0, 1.0, 1.0, 0.0) == 1.0
    assert lagged_value(0.3, 0.0, 1.0, 0.0, 0.5) == 0.3


@given(st.lists(st.floats(1e-6, 1.0), min_size=1, max_size=10), st.floats(1e-3, 10.0))
def test_a_straight_line_is_followed_the_same_whatever_the_samples(steps, lag):
    times = np.concatenate([[0.0], np.cumsum(steps)])
    shown, _ = readings(changed(lag=lag), times, 0.5 * times + 0.1)
    T = times[-1]
    once, _ = readings(changed(lag=lag), (0.0, T), (0.1, 0.5 * T + 0.1))
    assert shown[-1] == pytest.approx(once[-1], rel=1e-9, abs=1e-9)


def test_a_long_period_against_the_lag_stays_stable():
    shown, _ = readings(changed(lag=1e-6), np.arange(5.0), (0.0, 1.0, 1.0, 1.0, 1.0))
    assert shown == pytest.approx([0.0, 1.0, 1.0, 1.0, 1.0], abs=1e-5)


def test_noise_has_its_deviation_and_comes_back_with_the_seed():
    settings = changed(noise=0.1, seed=7.0)
    times = np.arange(20000.0)
    shown, _ = readings(settings, times, np.ones(times.size))
    assert shown.mean() == pytest.approx(1.0, abs=4.0 * 0.1 / np.sqrt(times.size))
    assert shown.std() == pytest.approx(0.1, rel=0.02)
    assert abs(np.corrcoef(shown[1:], shown[:-1])[0, 1]) < 0.03
    again, _ = readings(settings, times[:10], np.ones(10))
    assert np.array_equal(again, shown[:10])
    other, _ = readings(changed(noise=0.1, seed=8.0), times[:10], np.ones(10))
    assert not np.any(other == shown[:10])


def test_rounding_adds_a_twelfth_of_its_square():
    shown, _ = readings(changed(noise=0.1, resolution=0.1), np.arange(20000.0), np.full(20000, 0.37))
    assert shown.var() == pytest.approx(0.1**2 * (1.0 + 1.0 / 12.0), rel=0.04)


def test_a_frozen_instrument_goes_on_rightly_afterwards():
    times = np.arange(6.0)
    shown, memory = readings(changed(freeze_begin=2.0, freeze_end=4.0, lag=0.3), times, times)
    healthy, _ = readings(changed(lag=0.3), times, times)
    assert shown[2] == shown[3] == shown[1]
    assert np.array_equal(shown[[0, 1, 4, 5]], healthy[[0, 1, 4, 5]])
    assert memory.saturated == 0.0


def test_a_dropout_lies_at_the_lower_end():
    shown, memory = readings(changed(dropout_begin=1.0, dropout_end=2.0), np.arange(3.0), (5.0, 5.0, 5.0))
    assert shown.tolist() == [5.0, -10.0, 5.0]
    assert memory.saturated == 0.0


def test_contradictions_are_refused():
    for name, value in (
        ("range_low", 10.0), ("resolution", 21.0), ("resolution", -1.0), ("noise", -1.0),
    ):  # fmt: skip
        with pytest.raises(ParameterError, match=name):
            changed(**{name: value})
    for fault in ("freeze", "dropout"):
        with pytest.raises(ParameterError, match=f"{fault}_end"):
            changed(**{f"{fault}_begin": 2.0, f"{fault}_end": 1.0})


def test_compiled_steps_are_the_same():
    settings = changed(noise=0.1, resolution=0.01, lag=0.5, offset=0.1, seed=3.0)
    one = two = instrument_start(settings)
    fast = compiled(instrument_step, one, 0.0, 0.0, settings)
    for t in np.arange(0.0, 5.0, 0.25).tolist():
        one, a = instrument_step(one, t, np.sin(t), settings)
        two, b = fast(two, t, np.sin(t), settings)
        assert b == pytest.approx(a, rel=1e-14, abs=1e-14)
