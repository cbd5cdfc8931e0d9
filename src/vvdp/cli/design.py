"""`vvdp design`: optimum, trade-offs, tolerances and oil temperature of a valve."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from typer.core import TyperGroup

from vvdp.cli.constraints import Constraints
from vvdp.cli.options import (
    Output,
    RigCase,
    Seed,
    Verb,
    flat,
    parsed_option,
)
from vvdp.cli.printing import show_result, write_with_report
from vvdp.cli.robust import robust

if TYPE_CHECKING:
    from vvdp.design.optimise import Optimum
    from vvdp.design.problem import Problem
    from vvdp.design.proof import Proof
    from vvdp.design.sensitivity import LimitCurve
    from vvdp.results.result import Result
    from vvdp.systems.system import System

INTERRUPTED = 130


class _OptimumUnlessNamed(TyperGroup):
    """`vvdp design SYSTEM` is `vvdp design optimum SYSTEM`: where no question is named, it is that one."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Puts the question in front where it is missing."""
        if args and args[0] not in self.commands and args[0] not in ("-h", "--help") and not self._misspells(args[0]):
            args = ["optimum", *args]
        return super().parse_args(ctx, args)

    def shell_complete(self, ctx: Any, incomplete: str) -> list[Any]:
        """The questions, and the systems of which the optimum is asked."""
        questions = super().shell_complete(ctx, incomplete)
        return questions + self.commands["optimum"].params[0].shell_complete(ctx, incomplete)

    def _misspells(self, word: str) -> bool:
        """Whether a word is rather a question with a slip than a system."""
        from vvdp.base.tables import suggestion
        from vvdp.systems.system import named_systems

        return bool(suggestion(word, self.commands)) and word not in named_systems() and not Path(word).exists()


app = typer.Typer(cls=_OptimumUnlessNamed, no_args_is_help=True, rich_markup_mode=None)

NoUsualLimits = Annotated[
    bool,
    typer.Option("--no-usual-limits", help="Drop the default constraints."),
]


@dataclass(frozen=True)
class Search:
    """Options: how an optimum is searched for."""

    starts: Annotated[int, typer.Option("--starts", metavar="N", min=1, help="Number of random starting points.")] = 20
    seed: Seed = 1
    no_simulation: Annotated[
        bool, typer.Option("--no-simulation", help="Do not simulate the original and the optimum.")
    ] = False
    no_usual_limits: NoUsualLimits = False


@dataclass(frozen=True)
class Objectives:
    """Options: what designs are traded for."""

    minimise: Annotated[
        list[str] | None, typer.Option("--minimise", metavar="QUANTITY", help="Quantity to minimise (repeatable).")
    ] = None
    maximise: Annotated[
        list[str] | None, typer.Option("--maximise", metavar="QUANTITY", help="Quantity to maximise (repeatable).")
    ] = None


@dataclass(frozen=True)
class FrontSearch:
    """Options: how the Pareto front is searched for."""

    points: Annotated[int, typer.Option("--points", metavar="N", min=8, help="Number of designs on the front.")] = 60
    generations: Annotated[int, typer.Option("--generations", metavar="N", min=1, help="Number of generations.")] = 60
    seed: Seed = 1
    no_simulation: Annotated[bool, typer.Option("--no-simulation", help="Do not simulate the designs.")] = False
    no_usual_limits: NoUsualLimits = False


@dataclass(frozen=True)
class Draws:
    """Options: how often values are drawn from their spreads."""

    samples: Annotated[
        int, typer.Option("--samples", metavar="N", min=1, help="Number of base samples, a power of two.")
    ] = 1024
    runs: Annotated[
        int, typer.Option("--runs", metavar="N", min=16, help="Number of simulated draws, a power of two.")
    ] = 256
    no_simulation: Annotated[bool, typer.Option("--no-simulation", help="Use closed forms alone.")] = False
    seed: Seed = 1

    @property
    def runs_wanted(self) -> int:
        """How many draws are simulated."""
        return 0 if self.no_simulation else self.runs


@app.callback()
def design() -> None:
    """Design a rotary valve: optimum, trade-offs, tolerances.

    `vvdp design SYSTEM` is short for `vvdp design optimum SYSTEM`.
    """


@app.command(cls=Verb)
@flat("results/design-SYSTEM-DATE-TIME")
def optimum(
    *,
    case: RigCase,
    minimise: Annotated[
        str, typer.Option("--minimise", metavar="QUANTITY", help="Quantity to minimise, for example loss_total.")
    ] = "loss_total",
    limits: Constraints,
    search: Search,
    output: Output,
) -> None:
    """Find the best valve and write it as a new system.

    Spool radius, nozzle area, outlet area and radial clearance are varied, and any variable that a --bound names.
    """
    from vvdp.base.files import write_whole
    from vvdp.cli.screen import tell
    from vvdp.design.problem import with_usual_limits
    from vvdp.design.proof import optimum_text

    loaded = case.on_rig("design optimum")
    asked = limits.problem(loaded, minimise)
    if not search.no_usual_limits:
        asked = with_usual_limits(asked)

    def work(folder: Path) -> "Result":
        found, result = _optimum(asked, search.starts, search.seed, simulated=not search.no_simulation)
        write_whole(folder / SYSTEM, optimum_text(found))
        return result

    directory = _run(loaded, "design", work, output)
    if not output.json:
        tell(f"system: {directory / SYSTEM}   run it with: vvdp run {directory / SYSTEM}")


SYSTEM = "optimum.toml"


def _optimum(asked: "Problem", starts: int, seed: int, *, simulated: bool) -> "tuple[Optimum, Result]":
    """The optimum, its simulations and its course over its limits, as far as Ctrl-C lets them come."""
    from vvdp.cli.progress import count_lines
    from vvdp.cli.screen import say
    from vvdp.design.optimise import optimise
    from vvdp.design.optimum_result import doubt_findings, optimum_result
    from vvdp.design.proof import doubts, proofs, simulation_doubts
    from vvdp.design.sensitivity import limit_curves, movable

    with count_lines("starts") as progress:
        found = optimise(asked, starts=starts, seed=seed, progress=progress)
    doubted = doubts(asked, found.values)
    proven: list[Proof] = []
    finished = found.finished
    if finished and simulated:
        with count_lines("simulations") as progress:
            proven = proofs(asked, found.values, progress=progress, say=say)
        finished = len(proven) == 2 * len(asked.points)
    curves: list[LimitCurve] = []
    if finished:
        with count_lines("optima with a limit moved") as progress:
            curves = limit_curves(found, progress=progress)
        finished = len(curves) == len(movable(found))
    told = doubt_findings(simulation_doubts(found, proven), doubted)
    return found, optimum_result(found, proven, told, curves, finished=finished)


@app.command(cls=Verb)
@flat("results/pareto-SYSTEM-DATE-TIME")
def pareto(
    *,
    case: RigCase,
    objectives: Objectives,
    limits: Constraints,
    search: FrontSearch,
    output: Output,
) -> None:
    """Compute the Pareto front.

    By default loss, ripple and size are minimised and the PWM frequency is maximised. Each design is a system file.
    """
    from vvdp.cli.progress import count_lines
    from vvdp.cli.screen import say
    from vvdp.design import pareto as study
    from vvdp.design.pareto_result import front_result, write_designs
    from vvdp.design.problem import with_usual_limits
    from vvdp.design.proof import simulated_designs

    wanted = study.objectives(objectives.minimise or (), objectives.maximise or ())
    loaded = case.on_rig("design pareto")
    beside = [each.quantity for each in wanted]
    asked = limits.problem(loaded, wanted[0].quantity, beside)
    if not search.no_usual_limits:
        asked = with_usual_limits(asked, front=True)

    def work(folder: Path) -> "Result":
        with count_lines("generations and designs") as progress:
            found = study.front(
                asked,
                wanted,
                points=search.points,
                generations=search.generations,
                seed=search.seed,
                progress=progress,
            )
        finished = found.finished
        if finished and not search.no_simulation:
            say(f"simulating {len(found.values)} designs")
            try:
                found = replace(found, simulated=simulated_designs(asked, [{}, *found.values], say=say))
            except KeyboardInterrupt:
                finished = False
        write_designs(folder, found)
        return front_result(found, finished=finished)

    _run(loaded, "pareto", work, output, shows=("front",))


@app.command(cls=Verb)
@flat("results/tolerance-SYSTEM-DATE-TIME")
def tolerance(
    *,
    case: RigCase,
    spread: Annotated[
        list[str] | None,
        typer.Option(
            "--spread",
            metavar="STATEMENT",
            help='Spread of an input, for example "radial_clearance: 10 um to 16 um" (repeatable).',
        ),
    ] = None,
    draws: Draws,
    output: Output,
) -> None:
    """Show how results scatter with tolerances and assumed values.

    The scatter of drop, PWM frequency, efficiency and peak pressure is split into the shares of the inputs: valve and
    oil parameters, and every value that has a range in the system file.
    """
    from vvdp.base.files import write_whole
    from vvdp.design import tolerance as study
    from vvdp.design.spreads import spreads
    from vvdp.design.tolerance_result import draws as drawn
    from vvdp.design.tolerance_result import tolerance_result
    from vvdp.results.store import table_text

    loaded = case.on_rig("design tolerance")
    taken = spreads(loaded, spread or ())

    def work(folder: Path) -> "Result":
        found = study.tolerance(loaded, taken, samples=draws.samples, runs=draws.runs_wanted, seed=draws.seed)
        write_whole(folder / "draws.csv", table_text(drawn(found)))
        return tolerance_result(found)

    _run(loaded, "tolerance", work, output)


@app.command(cls=Verb)
@flat("results/temperature-SYSTEM-DATE-TIME")
def temperature(
    *,
    case: RigCase,
    coldest: Annotated[str, typer.Option("--from", metavar="TEMP", help="Coldest oil temperature.")] = "10 degC",
    hottest: Annotated[str, typer.Option("--to", metavar="TEMP", help="Hottest oil temperature.")] = "80 degC",
    output: Output,
) -> None:
    """Show the valve from cold to hot oil."""
    from vvdp.base.kinds import TEMPERATURE
    from vvdp.cli.progress import count_lines
    from vvdp.design import temperature as study
    from vvdp.design.temperature_result import temperature_result

    loaded = case.on_rig("design temperature")
    low, high = parsed_option("--from", coldest, TEMPERATURE), parsed_option("--to", hottest, TEMPERATURE)

    def work(_: Path) -> "Result":
        with count_lines("temperatures") as progress:
            return temperature_result(study.over_temperature(loaded, coldest=low, hottest=high, progress=progress))

    _run(loaded, "temperature", work, output, shows=("temperature", "checks"))


@app.command(cls=Verb)
@flat("results/levers-SYSTEM-DATE-TIME")
def levers(
    *,
    case: RigCase,
    no_simulation: Annotated[bool, typer.Option("--no-simulation", help="Use closed forms alone.")] = False,
    output: Output,
) -> None:
    """Compare what lowers the transition loss, in watts.

    Size, underlap, a relief setting that follows the load, other areas, a driven spool and soft switching, each at its
    best and simulated.
    """
    from vvdp.cli.progress import count_lines
    from vvdp.cli.screen import say
    from vvdp.design import levers as study
    from vvdp.design.levers_result import levers_result

    loaded = case.on_rig("design levers")

    def work(_: Path) -> "Result":
        with count_lines("levers") as progress:
            found = study.levers(loaded, simulated=not no_simulation, progress=progress, say=say)
        return levers_result(loaded, found)

    _run(loaded, "levers", work, output, shows=("levers",))


app.command(cls=Verb)(robust)


def _run(
    system: "System",
    name: str,
    work: "Callable[[Path], Result]",
    output: Output,
    shows: Sequence[str] | None = None,
) -> Path:
    """Has `work` done in a new result directory, writes and shows what comes of it, and gives the directory."""
    from vvdp.base.files import result_directory
    from vvdp.cli.screen import say
    from vvdp.systems.resolved import resolved_text

    directory = output.directory(f"{name}-{system.name}")
    with result_directory(directory, force=output.force) as folder:
        result = work(folder)
        reported = write_with_report(folder, result, resolved_text(system), no_report=output.no_report)
    show_result(result, directory, json=output.json, reported=reported, names=shows)
    if not result.finished:
        say("interrupted; what was found until then is written")
        raise typer.Exit(INTERRUPTED)
    return directory
