"""What an optimum rests on: its numbers at the ends of ranges against the design in a system with another value."""

import pytest
from tests.words import wording

from vvdp.design.optimise import optimise
from vvdp.design.optimum_ranges import known_quantities, optimum_ranges, ranges_in_words
from vvdp.design.problem import problem
from vvdp.design.tolerance import WORDS
from vvdp.systems.system import load_system

NAME = "prototype-constant-load"
BOUNDS = ("spool_radius = 12.7 mm", "outlet_area = 46.8 mm^2", "radial_clearance = 12.7 um")


@pytest.fixture(scope="module")
def found():
    return optimise(problem(load_system(NAME), "loss_total", ("pwm_frequency >= 60 Hz",), BOUNDS), starts=1)


@pytest.mark.parametrize(("setting", "end", "place"), [("helix_length", "26 mm", 1), ("outlet_radius", "12.06 mm", 0)])
def test_an_end_is_the_design_in_a_system_with_that_value(found, setting, end, place):
    ranges = optimum_ranges(found)
    row = [each.setting for each in ranges.rows].index(f"valve.{setting}")
    other = problem(load_system(NAME, [f"valve.{setting}={end}"]), "loss_total", (), BOUNDS)
    (there,) = other.evaluate(found.values)
    for key, name in (
        ("loss_total_W", "loss_total"),
        ("efficiency", "efficiency"),
        ("pwm_frequency_Hz", "pwm_frequency"),
    ):
        assert ranges.ends[key][row][place] == pytest.approx(float(getattr(there, name)), rel=1e-9)


def test_ranges_hold_the_optimum_and_leave_its_variables_out(found):
    ranges = optimum_ranges(found)
    assert ranges.nominal["loss_total_W"] == pytest.approx(found.objective)
    for key in ranges.nominal:
        low, high = ranges.span(key)
        assert low <= ranges.nominal[key] <= high
    varied = {f"valve.{name}" for name in found.values}
    assert varied.isdisjoint(row.setting for row in ranges.rows)
    assert list(ranges.left_out) == []
    assert set(known_quantities(ranges)) == set(ranges.nominal)


def test_what_it_rests_on_is_said(found):
    low, high = optimum_ranges(found).span("loss_total_W")
    words = ranges_in_words(optimum_ranges(found))
    assert wording.design.loss_range.format(low=f"{low:.4g} W", high=f"{high:.4g} W") in words
    assert WORDS["pwm_frequency"][1] in words
