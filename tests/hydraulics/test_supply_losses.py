"""What each way of supplying a load costs: numbers by hand, and the order in which they cannot but stand."""

import numpy as np
import pytest

from vvdp.hydraulics.supply_losses import bled_off_loss, drag_power, load_sensing_loss, metered_loss

LPM, BAR = 1e-3 / 60.0, 1e5
LEAKAGE = 2e-12


def test_throttling_by_hand():
    """40 lpm at 120 bar is 8 kW; of it 20 lpm at 100 bar, 3.333 kW, are used. Bled off: 20 lpm at 100 bar lost."""
    assert metered_loss(40 * LPM, 20 * LPM, 100 * BAR, 120 * BAR) == pytest.approx(8000.0 - 3333.33, abs=0.01)
    assert bled_off_loss(40 * LPM, 20 * LPM, 100 * BAR) == pytest.approx(3333.33, abs=0.01)


def test_load_sensing_by_hand():
    """20 bar at 30 lpm are 1 kW; 2e-12 (120e5)^2 = 288 W leak. Without margin, 200 W leak alone."""
    assert load_sensing_loss(30 * LPM, 100 * BAR, 120 * BAR, LEAKAGE) == pytest.approx(1288.0, abs=0.01)
    assert load_sensing_loss(30 * LPM, 100 * BAR, 100 * BAR, LEAKAGE) == pytest.approx(200.0, abs=1e-9)


def test_two_actuators_at_one_pump():
    """The lighter one pays for the heavier: 10 lpm from 120 down to 40 bar cost 1333 W more; leakage counts once."""
    heavier = load_sensing_loss(20 * LPM, 100 * BAR, 120 * BAR, LEAKAGE)
    lighter = load_sensing_loss(10 * LPM, 40 * BAR, 120 * BAR, 0.0)
    assert heavier + lighter == pytest.approx(20 * LPM * 20 * BAR + 288.0 + 4000.0 / 3.0, abs=0.01)


def test_drag_by_hand():
    """1 N m and 3 % of 100 bar times 3.6287e-6 m^3/rad, 36.287 N m, at 188.5 rad/s; either way round."""
    expected = 188.5 * (1.0 + 0.03 * 36.287)
    assert drag_power(100 * BAR, 188.5, 3.6287e-6, 1.0, 0.03) == pytest.approx(expected, rel=1e-9)
    assert drag_power(100 * BAR, -188.5, 3.6287e-6, 1.0, 0.03) == pytest.approx(expected, rel=1e-9)


def test_no_way_loses_less_than_the_one_with_less_to_hold():
    """Displacement control <= load sensing <= a held pressure <= metering, wherever the load stays below the setting;
    a fixed pump that is bled off loses no less than displacement control, and no more than a metered one."""
    rng = np.random.default_rng(3)
    for _ in range(200):
        relief = rng.uniform(60, 300) * BAR
        load = rng.uniform(0.0, 1.0) * (relief - 20 * BAR)
        pump = rng.uniform(20, 100) * LPM
        delivered = rng.uniform(0.0, 1.0) * (pump - LEAKAGE * relief)
        ways = [load_sensing_loss(delivered, load, held, LEAKAGE) for held in (load, load + 20 * BAR, relief)]
        ways.append(metered_loss(pump, delivered, load, relief))
        assert ways == sorted(ways)
        assert ways[0] <= bled_off_loss(pump, delivered, load) <= ways[-1]
