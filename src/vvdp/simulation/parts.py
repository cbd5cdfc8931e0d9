"""The texts of the modules that a model is compiled in: one for each of its functions, and one that joins them."""

import dis
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from vvdp.base.signal import Signal
from vvdp.simulation.layout import blocks, members
from vvdp.simulation.model import Case, Model, Program
from vvdp.simulation.text import Classes, Place, numbers, parameters, remember, retell, told_size, write
from vvdp.simulation.values import names

VECTOR = "float64[::1]"
STEP_EFFORT = 3.5
"""A sampled step has loops and branches, which formulas have not."""


@dataclass(frozen=True)
class Part:
    """A module to be compiled: its text, the functions called in it by name, and what it is to a person.

    What has no title is compiled without a word. `effort` is how much longer it takes than formulas of the same length.
    """

    source: str
    called: Mapping[str, Callable[..., Any]]
    classes: Classes
    title: str = ""
    effort: float = 1.0


@dataclass(frozen=True)
class Sampled:
    """What the joining module knows of a program: its symbols, its block, and how many numbers its reading has."""

    measure: str
    step: str
    block: int
    reading: int


class _Arguments:
    """Sources of the arguments of a circuit's functions, and the lines that work out where their numbers are."""

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
    lines = [_njit("void", 4, "rates(t, y, u, p, dy)"), *a.lines]
    place = Place()
    lines.append(f"    {_results(case)} = circuit(t, {a.state}, {a.command}, {a.params})")
    write(case.state, "value", "dy", place, lines)
    if "modes" in names(case.command):
        write(case.command.modes, "modes", "dy", place, lines)
    name = getattr(model.circuit, "__name__", "circuit").removesuffix("circuit").strip("_")
    return Part(_source(a.classes, lines), {"circuit": model.circuit}, a.classes, f"the circuit {name}".rstrip())


def stop_part(model: Model, case: Case) -> Part:
    """stop(t, u, p) -> float"""
    a = _Arguments(case)
    lines = [_njit("float64", 2, "stop(t, u, p)"), *a.lines]
    lines.append(f"    return float(jump(t, {a.command}, {a.params}))")
    return Part(_source(a.classes, lines), {"jump": model.stop}, a.classes)


def events_part(model: Model, case: Case) -> Part:
    """events(t, y, u, p, g)"""
    a = _Arguments(case)
    called: dict[str, Callable[..., Any]] = {"mark": model.mark}
    lines = [_njit("void", 4, "events(t, y, u, p, g)"), *a.lines]
    lines.append(f"    state, command, params = {a.state}, {a.command}, {a.params}")
    lines.append("    g[0] = mark(t, state, command, params)")
    for name, program in model.programs.items():
        if program.trigger:
            number = len(called)
            called[f"trigger_{number}"] = program.trigger
            settings = parameters(case.settings[name], Place(blocks(case).programs[name]), a.classes)
            lines.append(f"    g[{number}] = trigger_{number}(t, state, command, params, {settings})")
    return Part(_source(a.classes, lines), called, a.classes)


def signals_part(case: Case) -> Part:
    """signals(t, p, s), the value of each signal of the circuit's parameters, in their order."""
    classes, place, sources = Classes(), Place(), list[str]()
    for _, leaf in members(case.params, ""):
        source = parameters(leaf, place, classes)
        sources += [f"{source}.value"] if isinstance(leaf, Signal) else []
    lines = [_njit("void", 2, "signals(t, p, s)"), *(f"    s[{i}] = {text}" for i, text in enumerate(sources))]
    return Part(_source(classes, [*lines, "    return"]), {}, classes)


def conditions_part(conditions: Callable[..., Any], case: Case) -> Part:
    """exported(t, p, c), with addresses for vectors"""
    a = _Arguments(case)
    lines = [_outside(2, "exported(t, p_place, c_place)"), "    p, c = vector(p_place), vector(c_place)"]
    lines += [f"    held_from = int(p[{a.held}])", f"    value = conditions(t, {a.params})"]
    write(case.command.held, "value", "c", Place(0, "held_from"), lines)
    return Part(_source(a.classes, lines), {"conditions": conditions}, a.classes)


def measure_part(model: Model, program: Program, case: Case) -> tuple[Part, int]:
    """exported(t, y, u, p, r), with addresses for vectors, and how many numbers it writes to `r`."""
    a, reading = _Arguments(case), example_reading(model, program, case)
    called = {"measure": program.measure}
    lines = [_outside(4, "exported(t, y_place, u_place, p_place, r_place)")]
    lines.append("    y, u, p, r = vector(y_place), vector(u_place), vector(p_place), vector(r_place)")
    lines += [*a.lines, f"    state, command, params = {a.state}, {a.command}, {a.params}", "    outputs = 0.0"]
    if needs_outputs(program.measure):
        called["circuit"] = model.circuit
        lines[-1] = f"    {_results(case)} = circuit(t, state, command, params)"
    lines.append("    reading = measure(t, state, outputs, params)")
    write(reading, "reading", "r", Place(), lines, shapes=True)
    return Part(_source(a.classes, lines), called, a.classes), told_size(reading)


def step_part(model: Model, name: str, case: Case) -> Part:
    """exported(t, m, r, p, c, k), with addresses for vectors; `k` is where the program's block begins in `p`."""
    program, classes, lines = model.programs[name], Classes(), list[str]()
    block = Place(0, "k")
    settings = parameters(case.settings[name], block, classes)
    begins = [f"    m_from, c_from = int(p[{block}]), int(p[{Place(block.offset + 1, 'k')}])"]
    shapes, end = Place(block.offset + 2, "k"), Place(0, "m_from")
    memory = numbers(case.memory[name], "m", end, shapes, lines, classes)
    reading = retell(example_reading(model, program, case), "r", Place(), lines, classes)
    head = [_outside(4, "exported(t, m_place, r_place, p_place, c_place, k)", ", int64")]
    head.append("    m, r, p, c = vector(m_place), vector(r_place), vector(p_place), vector(c_place)")
    lines = [*head, *begins, *lines, f"    memory, command = step(t, {memory}, {reading}, {settings})"]
    if hasattr(case.command, name):
        write(getattr(case.command, name), "command", "c", Place(0, "c_from"), lines)
    lines += remember(case.memory[name], "memory", "m_from", str(end))
    return Part(_source(classes, lines), {"step": program.step}, classes, f"the program {name}", STEP_EFFORT)


def sample_part(held: str | None, programs: Sequence[Sampled]) -> Part:
    """sample(which, t, y, u, m, p, c), which calls what lies at the symbols of the other modules."""
    places = "float64, " + ", ".join(["intp"] * 4)
    lines = [] if held is None else [f"held = types.ExternalFunction({held!r}, void(float64, intp, intp))"]
    for number, program in enumerate(programs, 1):
        lines.append(f"measure_{number} = types.ExternalFunction({program.measure!r}, void({places}))")
        lines.append(f"step_{number} = types.ExternalFunction({program.step!r}, void({places}, int64))")
    lines += ["", "", f"@njit(void(int64, float64, *[{VECTOR}] * 5), cache=True, error_model='numpy')"]
    lines += ["def sample(which, t, y, u, m, p, c):"]
    if held is not None:
        lines += ["    if which == 0:", "        held(t, address(p), address(c))"]
    for number, program in enumerate(programs, 1):
        lines += [f"    if which == {number}:", f"        r = np.empty({max(1, program.reading)})"]
        lines += [f"        measure_{number}(t, address(y), address(u), address(p), address(r))"]
        lines += [f"        step_{number}(t, address(m), address(r), address(p), address(c), {program.block})"]
        lines += ["        r[0] = 0.0  # used once more, so that it is not freed while the step reads it"]
    lines += ["    return"]
    classes = Classes()
    return Part(_source(classes, lines), {}, classes)


def _results(case: Case) -> str:
    return "value, outputs, modes" if "modes" in names(case.command) else "value, outputs"


def example_reading(model: Model, program: Program, case: Case) -> Any:
    """What the program measures at the start."""
    outputs = model.circuit(0.0, case.state, case.command, case.params)[1]
    return program.measure(0.0, case.state, outputs, case.params)


def needs_outputs(measure: Callable[..., Any]) -> bool:
    """Whether a sensor reads the circuit's outputs, its third argument."""
    code = getattr(measure, "__code__", None)
    if code is None or code.co_argcount < 3:
        return True
    name, found = code.co_varnames[2], False
    for instruction in dis.get_instructions(code):
        value = instruction.argval
        found |= name == value or (isinstance(value, tuple) and name in value)
    return found


def symbol(digest: str) -> str:
    """The name under which a compiled function is found by others."""
    return f"vvdp_{digest}"


def _njit(result: str, vectors: int, signature: str) -> str:
    kinds = f"{result}(float64, *[{VECTOR}] * {vectors})"
    return f"@njit({kinds}, cache=True, error_model='numpy', _nrt=False)\ndef {signature}:"


def _outside(places: int, signature: str, more: str = "") -> str:
    kinds = f"void(float64, {', '.join(['intp'] * places)}{more})"
    return f"@njit({kinds}, cache=True, error_model='numpy')\ndef {signature}:"


def _source(classes: Classes, lines: Sequence[str]) -> str:
    return "\n".join([*classes.heading(), "", "", *lines]) + "\n"
