"""A batch is many single runs: without lanes the same numbers to the last bit, one failure stops no other, shapes must
agree."""

from dataclasses import replace

import numpy as np
import pytest

from vvdp.base.errors import ParameterError
from vvdp.base.signal import step, table
from vvdp.simulation import batch as batches
from vvdp.simulation.batch import simulate_batch
from vvdp.simulation.crew import Crew
from vvdp.simulation.layout import vectors
from vvdp.simulation.outcome import kept_marks, outcome
from vvdp.simulation.run import Stepping, simulate

REFERENCES = (8e5, 15e5, 20e5)
FROM = 0.05
STEPPING = Stepping(until=0.2, average_from=FROM)


@pytest.fixture(scope="module")
def cases(switching):
    """Three references, one of them with a tank pressure that changes in two steps: parameters of other lengths."""
    _, case = switching
    tanks = [{}, {}, {"tank_pressure": table([0.0, 0.1, 0.1, 0.2], [1e5, 1e5, 2e5, 1.5e5])}]
    return [case(reference, **tank) for reference, tank in zip(REFERENCES, tanks, strict=True)]


def test_batch_equals_single_runs_to_the_last_bit(switching, cases):
    model, _ = switching
    assert vectors(cases[0]).params.size < vectors(cases[2]).params.size
    run = simulate_batch(model, cases, STEPPING, lanes=False)
    for row, case in enumerate(cases):
        alone = simulate(model, case, STEPPING)
        inside = alone.mark_times >= FROM
        assert np.array_equal(run.final[row], alone.final)
        assert np.array_equal(run.final_commands[row], alone.reached.command)
        assert np.array_equal(run.final_memories[row], alone.reached.memory)
        assert np.array_equal(run.low[row], alone.low)
        assert np.array_equal(run.high[row], alone.high)
        assert run.marks[row] == inside.sum() >= 3
        times = alone.mark_times[inside]
        kept = kept_marks(inside.sum())
        assert np.array_equal(run.mark_times[row], times[kept])
        assert np.array_equal(run.mark_states[row], alone.mark_states[inside][kept])
        counts = (run.steps[row], run.rejected[row], run.evaluations[row], run.samples[row], run.stiff[row])
        assert counts == (alone.steps, alone.rejected, alone.evaluations, alone.samples, alone.stiff)
        assert run.end[row] == alone.end
        assert run.digest == alone.digest
        assert run.remarks[row] == alone.remarks
        one, other = run.outcome(row), outcome(alone)
        assert np.array_equal(one.window.first, other.window.first)
        assert (one.window.begin, one.window.end, one.remarks) == (other.window.begin, other.window.end, other.remarks)


def test_the_number_of_cores_changes_no_number(switching, cases):
    model, _ = switching
    with_one = simulate_batch(model, cases, STEPPING, Crew(1))
    with_all = simulate_batch(model, cases, STEPPING)
    assert np.array_equal(with_one.final, with_all.final)
    with pytest.raises(ParameterError, match="4097 cores; expected 1 to"):
        Crew(4097)


def test_more_marks_than_room_still_give_those_on_the_way(switching, cases, monkeypatch):
    model, _ = switching
    longer = replace(STEPPING, until=0.5)
    roomy = simulate_batch(model, cases, longer)
    assert roomy.marks.min() > 16  # the least room there is
    monkeypatch.setattr(batches, "MARKS_MEMORY", 0)
    cramped = simulate_batch(model, cases, longer)
    for name in ("final", "marks", "mark_times", "mark_states", "evaluations", "final_memories"):
        assert np.array_equal(getattr(roomy, name), getattr(cramped, name)), name


def test_a_failing_case_is_reported_and_stops_no_other(switching, cases):
    """A volume of nothing; and a start in bar."""
    model, case = switching
    good, bad = cases[1], case(inlet_volume=0.0)
    in_bar = replace(good, state=good.state._replace(load_pressure=15.0))
    run = simulate_batch(model, [good, bad, good, in_bar], STEPPING, lanes=False)
    assert run.reasons[0] is run.reasons[2] is None
    assert "cannot go on at t = 0 s" in run.reasons[1] and "inlet_pressure" in run.reasons[1]
    assert "state 'load_pressure' starts wrongly" in run.reasons[3] and "bar?" in run.reasons[3]
    assert run.outcome(1) is run.outcome(3) is None
    assert np.isnan(run.mark_times[1]).all()
    assert np.array_equal(run.final[0], run.final[2])
    assert np.array_equal(run.final[0], simulate(model, good, STEPPING).final)


def test_a_case_without_two_marks_has_means_over_the_plain_time(switching, cases):
    model, _ = switching
    late = replace(STEPPING, average_from=0.1999)
    one = simulate_batch(model, cases[:1], late, lanes=False).outcome(0).window
    alone = outcome(simulate(model, cases[0], late)).window
    assert one.periods == alone.periods == 0
    assert (one.begin, one.end, one.settled) == (0.1999, 0.2, alone.settled) == (alone.begin, alone.end, one.settled)
    assert np.array_equal(one.first, alone.first) and np.array_equal(one.last, alone.last)


def test_a_batch_from_which_no_means_are_wanted_has_no_outcome(switching, cases):
    model, _ = switching
    assert simulate_batch(model, cases[:1], Stepping(until=0.2)).outcome(0) is None


def test_cases_of_other_shapes_are_refused_with_the_place(switching, cases):
    model, case = switching
    stepped = case(tank_pressure=step(1e5, 2e5, 0.1))
    assert simulate_batch(model, [cases[0], stepped], STEPPING).reasons == (None, None)
    other = replace(cases[0], memory={**cases[0].memory, "display": cases[0].memory["controller"]})
    with pytest.raises(
        ParameterError, match=r"case 1 is not of .* case 0: memory\.display\.duty_ratio is a number against nothing"
    ):
        simulate_batch(model, [cases[0], other], STEPPING)
    with pytest.raises(ParameterError, match="at least one"):
        simulate_batch(model, [], STEPPING)
