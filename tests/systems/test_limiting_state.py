"""A run that takes long, or fails for its steps, names the state that limits them and its size."""

from types import SimpleNamespace

import numpy as np
import pytest

from vvdp.runs.simulate import run_system
from vvdp.simulation import places
from vvdp.simulation.limiting import LimitingState, state_words
from vvdp.simulation.run import failure
from vvdp.simulation.values import leaves
from vvdp.systems.system import load_system


@pytest.fixture(scope="module")
def tiny():
    """The buck converter with a node of 0.01 mm³."""
    return load_system("buck-converter", ["nodes.node.volume=1e-5 cc", "run.window=0.01 s"], "200 s")


def test_a_state_is_named_with_the_volume_it_belongs_to(tiny):
    paths = [path for path, _, _ in leaves(tiny.case.state)]
    assert state_words(tiny.case, paths.index("node")) == "node (volume 1e-05 cc)"
    assert state_words(tiny.case, paths.index("valve.position")) == "valve.position"


def test_the_state_with_the_largest_error_is_counted(tiny):
    """By hand: errors over atol + rtol |y| of 1, 4 and 2; one that is no number is the largest."""
    ready = SimpleNamespace(
        pattern=SimpleNamespace(group=np.zeros(3)), atol=np.array([1.0, 0.5, 1.0]), rtol=np.array([0.0, 0.5, 0.0])
    )
    bench = SimpleNamespace(error=np.array([1.0, -4.0, 2.0, 9.0]), trial=np.array([0.0, -1.0, 0.0, 0.0]))
    limiting = LimitingState(tiny.case, ready, bench)
    assert limiting.words == ""
    state = np.array([0.0, 0.5, 0.0, 0.0])
    assert limiting.count(state) == 1
    bench.error[2] = np.nan
    assert limiting.count(state) == 2
    bench.error[2] = 0.0
    limiting.count(state)
    assert dict(limiting.counts) == {1: 2, 2: 1}


def test_a_long_run_names_the_tiny_volume(tiny):
    said: list[str] = []
    run_system(tiny, say=said.append, stop=lambda: any("limited" in line for line in said))
    assert said[-1].startswith("this run will take about ")
    assert said[-1].endswith(" of its time; its steps are limited by node (volume 1e-05 cc)")


def test_a_step_that_becomes_too_small_names_the_state(tiny):
    clock, state = np.zeros(64), np.ones(40)
    words = failure(tiny.case, clock, state, places.STEP_TOO_SMALL, "node (volume 1e-05 cc)")
    assert "the step has become too small, limited by node (volume 1e-05 cc): is it much smaller" in words
    assert "limited by" not in failure(tiny.case, clock, state, places.STEP_TOO_SMALL)
