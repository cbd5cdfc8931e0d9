import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from vvdp.base.errors import ParameterError
from vvdp.hydraulics.switching_valve import (
    PortAreas,
    PulseTrain,
    SpoolState,
    SwitchingValve,
    port_areas,
    pulse_edge,
    pulse_stop,
    pulse_train,
    pulse_value,
    spool_ends,
    spool_rate,
)


def switching_valve(**changed):
    values = {"natural_frequency": 200.0, "damping_ratio": 0.7, "stroke": 4e-3, "lap": 1e-3, "full_area": 2e-5}
    return SwitchingValve(**(values | changed))


def response(valve, damping_limit=0.02):
    def rates(_, y):
        spool = SpoolState(y[0], y[1])
        held = float(y[0] >= valve.stroke and y[1] > 0.0)
        return spool_rate(1.0, spool, held, 0.0, valve)

    return solve_ivp(rates, (0.0, damping_limit), [0.0, 0.0], rtol=1e-9, atol=1e-13, max_step=2e-5)


def test_areas_by_hand():
    valve = switching_valve()
    # centre 2 mm, ports part at 3 and 1 mm
    assert port_areas(3.5e-3, valve) == pytest.approx((1e-5, 0.0), rel=1e-12)
    assert port_areas(0.25e-3, valve) == pytest.approx((0.0, 1.5e-5), rel=1e-12)
    assert port_areas(2e-3, valve) == PortAreas(0.0, 0.0)
    under = switching_valve(lap=-1e-3)
    # 1 mm of 3 mm open at the centre, either way
    assert port_areas(2e-3, under) == pytest.approx((2e-5 / 3.0, 2e-5 / 3.0), rel=1e-12)


def test_the_textbook_valve_opens_over_its_whole_stroke():
    """Lap of minus half the stroke: the areas are in proportion to the position, and together always the full one."""
    valve = switching_valve(lap=-2e-3)
    for x in np.linspace(0.0, 4e-3, 9):
        assert port_areas(x, valve) == pytest.approx((2e-5 * x / 4e-3, 2e-5 * (1.0 - x / 4e-3)), rel=1e-12, abs=1e-20)


@given(x=st.floats(-1e-3, 5e-3), lap=st.floats(-1.9e-3, 1.9e-3))
def test_areas_mirror_about_the_centre(x, lap):
    valve = switching_valve(lap=lap)
    here, there = port_areas(x, valve), port_areas(valve.stroke - x, valve)
    assert here.first == pytest.approx(there.second, abs=1e-16)
    assert 0.0 <= here.first <= valve.full_area
    if lap > 0.0:
        assert here.first * here.second == 0.0


def test_critically_damped_spool_follows_the_closed_form():
    valve = switching_valve(damping_ratio=1.0)
    omega = 2.0 * np.pi * 200.0
    run = response(valve, 4e-3)
    exact = 4e-3 * (1.0 - (1.0 + omega * run.t) * np.exp(-omega * run.t))
    np.testing.assert_allclose(run.y[0], exact, atol=1e-8 * 4e-3)


def test_the_end_of_the_stroke_takes_an_underdamped_spool():
    run = response(switching_valve(damping_ratio=0.2))
    x, v = run.y
    assert x.max() < 4e-3 * (1.0 + 1e-4)  # without the stop the overshoot would be 53 %
    assert abs(v[-1]) < 1e-4 * v.max()
    assert x[-1] == pytest.approx(4e-3, rel=1e-3)


def test_a_spool_beyond_its_stop_by_rounding_rests():
    """Nothing pulls it inward while its command is that end: it would else leave, come back, and knock for ever."""
    valve = SwitchingValve(natural_frequency=500.0, stroke=1e-3, full_area=1e-5)
    assert tuple(spool_rate(0.0, SpoolState(-3e-13, 0.0), 0.0, 1.0, valve)) == (0.0, 0.0)
    assert tuple(spool_rate(1.0, SpoolState(1e-3 + 3e-13, 0.0), 1.0, 0.0, valve)) == (0.0, 0.0)
    assert spool_rate(1.0, SpoolState(-3e-13, 0.0), 0.0, 1.0, valve).velocity > 0.0


def test_a_spool_at_its_stop_leaves_when_called():
    valve, rest = switching_valve(), SpoolState(4e-3, 0.0)
    away = spool_rate(0.0, rest, 1.0, 0.0, valve)
    assert away.position == 0.0 and away.velocity == pytest.approx(-((400.0 * np.pi) ** 2) * 4e-3, rel=1e-13)
    assert spool_rate(0.0, SpoolState(4e-3, -0.1), 0.0, 0.0, valve).position == -0.1
    # An end holds what comes to it, and lets go of what turns back; on the way nothing does.
    assert spool_ends(SpoolState(4e-3, 0.1), 0.0, 0.0, valve).first >= 1.0
    assert spool_ends(SpoolState(4e-3, 0.1), 1.0, 0.0, valve).first >= 1.0
    assert spool_ends(SpoolState(4e-3, -0.1), 1.0, 0.0, valve).first < 1.0
    assert spool_ends(SpoolState(0.0, -0.1), 0.0, 0.0, valve).second >= 1.0
    assert max(spool_ends(SpoolState(2e-3, 0.1), 0.0, 0.0, valve)) < 1.0


@pytest.mark.sampled(4)
@pytest.mark.parametrize("frequency", [62.0, 72.0, 71.3, 100.0 / 3.0, 10.0 * np.pi, 1000.0, 0.7])
@pytest.mark.parametrize("duty", [0.5, 0.1, 1.0 / 3.0, 0.999, 1e-3])
def test_edges_are_exact(frequency, duty):
    """Edge k is at float(k/f) and float((k + d)/f), and the value there is the one after it."""
    train = PulseTrain(frequency=frequency, duty_ratio=duty)
    t = 0.0
    for k in range(1500):
        assert t == k / frequency
        assert pulse_train(t, train) == 1.0
        assert pulse_train(np.nextafter(t, -np.inf), train) == 0.0
        fall = pulse_stop(t, train)
        assert fall == (k + duty) / frequency > t
        assert pulse_stop(np.nextafter(t, -np.inf), train) == t
        assert pulse_train(fall, train) == 0.0
        assert pulse_train(np.nextafter(fall, -np.inf), train) == 1.0
        t = pulse_stop(fall, train)
        assert t > fall


@given(t=st.floats(0.0, 1e4), frequency=st.floats(0.01, 1e4), duty=st.floats(0.0, 1.0))
def test_the_value_lasts_until_the_next_edge(t, frequency, duty):
    train = PulseTrain(frequency=frequency, duty_ratio=duty)
    stop = pulse_stop(t, train)
    assert stop > t
    before = t + 1.0 / frequency if stop == np.inf else np.nextafter(stop, -np.inf)
    assert pulse_train(before, train) == pulse_train(t, train)


def test_always_on_and_always_off():
    for duty in (0.0, 1.0):
        train = PulseTrain(frequency=72.0, duty_ratio=duty)
        times = [t for k in range(2000) for t in (k / 72.0, np.nextafter(k / 72.0, -np.inf), (k + 0.5) / 72.0)]
        assert {pulse_train(t, train) for t in times} == {duty}
        assert pulse_stop(0.3, train) == np.inf


@given(t=st.floats(0.0, 1e3), frequency=st.floats(0.01, 1e4), duty=st.floats(0.0, 1.0))
def test_a_duty_ratio_as_an_input_is_that_of_a_train(t, frequency, duty):
    train = PulseTrain(frequency=frequency, duty_ratio=duty)
    assert pulse_value(t, duty, frequency) == pulse_train(t, train)
    assert pulse_edge(t, duty, frequency) == pulse_stop(t, train)


def test_a_duty_ratio_beyond_its_range_is_held():
    for duty, value in ((-0.3, 0.0), (1.4, 1.0)):
        assert pulse_value(0.123, duty, 72.0) == value
        assert pulse_edge(0.123, duty, 72.0) == np.inf


def test_a_duty_ratio_that_changes_acts_at_once():
    # at 10 Hz, 30 ms into a period: off with 0.2; with 0.5 on until 50 ms
    assert pulse_value(0.03, 0.2, 10.0) == 0.0
    assert pulse_value(0.03, 0.5, 10.0) == 1.0
    assert pulse_edge(0.03, 0.2, 10.0) == 0.1
    assert pulse_edge(0.03, 0.5, 10.0) == 0.05


def test_contradictions_are_refused():
    for changed in ({"natural_frequency": 0.0}, {"stroke": 0.0}, {"lap": 2e-3}, {"lap": -2.001e-3}):
        with pytest.raises(ParameterError, match=next(iter(changed))):
            switching_valve(**changed)
    with pytest.raises(ParameterError, match="frequency"):
        PulseTrain(frequency=0.0, duty_ratio=0.5)
