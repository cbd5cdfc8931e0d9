"""The gain of a flow map, told by continuity."""

import numpy as np
import pytest

from vvdp.base.errors import ParameterError
from vvdp.control.flow_gain import FlowBalance, FlowGain, FlowGainMemory, flow_gain_start, flow_gain_step

SETTINGS = FlowGain(filter_rate=10.0, gain_rate=2.0, lowest=0.4, highest=1.3, least_flow=1e-5, settling_time=0.2)
CAPACITY = 3e-11
H = 1e-3


def learn(true_gain: float, seconds: float, rests: float = 1.0, ripple: float = 0.0) -> FlowGainMemory:
    """A piston whose speed swings, so that the pressure has to take up what it does not."""
    memory, pressure = flow_gain_start(), 20e5
    for k in range(int(seconds / H)):
        mapped = 1.2e-4
        swept = true_gain * mapped * (1.0 + 0.3 * np.sin(2.0 * np.pi * 1.3 * k * H))
        pressure += H * (true_gain * mapped - swept) / CAPACITY
        shown = pressure + ripple * np.sin(2.0 * np.pi * 72.0 * k * H)
        memory = flow_gain_step(memory, FlowBalance(mapped, swept, shown, CAPACITY, rests), H, SETTINGS)
    return memory


@pytest.mark.parametrize("true_gain", [0.6, 1.0, 1.2])
def test_a_gain_is_learned_though_the_pressure_swings(true_gain: float) -> None:
    assert learn(true_gain, 6.0).gain == pytest.approx(true_gain, rel=0.005)


def test_ripple_of_the_pressure_leaves_it_alone() -> None:
    # 0.2 bar at 72 Hz is a C w 0.2e5 = 2.7e-4 m^3/s of rippling flow, twice the mean
    assert learn(0.7, 6.0, ripple=0.2e5).gain == pytest.approx(0.7, rel=0.02)


def test_it_follows_as_its_rate_says() -> None:
    # with mapped 12 times least_flow the normalised slope is 1/(1 + 1/144): a first-order rate of 1.986 1/s,
    # from 0.2 s and the fading of the filter on
    memory = flow_gain_start()
    for _ in range(1200):
        memory = flow_gain_step(memory, FlowBalance(1.2e-4, 0.6e-4, 20e5, CAPACITY, 1.0), H, SETTINGS)
    assert memory.gain == pytest.approx(0.5 + 0.5 * np.exp(-1.986 * 1.0), rel=2e-3)


def test_it_stays_within_its_bounds() -> None:
    assert learn(0.1, 6.0).gain == 0.4


def test_it_rests_while_the_valve_moves() -> None:
    assert learn(0.6, 2.0, rests=0.0).gain == 1.0


def test_bounds_that_leave_out_the_map_itself_are_refused() -> None:
    with pytest.raises(ParameterError, match=r"1 must lie between lowest, 0\.4, and highest, 0\.9"):
        FlowGain(filter_rate=10.0, gain_rate=1.0, lowest=0.4, highest=0.9, least_flow=1e-5, settling_time=0.2)
