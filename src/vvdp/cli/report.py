"""`vvdp report`."""

from importlib import import_module
from pathlib import Path
from typing import Annotated, Any

import typer

from vvdp.cli.options import AsJson

RESULT, GEOMETRY = ("result_page", "write_result_report"), ("geometry_report", "write_geometry_report")
RUN, CFD = ("report", "write_report"), ("cfd_report", "write_cfd_report")
WRITERS = {
    "case/state.json": CFD,
    "geometry.toml": GEOMETRY,
    "result.json": RESULT,
}
"""What writes the report of a directory in which a file stands: module and function."""


def report(
    directory: Annotated[Path, typer.Argument(metavar="DIR", help="Result directory of any command.")],
    project: Annotated[str, typer.Option("--project", metavar="TEXT", help="Project named at the head.")] = "",
    customer: Annotated[str, typer.Option("--customer", metavar="TEXT", help="Customer named at the head.")] = "",
    json: AsJson = False,
) -> None:
    """Rebuild the report of a result directory.

    A project or customer that was given once stays until another is given.
    """
    from vvdp.base.errors import unusable
    from vvdp.cli.screen import print_json
    from vvdp.results.store import add_labels

    writer = next((writer for name, writer in WRITERS.items() if (directory / name).is_file()), RUN)
    try:
        if project or customer:
            add_labels(directory, {"project": project, "customer": customer})
        page = _write(writer, directory)
    except (KeyError, TypeError) as problem:
        raise unusable(directory, f"is damaged or not complete: {problem!r}") from None
    if json:
        print_json({"report": str(page)})
    else:
        typer.echo(str(page))


def add_report(writer: tuple[str, str], folder: Path, *results: Any) -> bool:
    """Writes the report beside results that are about to be put in place; Ctrl-C leaves it out, and gives False.

    `results` are at hand already, where the writer would otherwise read them.
    """
    from vvdp.cli.screen import say

    try:
        _write(writer, folder, *results)
    except KeyboardInterrupt:
        say("interrupted; the report is left out, the results are written")
        return False
    return True


def _write(writer: tuple[str, str], directory: Path, *results: Any) -> Path:
    from vvdp.base.extras import require_solids

    if writer in (GEOMETRY, CFD):
        require_solids()
    module, name = writer
    page: Path = getattr(import_module(f"vvdp.report.{module}"), name)(directory, *results)
    return page
