"""Shipped systems as tables alone, which a function draws."""

import re

from tests.systems.table_circuit import unit_on_load

from vvdp.systems.circuits import table_slots
from vvdp.systems.system import shipped_systems

START = re.compile(r"(?ms)^\[initial\].*?(?=^\[)")


def tables_alone(name: str) -> str:
    """A shipped system of the rig without its drawing: a function draws it from its tables."""
    parts = re.split(r"(?m)^(?=\[)", shipped_systems()[name])
    kept = [part for part in parts[1:] if part[1 : part.index("]")] in (*table_slots(unit_on_load), "run")]
    circuit = f'circuit = "{unit_on_load.__module__}:{unit_on_load.__name__}"\n\n'
    text = parts[0] + circuit + "".join(kept)
    return START.sub('[initial]\nload_pressure = "100 bar"\n\n', text)
