"""Cases in lanes: as they run alone within the tolerance, and to the last bit the same in whatever company."""

from dataclasses import replace

import numpy as np
import pytest

from vvdp.base.signal import constant, step, table
from vvdp.evaluation.bench import rotary_bench
from vvdp.evaluation.unit_rig import unit_on_rig
from vvdp.simulation.batch import simulate_batch
from vvdp.simulation.crew import Crew
from vvdp.simulation.run import Method, simulate
from vvdp.simulation.symbols import Untraceable
from vvdp.simulation.trace import trace
from vvdp.simulation.values import leaves
from vvdp.systems.system import load_system

SHORT = {
    "prototype": "0.05 s",
    "prototype-constant-load": "0.05 s",
    "accumulator-charging": "0.5 s",
    "boost-converter": "0.03 s",
    "buck-converter": "0.03 s",
    "cylinder-stops": "0.5 s",
    "hydrostatic-transmission": "0.5 s",
    "long-hose": "0.3 s",
}
FIELDS = ("final", "final_commands", "final_memories", "low", "high", "mark_times", "mark_states")
COUNTS = ("marks", "steps", "rejected", "evaluations", "samples", "end")


def farthest(found: np.ndarray, expected: np.ndarray, case) -> float:
    """The largest relative distance of a book part; parts below 1e-3 of the largest of their unit count as that.

    Without the time for which a port cavitates, whose rate jumps within steps.
    """
    books = ((i, path, kind) for i, (path, _, kind) in enumerate(leaves(case.state)) if path.startswith("books."))
    kept = [(i, kind.unit) for i, path, kind in books if not path.endswith("cavitating")]
    worst = 0.0
    for unit in {unit for _, unit in kept}:
        rows = [i for i, other in kept if other == unit]
        size = np.abs(expected[rows])
        if size.max() > 0.0:
            worst = max(worst, np.max(np.abs(found[rows] - expected[rows]) / size.clip(1e-3 * size.max())))
    return worst


def same(one, other, rows) -> bool:
    """Whether the cases of `one` have the bits of these rows of `other`."""
    pairs = [(getattr(one, name), getattr(other, name)[rows]) for name in (*FIELDS, *COUNTS)]
    return all(np.array_equal(a, b, equal_nan=True) for a, b in pairs)


@pytest.fixture(scope="module")
def prototype():
    """The prototype on its rig, without programs."""
    return unit_on_rig(load_system("prototype", until="0.03 s"), "batch")


@pytest.fixture(scope="module")
def mixed(prototype):
    """More cases than lanes: other settings, signals of three lengths, and some that fail at once."""
    bench, rng = rotary_bench(prototype, "batch"), np.random.default_rng(3)
    signals = [constant(0.4), step(0.3, 0.6, 0.011), table([0.0, 0.01, 0.02], [0.3, 0.5, 0.35])]
    cases = []
    for number in range(21):
        operation = {"duty_ratio": signals[number % 3]}
        setting = {"cracking_pressure": float(rng.uniform(1.1e7, 1.4e7))}
        cases.append(bench.with_tables(operation=operation, relief_valve=setting).case)
    for number in (4, 9, 10):
        cases[number] = replace(cases[number], state=cases[number].state._replace(inlet=np.nan))
    return cases


@pytest.mark.sampled(4)
@pytest.mark.parametrize("method", [Method.AUTOMATIC, Method.EXPLICIT])
@pytest.mark.parametrize("name", SHORT)
def test_lanes_agree_with_single_runs(name, method):
    """Both err by about the tolerance; 1e-5 of a part is what a study needs."""
    system = load_system(name, until=SHORT[name])
    stepping = replace(system.stepping, relative_tolerance=1e-7, method=method)
    beside = simulate_batch(system.model, [system.case] * 3, stepping)
    alone = simulate(system.model, system.case, stepping)
    assert beside.why_alone is None
    assert beside.reasons == (None,) * 3
    assert method is Method.AUTOMATIC or all(beside.lanes)
    assert farthest(beside.final[0], alone.final, system.case) < 1e-5
    for row in (1, 2):
        assert same(simulate_batch(system.model, [system.case], stepping), beside, [row])


def test_every_case_of_a_mixed_batch_agrees_with_its_single_run(prototype, mixed):
    """At half the default tolerance: each of the two errs by up to 1e-5 there, a step of a signal included."""
    stepping = replace(prototype.stepping, average_from=0.005, relative_tolerance=5e-7)
    found = simulate_batch(prototype.model, mixed, stepping)
    by_scalar = simulate_batch(prototype.model, mixed, stepping, lanes=False)
    assert by_scalar.why_alone
    assert not any(by_scalar.lanes)
    for row, case in enumerate(mixed):
        assert bool(found.reasons[row]) == (row in (4, 9, 10)) == (not found.lanes[row])
        if found.reasons[row]:
            assert found.reasons[row] == by_scalar.reasons[row]
            continue
        assert farthest(found.final[row], by_scalar.final[row], case) < 1e-5
        assert found.marks[row] == by_scalar.marks[row] >= 1
        assert found.mark_times[row] == pytest.approx(by_scalar.mark_times[row], rel=1e-5)
        span = (by_scalar.high[row] - by_scalar.low[row]).clip(1e-9)
        assert np.max(np.abs(found.low[row] - by_scalar.low[row]) / span) < 1e-4
        assert np.max(np.abs(found.high[row] - by_scalar.high[row]) / span) < 1e-4
        assert found.samples[row] == by_scalar.samples[row]


def test_company_order_and_cores_change_no_bit(prototype, mixed):
    whole = simulate_batch(prototype.model, mixed, prototype.stepping, Crew(1))
    order = np.random.default_rng(4).permutation(len(mixed))
    turned = simulate_batch(prototype.model, [mixed[row] for row in order], prototype.stepping)
    assert same(turned, whole, order)
    assert same(simulate_batch(prototype.model, mixed[5:8], prototype.stepping), whole, [5, 6, 7])


def test_a_stiff_case_runs_as_if_alone():
    system = load_system("accumulator-charging", until="1 s")
    found = simulate_batch(system.model, [system.case] * 2, system.stepping)
    assert found.lanes == (False, False)
    assert found.why_alone is None
    assert np.array_equal(found.final[0], simulate(system.model, system.case, system.stepping).final)


@pytest.mark.parametrize("latency", [0.0, 3e-3])
def test_programs_with_triggers_and_latency(latency):
    system = load_system("accumulator-charging", until="3 s")
    programs = {name: replace(program, latency=latency) for name, program in system.model.programs.items()}
    model = replace(system.model, programs=programs)
    stepping = replace(system.stepping, method=Method.EXPLICIT, relative_tolerance=1e-6)
    found = simulate_batch(model, [system.case], stepping)
    alone = simulate(model, system.case, stepping)
    assert found.lanes == (True,)
    assert sum(alone.calls.values()) > 2
    assert np.array_equal(found.final_commands[0], alone.reached.command)
    assert farthest(found.final[0], alone.final, system.case) < 1e-5


def test_the_stiff_method_runs_each_case_alone(prototype):
    stepping = replace(prototype.stepping, method=Method.STIFF, until=0.005)
    found = simulate_batch(prototype.model, [prototype.case], stepping)
    assert found.lanes == (False,)
    assert "stiff" in found.why_alone


def test_a_model_that_cannot_be_traced_says_why(prototype, monkeypatch):
    from vvdp.simulation import lanes

    def refuse(*_):
        raise Untraceable("a table")

    monkeypatch.setattr(lanes, "trace", refuse)
    monkeypatch.setattr(lanes, "_known", {})
    stepping = replace(prototype.stepping, until=0.005)
    found = simulate_batch(prototype.model, [prototype.case], stepping)
    assert found.why_alone == "a table"
    assert np.array_equal(found.final[0], simulate(prototype.model, prototype.case, stepping).final)
    assert trace(prototype.model, prototype.case).signals > 0
