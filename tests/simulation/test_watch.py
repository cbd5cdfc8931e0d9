"""What was linked is remembered for as long as nothing that it was made of has changed, and no longer."""

import types
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pytest
from tests.words import wording

from vvdp.base.kinds import Pressure
from vvdp.base.params import Params
from vvdp.simulation import link as linking
from vvdp.simulation.link import link
from vvdp.simulation.model import Case, Model, Program
from vvdp.simulation.reach import reachable
from vvdp.simulation.run import Stepping, simulate
from vvdp.simulation.text import told_size
from vvdp.simulation.watch import Watch, model_key

TEXT = """
import enum
import types
import numpy as np
from typing import NamedTuple

class Mode(enum.IntEnum):
    ONE = 1

class Pair(NamedTuple):
    a: float
    b: float = 2.0

FACTOR, TABLE, NESTED, UNREAD = 2.0, np.array([1.0, 2.0]), (1.0, (np.array([3.0]), "x")), 5.0
settings = types.ModuleType("settings")
settings.GAIN = 4.0

def inner(x, offset=1.0, *, scale=1.0):
    return abs(x) * scale + offset

def formula(x):
    return inner(x)

def outer(x):
    return formula(x) * FACTOR + TABLE[0] + NESTED[0] + settings.GAIN + Mode.ONE + Pair(x).b + np.sqrt(x)
"""


def written() -> types.ModuleType:
    module = types.ModuleType("written")
    exec(TEXT, module.__dict__)
    return module


def other(x, offset=1.0, *, scale=1.0):
    return x


CHANGES = {
    "a constant": lambda m: setattr(m, "FACTOR", 3.0),
    "a constant to an equal one of another kind": lambda m: setattr(m, "FACTOR", 2),
    "an array within": lambda m: m.TABLE.__setitem__(0, 7.0),
    "an array in a tuple": lambda m: m.NESTED[1][0].__setitem__(0, 7.0),
    "another array": lambda m: setattr(m, "TABLE", m.TABLE + 1.0),
    "a function": lambda m: setattr(m, "formula", other),
    "a function that another calls": lambda m: setattr(m, "inner", other),
    "the code of a function": lambda m: setattr(m.inner, "__code__", other.__code__),
    "a default": lambda m: setattr(m.inner, "__defaults__", (2.0,)),
    "a default by name": lambda m: m.inner.__kwdefaults__.__setitem__("scale", 3.0),
    "a compiled sibling": lambda m: setattr(m, "formula_compiled", other),
    "a builtin that is hidden": lambda m: setattr(m, "abs", other),
    "a value of another module": lambda m: setattr(m.settings, "GAIN", 5.0),
    "an enum": lambda m: setattr(m, "Mode", types.SimpleNamespace(ONE=1)),
    "a class": lambda m: exec("class Pair(NamedTuple):\n    a: float\n    b: float = 3.0", m.__dict__),
    "a module": lambda m: setattr(m, "np", types.SimpleNamespace(sqrt=abs)),
    "a name that is gone": lambda m: delattr(m, "FACTOR"),
}


@pytest.mark.parametrize("change", CHANGES.values(), ids=CHANGES)
def test_sees(change):
    module = written()
    watch = Watch(reachable(module.outer, {}))
    assert watch.is_unchanged()
    change(module)
    assert not watch.is_unchanged()


def test_overlooks_what_nothing_reads():
    module = written()
    watch = Watch(reachable(module.outer, {}))
    module.UNREAD = 6.0
    module.more = other
    assert watch.is_unchanged()


class State(NamedTuple):
    pressure: Pressure


class Outputs(NamedTuple):
    pressure: Pressure


class Command(NamedTuple):
    reader: Outputs


class Values(Params):
    start: Pressure = 1e5


class Longer(Params):
    start: Pressure = 1e5
    table: tuple[float, ...] = (1.0, 2.0)


SPEED = 1e5


def rising(t, state, command, params):
    return State(speed()), Outputs(state.pressure)


def speed():
    return SPEED


def model_and_case():
    return Model(rising), Case(State(1e5), Values())


def slow():
    return 3e5


def lost():
    return np.nan


def reached(model, case):
    return simulate(model, case, Stepping(until=1.0)).final[0]


def test_a_second_run_links_nothing(monkeypatch):
    model, case = model_and_case()
    first = link(model, case)
    monkeypatch.setattr(linking, "ModelAssemblies", lambda *given, **more: pytest.fail("linked again"))
    assert link(model, Case(State(2e5), Values(start=3e5))) is first
    assert link(Model(rising), case) is first
    with pytest.raises(pytest.fail.Exception):
        link(model, Case(State(1e5), Longer()))


def test_never_runs_what_was(monkeypatch):
    model, case = model_and_case()
    assert reached(model, case) == pytest.approx(2e5)
    monkeypatch.setitem(globals(), "SPEED", 2e5)
    assert reached(model, case) == pytest.approx(3e5)
    monkeypatch.setitem(globals(), "speed", slow)
    assert reached(model, case) == pytest.approx(4e5)
    monkeypatch.undo()
    assert reached(model, case) == pytest.approx(2e5)


def test_what_is_wrong_is_said_each_time(monkeypatch):
    """A change between two runs is tried in plain Python again, not only compiled."""
    model, case = model_and_case()
    reached(model, case)
    monkeypatch.setitem(globals(), "speed", lost)
    with pytest.raises(Exception, match=wording.simulation.no_finite_rate):
        reached(model, case)
    monkeypatch.undo()
    with pytest.raises(Exception, match=wording.simulation.starts_wrongly):
        reached(model, replace(case, state=State(-1e5)))


def test_what_may_change_unseen_has_no_key():
    _, case = model_and_case()

    class Called:
        def __call__(self, t, state, command, params):
            return rising(t, state, command, params)

    assert model_key(Model(rising), case) is not None
    assert model_key(Model(Called()), case) is None
    assert model_key(Model(rising, stop=np.sin), case) is None


class Reading(NamedTuple):
    many: Pressure


def measured(t, state, outputs, params):
    return Reading(np.zeros(int(params.start / 1e5)) + state.pressure)


def shown(t, memory, reading, settings):
    return memory, Outputs(reading.many[-1])


def test_readings_whose_length_is_a_value_are_linked_anew():
    """The room for a reading is part of the text: a longer one would be written beyond that of a shorter one."""
    model = Model(rising, programs={"reader": Program(measured, shown, Outputs(0.0))})
    short, long = (
        Case(State(1e5), Values(start=count * 1e5), Command(Outputs(0.0)), {"reader": ()}, {"reader": ()})
        for count in (1.0, 9.0)
    )
    assert linking.example_reading(model, model.programs["reader"], long).many.size == 9
    sizes = [told_size(linking.example_reading(model, model.programs["reader"], case)) for case in (short, long)]
    assert sizes == [2, 10]  # behind the length
    assert model_key(model, short) == model_key(model, long)
    assert link(model, short).digest != link(model, long).digest


def test_hash_and_watch_agree_on_the_network_functions():
    """Whatever an assembly reaches can be watched, so that the shipped systems are remembered."""
    from vvdp.systems.system import load_system

    system = load_system("prototype")
    link(system.model, system.case)
    key = (linking.default_cache(), False, model_key(system.model, system.case))
    assert linking._REMEMBERED.get(key) is not None
    assert linking.ModelAssemblies(system.model, system.case).circuit.functions
