"""`vvdp report`."""

from pathlib import Path
from typing import Annotated

import typer


def report(
    directory: Annotated[
        Path, typer.Argument(metavar="DIR", help="What a command with a report has written, but `vvdp geometry`.")
    ],
) -> None:
    """Write the report of a result directory anew."""
    from vvdp.base.errors import unusable
    from vvdp.comparison.results import is_comparison
    from vvdp.logs.kept import is_estimate
    from vvdp.report import design_report
    from vvdp.report.comparison import write_comparison_report
    from vvdp.report.log_report import write_log_report
    from vvdp.report.report import write_report
    from vvdp.report.rig_report import write_rig_report

    if (directory / "geometry.toml").is_file():
        raise unusable(directory, "its report.html shows the solids themselves; run the command again for another")
    writers = {
        "rig.json": write_rig_report,
        "design.json": design_report.write_design_report,
        "front.json": design_report.write_front_report,
        "tolerance.json": design_report.write_tolerance_report,
        "temperature.json": design_report.write_temperature_report,
    }
    write = next((writer for name, writer in writers.items() if (directory / name).is_file()), write_report)
    if is_estimate(directory):
        write = write_log_report
    elif is_comparison(directory):
        write = write_comparison_report
    try:
        page = write(directory)
    except (KeyError, TypeError) as problem:
        raise unusable(directory, f"is damaged or not complete: {problem!r}") from None
    typer.echo(str(page))
