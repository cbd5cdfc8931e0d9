"""The page of a component or program in the terminal."""

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from vvdp.base.errors import ConfigError
    from vvdp.systems.library_pages import Described, LibraryPage


def pages_of(words: Iterable[str]) -> "list[LibraryPage]":
    """The pages of those words that name a component or program."""
    from vvdp.components.library import COMPONENTS
    from vvdp.programs.library import PROGRAMS
    from vvdp.systems.library_pages import library_page

    return [library_page(word) for word in words if word in COMPONENTS or word in PROGRAMS]


INPUTS = (
    'An input is a value, a signal over time, or { from = "NAME.QUANTITY" }, a quantity of the circuit or an output of '
    'a program; a program may have it as "NAME.QUANTITY" alone.'
)
"""How inputs of components and programs are written in a file."""


def descriptions() -> dict[str, str]:
    """The description of each component and program of the library by its type, in small letters."""
    from vvdp.components.library import COMPONENTS
    from vvdp.programs.library import PROGRAMS
    from vvdp.systems.library_pages import library_page

    return {kind: library_page(kind).description.lower() for kind in (*COMPONENTS, *PROGRAMS)}


def print_page(page: "LibraryPage") -> None:
    """Prints all about a component or program: description, values, rules, a file that runs, and equations."""
    from vvdp.cli.screen import tell

    tell(f"{page.type}: {page.description}")
    ports = ", ".join(f"{port.name} {port.meaning}".strip() for port in page.ports)
    if ports:
        tell(f"\nPorts: {ports}")
    for title, rows in (("Inputs", page.inputs), ("Values", page.values), ("Outputs", page.outputs)):
        _print_values(title, rows)
        if rows and rows is page.inputs:
            tell(INPUTS)
    for title, lines in (("Rules", page.rules), ("Warnings of a run", page.warnings)):
        if lines:
            tell("\n".join([f"\n{title}", *(f"  {line}" for line in lines)]))
    if page.example:
        tell(f"\nA file that runs (vvdp new NAME --from {page.type} writes it)\n\n{page.example.rstrip()}")
    tell("\nEquations")
    for each in page.equations:
        tell(f"\n{each.text.rstrip()}" + (f"\n    # {each.source}" if each.source else ""))


def _print_values(title: str, rows: "Sequence[Described]") -> None:
    from vvdp.cli.screen import console, grid

    if not rows:
        return
    table = grid("name", "example", "default", "meaning", title=f"\n{title}")
    for row in rows:
        table.add_row(row.name, row.example, row.usual, f"{row.meaning} [{row.unit}]" if row.unit else row.meaning)
    console().print(table)


def pages_for(problem: "ConfigError") -> str:
    """A line that names the pages of the components and programs with faults; empty without one."""
    from vvdp.base.errors import VvdpError
    from vvdp.base.tables import read_table
    from vvdp.components.library import COMPONENTS
    from vvdp.programs.library import PROGRAMS

    found: dict[str, None] = {}
    for fault in problem.faults:
        table, _, rest = fault.key.partition(".")
        if table not in ("components", "programs"):
            continue
        try:
            part = read_table(Path(fault.place)).content.get(table, {}).get(rest.partition(".")[0], {})
        except (VvdpError, AttributeError):
            continue  # a shipped system, or no table
        kind = part.get("type") if isinstance(part, dict) else None
        if isinstance(kind, str) and (kind in COMPONENTS or kind in PROGRAMS):
            found[kind] = None
    return f"values with their meaning, and a file that runs: vvdp list {' '.join(found)}" if found else ""
