"""Ripple of the load line: exact harmonics, what it hangs on, the estimate, and where there is none."""

import numpy as np
import pytest
from tests.words import wording

from vvdp.base.errors import ParameterError
from vvdp.evaluation.load_ripple import estimated_ripple
from vvdp.rigs.ripple import line_capacity, power_of, ripple
from vvdp.steady.waveform import harmonics


@pytest.fixture(scope="module")
def found(orifice_stand):
    return ripple(orifice_stand, [0.3, 0.5, 0.8], [30.0, 60.0, 120.0], [0.5, 1.0, 4.0])


def test_harmonics_of_a_known_wave():
    """1 + 3 sin(x) + 0.5 cos(4 x): amplitudes 3, 0, 0, 0.5; no leakage, whatever the number of samples."""
    x = 2.0 * np.pi * np.arange(100) / 100
    np.testing.assert_allclose(
        harmonics(1.0 + 3.0 * np.sin(x) + 0.5 * np.cos(4.0 * x), 5), [3.0, 0.0, 0.0, 0.5, 0.0], atol=1e-12
    )


def test_harmonics_give_the_root_mean_square(found):
    """Parseval: half the squares of all harmonics are the variance; twenty of them hold all but 1e-4 of it."""
    amplitudes = found.tables["spectrum"]["load_pressure_Pa"]
    rms = found.numbers["load_ripple_rms_Pa"].value
    assert np.sqrt(0.5 * np.sum(amplitudes**2)) == pytest.approx(rms, rel=1e-4)


def test_estimate_by_hand():
    """20 of 40 lpm, 50 Hz, 1 cc per bar: 3.333e-4 * 0.5 / (50 * 1e-11) = 3.333 bar."""
    assert estimated_ripple(20e-3 / 60, 40e-3 / 60, 50.0, 1e-11) == pytest.approx(3.3333e5, rel=1e-4)


def test_capacity_of_a_line_without_gas(orifice_stand):
    """0.4 l over the modulus and 0.4 l times the hose's compliance, at 100 bar; beta there is 1.39 GPa within 2 %."""
    rigid = orifice_stand.with_tables(load_line={"gas_volume": 0.0})
    expected = 0.4e-3 / 1.39e9 + 0.4e-3 * 3e-10
    assert line_capacity(101e5, rigid) == pytest.approx(expected, rel=0.05)


def test_ripple_is_as_estimated(found):
    """The estimate has pulses with upright flanks and a load that takes evenly: 15 % above 12 cm^3 of gas."""
    for name in ("duty", "frequency", "accumulator"):
        table = found.tables[name]
        assert np.all(table["remark"] == "")
        np.testing.assert_allclose(table["load_ripple_Pa"], table["estimated_ripple_Pa"], rtol=0.15)


def test_ripple_goes_down_with_frequency_and_volume(found):
    """wang2017, chapter 1: the faster the switching, the smaller the ripple. 1/f exactly for linear filling."""
    frequency = found.tables["frequency"]
    assert np.all(np.diff(frequency["load_ripple_Pa"]) < 0.0)
    assert found.numbers["frequency_exponent"].value == pytest.approx(-1.0, abs=0.04)
    assert np.all(np.diff(found.tables["accumulator"]["load_ripple_Pa"]) < 0.0)
    assert -1.0 < found.numbers["gas_volume_exponent"].value < -0.7


def test_mean_pressure_is_held(found):
    for name in ("duty", "frequency", "accumulator"):
        np.testing.assert_allclose(found.tables[name]["pressure_mean_load_line_Pa"], 100e5, rtol=1.1e-3)


def test_source_has_no_ripple(source_stand):
    with pytest.raises(ParameterError, match=wording.rig.load_pressure_held):
        ripple(source_stand)


def test_power_of_a_law():
    assert power_of(np.array([1.0, 2.0, 4.0]), np.array([3.0, 12.0, 48.0])) == pytest.approx(2.0)
    assert np.isnan(power_of(np.array([1.0]), np.array([1.0])))
