"""Part of a system that is exported as C: its circuit, or the step of one of its programs."""

import hashlib
import itertools
import linecache
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, is_dataclass, replace
from enum import Enum
from types import FunctionType
from typing import Any, NamedTuple

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.kinds import Time
from vvdp.export.c_structs import Classes, store_lines, value_text
from vvdp.generator.c_room import Amount
from vvdp.generator.c_writer import CModule, shown_file
from vvdp.generator.kinds import FLOAT, Kind, Row, stand_in
from vvdp.generator.tree import Module
from vvdp.generator.unit import Options, Unit
from vvdp.generator.verify import verify
from vvdp.simulation import dialect
from vvdp.simulation.model import Case, Model, Program
from vvdp.simulation.reach import compiled_form
from vvdp.simulation.values import as_value, flat, leaves

ROW_LINE = re.compile(r"memory\[(\d+):(\d+)\] = (.*)")
"""A line that writes an array of a memory back."""

IN, OUT, KEPT = "in", "out", "kept"


class Precision(Enum):
    """The type of all numbers of exported code: its C name, and its size in bytes.

    `tolerance` is the largest difference from double precision that a test accepts, as a share of the largest value of
    a number.
    """

    DOUBLE = ("double", 8, 0.0)
    SINGLE = ("float", 4, 1e-3)

    def __init__(self, real: str, size: int, tolerance: float) -> None:
        self.real, self.size, self.tolerance = real, size, tolerance


class Stop(NamedTuple):
    """When the rates jump next."""

    time: Time


class Mark(NamedTuple):
    """Periods since the beginning, of which each whole number ends one."""

    periods: float


@dataclass(frozen=True)
class Block:
    """An argument of an entry: a struct in C, a flat vector in the text.

    role    IN is read, OUT is written, KEPT is both
    about   its meaning, in words
    drawn   whether its numbers change from one sample of the test to the next
    """

    name: str
    value: Any
    role: str
    about: str
    drawn: bool = False

    @property
    def size(self) -> int:
        """How many numbers it has."""
        return int(flat(self.value).size)


@dataclass(frozen=True)
class Entry:
    """A function that is exported: Python text of a function of `t` and its blocks, and what the text calls."""

    name: str
    about: str
    blocks: tuple[Block, ...]
    lines: tuple[str, ...]
    called: Mapping[str, Callable[..., Any]]
    classes: Classes

    @property
    def arguments(self) -> tuple[Block, ...]:
        """The blocks with a number in them, which are the arguments."""
        return tuple(block for block in self.blocks if block.size)


def program_entry(model: Model, case: Case, name: str) -> Entry:
    """The step of a program."""
    program = model.programs[name]
    outputs = model.circuit(0.0, case.state, case.command, case.params)[1]
    reading = program.measure(0.0, case.state, outputs, case.params)
    classes = Classes()
    values = {"memory": case.memory[name], "reading": reading, "settings": case.settings[name]}
    texts = [_value_text(value, vector, classes) for vector, value in values.items()]
    lines = [f"new_memory, new_command = function(t, {', '.join(texts)})"]
    lines += _kept_lines(case.memory[name])
    lines += store_lines(program.command, "new_command", "command")
    blocks = (
        Block("memory", case.memory[name], KEPT, "What the program keeps from one sample to the next"),
        Block("reading", reading, IN, "What the sensors measure at this sample", drawn=True),
        Block("settings", case.settings[name], IN, "Settings of the program"),
        Block("command", program.command, OUT, "What the program commands"),
    )
    return Entry(
        name="step",
        about="One sample of the program",
        blocks=blocks,
        lines=tuple(lines),
        called={"function": program.step},
        classes=classes,
    )


def _kept_lines(memory: Any) -> list[str]:
    """Text that writes a memory back, arrays last and all at once: one may be a view of where another belongs."""
    lines = store_lines(memory, "new_memory", "memory")
    rows = [(int(found[1]), int(found[2]), found[3]) for line in lines if (found := ROW_LINE.fullmatch(line))]
    if not rows:
        return lines
    count = sum(end - begin for begin, end, _ in rows)
    beside, after = [f"beside = np.empty({count})"], list[str]()
    place = 0
    for begin, end, value in rows:
        beside.append(f"beside[{place}:{place + end - begin}] = {value}")
        after.append(f"memory[{begin}:{end}] = beside[{place}:{place + end - begin}]")
        place += end - begin
    return [*beside, *(line for line in lines if not ROW_LINE.fullmatch(line)), *after]


def circuit_entries(model: Model, case: Case) -> list[Entry]:
    """The rates of a circuit, and its conditions, stops and marks."""
    results = model.circuit(0.0, case.state, case.command, case.params)
    state = Block("state", case.state, IN, "State of the circuit", drawn=True)
    command = Block("command", case.command, IN, "What holds between two samples: conditions, commands, modes")
    parameters = Block("parameters", case.params, IN, "Parameters of the circuit")
    found = [
        Block("state_rates", results[0], OUT, "Rates of the state, per second"),
        Block("outputs", results[1], OUT, "Outputs of the circuit"),
    ]
    if len(results) > 2:
        found.append(Block("modes", results[2], OUT, "Sides of jumps and kinks: their floors are the modes"))
    entries = [
        _entry("rates", "Rates of the circuit", (state, command, parameters), found, model.circuit),
        _entry("stop", "Next jump of the rates after t", (command, parameters), _single("next_jump", Stop), model.stop),
        _entry("mark", "Periods at a state", (state, command, parameters), _single("mark_value", Mark), model.mark),
    ]
    if model.conditions is not None:
        held = [Block("held", model.conditions(0.0, case.params), OUT, "Conditions, which hold between two samples")]
        entries.append(_entry("conditions", "Conditions at a time", (parameters,), held, model.conditions))
    return entries


def _single(name: str, cls: Any) -> list[Block]:
    return [Block(name, cls(0.0), OUT, str(cls.__doc__).rstrip("."))]


def _entry(name: str, about: str, given: tuple[Block, ...], found: list[Block], function: Callable[..., Any]) -> Entry:
    classes = Classes()
    handed = ", ".join(_value_text(block.value, block.name, classes) for block in given)
    is_single = len(found) == 1
    targets = ", ".join(f"{block.name}_found" for block in found)
    lines = [f"{targets} = function(t, {handed})"]
    for block in found:
        single = is_single and isinstance(block.value, Stop | Mark)
        path = f"{block.name}_found"
        lines += [f"{block.name}[0] = {path}"] if single else store_lines(block.value, path, block.name)
    return Entry(
        name=name,
        about=about,
        blocks=(*given, *found),
        lines=tuple(lines),
        called={"function": function},
        classes=classes,
    )


def _value_text(value: Any, vector: str, classes: Classes) -> str:
    return value_text(value, vector, itertools.count(), classes)


def module_of(entries: Sequence[Entry]) -> Module:
    """The verified tree of entries. Raises LanguageError where a function uses what the language does not have."""
    unit = Unit(model_options())
    for entry in entries:
        kinds: list[Kind] = [FLOAT, *(Row(FLOAT, (block.size,)) for block in entry.arguments)]
        unit.add(function_of(entry), kinds, entry.name)
    return verify(unit.module())


def function_of(entry: Entry) -> FunctionType:
    """The Python function of an entry's text."""
    head = f"def {entry.name}(t, {', '.join(block.name for block in entry.arguments)}):"
    text = "\n".join([head, f'    """{entry.about}."""', *(f"    {line}" for line in entry.lines)]) + "\n"
    file = f"<export of {entry.name} {abs(hash(text))}>"
    linecache.cache[file] = (len(text), None, text.splitlines(keepends=True), file)
    known: dict[str, Any] = {"np": np, **entry.called}
    known |= {name: stand_in(cls) if is_dataclass(cls) else cls for cls, name in entry.classes.names.items()}
    exec(compile(text, file, "exec"), known)
    found: FunctionType = known[entry.name]
    return found


class _Forms(dict[Any, Any]):
    """The function that replaces another in compiled code: its module's `<name>_compiled`, where there is one."""

    def get(self, function: Any, default: Any = None) -> Any:
        form = compiled_form(function) if isinstance(function, FunctionType) else None
        return form or default


def model_options() -> Options:
    """How the functions of models are read: as in a simulation, but for signals, which are plain records here."""
    return replace(dialect.model_options(), replaced=_Forms())


SPREAD = 0.2
"""Of the numbers drawn about the first state, as a share of them and of the scales of their kinds."""


def drawn_values(model: Model, case: Case, name: str | None, times: Sequence[float]) -> list[Array]:
    """Values of the block that changes: random states about the first, or what a program measures at them.

    What accumulates, as an angle does, moves forward from one time to the next.
    """
    draw, first = np.random.default_rng(1), flat(case.state)
    kinds = [kind for _, value, kind in leaves(case.state) for _ in range(int(np.size(value)))]
    scales = np.array([1.0 if kind is None else kind.scale for kind in kinds])
    accumulates = np.array([kind is not None and kind.accumulates for kind in kinds], bool)
    found, passed = list[Array](), np.zeros(first.size)
    for t in times:
        noise = draw.standard_normal(first.size)
        passed += np.where(accumulates, abs(noise) * SPREAD**2 * scales, 0.0)
        y = first + np.where(accumulates, passed, SPREAD * noise * (abs(first) + np.where(first == 0.0, scales, 0.0)))
        found.append(y if name is None else _reading(model, case, name, t, y))
    return found


def _reading(model: Model, case: Case, name: str, t: float, y: Array) -> Array:
    """Measured values of a program at a state."""
    state = as_value(case.state, y)
    outputs = model.circuit(t, state, case.command, case.params)[1]
    return flat(model.programs[name].measure(t, state, outputs, case.params))


@dataclass(frozen=True)
class CPart:
    """A part of a system in C.

    name       begins the name of everything in the text
    entries    its functions
    rooms      by entry, the numbers that it needs on the stack for arrays
    program    the program that is exported; None for a circuit
    period     time between two samples [s]
    precision  of all of its numbers
    """

    name: str
    part: str
    system: str
    entries: tuple[Entry, ...]
    module: Module
    core: CModule
    rooms: Mapping[str, Amount]
    program: Program | None
    period: float
    precision: Precision = Precision.DOUBLE

    @property
    def phase(self) -> float:
        """When the first sample is [s]."""
        return 0.0 if self.program is None else self.program.phase

    @property
    def blocks(self) -> dict[str, Block]:
        """The arguments of all entries by name."""
        return {block.name: block for entry in self.entries for block in entry.arguments}

    @property
    def answers(self) -> bool:
        """Whether it is a program that gives a command for a reading, as most do."""
        return self.program is not None and {"reading", "command"} <= self.blocks.keys()

    @property
    def array_bytes(self) -> int:
        """Bytes of the stack that arrays take; whole numbers have 8 each."""
        return max(self.precision.size * reals + 8 * wholes for reals, wholes in self.rooms.values())

    @property
    def hash(self) -> str:
        """Hash that distinguishes this text from any other."""
        return hashlib.sha256((self.core.header + self.core.source).encode()).hexdigest()[:16]

    @property
    def functions(self) -> list[tuple[str, str]]:
        """Name in C, and file and line of the Python text, of each function."""
        return [(self.core.functions[f.name], f"{shown_file(f.file)}:{f.line}") for f in self.module.functions]
