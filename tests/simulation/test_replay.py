"""A sampled step over a record: the compiled pass is the plain one, in one go or in portions."""

from typing import NamedTuple

import numpy as np
import pytest
from tests.words import wording

from vvdp.base.errors import RunError
from vvdp.base.kinds import Ratio, Time
from vvdp.base.params import Params
from vvdp.numerics.kalman import observe
from vvdp.numerics.random import Random, normal, random_start
from vvdp.simulation.replay import Replay
from vvdp.simulation.values import flat


class Sample(NamedTuple):
    time: float
    value: float


class Memory(NamedTuple):
    sum: float
    random: Random
    last: np.ndarray


class Shown(NamedTuple):
    mean: float
    noise: float
    oldest: float


class Settings(Params):
    share: Ratio
    times: Time


def averaged(memory, sample, settings):
    random, noise = normal(memory.random)
    last = np.empty(3)
    last[1:] = memory.last[:2]
    last[0] = sample.value
    factors, gain = np.zeros((2, 2)), np.empty(2)
    factors[0, 0] = factors[1, 1] = 1.0
    observe(factors, np.array([1.0, 0.0]), settings.share, gain)
    total = memory.sum + gain[0] * (sample.value + noise)
    return Memory(total, random, last), Shown(total / sample.time, noise, last[2])


def forgetful(memory, sample, settings):
    return memory.sum, Shown(0.0, 0.0, 0.0)


def whole_row(memory, sample, settings):
    return memory, memory.last


START = Memory(0.0, random_start(7.0), np.zeros(3))
SETTINGS = Settings(share=0.5, times=1.0)
ROWS = np.column_stack([np.arange(1.0, 201.0), np.sin(np.arange(200.0))])


@pytest.fixture(scope="module")
def replay():
    return Replay(averaged, START, Sample(1.0, 0.0), SETTINGS)


def test_compiled_pass_is_the_plain_one(replay):
    found = replay(START, ROWS)
    memory, plain = START, []
    for row in ROWS.tolist():
        memory, shown = averaged(memory, Sample(*row), SETTINGS)
        plain.append(shown)
    assert replay.columns == ("mean", "noise", "oldest")
    np.testing.assert_allclose(found.shown, plain, rtol=1e-13, atol=1e-13)
    assert found.memory.random == memory.random  # whole numbers below 2^53: exact
    np.testing.assert_array_equal(found.memory.last, memory.last)


def test_portions_give_the_same_to_the_last_bit(replay):
    whole = replay(START, ROWS)
    first = replay(START, ROWS[:77])
    second = replay(first.memory, ROWS[77:])
    np.testing.assert_array_equal(np.vstack([first.shown, second.shown]), whole.shown)
    assert second.memory.sum == whole.memory.sum


def test_the_memory_that_was_given_is_left_alone(replay):
    replay(START, ROWS)
    assert START.sum == 0.0
    assert not START.last.any()


def test_outputs_alone_are_those_of_a_pass_and_move_the_memory_in_place(replay):
    whole, memory = replay(START, ROWS), flat(START)
    np.testing.assert_array_equal(replay.outputs(memory, ROWS), whole.shown)
    np.testing.assert_array_equal(memory, flat(whole.memory))


def test_other_settings_need_no_new_compilation(replay):
    """Gain 1/(1 + R): with R = 0 the measured value itself."""
    found = replay(START, ROWS[:1], Settings(share=0.0, times=1.0))
    assert found.shown[0, 0] == pytest.approx(0.0 + found.shown[0, 1], abs=1e-15)


def test_what_does_not_fit_is_refused(replay):
    with pytest.raises(RunError, match=r"expected \(samples, 2\)"):
        replay(START, np.zeros((5, 3)))
    with pytest.raises(RunError, match=wording.simulation.memory_differs):
        Replay(forgetful, START, Sample(1.0, 0.0), SETTINGS)
    with pytest.raises(RunError, match=wording.simulation.shows_an_array):
        Replay(whole_row, START, Sample(1.0, 0.0), SETTINGS)


class Weights(NamedTuple):
    weights: tuple[float, ...]


class Window(NamedTuple):
    last: np.ndarray
    before: np.ndarray


def weighed(memory, sample, settings):
    total = 0.0
    for i in range(len(settings.weights)):
        total = total + settings.weights[i] * memory.last[i]
    last = np.empty(memory.last.size)
    last[1:] = memory.last[:-1]
    last[0] = sample.value
    return Window(last, memory.last), Shown(total, memory.before[0], 0.0)


def test_lengths_of_settings_and_memory_take_no_part_in_the_text():
    digests = set()
    for n in (2, 5):
        start, settings = Window(np.zeros(n), np.ones(n)), Weights(tuple(np.arange(1.0, n + 1.0)))
        replay = Replay(weighed, start, Sample(1.0, 0.0), settings)
        found, memory = replay(start, ROWS), start
        for row, shown in zip(ROWS.tolist(), found.shown, strict=True):
            memory, plain = weighed(memory, Sample(*row), settings)
            assert shown.tolist() == pytest.approx(list(plain), rel=1e-14)
        np.testing.assert_array_equal(found.memory.before, memory.before)
        assert replay(start, ROWS, Weights(settings.weights[:1])).shown[1, 0] == ROWS[0, 1]
        digests.add(replay.digest)
    assert len(digests) == 1
