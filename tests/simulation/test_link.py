"""Joining a model to the compiled loop: what is refused and in which words, and that compiled code is never stale."""

import os
import subprocess
import sys
import textwrap
from pathlib import Path
from typing import Annotated, NamedTuple

import numpy as np
import pytest

from vvdp.base.books import Books, Nothing
from vvdp.base.errors import RunError
from vvdp.base.kinds import Energy, Kind
from vvdp.base.params import Params
from vvdp.simulation.link import link
from vvdp.simulation.model import Case, Model
from vvdp.simulation.run import Stepping, simulate

Plain = Annotated[float, Kind("plain number", "1", -1e9, 1e9, "1")]


class Level(NamedTuple):
    x: Plain


class Other(NamedTuple):
    y: Plain


class Bare(NamedTuple):
    x: float


class Gain(Params):
    gain: Plain


CASE = Case(Level(1.0), Gain(gain=2.0))


def sound(t: float, s: Level, u: Nothing, p: Gain) -> tuple[Level, Nothing]:
    return Level(-p.gain * s.x), Nothing(0.0)


def other_fields(t: float, s: Level, u: Nothing, p: Gain) -> tuple[Other, Nothing]:
    return Other(s.x), Nothing(0.0)


def infinite(t: float, s: Level, u: Nothing, p: Gain) -> tuple[Level, Nothing]:
    return Level(np.sqrt(s.x - 2.0)), Nothing(0.0)


def bare(t: float, s: Bare, u: Nothing, p: Gain) -> tuple[Bare, Nothing]:
    return Bare(s.x), Nothing(0.0)


def forgetful(t: float, memory: Nothing, measured: Level, settings: Nothing) -> tuple[Other, Nothing]:
    return Other(0.0), Nothing(0.0)


def commanding(t: float, memory: Nothing, measured: Level, settings: Nothing) -> tuple[Nothing, Other]:
    return memory, Other(0.0)


def closing(factor):
    def circuit(t, s, u, p):
        return Level(factor * s.x), Nothing(0.0)

    return circuit


class Callable:
    def __call__(self, *arguments):
        return arguments[1], Nothing(0.0)


class Kept(NamedTuple):
    books: Books
    x: Plain


class Sums(NamedTuple):
    all: Energy


class Reading(NamedTuple):
    x: Plain
    books: Books


BLANK = Books(Sums(0.0), Sums(0.0), 0.0, 0.0)


def books_first(t: float, s: Kept, u: Nothing, p: Gain) -> tuple[Kept, Nothing]:
    return Kept(BLANK, -s.x), Nothing(0.0)


def reads_books(t: float, s: Reading, u: Nothing, p: Gain) -> tuple[Reading, Nothing]:
    return Reading(-s.x - s.books.taken_in, BLANK), Nothing(0.0)


class Arrayed(NamedTuple):
    x: Plain
    column: np.ndarray


def arrayed(t: float, s: Arrayed, u: Nothing, p: Gain) -> tuple[Arrayed, Nothing]:
    return Arrayed(s.x, s.column), Nothing(0.0)


@pytest.mark.parametrize(
    ("model", "case", "told"),
    [
        (Model(other_fields), CASE, "the rates of the circuit and its state differ in x, y"),
        (Model(infinite), CASE, "no finite rate at the start for x"),
        (Model(bare), Case(Bare(1.0), Gain(gain=1.0)), "state 'x' has no kind"),
        (Model(sound, program=forgetful), CASE, "the memory that the program returns .* differ in unused, y"),
        (Model(sound, program=commanding), CASE, "the command that the program returns .* differ in unused, y"),
        (Model(closing(2.0)), CASE, "closing.<locals>.circuit closes over variables; hand values over in params"),
        (Model(Callable()), CASE, "is not a plain function"),
        (Model(books_first), Case(Kept(BLANK, 1.0), Gain(gain=1.0)), "books must be the last field"),
        (Model(reads_books), Case(Reading(1.0, BLANK), Gain(gain=1.0)), "reads its own books"),
        (Model(sound), Case(Level(np.nan), Gain(gain=1.0)), "no finite rate at the start for x"),
        (Model(arrayed), Case(Arrayed(1.0, np.zeros(3)), Gain(gain=1.0)), "state 'column' is an array"),
    ],
)
def test_what_does_not_fit_together_is_refused(model, case, told, tmp_path):
    with pytest.raises(RunError, match=told):
        link(model, case, tmp_path)
    assert not any(tmp_path.iterdir())


def uncompilable(t: float, s: Level, u: Nothing, p: Gain) -> tuple[Level, Nothing]:
    return Level(helper_with_words(s.x)), Nothing(0.0)


def helper_with_words(x: float) -> float:
    return float(f"{x:.3f}") + undeclared(x)


def undeclared(x: float) -> float:
    return sorted([x, 1.0], key=str)[0]


def test_what_cannot_be_compiled_is_told_in_one_readable_message(tmp_path):
    with pytest.raises(RunError) as caught:
        link(Model(uncompilable), CASE, tmp_path)
    message = str(caught.value)
    assert "uncompilable" in message
    assert "cannot be compiled" in message
    assert "test_link.py" in message  # where
    assert "Traceback" not in message
    assert len(message.splitlines()) <= 6


def choosing(t: float, s: Level, u: Nothing, p: Gain) -> tuple[Level, Nothing]:
    return Level(-s.x if s.x > 1.0 else s.x), Nothing(0.0)


def test_choice_by_a_state_is_refused_before_it_fails_on_recorded_columns(tmp_path):
    with pytest.raises(RunError, match="choosing chooses by a state; write the choice with select"):
        link(Model(choosing), CASE, tmp_path)


def test_after_a_failed_compilation_the_next_attempt_fails_alike(tmp_path):
    for _ in range(2):
        with pytest.raises(RunError, match="cannot be compiled"):
            link(Model(uncompilable), CASE, tmp_path)


def test_cache_that_cannot_be_written_is_told(tmp_path):
    place = tmp_path / "file"
    place.write_text("")
    with pytest.raises(RunError, match="VVDP_CACHE"):
        link(Model(sound), CASE, place)


def test_linked_rates_are_those_of_the_circuit(tmp_path):
    linked = link(Model(sound), CASE, tmp_path)
    dy = np.zeros(1)
    linked.rates(0.0, np.array([3.0]), np.zeros(1), np.array([2.0]), dy)
    assert dy[0] == -6.0


def test_values_take_no_part_in_the_hash(tmp_path):
    """One compilation serves all values; another shape is another."""
    a = link(Model(sound), CASE, tmp_path).digest
    b = link(Model(sound), Case(Level(7.0), Gain(gain=-1.0)), tmp_path).digest
    assert a == b


def run_python(text: str, folder: Path, cache: Path) -> str:
    """What a fresh interpreter prints."""
    source = Path(__file__).parents[2] / "src"
    path = os.pathsep.join([str(folder), *(p for p in (os.environ.get("PYTHONPATH"), str(source)) if p)])
    environment = {**os.environ, "PYTHONPATH": path, "VVDP_CACHE": str(cache), "PYTHONDONTWRITEBYTECODE": "1"}
    done = subprocess.run(
        [sys.executable, "-c", textwrap.dedent(text)], env=environment, capture_output=True, text=True, check=True
    )
    return done.stdout


FORMULA = """
    FACTOR = {factor}

    def loss(x, gain):
        return {formula}
"""
CIRCUIT = """
    from typing import Annotated, NamedTuple

    from vvdp.base.books import Nothing
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
    from wiring import State, Values, circuit
    from vvdp.simulation.model import Case, Model
    from vvdp.simulation.run import Stepping, simulate

    case = Case(State(0.0), Values(gain=2.0))
    stepping = Stepping(until=1.0, sample_period=0.1, record_interval=1.0, window_interval=1.0)
    run = simulate(Model(circuit), case, stepping, say=print)
    print(repr(float(run.final[0])))
"""


def write(folder: Path, factor: float, formula: str, *, by_module: bool) -> None:
    (folder / "laws.py").write_text(textwrap.dedent(FORMULA).format(factor=factor, formula=formula))
    imported, called = ("import laws", "laws.loss") if by_module else ("from laws import loss", "loss")
    (folder / "wiring.py").write_text(textwrap.dedent(CIRCUIT).format(imported=imported, called=called))


@pytest.mark.parametrize("by_module", [False, True])
def test_changed_formula_in_another_file_is_never_served_stale(by_module, tmp_path):
    """x' = loss: a change of the formula, and of a constant that it uses, both show at once; and nothing is compiled
    twice."""
    cache = tmp_path / "cache"
    write(tmp_path, 3.0, "FACTOR * gain", by_module=by_module)
    first = run_python(PROGRAM, tmp_path, cache).splitlines()
    assert float(first[-1]) == pytest.approx(6.0)
    assert any("compiling the circuit" in line for line in first)

    again = run_python(PROGRAM, tmp_path, cache).splitlines()
    assert again == [first[-1]]  # no word of compiling, and the same to the last digit

    write(tmp_path, 5.0, "FACTOR * gain", by_module=by_module)
    assert float(run_python(PROGRAM, tmp_path, cache).splitlines()[-1]) == pytest.approx(10.0)

    write(tmp_path, 5.0, "FACTOR * gain + 1.0", by_module=by_module)
    assert float(run_python(PROGRAM, tmp_path, cache).splitlines()[-1]) == pytest.approx(11.0)

    write(tmp_path, 3.0, "FACTOR * gain", by_module=by_module)
    assert run_python(PROGRAM, tmp_path, cache).splitlines() == [first[-1]]


def test_classes_of_the_same_name_from_different_modules(tmp_path):
    for name, field in (("left", "a"), ("right", "b")):
        (tmp_path / f"{name}.py").write_text(
            textwrap.dedent(f"""
            from typing import Annotated, NamedTuple
            from vvdp.base.kinds import Kind
            from vvdp.base.params import Params
            Plain = Annotated[float, Kind("plain number", "1", -1e9, 1e9, "1")]
            class Values(Params):
                {field}: Plain
            class Part(NamedTuple):
                {field}: Plain
            """)
        )
    (tmp_path / "wiring.py").write_text(
        textwrap.dedent("""
        from typing import NamedTuple
        import left, right
        from vvdp.base.books import Nothing
        from vvdp.base.params import Params
        class Values(Params):
            left: left.Values
            right: right.Values
        class State(NamedTuple):
            left: left.Part
            right: right.Part
        def circuit(t, s, u, p):
            return State(left.Part(p.left.a), right.Part(p.right.b)), Nothing(0.0)
        """)
    )
    program = """
        import left, right
        from wiring import State, Values, circuit
        from vvdp.simulation.model import Case, Model
        from vvdp.simulation.run import Stepping, simulate
        case = Case(State(left.Part(0.0), right.Part(0.0)), Values(left=left.Values(a=2.0), right=right.Values(b=3.0)))
        stepping = Stepping(until=1.0, sample_period=0.1, record_interval=1.0, window_interval=1.0)
        print(simulate(Model(circuit), case, stepping).final.round(9).tolist())
    """
    assert run_python(program, tmp_path, tmp_path / "cache") == "[2.0, 3.0]\n"
    assert run_python(program, tmp_path, tmp_path / "cache") == "[2.0, 3.0]\n"


class Tabled(NamedTuple):
    table: np.ndarray


class Remembered(NamedTuple):
    matrix: np.ndarray
    count: Plain


def turned(t: float, memory: Remembered, measured: Level, settings: Tabled) -> tuple[Remembered, Other]:
    matrix = memory.matrix @ settings.table
    return Remembered(matrix, memory.count + 1.0), Other(matrix[0, 1])


def driven(t: float, s: Level, u: Other, p: Gain) -> tuple[Level, Nothing]:
    return Level(u.y), Nothing(0.0)


def test_arrays_in_memory_and_settings():
    """The n-th power of a quarter turn: (0, 1) entry -1, 0, 1, 0 ... held over 8 samples of 1/8 s sums to 0, and over 6
    of them, the first held at the start command 0, to -1/8."""
    quarter = np.array([[0.0, -1.0], [1.0, 0.0]])
    case = Case(Level(0.0), Gain(gain=1.0), Other(0.0), Remembered(np.eye(2), 0.0), Tabled(quarter))
    for until, expected in ((1.125, 0.0), (0.75, -1.0 / 8.0)):
        stepping = Stepping(until=until, sample_period=1.0 / 8.0, record_interval=until, window_interval=until)
        run = simulate(Model(driven, program=turned), case, stepping)
        assert run.final[0] == pytest.approx(expected, abs=1e-12)


def jumping(t: float, s: Level, p: Gain) -> float:
    return 1e9 * s.x


def test_mark_that_jumps_is_refused_instead_of_filling_the_memory():
    stepping = Stepping(until=1.0, sample_period=0.1, record_interval=1.0, window_interval=1.0)
    with pytest.raises(RunError, match="marks"):
        simulate(Model(sound, mark=jumping), CASE, stepping)
