"""A run leaves the interpreter free and can be stopped from outside; what was reached is as exact as ever."""

import threading
from concurrent.futures import ThreadPoolExecutor
from typing import Annotated, NamedTuple

import numpy as np
import pytest
from tests.words import wording

from vvdp.base.conservation import Nothing
from vvdp.base.errors import RunError
from vvdp.base.kinds import Kind
from vvdp.base.params import Params
from vvdp.simulation import batch as batches
from vvdp.simulation import places
from vvdp.simulation import run as runs
from vvdp.simulation.batch import simulate_batch
from vvdp.simulation.crew import Crew
from vvdp.simulation.link import link, quiet
from vvdp.simulation.loops import compiled_loop
from vvdp.simulation.model import Case, Model
from vvdp.simulation.prepare import prepare, start_run
from vvdp.simulation.run import PROMPT, UNHURRIED, Stepping, simulate

Plain = Annotated[float, Kind("plain number", "1", -1e9, 1e9, "1")]
SLOW, FAST = 1e-3, 1e4
"""Angular frequencies: one step and no end."""
ENDLESS = 1e3


class Turning(NamedTuple):
    x: Plain
    v: Plain


class Rate(Params):
    angular: Plain


def oscillator(t: float, s: Turning, u: Nothing, p: Rate) -> tuple[Turning, Nothing]:
    return Turning(p.angular * s.v, -p.angular * s.x), Nothing(0.0)


def damped(t: float, s: Turning, u: Nothing, p: Rate) -> tuple[Turning, Nothing]:
    return Turning(p.angular * s.v, -p.angular * (s.x + 0.1 * s.v)), Nothing(0.0)


def turning(angular: float) -> Case:
    return Case(Turning(0.0, 1.0), Rate(angular=angular))


def stepping(until: float, **others) -> Stepping:
    coarse = dict.fromkeys(("sample_period", "record_interval", "window_interval"), until)
    return Stepping(until=until, **coarse | others)


MODEL = Model(oscillator)


@pytest.mark.parametrize("portion", [50.0, 400.0])
def test_a_stopped_run_keeps_what_was_reached_to_the_last_bit(portion):
    """It is stopped in the fourth portion, and no more evaluations were made than these and the step at hand."""
    asked = iter([False, False, False, True])
    chosen = stepping(5.0, record_interval=1e-2)
    run = simulate(MODEL, turning(60.0), chosen, stop=lambda: next(asked), portion=portion)
    whole = simulate(MODEL, turning(60.0), chosen)
    assert whole.finished and not run.finished and 0.0 < run.end < whole.end
    assert 4.0 * portion <= run.evaluations <= 4.0 * (portion + 20.0)
    assert run.times[-1] <= run.end < run.times[-1] + 1e-2
    assert np.array_equal(run.states, whole.states[: run.times.size])
    go_on = simulate(MODEL, turning(60.0), chosen, continue_from=run)
    assert np.array_equal(go_on.final, whole.final)


def test_asking_changes_no_bit():
    chosen = stepping(5.0, record_interval=1e-2)
    watched = simulate(MODEL, turning(60.0), chosen, stop=lambda: False, progress=lambda _: None)
    alone = simulate(MODEL, turning(60.0), chosen, portion=1e12)
    assert watched.finished and watched.evaluations == alone.evaluations
    for name in ("states", "final", "low", "high"):
        assert np.array_equal(getattr(watched, name), getattr(alone, name)), name


def test_portions_by_hand():
    """1000 evaluations in 1 ms are 7000 in 7 ms and 200,000 in 200 ms, which is more than 20 times as many."""
    watched, alone = runs._Watcher(None, lambda: False, None, quiet), runs._Watcher(None, None, None, quiet)
    assert (PROMPT.seconds, UNHURRIED.seconds) == (7e-3, 0.2)
    assert watched.next_portion(1000.0, 1e-3) == pytest.approx(7000.0)
    assert alone.next_portion(1000.0, 1e-3) == pytest.approx(20_000.0)
    assert alone.next_portion(1000.0, 0.4) == pytest.approx(500.0)
    assert watched.next_portion(0.0, 1e-3) == 1.0
    assert runs._Watcher(None, None, 7.0, quiet).next_portion(1000.0, 1e-3) == 7.0


def test_another_thread_sees_the_time_go_on_and_can_end_the_run():
    """A run in a single portion, seen on its way by another thread, which then takes its parameter away."""
    chosen = stepping(ENDLESS)
    ready, loop = prepare(MODEL, turning(FAST), chosen), compiled_loop(print)
    reached = start_run(ready, chosen)
    rows, watcher = runs._Rows(reached, chosen), runs._Watcher(None, None, 1e15, quiet)
    with ThreadPoolExecutor(1) as pool:
        run = pool.submit(runs._carry, loop, ready, chosen, reached, rows, turning(FAST), watcher)
        seen = set[float]()
        while len(seen) < 3 and not run.done():
            seen.add(float(reached.clock[places.TIME]))
        ready.vectors.params[0] = np.nan
        with pytest.raises(RunError, match=wording.simulation.no_longer_finite):
            run.result()
    assert max(seen) < ENDLESS and len(seen) == 3


def test_threads_change_no_bit(switching):
    """Two systems at once, in small portions and on several threads, against one after the other."""
    model, case = switching
    jobs = [(model, case(), Stepping(until=0.1)), (MODEL, turning(60.0), stepping(5.0, record_interval=1e-2))] * 3
    expected = [simulate(*job) for job in jobs[:2]] * 3
    with ThreadPoolExecutor(len(jobs)) as pool:
        found = list(pool.map(lambda job: simulate(*job, portion=200.0), jobs))
    for one, other in zip(found, expected, strict=True):
        assert np.array_equal(one.states, other.states) and np.array_equal(one.final, other.final)
        assert one.evaluations == other.evaluations


def test_threads_may_compile_the_same_and_another_at_once(tmp_path):
    models = [Model(damped), MODEL, Model(damped)]
    begin = threading.Barrier(len(models))

    def linked(model: Model):
        begin.wait()
        return link(model, turning(2.0), tmp_path)

    with ThreadPoolExecutor(len(models)) as pool:
        found = list(pool.map(linked, models))
    assert found[0].rates is found[2].rates and found[0].digest != found[1].digest
    rates = np.zeros(2)
    found[0].rates(0.0, np.array([1.0, 2.0]), np.zeros(0), np.array([2.0, 0.0]), rates)
    assert rates.tolist() == pytest.approx([4.0, -2.4])


@pytest.mark.parametrize(("lanes", "part"), [(True, "run_lanes"), (False, "_run_alone")])
def test_a_stopped_batch_keeps_the_cases_that_have_ended(monkeypatch, lanes, part):
    """A slow oscillator ends at once, a fast one never would; it has reached a place on its circle."""
    clocks, carried = [], getattr(batches, part)

    def watched(*given):
        clocks.extend(each.clock for each in given if isinstance(each, batches.CaseRows))
        carried(*given)

    monkeypatch.setattr(batches, part, watched)

    def both_are_on_their_way():
        return bool(clocks) and clocks[0][0, places.TIME] >= ENDLESS and clocks[0][1, places.TIME] > 0.0

    cases, chosen = [turning(SLOW), turning(FAST)], stepping(ENDLESS)
    run = simulate_batch(MODEL, cases, chosen, Crew(1, both_are_on_their_way), lanes=lanes)
    whole = simulate_batch(MODEL, cases[:1], chosen, lanes=lanes)
    assert run.stopped and not whole.stopped
    assert run.reasons[0] is None and run.reasons[1].startswith(wording.simulation.stopped_at)
    assert run.lanes == (lanes, lanes)
    for name in ("final", "low", "high", "evaluations"):
        assert np.array_equal(getattr(run, name)[0], getattr(whole, name)[0]), name
    assert 0.0 < run.end[1] < ENDLESS and run.outcome(1) is None
    angle = FAST * run.end[1]
    assert run.final[1] == pytest.approx([np.sin(angle), np.cos(angle)], abs=1e-6 * (1.0 + angle))


@pytest.mark.parametrize("lanes", [True, False])
def test_a_batch_that_is_stopped_before_it_begins(lanes):
    """Case 2 is not even begun: there is no lane, and no thread, for it."""
    count = 20
    chosen = stepping(ENDLESS)
    run = simulate_batch(MODEL, [turning(FAST)] * count, chosen, Crew(1, lambda: True), lanes=lanes)
    assert run.stopped and run.end.max() < ENDLESS
    assert run.reasons[-1] == wording.simulation.stopped_at + "0 s"
    assert run.final[-1].tolist() == [0.0, 1.0] == run.low[-1].tolist()
    assert run.evaluations[-1] == 0


@pytest.mark.parametrize("lanes", [True, False])
def test_an_interruption_halts_all_threads(lanes):
    def interrupt() -> bool:
        raise KeyboardInterrupt

    before = threading.active_count()
    with pytest.raises(KeyboardInterrupt):
        simulate_batch(MODEL, [turning(FAST)] * 20, stepping(ENDLESS), Crew(stop=interrupt), lanes=lanes)
    assert threading.active_count() <= before
