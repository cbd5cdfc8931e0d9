"""`vvdp report`."""

from importlib import import_module
from pathlib import Path
from typing import Annotated

import typer

from vvdp.cli.options import AsJson

RESULT = ("result_page", "write_result_report")
RUN = ("report", "write_report")
COMPARISON = ("comparison", "write_comparison_report")
WRITERS = {
    "result.json": RESULT,
    "design.json": ("design_report", "write_design_report"),
    "front.json": ("design_report", "write_front_report"),
    "tolerance.json": ("design_report", "write_tolerance_report"),
    "temperature.json": ("design_report", "write_temperature_report"),
}
"""What writes the report of a directory in which a file stands: module and function."""


def report(
    directory: Annotated[
        Path, typer.Argument(metavar="DIR", help="Result directory of any command except `vvdp geometry`.")
    ],
    json: AsJson = False,
) -> None:
    """Rebuild the report of a result directory."""
    from vvdp.base.errors import unusable
    from vvdp.cli.screen import print_json
    from vvdp.comparison.results import is_comparison

    if (directory / "geometry.toml").is_file():
        raise unusable(directory, "its report.html shows the solids themselves; run the command again for another")
    writer = next((writer for name, writer in WRITERS.items() if (directory / name).is_file()), RUN)
    if is_comparison(directory):
        writer = COMPARISON
    try:
        page = _write(writer, directory)
    except (KeyError, TypeError) as problem:
        raise unusable(directory, f"is damaged or not complete: {problem!r}") from None
    if json:
        print_json({"report": str(page)})
    else:
        typer.echo(str(page))


def add_report(writer: tuple[str, str], folder: Path) -> bool:
    """Writes the report beside results that are about to be put in place; Ctrl-C leaves it out, and gives False."""
    from vvdp.cli.screen import say

    try:
        _write(writer, folder)
    except KeyboardInterrupt:
        say("interrupted; the report is left out, the results are written")
        return False
    return True


def _write(writer: tuple[str, str], directory: Path) -> Path:
    module, name = writer
    page: Path = getattr(import_module(f"vvdp.report.{module}"), name)(directory)
    return page
