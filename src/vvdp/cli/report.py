"""`vvdp report`."""

from pathlib import Path
from typing import Annotated

import typer


def report(
    directory: Annotated[Path, typer.Argument(metavar="DIR", help="A directory that `vvdp run` has written.")],
) -> None:
    """Write the report of a result directory anew."""
    from vvdp.report.report import write_report

    typer.echo(str(write_report(directory)))
