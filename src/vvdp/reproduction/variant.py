"""Shipped systems with other values and without some of their tables."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from vvdp.systems.system import System, load_system


def variant(name: str, *, without: Sequence[str] = (), **tables: Mapping[str, Any]) -> System:
    """The shipped system called `name` without some tables and with other values, as a file writes them."""
    system = load_system(name)
    content = {table: values for table, values in system.table.content.items() if table not in without}
    for table, values in tables.items():
        content[table] = {**content.get(table, {}), **values}
    return system.read_from(replace(system.table, content=content))
