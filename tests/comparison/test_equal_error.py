"""Circuits at one tracking error: the search in closed form, and rows that are equal within 5 %."""

from math import hypot

import pytest

from vvdp.base.errors import ParameterError
from vvdp.comparison.circuit_result import circuit_result, errors_in_mm
from vvdp.comparison.circuit_trials import compare_circuits
from vvdp.comparison.equal_error import (
    FASTEST,
    MOST_TRIES,
    Attempt,
    attempts,
    closest,
    common_error,
    is_reached,
    next_rate,
    rms_speed,
)
from vvdp.control.duty_cycle import DutyCycle
from vvdp.machines.duties import HEAVY, shipped_duties
from vvdp.results.result import Grade
from vvdp.rivals.rival_circuits import CIRCUITS

DUTY = next(each for each in shipped_duties() if each.name == "heavy")
QUICK = [each for each in CIRCUITS if each.name in ("throttle", "ideal-pump", "four-valves")]


def lagging(own, speed=0.1, sought=None):
    """A circuit that adds its own error to what a delay beyond that of 25 1/s adds: e^2 = own^2 + (V D)^2."""

    def run(rate):
        if sought is not None:
            sought.append(rate)
        return Attempt(rate, hypot(own, speed * (4.0 / rate - 0.16)), 100.0)

    return run


def test_the_first_try_is_exact_for_an_error_that_a_delay_adds_to():
    """3 mm of its own, 5 mm wanted: 4 mm by 0.1 m/s times 40 ms, so L = 200 ms and w = 20 1/s."""
    sought = []
    run = lagging(3e-3, sought=sought)
    tried = attempts(run, run(25.0), 5e-3, 0.1)
    assert sought == [25.0, 20.0] and tried[-1].error == pytest.approx(5e-3, rel=1e-9)


def test_an_error_that_goes_otherwise_is_enclosed():
    """Twice the speed that was taken for granted: the first try is too far, the next ones lie between."""
    run = lagging(1e-3, speed=0.2)
    tried = attempts(run, run(25.0), 5e-3, 0.1)
    assert 3 <= len(tried) <= MOST_TRIES and is_reached(tried[-1].error, 5e-3)
    assert closest(tried, 5e-3) == len(tried) - 1


def test_an_error_below_what_a_circuit_has_is_tried_with_earlier_references():
    lead = attempts(lambda rate: Attempt(rate, 0.05 / rate, 1.0), Attempt(25.0, 2e-3, 1.0), 1e-3, 0.1)
    assert is_reached(lead[-1].error, 1e-3) and lead[-1].filter_rate > 25.0


def test_a_jump_is_enclosed_by_delays_and_not_by_errors():
    """The error wavers by 0.25 mm around the one wanted: the closest delays on either side are halved further."""
    delays = [0.16, 0.18, 0.20, 0.22]
    errors = [1e-3, 2.9e-3, 2.85e-3, 4e-3]
    tried = [Attempt(4.0 / delay, error, 1.0) for delay, error in zip(delays, errors, strict=True)]
    assert 0.20 < 4.0 / next_rate(tried, 3e-3, 0.1) < 0.22


def test_a_common_error_has_three_digits():
    assert [common_error([each]) for each in (3.0301e-3, 3.03e-3, 6.675e-4, 0.02)] == [3.04e-3, 3.03e-3, 6.68e-4, 0.02]


def test_the_common_error_of_circuits_without_error_is_zero_and_reached():
    assert common_error([0.0, 0.0]) == 0.0 and is_reached(0.0, common_error([0.0]))


def test_a_circuit_that_cannot_is_tried_up_to_the_fastest_poles():
    tried = attempts(lambda rate: Attempt(rate, 2e-3, 1.0), Attempt(25.0, 2e-3, 1.0), 1e-3, 0.01)
    assert tried[-1].filter_rate == FASTEST and not is_reached(tried[closest(tried, 1e-3)].error, 1e-3)


def test_a_run_that_breaks_off_ends_the_search():
    assert attempts(lambda rate: None, Attempt(25.0, 1e-3, 1.0), 5e-3, 0.1) == [Attempt(25.0, 1e-3, 1.0)]


def test_rms_speed_of_a_cycle():
    """172.8 mm/s either way; 0.1 m/s for 1 s and 0.05 m/s for 2 s: root((0.01 + 2 0.0025)/3) = 70.7 mm/s."""
    assert rms_speed(HEAVY) == pytest.approx(0.1728, rel=1e-12)
    cycle = DutyCycle(times=(0.0, 1.0, 3.0), positions=(0.1, 0.2, 0.1), forces=(0.0,) * 3)
    assert rms_speed(cycle) == pytest.approx(0.0707107, rel=1e-5)


def test_delays_are_tried_between_bounds():
    assert next_rate([Attempt(25.0, 1e-3, 1.0)], 1.0, 0.1) == 5.0
    assert next_rate([Attempt(25.0, 1.0, 1.0)], 1e-3, 0.1) == FASTEST


@pytest.fixture(scope="module")
def found():
    return compare_circuits([DUTY], QUICK)


def test_all_rows_have_one_error(found):
    """That of the circuit that follows worst with the common reference; every run stands on the front."""
    errors = errors_in_mm(circuit_result(found))["error_rms_mm"]
    assert len(errors) == len(QUICK) and max(errors) <= 1.05 * min(errors)
    firsts = [run.tried[0] for run in found.found]
    assert {each.filter_rate for each in firsts} == {25.0}
    assert found.error == common_error([each.error for each in firsts]) == pytest.approx(6.68e-4, rel=1e-12)
    front = circuit_result(found).tables["front"]
    assert front.rows == sum(len(run.tried) for run in found.found) > len(QUICK)
    for run in found.found:
        kept = run.tried[run.kept]
        assert (kept.error, kept.power) == (run.score.tracking_rms, run.score.drawn - run.score.returned)


def test_a_circuit_that_follows_worse_is_named():
    result = circuit_result(compare_circuits([DUTY], QUICK[:1], error=1e-5))
    (told,) = [each.text for each in result.findings if each.grade is Grade.WARNING]
    assert told.startswith("throttle on heavy comes to an rms error of 0.") and "0.0100 mm of the others" in told


def test_no_error_is_refused():
    with pytest.raises(ParameterError, match="0 mm must be greater than 0"):
        compare_circuits([DUTY], QUICK, error=0.0)
