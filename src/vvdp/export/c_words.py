"""The texts around exported functions: vectors, the program that replays them, an example, Makefile and README."""

from collections.abc import Mapping, Sequence

import numpy as np

from vvdp.base.arrays import Array
from vvdp.export.c_parts import IN, OUT, CPart, Entry, Precision
from vvdp.generator.c_text import wrap

WARNINGS = "-Wall -Wextra -Wconversion -Wpedantic"


def vectors_text(
    entries: Sequence[Entry],
    times: Sequence[float],
    drawn: Sequence[Array],
    expected: Mapping[str, list[dict[str, Array]]],
) -> str:
    """Times, arguments and expected results of every sample, as the bits of floats."""
    parts = [
        "/* Arguments and expected results as the bits of IEEE 754 doubles. */\n#include <stdint.h>\n",
        f"enum {{ SAMPLES = {len(drawn)} }};\n",
        f"static const uint64_t times[SAMPLES] = {{\n{bits_text(np.array(times))}\n}};\n",
    ]
    known = next(block for entry in entries for block in entry.arguments if block.drawn)
    parts.append(_rows(f"drawn_{known.name}", drawn))
    for entry in entries:
        for block in entry.arguments:
            if block.role != IN:
                rows = [sample[block.name] for sample in expected[entry.name]]
                parts.append(_rows(f"{entry.name}_{block.name}", rows))
    return "\n".join(parts)


def _rows(name: str, rows: Sequence[Array]) -> str:
    lines = ",\n".join(f"    {{\n{bits_text(row)}\n    }}" for row in rows)
    return f"static const uint64_t {name}[SAMPLES][{rows[0].size}] = {{\n{lines}\n}};\n"


def bits_text(numbers: Array) -> str:
    """Numbers as the bits of floats, in lines of C."""
    words = [f"UINT64_C(0x{int(bits):016x})" for bits in np.asarray(numbers, float).view(np.uint64)]
    return ",\n".join("        " + ", ".join(words[i : i + 4]) for i in range(0, len(words), 4))


def example_text(name: str, entries: Sequence[Entry], period: float) -> str:
    """A program that calls the first function a few times with the values of the system."""
    entry = entries[0]
    lines = ["/* Calls the function with the values of the system. */", f'#include "{name}.h"', ""]
    lines += ["#include <stdio.h>", "", "int main(void)", "{"]
    for block in entry.arguments:
        first = f" = {name}_first_{block.name}" if block.role != OUT else ""
        lines.append(f"    {name}_{block.name} {block.name}{first};")
    handed = ", ".join(f"&{block.name}" for block in entry.arguments)
    shown = next(block for block in entry.arguments if block.role != IN)
    lines += ["    for (int sample = 0; sample < 3; sample++) {", f"        const double t = sample * {period!r};"]
    lines += [f"        if ({name}_{entry.name}(t, {handed}) != 0) {{", "            return 1;", "        }"]
    lines += [f"        const double *first = (const double *)&{shown.name};"]
    lines += [f'        printf("%g s: first number of {shown.name}: %.17g\\n", t, first[0]);', "    }", "    return 0;"]
    return "\n".join([*map(wrap, lines), "}", ""])


PROCESS = """\
/* Answers samples: takes frames of a time and a reading from the standard input, gives the memory and the command to
   the standard output, all as doubles. At the end it prints the time of a step. */
#define _POSIX_C_SOURCE 199309L
#include "{name}.h"

#include <stdio.h>
#include <time.h>

typedef struct {{
    double time;
    {name}_reading reading;
}} frame;

int main(void)
{{
{memory}    {name}_command command;
    frame given;
    double least = 1e300, most = 0.0, sum = 0.0;
    unsigned long samples = 0, longest = 0;
    while (fread(&given, sizeof given, 1, stdin) == 1) {{
        struct timespec begin, end;
        clock_gettime(CLOCK_MONOTONIC, &begin);
        const int failure = {name}_step({handed});
        clock_gettime(CLOCK_MONOTONIC, &end);
        if (failure != 0) {{
            fprintf(stderr, "{name}: failure %d at t = %g s\\n", failure, given.time);
            return 1;
        }}
        {write}fwrite(&command, sizeof command, 1, stdout);
        fflush(stdout);
        const double took = 1e6 * (double)(end.tv_sec - begin.tv_sec) + 1e-3 * (double)(end.tv_nsec - begin.tv_nsec);
        least = took < least ? took : least;
        longest = took > most ? samples : longest;
        most = took > most ? took : most;
        sum += took;
        samples++;
    }}
    if (samples != 0) {{
        fprintf(stderr, "{name}: %lu samples\\n", samples);
        fprintf(stderr, "time of a step: minimum %.3g us, mean %.3g us, maximum %.3g us (sample %lu)\\n",
                least, sum / (double)samples, most, longest);
    }}
    return 0;
}}
"""


def process_text(name: str, entry: Entry) -> str:
    """The program that takes the steps of an exported program in a process of its own, and times them."""
    blocks = [block.name for block in entry.arguments]
    kept = "memory" in blocks
    ways = {"reading": "&given.reading", "memory": "&memory", "command": "&command"}
    handed = ["given.time", *(ways.get(each, f"&{name}_first_{each}") for each in blocks)]
    return PROCESS.format(
        name=name,
        handed=", ".join(handed),
        memory=f"    {name}_memory memory = {name}_first_memory;\n" if kept else "",
        write="fwrite(&memory, sizeof memory, 1, stdout);\n        " if kept else "",
    )


def makefile_text(name: str, flags: Sequence[str], more: str = "") -> str:
    """The Makefile that builds and tests the folder; the flags are part of the text.

    more  further goals (`target_goal`, `loop_goal`)
    """
    objects = f"{name}.o {name}_core.o"
    return f"""\
CC ?= cc
# The functions have the stated bits with these flags only.
FLAGS = {" ".join(flags)} -O2 {WARNINGS}

all: test_{name} example

test: test_{name}
\t./test_{name}

test_{name}: test_{name}.o {objects}
\t$(CC) $(FLAGS) -o $@ $^ -lm

example: example.o {objects}
\t$(CC) $(FLAGS) -o $@ $^ -lm

%.o: %.c {name}.h {name}_core.h vectors.h
\t$(CC) $(FLAGS) -c -o $@ $<

# Stack of each function, by GCC.
stack: {name}_core.c {name}_core.h
\t$(CC) $(FLAGS) -fstack-usage -c -o {name}_core.o {name}_core.c
\tsort -t '\t' -k 2 -n -r {name}_core.su | head

{more}clean:
\trm -f *.o *.su *.elf test_{name} example loop_{name}

.PHONY: all test stack pil loop clean
"""


def loop_goal(name: str, system: str, part: str) -> str:
    """The goal that runs the program in a process of its own, in the loop with its system."""
    return f"""\
# The program in a process of its own, in the loop with the system that vvdp simulates; SET: the --set of the export.
PYTHON ?= python3
SYSTEM = {system}
SET =
SAMPLES = 1000

loop: loop_{name}
\t$(PYTHON) -m vvdp.export.closed_loop $(SET) --samples $(SAMPLES) $(SYSTEM) {part} ./loop_{name}

loop_{name}: loop_{name}.o {name}.o {name}_core.o
\t$(CC) $(FLAGS) -o $@ $^ -lm

"""


MEMORY = "\n## Memory\n"
"""The heading of the README before which its section on the time of a step stands."""

README = """\
# {part} of {system} in C99{precision}

Written by vvdp {version} from the Python text of the model. Hash of the text: `{hash}`.

## Functions

{calls}
{when}

Include `{name}.h`. The values of the system are in `{name}_first_...`. All units are SI; pressures are absolute.
The result of a function is 0, or the number of a failure (`{name}_core.h`).

## Compiling

`make test` compiles everything and replays the vectors; `make example` makes a program that calls the first function.
Only the headers of C99 and its mathematical library (`-lm`) are needed. Keep the flags of the Makefile:

- Without `-ffp-contract=off` a compiler may round a product and a sum once instead of twice.
- Without `-fno-builtin-...` it may replace functions of the C library.
- With `-ffast-math` the text does not compile.

## Evidence

The vectors hold {samples} samples, with the bits that vvdp's own machine code has calculated from the same Python text.
`make test` reports how many samples have the same bits here, and otherwise the largest difference. {bits}
## Memory

| struct | content | numbers | bytes |
|---|---|---|---|
{rows}
All of them belong to the caller. Arrays take {room} bytes of the stack, besides local variables (`make stack` lists the
stack of each function, `make pil` what a call uses). Nothing is taken from the heap, no global variable is written, and
no function calls itself.

## Python text of each function

| C | Python |
|---|---|
{functions}
## Licence

Apache-2.0, as vvdp.
"""


BITS = {
    Precision.DOUBLE: """\
Two things may
change last bits on another machine: functions of its C library, and `fma` if it does not round once.
""",
    Precision.SINGLE: """\
This text
calculates in single precision, so numbers differ; `make test` fails where one differs by more than 0.1 % of its largest
value.
""",
}


def readme_text(part: CPart, samples: int, version: str) -> str:
    """README of the folder: its content, what to call at which times, what it needs, and what was verified."""
    size = part.precision.size
    rows = "".join(
        f"| `{part.name}_{block.name}` | {block.about} | {block.size} | {size * block.size} |\n"
        for block in part.blocks.values()
    )
    return README.format(
        part=part.part,
        system=part.system,
        version=version,
        hash=part.hash,
        calls="".join(f"- `{part.name}_{entry.name}`: {_in_sentence(entry.about)}.\n" for entry in part.entries),
        when=_when(part),
        name=part.name,
        samples=samples,
        rows=rows,
        room=part.array_bytes,
        precision=", in single precision" if part.precision is Precision.SINGLE else "",
        bits=BITS[part.precision],
        functions="".join(f"| `{name}` | {where} |\n" for name, where in part.functions),
    )


def _when(part: CPart) -> str:
    program = part.program
    if program is None:
        return f"Conditions are calculated every {part.period:g} s and hold in between."
    latency = f" The command acts {program.latency:g} s after the sample." if program.latency else ""
    if program.trigger is not None:
        return f"Call it at each event of its trigger.{latency}"
    return f"Call it every {part.period:g} s, first at {program.phase:g} s.{latency}"


def _in_sentence(words: str) -> str:
    return words[0].lower() + words[1:]
