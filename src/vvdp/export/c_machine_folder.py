"""The folder of a system with its loop in C: what replays a run and compares every bit, example, Makefile, README."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from importlib.metadata import version
from typing import Any

import numpy as np

from vvdp.base.arrays import Array
from vvdp.export.c_machine import FAILED, MACHINE, STATUS, CMachine, facade_text, header_text
from vvdp.export.c_words import bits_text, makefile_text
from vvdp.simulation.link import quiet
from vvdp.simulation.run import Run, simulate
from vvdp.simulation.values import leaves


@dataclass(frozen=True)
class Expected:
    """Result of vvdp's own run of a machine, by the names in C."""

    until: float
    times: Array
    numbers: dict[str, Array]


def expected_run(machine: CMachine, samples: int, say: Callable[[str], None] = quiet) -> Expected:
    """A run over so many sample periods, recorded at each. `say` is informed if something must be compiled."""
    system, period = machine.system, machine.system.stepping.sample_period
    until = system.stepping.begin + samples * period
    stepping = replace(system.stepping, until=until, record_interval=period, window=0.0, average_from=None)
    return expected_of(simulate(system.model, system.case, stepping, say=say))


def expected_of(run: Run) -> Expected:
    """Result of a run: its rows and marks, and its state at the end."""
    reached = run.reached
    return Expected(
        until=run.end,
        times=run.times,
        numbers={
            "states": run.states,
            "commands": run.commands,
            "memories": run.memories,
            "mark_times": run.mark_times,
            "mark_states": run.mark_states,
            "last_state": reached.state,
            "last_command": reached.command,
            "last_memory": reached.memory,
            "last_agenda": reached.agenda,
            "last_clock": reached.clock,
        },
    )


def machine_files(machine: CMachine, samples: int, say: Callable[[str], None] = quiet) -> dict[str, str]:
    """The files of the folder by name."""
    name, expected = machine.name, expected_run(machine, samples, say)
    return {
        f"{name}.h": header_text(machine),
        f"{name}.c": facade_text(machine),
        f"{name}_core.h": machine.core.header,
        f"{name}_core.c": machine.core.source,
        "vectors.h": vectors_text(expected),
        f"test_{name}.c": CHECK.replace("NAME", name),
        "example.c": _example(machine),
        "Makefile": makefile_text(name, machine.flags),
        "README.md": readme_text(machine, expected),
    }


def facts(machine: CMachine, files: dict[str, str], samples: int) -> dict[str, Any]:
    """Summary of an export, as the command line prints it."""
    return {
        "verb": "export c",
        "system": machine.system.name,
        "part": MACHINE,
        "files": sorted(files),
        "functions": len(machine.functions),
        "lines": sum(files[each].count("\n") for each in (f"{machine.name}.c", f"{machine.name}_core.c")),
        "memory_bytes": machine.size,
        "settings_bytes": 8 * machine.content["parameters"].size,
        "stack_bytes": 8 * max(reals + wholes for reals, wholes in machine.rooms.values()),
        "flags": list(machine.flags),
        "samples": samples,
        "hash": machine.hash,
    }


def vectors_text(expected: Expected) -> str:
    """Times and expected numbers of a run, as the bits of floats."""
    parts = [
        "/* A run of vvdp as the bits of IEEE 754 doubles: its rows, its marks, and where it stands at its end. */",
        "#include <stdint.h>\n",
        f"enum {{ ROWS = {expected.times.size}, MARKS = {expected.numbers['mark_times'].size} }};\n",
    ]
    named = {"until": np.array([expected.until]), "times": expected.times, **expected.numbers}
    for name, numbers in named.items():
        bits = bits_text(np.ravel(numbers)) or "        0"
        parts.append(f"enum {{ COUNT_{name} = {numbers.size} }};")
        parts.append(f"static const uint64_t expected_{name}[{max(1, numbers.size)}] = {{\n{bits}\n}};\n")
    return "\n".join(parts)


CHECK = """\
/* Repeats a run of vvdp and compares every bit. */
#include "NAME.h"

#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include "vectors.h"

typedef struct {
    size_t numbers;
    size_t differing;
    double largest; /* difference */
    const char *where; /* block with the largest difference */
    size_t place; /* in the block */
} outcome;

static double float_of(uint64_t bits)
{
    double x;
    memcpy(&x, &bits, sizeof x);
    return x;
}

static void compare(const char *where, const double *found, const uint64_t *expected, size_t count, outcome *all)
{
    for (size_t i = 0; i < count; i++) {
        const double wanted = float_of(expected[i]);
        all->numbers++;
        if (memcmp(&found[i], &expected[i], sizeof wanted) == 0 || (isnan(found[i]) && isnan(wanted))) {
            continue;
        }
        const double difference = fabs(found[i] - wanted);
        if (all->where == NULL || difference > all->largest) {
            all->largest = difference;
            all->where = where;
            all->place = i;
        }
        all->differing++;
    }
}

static NAME_machine machine;
static double times[ROWS + 1], states[COUNT_states + 1], commands[COUNT_commands + 1], memories[COUNT_memories + 1];
static double mark_times[MARKS + 1], mark_states[COUNT_mark_states + 1];

int main(void)
{
    outcome all = {0, 0, 0.0, NULL, 0};
    const NAME_record record = {times, ROWS, states, commands, memories, mark_times, mark_states, MARKS};
    for (size_t i = 0; i < ROWS; i++) {
        times[i] = float_of(expected_times[i]);
    }
    NAME_start(&machine);
    const int answer = NAME_run(&machine, float_of(expected_until[0]), &record);
    if (answer != 0) {
        printf("NAME: the run ended with the answer %d at t = %g s\\n", answer, NAME_time(&machine));
        return 1;
    }
    compare("states", states, expected_states, COUNT_states, &all);
    compare("commands", commands, expected_commands, COUNT_commands, &all);
    compare("memories", memories, expected_memories, COUNT_memories, &all);
    compare("mark_times", mark_times, expected_mark_times, COUNT_mark_times, &all);
    compare("mark_states", mark_states, expected_mark_states, COUNT_mark_states, &all);
    compare("the last state", machine.state, expected_last_state, COUNT_last_state, &all);
    compare("the last command", machine.command, expected_last_command, COUNT_last_command, &all);
    compare("the last memory", machine.memory, expected_last_memory, COUNT_last_memory, &all);
    compare("agenda", machine.agenda, expected_last_agenda, COUNT_last_agenda, &all);
    compare("clock", machine.clock, expected_last_clock, COUNT_last_clock, &all);
    printf("NAME: %zu of %zu numbers differ from vvdp\\n", all.differing, all.numbers);
    if (all.differing != 0) {
        printf("largest difference: %g in number %zu of %s\\n", all.largest, all.place, all.where);
    }
    return all.differing != 0;
}
"""


def _example(machine: CMachine) -> str:
    period, name = machine.system.stepping.sample_period, machine.name
    path = next(path for path, _, _ in leaves(machine.system.case.state))
    return f"""\
/* Carries a machine over three sample periods and prints the first number of its state. */
#include "{name}.h"

#include <stdio.h>

int main(void)
{{
    static {name}_machine machine;
    {name}_start(&machine);
    for (int sample = 1; sample <= 3; sample++) {{
        if ({name}_run(&machine, sample * {period!r}, NULL) != 0) {{
            return 1;
        }}
        printf("%g s: {path} = %.17g\\n", {name}_time(&machine), machine.state[0]);
    }}
    return 0;
}}
"""


README = """\
# {system} with its simulation loop in C99

Written by vvdp {version} from the Python text of the model and of the loop. Hash of the text: `{hash}`.

## Functions

- `{name}_start`: sets a machine to the values of the system.
- `{name}_run`: carries a machine on to a time, with all steps, samples, programs, jumps and marks of `vvdp run`.
- `{name}_outputs`: outputs of the circuit where the machine stands.

Conditions are calculated every {period:g} s; programs are called at their own times. Call `{name}_run` as often as you
need numbers. A machine that is carried from sample to sample has the bits of one that is carried to the end at once;
other times of return end a step of the integration there, and change numbers within the tolerance.

Include `{name}.h`. All units are SI; pressures are absolute. The answer of a function is 0, or
{answers};
above {failed}, {failed} plus the number of a failure in `{name}_core.h`.

## State

Everything that changes is in one struct of the caller, `{name}_machine`, of {size} bytes. It contains no address, so
a copy of it is a machine of its own, and a run can be repeated from any copy. A machine may run in any thread.
`machine.parameters` may be changed between two calls; `{name}.c` names each of them. Values that are calculated once
per sample period follow at the next sample. Numbers of a signal are base, place, changes and sines; a signal with
place 0 is constant at its base. Lengths of arrays, sample periods and the tolerance are fixed.

| member | content | numbers |
|---|---|---|
{rows}
Arrays take {room} bytes of the stack, besides local variables (`make stack` lists the stack of each function). Nothing
is taken from the heap, no global variable is written, and no function calls itself.

## Compiling

`make test` compiles everything and repeats the run of `vectors.h`; `make example` makes a short program.
Only the headers of C99 and its mathematical library (`-lm`) are needed. Keep the flags of the Makefile:

- Without `-ffp-contract=off` a compiler may round a product and a sum once instead of twice.
- Without `-fno-builtin-...` it may replace functions of the C library.
- Without `-fno-builtin-memcpy`, GCC 12.2 with `-march=x86-64-v4` copies some constants wrongly.
- With `-ffast-math` the text does not compile.

## Evidence

The vectors hold a run of {until:g} s of vvdp's own compiled code: {rows_count} rows with state, command and memory,
{marks} marks, and where the run stands at its end, with all counts of steps and evaluations. `make test` reports how
many of these numbers differ here, and the largest difference. Two things may change last bits on another machine:
functions of its C library, and `fma` if it does not round once.

## Python text of each function

| C | Python |
|---|---|
{functions}
## Licence

Apache-2.0, as vvdp.
"""
ABOUT = {
    "state": "State of the circuit",
    "command": "Conditions, commands of programs, and modes",
    "memory": "What programs keep",
    "parameters": "Parameters of the circuit and settings of programs",
    "agenda": "Numbers of samples and times of waiting commands",
    "waiting": "Commands that wait",
    "clock": "Time, step and counts of the loop",
    "course": "The last two steps of what may jump",
    "lowest": "Lowest numbers of the state",
    "highest": "Highest numbers of the state",
}


def readme_text(machine: CMachine, expected: Expected) -> str:
    """README of the folder: its content, what to call, what it needs, and what was verified."""
    rows = "".join(f"| `{name}` | {ABOUT[name]} | {each.size} |\n" for name, each in machine.content.items())
    answers = [f"{number} ({word.lower().replace('_', ' ')})" for number, word in enumerate(STATUS) if number > 1]
    return README.format(
        system=machine.system.name,
        version=version("vvdp"),
        hash=machine.hash,
        name=machine.name,
        period=machine.system.stepping.sample_period,
        answers=", ".join(answers),
        failed=FAILED,
        size=machine.size,
        rows=rows,
        room=8 * max(reals + wholes for reals, wholes in machine.rooms.values()),
        until=expected.until,
        rows_count=expected.times.size,
        marks=expected.numbers["mark_times"].size,
        functions="".join(f"| `{name}` | {where} |\n" for name, where in machine.functions),
    )
