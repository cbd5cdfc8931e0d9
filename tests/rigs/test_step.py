"""Step and frequency response of the delivered flow."""

import numpy as np
import pytest
from tests.words import wording

from vvdp.base.errors import ParameterError
from vvdp.rigs.response import _of_value, _of_volume, crossing_time, response_frequencies, settling_time
from vvdp.rigs.step import checked_steps, dynamics


def values(found):
    return {key: number.value for key, number in found.numbers.items()}


@pytest.fixture(scope="module")
def against_source(source_stand):
    return dynamics(source_stand, (0.4, 0.6), [2.0, 10.0, 25.0])


@pytest.fixture(scope="module")
def against_orifice(orifice_stand):
    return dynamics(orifice_stand, (0.4, 0.6), [1.0, 8.0])


def test_times_of_a_known_course():
    """1 - e^(-t/0.1): 63.2 % at 0.1 s, within 5 % after 0.1 ln 20 = 0.29957 s; steps of 1 ms."""
    t = np.arange(-0.1, 1.0, 1e-3)
    flow = np.where(t < 0.0, 0.0, 1.0 - np.exp(-t / 0.1))
    assert crossing_time(t, flow, 0.0, 1.0, 1.0 - np.exp(-1.0)) == pytest.approx(0.1, abs=1.1e-3)
    assert settling_time(t, flow, 0.0, 1.0) == pytest.approx(0.29957, abs=1.1e-3)
    assert np.isnan(crossing_time(t, flow, 0.0, 1.0, 1.5))


def test_amplitude_of_a_known_flow():
    """0.3 sin(2 pi 5 t + 0.4) with pulses at 63 Hz on top, from its integral and from itself."""
    t = np.arange(0.0, 1.0, 1e-4)
    w, pulse = 2.0 * np.pi * 5.0, 2.0 * np.pi * 63.0
    flow = 2.0 + 0.3 * np.sin(w * t + 0.4) + np.cos(pulse * t)
    volume = 2.0 * t - 0.3 / w * np.cos(w * t + 0.4) + np.sin(pulse * t) / pulse
    expected = 0.3 * np.exp(0.4j)
    for found in (_of_volume(t, volume, 0.2, 0.8, 5.0), _of_value(t, flow, 0.2, 0.8, 5.0)):
        assert found == pytest.approx(expected, abs=1e-4)


def test_flow_follows_within_a_period(against_source):
    """The mean over a period cannot be quicker than the period; with nothing but switching it is not slower either."""
    n = values(against_source)
    period = 1.0 / n["pwm_frequency_Hz"]
    for name in ("up", "down"):
        assert 0.3 * period < n[f"step_{name}_to_63_s"] < period
        assert n[f"step_{name}_settling_s"] < 1.1 * period


def test_flow_before_and_after_is_the_steady_one(against_source):
    n = values(against_source)
    assert n["step_up_flow_before_m3_s"] == pytest.approx(n["step_down_flow_after_m3_s"], rel=1e-3)
    assert n["step_up_flow_after_m3_s"] == pytest.approx(n["step_down_flow_before_m3_s"], rel=1e-3)
    # Between kappa and 1 - kappa the closed form has the gain Q, 40 lpm.
    assert n["static_gain_m3_s"] == pytest.approx(40e-3 / 60.0, rel=0.01)


def test_gain_is_flat_against_a_source(against_source):
    """Both edges move with the duty ratio, so the mean flow follows at once: gain 1, no phase, up to 0.45 f."""
    table = against_source.tables["frequency"]
    np.testing.assert_allclose(table["delivered_flow_gain"], 1.0, atol=0.01)
    np.testing.assert_allclose(table["delivered_flow_phase_rad"], 0.0, atol=0.05)
    assert "load_flow_gain" not in table.columns


def test_slow_switching_changes_nothing(source_stand):
    """At 4 Hz the mean over a period of 0.25 s is only there 0.25 s after the step, and 24 periods last 6 s: 3 whole
    cycles of 0.5 Hz, 11 of 1.75 Hz. The gain stays 1, the static one 40 lpm.
    """
    found = dynamics(source_stand.with_motor(4.0), (0.4, 0.6), [0.5, 1.75])
    assert values(found)["static_gain_m3_s"] == pytest.approx(40e-3 / 60.0, rel=0.01)
    np.testing.assert_allclose(found.tables["frequency"]["delivered_flow_gain"], 1.0, atol=0.01)
    # Flow turns the stiffly coupled spool some percent faster.
    assert found.tables["step_up"]["time_s"][-1] == pytest.approx(2.5 / values(found)["pwm_frequency_Hz"], rel=0.01)


def test_frequencies_go_up_from_the_lowest():
    """1 to 0.45 x 60 = 27 Hz; at 2 Hz 2 x 0.02 = 0.04 to 0.9 Hz; 0.1 over a line's 0.5 s are 0.2 Hz."""
    for pwm, lag, ends in ((60.0, 0.0, (1.0, 27.0)), (2.0, 0.0, (0.04, 0.9)), (60.0, 0.5, (0.2, 27.0))):
        found = response_frequencies(pwm, lag)
        assert (found[0], found[-1]) == pytest.approx(ends, rel=1e-9)
        assert np.all(np.diff(found) > 0.0)
        assert min(abs(f / pwm - 1.0 / 3.0) for f in found) > 1.0 / 36.0


def test_line_is_a_low_pass(against_orifice):
    """First order with the stated time constant: gain over the delivered flow's 1/sqrt(1 + (w tau)^2), within 15 %."""
    table, tau = against_orifice.tables["frequency"], values(against_orifice)["load_line_time_constant_s"]
    w = 2.0 * np.pi * table["frequency_Hz"]
    ratio = table["load_flow_gain"] / table["delivered_flow_gain"]
    np.testing.assert_allclose(ratio, 1.0 / np.sqrt(1.0 + (w * tau) ** 2), rtol=0.15)
    lag = table["load_flow_phase_rad"] - table["delivered_flow_phase_rad"]
    np.testing.assert_allclose(lag, -np.arctan(w * tau), atol=0.15)


def test_load_gets_what_is_delivered(against_orifice):
    """In tank volumes, long after the step."""
    table = against_orifice.tables["step_up"]
    late = table["time_s"] > 0.8 * table["time_s"][-1]
    delivered, load = (np.mean(table[name][late]) for name in ("delivered_flow_m3_s", "load_flow_m3_s"))
    assert load == pytest.approx(delivered, rel=5e-3)


@pytest.mark.parametrize(
    ("frequencies", "words"), [([0.0], "greater than 0 Hz"), ([40.0], wording.rig.half_pwm_frequency)]
)
def test_bad_frequencies_are_refused(source_stand, frequencies, words):
    with pytest.raises(ParameterError, match=words):
        dynamics(source_stand, (0.4, 0.6), frequencies)


def test_no_step_is_refused(source_stand):
    with pytest.raises(ParameterError, match=wording.rig.two_different):
        dynamics(source_stand, (0.4, 0.4))


def test_step_beyond_the_duty_ratios_is_refused(source_stand):
    with pytest.raises(ParameterError, match=wording.rig.two_duty_ratios.format(begin=0, end=1.5)):
        dynamics(source_stand, (0.0, 1.5))


def test_order_of_the_duty_ratios_does_not_matter(source_stand, against_source):
    """From 0.4 to 0.6 of 40 lpm is up, 8 lpm more, however it is said."""
    assert checked_steps((0.6, 0.4)) == (0.4, 0.6)
    turned = values(dynamics(source_stand, (0.6, 0.4), [10.0]))
    rise = turned["step_up_flow_after_m3_s"] - turned["step_up_flow_before_m3_s"]
    assert rise == pytest.approx(8e-3 / 60.0, rel=0.01)
    assert turned["step_up_to_63_s"] == values(against_source)["step_up_to_63_s"]


def test_static_gain_says_what_it_is_of(against_source, against_orifice):
    """Through the same orifice more flow meets more pressure: a fifth less than the 40 lpm at a constant pressure."""
    fixed, held = (next(f.text for f in each.findings if wording.rig.static_gain in f.text) for each in
                   (against_orifice, against_source))  # fmt: skip
    assert values(against_orifice)["static_gain_m3_s"] == pytest.approx(0.81 * 40e-3 / 60.0, rel=0.01)
    assert wording.rig.orifice_stays in fixed
    assert fixed.endswith(wording.rig.about_pump_flow.format(flow="40 lpm"))
    assert held.endswith(wording.rig.pressure_stays)
