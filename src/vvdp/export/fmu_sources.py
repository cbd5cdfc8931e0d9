"""The C sources of an FMU: the machine, tables of its variables, and the interface of FMI."""

import json
from collections.abc import Mapping
from importlib import resources

from vvdp.export.c_machine import STATUS, facade_text, header_text
from vvdp.export.fmu_model import FIXED, INPUT, FmuModel
from vvdp.generator.c_text import constant, wrap
from vvdp.generator.kinds import FLOAT

ROLES = {FIXED: "FMU_FIXED", INPUT: "FMU_INPUT"}
VECTORS = {"y": "FMU_STATE", "state": "FMU_STATE", "command": "FMU_COMMAND", "output": "FMU_OUTPUT",
           "memory": "FMU_MEMORY", "params": "FMU_PARAMETERS"}  # fmt: skip
OPERATIONS = {"+": "FMU_ADD", "*": "FMU_TIMES", "/": "FMU_BY", "over": "FMU_OVER"}
REASONS = {
    "NOT_FINITE": "a rate is no longer finite",
    "STEP_TOO_SMALL": "the step has become too small",
    "STOP_BEHIND": "no later jump of the rates is named",
    "TOO_MANY_WAITING": "too many commands of a program wait",
    "RESTLESS": "a mode changes without end",
    "BELOW_ZERO": "a pressure has fallen below 0 Pa absolute",
}
FMI_FILES = {
    2: ("fmi2.c", "fmi2Functions.h", "fmi2FunctionTypes.h", "fmi2TypesPlatform.h"),
    3: ("fmi3.c", "fmi3Functions.h", "fmi3FunctionTypes.h", "fmi3PlatformTypes.h"),
}
TOKEN_SIZE = 40
"""Characters of a token with its end."""


def source_files(model: FmuModel, fmi: int, token: str) -> dict[str, str]:
    """The files of the folder `sources` by name."""
    machine = model.machine
    return {
        f"{machine.name}.h": header_text(machine),
        f"{machine.name}.c": facade_text(machine),
        f"{machine.name}_core.h": machine.core.header,
        f"{machine.name}_core.c": machine.core.source,
        "fmu_model.h": _model_header(model, fmi, token),
        "fmu_tables.c": tables_text(model),
        **fixed_files(fmi),
    }


def fixed_files(fmi: int) -> Mapping[str, str]:
    """The sources that are the same in every FMU, and the headers of FMI (2-Clause BSD)."""
    folder = resources.files("vvdp.export").joinpath("fmi")
    return {name: folder.joinpath(name).read_text("utf-8") for name in ("fmu.h", "fmu.c", *FMI_FILES[fmi])}


def _model_header(model: FmuModel, fmi: int, token: str) -> str:
    machine, stepping = model.machine, model.system.stepping
    followers = sum(len(each.followers) for each in model.settables)
    reasons = [REASONS.get(word, "the loop was interrupted") for word in STATUS]
    names = {"machine": "fmu_machine", "output": "fmu_model_output"}
    return "\n".join(
        [
            "/* The machine of this FMU, and how many variables it has. */",
            "#ifndef FMU_MODEL_H\n#define FMU_MODEL_H\n",
            f'#include "{machine.name}.h"\n',
            f"#define FMU_TOKEN {json.dumps(token)}",
            f"#define FMU_HAS_TIME {int(fmi == 3)}",
            f"#define FMU_BEGIN {stepping.begin!r}",
            f"#define FMU_PERIOD {stepping.sample_period!r}",
            *(f"#define fmu_model_{each} {machine.name}_{each}" for each in ("start", "run", "outputs", "time")),
            "",
            f"enum {{ FMU_TOKEN_SIZE = {TOKEN_SIZE}, FMU_STATES = {machine.begun.state.size} }};",
            f"enum {{ FMU_SETTABLES = {len(model.settables)}, FMU_FOLLOWERS = {followers} }};",
            f"enum {{ FMU_OUTPUTS = {len(model.outputs)} }};",
            *(f"typedef {machine.name}_{own} {name};" for own, name in names.items()),
            wrap(f"static const char *const fmu_reasons[] = {{{', '.join(map(json.dumps, reasons))}}};"),
            "\n#endif\n",
        ]
    )


def tables_text(model: FmuModel) -> str:
    """The tables of variables."""
    settables, followers = [], []
    for number, each in enumerate(model.settables):
        numbers = ", ".join(constant(FLOAT, x) for x in (each.start, each.low, each.high))
        settables.append(f"    {{{json.dumps(each.name)}, {numbers}, {ROLES.get(each.role, 'FMU_TUNABLE')}}},")
        for own in each.followers:
            operation = f"{OPERATIONS[own.operation]}, {constant(FLOAT, own.constant)}"
            followers.append(f"    {{{number}, {VECTORS[own.vector]}, {own.place}, {operation}}},")
    outputs = [f"    {{{VECTORS[each.vector]}, {each.place}}}, /* {each.key} */" for each in model.outputs]
    parts = ['/* Variables in the order of their references. */\n#include "fmu.h"\n']
    for kind, rows, none in (
        ("fmu_settable", settables, '    {"", 0.0, 0.0, 0.0, FMU_FIXED},'),
        ("fmu_follower", followers, "    {-1, FMU_PARAMETERS, 0, FMU_ADD, 0.0},"),
        ("fmu_output", outputs, "    {FMU_STATE, 0},"),
    ):
        parts.append("\n".join([f"const {kind} {kind}s[] = {{", *(rows or [none]), "};\n"]))
    return "\n".join(parts)
