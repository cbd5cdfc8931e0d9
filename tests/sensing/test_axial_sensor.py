"""The axial optical sensor: calibration, pollution that repeats with the turn, noise, faults."""

from dataclasses import replace

import numpy as np
import pytest

from vvdp.base.errors import ParameterError
from vvdp.sensing.axial_sensor import (
    AxialSensor,
    LightCurve,
    Pollution,
    SpoolPlace,
    axial_sensor_start,
    axial_sensor_step,
    calibrate,
    calibrated_position,
    light_at,
    pollution_at,
    recorded_pollution,
    seen_position,
)
from vvdp.sensing.instrument import ideal_instrument

ROWS = (-0.01, 0.0, 0.01, 0.02, 0.03)
CURVE = LightCurve(positions=ROWS, light=(0.96, 0.76, 0.56, 0.36, 0.16))
BENT = LightCurve(positions=ROWS, light=(0.96, 0.70, 0.52, 0.40, 0.32))
"""Less steep the further the spool is away."""
POLLUTION = Pollution(scale=1e-3 / 1.6, amplitudes=(1.0, 0.55, 0.30, 0.15, 0.08), phases=(0.3, 1.1, -0.7, 2.0, 0.5))
CLEAN = Pollution(scale=0.0, amplitudes=(), phases=())
TURN = np.linspace(0.0, 2.0 * np.pi, 360, endpoint=False)


def sensor(**changes):
    found = AxialSensor(
        curve=CURVE, calibration=CURVE, near=POLLUTION, far=POLLUTION, instrument=ideal_instrument(0.0, 1.0)
    )
    return replace(found, **changes)


def readings(positions, angles, settings, period=1e-3):
    memory, found = axial_sensor_start(settings), []
    for i, (x, angle) in enumerate(zip(positions, angles, strict=True)):
        memory, reading = axial_sensor_step(memory, SpoolPlace(i * period, float(x), float(angle)), settings)
        found.append(reading)
    return found


def test_without_pollution_the_position_is_told_exactly():
    places = np.linspace(-0.006, 0.026, 50)
    for curve in (CURVE, BENT):
        told = readings(places, 0.0 * places, sensor(curve=curve, calibration=curve, near=CLEAN, far=CLEAN))
        assert [r.position for r in told] == pytest.approx(list(places), abs=1e-15)


def test_pollution_by_hand_and_the_same_in_every_turn():
    """At angle 0: 0.625 mm (sin 0.3 + 0.55 sin 1.1 - 0.3 sin 0.7 + 0.15 sin 2 + 0.08 sin 0.5) = 0.4794 mm."""
    assert pollution_at(0.0, POLLUTION) == pytest.approx(0.4794e-3, abs=1e-7)
    for angle in (0.1, 2.3, 5.9):
        for turns in (1.0, -3.0, 1000.0):
            assert pollution_at(angle + 2.0 * np.pi * turns, POLLUTION) == pytest.approx(
                pollution_at(angle, POLLUTION), abs=1e-14
            )
    wave = [pollution_at(angle, POLLUTION) for angle in TURN]
    assert np.mean(wave) == pytest.approx(0.0, abs=1e-18)
    rms = 1e-3 / 1.6 * np.sqrt(0.5 * sum(a * a for a in POLLUTION.amplitudes))
    assert np.sqrt(np.mean(np.square(wave))) == pytest.approx(rms, rel=1e-12)


def test_mean_over_a_turn_is_the_calibration():
    """Of a straight light curve the pollution leaves the mean alone; the calibration then tells the position."""
    places = np.array([-0.005, 0.005, 0.015, 0.025])
    light = np.array([[light_at(seen_position(x, a, sensor()), CURVE) for a in TURN] for x in places])
    found = calibrate(places, light)
    assert found.light == pytest.approx([light_at(x, CURVE) for x in places], abs=1e-15)
    assert calibrated_position(light_at(0.0123, CURVE), found) == pytest.approx(0.0123, abs=1e-15)


@pytest.mark.parametrize(
    ("light", "told"),
    [
        ((0.9, 0.5, 0.6, 0.3, 0.1), "row 3, 0.6 after 0.5, must keep to the direction from 0.9 to 0.1"),
        ((0.1, 0.3, 0.3, 0.5, 0.9), "row 3, 0.3 after 0.3"),
        ((0.5, 0.5, 0.5, 0.5, 0.5), "row 2, 0.5 after 0.5"),
    ],
)
def test_calibration_that_is_not_monotone_is_refused_with_its_row(light, told):
    with pytest.raises(ParameterError, match=told):
        LightCurve(positions=ROWS, light=light)
    with pytest.raises(ParameterError, match=told):
        calibrate(np.array(ROWS), np.array(light)[:, None])


def test_noise_has_its_deviation_and_is_white():
    """20 um at 20 per metre of slope; 4000 samples tell the deviation to 1.1 % and a correlation to 0.016."""
    noisy = sensor(near=CLEAN, far=CLEAN, instrument=replace(ideal_instrument(0.0, 1.0), noise=20e-6 * 20.0, seed=7.0))
    told = np.array([r.position for r in readings(np.full(4000, 5e-3), np.zeros(4000), noisy)]) - 5e-3
    assert np.std(told) == pytest.approx(20e-6, rel=0.04)
    assert abs(np.mean(told)) < 4.0 * 20e-6 / np.sqrt(4000)
    assert abs(np.corrcoef(told[1:], told[:-1])[0, 1]) < 0.06
    again = [r.position - 5e-3 for r in readings(np.full(10, 5e-3), np.zeros(10), noisy)]
    assert again == pytest.approx(list(told[:10]), abs=0.0)


def test_amplitude_and_shape_go_over_from_one_end_to_the_other():
    other = Pollution(scale=0.2e-3, amplitudes=(0.0, 1.0), phases=(0.0, 0.4))
    settings = sensor(far=other)
    for angle in (0.0, 1.0, 4.0):
        near, far = pollution_at(angle, POLLUTION), pollution_at(angle, other)
        assert seen_position(ROWS[0], angle, settings) - ROWS[0] == pytest.approx(near, abs=1e-16)
        assert seen_position(ROWS[-1], angle, settings) - ROWS[-1] == pytest.approx(far, abs=1e-16)
        assert seen_position(0.01, angle, settings) - 0.01 == pytest.approx(0.5 * (near + far), abs=1e-16)


def test_a_recorded_turn_is_repeated():
    """From a turn against a hard stop, Fig. 4.2: its harmonics give it back; too short a record is refused."""
    record = np.array([pollution_at(angle, POLLUTION) for angle in TURN])
    found = recorded_pollution(record + 3e-3, 5)
    assert [pollution_at(a, found) for a in TURN] == pytest.approx(list(record), abs=1e-17)
    with pytest.raises(ParameterError, match="5 harmonics of 10 samples"):
        recorded_pollution(record[:10], 5)


def test_faults_freeze_darken_and_bias_the_signal():
    faulty = replace(
        ideal_instrument(0.0, 1.0), freeze_begin=0.002, freeze_end=0.004, dropout_begin=0.006, dropout_end=0.008
    )
    places = np.linspace(0.0, 9e-3, 10)
    told = readings(places, np.zeros(10), sensor(near=CLEAN, far=CLEAN, instrument=faulty))
    frozen, dark = told[1].position, told[6]
    assert [r.position for r in told[2:4]] == [frozen, frozen]
    assert told[4].position == pytest.approx(4e-3)
    assert dark.light == 0.0
    assert dark.position == ROWS[-1]
    assert told[8].position == pytest.approx(8e-3)
    biased = sensor(near=CLEAN, far=CLEAN, instrument=replace(ideal_instrument(0.0, 1.0), offset=-0.002))
    assert readings([5e-3], [0.0], biased)[0].position == pytest.approx(5.1e-3)
