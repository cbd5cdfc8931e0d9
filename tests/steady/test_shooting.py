"""Periodic states found by shooting: they come back, they are where a long run ends, and what has none says so."""

from dataclasses import replace

import numpy as np
import pytest

from vvdp.base.errors import ParameterError
from vvdp.evaluation.summary import simulated_summary
from vvdp.simulation.crew import Crew
from vvdp.simulation.outcome import outcome
from vvdp.simulation.run import simulate
from vvdp.simulation.values import as_value, flat
from vvdp.steady.shooting import DISTANCE, LIMIT, Guess, periodic_states
from vvdp.steady.steady_states import HELD, steady_states
from vvdp.steady.test_stand import SetPoint

LOAD = 80.0e5 + 101325.0


@pytest.fixture(scope="module")
def held(orifice_stand, source_stand):
    """A state of either bench at the same set point, and one with a driven spool."""
    here = orifice_stand.set_point._replace(load_pressure=LOAD, duty_ratio=0.4)
    orifice = steady_states([(orifice_stand, here), (orifice_stand.with_motor(90.0), here)])
    return {"orifice": orifice[0], "driven": orifice[1], "source": steady_states([(source_stand, here)])[0]}


@pytest.mark.parametrize("name", ["orifice", "driven", "source"])
def test_state_comes_back_again_and_again(held, name):
    """Ten periods on, at the stepping of the system: no state has moved by more than the distance that is allowed."""
    state = held[name]
    case = state.periodic.case
    run = simulate(state.stand.model, case, replace(state.stand.stepping, until=11.0 * state.periodic.period))
    assert run.mark_times.size >= 10
    first = as_value(case.state, run.mark_states[9])
    assert first.inlet == pytest.approx(case.state.inlet, rel=DISTANCE)
    assert first.spool.speed == pytest.approx(case.state.spool.speed, rel=1e-4)
    late = run.mark_times[run.mark_times > 0.5 * state.periodic.period]
    np.testing.assert_allclose(np.diff(late), state.periodic.period, rtol=2e-4)


@pytest.mark.parametrize("name", ["orifice", "driven", "source"])
def test_residual_is_as_stated(held, name):
    periodic = held[name].periodic
    assert periodic.residual <= LIMIT
    window = periodic.outcome.window
    moved = as_value(periodic.case.state, window.last - window.first)
    assert abs(moved.spool.speed) <= LIMIT * (1.0 + abs(periodic.case.state.spool.speed))
    assert moved.spool.angle == pytest.approx(2.0 * np.pi / 3.0)


@pytest.mark.parametrize("name", ["orifice", "driven", "source"])
def test_same_means_as_a_long_run(held, name):
    """Two simulated seconds from another start, means over the last: efficiency within 0.2 %."""
    state = held[name]
    case = state.periodic.case
    spool = case.state.spool
    shifted = replace(case, state=case.state._replace(spool=spool._replace(speed=0.93 * spool.speed)))
    run = simulate(state.stand.model, shifted, replace(state.stand.stepping, until=2.0, average_from=1.0))
    long, short = simulated_summary(outcome(run), state.stand.bench.system), state.summary
    assert short["efficiency"] == pytest.approx(long["efficiency"], rel=2e-3)
    assert short["pwm_frequency_Hz"] == pytest.approx(long["pwm_frequency_Hz"], rel=5e-4)
    assert short["mean_load_flow_m3_s"] == pytest.approx(long["mean_load_flow_m3_s"], rel=2e-3)
    assert short["trusted"]


def test_orifice_holds_the_pressure(held):
    for name in ("orifice", "driven"):
        pressure = held[name].summary["pressure_mean_load_line_Pa"]
        assert pressure == pytest.approx(80e5, rel=HELD)
    assert held["orifice"].area > 0.0
    assert np.isnan(held["source"].area)


def test_driven_spool_keeps_the_speed_of_its_motor(held):
    assert held["driven"].summary["pwm_frequency_Hz"] == pytest.approx(90.0, rel=5e-3)


def test_pressure_that_cannot_be_held_has_a_reason(orifice_stand):
    here = orifice_stand.set_point
    points = [here._replace(duty_ratio=0.02, load_pressure=100e5), here._replace(duty_ratio=0.5, load_pressure=LOAD)]
    nothing, something = steady_states([(orifice_stand, point) for point in points])
    assert "delivers nothing" in nothing.reason
    assert nothing.summary == {}
    assert something.reason is None


def test_refuses_a_period_that_is_none(source_stand):
    here = source_stand.set_point
    case = source_stand.case(here, source_stand.means(here))
    with pytest.raises(ParameterError, match="period: 0 ms must be greater than 0"):
        periodic_states(source_stand.model, [Guess(case, 0.0)], source_stand.stepping)


def test_case_without_a_mark_has_a_reason(source_stand):
    """A spool held by a motor at rest never passes a mark."""
    braked = source_stand.with_motor(70.0)
    here = SetPoint(0.5, LOAD, 188.5, 313.15)
    case = braked.case(here, braked.means(here))
    still = replace(case, params=braked.with_tables(operation={"spool_motor_speed": 0.0}).bench.params)
    assert flat(still.params).size == flat(case.params).size
    (found,) = periodic_states(braked.model, [Guess(still, 0.001)], braked.stepping)
    assert found.outcome is None
    assert found.reason is not None


def test_a_search_that_is_stopped_says_so(held):
    stand, before = held["orifice"].stand, held["orifice"].periodic
    guess, crew = Guess(before.case, before.period), Crew(stop=lambda: True)
    found = periodic_states(stand.model, [guess], stand.stepping, crew)
    assert found[0].outcome is None
    assert found[0].reason == "stopped in round 1, before the periodic state was found"
