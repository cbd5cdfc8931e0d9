"""Joining a model to the compiled loop: flat vectors in and out, and compiled code that is never stale nor foreign."""

import enum
import os
import subprocess
import sys
import textwrap
import types
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import numpy as np
import pytest
from tests.words import wording

from vvdp.base.conservation import NOTHING, Nothing
from vvdp.base.errors import RunError
from vvdp.base.kinds import Kind
from vvdp.base.params import Params
from vvdp.base.signal import Signal, constant, signal_stop, signal_value, table
from vvdp.generator.source import known_text
from vvdp.simulation import assembly, cache
from vvdp.simulation import link as linking
from vvdp.simulation.assembly import Assembly
from vvdp.simulation.cache import check_private, keep, kept_bytes, read_kept
from vvdp.simulation.layout import as_memory, case_shape, command_parts, memory_parts, rows, vectors
from vvdp.simulation.link import link
from vvdp.simulation.model import Case, Model, Program
from vvdp.simulation.parts import measure_part, rates_part

pytestmark = pytest.mark.thorough

Plain = Annotated[float, Kind("plain number", "1", -1e9, 1e9, "1")]
Prescribed = Annotated[Signal, Kind("plain number", "1", -1e9, 1e9, "1")]


class Level(NamedTuple):
    x: Plain


class Gain(Params):
    gain: Plain


class Driven(Params):
    gain: Plain
    drive: Prescribed


CASE = Case(Level(1.0), Gain(gain=2.0))


def sound(t, s, u, p):
    return Level(-p.gain * s.x), Nothing(0.0)


def driven(t, s, u, p):
    return Level(signal_value(t, p.drive) + p.gain), Nothing(0.0)


def driven_stop(t, u, p):
    return signal_stop(t, p.drive)


def rates_of(linked, case, t=0.0):
    y, u, _, p = vectors(case)
    found = np.zeros_like(y)
    linked.rates(t, y, u, p, found)
    return found


def forget() -> None:
    """As a new process would find it: nothing is loaded yet."""
    assembly._LOADED.clear()
    linking._REMEMBERED._found.clear()


@pytest.fixture
def fresh():
    forget()
    yield
    forget()


# What is refused


def closing(factor):
    def circuit(t, s, u, p):
        return Level(factor * s.x), Nothing(0.0)

    return circuit


class Callable:
    def __call__(self, *arguments):
        return arguments[1], Nothing(0.0)


FACTORS, SHARES, WHOLE = [1.0, 2.0], {"a": 1.0}, Gain(gain=1.0)


def by_list(t, s, u, p):
    return Level(FACTORS[0] * s.x), Nothing(0.0)


def by_mapping(t, s, u, p):
    return Level(SHARES["a"] * s.x), Nothing(0.0)


def by_record(t, s, u, p):
    return Level(WHOLE.gain * s.x), Nothing(0.0)


def by_module(t, s, u, p):
    words = textwrap
    return Level(words.factor * s.x), Nothing(0.0)


@pytest.mark.parametrize(
    ("circuit", "told"),
    [
        (closing(2.0), "closing.<locals>.circuit " + wording.simulation.closes_over),
        (Callable(), wording.simulation.no_plain_function),
        (by_list, r"FACTORS \(in by_list\) is a list, which may change unseen; write a tuple or an array"),
        (by_mapping, r"SHARES \(in by_mapping\) is a dict"),
        (by_record, r"WHOLE \(in by_record\) is a Gain; .*use params"),
        (by_module, r"textwrap \(in by_module\) is the module textwrap itself"),
    ],
)
def test_what_cannot_be_hashed_is_refused_by_name(circuit, told, tmp_path):
    with pytest.raises(RunError, match=told):
        link(Model(circuit), CASE, tmp_path)
    assert not any(tmp_path.iterdir())


def test_memory_and_settings_are_those_of_the_programs(tmp_path):
    with pytest.raises(RunError, match=wording.simulation.for_each_program):
        link(Model(sound), Case(Level(1.0), Gain(gain=1.0), memory={"other": NOTHING}), tmp_path)


def uncompilable(t, s, u, p):
    return Level(helper_with_words(s.x)), Nothing(0.0)


def helper_with_words(x):
    return float(f"{x:.3f}") + sorted([x, 1.0], key=str)[0]


def test_what_the_language_does_not_have_is_refused_with_its_place_each_time(tmp_path):
    for _ in range(2):
        with pytest.raises(RunError, match=r"test_link.py:\d+: .* \(in helper_with_words\); ") as caught:
            link(Model(uncompilable), CASE, tmp_path)
        assert len(str(caught.value).splitlines()) == 1
    assert not any(tmp_path.iterdir())


class Pair(NamedTuple):
    x: Plain
    y: Plain = 0.25


def leaving_out(t, s, u, p):
    return Pair(s.x * p.gain), Nothing(0.0)


def test_fields_left_out_have_their_defaults(tmp_path):
    case = Case(Pair(1.0), Gain(gain=2.0))
    assert rates_of(link(Model(leaving_out), case, tmp_path), case).tolist() == [2.0, 0.25]


# Values in and out


class Held(NamedTuple):
    level: Plain


class Flow(NamedTuple):
    flow: Plain


class Shown(NamedTuple):
    row: np.ndarray
    count: Plain


class Command(NamedTuple):
    held: Held
    counter: Shown
    controller: Flow


class Row(NamedTuple):
    level: Plain
    row: np.ndarray


class Pairs(NamedTuple):
    one: np.ndarray
    count: Plain
    other: np.ndarray


class Gains(NamedTuple):
    gains: tuple[float, ...]
    square: np.ndarray
    share: Plain


def tank(t, s, u, p):
    return Level(u.controller.flow + u.counter.row[1] + u.counter.count + u.held.level), Flow(3.0 * s.x)


def tank_conditions(t, p):
    return Held(2.0 * p.gain + t)


def flow_sensor(t, state, outputs, params):
    return Flow(outputs.flow + params.gain)


def controller(t, memory, reading, settings):
    return memory, Flow(reading.flow * settings.gains[1] + len(settings.gains) + settings.square[1, 0])


def level_sensor(t, state, outputs, params):
    return Row(state.x, np.array([state.x, 2.0 * t]))


def counter(t, memory, reading, settings):
    found = Pairs(memory.other, memory.count + 1.0, memory.one)  # each array where the other one was
    return found, Shown(reading.row * settings.share, memory.count)


def trigger(t, state, command, params, settings):
    return 10.0 * t + command.held.level


def tank_mark(t, state, command, params):
    return state.x + command.controller.flow


PROGRAMS = {
    "controller": Program(flow_sensor, controller, Flow(0.0)),
    "counter": Program(level_sensor, counter, Shown(np.zeros(2), 0.0), trigger=trigger),
}
TANK = Model(tank, conditions=tank_conditions, programs=PROGRAMS, mark=tank_mark)


def tank_case(length: int = 3) -> Case:
    rng = np.random.default_rng(length)
    return Case(
        state=Level(1.5),
        params=Gain(gain=0.25),
        command=Command(Held(0.5), Shown(np.array([1.0, 2.0]), 3.0), Flow(4.0)),
        memory={"controller": NOTHING, "counter": Pairs(rng.random(length), 5.0, rng.random(length))},
        settings={
            "controller": Gains(tuple(rng.random(length)), rng.random((2, length)), 1.0),
            "counter": Gains((1.0,), np.ones((1, 1)), 0.5),
        },
    )


@pytest.mark.parametrize("length", [3, 4])
def test_each_linked_function_does_what_the_plain_one_does(length):
    case = tank_case(length)
    linked, (y, u, m, p) = link(TANK, case), vectors(case)
    c, g, t = u.copy(), np.zeros(2), 0.75
    linked.events(t, y, u, p, g)
    assert g.tolist() == [tank_mark(t, case.state, case.command, case.params), 8.0]
    assert linked.stop(t, u, p) == np.inf
    assert rates_of(linked, case).tolist() == [9.5]
    parts = command_parts(case)

    linked.sample(0, t, y, u, m, p, c)
    assert c[parts["held"]].tolist() == [1.25]
    linked.sample(1, t, y, u, m, p, c)
    reading = flow_sensor(t, case.state, tank(t, case.state, case.command, case.params)[1], case.params)
    assert c[parts["controller"]].tolist() == [controller(t, NOTHING, reading, case.settings["controller"])[1].flow]
    assert c[parts["counter"]].tolist() == [1.0, 2.0, 3.0]  # none of its business

    before = m.copy()
    linked.sample(2, t, y, u, m, p, c)
    assert c[parts["counter"]].tolist() == [0.75, 0.75, 5.0]
    found, given = as_memory(case, m)["counter"], case.memory["counter"]
    np.testing.assert_array_equal(found.one, given.other)
    np.testing.assert_array_equal(found.other, given.one)
    assert found.count == 6.0
    assert before[memory_parts(case)["controller"]].tolist() == m[memory_parts(case)["controller"]].tolist()
    assert u.tolist() == vectors(case).command.tolist()


def test_lengths_of_arrays_and_tables_take_no_part_in_the_text():
    short, long = link(TANK, tank_case(3)), link(TANK, tank_case(40))
    assert short.digest == long.digest
    assert case_shape(tank_case(3)) != case_shape(tank_case(40))  # memory: not one batch
    points = [table(range(n), np.sin(np.arange(n))) for n in (2, 300)]
    cases = [Case(Level(0.0), Driven(gain=1.0, drive=signal)) for signal in (constant(2.0), *points)]
    assert len({rates_part(Model(driven), case).source for case in cases}) == 1
    assert len({case_shape(case) for case in cases}) == 1


def test_rows_of_different_lengths_go_together():
    cases = [
        Case(Level(0.0), Driven(gain=1.0, drive=signal))
        for signal in (
            constant(2.0),
            table((0.0, 1.0, 2.0), (0.0, 5.0, 1.0)),
            Signal(1.0, (), (), (), (2.0,), (3.0,), (0.0,)),
        )
    ]
    linked, packed = link(Model(driven), cases[0]), rows(cases).params
    for case, row in zip(cases, packed, strict=True):
        found = np.zeros(1)
        linked.rates(0.3, np.zeros(1), np.zeros(1), row, found)
        assert found[0] == pytest.approx(signal_value(0.3, case.params.drive) + 1.0, rel=1e-15)


def random_signal(rng: np.random.Generator, changes: int, sines: int) -> Signal:
    starts = np.sort(rng.uniform(0.0, 2.0, changes)).round(2)
    durations = rng.uniform(0.0, 0.5, changes) * (rng.random(changes) < 0.7)
    columns = (starts, durations, rng.normal(size=changes), *rng.normal(size=(3, sines)))
    return Signal(float(rng.normal()), *(tuple(map(float, column)) for column in columns))


def test_signals_are_the_plain_ones_to_the_last_bit():
    """Sines are those of another library: to the last but one."""
    rng = np.random.default_rng(3)
    model = Model(driven, stop=driven_stop)
    linked = link(model, Case(Level(0.0), Driven(gain=0.0, drive=constant(0.0))))
    assert np.signbit(rates_of(linked, Case(Level(0.0), Driven(gain=-0.0, drive=constant(-0.0))))[0]) == np.False_
    for number in range(200):
        signal = random_signal(rng, int(rng.integers(0, 6)), int(rng.integers(0, 3)) if number % 2 else 0)
        case = Case(Level(0.0), Driven(gain=0.0, drive=signal))
        params = vectors(case).params
        for t in (0.0, *signal.start, *rng.uniform(0.0, 3.0, 10)):
            found, plain = rates_of(linked, case, t)[0], signal_value(t, signal)
            if signal.amplitude:
                assert found == pytest.approx(plain, rel=1e-14, abs=1e-14)
            else:
                assert found == plain
            assert linked.stop(t, np.zeros(1), params) == signal_stop(t, signal)


def later(t, s, u, p):
    return Level(signal_value(2.0 * t, p.drive) + signal_value(0.0, p.drive)), Nothing(0.0)


def test_a_signal_at_another_time_than_now():
    case = Case(Level(0.0), Driven(gain=0.0, drive=table((0.0, 1.0, 2.0), (3.0, 5.0, 1.0))))
    assert rates_of(link(Model(later), case), case, 0.7)[0] == signal_value(1.4, case.params.drive) + 3.0


def test_a_signal_that_nobody_asks_for(tmp_path):
    text = """
        import numpy as np
        from test_link import CASE, Driven, Level, link, rates_of, sound
        from vvdp.base.signal import constant
        from vvdp.simulation.model import Case, Model
        case = Case(Level(1.0), Driven(gain=2.0, drive=constant(1.0)))
        print(rates_of(link(Model(sound), case), case)[0])
    """
    assert run_python(text, Path(__file__).parent, tmp_path) == "-2.0\n"


# What is compiled again, and what is not


def files(cache: Path) -> set[str]:
    return {path.name for path in cache.iterdir()}


def test_one_line_names_all_that_is_compiled_and_the_time(tmp_path, fresh):
    said: list[str] = []
    link(TANK, tank_case(), tmp_path, said.append)
    what = "the circuit tank, the program controller, the program counter"
    assert said == [wording.simulation.compiling.format(what=what, seconds=1)]


def other_controller(t, memory, reading, settings):
    return memory, Flow(reading.flow - settings.gains[0])


def other_tank(t, s, u, p):
    return Level(u.controller.flow - s.x), Flow(2.0 * s.x)


def test_another_gain_compiles_nothing_and_another_controller_only_itself(tmp_path, fresh):
    link(TANK, tank_case(), tmp_path)
    before, said = files(tmp_path), []
    assert len(before) == 6  # the circuit, two sensors, two steps, and what calls them
    forget()
    link(TANK, Case(**{**vars(tank_case(5)), "params": Gain(gain=7.0)}), tmp_path, said.append)
    assert files(tmp_path) == before
    assert said == []

    programs = {**PROGRAMS, "controller": Program(flow_sensor, other_controller, Flow(0.0))}
    link(Model(tank, conditions=tank_conditions, programs=programs, mark=tank_mark), tank_case(), tmp_path, said.append)
    assert len(files(tmp_path) - before) == 2  # the step, and what calls sensors and steps
    assert said == [wording.simulation.compiling.format(what="the program controller", seconds=1)]

    before = files(tmp_path)
    link(Model(other_tank, conditions=tank_conditions, programs=PROGRAMS, mark=tank_mark), tank_case(), tmp_path)
    assert len(files(tmp_path) - before) == 2  # the circuit, and what calls sensors and steps


@pytest.mark.parametrize("name", PROGRAMS)
def test_a_sensor_does_not_contain_the_circuit(name):
    digests = {Assembly([measure_part(Model(c), PROGRAMS[name], tank_case())]).digest for c in (tank, other_tank)}
    assert len(digests) == 1


def test_checked_code_is_kept_apart_and_gives_the_same(tmp_path, fresh):
    case = tank_case()
    plain = rates_of(link(TANK, case, tmp_path), case)
    before = files(tmp_path)
    checked = rates_of(link(TANK, case, tmp_path, checked=True), case)
    assert len(files(tmp_path) - before) == len(before)
    assert checked.tobytes() == plain.tobytes()


def beyond(t, memory, reading, settings):
    return memory, Flow(settings.gains[int(reading.flow)])


def test_an_index_out_of_bounds_is_reported_by_checked_code_alone(tmp_path, fresh):
    programs = {**PROGRAMS, "controller": Program(flow_sensor, beyond, Flow(0.0))}
    model, case = Model(tank, conditions=tank_conditions, programs=programs, mark=tank_mark), tank_case()
    linked, (y, u, m, p) = link(model, case, tmp_path, checked=True), vectors(case)
    with pytest.raises(Exception, match=r"test_link.py:\d+: .*\(in beyond\)"):
        linked.sample(1, 0.0, y, u, m, p, u.copy())


class Colour(enum.Enum):
    RED = 1.0


CONSTANTS = """
    import enum
    from typing import NamedTuple
    import numpy as np
    {inner}

    class Mode(enum.Enum):
        ONE = {k}

    class Number(enum.IntEnum):
        ONE = {k}

    class Filled(NamedTuple):
        y: float = {k}.0

    SCALAR, WHOLE, ROW, NESTED = np.float64({k}), np.int64({k}), np.array([{k}.0]), (1.0, (2.0, {k}.0))

    def defaulted(x, k={k}.0):
        return k * x
"""
USES = {
    "module": "consts.SCALAR",
    "module of a module": "outer.consts.WHOLE",
    "scalar": "SCALAR",
    "whole scalar": "WHOLE",
    "array": "ROW[0]",
    "nested tuple": "NESTED[1][1]",
    "enum": "Mode.ONE.value",
    "enum of a module": "consts.Number.ONE",
    "default of a NamedTuple": "Filled().y",
    "default of a function": "defaulted(1.0)",
    "function of a module": "consts.defaulted(1.0)",
}


def circuit_with(k: int, use: str) -> types.FunctionType:
    """A circuit that uses a constant whose value is `k`."""
    consts, outer, home = (types.ModuleType(name) for name in ("consts", "outer", "home"))
    exec(textwrap.dedent(CONSTANTS).format(k=k, inner=""), consts.__dict__)
    outer.consts = consts  # type: ignore[attr-defined]
    home.__dict__.update({**vars(consts), "__name__": "home", "consts": consts, "outer": outer, "Level": Level})
    exec(f"def circuit(t, s, u, p):\n    return Level({use} * p.gain), 0.0", home.__dict__)
    return home.circuit


@pytest.mark.parametrize("use", USES.values(), ids=USES)
def test_a_changed_constant_is_another_hash(use):
    one, again, other = (Assembly([rates_part(Model(circuit_with(k, use)), CASE)]).digest for k in (1, 1, 2))
    assert one == again
    assert one != other


def run_python(text: str, folder: Path, cache: Path, more: Mapping[str, str] | None = None) -> str:
    """What a fresh interpreter prints; `more` is added to its environment."""
    source = Path(__file__).parents[2] / "src"
    path = os.pathsep.join([str(folder), *(p for p in (os.environ.get("PYTHONPATH"), str(source)) if p)])
    environment = {
        **os.environ,
        "PYTHONPATH": path,
        "VVDP_CACHE": str(cache),
        "PYTHONDONTWRITEBYTECODE": "1",
        **(more or {}),
    }
    done = subprocess.run(
        [sys.executable, "-c", textwrap.dedent(text)], env=environment, capture_output=True, text=True, check=True
    )
    return done.stdout


FORMULA = """
    import consts

    def loss(x, gain):
        return {formula}
"""
CIRCUIT = """
    from typing import Annotated, NamedTuple

    from vvdp.base.conservation import Nothing
    from vvdp.base.kinds import Kind
    from vvdp.base.params import Params
    {imported}

    Plain = Annotated[float, Kind("plain number", "1", -1e9, 1e9, "1")]

    class State(NamedTuple):
        x: Plain

    class Values(Params):
        gain: Plain

    def circuit(t, s, u, p):
        return State({called}(s.x, p.gain)), Nothing(0.0)
"""
PROGRAM = """
    import numpy as np
    from wiring import State, Values, circuit
    from vvdp.simulation.layout import vectors
    from vvdp.simulation.link import link
    from vvdp.simulation.model import Case, Model

    case = Case(State(0.0), Values(gain=2.0))
    linked, (y, u, m, p), dy = link(Model(circuit), case, say=print), vectors(case), np.zeros(1)
    linked.rates(0.0, y, u, p, dy)
    print(dy[0])
"""


def write(folder: Path, factor: float, formula: str, *, by_module: bool) -> None:
    (folder / "consts.py").write_text(f"FACTOR = {factor}\n")
    (folder / "laws.py").write_text(textwrap.dedent(FORMULA).format(formula=formula))
    imported, called = ("import laws", "laws.loss") if by_module else ("from laws import loss", "loss")
    (folder / "wiring.py").write_text(textwrap.dedent(CIRCUIT).format(imported=imported, called=called))


@pytest.mark.parametrize("by_module", [False, True])
def test_changed_formula_in_another_file_is_never_served_stale(by_module, tmp_path):
    """x' = loss: a change of the formula, and of a constant that it uses, both show at once; and nothing is compiled
    twice."""
    cache = tmp_path / "cache"
    write(tmp_path, 3.0, "consts.FACTOR * gain", by_module=by_module)
    first = run_python(PROGRAM, tmp_path, cache).splitlines()
    assert float(first[-1]) == 6.0
    assert any(wording.simulation.compiling_what.format(what="the circuit") in line for line in first)

    again = run_python(PROGRAM, tmp_path, cache).splitlines()
    assert again == [first[-1]]  # no word of compiling, and the same to the last digit

    write(tmp_path, 5.0, "consts.FACTOR * gain", by_module=by_module)
    assert float(run_python(PROGRAM, tmp_path, cache).splitlines()[-1]) == 10.0

    write(tmp_path, 5.0, "consts.FACTOR * gain + 1.0", by_module=by_module)
    assert float(run_python(PROGRAM, tmp_path, cache).splitlines()[-1]) == 11.0


class Left(Params):
    a: Plain


class Right(Params):
    b: Plain


class Both(Params):
    left: Left
    right: Right


Right.__name__ = Right.__qualname__ = "Left"


def two_sided(t, s, u, p):
    return Level(p.left.a - p.right.b), Nothing(0.0)


def test_classes_of_the_same_name():
    case = Case(Level(0.0), Both(left=Left(a=2.0), right=Right(b=3.0)))
    assert rates_of(link(Model(two_sided), case), case).tolist() == [-1.0]


# The cache


def truncate(path: Path) -> None:
    path.write_bytes(path.read_bytes()[:-20])


def garble(path: Path) -> None:
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 0xFF
    path.write_bytes(content)


def empty(path: Path) -> None:
    path.write_bytes(b"")


@pytest.mark.parametrize("damage", [truncate, garble, empty])
def test_damaged_code_is_reported_and_compiled_again(damage, tmp_path, fresh):
    link(Model(sound), CASE, tmp_path)
    kept, said = {path: path.read_bytes() for path in tmp_path.iterdir()}, []
    for path in kept:
        damage(path)
    forget()
    assert rates_of(link(Model(sound), CASE, tmp_path, said.append), CASE).tolist() == [-2.0]
    assert {path: path.read_bytes() for path in tmp_path.iterdir()} == kept
    assert any(wording.simulation.damaged_again in line for line in said)
    forget()
    said.clear()
    link(Model(sound), CASE, tmp_path, said.append)
    assert said == []


def test_code_that_somebody_has_replaced_is_not_executed(tmp_path, fresh):
    """The code of another circuit in the place of this one, without its sum."""
    link(Model(sound), CASE, tmp_path)
    (mine,) = [
        path for path in tmp_path.iterdir() if path.stat().st_size == max(p.stat().st_size for p in tmp_path.iterdir())
    ]
    mine.write_bytes(mine.read_bytes().partition(b"\n")[0] + b"\n[]\nother code")
    forget()
    assert rates_of(link(Model(sound), CASE, tmp_path), CASE).tolist() == [-2.0]


def test_a_full_disk_leaves_no_part_of_a_file(tmp_path):
    text = """
        import resource, signal
        from pathlib import Path
        from vvdp.base.errors import RunError
        from vvdp.simulation.cache import keep
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))
        try:
            keep("large", b"x" * 100_000, Path(CACHE))
        except RunError as problem:
            print(problem)
    """.replace("CACHE", repr(str(tmp_path / "kept")))
    assert "VVDP_CACHE" in run_python(text, tmp_path, tmp_path / "unused")
    assert list((tmp_path / "kept").iterdir()) == []


def test_what_was_not_used_for_longest_makes_room(tmp_path, monkeypatch):
    for number, name in enumerate(("old", "used", "new")):
        keep(name, b"x" * 1000, tmp_path)
        for path in tmp_path.glob(f"{name}-*"):
            os.utime(path, (number, number))
    assert read_kept("used", tmp_path) == b"x" * 1000  # which counts as a use
    monkeypatch.setattr(cache, "MOST_BYTES", 3 * 1065)
    keep("newest", b"x" * 1000, tmp_path)
    assert {path.name.partition("-")[0] for path in tmp_path.iterdir()} == {"used", "new", "newest"}
    assert kept_bytes(tmp_path) == 3 * 1065


def test_a_processor_level_is_part_of_the_key(tmp_path):
    text = """
        from test_link import CASE, Model, link, rates_of, sound
        print(rates_of(link(Model(sound), CASE), CASE)[0])
    """
    found = [run_python(text, Path(__file__).parent, tmp_path, {"VVDP_PROCESSOR": v}) for v in ("", "x86-64-v2")]
    assert found == ["-2.0\n"] * 2
    names = [path.name.partition("-")[0] for path in tmp_path.iterdir()]
    assert len(names) == 2 * len(set(names))
    with pytest.raises(subprocess.CalledProcessError) as caught:
        run_python(text, Path(__file__).parent, tmp_path, {"VVDP_PROCESSOR": "fast"})
    assert wording.simulation.no_level in caught.value.stderr


def test_two_threads_and_two_processes_at_once_on_an_empty_cache(tmp_path):
    text = """
        from concurrent.futures import ThreadPoolExecutor
        from test_link import CASE, Model, link, rates_of, sound
        with ThreadPoolExecutor(2) as pool:
            linked = pool.map(lambda _: link(Model(sound), CASE), range(4))
            print([float(rates_of(each, CASE)[0]) for each in linked])
    """
    with ThreadPoolExecutor(2) as pool:
        found = list(pool.map(lambda _: run_python(text, Path(__file__).parent, tmp_path), range(2)))
    assert found == ["[-2.0, -2.0, -2.0, -2.0]\n"] * 2
    assert not [path for path in tmp_path.iterdir() if path.name.startswith(".")]


def test_cache_that_cannot_be_written_is_told(tmp_path, fresh):
    place = tmp_path / "file"
    place.write_text("")
    with pytest.raises(RunError, match="VVDP_CACHE"):
        link(Model(sound), CASE, place)


@pytest.mark.skipif(not hasattr(os, "getuid"), reason="files have no owner")
def test_cache_that_others_may_write_to_is_not_executed(tmp_path, fresh):
    cache = tmp_path / "cache"
    link(Model(sound), CASE, cache)
    forget()
    cache.chmod(0o777)
    with pytest.raises(
        RunError, match=rf"{wording.simulation.others_may_write_to} {cache}; chmod go-w .* or set VVDP_CACHE"
    ):
        link(Model(sound), CASE, cache)


@pytest.mark.skipif(not hasattr(os, "getuid"), reason="files have no owner")
def test_whose_folders_matter(tmp_path, monkeypatch):
    cache = tmp_path / "parent" / "cache"
    cache.mkdir(parents=True)
    check_private(cache)
    cache.parent.chmod(0o777)
    with pytest.raises(RunError, match=f"{wording.simulation.others_may_write_to} {cache.parent}"):
        check_private(cache)
    cache.parent.chmod(0o1777)  # sticky, as /tmp: nobody but its owner can take the folder away
    check_private(cache)
    monkeypatch.setattr(os, "getuid", lambda: cache.stat().st_uid + 1)
    with pytest.raises(RunError, match=wording.simulation.belongs_to_another):
        check_private(cache)


@pytest.fixture
def many() -> tuple[Model, Any]:
    """A chain of 32 levels, each with a line of text of its own."""
    names = [f"x{i}" for i in range(32)]
    home = types.ModuleType("chain")
    home.__dict__.update(NamedTuple=NamedTuple, Plain=Plain, Nothing=Nothing, signal_value=signal_value)
    fields = "".join(f"    {name}: Plain\n" for name in names)
    rates = ", ".join(f"p.gain * (s.{names[i - 1]} - s.{name}) * abs(s.{name}) ** 0.5" for i, name in enumerate(names))
    text = f"class Chain(NamedTuple):\n{fields}\ndef chain(t, s, u, p):\n    return Chain({rates}), Nothing(0.0)\n"
    exec(compile(text, known_text(text, "chain"), "exec"), home.__dict__)
    return Model(home.chain), home.Chain(*(float(i) for i in range(32)))


def test_a_network_of_32_states(many):
    model, state = many
    case = Case(state, Gain(gain=2.0))
    np.testing.assert_allclose(rates_of(link(model, case), case), model.circuit(0.0, state, None, case.params)[0])


def chain_of(count):
    """A chain of so many levels, each of which calls a formula."""
    names = [f"x{i}" for i in range(count)]
    fields = "".join(f"    {name}: Plain\n" for name in names)
    rates = ", ".join(f"smooth(s.{names[i - 1]} - s.{name})" for i, name in enumerate(names))
    text = f"class Chain(NamedTuple):\n{fields}\ndef chain(t, s, u, p):\n    return Chain({rates}), Nothing(0.0)\n"
    home = types.ModuleType("long_chain")
    home.__dict__.update(NamedTuple=NamedTuple, Plain=Plain, Nothing=Nothing, smooth=smooth)
    exec(compile(text, known_text(text, "long chain"), "exec"), home.__dict__)
    return Model(home.chain), Case(home.Chain(*(1.0 for _ in names)), Gain(gain=2.0))


def smooth(x):
    y = x
    for _ in range(8):
        y = y + np.sqrt(y * y + 1.0) - abs(x)
    return y


def test_the_code_of_a_circuit_grows_with_its_size():
    """Copied to their place, the formulas of 300 states would take minutes to compile."""
    sizes = [len(linking.ModelAssemblies(*chain_of(count)).circuit.llvm_text()[0]) for count in (150, 300)]
    assert sizes[1] / sizes[0] < 2.2
    assert sizes[1] < 300 * 2000
