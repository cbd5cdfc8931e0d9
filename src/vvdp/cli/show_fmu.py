"""Output of `vvdp show FILE.fmu`: the description of an FMU, of which nothing is run."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from vvdp.programs.foreign.archive import Archive

SHOWN = ("input", "output", "parameter")
"""Causalities of the variables that are listed."""


def show_fmu(path: Path, *, json: bool) -> None:
    """Prints the description. Raises ConfigError if the file cannot be used."""
    from vvdp.base.errors import ParameterError, unusable
    from vvdp.cli.screen import console, grid, print_json, tell
    from vvdp.programs.foreign.archive import open_archive

    try:
        archive = open_archive(path)
    except ParameterError as problem:
        raise unusable(path, str(problem)) from None
    found = fmu_facts(archive)
    if json:
        print_json(found)
        return
    tool = found["tool"] or "no named tool"
    tell(f"{found['model']}, FMI {found['fmi']}, {', '.join(found['kinds'])}, written by {tool}")
    tell(f"binaries: {', '.join(found['platforms']) or 'none'}")
    for causality in SHOWN:
        rows = [each for each in found["variables"] if each["causality"] == causality]
        table = grid("variable", "type", "unit", "start", "changes", title=f"{causality.capitalize()}s")
        for each in rows:
            start = "" if each["start"] is None else f"{each['start']:g}"
            table.add_row(each["name"], each["type"], each["unit"], start, each["variability"])
        if rows:
            console().print(table)


def fmu_facts(archive: "Archive") -> dict[str, Any]:
    """The description of an FMU, as JSON has it."""
    known = archive.description
    return {
        "verb": "show",
        "model": known.model,
        "fmi": known.fmi,
        "kinds": list(known.kinds),
        "tool": known.tool,
        "platforms": archive.platforms,
        "variables": [
            {
                "name": each.name,
                "causality": each.causality,
                "type": each.type,
                "unit": each.unit,
                "start": each.start,
                "variability": each.variability,
            }
            for each in known.variables.values()
            if each.causality in SHOWN
        ],
    }
