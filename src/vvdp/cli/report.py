"""`vvdp report`."""

from pathlib import Path
from typing import Annotated

import typer

DRAWN_ONCE = ("design.json", "front.json", "tolerance.json", "temperature.json", "geometry.toml")
"""Files of results whose page is made of more than the directory holds."""


def report(
    directory: Annotated[
        Path, typer.Argument(metavar="DIR", help="What `vvdp run`, `estimate`, `compare`, `map` or `rig` has written.")
    ],
) -> None:
    """Write the report of a result directory anew."""
    from vvdp.base.errors import unusable
    from vvdp.comparison.results import is_comparison
    from vvdp.logs.kept import is_estimate
    from vvdp.report.comparison import write_comparison_report
    from vvdp.report.log_report import write_log_report
    from vvdp.report.report import write_report
    from vvdp.report.rig_report import write_rig_report

    write = write_report
    if is_estimate(directory):
        write = write_log_report
    elif is_comparison(directory):
        write = write_comparison_report
    elif (directory / "rig.json").is_file():
        write = write_rig_report
    elif any((directory / name).is_file() for name in DRAWN_ONCE):
        raise unusable(directory, "its report.html is written with the result only; run the command again for another")
    typer.echo(str(write(directory)))
