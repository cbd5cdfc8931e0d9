"""Shipped systems with other values."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from vvdp.base.tables import copy_tables
from vvdp.systems.drawn_parts import other_keys
from vvdp.systems.system import System, load_system


def variant(name: str, changes: Mapping[str, object]) -> System:
    """The shipped system called `name` with other entries by their paths, in its order; None leaves one out.

    Keys that another type does not take go with the old one.
    """
    system = load_system(name)
    content = copy_tables(system.table.content)
    for path, value in changes.items():
        *above, key = path.split(".")
        table: Any = content
        for word in above:
            table = table.setdefault(word, {})
        for other in other_keys(above[0], table, {key: value}) if key == "type" else ():
            del table[other]
        if value is None:
            table.pop(key, None)
        else:
            table[key] = copy_tables(value) if isinstance(value, Mapping) else value
    return system.read_from(replace(system.table, content=content))
