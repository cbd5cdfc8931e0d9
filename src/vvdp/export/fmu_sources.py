"""The C sources of an FMU: the machine, tables of its variables, and the interface of FMI."""

import json
from collections.abc import Mapping
from importlib import resources

from vvdp.export.c_guest import guest_header, guest_text, indicator_count
from vvdp.export.c_machine import STATUS, facade_text, header_text, numbers_text
from vvdp.export.c_tangent import tangent_header, tangent_text
from vvdp.export.fmu_model import FIXED, INPUT, FmuModel, has_clock
from vvdp.generator.c_text import constant, wrap
from vvdp.generator.kinds import FLOAT
from vvdp.simulation import places

ROLES = {FIXED: "FMU_FIXED", INPUT: "FMU_INPUT"}
VECTORS = {
    "y": "FMU_STATE",
    "state": "FMU_STATE",
    "command": "FMU_COMMAND",
    "output": "FMU_OUTPUT",
    "memory": "FMU_MEMORY",
    "params": "FMU_PARAMETERS",
    "rate": "FMU_RATE",
    "indicator": "FMU_INDICATOR",
}
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
    machine, is_guest = model.machine, model.machine.is_guest
    tangent: tuple[str, dict[str, str]] = ("", {})
    if model.tangent is not None:
        text = tangent_text(machine, model.tangent)
        tangent = ("\n" + tangent_header(machine, model.tangent), {f"{machine.name}_tangent.c": text})
    return {
        f"{machine.name}.h": header_text(machine, guest_header(machine) + tangent[0]),
        **tangent[1],
        f"{machine.name}.c": facade_text(machine) + guest_text(machine),
        f"{machine.name}_core.h": machine.core.header,
        f"{machine.name}_core.c": machine.core.source,
        "fmu_model.h": _model_header(model, fmi, token),
        "fmu_tables.c": tables_text(model),
        **fixed_files(fmi, is_guest=is_guest),
    }


def fixed_files(fmi: int, *, is_guest: bool) -> Mapping[str, str]:
    """The sources that are the same in every FMU, and the headers of FMI (2-Clause BSD)."""
    folder = resources.files("vvdp.export").joinpath("fmi")
    names = ["fmu.h", "fmu.c", *(["fmu_guest.c"] if is_guest else []), *FMI_FILES[fmi]]
    return {name: folder.joinpath(name).read_text("utf-8") for name in names}


def _model_header(model: FmuModel, fmi: int, token: str) -> str:
    machine, stepping = model.machine, model.system.stepping
    followers = sum(len(each.followers) for each in model.settables)
    reasons = [REASONS.get(word, "the loop was interrupted") for word in STATUS]
    names = {"machine": "fmu_machine", "output": "fmu_model_output"}
    functions = ["start", "run", "outputs", "time", "upcoming"]
    functions += ["tangent"] if model.tangent else []
    functions += ["derive", "indicate", "enter", "fallen", "move"] if machine.is_guest else []
    return "\n".join(
        [
            "/* The machine of this FMU, and how many variables it has. */",
            "#ifndef FMU_MODEL_H\n#define FMU_MODEL_H\n",
            f'#include "{machine.name}.h"\n',
            f"#define FMU_TOKEN {json.dumps(token)}",
            f"#define FMU_HAS_TIME {int(fmi == 3)}",
            f"#define FMU_BEGIN {stepping.begin!r}",
            f"#define FMU_PERIOD {stepping.sample_period!r}",
            f"#define FMU_IS_GUEST {int(machine.is_guest)}",
            f"#define FMU_HAS_TANGENT {int(model.tangent is not None)}",
            f"#define FMU_HAS_MARKS {int(has_clock(model, fmi))}",
            *(f"#define fmu_model_{each} {machine.name}_{each}" for each in functions),
            "",
            f"enum {{ FMU_TOKEN_SIZE = {TOKEN_SIZE}, FMU_STATES = {machine.begun.state.size} }};",
            f"enum {{ FMU_COMMANDS = {max(1, machine.begun.command.size)} }};",
            f"enum {{ FMU_CLOCK_MARKS = {places.MARKS}, FMU_CLOCK_STORED = {places.STORED} }};",
            f"enum {{ FMU_SETTABLES = {len(model.settables)}, FMU_FOLLOWERS = {followers} }};",
            f"enum {{ FMU_OUTPUTS = {len(model.outputs) + len(model.inner)} }};",
            *([_guest_sizes(model)] if machine.is_guest else []),
            *(f"typedef {machine.name}_{own} {name};" for own, name in names.items()),
            wrap(f"static const char *const fmu_reasons[] = {{{', '.join(map(json.dumps, reasons))}}};"),
            "\n#endif\n",
        ]
    )


def _guest_sizes(model: FmuModel) -> str:
    sizes = {"CARRIED": len(model.carried), "POSITIONS": model.machine.bench.rate.size}
    sizes["INDICATORS"] = indicator_count(model.machine)
    sizes["PARAMETERS_SIZE"] = max(1, model.machine.tables.vectors.params.size)
    sizes["TANGENTS"] = 1 if model.tangent is None else len(model.tangent.graph.outputs)
    return f"enum {{ {', '.join(f'FMU_{name} = {size}' for name, size in sizes.items())} }};"


def tables_text(model: FmuModel) -> str:
    """The tables of variables."""
    settables, followers, names, begin = [], [], [], 0
    for number, each in enumerate(model.settables):
        numbers = ", ".join(constant(FLOAT, x) for x in (each.start, each.low, each.high))
        settables.append(f"    {{{numbers}, {ROLES.get(each.role, 'FMU_TUNABLE')}, {begin}}},")
        names.append(f'    "{each.name}\\0"')
        begin += len(each.name) + 1
        for own in each.followers:
            place = f"{constant(FLOAT, own.constant)}, {own.place}, {number}"
            followers.append(f"    {{{place}, {VECTORS[own.vector]}, {OPERATIONS[own.operation]}}},")
    shown = (*model.outputs, *model.inner)
    outputs = [f"    {{{VECTORS[each.vector]}, {each.place}}}, /* {each.key} */" for each in shown]
    parts = ['/* Variables in the order of their references. */\n#include "fmu.h"\n']
    for kind, rows, none in (
        ("fmu_settable", settables, "    {0.0, 0.0, 0.0, FMU_FIXED, 0},"),
        ("fmu_follower", followers, "    {0.0, 0, 0, FMU_PARAMETERS, FMU_ADD},"),
        ("fmu_output", outputs, "    {FMU_STATE, 0},"),
    ):
        parts.append("\n".join([f"const {kind} {kind}s[] = {{", *(rows or [none]), "};\n"]))
    parts.append("\n".join(["const char fmu_names[] =", *(names or ['    ""'])]) + ";\n")
    if model.machine.is_guest:
        nominals = numbers_text(model.machine.tables.scale[: len(model.carried)])
        parts.append(f"const double fmu_nominals[] = {{\n{nominals}\n}};\n")
    return "\n".join(parts)
