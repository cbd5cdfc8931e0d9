"""`vvdp report`."""

from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Annotated, Any

import typer

from vvdp.cli.options import AsJson, Trust

RESULT, GEOMETRY = ("result_page", "write_result_report"), ("geometry_report", "write_geometry_report")
RUN, CFD = ("report", "write_report"), ("cfd_report", "write_cfd_report")
FLOW = "case/state.json"
"""The file by which a computed flow is known."""
WRITERS = {"geometry.toml": GEOMETRY, "result.json": RESULT}
"""Writer of the report of a directory, by a file that vvdp wrote there: module and function."""


def report(
    directory: Annotated[Path, typer.Argument(metavar="DIR", help="Result directory of any command.")],
    project: Annotated[str, typer.Option("--project", metavar="TEXT", help="Project named at the head.")] = "",
    customer: Annotated[str, typer.Option("--customer", metavar="TEXT", help="Customer named at the head.")] = "",
    live: Annotated[
        bool,
        typer.Option("--live", help="Put the system of a run into its report, as `vvdp run --live` does."),
    ] = False,
    trust: Trust = "",
    json: AsJson = False,
) -> None:
    """Rebuild the report of a result directory.

    A project or customer that was given once stays until another is given.
    """
    from vvdp.base.errors import unusable
    from vvdp.base.manifest import as_damaged, open_directory
    from vvdp.cli.screen import print_json, run_command, say
    from vvdp.results.store import add_labels

    files = open_directory(directory).files
    writer = CFD if (directory / FLOW).is_file() else next((w for name, w in WRITERS.items() if name in files), RUN)
    if live and writer != RUN:
        raise unusable(directory, "holds no run; only the report of a run takes --live")
    with as_damaged(directory):
        if project or customer:
            add_labels(directory, {"project": project, "customer": customer})
        options: dict[tuple[str, str], dict[str, Any]] = {RUN: {"trust": trust, "say": say}, GEOMETRY: {"trust": trust}}
        if live:
            options[RUN]["dress"] = dressing(run_command(str(directory / "system.toml")))
        page = _write(writer, directory, **options.get(writer, {}))
    if json:
        print_json({"report": str(page)})
    else:
        typer.echo(str(page))


def dressing(command: str) -> Callable[..., Any]:
    """Function that makes the page of a run interactive; `command` is the line that repeats the run."""
    from functools import partial

    from vvdp.cli.screen import say
    from vvdp.web.live import live_page

    return partial(live_page, command=command, say=say)


def add_report(writer: tuple[str, str], folder: Path, *results: Any, **options: Any) -> bool:
    """Writes the report beside results that are about to be put in place; Ctrl-C leaves it out, and gives False.

    `results` are at hand already, where the writer would otherwise read them.
    """
    from vvdp.cli.screen import say

    try:
        _write(writer, folder, *results, **options)
    except KeyboardInterrupt:
        say("interrupted; the report is left out, the results are written")
        return False
    return True


def _write(writer: tuple[str, str], directory: Path, *results: Any, **options: Any) -> Path:
    from vvdp.base.extras import require_solids

    if writer in (GEOMETRY, CFD):
        require_solids()
    module, name = writer
    page: Path = getattr(import_module(f"vvdp.report.{module}"), name)(directory, *results, **options)
    return page
