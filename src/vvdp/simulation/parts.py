"""The texts of the functions of a model over flat vectors, as compiled code has them."""

import ast
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from vvdp.base.signal import Signal
from vvdp.generator.kinds import FLOAT, INT, Address, External, Kind, Row, Scalar, stand_in
from vvdp.generator.source import LanguageError, known_text, read_source
from vvdp.simulation.flat import record_value, signal, store, view
from vvdp.simulation.layout import blocks, members
from vvdp.simulation.model import Case, Model, Program
from vvdp.simulation.text import Classes, Place, numbers, parameters, remember, retell, told_size, write
from vvdp.simulation.values import names

VECTOR = Row(FLOAT, (None,))


@dataclass(frozen=True)
class Part:
    """A function over flat vectors: its name and text, what it calls by name, and the types of its arguments."""

    name: str
    source: str
    called: Mapping[str, Any]
    classes: Classes
    kinds: tuple[Kind, ...]
    result: Scalar | None = None

    def function(self) -> Callable[..., Any]:
        """The function of this text, whose lines are known to readers of its source."""
        known = {"np": np, "signal": signal, "view": view, "store": store, **self.called}
        known |= dict(self.classes.tuples())
        known |= {name: stand_in(cls) for name, cls in self.classes.records()}
        exec(compile(self.source, known_text(self.source, self.name), "exec"), known)
        found: Callable[..., Any] = known[self.name]
        return found


class _Arguments:
    """Sources of the arguments of a circuit's functions, and the lines that calculate where their numbers are."""

    def __init__(self, case: Case) -> None:
        self.classes, self.lines = Classes(), list[str]()
        place = Place()
        self.params = parameters(case.params, place, self.classes)
        self.command = numbers(case.command, "u", Place(), place, self.lines, self.classes)
        self.held = int(place.offset)
        self.state = numbers(case.state, "y", Place(), Place(), [], self.classes)


def rates_part(model: Model, case: Case) -> Part:
    """rates(t, y, u, p, dy), with the modes behind the rates in `dy`."""
    a = _Arguments(case)
    lines = ["def rates(t, y, u, p, dy):", *a.lines]
    place = Place()
    lines.append(f"    {_results(case)} = circuit(t, {a.state}, {a.command}, {a.params})")
    write(case.state, "value", "dy", place, lines)
    if "modes" in names(case.command):
        write(case.command.modes, "modes", "dy", place, lines)
    return _part("rates", lines, {"circuit": model.circuit}, a.classes)


def outputs_part(model: Model, case: Case, *, shapes: bool = True) -> Part:
    """outputs(t, y, u, p, o), what the circuit shows to sensors; with `shapes` that of an array before its numbers."""
    a = _Arguments(case)
    lines = ["def outputs(t, y, u, p, o):", *a.lines]
    lines.append(f"    {_results(case)} = circuit(t, {a.state}, {a.command}, {a.params})")
    write(example_outputs(model, case), "outputs", "o", Place(), lines, shapes=shapes)
    return _part("outputs", lines, {"circuit": model.circuit}, a.classes)


def stored_part(stored: Callable[..., Any], case: Case) -> Part:
    """stored(t, y, p, s), what the circuit holds."""
    classes = Classes()
    params = parameters(case.params, Place(), classes)
    state = numbers(case.state, "y", Place(), Place(), [], classes)
    lines = ["def stored(t, y, p, s):", f"    value = held({state}, {params})"]
    write(stored(case.state, case.params), "value", "s", Place(), lines)
    return _part("stored", [*lines, "    return"], {"held": stored}, classes)


def stop_part(model: Model, case: Case) -> Part:
    """stop(t, u, p) -> float"""
    a = _Arguments(case)
    lines = ["def stop(t, u, p):", *a.lines, f"    return float(jump(t, {a.command}, {a.params}))"]
    return _part("stop", lines, {"jump": model.stop}, a.classes, result=FLOAT)


def events_part(model: Model, case: Case) -> Part:
    """events(t, y, u, p, g)"""
    a = _Arguments(case)
    called: dict[str, Callable[..., Any]] = {"mark": model.mark}
    lines = ["def events(t, y, u, p, g):", *a.lines]
    lines.append(f"    state, command, params = {a.state}, {a.command}, {a.params}")
    lines.append("    g[0] = mark(t, state, command, params)")
    for name, program in model.programs.items():
        if program.trigger:
            number = len(called)
            called[f"trigger_{number}"] = program.trigger
            settings = parameters(case.settings[name], Place(blocks(case).programs[name]), a.classes)
            lines.append(f"    g[{number}] = trigger_{number}(t, state, command, params, {settings})")
    return _part("events", lines, called, a.classes)


def signals_part(case: Case) -> Part:
    """signals(t, p, s), the value of each signal of the circuit's parameters, in their order."""
    classes, place, sources = Classes(), Place(), list[str]()
    for _, leaf in members(case.params, ""):
        source = parameters(leaf, place, classes)
        sources += [source] if isinstance(leaf, Signal) else []
    lines = ["def signals(t, p, s):", *(f"    s[{i}] = value(t, {text})" for i, text in enumerate(sources))]
    return _part("signals", [*lines, "    return"], {"value": record_value}, classes)


def conditions_part(conditions: Callable[..., Any], case: Case) -> Part:
    """hold(t, p, c)"""
    a = _Arguments(case)
    lines = ["def hold(t, p, c):", f"    held_from = int(p[{a.held}])", f"    value = conditions(t, {a.params})"]
    write(case.command.held, "value", "c", Place(0, "held_from"), lines)
    return _part("hold", lines, {"conditions": conditions}, a.classes)


def measure_part(model: Model, program: Program, case: Case) -> Part:
    """measure(t, y, u, p, o, r), from the numbers of `outputs_part`."""
    a = _Arguments(case)
    lines = ["def measure(t, y, u, p, o, r):", *a.lines]
    outputs = "0.0"
    if needs_outputs(program.measure):
        outputs = retell(example_outputs(model, case), "o", Place(), lines, a.classes)
    lines += [f"    reading = sensor(t, {a.state}, {outputs}, {a.params})"]
    write(example_reading(model, program, case), "reading", "r", Place(), lines, shapes=True)
    return _part("measure", lines, {"sensor": program.measure}, a.classes)


def step_part(model: Model, name: str, case: Case) -> Part:
    """step(t, m, r, p, c, k); `k` is where the program's block begins in `p`."""
    program, classes, lines = model.programs[name], Classes(), list[str]()
    block = Place(0, "k")
    settings = parameters(case.settings[name], block, classes)
    begins = [f"    m_from, c_from = int(p[{block}]), int(p[{Place(block.offset + 1, 'k')}])"]
    shapes, end = Place(block.offset + 2, "k"), Place(0, "m_from")
    memory = numbers(case.memory[name], "m", end, shapes, lines, classes)
    reading = retell(example_reading(model, program, case), "r", Place(), lines, classes)
    head = ["def step(t, m, r, p, c, k):", *begins, *lines]
    lines = [*head, f"    memory, command = advance(t, {memory}, {reading}, {settings})"]
    if hasattr(case.command, name):
        write(getattr(case.command, name), "command", "c", Place(0, "c_from"), lines)
    lines += remember(case.memory[name], "memory", "m_from", str(end))
    return _part("step", lines, {"advance": program.step}, classes)


@dataclass(frozen=True)
class Sampled:
    """A program as the joining function calls it: the symbols of its sensor and step, its block, and the numbers of
    its reading and of the outputs that it needs."""

    measure: str
    step: str
    block: int
    reading: int
    outputs: int


def sample_part(held: str | None, outputs: str, programs: Sequence[Sampled]) -> Part:
    """sample(which, t, y, u, m, p, c), which calls what lies at the symbols of the other parts."""
    called: dict[str, Any] = {}
    lines = ["def sample(which, t, y, u, m, p, c):"]
    if held is not None:
        called["hold"] = External(held, Address((FLOAT, VECTOR, VECTOR), None))
        lines += ["    if which == 0:", "        hold(t, p, c)"]
    for number, program in enumerate(programs, 1):
        called[f"measure_{number}"] = External(program.measure, Address((FLOAT, *[VECTOR] * 5), None))
        called[f"step_{number}"] = External(program.step, Address((FLOAT, *[VECTOR] * 4, INT), None))
        lines += [f"    if which == {number}:", f"        r = np.empty({max(1, program.reading)})"]
        lines += [f"        o = np.empty({max(1, program.outputs)})"]
        if program.outputs:
            called["outputs"] = External(outputs, Address((FLOAT, *[VECTOR] * 4), None))
            lines += ["        outputs(t, y, u, p, o)"]
        lines += [f"        measure_{number}(t, y, u, p, o, r)"]
        lines += [f"        step_{number}(t, m, r, p, c, {program.block})"]
    return _part("sample", [*lines, "    return"], called, Classes())


def _part(
    name: str, lines: Sequence[str], called: Mapping[str, Any], classes: Classes, *, result: Scalar | None = None
) -> Part:
    kinds: dict[str, Kind] = {"t": FLOAT, "which": INT, "k": INT}
    head = lines[0]
    arguments = head[head.index("(") + 1 : head.index(")")].split(", ")
    return Part(
        name=name,
        source="\n".join(lines) + "\n",
        called=called,
        classes=classes,
        kinds=tuple(kinds.get(each, VECTOR) for each in arguments),
        result=result,
    )


def _results(case: Case) -> str:
    return "value, outputs, modes" if "modes" in names(case.command) else "value, outputs"


def example_outputs(model: Model, case: Case) -> Any:
    """Outputs of the circuit at the start."""
    return model.circuit(0.0, case.state, case.command, case.params)[1]


def example_reading(model: Model, program: Program, case: Case) -> Any:
    """Measured values of the program at the start."""
    return program.measure(0.0, case.state, example_outputs(model, case), case.params)


def outputs_size(model: Model, case: Case) -> int:
    """How many numbers `outputs_part` writes."""
    return told_size(example_outputs(model, case))


def needs_outputs(measure: Callable[..., Any]) -> bool:
    """Whether a sensor reads the circuit's outputs, its third argument."""
    try:
        node = read_source(measure).node
    except LanguageError:
        return True
    arguments = [each.arg for each in node.args.args]
    if len(arguments) < 3:
        return True
    return any(isinstance(each, ast.Name) and each.id == arguments[2] for each in ast.walk(node))
