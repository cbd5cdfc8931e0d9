"""`vvdp run`."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from vvdp.cli.options import Case, Output, flat

if TYPE_CHECKING:
    from vvdp.evaluation.accuracy import Move
    from vvdp.runs.run import RecordedRun
    from vvdp.systems.system import System

MOST_CHANGES = 5
"""Numbers that `--check` prints."""
FAILED = 1
NOT_TRUSTED = 3
INTERRUPTED = 130


@dataclass(frozen=True)
class Ways:
    """Options: what is followed, and what is run besides."""

    check: Annotated[
        bool,
        typer.Option(
            "--check", help="Repeat the run at a tenth of the tolerance, pipes in twice the pieces, and show changes."
        ),
    ] = False
    cycle: Annotated[
        Path | None,
        typer.Option("--cycle", metavar="LOG", help="Follow a recorded cycle: any log with a channel `position`."),
    ] = None
    ranges: Annotated[
        bool | None,
        typer.Option(
            "--ranges/--no-ranges",
            help="Run again at both ends of each value that has a range, and show how far results move "
            "(default: where that takes about a second).",
            show_default=False,
        ),
    ] = None
    checked: Annotated[
        bool,
        typer.Option("--checked", help="Check indexes, divisions, assertions in compiled code (slower)."),
    ] = False
    live: Annotated[
        bool,
        typer.Option(
            "--live",
            help="Put the system into the report, so that its values can be changed there (needs the extra `web`).",
        ),
    ] = False
    trust: Annotated[
        list[Path] | None,
        typer.Option(
            "--trust",
            metavar="FILE.fmu",
            help="Run this foreign FMU in the process of vvdp, without the cost of a process of its own (repeatable).",
        ),
    ] = None
    watched: Annotated[
        bool,
        typer.Option("--watch", help="Run again whenever the file is saved; print what changed."),
    ] = False


@flat("results/SYSTEM-DATE-TIME")
def run(
    *,
    case: Case,
    until: Annotated[
        str | None, typer.Option("--until", metavar="TIME", help='Time to simulate, for example "2 s".')
    ] = None,
    output: Output,
    ways: Ways,
) -> None:
    """Simulate a system and write its results and a report.

    Ctrl-C stops the simulation early and keeps the results so far.
    """
    if ways.watched:
        from vvdp.cli.watch import refuse_together, watch
        from vvdp.systems.system import load_system

        refuse_together(
            out=output.out is not None,
            force=output.force,
            json=output.json,
            check=ways.check,
            cycle=ways.cycle is not None,
            live=ways.live,
        )
        watch(case.system, lambda: load_system(case.system, case.settings or (), until), lambda done: _print(done, ()))
        return
    from vvdp.cli.screen import run_command
    from vvdp.systems.system import load_system

    if ways.live:
        _refuse_beside_live(no_report=output.no_report, cycle=ways.cycle is not None)
    loaded = load_system(case.system, case.settings or (), until)
    if ways.cycle is not None:
        from vvdp.machines.recorded_cycle import with_cycle

        loaded = with_cycle(loaded, ways.cycle)
    if ways.trust:
        from vvdp.programs.foreign.partners import trust

        for path in ways.trust:
            trust(path)
    _simulate(loaded, output, ways, run_command(case.system, case.settings, until))


def _refuse_beside_live(**given: bool) -> None:
    """Raise an error where the extra is missing, or an option is given beside which no report can be interactive."""
    from vvdp.base.extras import require

    for name in (name for name, is_given in given.items() if is_given):
        raise typer.BadParameter(f"--live makes a report whose values can be set; leave out --{name.replace('_', '-')}")
    require("ziglang", "web", "an interactive report")


def _simulate(loaded: "System", output: Output, ways: Ways, command: str) -> None:
    """Runs a system, writes and shows what comes of it, and leaves with its code; `command` repeats the run."""
    from vvdp.base.files import result_directory
    from vvdp.cli.progress import report_reach
    from vvdp.cli.report import RUN, add_report, dressing
    from vvdp.cli.screen import print_json, say, typed_command
    from vvdp.runs.simulate import check_accuracy, json_summary, run_system, save_run

    end = loaded.stepping.until
    directory = output.directory(loaded.name)
    with result_directory(directory, force=output.force) as folder:
        with report_reach(end, lambda now: f"t = {now:.4g} s of {end:.4g} s") as reach:
            done = run_system(loaded, progress=reach.move, say=reach.say, command=typed_command(), checked=ways.checked)
        if not done.has("finished"):
            why = done.meta.get("failed") or f"interrupted at t = {done.number('duration_s'):.6g} s"
            say(f"{why}; writing what was reached")
        changes: tuple[Move, ...] = ()
        if ways.check and done.has("finished"):
            with report_reach(end, lambda now: f"check: t = {now:.4g} s of {end:.4g} s") as reach:
                changes = check_accuracy(done, reach.move)
        done = _with_ranges(done, ways.ranges)
        save_run(folder, done)
        dress = {"dress": dressing(command)} if ways.live else {}
        reported = not output.no_report and add_report(RUN, folder, done, **dress)
    if output.json:
        accuracy = {"check": {move.key: move.change for move in changes}} if changes else {}
        spans = {"ranges": done.meta["ranges"]} if "ranges" in done.meta else {}
        print_json({**json_summary(done), **accuracy, **spans, "out": str(directory)})
    else:
        _print(done, changes)
        typer.echo(f"results: {directory}" + (f"\nreport: {directory / 'report.html'}" if reported else ""))
    _exit(done)


def _with_ranges(run: "RecordedRun", wanted: bool | None) -> "RecordedRun":
    """The run with its ranges where they are `wanted` and there are any, or quickly made by default."""
    from vvdp.cli.screen import say
    from vvdp.runs.ranges import MOST_EVALUATIONS, expected_evaluations, run_ranges, with_ranges

    count, expected = len(run.system.uncertainties), expected_evaluations(run)
    if wanted is False or not count or not run.has("finished"):
        return run
    if wanted is None and expected > MOST_EVALUATIONS:
        say(f"{count} values have a range: --ranges shows how far the results move over them")
        return run
    if expected > MOST_EVALUATIONS:
        say(f"{2 * count} runs at the ends of {count} values")
    found = run_ranges(run, say=say)
    if found is None:
        say("interrupted; the ranges are left out")
        return run
    return with_ranges(run, found)


def _exit(run: "RecordedRun") -> None:
    """Leaves with the code of a run that was interrupted or that is not to be trusted."""
    from vvdp.cli.screen import say

    trusted = bool(run.summary.get("trusted", True))
    if not trusted:
        say("this run is not to be trusted: its warnings say why")
    if not run.has("finished"):
        raise typer.Exit(FAILED if run.meta.get("failed") else INTERRUPTED)
    if not trusted:
        raise typer.Exit(NOT_TRUSTED)


def _print(run: "RecordedRun", changes: "tuple[Move, ...]") -> None:
    from vvdp.cli.printing import listing_grid
    from vvdp.cli.screen import console, grid, tell, warn
    from vvdp.evaluation.bench_report import additions
    from vvdp.evaluation.overview import period, warnings
    from vvdp.runs.tables import screen_listings
    from vvdp.simulation.balance import LIMIT
    from vvdp.systems.assumed import assumed_words

    out, found = console(), run.summary
    tell(run.system.title)
    periods = f"{found['averaged_periods']:g} {period(run.system)}s, " if found["averaged_periods"] else ""
    begin, end = found["averaged_from_s"], found["averaged_to_s"]
    tell(f"means over {periods}{begin:.4g} s to {end:.4g} s; lowest and highest over the whole run; pressures gauge")
    for place, listing in enumerate(screen_listings(run)):
        if place == 0 and listing.title:
            tell("")
        out.print(listing_grid(listing))
    if (own := additions(run.system)) and own.OVERVIEW_NOTE:
        tell(f"{own.OVERVIEW_NOTE}\n")
    if "trusted" in found:
        energy, oil = found["energy_residual"], found["mass_residual"]
        tell(f"balances: energy {energy:.1e}, oil {oil:.1e} of the throughput (limit {LIMIT:.0e})")
    tell(f"{found['steps']:.0f} steps in {float(run.meta['seconds']):.2f} s; {assumed_words(run.system.assumptions)}")
    _print_ranges(run)
    for text in run.meta.get("remarks", ()):
        tell(f"note: {text}")
    if changes:
        table = grid("at a tenth of the tolerance", "change", right=("change",))
        for move in changes[:MOST_CHANGES]:
            table.add_row(move.key, f"{move.change:.1e}")
        out.print(table)
    for text in warnings(run.system, found):
        warn(text)


def _print_ranges(run: "RecordedRun") -> None:
    from vvdp.cli.printing import listing_grid
    from vvdp.cli.screen import console, tell
    from vvdp.evaluation.quantities import quantities
    from vvdp.evaluation.range_display import range_listing
    from vvdp.runs.ranges import kept_ranges

    ranges = kept_ranges(run)
    if ranges is not None and ranges.rows:
        listing = range_listing(ranges, quantities(run.system))
        tell("")
        console().print(listing_grid(listing))
        if listing.note:
            tell(listing.note)
