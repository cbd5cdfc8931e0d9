"""Functions, classes and modules stay small enough to be read at once; what is larger stands here, with the reason."""

import ast
import io
import tokenize
from collections.abc import Iterator
from typing import NamedTuple

import pytest
from tests.components.conftest import library
from tests.contracts.conftest import tree_of

MOST = {"function": 40, "class": 80, "module": 400, "parameters": 6, "complexity": 10}
"""Lines of code of each, without docstrings, comments and empty lines; parameters; ways through a function."""


class Size(NamedTuple):
    """One measure of one thing: which thing, which measure, how much."""

    name: str
    measure: str
    amount: int


def code_lines(text: str) -> set[int]:
    """Numbers of the lines that hold more than comments."""
    silent = {tokenize.COMMENT, tokenize.NL, tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT, tokenize.ENDMARKER}
    tokens = tokenize.generate_tokens(io.StringIO(text).readline)
    return {n for t in tokens if t.type not in silent for n in range(t.start[0], t.end[0] + 1)}


def described_lines(tree: ast.AST) -> set[int]:
    """Numbers of the lines that descriptions of modules, classes, functions and values take."""
    texts = (n for n in ast.walk(tree) if isinstance(n, ast.Expr) and isinstance(n.value, ast.Constant))
    return {n for each in texts if isinstance(each.value.value, str) for n in range(each.lineno, each.end_lineno + 1)}


def parameters(function: ast.FunctionDef) -> int:
    """How many arguments a function takes, but for the object that a method belongs to."""
    a = function.args
    named = [each.arg for each in (*a.posonlyargs, *a.args, *a.kwonlyargs)]
    return len(named) - (named[:1] in (["self"], ["cls"])) + bool(a.vararg) + bool(a.kwarg)


BRANCHES = (ast.If, ast.For, ast.While, ast.ExceptHandler, ast.match_case)


def own_nodes(function: ast.AST) -> Iterator[ast.AST]:
    """What stands in a function, but not in functions within it."""
    for child in ast.iter_child_nodes(function):
        if not isinstance(child, ast.FunctionDef | ast.ClassDef):
            yield child
            yield from own_nodes(child)


def complexity(function: ast.FunctionDef) -> int:
    """One more than the statements at which a function may go two ways, as McCabe counts."""
    return 1 + sum(isinstance(node, BRANCHES) for node in own_nodes(function))


def named(node: ast.AST, where: str) -> Iterator[tuple[str, ast.FunctionDef | ast.ClassDef]]:
    for child in ast.iter_child_nodes(node):
        if isinstance(child, ast.FunctionDef | ast.ClassDef):
            yield f"{where}.{child.name}", child
            yield from named(child, f"{where}.{child.name}")
        else:
            yield from named(child, where)


def sizes(text: str, module: str, tree: ast.Module) -> Iterator[Size]:
    """Every measure of a module and of what it defines."""
    lines = code_lines(text) - described_lines(tree)
    yield Size(module, "module", len(lines))
    for name, each in named(tree, module):
        length = sum(n in lines for n in range(each.lineno, each.end_lineno + 1))
        if isinstance(each, ast.ClassDef):
            yield Size(name, "class", length)
        else:
            yield Size(name, "function", length)
            yield Size(name, "parameters", parameters(each))
            yield Size(name, "complexity", complexity(each))


def excesses(text: str, module: str, tree: ast.Module) -> list[Size]:
    return [size for size in sizes(text, module, tree) if size.amount > MOST[size.measure]]


@pytest.fixture(scope="module")
def too_large(source) -> dict[str, list[Size]]:
    """What exceeds a limit, by its name below vvdp; a law has an argument for each port, input and value."""
    found: dict[str, list[Size]] = {}
    laws = {f"{each.law.__module__}.{each.law.__name__}".removeprefix("vvdp.") for each in library()}
    for path in sorted(source.rglob("*.py")):
        module = ".".join(path.relative_to(source).with_suffix("").parts)
        for size in excesses(path.read_text("utf-8"), module, tree_of(path)):
            if size.measure != "parameters" or size.name not in laws:
                found.setdefault(size.name, []).append(size)
    return found


GOES_BY = "what is known of a record while it goes by, one state; or a sentence for each thing that it may show"
COMPILED = (
    "compiled code: its state is plain arrays and numbers, and a record for each call would cost more than it tells"
)
ONE_PASS = "one pass in the order in which things happen; parts would hand a dozen numbers to each other"
ONE_SAMPLE = "one sample as it passes, compiled: cut up, its parts would return most of a memory each"
ONE_CALL = "the call a person makes: all but the first few arguments have defaults and are given by name"
LAW = "a law's arguments are the ports, inputs and values of its component, one each"
TEXT_WRITER = "the shared state of one text that is written; the parts are already functions of their own"
DRAWN_FILE = "one table of a drawn file after the other, each with its faults"
RECORD = "a record that is filled by name, one line for each of its fields"
FACADE = "one value with what it can be asked, each answer a few lines"
CHOICE = "one branch for each case of a closed list"
ALLOWED = {
    "components.rotary_valve.rotary_valve": RECORD,
    "estimation.baselines.torque_filter._after_edge": ONE_SAMPLE,
    "estimation.event_filter.take_in": ONE_SAMPLE,
    "estimation.fusion._after_pressure_edge": ONE_SAMPLE,
    "estimation.index.index_after_edge": ONE_SAMPLE,
    "estimation.pressure_edges.pressure_edges_step": ONE_SAMPLE,
    "network.classes.Classes": TEXT_WRITER,
    "network.functions.Functions": TEXT_WRITER,
    "network.network.Network": FACADE,
    "network.network.Network.program": ONE_CALL,
    "network.paths.Places": TEXT_WRITER,
    "network.text.Text": TEXT_WRITER,
    "sensing.encoder.encoder_reading": ONE_SAMPLE,
    "simulation.guest.derive": COMPILED,
    "simulation.guest.enter": COMPILED,
    "simulation.guest.indicate": COMPILED,
    "simulation.landing.arc": COMPILED,
    "simulation.landing.lateness": COMPILED,
    "simulation.landing.positions": COMPILED,
    "simulation.landing.settle": COMPILED,
    "simulation.lane_loop.cube": COMPILED,
    "simulation.lane_loop.is_late": COMPILED,
    "simulation.lane_loop.judge": COMPILED,
    "simulation.lane_loop.land": COMPILED,
    "simulation.lane_loop.load": COMPILED,
    "simulation.lane_loop.run_lanes": COMPILED,
    "simulation.lane_vectors.call": COMPILED,
    "simulation.lane_vectors.stage": COMPILED,
    "simulation.lane_vectors.sweep": COMPILED,
    "simulation.loop.batch": COMPILED,
    "simulation.loop.first_change": COMPILED,
    "simulation.loop.run": "compiled code, one loop for all circuits: steps, events, samples, marks in one order",
    "simulation.marks.mark_fraction": COMPILED,
    "simulation.marks.pass_marks": COMPILED,
    "simulation.marks.store_records": COMPILED,
    "simulation.pace.grow": COMPILED,
    "simulation.run._carry": COMPILED,
    "simulation.run.simulate": ONE_CALL,
    "simulation.schedule.ask": COMPILED,
    "simulation.schedule.begin": COMPILED,
    "simulation.schedule.instant": COMPILED,
    "simulation.steps.explicit_step": COMPILED,
    "simulation.steps.widen": COMPILED,
    "simulation.stiff.differences": COMPILED,
    "simulation.stiff.stiff_step": COMPILED,
    "evaluation.bench.RotaryBench": FACADE,
    "systems.drawing.Drawer": DRAWN_FILE,
    "valve.torque.spool_torque": LAW,
}
"""What may exceed a limit, by its name below vvdp, with the reason."""


def test_everything_is_small_or_has_a_reason(too_large):
    found = [size for name in sorted({*too_large} - {*ALLOWED}) for size in too_large[name]]
    assert found == []


def test_each_exception_is_still_needed(too_large):
    assert sorted({*ALLOWED} - {*too_large}) == []


LONG = "def f():\n" + "    x = 1\n" * 40
MANY_WAYS = "def f(x):\n" + "    if x:\n        x = 1\n" * 10


@pytest.mark.parametrize(
    ("text", "measure", "amount"),
    [
        (LONG, "function", 41),
        ("class A:\n" + "    x = 1\n" * 80, "class", 81),
        ("x = 1\n" * 401, "module", 401),
        ("class A:\n    def f(self, a, b, c, *, d=1, e=2, f=3, **g): pass", "parameters", 7),
        (MANY_WAYS, "complexity", 11),
    ],
)
def test_what_is_too_large_is_seen(text, measure, amount):
    assert [(size.measure, size.amount) for size in excesses(text, "m", ast.parse(text))] == [(measure, amount)]


@pytest.mark.parametrize(
    "text",
    [
        'def f():\n    """A.\n\n' + "    B.\n" * 50 + '    """\n    # why\n\n' + "    x = 1\n" * 38,
        LONG.replace("    x = 1\n", "", 1),
        MANY_WAYS.replace("    if x:\n        x = 1\n", "", 1) + "    def g(y):\n        if y: y = 1\n",
        "def f(a, b, c, d, e, f): pass",
    ],
)
def test_what_is_small_enough_passes(text):
    assert excesses(text, "m", ast.parse(text)) == []
