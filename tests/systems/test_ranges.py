"""Ranges of values: what a run comes to at their ends, from system files, against runs made one by one."""

import numpy as np
import pytest
from tests.words import wording

from vvdp.evaluation.range_display import value_words
from vvdp.evaluation.ranges import at_end, at_ends, range_text
from vvdp.runs import ranges as ranges_of_runs
from vvdp.runs.ranges import expected_evaluations, headline, kept_ranges, run_ranges, with_ranges
from vvdp.runs.result import run_result
from vvdp.runs.simulate import run_system
from vvdp.systems.system import load_system

BENCH = "prototype-constant-load"


def run_with(*settings, name=BENCH, until=None):
    return run_system(load_system(name, settings, until))


def lag(value, low, high):
    """Settings of a relief valve with 10 bar of override whose opening time lies in a range."""
    return (
        "relief_valve.override_pressure=10 bar",
        f'relief_valve.opening_time={{value="{value}", range=["{low}", "{high}"]}}',
    )


@pytest.fixture(scope="module")
def plain_run():
    return run_with()


@pytest.fixture(scope="module")
def ranges(plain_run):
    found = run_ranges(plain_run)
    assert found is not None
    return found


def test_each_end_is_the_run_that_a_setting_gives(ranges):
    """Lanes against a run by itself, to the tolerance."""
    place = [row.setting for row in ranges.rows].index("valve.lap_ratio")
    alone = run_with("valve.lap_ratio=0.5")
    for key in ranges.nominal:
        assert ranges.ends[key][place][0] == pytest.approx(alone.number(key), rel=1e-5)


def test_ranges_hold_the_number_itself(ranges, plain_run):
    assert set(ranges.nominal) == {"efficiency", "pwm_frequency_Hz", "pressure_max_inlet_Pa", "loss_total_W"}
    for key, value in ranges.nominal.items():
        low, high = ranges.span(key)
        assert low <= value == plain_run.number(key) <= high
        assert ranges.moves(key)


def test_what_grows_with_a_value_grows_over_its_range(ranges):
    """A longer helix shortens the transitions in parts of the period, a lap blocks less, a gap brakes less."""
    at = {row.setting: place for place, row in enumerate(ranges.rows)}
    for setting, key, sign in (
        ("valve.helix_length", "efficiency", 1.0),
        ("valve.lap_ratio", "efficiency", -1.0),
        ("valve.radial_clearance", "pwm_frequency_Hz", 1.0),
        ("oil.viscosity_40", "pwm_frequency_Hz", -1.0),
        ("valve.jet_exponent", "pwm_frequency_Hz", 1.0),
        ("relief_valve.override_pressure", "pressure_max_inlet_Pa", 1.0),
    ):
        low, high = ranges.ends[key][at[setting]]
        assert sign * (high - low) > 0.0, setting


def test_the_relief_valve_decides():
    """Values found by an independent program: 10 bar of override, opening times of 0, 1, 5, 15 ms."""
    first, slow = run_with(*lag("1 ms", "0 ms", "15 ms")), run_with(*lag("5 ms", "4.9 ms", "5 ms"))
    found = run_ranges(first)
    assert found is not None
    place = [row.setting for row in found.rows].index("relief_valve.opening_time")
    for key, expected, within in (
        ("efficiency", (0.616, 0.585, 0.434, 0.398), 0.002),
        ("pwm_frequency_Hz", (62.7, 55.7, 40.8, 35.7), 0.3),
        ("pressure_max_inlet_Pa", (130e5, 183e5, 239e5, 288e5), 1e5),
    ):
        at_once, slowest = found.ends[key][place]
        assert (at_once, first.number(key), slow.number(key), slowest) == pytest.approx(expected, abs=within), key
    assert found.span("efficiency")[0] == found.ends["efficiency"][place][1]


def test_a_run_keeps_its_ranges_and_shows_them(plain_run, ranges):
    assert kept_ranges(plain_run) is None
    run = with_ranges(plain_run, ranges)
    again = kept_ranges(run)
    assert again is not None
    assert [row.setting for row in again.rows] == [row.setting for row in ranges.rows]
    for key, ends in ranges.ends.items():
        assert np.array_equal(again.ends[key], ends)
    result = run_result(run)
    assert [each.title for each in result.sections].count(wording.report.rests_on) == 1
    assert result.charts["rests-on"].panels
    assert result.tables["ranges"].rows == len(ranges.rows)
    first = result.listings["spans"].rows[0]
    assert first.values[-1] == wording.systems.lap_range.format(low=0.5, high=1.2)
    assert "rests-on" not in run_result(plain_run).charts


def test_an_end_that_contradicts_other_values_is_left_out_with_its_reason():
    """An ideal relief valve has no opening time."""
    setting = 'relief_valve.opening_time={value="0 ms", range=["0 ms", "15 ms"]}'
    run = run_with(setting, until="0.2 s")
    found = run_ranges(run)
    assert found is not None
    reason = "15 ms " + wording.files.must_be_zero_if.format(key="override_pressure")
    assert reason in found.left_out["relief_valve.opening_time"]
    place = [row.setting for row in found.rows].index("relief_valve.opening_time")
    low, high = found.ends["efficiency"][place]
    assert low == pytest.approx(run.number("efficiency"), rel=1e-5)
    assert np.isnan(high)
    assert np.isfinite(found.span("efficiency")).all()


def test_a_value_is_called_what_a_person_calls_it():
    named = {row.setting: value_words(row) for row in load_system("prototype").rows}
    assert named["oil.viscosity_40"] == wording.systems.viscosity
    assert named["relief_valve.opening_time"] == wording.systems.opening_time


def test_a_value_that_somebody_sets_has_no_range():
    """What is given is not assumed."""
    system = load_system(BENCH, ["valve.lap_ratio=0.8"])
    assert "valve.lap_ratio" not in {row.setting for row in system.uncertainties}
    assert len(load_system(BENCH).uncertainties) == len(system.uncertainties) + 1


def test_any_circuit_has_ranges_of_pressures():
    """A drawn circuit: the mean pressure behind a tube falls with the diameter of the tube."""
    run = run_with('components.tube.diameter={value="5 mm", range=["4.5 mm", "5.5 mm"]}', name="buck-converter")
    (row,) = run.system.uncertainties
    assert (row.setting, range_text(row)) == ("components.tube.diameter", "4.5 mm to 5.5 mm")
    found = run_ranges(run)
    assert found is not None
    assert all(key.startswith("pressure_") for key in headline(run))
    low, high = found.ends["pressure_mean_node_Pa"][0]
    assert low != high
    assert expected_evaluations(run) == 2.0 * run.number("evaluations")


def test_ends_of_a_signal_that_does_not_change():
    system = load_system(BENCH, ['load.pressure={value="100 bar", range=["90 bar", "110 bar"]}'])
    row = next(row for row in system.uncertainties if row.setting == "load.pressure")
    assert at_end(system, row, 1).case.params.load_line_pressure.base == pytest.approx(110e5 + 101325.0)
    assert len(list(at_ends(system))) == 2 * len(system.uncertainties)


def test_who_stops_the_runs_gets_no_ranges(plain_run):
    assert run_ranges(plain_run, stop=lambda: True) is None


@pytest.mark.parametrize("step", ["at_ends", "simulated_summary"])
def test_an_interrupt_between_the_runs_leaves_the_run(plain_run, monkeypatch, step):
    def interrupt(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(ranges_of_runs, step, interrupt)
    assert run_ranges(plain_run) is None


def test_a_system_without_ranges_has_none():
    run = run_with(name="buck-converter", until="0.05 s")
    found = run_ranges(run)
    assert found is not None
    assert found.rows == ()
    assert "rests-on" not in run_result(with_ranges(run, found)).charts
