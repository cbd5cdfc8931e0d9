"""Systems of the whole machine on prescribed commands, made of the shipped ones."""

import json
import re
import tomllib
from functools import cache

from vvdp.base.tables import parsed_table
from vvdp.simulation.run import Run, simulate
from vvdp.systems.system import System, built_system, shipped_systems

OFF = {
    "direction": "0",
    "opening": "0",
    "pump": "1",
    "dump": "1",
    "drive": "-1",
    "spool_position": "0 mm",
}
"""The cylinder held, the pump on, and the spool of a chamber drive on its way to its stop."""
SPRING, GEROTOR, IDEAL = "displacement-control", "displacement-control-gerotor", "ideal"
COMMANDS = {
    "displacement.direction": "direction",
    "displacement.opening": "opening",
    "displacement.pump": "pump",
    "displacement.dump": "dump",
    "passivity.command": "drive",
    "position_control.command": "drive",
}
"""The command that stands in place of that of a program."""
LAG = '{ type = "lagging-drive", wanted = WANTED, lag = "10 ms" }'


def prescribed_text(circuit: str, **commands: str) -> str:
    """A machine whose drives are told what to do; a command is a value in quotes, or a table in braces."""
    rows = {name: value if value.startswith("{") else f'"{value}"' for name, value in (OFF | commands).items()}
    text = without_programs(shipped_systems()[SPRING if circuit == SPRING else GEROTOR])
    for source, name in COMMANDS.items():
        text = text.replace(f'{{ from = "{source}" }}', rows[name])
    if circuit == IDEAL:
        text = re.sub(r"(?m)^gerotor = .*$", "slide = " + LAG.replace("WANTED", rows["spool_position"]), text)
        for old, new in (('"gerotor.position"', '"slide.position"'), ("components.gerotor.", "components.slide.")):
            text = text.replace(old, new)
        text = re.sub(r"(?ms)^\[(gerotor|characteristic)\]\n.*?(?=^\[)", "", text)
        text = re.sub(r'(?m)^"?(gerotor\.|characteristic).*\n', "", text)
    return text


def without_programs(text: str) -> str:
    """A drawn system without its programs, and without the values that lead to nothing else."""
    values = tomllib.loads(text)["values"]
    kept, gone = {}, set()
    for outer, paths in _paths(values):
        left = [path for path in paths if not path.startswith("programs.")]
        stays_there = outer in ("oil", "operation.oil_temperature")
        if left:
            kept[outer] = left
        elif not stays_there:
            gone.add(outer)
    parts = re.split(r"(?m)^(?=\[)", text)
    names = {part: part[1 : part.index("]")] for part in parts[1:]}
    programs = {name.partition(".")[2] for name in names.values() if name.startswith("programs.")}
    found = [parts[0]]
    for part in parts[1:]:
        name = names[part]
        if name == "values":
            lines = [f"{json.dumps(outer)} = {json.dumps(paths)}" for outer, paths in kept.items()]
            found.append("\n".join(["[values]", *lines]) + "\n\n")
        elif not name.startswith("programs.") and name not in gone | programs | {"calibration", "axial_sequence"}:
            rows = [row for row in part.splitlines(True) if f"{name}.{row.partition(' ')[0]}" not in gone]
            found.append("".join(rows))
    return "".join(found)


def _paths(values, above=""):
    for key, entry in values.items():
        if isinstance(entry, dict):
            yield from _paths(entry, f"{above}{key}.")
        else:
            yield above + key, [entry] if isinstance(entry, str) else entry


def change(text: str, **values: str) -> str:
    """A text with other values, each called table__key."""
    for name, value in values.items():
        table, _, key = name.partition("__")
        begin = text.index(f"\n[{table}]\n")
        end = text.find("\n[", begin + 1)
        section = text[begin : end if end >= 0 else len(text)]
        new = re.sub(rf"(?m)^{key} = .*$", lambda _, k=key, v=value: f'{k} = "{v}"', section)
        assert new != section, name
        text = text.replace(section, new)
    return text


def step(before: str, after: str, at: str) -> str:
    """A signal that jumps."""
    return f'{{step = ["{before}", "{after}"], at = "{at}"}}'


def system_of(text: str, until: str, average_from: str = "0 s") -> System:
    """The system of a text that lasts until a time."""
    return built_system(
        parsed_table(change(text, run__until=until, run__average_from=average_from), "machine"), "machine"
    )


@cache
def run_of(text: str, until: str, average_from: str = "0 s") -> tuple[System, Run]:
    """A system and its run; the same one is run once."""
    system = system_of(text, until, average_from)
    return system, simulate(system.model, system.case, system.stepping)
