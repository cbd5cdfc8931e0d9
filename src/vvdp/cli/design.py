"""`vvdp design`: optimum, trade-offs, tolerances and oil temperature of a valve."""

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from typer.core import TyperGroup

from vvdp.cli.options import (
    AsJson,
    Force,
    NoReport,
    Seed,
    Settings,
    SystemName,
    Verb,
    default_directory,
    out_option,
    parsed_option,
)

if TYPE_CHECKING:
    from vvdp.design.optimise import Moved, Optimum
    from vvdp.design.pareto import Front
    from vvdp.design.problem import Limit
    from vvdp.design.proof import Proof
    from vvdp.design.temperature import OverTemperature
    from vvdp.design.tolerance import Tolerance
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
        from vvdp.systems.system import shipped

        return bool(suggestion(word, self.commands)) and word not in shipped() and not Path(word).exists()


app = typer.Typer(cls=_OptimumUnlessNamed, no_args_is_help=True, rich_markup_mode=None)

Bounds = Annotated[
    list[str] | None,
    typer.Option(
        "--bound",
        metavar="STATEMENT",
        help='Bound of a variable, for example "radial_clearance <= 22.5 um" (repeatable).',
    ),
]
Limits = Annotated[
    list[str] | None,
    typer.Option(
        "--subject-to", metavar="STATEMENT", help='Constraint, for example "pwm_frequency >= 72 Hz" (repeatable).'
    ),
]
Cycle = Annotated[
    Path | None,
    typer.Option("--cycle", metavar="FILE", help="Weighted operating points, a TOML file."),
]
NoUsualLimits = Annotated[
    bool,
    typer.Option("--no-usual-limits", help="Drop the default constraints."),
]


@app.callback()
def design() -> None:
    """Design a rotary valve: optimum, trade-offs, tolerances.

    `vvdp design SYSTEM` is short for `vvdp design optimum SYSTEM`.
    """


def _bench_system(verb: str, name: str, settings: list[str] | None) -> "System":
    """A system with settings. Raises ConfigError, which names `verb`, where it is no bench of a rotary valve."""
    from vvdp.systems.bench import rotary_bench
    from vvdp.systems.system import load_system

    loaded = load_system(name, settings or ())
    rotary_bench(loaded, f"design {verb}")
    return loaded


def _print_report(directory: Path, no_report: bool) -> None:
    if not no_report:
        typer.echo(f"report: {directory / 'report.html'}")


@app.command(cls=Verb)
def optimum(
    system: SystemName,
    minimise: Annotated[
        str, typer.Option("--minimise", metavar="QUANTITY", help="Quantity to minimise, for example loss_total.")
    ] = "loss_total",
    subject_to: Limits = None,
    bound: Bounds = None,
    cycle: Cycle = None,
    settings: Settings = None,
    starts: Annotated[int, typer.Option("--starts", metavar="N", min=1, help="Number of random starting points.")] = 20,
    seed: Seed = 1,
    no_simulation: Annotated[
        bool, typer.Option("--no-simulation", help="Do not simulate the original and the optimum.")
    ] = False,
    no_usual_limits: NoUsualLimits = False,
    out: Annotated[Path | None, out_option("results/design-SYSTEM-DATE-TIME")] = None,
    force: Force = False,
    json: AsJson = False,
    no_report: NoReport = False,
) -> None:
    """Find the best valve and write it as a new system.

    Spool radius, nozzle area, outlet area and radial clearance are varied, and any variable that a --bound names.
    """
    from vvdp.base.files import result_directory
    from vvdp.cli.progress import counted
    from vvdp.cli.screen import print_json, say
    from vvdp.design.optimise import movable, moved, optimised
    from vvdp.design.problem import problem, with_usual_limits
    from vvdp.design.proof import doubts, proofs, simulation_doubts
    from vvdp.design.results import SYSTEM, flat_results, write_design
    from vvdp.report.design_report import write_design_report

    loaded = _bench_system("optimum", system, settings)
    asked = problem(loaded, minimise, subject_to or (), bound or (), cycle)
    if not no_usual_limits:
        asked = with_usual_limits(asked)
    directory = out if out is not None else default_directory(f"design-{loaded.name}")
    with result_directory(directory, force=force) as folder:
        with counted("starts") as progress:
            found = optimised(asked, starts=starts, seed=seed, progress=progress)
        doubted = doubts(asked, found.values)
        proven: list[Proof] = []
        if found.finished and not no_simulation:
            with counted("simulations") as progress:
                proven = proofs(asked, found.values, progress=progress, say=say)
        interrupted = not found.finished or (not no_simulation and len(proven) < 2 * len(asked.points))
        curves: list[Moved] = []
        if not interrupted:
            with counted("optima with a limit moved") as progress:
                curves = moved(found, progress=progress)
            interrupted = len(curves) < len(movable(found))
        warnings = [*simulation_doubts(found, proven), *doubted]
        write_design(folder, found, proven, doubted, curves)
        if not no_report:
            write_design_report(folder)
    if json:
        simulated = {
            f"{p.design}_simulated_{key}": value for p in proven if p.point == 0 for key, value in p.found.items()
        }
        told = {"warnings": warnings, "out": str(directory)}
        print_json({"system": loaded.name, **flat_results(found), **simulated, **told})
    else:
        _print(found, proven, warnings)
        typer.echo(f"system: {directory / SYSTEM}   run it with: vvdp run {directory / SYSTEM}")
        _print_report(directory, no_report)
    if interrupted:
        say("interrupted; what was found until then is written")
        raise typer.Exit(INTERRUPTED)


@app.command(cls=Verb)
def pareto(
    system: SystemName,
    minimise: Annotated[
        list[str] | None, typer.Option("--minimise", metavar="QUANTITY", help="Quantity to minimise (repeatable).")
    ] = None,
    maximise: Annotated[
        list[str] | None, typer.Option("--maximise", metavar="QUANTITY", help="Quantity to maximise (repeatable).")
    ] = None,
    subject_to: Limits = None,
    bound: Bounds = None,
    cycle: Cycle = None,
    settings: Settings = None,
    points: Annotated[int, typer.Option("--points", metavar="N", min=8, help="Number of designs on the front.")] = 60,
    generations: Annotated[int, typer.Option("--generations", metavar="N", min=1, help="Number of generations.")] = 60,
    seed: Seed = 1,
    no_simulation: Annotated[bool, typer.Option("--no-simulation", help="Do not simulate the designs.")] = False,
    no_usual_limits: NoUsualLimits = False,
    out: Annotated[Path | None, out_option("results/pareto-SYSTEM-DATE-TIME")] = None,
    force: Force = False,
    json: AsJson = False,
    no_report: NoReport = False,
) -> None:
    """Compute the Pareto front.

    By default loss, ripple and size are minimised and the PWM frequency is maximised. Each design is a system file.
    """
    from vvdp.base.files import result_directory
    from vvdp.cli.progress import counted
    from vvdp.cli.screen import print_json, say
    from vvdp.design import pareto as study
    from vvdp.design.problem import problem, with_usual_limits
    from vvdp.design.proof import simulated_designs
    from vvdp.report.design_report import write_front_report

    wanted = study.objectives(minimise or (), maximise or ())
    loaded = _bench_system("pareto", system, settings)
    beside = [each.quantity for each in wanted]
    asked = problem(loaded, wanted[0].quantity, subject_to or (), bound or (), cycle, beside=beside)
    if not no_usual_limits:
        asked = with_usual_limits(asked, front=True)
    directory = out if out is not None else default_directory(f"pareto-{loaded.name}")
    with result_directory(directory, force=force) as folder:
        with counted("generations and designs") as progress:
            found = study.front(asked, wanted, points=points, generations=generations, seed=seed, progress=progress)
        finished = found.finished
        if finished and not no_simulation:
            say(f"simulating {len(found.values)} designs")
            try:
                found = replace(found, simulated=simulated_designs(asked, [{}, *found.values], say=say))
            except KeyboardInterrupt:
                finished = False
        study.write_front(folder, found)
        if not no_report:
            write_front_report(folder)
    if json:
        told = {"warnings": list(found.warnings), "out": str(directory)}
        print_json({"system": loaded.name, **study.flat_front(found), **told})
    else:
        _print_front(found)
        typer.echo(f"systems: {directory / 'systems'}")
        _print_report(directory, no_report)
    if not finished:
        say("interrupted; the designs found until then are written")
        raise typer.Exit(INTERRUPTED)


def _print_front(found: "Front") -> None:
    from vvdp.cli.screen import console, grid, tell, warn
    from vvdp.design.pareto import point_name
    from vvdp.design.problem import shown
    from vvdp.design.quantities import KINDS

    screen = console()
    tell(found.problem.system.title)
    if found.problem.limits:
        tell(f"subject to {', '.join(map(_limit, found.problem.limits))}")
    for told in found.warnings:
        warn(told)
    names = [each.quantity for each in found.objectives]
    labels = [
        f"{name.replace('_', ' ')} ({'large' if each.large else 'small'})"
        for name, each in zip(names, found.objectives, strict=True)
    ]
    simulated = ("loss total, simulated", "") if found.simulated else ()
    table = grid("system", *labels, *simulated, right=(*labels, *simulated))
    rows = [("as it was", found.before)]
    rows += [(f"{point_name(number)}.toml", row) for number, row in enumerate(found.quantities, 1)]
    for k, (name, row) in enumerate(rows):
        cells = [shown(row[each], KINDS[each], 4) for each in names]
        if found.simulated:
            each = found.simulated[k]
            loss = shown(each.loss_total, KINDS["loss_total"], 4) if each.loss_total == each.loss_total else "-"
            cells += [loss, "in doubt" if each.doubts else ""]
        table.add_row(name, *cells)
    screen.print(table)


def _limit(limit: "Limit") -> str:
    return f"{limit} (usual limit)" if limit.usual else str(limit)


@app.command(cls=Verb)
def tolerance(
    system: SystemName,
    spread: Annotated[
        list[str] | None,
        typer.Option(
            "--spread",
            metavar="STATEMENT",
            help='Spread of an input, for example "radial_clearance: 10 um to 16 um" (repeatable).',
        ),
    ] = None,
    samples: Annotated[
        int, typer.Option("--samples", metavar="N", min=1, help="Number of base samples, a power of two.")
    ] = 1024,
    seed: Seed = 1,
    settings: Settings = None,
    out: Annotated[Path | None, out_option("results/tolerance-SYSTEM-DATE-TIME")] = None,
    force: Force = False,
    json: AsJson = False,
    no_report: NoReport = False,
) -> None:
    """Show how results scatter with tolerances.

    The scatter of drop, PWM frequency and efficiency is split into the shares of valve and oil parameters.
    """
    from vvdp.base.files import result_directory
    from vvdp.cli.screen import print_json
    from vvdp.design import tolerance as study
    from vvdp.design.results import write_columns, write_numbers
    from vvdp.report.design_report import TOLERANCE, write_tolerance_report

    loaded = _bench_system("tolerance", system, settings)
    taken = study.spreads(loaded, spread or ())
    directory = out if out is not None else default_directory(f"tolerance-{loaded.name}")
    with result_directory(directory, force=force) as folder:
        found = study.tolerance(loaded, taken, samples=samples, seed=seed)
        write_numbers(folder, TOLERANCE, study.tolerance_content(found))
        write_columns(folder / "draws.csv", study.columns(found))
        if not no_report:
            write_tolerance_report(folder)
    if json:
        print_json({"system": loaded.name, **study.flat_tolerance(found), "out": str(directory)})
        return
    _print_tolerance(found)
    _print_report(directory, no_report)


@app.command(cls=Verb)
def temperature(
    system: SystemName,
    coldest: Annotated[str, typer.Option("--from", metavar="TEMP", help="Coldest oil temperature.")] = "10 degC",
    hottest: Annotated[str, typer.Option("--to", metavar="TEMP", help="Hottest oil temperature.")] = "80 degC",
    settings: Settings = None,
    out: Annotated[Path | None, out_option("results/temperature-SYSTEM-DATE-TIME")] = None,
    force: Force = False,
    json: AsJson = False,
    no_report: NoReport = False,
) -> None:
    """Show the valve from cold to hot oil."""
    from vvdp.base.files import result_directory
    from vvdp.base.kinds import TEMPERATURE as KIND
    from vvdp.cli.progress import counted
    from vvdp.cli.screen import print_json
    from vvdp.design import temperature as study
    from vvdp.design.results import write_columns, write_numbers
    from vvdp.report.design_report import TEMPERATURE, write_temperature_report

    loaded = _bench_system("temperature", system, settings)
    low, high = parsed_option("--from", coldest, KIND), parsed_option("--to", hottest, KIND)
    directory = out if out is not None else default_directory(f"temperature-{loaded.name}")
    with result_directory(directory, force=force) as folder:
        with counted("temperatures") as progress:
            found = study.over_temperature(loaded, coldest=low, hottest=high, progress=progress)
        write_numbers(folder, TEMPERATURE, study.temperature_content(found))
        write_columns(folder / "temperature.csv", study.temperature_columns(found))
        if not no_report:
            write_temperature_report(folder)
    if json:
        columns = {name: column.tolist() for name, column in study.temperature_columns(found).items()}
        print_json({"system": loaded.name, **columns, "warnings": list(found.warnings), "out": str(directory)})
        return
    _print_temperature(found)
    _print_report(directory, no_report)


def _print_temperature(found: "OverTemperature") -> None:
    from vvdp.cli.screen import console, grid, tell, warn
    from vvdp.design.temperature import by_temperature

    screen = console()
    tell(found.system.title)
    columns = (
        "oil [degC]",
        "viscosity [mPa s]",
        "PWM open [Hz]",
        "PWM mean [Hz]",
        "loss [W]",
        "leakage [W]",
        "efficiency",
    )
    table = grid(*columns, right=columns)
    t, c = found.temperatures, found.columns
    for k in dict.fromkeys(by_temperature(found, [t[0] + 10.0 * i for i in range(int((t[-1] - t[0]) / 10.0) + 1)])):
        numbers = (
            t[k] - 273.15, 1e3 * c["viscosity"][k], c["pwm_frequency"][k], c["pwm_frequency_averaged"][k],
            c["loss_total"][k], c["loss_leakage"][k], c["efficiency"][k],
        )  # fmt: skip
        table.add_row(*(f"{x:.4g}" for x in numbers))
    screen.print(table)
    for text in found.warnings:
        warn(text)


def _print_tolerance(found: "Tolerance") -> None:
    from vvdp.cli.screen import console, grid, tell, warn
    from vvdp.design.problem import shown
    from vvdp.design.quantities import KINDS

    screen = console()
    tell(found.system.title)
    columns = ("nominal", "mean", "deviation", "2.5 %", "97.5 %")
    table = grid("output", *columns, right=columns)
    for name, each in found.scatter.items():
        values = (each.nominal, each.mean, each.deviation, each.percentiles["2.5"], each.percentiles["97.5"])
        table.add_row(name.replace("_", " "), *(shown(x, KINDS[name], 4) for x in values))
    screen.print(table)
    names = tuple(name.replace("_", " ") for name in found.scatter)
    table = grid("input", "from, to", "status", *names, title="Share of the variance, with all others", right=names)
    for taken in found.spreads:
        shares = (f"{100.0 * each.whole[taken.name]:.1f} %" for each in found.scatter.values())
        table.add_row(taken.words, str(taken), " ".join((taken.status, taken.source)).strip(), *shares)
    screen.print(table)
    for text in found.warnings:
        warn(text)


def _print(found: "Optimum", proven: "list[Proof]", warnings: list[str]) -> None:
    from vvdp.cli.screen import console, grid, tell, warn
    from vvdp.design.problem import shown
    from vvdp.design.proof import headline
    from vvdp.design.quantities import KINDS
    from vvdp.design.variables import value_in

    asked, screen = found.problem, console()
    tell(asked.system.title)
    demands = ", ".join(map(_limit, asked.limits)) or "nothing"
    where = f"; weighted mean over {len(asked.points)} operating points" if len(asked.points) > 1 else ""
    tell(f"least {asked.objective} subject to {demands}{where}")
    tell(headline(found, proven))
    for text in warnings:
        warn(text)
    table = grid("variable", "before", "optimum", "from", "to", right=("before", "optimum", "from", "to"))
    for b in asked.bounds:
        numbers = (value_in(asked.points[0].setup, b.variable.name), found.values[b.variable.name], b.low, b.high)
        table.add_row(b.variable.words, *(shown(x, b.variable.kind, 5) for x in numbers))
    screen.print(table)
    table = grid("result", "before", "optimum", right=("before", "optimum"))
    for name, kind in KINDS.items():
        pair = (float(asked.mean(quantities, name)) for quantities in (found.before, found.after))
        table.add_row(name.replace("_", " "), *(shown(x, kind, 5) for x in pair))
    screen.print(table)
    table = grid(
        "held by", "which is a", "1 % more changes the objective by", right=("1 % more changes the objective by",)
    )
    for each in found.holding:
        table.add_row(each.text, each.kind, f"{each.elasticity:+.3f} %" if each.elasticity == each.elasticity else "-")
    screen.print(table)
    search = f"{found.agreeing} of {found.starts} random starts ended here"
    if found.global_objective is not None:
        apart = 100.0 * (found.global_objective / found.objective - 1.0)
        search += f"; a global search of {found.global_evaluations} designs came within {apart:.2g} %"
    tell(search)
    _print_proof(proven)


def _print_proof(proven: "list[Proof]") -> None:
    from vvdp.cli.screen import console, grid

    if not proven:
        return
    columns = ("total loss, simulated [W]", "analytic [W]", "PWM, simulated [Hz]", "analytic [Hz]")
    table = grid("design", "point", *columns, right=("point", *columns))
    for each in proven:
        keys = ("loss_total_W", "analytic_loss_total_W", "pwm_frequency_Hz", "analytic_pwm_frequency_Hz")
        table.add_row(
            each.design, str(each.point + 1), *(f"{each.found[k]:.5g}" if k in each.found else "-" for k in keys)
        )
    console().print(table)
