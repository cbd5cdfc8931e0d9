"""Scenarios: numbers worked by hand, and truths that obey the torque balance."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from vvdp.base.errors import ParameterError
from vvdp.comparison.motion import Lag
from vvdp.comparison.scenarios import (
    LPM,
    commensurate_turns,
    drive,
    driving_flow,
    encoder_of,
    flow_step,
    scenarios,
)
from vvdp.sensing.encoder import edge_deviation
from vvdp.valve.torque import flow_damping, friction_coefficient, spool_inertia, stall_torque


def test_the_flow_step_by_hand():
    """At 40 lpm rho Q^2 R (1/A_in + 1/A_out,eff) = 876 (6.6667e-4)^2 0.0127 (27397 + 16181) = 0.21548 N m, against
    k_f + rho R^2 Q = 1.3347e-3 + 9.419e-5 = 1.42889e-3 N m s: 150.8 rad/s; J = 0.5 0.5 0.0127^2 = 4.0323e-5 kg m^2 over
    it: 28.22 ms. At 26.7 lpm 0.096007 over 1.39757e-3: 68.7 rad/s."""
    motion = flow_step(1.0)
    assert motion.after == pytest.approx(150.8, abs=0.05)
    assert motion.time_constant == pytest.approx(28.22e-3, rel=1e-3)
    assert motion.before == pytest.approx(68.7, abs=0.05)


def test_the_driving_flow_of_the_step_is_the_step():
    flow = driving_flow(flow_step(1.0), np.array([0.2, 0.999, 1.001, 1.03, 3.0]))
    assert flow / LPM == pytest.approx([26.7, 26.7, 40.0, 40.0, 40.0], rel=1e-9)


def test_the_driving_flow_drives_the_motion():
    """The torque balance integrated with that flow gives the speed back, here for the slow start."""
    valve, _, rho, mu, _ = drive()
    motion = Lag(0.0, 150.0, 0.1, 0.5)

    def rate(t, y):
        flow = driving_flow(motion, np.array([t]))[0]
        damping = friction_coefficient(mu, valve) + flow_damping(flow, rho, valve)
        return [(stall_torque(flow, rho, valve) - damping * y[0]) / spool_inertia(valve)]

    found = solve_ivp(rate, (0.1, 2.0), [0.0], rtol=1e-8, atol=1e-8, t_eval=[0.3, 1.0, 2.0])
    assert found.y[0] == pytest.approx(motion.speed(found.t), rel=1e-5)


def test_edges_scatter_as_published():
    """A triangle of +-0.75 ms at 25 Hz: 157.08 0.75e-3/sqrt(6) = 0.0481 rad."""
    assert edge_deviation(encoder_of(8)) == pytest.approx(0.0481, abs=1e-4)


@pytest.mark.parametrize("sectors", [4, 16, 60])
def test_other_wheels_have_the_same_shape(sectors):
    encoder = encoder_of(sectors)
    assert edge_deviation(encoder) == pytest.approx(edge_deviation(encoder_of(8)) * 8 / sectors)


def test_scenarios_have_names_of_their_own():
    found = scenarios()
    assert len({each.name for each in found}) == len(found) >= 12
    assert all(each.until > each.scored_from + 1.0 for each in found)


def test_a_wheel_that_cannot_be_is_refused():
    with pytest.raises(ParameterError, match="7 sectors"):
        scenarios(7)


@pytest.mark.parametrize(("sectors", "rate"), [(8, 1000.0), (8, 1100.0), (60, 1e4), (2, 44100.0), (60, 1000.0)])
def test_in_step_means_whole_samples(sectors, rate):
    """8 sectors at 1 kHz: 5 samples at 25 turns a second; at 1.1 kHz round(5.5) = 6 samples at 22.92."""
    turns = commensurate_turns(sectors, rate)
    samples = rate / (turns * sectors)
    assert samples == pytest.approx(max(1, round(samples)))
    assert abs(samples - rate / (25.0 * sectors)) <= 0.5 or round(samples) == 1
