"""What may not change what a circuit does: each over a few random values of drawn circuits that are compiled once."""

import os
import subprocess
import sys
import threading
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from tests.invariance.circuits import CIRCUITS, changes, drawn, found, numbers, varied

from vvdp.base.signal import Signal
from vvdp.evaluation.summary import simulated_summary
from vvdp.simulation.batch import simulate_batch
from vvdp.simulation.outcome import averaging_window
from vvdp.simulation.run import Method, simulate

SEEDS = (1, 2)
FEW = [(name, seed) for name in CIRCUITS for seed in SEEDS]
MANY = [(name, seed) for name in CIRCUITS for seed in range(3, 40)]
VARIANTS = [*FEW, *(pytest.param(*each, marks=pytest.mark.slow) for each in MANY)]
SHIFT = 0.125
"""How far a run is shifted in time [s]: whole samples, and a power of two, so that no signal's corner is rounded."""
TOLERANCE = 1e-6
VOLUMES = ("first", "second", "third")


@pytest.mark.parametrize(("name", "seed"), VARIANTS)
def test_recording_changes_no_bit(name, seed):
    once, *others = (
        numbers(name, *varied(name, seed), record_interval=interval, window=window, window_interval=fine)
        for interval, window, fine in ((1e-3, 0.01, 2e-5), (0.9, 0.0, 2e-5), (1.7e-4, 0.9, 1e-4))
    )
    assert all(other == once for other in others)


@pytest.mark.parametrize(("name", "seed"), VARIANTS)
def test_a_continued_run_is_an_unbroken_one(name, seed):
    """Its state to the last bit, its extremes too, which are those of the whole; its means where they begin later."""
    system = drawn(name, *varied(name, seed))
    whole = simulate(system.model, system.case, system.stepping)
    run = None
    for until in (0.2, 0.637, 0.9):
        stepping = replace(system.stepping, until=until, average_from=0.7)
        run = simulate(system.model, system.case, stepping, continue_from=run)
    assert np.array_equal(run.final, whole.final)
    assert np.array_equal(run.low, whole.low) and np.array_equal(run.high, whole.high)
    late = simulate(system.model, system.case, replace(system.stepping, average_from=0.7))
    counts = {"steps", "rejected_steps", "evaluations"}
    one, other = (found(system, each) for each in (run, late))
    assert {key for key in one if one[key] != other[key]} <= counts
    assert averaging_window(run).begin == pytest.approx(0.7, rel=1e-15)


def test_the_means_of_a_continued_run_begin_where_it_does_at_the_earliest():
    system = drawn("lowering")
    first = simulate(system.model, system.case, replace(system.stepping, until=0.5))
    second = simulate(system.model, system.case, system.stepping, continue_from=first)
    assert averaging_window(second).begin == 0.5


@pytest.mark.parametrize(("name", "seed"), VARIANTS)
def test_a_shift_in_time_changes_times_alone(name, seed):
    system = drawn(name, *varied(name, seed))
    here = simulate(system.model, system.case, system.stepping)
    stepping = system.stepping
    moved = replace(stepping, begin=SHIFT, until=stepping.until + SHIFT, average_from=stepping.average_from + SHIFT)
    later = simulate(system.model, replace(system.case, params=shifted(system.case.params)), moved)
    assert later.end == here.end + SHIFT
    one, other = found(system, here), found(system, later)
    assert not changes(name, one, other, TOLERANCE)
    assert one["settled"] == other["settled"]


def shifted(params):
    """The parameters with every signal that moves moved by `SHIFT`."""
    if isinstance(params, Signal):
        return params if params.is_constant else replace(params, start=tuple(t + SHIFT for t in params.start))
    if hasattr(params, "_fields"):
        return params._make(shifted(each) for each in params)
    names = getattr(params, "__dataclass_fields__", {})
    changed = {name: shifted(getattr(params, name)) for name in names}
    return replace(params, **changed) if names else params


@pytest.mark.parametrize(("name", "seed"), VARIANTS)
def test_both_methods_agree(name, seed):
    one, other = (numbers(name, *varied(name, seed), method=each) for each in (Method.STIFF, Method.EXPLICIT))
    assert not changes(name, one, other, 30.0 * TOLERANCE)


@pytest.mark.parametrize(("name", "seed"), VARIANTS)
def test_twice_the_tolerance_is_within_twice_the_error(name, seed):
    """The error of a number is at most so many tolerances, at each of them."""
    exact = numbers(name, *varied(name, seed), relative_tolerance=1e-11)
    for tolerance in (5e-7, 1e-6, 2e-6, 4e-6):
        rough = numbers(name, *varied(name, seed), relative_tolerance=tolerance)
        assert not changes(name, rough, exact, 30.0 * tolerance)


@pytest.mark.parametrize(("name", "seed"), VARIANTS)
def test_lanes_agree_with_the_loop(name, seed):
    """All lanes full of other cases; the explicit method, since stiff cases leave their lane."""
    systems = [drawn(name, *varied(name, 100 * seed + place)) for place in range(9)]
    stepping = replace(systems[0].stepping, method=Method.EXPLICIT)
    batch = simulate_batch(systems[0].model, [each.case for each in systems], stepping)
    assert all(batch.lanes)
    for row in (0, 8):
        alone = found(systems[row], simulate(systems[row].model, systems[row].case, stepping))
        beside = simulated_summary(batch.outcome(row), systems[row])
        assert not changes(name, alone, beside, 30.0 * TOLERANCE)


def test_threads_change_no_bit():
    """Four runs at once in threads, of three circuits; and a batch on one core and on two."""
    jobs = [(name, *varied(name, seed)) for name in CIRCUITS for seed in SEEDS]
    alone = [numbers(*job) for job in jobs]
    ready = threading.Barrier(4)

    def job(place):
        if place < 4:
            ready.wait()
        return numbers(*jobs[place])

    with ThreadPoolExecutor(4) as pool:
        assert list(pool.map(job, range(len(jobs)))) == alone


SUBPROCESS = """
from tests.invariance.circuits import CIRCUITS, numbers, varied
print([sorted(numbers(name, *varied(name, 1)).items()) for name in CIRCUITS])
"""


@pytest.mark.thorough
def test_hash_seeds_change_no_bit():
    """In processes of their own, which find the compiled circuits by a hash of their text."""
    root = Path(__file__).parents[2]
    told = []
    for seed in ("0", "7"):
        environment = {**os.environ, "PYTHONHASHSEED": seed, "PYTHONPATH": os.pathsep.join([str(root), *sys.path])}
        done = subprocess.run(
            [sys.executable, "-c", SUBPROCESS], env=environment, capture_output=True, text=True, check=True
        )
        told.append(done.stdout)
    assert told[0] == told[1]
    assert told[0].strip() == str([sorted(numbers(name, *varied(name, 1)).items()) for name in CIRCUITS])


@pytest.mark.parametrize("seed", [1, 2, *(pytest.param(seed, marks=pytest.mark.slow) for seed in range(3, 20))])
def test_a_volume_split_in_two_does_as_one(seed):
    """The same circuit twice: once its first volume is whole and its last split, once the other way round.

    What is outside of the split agrees; within it is the pressure drop of the orifice between the halves, 0.2 %.
    """
    rng = np.random.default_rng(seed)
    half, narrow, wide = rng.uniform(15.0, 30.0), rng.uniform(8.0, 15.0), 200.0
    last_split, first_split = (
        numbers(
            "charging",
            *varied("charging", seed)[2:3],
            *(f"nodes.{name}.volume={half * halves:.6g} cc" for name, halves in zip(VOLUMES, shares, strict=True)),
            *(f"components.{name}.area={area:.6g} mm^2" for name, area in zip(("near", "far"), areas, strict=True)),
        )
        for shares, areas in (((2, 1, 1), (narrow, wide)), ((1, 1, 2), (wide, narrow)))
    )
    for key in ("pressure_mean_pump_line_Pa", "pressure_mean_first_Pa", "pressure_mean_accumulator_Pa", "power_pump_W"):
        assert first_split[key] == pytest.approx(last_split[key], rel=5e-5), key
    for one, other in (("first", "second"), ("second", "third")):
        for quantity in ("pressure_mean", "pressure_max"):
            pressure = last_split[f"{quantity}_{one}_Pa"]
            assert first_split[f"{quantity}_{other}_Pa"] == pytest.approx(pressure, rel=5e-3), (quantity, one)
