"""Means begin at an instant on which a step ends: they are those of the circuit, not of its record."""

from dataclasses import replace

import numpy as np
import pytest
from tests.invariance.circuits import CIRCUITS, changes, drawn, found, numbers, varied

from vvdp.evaluation.summary import simulated_summary
from vvdp.simulation.batch import simulate_batch
from vvdp.simulation.outcome import averaging_window
from vvdp.simulation.run import Stepping, simulate

BETWEEN = 0.25037
"""A start of means that is neither a recorded time nor a sample [s]."""


@pytest.mark.parametrize("name", CIRCUITS)
def test_no_number_depends_on_the_recording_interval(name):
    fine = numbers(name, record_interval=1e-3)
    assert (fine["averaged_from_s"], fine["averaged_to_s"], fine["averaged_periods"]) == (0.25, 0.9, 0.0)
    for interval in (0.1, 0.7):
        assert numbers(name, record_interval=interval) == pytest.approx(fine, rel=1e-9, abs=1e-15), interval


@pytest.mark.parametrize("name", CIRCUITS)
def test_the_means_are_those_from_the_very_state_at_their_start(name):
    """A run that ends there has the same state to the last bit."""
    system = drawn(name, *varied(name, 1), f"run.average_from={BETWEEN} s")
    whole = simulate(system.model, system.case, system.stepping)
    until = simulate(system.model, system.case, replace(system.stepping, until=BETWEEN, average_from=None))
    assert whole.span_times[0] == averaging_window(whole).begin == BETWEEN
    assert np.array_equal(whole.span_states[0], until.final)
    assert found(system, whole) == numbers(name, *varied(name, 1), average_from=BETWEEN, record_interval=0.7)


@pytest.mark.parametrize("name", CIRCUITS)
def test_means_from_a_sample_on_cost_no_step(name):
    """The run is then to the last bit the one from which no means are wanted, spans included."""
    system = drawn(name)
    one = simulate(system.model, system.case, system.stepping)
    other = simulate(system.model, system.case, replace(system.stepping, average_from=None))
    assert one.span_times.size == 4 and other.span_times.size == 0
    assert np.array_equal(one.final, other.final) and one.steps == other.steps


@pytest.mark.parametrize("name", CIRCUITS)
def test_a_batch_has_the_means_of_its_single_runs(name):
    """To the last bit where each case runs alone, within the tolerance in lanes."""
    systems = [drawn(name, *varied(name, seed)) for seed in range(3)]
    one = systems[0]
    stepping = replace(one.stepping, average_from=BETWEEN)
    alone = [found(each, simulate(each.model, each.case, stepping)) for each in systems]
    cases = [each.case for each in systems]
    for lanes in (False, True):
        batch = simulate_batch(one.model, cases, stepping, lanes=lanes)
        for row, system in enumerate(systems):
            in_batch = simulated_summary(batch.outcome(row), system)
            del in_batch["wall_time_s"]
            if not batch.lanes[row]:
                assert in_batch == alone[row]
            assert not changes(name, alone[row], in_batch, 3e-5)


def test_spans_are_whole_samples_of_equal_length():
    times = Stepping(until=2.0, average_from=0.25).span_times
    assert times.tolist() == [0.25, 0.251, 0.834, 1.417]
    assert Stepping(until=2.0, average_from=0.25, sample_period=1.0).span_times == pytest.approx(
        0.25 + 1.75 * np.arange(3)[[0, 0, 1, 2]] / 3.0
    )
    assert Stepping(until=2.0).span_times.size == 0


def test_means_of_a_run_that_ends_before_their_start_are_over_its_second_half():
    stepping = Stepping(until=2.0, average_from=3.0)
    assert stepping.means_from(2.0) == stepping.span_times[0] == 1.0
    assert stepping.means_from(4.0) == 3.0


def test_a_run_stopped_before_the_start_of_its_means_has_them_over_all_it_reached():
    system = drawn("charging")
    run = simulate(
        system.model, system.case, system.stepping, stop=lambda: True, portion=2000.0,
    )  # fmt: skip
    assert 0.0 < run.end < 0.25
    window = averaging_window(run)
    assert (window.begin, window.end, window.settled) == (0.0, run.end, False)
    assert np.array_equal(window.first, run.initial)


def test_a_run_stopped_after_the_start_of_its_means_has_them_from_there_and_does_not_call_itself_settled():
    """The same run to its end does: at rest, whatever part of its last third were missing."""
    still = ("components.valve.command=1", "components.pump.flow=12 lpm", "run.until=6 s", "run.average_from=5 s")
    system = drawn("charging", *still)
    run = simulate(system.model, system.case, system.stepping)
    assert averaging_window(run).settled
    window = averaging_window(replace(run, finished=False))
    assert (window.begin, window.settled) == (5.0, False)
