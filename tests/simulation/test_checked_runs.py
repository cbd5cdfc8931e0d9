"""Everything compiled with checks: what passes keeps its bits, and what fails ends the run with file and line."""

from typing import NamedTuple

import numpy as np
import pytest
from tests.simulation.asserting import asserting

from vvdp.base.conservation import NOTHING, Nothing
from vvdp.base.errors import RunError
from vvdp.base.kinds import Pressure
from vvdp.base.params import Params
from vvdp.simulation.batch import simulate_batch
from vvdp.simulation.model import Case, Model, Program
from vvdp.simulation.replay import Replay
from vvdp.simulation.run import Stepping, simulate
from vvdp.systems.system import load_system, shipped_systems

SHORT = ("buck-converter", "long-hose", "prototype-constant-load")


def test_some_systems_pass_all_checks_with_the_same_bits():
    for name in SHORT:
        passes_with_the_same_bits(name)


@pytest.mark.thorough
@pytest.mark.parametrize("name", sorted(set(shipped_systems()) - set(SHORT)))
def test_every_system_passes_all_checks_with_the_same_bits(name):
    passes_with_the_same_bits(name)


def passes_with_the_same_bits(name):
    system = load_system(name)
    system = load_system(name, until=f"{min(0.2, system.stepping.until)} s")
    plain, checked = (simulate(system.model, system.case, system.stepping, checked=each) for each in (False, True))
    assert checked.states.tobytes() == plain.states.tobytes()
    assert checked.memories.tobytes() == plain.memories.tobytes()
    assert checked.reached.clock.tobytes() == plain.reached.clock.tobytes()


class State(NamedTuple):
    pressure: Pressure


class Command(NamedTuple):
    guard: State


class Limit(Params):
    pressure: Pressure


def rising(t, state, command, params):
    return State(1e6), Nothing(0.0)


def seen(t, state, outputs, params):
    return state


def raising(t, memory, reading, settings):
    if reading.pressure > settings.pressure:
        raise ValueError("above the limit")
    return memory, reading


def guarded(step):
    """From 1e5 Pa at 1e6 Pa/s, seen each millisecond: a limit of 5e5 Pa is passed after 0.4 s."""
    model = Model(rising, programs={"guard": Program(seen, step, command=State(0.0))})
    case = Case(State(1e5), NOTHING, Command(State(0.0)), {"guard": NOTHING}, {"guard": Limit(pressure=5.005e5)})
    return model, case


def run(step, *, checked=False):
    return simulate(*guarded(step), Stepping(until=1.0), checked=checked)


def test_an_error_that_a_program_raises_ends_the_run_with_its_place():
    with pytest.raises(RunError, match=r"t = 0\.4\d* s: .*test_checked_runs.py:\d+: ValueError\('above the limit'\)"):
        run(raising)


def test_an_error_that_a_program_raises_in_a_batch_or_a_replay_is_one_of_the_run():
    model, case = guarded(raising)
    with pytest.raises(RunError, match=r"test_checked_runs.py:\d+: ValueError\('above the limit'\)"):
        simulate_batch(model, [case] * 3, Stepping(until=1.0), lanes=False)
    replay = Replay(watching, NOTHING, State(0.0), Limit(pressure=5e5))
    assert replay(NOTHING, np.array([[1e5], [5e5]])).shown.ravel().tolist() == [1e5, 5e5]
    with pytest.raises(RunError, match=r"test_checked_runs.py:\d+: ValueError\('above the limit'\)"):
        replay(NOTHING, np.array([[1e5], [6e5]]))


def watching(memory, reading, settings):
    return raising(0.0, memory, reading, settings)


def test_assertions_count_in_checked_code_alone():
    assert run(asserting).final[0] == pytest.approx(1.1e6)
    with pytest.raises(RunError, match=r"asserting.py:\d+: assert reading.pressure <= settings.pressure"):
        run(asserting, checked=True)
