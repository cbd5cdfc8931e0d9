"""Which numbers of a case follow a value, and how the numbers of a run are summed up."""

import numpy as np
import pytest

from vvdp.base import kinds
from vvdp.evaluation.summary import simulated_summary
from vvdp.runs.simulate import run_system
from vvdp.simulation.layout import vectors
from vvdp.simulation.outcome import outcome
from vvdp.simulation.run import simulate
from vvdp.systems.changeable import OPERATIONS, changeable_values, conversion, operation_of
from vvdp.systems.system import load_system
from vvdp.web.numbers import Sum, judgement, summary_sums


@pytest.fixture(scope="module")
def system():
    return load_system("cylinder-stops", (), "0.5 s")


@pytest.fixture(scope="module")
def values(system):
    return {value.row.setting: value for value in changeable_values(system, lambda each: each.circuit.digest)}


def test_operation_is_found_by_its_bits():
    x = [0.9, 1.7, 3.3]
    assert operation_of(x, x) == ("+", 0.0)
    assert operation_of(x, [each * 0.1 for each in x]) == ("*", 0.1)
    assert operation_of(x, [3.0 / each for each in x]) == ("over", 3.0)
    assert operation_of(x, [each + 101325.0 for each in x]) == ("+", 101325.0)
    assert operation_of(x, [each**2 for each in x]) is None


def test_units_are_brought_to_si_as_files_are_read():
    assert conversion(kinds.DENSITY, "kg/m^3", (500.0, 876.0, 1000.0)) == (("*", 1.0),)
    level = conversion(kinds.PRESSURE_LEVEL, "bar", (0.0, 100.0, 350.0))
    assert level == (("*", 1e5), ("+", 101325.0))


def test_what_follows_a_value_is_what_the_case_has(system, values):
    value = values["oil.density"]
    assert not value.why_not
    before, other = (
        vectors(system.case),
        vectors(load_system("cylinder-stops", ['oil.density="870 kg/m^3"'], "0.5 s").case),
    )
    params = before.params.copy()
    for each in value.followers:
        assert each.vector == "params"
        params[each.place] = OPERATIONS[each.operation](870.0, each.constant)
    assert np.array_equal(params, other.params)
    assert not np.array_equal(params, before.params)


def test_a_value_that_changes_the_circuit_is_refused_with_the_reason(values):
    assert "changes the circuit itself" in values["components.pump.dead_volume"].why_not
    assert sum(not value.why_not for value in values.values()) > 40


def test_sums_are_the_summary(system):
    run = outcome(simulate(system.model, system.case, system.stepping))
    found, w = simulated_summary(run, system), run.window
    numbers = {"mean": (w.last - w.first) / (w.end - w.begin), "low": run.low, "high": run.high}
    sums = summary_sums(system)
    assert len(sums) > 30
    for key, (constant, *terms) in sums.items():
        value = constant + sum(factor * numbers[kind][place] for kind, place, factor in terms)
        assert value == pytest.approx(found[key], rel=1e-9, abs=1e-9), key


def test_a_sum_is_linear():
    one, two = Sum({("mean", 1): 2.0}), Sum({("mean", 1): 1.0, ("low", 0): 3.0}, 5.0)
    assert (one - two * 2.0 + 1.0).flat == [-9.0, ["mean", 1, 0.0], ["low", 0, -6.0]]


def test_bounds_of_laws_are_told_by_the_number_that_breaks_them(system):
    found = judgement(system, run_system(system).summary)["bounds"]
    lowest = [each for each in found if each["key"] == "pressure_min_pump_line_Pa"]
    assert [(each["least"], each["offset"]) for each in lowest] == [(3e4, 101325.0)]
    assert any(each["key"] == "position_max_rod_m" for each in found)
