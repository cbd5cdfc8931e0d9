"""`vvdp compare`."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Protocol, TypeVar

import typer

from vvdp.cli.engines import HERE, Cores, On, Sbatch, Workers, chosen_engine
from vvdp.cli.options import AsJson, Force, NoReport, Verb, default_directory, out_option, parsed_option
from vvdp.cli.printing import show_result, write_with_report

if TYPE_CHECKING:
    from vvdp.comparison.estimators import Contender
    from vvdp.comparison.results import Comparison
    from vvdp.comparison.scenarios import Scenario
    from vvdp.results.result import Result

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
    from vvdp.cli.progress import count_lines
    from vvdp.cli.screen import say
    from vvdp.comparison.estimators import contenders
    from vvdp.comparison.result import comparison_result
    from vvdp.comparison.scenarios import scenarios
    from vvdp.comparison.trials import compare

    frequency = parsed_option("--rate", rate, FREQUENCY)
    chosen = _choose("--scenario", scenario, scenarios(sectors, frequency))
    rivals = _choose("--estimator", estimator, contenders(sectors, frequency))
    if show:
        _print_names(chosen, rivals)
        return
    directory = out if out is not None else default_directory("compare-estimators")
    engine = chosen_engine(on, workers, cores, sbatch, directory.parent)
    with result_directory(directory, force=force) as folder:
        with count_lines("runs") as progress:
            found = compare(chosen, rivals, seeds, engine=engine, progress=progress, say=say)
        result = comparison_result(found)
        reported = write_with_report(folder, result, "", no_report=no_report)
    if json:
        kept = {name: result.tables[name] for name in ("comparison", "estimators")}
        result = replace(result, charts={}, tables=kept)
    else:
        _print_scenarios(found, result)
    show_result(result, directory, json=json, reported=reported, names=("estimators",))
    if not found.finished:
        done = sum(played.runs for played in found.scenarios.values())
        say(f"interrupted after {done} of {seeds * len(chosen)} runs; these were written")
        raise typer.Exit(INTERRUPTED)


def _choose(option: str, names: list[str] | None, known: Sequence[Chosen]) -> list[Chosen]:
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


def _print_scenarios(found: "Comparison", result: "Result") -> None:
    """A table for every scenario: what matters; the rest stands in the files."""
    from vvdp.cli.printing import table_grid
    from vvdp.cli.screen import console, tell
    from vvdp.comparison.result import scenario_tables

    for table in scenario_tables(found, result).values():
        console().print(table_grid("comparison", table))
    tell(
        "errors are estimate less truth, rms over all runs, 95 % of each run and then their mean; "
        "lost in sectors, settling as the median\n"
    )
