"""`vvdp plot`."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from vvdp.cli.completion import drawable_names
from vvdp.cli.options import AsJson, Trust, flat, parsed_option

if TYPE_CHECKING:
    from vvdp.results.result import Result


@dataclass(frozen=True)
class Figure:
    """Options: what is drawn, from when to when, and the file to write."""

    names: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="[NAME]...", help="Charts and series, drawn over one axis.", autocompletion=drawable_names
        ),
    ] = None
    out: Annotated[
        Path | None, typer.Option("--out", metavar="FILE", help="Figure, PNG, SVG or PDF (default: NAME.png).")
    ] = None
    begin: Annotated[str | None, typer.Option("--from", metavar="TIME", help="Left end of the time axis.")] = None
    end: Annotated[str | None, typer.Option("--to", metavar="TIME", help="Right end of the time axis.")] = None

    @property
    def span(self) -> tuple[float | None, float | None]:
        """Both ends of the time axis [s]; None where that of the series is meant."""
        from vvdp.base.kinds import TIME

        return (
            None if self.begin is None else parsed_option("--from", self.begin, TIME),
            None if self.end is None else parsed_option("--to", self.end, TIME),
        )


@flat()
def plot(
    *,
    directory: Annotated[Path, typer.Argument(metavar="DIR", help="Result directory.")],
    figure: Figure,
    show: Annotated[bool, typer.Option("--list", help="List what can be drawn (default without a NAME).")] = False,
    force: Annotated[bool, typer.Option("--force", help="Replace an existing file.")] = False,
    trust: Trust = "",
    json: AsJson = False,
) -> None:
    """Draw charts or series of a result as PNG, SVG or PDF."""
    from vvdp.base.errors import unusable
    from vvdp.base.manifest import as_damaged
    from vvdp.cli.screen import print_json, say
    from vvdp.report.chosen import check_form, chosen_chart, open_drawable, series_names, write_figure
    from vvdp.runs.untold import TITLE as UNTOLD

    span, out, names = figure.span, figure.out, figure.names
    if out is not None:
        check_form(out)
    with as_damaged(directory):
        result = open_drawable(directory, trust)
    for each in result.findings if result.verb == "run" else ():
        if each.title == UNTOLD:
            say(each.text)
    if show or not names:
        if json:
            print_json({"charts": list(result.charts), "series": list(series_names(result))})
        else:
            _print_names(result)
        return
    path = out if out is not None else Path(f"{'-'.join(names)}.png")
    if path.exists() and (path.is_dir() or not force):
        raise unusable(path, "already exists; choose another name or use --force")
    with as_damaged(directory):
        write_figure(path, chosen_chart(result, names, span), result)
    if json:
        print_json({"figure": str(path)})
    else:
        typer.echo(str(path))


def _print_names(result: "Result") -> None:
    from vvdp.cli.screen import console, grid
    from vvdp.report.chosen import series_labels, series_names

    charts = grid("chart", "what it shows", title="Charts")
    for chart in result.charts.values():
        charts.add_row(chart.name, chart.caption.partition(". ")[0].partition(";")[0].removesuffix("."))
    series = grid("series", "what it is", "table", title="Series")
    for name, table, label in series_labels(result):
        series.add_row(name, label, table)
    for each, known in ((charts, result.charts), (series, series_names(result))):
        if known:
            console().print(each)
