"""A batch is many single runs: the same numbers to the last bit, one failure stops no other, shapes must agree."""

import numpy as np
import pytest

from vvdp.base.errors import ParameterError
from vvdp.simulation import batch as batches
from vvdp.simulation.batch import simulate_batch
from vvdp.simulation.outcome import outcome
from vvdp.simulation.run import simulate
from vvdp.systems.summary import analytic_summary, simulated_summary, summary
from vvdp.systems.system import System, load_system

DUTIES = ("0.35", "0.5", "0.8")
# Backwards the pump pulls the inlet down; without air and with a tight check valve nothing holds its pressure up.
FAILING = ("operation.pump_speed=-1800 rpm", "oil.air_fraction=0", "check_valve.reverse_opening=0")


@pytest.fixture(scope="module")
def systems() -> list[System]:
    """Three cases of the shipped prototype, long enough for several PWM periods."""
    return [load_system("prototype", [f"operation.duty_ratio={duty}"], until="0.2 s") for duty in DUTIES]


def test_batch_equals_single_runs_to_the_last_bit(systems: list[System]) -> None:
    one = systems[0]
    run = simulate_batch(one.model, [s.case for s in systems], one.stepping, one.average_from)
    for row, system in enumerate(systems):
        alone = simulate(system.model, system.case, system.stepping)
        inside = alone.mark_times >= one.average_from
        assert np.array_equal(run.final[row], alone.final)
        assert np.array_equal(run.low[row], alone.low)
        assert np.array_equal(run.high[row], alone.high)
        assert run.marks[row] == inside.sum() >= 3
        times = alone.mark_times[inside]
        assert run.mark_times[row].tolist() == [times[0], times[(inside.sum() - 1) // 2], times[-1]]
        assert np.array_equal(run.first_marks[row], alone.mark_states[inside][0])
        assert np.array_equal(run.last_marks[row], alone.mark_states[inside][-1])
        counts = (run.steps[row], run.rejected[row], run.evaluations[row], run.samples[row], run.stiff[row])
        assert counts == (alone.steps, alone.rejected, alone.evaluations, alone.samples, alone.stiff)
        assert run.end[row] == alone.end
        assert run.digest == alone.digest
        found = run.outcome(row)
        assert found is not None
        in_batch, single = simulated_summary(found, system), summary(system, alone)
        in_batch |= analytic_summary(in_batch, system)
        assert in_batch.keys() == single.keys()
        assert {k for k in single if in_batch[k] != single[k]} <= {"wall_time_s"}


def test_the_number_of_cores_changes_no_number(systems: list[System]) -> None:
    one, cases = systems[0], [s.case for s in systems]
    with_one = simulate_batch(one.model, cases, one.stepping, one.average_from, cores=1)
    with_all = simulate_batch(one.model, cases, one.stepping, one.average_from)
    assert np.array_equal(with_one.final, with_all.final)
    with pytest.raises(ParameterError, match="4097 cores; expected 1 to"):
        simulate_batch(one.model, cases, one.stepping, one.average_from, cores=4097)


def test_more_marks_than_room_still_give_the_middle_one(systems: list[System], monkeypatch: pytest.MonkeyPatch) -> None:
    system = load_system("prototype", until="0.5 s")
    cases = [system.case, load_system("prototype", ["operation.duty_ratio=0.6"], until="0.5 s").case]
    roomy = simulate_batch(system.model, cases, system.stepping, 0.05)
    assert roomy.marks.min() > 16  # the least room there is
    monkeypatch.setattr(batches, "MARKS_MEMORY", 0)
    cramped = simulate_batch(system.model, cases, system.stepping, 0.05)
    for name in ("final", "marks", "mark_times", "first_marks", "last_marks", "evaluations"):
        assert np.array_equal(getattr(roomy, name), getattr(cramped, name)), name


def test_a_failing_case_is_reported_and_stops_no_other(systems: list[System]) -> None:
    bad, good = load_system("prototype", FAILING, until="0.2 s"), systems[1]
    run = simulate_batch(good.model, [good.case, bad.case, good.case], good.stepping, good.average_from)
    assert run.reasons[0] is run.reasons[2] is None
    assert run.reasons[1] is not None
    assert "cannot go on at t = 0.0" in run.reasons[1] and "supply.inlet_pressure" in run.reasons[1]
    assert run.outcome(1) is None
    assert np.isnan(run.mark_times[1]).all()
    assert np.array_equal(run.final[0], run.final[2])
    assert np.array_equal(run.final[0], simulate(good.model, good.case, good.stepping).final)


def test_a_case_without_two_marks_has_no_outcome(systems: list[System]) -> None:
    system = systems[0]
    run = simulate_batch(system.model, [system.case], system.stepping, 0.1999)
    assert run.reasons == (None,)
    assert run.outcome(0) is None
    alone = outcome(simulate(system.model, system.case, system.stepping), 0.1999)
    assert alone.window.periods == 0


def test_cases_of_other_shapes_are_refused_with_the_place(systems: list[System]) -> None:
    one = systems[0]
    stepped = load_system("prototype", ['operation.duty_ratio={step=["0.4","0.6"],at="50 ms"}'], until="0.12 s")
    message = r"case 1 is not of .* case 0: params\.supply\.operation\.axial_position\.start has 1 numbers against 0"
    with pytest.raises(ParameterError, match=message):
        simulate_batch(one.model, [one.case, stepped.case], one.stepping, 0.05)
    other = load_system("prototype-constant-load", until="0.12 s")
    with pytest.raises(ParameterError, match=r"params\.load\.pressure\.base has 1 numbers against none"):
        simulate_batch(one.model, [one.case, other.case], one.stepping, 0.05)
    with pytest.raises(ParameterError, match="at least one"):
        simulate_batch(one.model, [], one.stepping, 0.05)
