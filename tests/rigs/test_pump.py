"""The VVDP as a controlled pump: what is read from its maps, and the whole test."""

import os
import signal
from dataclasses import replace

import numpy as np
import pytest
from tests.words import wording

from vvdp.base.errors import ParameterError
from vvdp.rigs import maps
from vvdp.rigs.map_axes import Axes
from vvdp.rigs.maps import simulated_map
from vvdp.rigs.pump import PumpTest, control_numbers, dead_band, linearity, pump, pump_axes
from vvdp.studies import work


def test_dead_band_of_a_known_curve():
    """0 up to 0.1, then 10 per unit; 1 % of 9 is 0.09, reached at 0.1 + 0.009."""
    duty = np.array([0.0, 0.05, 0.1, 0.5, 1.0])
    assert dead_band(duty, np.array([0.0, 0.0, 0.0, 4.0, 9.0])) == pytest.approx(0.109)
    assert np.isnan(dead_band(duty, np.array([1.0, 2.0, 3.0, 4.0, 5.0])))


def test_linearity_of_a_known_curve():
    """y = x^2 on 0, 1/2, 1: line x - 1/12; distances 1/12, -1/6, 1/12 over a span of 1."""
    gain, apart = linearity(np.array([0.0, 0.5, 1.0]), np.array([0.0, 0.25, 1.0]))
    assert gain == pytest.approx(1.0)
    assert apart == pytest.approx(1.0 / 6.0)


@pytest.mark.thorough
def test_whole_test_and_going_on(source_stand, tmp_path):
    axes = replace(
        pump_axes(source_stand), duty_ratios=(0.04, 0.1, 0.4, 0.6, 0.8), pump_speeds=(188.49555921538757,),
        load_pressures=(41e5, 81e5),
    )  # fmt: skip
    found = pump(source_stand, tmp_path, PumpTest(axes))
    assert set(found.tables) == {"steady", "step_up", "step_down", "frequency"}
    assert found.tables["steady"].rows == 10
    assert found.finished
    n = {key: number.value for key, number in found.numbers.items()}
    # The load port is open for the share d, but never wide below kappa = 0.3: almost nothing up to 0.08.
    assert 0.04 < n["dead_band_duty_ratio"] < 0.1
    assert n["linearity_error"] < 0.005
    assert n["flow_gain_lowest_m3_s"] == pytest.approx(40e-3 / 60.0, rel=0.02)
    assert 0.0 < n["flow_loss_per_pressure_m3_s_Pa"] * 40e5 < 0.03 * 40e-3 / 60.0
    assert {"iso17559", "iso4409", "iso8426"} == set(found.references)
    assert "ISO 17559" in found.manner
    again = pump(source_stand, tmp_path, PumpTest(axes))
    np.testing.assert_array_equal(again.tables["steady"]["delivered_flow_m3_s"],
                                  found.tables["steady"]["delivered_flow_m3_s"])  # fmt: skip


def test_interrupted_test_leaves_out_the_dynamics(source_stand, tmp_path, monkeypatch):
    monkeypatch.setattr(maps, "BATCHING", work.Batching(least=2, seconds=0.0))
    axes = replace(pump_axes(source_stand), duty_ratios=(0.4, 0.6), load_pressures=(41e5,))
    part = pump(
        source_stand,
        tmp_path,
        PumpTest(axes),
        progress=lambda done, total: done == 2 and os.kill(os.getpid(), signal.SIGINT),
    )
    assert not part.finished
    assert set(part.tables) == {"steady"}


def test_bad_step_is_refused_before_the_map(source_stand):
    with pytest.raises(ParameterError, match=wording.rig.two_duty_ratios.format(begin=0.4, end=1.4)):
        PumpTest(pump_axes(source_stand), (0.4, 1.4))


def test_numbers_of_a_map_without_results_are_missing(source_stand, tmp_path):
    nothing = simulated_map(source_stand, Axes((0.01, 0.02), (110e5,), (188.5,), (313.15,)), tmp_path)
    assert set(nothing.reasons) == {wording.rig.delivers_nothing}
    assert control_numbers(nothing) == {}
