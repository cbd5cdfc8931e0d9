"""Shipped systems as tables alone, which a function draws."""

import re

from vvdp.machines.rotary_bench import orifice_load
from vvdp.systems.circuits import table_slots
from vvdp.systems.system import shipped_systems


def tables_alone(name: str) -> str:
    """A shipped system of the rig without its drawing: its circuit draws it from its tables."""
    parts = re.split(r"(?m)^(?=\[)", shipped_systems()[name])
    kept = [part for part in parts[1:] if part[1 : part.index("]")] in (*table_slots(orifice_load), "run")]
    return parts[0] + "".join(kept)
