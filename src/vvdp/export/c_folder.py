"""A folder with a part of a system in C: the functions, structs with units, vectors with expected bits, what checks."""

from collections.abc import Callable, Mapping, Sequence
from importlib.metadata import version
from typing import Any, NamedTuple

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.errors import ConfigError, Fault
from vvdp.base.tables import nearest
from vvdp.export.c_check import check_text
from vvdp.export.c_machine import MACHINE, c_machine
from vvdp.export.c_machine_folder import facts as machine_facts
from vvdp.export.c_machine_folder import machine_files
from vvdp.export.c_parts import (
    IN,
    KEPT,
    OUT,
    CPart,
    Entry,
    Precision,
    circuit_entries,
    drawn_values,
    module_of,
    program_entry,
)
from vvdp.export.c_powers import C_INTRINSICS
from vvdp.export.c_precision import in_single, refusal
from vvdp.export.c_structs import initial_text, struct_text
from vvdp.export.c_target import (
    Load,
    counted_loads,
    late_cores,
    load_text,
    missing_tools,
    target_files,
    target_goal,
)
from vvdp.export.c_words import MEMORY, example_text, loop_goal, makefile_text, process_text, readme_text, vectors_text
from vvdp.export.closed_loop import recorded_readings
from vvdp.generator import binding
from vvdp.generator.c_room import room_of
from vvdp.generator.c_single import single_text
from vvdp.generator.c_text import identifier, wrap
from vvdp.generator.c_writer import write_c
from vvdp.generator.calls import callables
from vvdp.generator.llvm_writer import write_llvm
from vvdp.simulation.exchange import refuse_partners
from vvdp.simulation.link import quiet
from vvdp.simulation.values import flat
from vvdp.systems.system import System

CIRCUIT = "circuit"


class Exported(NamedTuple):
    """A folder: the name of what is in it, its files by name, and what the command line prints."""

    name: str
    files: Mapping[str, str]
    facts: Mapping[str, Any]


def exported_folder(
    system: System,
    part: str,
    samples: int,
    precision: Precision = Precision.DOUBLE,
    clock: float | None = None,
    say: Callable[[str], None] = quiet,
) -> Exported:
    """The folder of a part: `circuit`, `machine`, or a program by its name; `say` is informed if something is compiled.

    clock  of a microcontroller [Hz]: the README states its load, and `say` gets warnings; None leaves this out

    Raises as `c_part`, `in_single` and `counted_loads`.
    """
    if clock is not None and part in (CIRCUIT, MACHINE):
        raise ConfigError([Fault("--clock", 0, part, "the load is known for programs only, which have a period")])
    if part == MACHINE:
        if precision is Precision.SINGLE:
            raise refusal(part, "only the step of a program can be exported in single precision")
        machine = c_machine(system)
        files = machine_files(machine, samples, say)
        return Exported(machine.name, files, machine_facts(machine, files, samples))
    made = c_part(system, part)
    made = in_single(made) if precision is Precision.SINGLE else made
    files = c_files(system, made, samples)
    found = facts(made, files, samples)
    if clock is not None:
        loads, load = loads_at(made, files, clock, say)
        files["README.md"] = files["README.md"].replace(MEMORY, f"{load}{MEMORY}")
        found |= {"clock_Hz": clock, "loads": [each._asdict() for each in loads]}
    return Exported(made.name, files, found)


def loads_at(part: CPart, files: Mapping[str, str], clock: float, say: Callable[[str], None]) -> tuple[list[Load], str]:
    """Load of a program on microcontrollers, and the text on it in the README; nothing is counted without tools."""
    if missing := missing_tools():
        words = f"instructions were not counted: {', '.join(missing)} not found"
        say(words)
        return [], f"\n## Time on a microcontroller\n\nNot known; {words}.\n"
    loads = counted_loads(files)
    for warning in late_cores(loads, part.period, clock):
        say(f"warning: {warning}")
    return loads, load_text(loads, part.period, clock)


def c_part(system: System, part: str) -> CPart:
    """A part of a system in C: the step of a program by its name, or `circuit`.

    Raises ConfigError where there is no such part; LanguageError, with file and line, where its text uses what cannot
    be exported; RunError for a foreign FMU.
    """
    model, case = system.model, system.case
    names = (CIRCUIT, MACHINE, *model.programs)
    if part not in names:
        raise ConfigError([Fault("--part", 0, part, f"unknown{nearest(part, names)}")])
    refuse_partners(model.partners.keys() & {part}, "exported code")
    is_circuit = part == CIRCUIT
    entries = circuit_entries(model, case) if is_circuit else [program_entry(model, case, part)]
    module = module_of(entries)
    name = identifier(f"{system.name}_{part}".replace("-", "_"))
    rooms = {}
    for function, room in room_of(module).items():
        if function in module.entries:
            assert room is not None, "all arrays of an exported part have known lengths"
            rooms[function] = room
    program = None if is_circuit else model.programs[part]
    return CPart(
        name=name,
        part=part,
        system=system.name,
        entries=tuple(entries),
        module=module,
        core=write_c(module, f"{name}_core", C_INTRINSICS),
        rooms=rooms,
        program=program,
        period=system.stepping.sample_period if program is None or program.period is None else program.period,
    )


def c_files(system: System, part: CPart, samples: int) -> dict[str, str]:
    """The files of the folder by name."""
    code = part_code(part)
    times, drawn = sampled_values(system, part, code, samples)
    expected = expected_values(part, code, times, drawn)
    name = part.name
    entry = part.entries[0]
    is_single = part.precision is Precision.SINGLE
    is_loop = part.answers and not is_single
    loop = loop_goal(name, part.system, part.part) if is_loop else ""
    written = single_text if is_single else str
    return {
        f"{name}.h": written(header_text(part)),
        f"{name}.c": written(facade_text(part)),
        f"{name}_core.h": part.core.header,
        f"{name}_core.c": part.core.source,
        "vectors.h": vectors_text(part.entries, times, drawn, expected),
        f"test_{name}.c": check_text(name, part.entries, part.precision),
        "example.c": written(example_text(name, part.entries, part.period)),
        **({f"loop_{name}.c": process_text(name, entry)} if is_loop else {}),
        **target_files(),
        "Makefile": makefile_text(name, part.core.flags, target_goal(name, part.precision) + loop),
        "README.md": readme_text(part, len(times), version("vvdp")),
    }


def part_code(part: CPart) -> Mapping[str, Callable[..., Any]]:
    """The entries of a part as vvdp's machine code, in double precision."""
    return callables(
        part.module, binding.load_code(binding.compile_text(write_llvm(part.module), 2), part.module.entries)
    )


def sampled_values(
    system: System, part: CPart, code: Mapping[str, Callable[..., Any]], samples: int
) -> tuple[list[float], list[Array]]:
    """Times of samples, and what is read at them: by a program in a run, by a circuit at random about its start."""
    entry = part.entries[0]
    kept = {block.name: flat(block.value) for block in entry.arguments}

    def step(t: float, reading: Array) -> Array:
        kept["reading"] = reading
        code[entry.name](t, *(kept[block.name] for block in entry.arguments))
        return np.concatenate([kept[block.name] for block in entry.arguments if block.role in (OUT, KEPT)])

    if part.answers and (found := recorded_readings(system, part.part, samples, step)):
        return [t for t, _ in found], [reading for _, reading in found]
    times = [part.phase + number * part.period for number in range(samples)]
    return times, drawn_values(system.model, system.case, None if part.program is None else part.part, times)


def facts(part: CPart, files: Mapping[str, str], samples: int) -> dict[str, Any]:
    """Summary of an export, as the command line prints it."""
    blocks, size = part.blocks.values(), part.precision.size
    return {
        "verb": "export c",
        "system": part.system,
        "part": part.part,
        "files": sorted(files),
        "functions": len(part.functions),
        "lines": sum(files[name].count("\n") for name in (f"{part.name}.c", f"{part.name}_core.c")),
        "precision": part.precision.name.lower(),
        "memory_bytes": size * sum(block.size for block in blocks if block.role == KEPT),
        "settings_bytes": size * sum(block.size for block in blocks if block.role == IN and not block.drawn),
        "stack_bytes": part.array_bytes,
        "flags": list(part.core.flags),
        "period_s": part.period,
        "samples": samples,
        "hash": part.hash,
    }


def header_text(part: CPart) -> str:
    """The structs and functions for callers."""
    guard, first = f"{part.name.upper()}_H", f"/* {part.part} of {part.system}: units are SI, pressures absolute. */\n"
    structs = [struct_text(f"{part.name}_{name}", b.value, f"{b.about}.") for name, b in part.blocks.items()]
    values = [
        f"/* {block.about}: the values of the system. */\nextern const {part.name}_{name} {part.name}_first_{name};\n"
        for name, block in part.blocks.items()
        if block.role != OUT
    ]
    heads = [f"/* {entry.about}; the result is 0, or the number of a failure. */\n{_head(part, entry)};\n"
             for entry in part.entries]  # fmt: skip
    return "\n".join([f"#ifndef {guard}\n#define {guard}\n", first, *structs, *values, *heads, "#endif\n"])


def facade_text(part: CPart) -> str:
    """The functions for callers, which hand structs over as the numbers that they consist of."""
    name = part.name
    parts = [f'#include "{name}.h"\n\n#include <math.h>\n#include <stdint.h>\n\n#include "{name}_core.h"\n']
    for own, block in part.blocks.items():
        if block.role != OUT:
            parts.append(initial_text(f"{name}_{own}", f"{name}_first_{own}", block.value, f"{block.about}."))
        count = f"sizeof({name}_{own}) == {block.size} * sizeof(double)"
        parts.append(f"typedef char {name}_{own}_without_gaps[{count} ? 1 : -1];\n")
    return "\n".join([*parts, *(_facade(part, entry) for entry in part.entries)])


def _head(part: CPart, entry: Entry) -> str:
    found = ["double t"]
    for block in entry.arguments:
        found.append(f"{'const ' if block.role == IN else ''}{part.name}_{block.name} *{block.name}")
    return wrap(f"int {part.name}_{entry.name}({', '.join(found)})")


def _facade(part: CPart, entry: Entry) -> str:
    needs = part.core.needs[entry.name]
    handed = ["t", *(f"(double *){block.name}" for block in entry.arguments)]
    lines = [_head(part, entry), "{"]
    if needs.room:
        reals, wholes = part.rooms[entry.name]
        lines += [f"    double reals[{max(reals, 1)}];", f"    int64_t wholes[{max(wholes, 1)}];"]
        lines += [f"    {part.name}_core_workspace workspace = {{reals, {reals}, wholes, {wholes}}};"]
    if needs.trouble:
        lines.append("    int64_t failure = 0;")
        handed.append("&failure")
    handed += ["&workspace"] if needs.room else []
    lines += [wrap(f"    {part.core.functions[entry.name]}({', '.join(handed)});")]
    return "\n".join([*lines, f"    return {'(int)failure' if needs.trouble else '0'};", "}\n"])


def expected_values(
    part: CPart, entries: Mapping[str, Callable[..., Any]], times: Sequence[float], drawn: Sequence[Array]
) -> dict[str, list[dict[str, Array]]]:
    """By entry and sample, what vvdp's machine code writes: a memory goes on from one sample to the next."""
    found: dict[str, list[dict[str, Array]]] = {}
    for entry in part.entries:
        kept = {block.name: flat(block.value) for block in entry.arguments}
        found[entry.name] = []
        for t, values in zip(times, drawn, strict=True):
            for block in entry.arguments:
                if block.drawn:
                    kept[block.name] = values.copy()
                elif block.role == OUT:
                    kept[block.name] = np.zeros(block.size)
            entries[entry.name](t, *(kept[block.name] for block in entry.arguments))
            written = {block.name for block in entry.arguments if block.role in (OUT, KEPT)}
            found[entry.name].append({name: kept[name].copy() for name in written})
    return found
