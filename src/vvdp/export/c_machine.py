"""A system with its loop as C: one struct of the caller, and functions that start it, carry it on and show it."""

import hashlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.signal import Signal
from vvdp.export.c_powers import C_INTRINSICS
from vvdp.export.c_structs import struct_text
from vvdp.export.machine import NONE, machine_module, parameters_of
from vvdp.generator.c_room import Amount, room_of
from vvdp.generator.c_text import Shared, constant, identifier, length_names, wrap
from vvdp.generator.c_writer import CModule, shown_file, write_c
from vvdp.generator.kinds import FLOAT, Address, Kind, Record, Row
from vvdp.generator.tree import Module
from vvdp.simulation import guest, loop, places
from vvdp.simulation.layout import SIGNAL_SLOTS, blocks, members
from vvdp.simulation.model import Case
from vvdp.simulation.parts import example_outputs
from vvdp.simulation.prepare import Reached, Tables, start_run, tables
from vvdp.simulation.values import flat
from vvdp.systems.system import System

MACHINE = "machine"
FAILED = 100
"""Offset of the number of a failure of the core in the answer of `run`."""
STATUS = (
    "DONE", "PAUSED", "MARKS_FULL", "NOT_FINITE", "STEP_TOO_SMALL", "STOP_BEHIND", "TOO_MANY_WAITING", "RESTLESS",
    "BELOW_ZERO",
)  # fmt: skip
"""Answers of the loop, by number."""
OFTEN = ("rates", "explicit_step")
"""Functions that take most of the time of a run."""
LAST_MARKS = 2
"""Marks for which there is room by default."""
GIVEN = {
    "y": "machine->state", "command": "machine->command", "memory": "machine->memory", "params": "machine->parameters",
    "agenda": "machine->agenda", "waiting": "machine->waiting", "clock": "machine->clock", "course": "machine->course",
    "low": "machine->lowest", "high": "machine->highest", "t_end": "t_end", "budget": "1e300",
    "record_times": "record->times", "record": "record->states", "record_command": "record->commands",
    "record_memory": "record->memories", "span_times": "NULL", "span_states": "NULL",
}  # fmt: skip
"""In the call of the loop, what its arguments are in C."""


@dataclass(frozen=True)
class CMachine:
    """A system with its loop in C.

    name    begins the name of everything in the text
    rooms   by entry, the numbers that it needs on the stack for arrays
    tables  what the loop is handed besides what the machine keeps
    begun   where a run begins
    """

    name: str
    system: System
    module: Module
    core: CModule
    rooms: dict[str, Amount]
    tables: Tables
    begun: Reached

    @property
    def is_guest(self) -> bool:
        """Whether the integrator of another program can carry it."""
        return "enter" in self.module.entries

    @property
    def hash(self) -> str:
        """The identity of this text."""
        return hashlib.sha256((self.core.header + self.core.source).encode()).hexdigest()[:16]

    @property
    def functions(self) -> list[tuple[str, str]]:
        """Name in C, and file and line of the Python text, of each function."""
        return [(self.core.functions[f.name], f"{shown_file(f.file)}:{f.line}") for f in self.module.functions]

    @property
    def flags(self) -> tuple[str, ...]:
        """Flags of the compiler: as for the core, and that it copies numbers by the C library.

        GCC 12.2 with -march=x86-64-v4 copies constants that begin with two equal numbers wrongly.
        """
        return (*self.core.flags, "-fno-builtin-memcpy")

    @cached_property
    def bench(self) -> loop.Workbench:
        """Arrays of the size that the loop works with."""
        return loop.workbench(self.tables.plan, self.begun.state.size, self.tables.width.size, self.tables.pattern)

    @cached_property
    def content(self) -> dict[str, Array]:
        """Content of a machine at the start, by the names of its members."""
        found = dict(zip(("state", "command", "memory"), self.begun, strict=False))
        found |= {"parameters": self.tables.vectors.params}
        found |= {name: getattr(self.begun, name) for name in ("agenda", "waiting", "clock", "course")}
        return {**found, "lowest": self.begun.state, "highest": self.begun.state}

    @property
    def size(self) -> int:
        """Bytes of a machine: what it keeps, room of the loop, and the last marks."""
        numbers: int = sum(max(1, int(each.size)) for each in (*self.content.values(), *self.bench))
        return 8 * (numbers + LAST_MARKS * (1 + self.begun.state.size))


def c_machine(system: System, more: guest.Entries = NONE) -> CMachine:
    """A system with its loop in C, and `more` of `simulation.guest` that a host calls.

    Raises LanguageError, with file and line, where a text cannot be exported.
    """
    module = machine_module(system.model, system.case, more)
    name = identifier(f"{system.name}_{MACHINE}".replace("-", "_"))
    rooms = {}
    for function, room in room_of(module).items():
        if function in module.entries:
            assert room is not None, "all arrays of an exported system have known lengths"
            rooms[function] = room
    found = tables(system.model, system.case, system.stepping)
    return CMachine(
        name=name,
        system=system,
        module=module,
        core=write_c(module, f"{name}_core", C_INTRINSICS, OFTEN),
        rooms=rooms,
        tables=found,
        begun=start_run(found, system.stepping),
    )


HEADER = """\
/* Room for rows of one call of {name}_run. `times` are increasing; a row has the state at its time, and the command and
   the memory that held until then. Marks are the ends of periods; without room for them the last ones are not kept. */
typedef struct {{
    const double *times;
    int64_t rows;
    double *states; /* rows of {states} numbers */
    double *commands; /* of {commands} */
    double *memories; /* of {memories} */
    double *mark_times;
    double *mark_states; /* of {states} */
    int64_t marks;
}} {name}_record;

/* Answers of {name}_run; {failed} and more is a failure of the core. */
enum {{ {answers} }};

/* Sets a machine to the values of the system at t = {begin} s. */
void {name}_start({name}_machine *machine);

/* Carries a machine on to t_end [s]; the answer is 0, or why it could not go on. `record` may be NULL.
   At a t_end at which a sample is due, it is taken before the function returns. */
int {name}_run({name}_machine *machine, double t_end, const {name}_record *record);

/* Outputs of the circuit where the machine stands; the answer is as that of {name}_run. */
int {name}_outputs(const {name}_machine *machine, {name}_output *outputs);

/* Where a machine stands [s]. */
double {name}_time(const {name}_machine *machine);
"""


def header_text(machine: CMachine, more: str = "") -> str:
    """The structs and functions for callers, with `more` of them at the end."""
    name, case = machine.name, machine.system.case
    guard, begin = f"{name.upper()}_H", machine.system.stepping.begin
    shown = example_outputs(machine.system.model, case)
    views = (
        ("state", case.state, "The state, in the order of `state`."),
        ("command", case.command, "Conditions, commands and modes, in the order of `command`."),
        ("output", shown, "Outputs of the circuit."),
    )
    structs = [struct_text(f"{name}_{word}", value, about) for word, value, about in views if flat(value).size]
    if not flat(shown).size:
        structs.append(f"typedef double {name}_output;\n")
    sizes = {word: machine.content[word].size for word in ("state", "command", "memory")}
    said = HEADER.format(
        name=name,
        states=sizes["state"],
        commands=sizes["command"],
        memories=sizes["memory"],
        failed=FAILED,
        answers=", ".join(f"{name.upper()}_{word} = {number}" for number, word in enumerate(STATUS)),
        begin=repr(begin),
    )
    head = f"/* {machine.system.name} with its simulation loop: units are SI, pressures absolute. */\n"
    first = f"#ifndef {guard}\n#define {guard}\n\n#include <stdint.h>\n"
    return "\n".join([first, head, *structs, _machine_struct(machine), wrap_lines(said) + more, "#endif\n"])


def wrap_lines(words: str) -> str:
    """A text with its long lines broken."""
    return "\n".join(map(wrap, words.split("\n")))


def _machine_struct(machine: CMachine) -> str:
    n = machine.begun.state.size
    lines = [f"    double {name}[{max(1, each.size)}];" for name, each in machine.content.items()]
    lines += [f"    double mark_times[{LAST_MARKS}];", f"    double mark_states[{LAST_MARKS * n}];", "    struct {"]
    bench = machine.bench._asdict().items()
    lines += [f"        double {name}[{max(1, each.size)}];" for name, each in bench]
    about = "/* A machine: all that changes while it runs. Copies of it are machines of their own. */"
    return "\n".join([about, "typedef struct {", *lines, "    } bench;", f"}} {machine.name}_machine;", ""])


def facade_text(machine: CMachine) -> str:
    """The functions for callers, and the numbers of the system."""
    name = machine.name
    includes = ["math.h", "stddef.h", "stdint.h", "string.h"]
    parts = [f'#include "{name}.h"\n', *(f"#include <{each}>" for each in includes), f'\n#include "{name}_core.h"\n']
    for key, first in _first_numbers(machine).items():
        parts.append(f"{_head(key)}\n{numbers_text(first)}\n}};\n")
    rows = "\n".join(parameter_lines(machine))
    parts.append(
        f"/* Parameters, with their keys; values over time have four numbers. */\n{_head('parameters')}\n{rows}"
    )
    parts.append("};\n")
    for key in ("plan", "atol", "rtol", "scale", "floor", "width"):
        parts.append(f"static const double {key}_[] = {{\n{numbers_text(getattr(machine.tables, key))}\n}};\n")
    for key, each in machine.tables.pattern._asdict().items():
        numbers = ", ".join(map(str, np.ravel(each).tolist())) or "0"
        parts.append(wrap(f"static const int64_t pattern_{key}[] = {{{numbers}}};") + "\n")
    return "\n".join([*parts, _start(machine), _run(machine), _outputs(machine)])


def _first_numbers(machine: CMachine) -> dict[str, Array]:
    """Start values of a machine besides parameters, up to the last number whose bits are not 0."""
    kept = {key: each for key, each in machine.content.items() if key not in ("parameters", "lowest", "highest")}
    used = {key: np.flatnonzero(each.view(np.int64)) for key, each in kept.items()}
    return {key: each[: used[key][-1] + 1] for key, each in kept.items() if used[key].size}


def _head(key: str) -> str:
    return f"static const double first_{key}[] = {{"


def numbers_text(numbers: Array) -> str:
    """Numbers in lines of C; a zero where there are none."""
    words = [constant(FLOAT, float(x)) for x in np.ravel(numbers)] or ["0.0"]
    return "\n".join(f"    {', '.join(words[i : i + 6])}," for i in range(0, len(words), 6))


def parameter_lines(machine: CMachine) -> Iterator[str]:
    """The parameters, those of one key in a line that names it."""
    numbers, at = machine.tables.vectors.params, 0
    for begin, path, count in parameter_places(machine.system.case):
        if begin > at:
            yield numbers_text(numbers[at:begin])
        at = begin + count
        words = ", ".join(constant(FLOAT, float(x)) for x in numbers[begin:at])
        yield wrap(f"    {words}, /* {begin}: {path} */")
    yield numbers_text(numbers[at:])


def parameter_places(case: Case) -> Iterator[tuple[int, str, int]]:
    """Where the numbers of each parameter and setting begin, its path, and how many they are."""
    values = [(0, case.params, "")]
    values += [(begin, case.settings[name], name) for name, begin in blocks(case).programs.items()]
    for begin, value, above in values:
        for path, leaf in members(value, above):
            count = SIGNAL_SLOTS if isinstance(leaf, Signal) else 1 + np.ndim(leaf)
            yield begin, path.removeprefix("."), count
            begin += count


def _start(machine: CMachine) -> str:
    name = machine.name
    lines = [f"void {name}_start({name}_machine *machine)", "{", "    memset(machine, 0, sizeof *machine);"]
    kept = {*_first_numbers(machine), "parameters"}
    for key in machine.content:
        source = "state" if key in ("lowest", "highest") else key
        if source in kept:
            lines.append(f"    memcpy(machine->{key}, first_{source}, sizeof first_{source});")
    return "\n".join([*lines, "}", ""])


def _run(machine: CMachine) -> str:
    name, core = machine.name, machine.core
    lines = [f"int {name}_run({name}_machine *machine, double t_end, const {name}_record *record)", "{"]
    lines += [f"    static const {name}_record none = {{NULL, 0, NULL, NULL, NULL, NULL, NULL, 0}};"]
    lines += ["    if (record == NULL) {", "        record = &none;", "    }"]
    lines += ["    const int keeps = record->marks > 0;"]
    lines += _record_lines(core.types[loop.PATTERN], "pattern", "(int64_t *)pattern_", loop.PATTERN, machine)
    lines += bench_lines(machine)
    handed = [each for argument in _arguments(machine) for each in argument]
    lines += room_lines(machine, "run", handed)
    lines.append(f"    const int64_t answer = {core.functions['run']}({', '.join(handed)});")
    lines.append(f"    return {answer_text(machine, 'run', '(int)answer')};")
    return "\n".join([*map(wrap, lines), "}", ""])


def bench_lines(machine: CMachine) -> list[str]:
    """The struct of the core for the room of the loop, which the machine holds."""
    return _record_lines(machine.core.types[loop.BENCH], "bench", "machine->bench.", loop.BENCH, machine)


def _record_lines(kind: str, name: str, before: str, record: Record, machine: CMachine) -> list[str]:
    """A struct of the core whose arrays lie elsewhere."""
    values = getattr(machine.tables, name) if name == "pattern" else machine.bench
    parts = []
    for member, each in Shared.members(record):
        assert isinstance(each, Row)
        array = getattr(values, member)
        parts.append(f"        .{member} = {before}{member},")
        lengths = zip(length_names(member, each), array.shape, strict=True)
        parts += [f"        .{length} = {number}," for length, number in lengths]
    return [f"    const {kind} {name} = {{", *parts, "    };"]


def _arguments(machine: CMachine) -> Iterator[list[str]]:
    """The arguments of the loop in C, each with its open lengths."""
    stepping, n = machine.system.stepping, str(machine.begun.state.size)
    rows, sizes = "record->rows", {key: str(machine.content[key].size) for key in ("command", "memory")}
    shapes: dict[str, list[str]] = {
        "record_times": [rows], "record": [rows, n], "record_command": [rows, sizes["command"]],
        "record_memory": [rows, sizes["memory"]], "mark_times": [f"keeps ? record->marks : {LAST_MARKS}"],
        "mark_states": [f"keeps ? record->marks : {LAST_MARKS}", n], "span_times": ["0"], "span_states": ["0", n],
    }  # fmt: skip
    words = dict(GIVEN)
    words |= {key: f"{key}_" for key in ("plan", "atol", "rtol", "scale", "floor", "width")}
    words |= {key: f"keeps ? record->{key} : machine->{key}" for key in ("mark_times", "mark_states")}
    words |= {"longest": repr(stepping.longest_step), "marks_from": repr(stepping.begin)}
    words |= {"method": str(stepping.method.value), "overwrite": "keeps ? 0 : 1"}
    yield from call_arguments(machine, parameters_of(loop.run, loop.RUN), words, shapes)


def call_arguments(
    machine: CMachine, kinds: Mapping[str, Kind], words: Mapping[str, str], shapes: Mapping[str, list[str]]
) -> Iterator[list[str]]:
    """Arguments of a function of the core in C by their names, each with its open lengths.

    words, shapes  text and lengths of those that are not what the machine or a table holds
    """
    for name, kind in kinds.items():
        if not isinstance(kind, Address):
            yield _argument(words.get(name, name), kind, shapes.get(name) or _shape(machine, name))


def _argument(word: str, kind: Kind, shape: list[str]) -> list[str]:
    if isinstance(kind, Record):
        return [f"&{word}"]
    return [word, *shape] if isinstance(kind, Row) else [word]


def _shape(machine: CMachine, name: str) -> list[str]:
    """The lengths of an argument that the machine or a table holds."""
    own = {"y": "state", "params": "parameters", "low": "lowest", "high": "highest"}.get(name, name)
    array: Any = machine.content.get(own)
    array = getattr(machine.tables, name, None) if array is None else array
    return [str(length) for length in array.shape] if isinstance(array, np.ndarray) else []


def _outputs(machine: CMachine) -> str:
    name, core = machine.name, machine.core
    count = flat(example_outputs(machine.system.model, machine.system.case)).size
    kept = [f"(double *)machine->{key}, {machine.content[key].size}" for key in ("state", "command", "parameters")]
    handed = [f"machine->clock[{places.TIME}]", *kept, f"(double *)outputs, {count}"]
    lines = [f"int {name}_outputs(const {name}_machine *machine, {name}_output *outputs)", "{"]
    lines += room_lines(machine, "outputs", handed)
    lines += [
        f"    {core.functions['outputs']}({', '.join(handed)});",
        f"    return {answer_text(machine, 'outputs', '0')};",
    ]
    time = [f"double {name}_time(const {name}_machine *machine)", "{", f"    return machine->clock[{places.TIME}];"]
    return "\n".join([*map(wrap, lines), "}", "", *time, "}", ""])


def room_lines(machine: CMachine, entry: str, handed: list[str]) -> list[str]:
    """Lines before a call of an entry that can fail or needs workspace; their arguments are added to `handed`."""
    needs, lines = machine.core.needs[entry], list[str]()
    if needs.trouble:
        lines.append("    int64_t failure = 0;")
        handed.append("&failure")
    if needs.room:
        reals, wholes = machine.rooms[entry]
        lines += [f"    double reals[{max(reals, 1)}];", f"    int64_t wholes[{max(wholes, 1)}];"]
        lines += [f"    {machine.name}_core_workspace workspace = {{reals, {reals}, wholes, {wholes}}};"]
        handed.append("&workspace")
    return lines


def answer_text(machine: CMachine, entry: str, answer: str) -> str:
    """The answer of an entry, or the number of its failure."""
    return f"failure != 0 ? {FAILED} + (int)failure : {answer}" if machine.core.needs[entry].trouble else answer
