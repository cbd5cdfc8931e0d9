"""The learned volume of a chamber: one step by hand, the rate of the storage, bounds, and where nothing is learned."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vvdp.base.errors import ParameterError
from vvdp.control.chamber import ChamberReading, desired_pressure
from vvdp.control.dead_volume import LearnedVolume, VolumeLearning, volume_step
from vvdp.control.passivity import exact_feedforward
from vvdp.control.reference import Reference, reference_at_rest
from vvdp.control.storage import pressure_balance
from vvdp.fluid.mixture import compression_energy_per_volume, density_rise

MOVING = Reference(2e-3, 0.02, 1.0, 100.0)


def test_a_step_by_hand(drive, passive):
    """P_d1' = (0.5 kg 100 m/s^3 + 2594 N/m 0.02 m/s)/174 mm^2 = 585.5 kPa/s, for 1 ms, times 1e-5 m^3/Pa."""
    reading = ChamberReading(2e-3, 0.02, 13.5e5)
    desired = desired_pressure(MOVING, reading, passive, drive)
    rate = (50.0 + 2594.0 * 0.02) / 1.74e-4
    assert rate == pytest.approx(585.5e3, rel=1e-3)
    rise = density_rise(13.5e5, desired.pressure, drive.oil)
    memory, settings = LearnedVolume(60e-6, 1.0, 0.0), VolumeLearning(volume_gain=1e-5)
    found = volume_step(memory, 1.001, desired, 13.5e5, settings, drive)
    assert found.oil_volume - 60e-6 == pytest.approx(-1e-5 * rise * rate * 1e-3, rel=1e-6)
    assert volume_step(memory._replace(free_since=0.9), 1.001, desired, 13.5e5, settings, drive).oil_volume == 60e-6
    assert volume_step(memory, 1.001, desired, 13.5e5, VolumeLearning(), drive).oil_volume == 60e-6


@given(st.floats(-20e-6, 40e-6), st.floats(12e5, 16e5), st.floats(0.0, 0.05))
def test_a_wrong_volume_changes_the_rate_of_the_storage_by_what_is_learned_from(
    drive, passive, off, pressure, velocity
):
    """(p + W)(Q_d with V + off - Q_d) = off (e^g - 1) P_d', for any pressure: what V_0' takes out of off^2/(2 g)."""
    reading = ChamberReading(2e-3, velocity, pressure)
    desired = desired_pressure(MOVING, reading, passive, drive)
    wrong = reading._replace(position=reading.position + off / drive.area)
    flow = exact_feedforward(desired, wrong, drive)
    right = exact_feedforward(desired, reading, drive)
    more = (
        pressure_balance(flow, desired, reading, drive).supply - pressure_balance(right, desired, reading, drive).supply
    )
    p = pressure - desired.pressure
    effort = p + compression_energy_per_volume(pressure, desired.pressure, drive.oil)
    expected = off * density_rise(pressure, desired.pressure, drive.oil) * desired.rate
    assert more == pytest.approx(expected, rel=1e-6, abs=1e-9 * abs(effort * flow) + 1e-15)


def test_nothing_is_learned_at_rest_whatever_the_noise(drive, passive):
    memory, settings, random = (
        LearnedVolume(40e-6, 0.0, -1.0),
        VolumeLearning(volume_gain=1e-3),
        np.random.default_rng(3),
    )
    for k in range(200):
        reading = ChamberReading(2e-3 + 1e-5 * random.normal(), 0.01 * random.normal(), 13e5 + 1e4 * random.normal())
        desired = desired_pressure(reference_at_rest(2e-3), reading, passive, drive)
        memory = volume_step(memory, 1e-3 * k, desired, reading.pressure, settings, drive)
    assert memory.oil_volume == 40e-6


def test_bounds(drive, passive):
    settings = VolumeLearning(volume_gain=1e-3, lowest_volume=50e-6, highest_volume=70e-6)
    reading = ChamberReading(2e-3, 0.02, 20e5)
    desired = desired_pressure(MOVING, reading, passive, drive)
    found = volume_step(LearnedVolume(60e-6, 0.0, -1.0), 1.0, desired, 20e5, settings, drive)
    assert found.oil_volume == 50e-6
    with pytest.raises(ParameterError, match="lowest_volume"):
        VolumeLearning(lowest_volume=2e-3)
