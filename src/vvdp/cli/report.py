"""`vvdp report`."""

from pathlib import Path
from typing import Annotated

import typer


def report(
    directory: Annotated[
        Path, typer.Argument(metavar="DIR", help="What `vvdp run`, `estimate` or `compare` has written.")
    ],
) -> None:
    """Write the report of a result directory anew."""
    from vvdp.comparison.results import is_comparison
    from vvdp.logs.kept import is_estimate
    from vvdp.report.comparison import write_comparison_report
    from vvdp.report.log_report import write_log_report
    from vvdp.report.report import write_report

    write = write_report
    if is_estimate(directory):
        write = write_log_report
    elif is_comparison(directory):
        write = write_comparison_report
    typer.echo(str(write(directory)))
