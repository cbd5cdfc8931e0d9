"""`vvdp compare`."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, TypeVar

import typer

from vvdp.cli.engines import HERE, Spread
from vvdp.cli.options import (
    AsJson,
    Force,
    NoReport,
    OwnCycles,
    Trust,
    Verb,
    default_directory,
    flat,
    out_option,
    parsed_option,
)
from vvdp.cli.printing import show_result, write_with_report

if TYPE_CHECKING:
    from vvdp.comparison.contest import Titled
    from vvdp.machines.duties import Duty
    from vvdp.results.result import Result, Table
    from vvdp.rivals.rival_circuits import RivalCircuit

INTERRUPTED = 130
MOST_MISSING = 5
"""Missing runs that are named after an interrupt."""
SECONDS_OF_A_CIRCUIT = 1.3
"""Processor time of a circuit on a cycle, with the common reference or at one error, mean over all pairs [s]."""

app = typer.Typer(no_args_is_help=True, rich_markup_mode=None)

Chosen = TypeVar("Chosen", bound="Titled")
Scenarios = Annotated[
    list[str] | None, typer.Option("--scenario", metavar="NAME", help="Run this scenario only (repeatable).")
]


@dataclass(frozen=True)
class Trials(Spread):
    """Options of a comparison: where it writes, where its runs are carried out, what is shown."""

    def seconds(self, of_a_core: float) -> float:
        """Time after which one more run is done, each of so many seconds of a core [s]; 0, unknown, if not run here."""
        from vvdp.simulation.crew import all_cores

        return of_a_core / (self.cores or all_cores()) if self.on == HERE else 0.0


@dataclass(frozen=True)
class Wheel:
    """Options: the encoder whose readings are estimated from."""

    sectors: Annotated[
        int,
        typer.Option("--sectors", metavar="N", min=2, help="Number of sectors of the code wheel, bright plus dark."),
    ] = 8
    rate: Annotated[
        str, typer.Option("--rate", metavar="FREQUENCY", help='Sample rate of the encoder, for example "1 kHz".')
    ] = "1 kHz"


@dataclass(frozen=True)
class Circuits:
    """Options: duty cycles and circuits, and the error at which these are compared."""

    cycle: Annotated[
        list[str] | None, typer.Option("--cycle", metavar="NAME", help="Run this duty cycle only (repeatable).")
    ] = None
    circuit: Annotated[
        list[str] | None, typer.Option("--circuit", metavar="NAME", help="Run this circuit only (repeatable).")
    ] = None
    own: OwnCycles = None
    valve: Annotated[
        str | None,
        typer.Option("--valve", metavar="SYSTEM", help="Add the machine with the rotary valve of another system."),
    ] = None
    error: Annotated[
        str | None,
        typer.Option(
            "--error",
            metavar="LENGTH",
            help='Compare at this rms tracking error, for example "2 mm"; default: the largest.',
        ),
    ] = None

    @property
    def duties(self) -> "list[Duty]":
        """The duty cycles that are run."""
        from vvdp.machines.duties import known_cylinder, read_duty, shipped_duties

        given = [read_duty(path, *known_cylinder()) for path in self.own or ()]
        return [*(_choose("--cycle", self.cycle, shipped_duties()) if self.cycle or not given else ()), *given]

    @property
    def rivals(self) -> "list[RivalCircuit]":
        """The circuits that are run."""
        from vvdp.rivals.rival_circuits import CIRCUITS, machine_with_valve

        return _choose(
            "--circuit", self.circuit, (*CIRCUITS, *([machine_with_valve(self.valve)] if self.valve else []))
        )

    @property
    def wanted_error(self) -> float | None:
        """The rms error at which all are compared [m]. Raises ConfigError for one of 0."""
        from vvdp.base.errors import ConfigError, Fault
        from vvdp.base.kinds import LENGTH

        wanted = None if self.error is None else parsed_option("--error", self.error, LENGTH)
        if wanted == 0.0:
            raise ConfigError([Fault("--error", 0, "", f"{self.error} must be greater than 0")])
        return wanted


@app.callback()
def compare() -> None:
    """Compare runs, estimators, controllers, or circuits."""


@app.command(cls=Verb)
def runs(
    directories: Annotated[list[Path], typer.Argument(metavar="DIR", help="Result directories of `vvdp run`.")],
    out: Annotated[Path | None, out_option("results/compare-runs-DATE-TIME")] = None,
    trust: Trust = "",
    force: Force = False,
    json: AsJson = False,
    no_report: NoReport = False,
) -> None:
    """Compare runs: parameters that differ, numbers side by side, series over each other.

    Differences are to the first run.
    """
    from vvdp.base.files import result_directory
    from vvdp.base.manifest import as_damaged
    from vvdp.comparison.runs import RUNS, compare_runs

    with as_damaged(directories[0]):
        result = compare_runs(directories, trust)
    directory = out if out is not None else default_directory("compare-runs")
    with result_directory(directory, force=force) as folder:
        reported = write_with_report(folder, result, "", no_report=no_report)
    shown = replace(result, charts={}, tables={RUNS: result.tables[RUNS]}) if json else result  # series are long
    show_result(shown, directory, json=json, reported=reported)


@app.command(cls=Verb)
@flat("results/compare-estimators-DATE-TIME")
def estimators(
    *,
    scenario: Scenarios = None,
    estimator: Annotated[
        list[str] | None, typer.Option("--estimator", metavar="NAME", help="Run this estimator only (repeatable).")
    ] = None,
    seeds: Annotated[
        int, typer.Option("--seeds", metavar="N", min=1, help="Number of random runs per scenario.")
    ] = 200,
    wheel: Wheel,
    work: Trials,
    show: Annotated[bool, typer.Option("--list", help="List scenarios and estimators without running any.")] = False,
) -> None:
    """Run estimators on the same readings of a simulated encoder.

    Ctrl-C stops the comparison early and keeps the completed runs.
    """
    from vvdp.base.kinds import FREQUENCY
    from vvdp.comparison.estimators import contenders
    from vvdp.comparison.result import comparison_result, screen_tables
    from vvdp.comparison.scenarios import scenarios
    from vvdp.comparison.trials import compare

    frequency = parsed_option("--rate", wheel.rate, FREQUENCY)
    chosen = _choose("--scenario", scenario, scenarios(wheel.sectors, frequency))
    rivals = _choose("--estimator", estimator, contenders(wheel.sectors, frequency))
    if show:
        _print_names(chosen, rivals, "estimator")
        return
    directory = work.directory("compare-estimators")
    engine = work.engine(directory.parent)
    note = (
        "errors are estimate minus truth, rms over all runs, 95 % of each run and then their mean; "
        "lost in sectors, settling as the median\n"
    )
    contest = _Contest(
        compare=lambda **how: compare(chosen, rivals, seeds, engine=engine, **how),
        result=comparison_result,
        screen=screen_tables,
        contenders="estimators",
        note=note,
    )
    _carry_out(contest, directory, work)


@app.command(cls=Verb)
@flat("results/compare-controllers-DATE-TIME")
def controllers(
    *,
    scenario: Scenarios = None,
    controller: Annotated[
        list[str] | None, typer.Option("--controller", metavar="NAME", help="Run this controller only (repeatable).")
    ] = None,
    seeds: Annotated[int, typer.Option("--seeds", metavar="N", min=1, help="Number of random runs per scenario.")] = 20,
    work: Trials,
    show: Annotated[bool, typer.Option("--list", help="List scenarios and controllers without running any.")] = False,
) -> None:
    """Run controllers of the spool's axial position on the same simulated drive, a pressure chamber against a spring.

    Ctrl-C stops the comparison early and keeps the completed runs.
    """
    from vvdp.comparison.controllers import controllers as known_controllers
    from vvdp.comparison.loop_result import controller_result, screen_tables
    from vvdp.comparison.loop_scenarios import loop_scenarios
    from vvdp.comparison.loop_trials import compare_controllers

    chosen = _choose("--scenario", scenario, loop_scenarios())
    rivals = _choose("--controller", controller, known_controllers())
    if show:
        _print_names(chosen, rivals, "controller")
        return
    directory = work.directory("compare-controllers")
    engine = work.engine(directory.parent)
    contest = _Contest(
        compare=lambda **how: compare_controllers(chosen, rivals, seeds, engine=engine, **how),
        result=controller_result,
        screen=screen_tables,
        contenders="controllers",
        note="tracking is position minus reference, estimate is estimate less position, both rms over all runs\n",
    )
    _carry_out(contest, directory, work)


@app.command(cls=Verb)
@flat("results/compare-circuits-DATE-TIME")
def circuits(
    *,
    what: Circuits,
    work: Trials,
    show: Annotated[bool, typer.Option("--list", help="List duty cycles and circuits without running any.")] = False,
) -> None:
    """Run circuits that move the same cylinder through the same duty cycles: where the power goes, what comes back.

    All circuits follow with the same rms error: each receives its reference as late as that takes.

    Ctrl-C stops the comparison early and keeps the completed runs.
    """
    from vvdp.comparison.circuit_result import circuit_result, errors_in_mm, screen_tables
    from vvdp.comparison.circuit_trials import compare_circuits

    duties, rivals = what.duties, what.rivals
    if show:
        _print_names(duties, rivals, "circuit", "cycle")
        return
    wanted = what.wanted_error
    directory = work.directory("compare-circuits")
    contest = _Contest(
        compare=lambda **how: compare_circuits(
            duties, rivals, error=wanted, engine=work.engine(directory.parent), **how
        ),
        result=circuit_result,
        screen=screen_tables,
        contenders="circuits",
        note="powers are means over a round; delivered while the rod is pushed, received while the load overruns\n",
        seconds_each=SECONDS_OF_A_CIRCUIT,
        further=("front",),
        more=errors_in_mm,
    )
    _carry_out(contest, directory, work)


@dataclass(frozen=True)
class _Contest:
    """A comparison of contenders: how it is run, its result, its tables on the screen, and a note below these.

    seconds_each  usual processor time of a run [s], where it is long enough to be announced
    further       tables that stand in the JSON object beside those of scores and contenders
    more          what stands there beside the tables
    """

    compare: Callable[..., Any]
    result: Callable[[Any], "Result"]
    screen: Callable[[Any, "Result"], Mapping[str, "Table"]]
    contenders: str
    note: str
    seconds_each: float = 0.0
    further: tuple[str, ...] = ()
    more: "Callable[[Result], Mapping[str, object]]" = lambda result: {}


def _carry_out(contest: _Contest, directory: Path, work: Trials) -> None:
    """Runs a comparison, writes its result and prints it; exits with 130 after an interrupt."""
    from vvdp.base.files import result_directory
    from vvdp.cli.progress import count_lines
    from vvdp.cli.screen import say

    with result_directory(directory, force=work.force) as folder:
        with count_lines("runs", work.seconds(contest.seconds_each)) as progress:
            found = contest.compare(progress=progress, say=say)
        result = contest.result(found)
        reported = write_with_report(folder, result, "", no_report=work.no_report)
    if work.json:
        kept = {name: result.tables[name] for name in ("comparison", contest.contenders, *contest.further)}
        shown = replace(result, charts={}, tables=kept)
    else:
        _print_scenarios(contest.screen(found, result), contest.note)
        shown = result
    more = contest.more(result) if work.json else {}
    show_result(shown, directory, json=work.json, reported=reported, names=(contest.contenders,), more=more)
    if not found.finished:
        say(f"interrupted after {found.runs} of {found.all_runs} runs; these were written")
        say(f"missing: {_few(found.missing)}")
        raise typer.Exit(INTERRUPTED)


def _few(names: Sequence[str]) -> str:
    """The first of some names, and how many more there are."""
    rest = len(names) - MOST_MISSING
    return ", ".join(names[:MOST_MISSING]) + (f" and {rest} more" if rest > 0 else "")


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


def _print_names(
    scenarios: Sequence["Titled"], contenders: Sequence["Titled"], what: str, where: str = "scenario"
) -> None:
    from vvdp.cli.screen import console, grid

    for head, meaning, title, found in (
        (where, "what happens", f"{where.capitalize()}s", scenarios),
        (what, "what it is", f"{what.capitalize()}s", contenders),
    ):
        table = grid(head, meaning, title=title)
        for each in found:
            table.add_row(each.name, each.title)
        console().print(table)


def _print_scenarios(tables: Mapping[str, "Table"], note: str) -> None:
    """A table for every scenario: what matters; the rest stands in the files."""
    from vvdp.cli.printing import table_grid
    from vvdp.cli.screen import console, tell

    for table in tables.values():
        console().print(table_grid("comparison", table))
    tell(note)
