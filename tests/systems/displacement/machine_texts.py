"""Systems of the whole machine on prescribed commands, made of the shipped ones."""

import re
from functools import cache

from vvdp.base.tables import parsed_table
from vvdp.machines import machine
from vvdp.simulation.run import Run, simulate
from vvdp.systems.circuits import table_slots
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
SPRING, GEROTOR, IDEAL = "displacement_control", "displacement_control_gerotor", "displacement_control_ideal"


def prescribed_text(circuit: str, **commands: str) -> str:
    """A machine whose drives are told what to do; a command is a value in quotes, or a table in braces."""
    source = "displacement-control" if circuit == SPRING else "displacement-control-gerotor"
    wanted = table_slots(getattr(machine, circuit))
    parts = re.split(r"(?m)^(?=\[)", shipped_systems()[source])
    kept = [part for part in parts[1:] if part[1 : part.index("]")] in (*wanted, "run", "geometry")]
    if circuit == IDEAL:
        kept.append('[axial_drive]\nlag = "10 ms"\n')
    rows = {name: value if value.startswith("{") else f'"{value}"' for name, value in (OFF | commands).items()}
    table = "\n".join(f"{name} = {value}" for name, value in rows.items())
    head = f'title = "prescribed"\ncircuit = "vvdp.machines.machine:{circuit}"\n\n'
    return head + "".join(kept) + f"\n[prescribed]\n{table}\n"


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
