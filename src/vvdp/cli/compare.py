"""`vvdp compare`."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Protocol, TypeVar

import typer

from vvdp.cli.engines import HERE, Cores, On, Sbatch, Workers, chosen_engine
from vvdp.cli.options import AsJson, Force, NoReport, Verb, default_directory, out_option, parsed_option
from vvdp.cli.printing import show_result, write_with_report

if TYPE_CHECKING:
    from vvdp.cli.table import Grid
    from vvdp.comparison.estimators import Contender
    from vvdp.comparison.results import Comparison
    from vvdp.comparison.scenarios import Scenario
    from vvdp.comparison.scores import Measured

INTERRUPTED = 130

app = typer.Typer(no_args_is_help=True, rich_markup_mode=None)


class _Named(Protocol):
    @property
    def name(self) -> str: ...


Chosen = TypeVar("Chosen", bound=_Named)


@app.callback()
def compare() -> None:
    """Compare runs, or estimators on simulated data."""


@app.command(cls=Verb)
def runs(
    directories: Annotated[list[Path], typer.Argument(metavar="DIR", help="Result directories of `vvdp run`.")],
    out: Annotated[Path | None, out_option("results/compare-runs-DATE-TIME")] = None,
    force: Force = False,
    json: AsJson = False,
    no_report: NoReport = False,
) -> None:
    """Compare runs: parameters that differ, numbers side by side, series over each other.

    Differences are to the first run.
    """
    from dataclasses import replace

    from vvdp.base.files import result_directory
    from vvdp.comparison.runs import compare_runs

    result = compare_runs(directories)
    directory = out if out is not None else default_directory("compare-runs")
    with result_directory(directory, force=force) as folder:
        reported = write_with_report(folder, result, "", no_report=no_report)
    shown = replace(result, charts={}, tables={"runs": result.tables["runs"]}) if json else result  # series are long
    show_result(shown, directory, json=json, reported=reported)


@app.command(cls=Verb)
def estimators(
    scenario: Annotated[
        list[str] | None, typer.Option("--scenario", metavar="NAME", help="Run this scenario only (repeatable).")
    ] = None,
    estimator: Annotated[
        list[str] | None, typer.Option("--estimator", metavar="NAME", help="Run this estimator only (repeatable).")
    ] = None,
    seeds: Annotated[
        int, typer.Option("--seeds", metavar="N", min=1, help="Number of random runs per scenario.")
    ] = 200,
    sectors: Annotated[
        int,
        typer.Option("--sectors", metavar="N", min=2, help="Number of sectors of the code wheel, bright plus dark."),
    ] = 8,
    rate: Annotated[
        str, typer.Option("--rate", metavar="FREQUENCY", help='Sample rate of the encoder, for example "1 kHz".')
    ] = "1 kHz",
    out: Annotated[Path | None, out_option("results/compare-estimators-DATE-TIME")] = None,
    force: Force = False,
    on: On = HERE,
    workers: Workers = None,
    cores: Cores = None,
    sbatch: Sbatch = None,
    json: AsJson = False,
    no_report: NoReport = False,
    show: Annotated[bool, typer.Option("--list", help="List scenarios and estimators without running any.")] = False,
) -> None:
    """Run estimators on the same readings of a simulated encoder.

    Ctrl-C stops the comparison early and keeps the completed runs.
    """
    from vvdp.base.files import result_directory
    from vvdp.base.kinds import FREQUENCY
    from vvdp.cli.progress import counted
    from vvdp.cli.screen import print_json, say
    from vvdp.comparison.estimators import contenders
    from vvdp.comparison.results import write_comparison
    from vvdp.comparison.scenarios import scenarios
    from vvdp.comparison.trials import compare
    from vvdp.report.comparison import write_comparison_report

    frequency = parsed_option("--rate", rate, FREQUENCY)
    chosen = _chosen("--scenario", scenario, scenarios(sectors, frequency))
    rivals = _chosen("--estimator", estimator, contenders(sectors, frequency))
    if show:
        _print_names(chosen, rivals)
        return
    directory = out if out is not None else default_directory("compare-estimators")
    engine = chosen_engine(on, workers, cores, sbatch, directory.parent)
    with result_directory(directory, force=force) as folder:
        with counted("runs") as progress:
            found = compare(chosen, rivals, seeds, engine=engine, progress=progress, say=say)
        write_comparison(folder, found)
        if not no_report:
            write_comparison_report(folder)
    if json:
        print_json({**found.content, "out": str(directory)})
    else:
        _print(found)
        typer.echo(f"results: {directory}" + ("" if no_report else f"\nreport: {directory / 'report.html'}"))
    if not found.finished:
        done = sum(played.runs for played in found.scenarios.values())
        say(f"interrupted after {done} of {seeds * len(chosen)} runs; these were written")
        raise typer.Exit(INTERRUPTED)


def _chosen(option: str, names: list[str] | None, known: Sequence[Chosen]) -> list[Chosen]:
    """Those of `known` that are named, all without names. Raises ConfigError with every name that is not known."""
    from vvdp.base.errors import ConfigError, Fault
    from vvdp.base.tables import nearest

    by_name = {each.name: each for each in known}
    unknown = [name for name in names or () if name not in by_name]
    faults = [Fault(option, 0, name, f"unknown{nearest(name, list(by_name))}") for name in unknown]
    if faults:
        raise ConfigError(faults)
    return [by_name[name] for name in dict.fromkeys(names or by_name)]


def _print_names(scenarios: Sequence["Scenario"], contenders: Sequence["Contender"]) -> None:
    from vvdp.cli.screen import console, grid

    table = grid("scenario", "what happens", title="Scenarios")
    for scenario in scenarios:
        table.add_row(scenario.name, scenario.title)
    console().print(table)
    table = grid("estimator", "what it is", title="Estimators")
    for contender in contenders:
        table.add_row(contender.name, contender.title)
    console().print(table)


def _print(found: "Comparison") -> None:
    """A table for every scenario: what matters; the rest stands in the files."""
    from vvdp.cli.screen import console, grid

    screen = console()
    for scenario, (title, changes, runs) in found.scenarios.items():
        if not runs:
            continue
        columns = ["speed rms", "95 %", "angle rms", "95 %", "lost", "NIS", *(("settles", "delay") if changes else ())]
        table = grid("estimator", *columns, title=f"{scenario}: {title}", right=tuple(columns))
        for estimator in found.estimators:
            table.add_row(estimator, *_cells(found.scores[scenario, estimator], changes))
        screen.print(table)
    typer.echo(
        "speed in rad/s, angle in rad, lost in sectors, settling (median) and delay in ms; estimate less truth\n"
    )
    screen.print(_robustness(found))
    runs = sum(played.runs for played in found.scenarios.values())
    typer.echo(
        f"{runs} runs of {len(found.estimators)} estimators in {found.seconds:.1f} s; "
        f"{found.sectors} sectors, {found.rate:g} Hz"
    )


def _robustness(found: "Comparison") -> "Grid":
    """What each estimator costs, and in which scenarios it loses count in one run or more."""
    from vvdp.cli.screen import grid

    table = grid("estimator", "ns per sample", "sectors lost in", title="Cost and robustness", right=("ns per sample",))
    for estimator, cost in found.costs.items():
        lost = [
            scenario
            for scenario, played in found.scenarios.items()
            if played.runs and found.scores[scenario, estimator]["lost_sectors"].value > 0.0
        ]
        table.add_row(estimator, f"{1e9 * cost.value:.0f}", ", ".join(lost) or "none")
    return table


def _cells(figures: Mapping[str, "Measured"], changes: bool) -> list[str]:
    from vvdp.report.comparison import size

    names = ("speed_error_rms_rad_s", "speed_error_95_rad_s", "angle_error_rms_rad", "angle_error_95_rad")
    cells = [size(figures[name].value) for name in names]
    cells += [size(figures["lost_sectors"].value, 2), size(figures["nis"].value)]
    if changes:
        cells += [size(1e3 * figures["settling_median_s"].value), size(1e3 * figures["delay_s"].value)]
    return cells
