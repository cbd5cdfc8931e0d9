"""`vvdp run`."""

import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from vvdp.cli.options import AsJson, Force, Settings, SystemName, default_directory, out_option

if TYPE_CHECKING:
    from rich.table import Table

    from vvdp.simulation.run import Run
    from vvdp.systems.accuracy import Move
    from vvdp.systems.extras import Line
    from vvdp.systems.system import System

ROUNDING = 1e-9
"""What is taken into store counts as nothing below this share of the largest power."""
MOST_MOVED = 5
"""Numbers that `--check` prints."""
NOT_TRUSTED = 3
INTERRUPTED = 130


def run(
    system: SystemName,
    settings: Settings = None,
    until: Annotated[
        str | None, typer.Option("--until", metavar="TIME", help='Simulated time, for example "2 s".')
    ] = None,
    out: Annotated[
        Path | None,
        out_option("Where to write; by default results/SYSTEM-DATE-TIME."),
    ] = None,
    force: Force = False,
    json: AsJson = False,
    no_report: Annotated[bool, typer.Option("--no-report", help="Write no report.")] = False,
    check: Annotated[
        bool, typer.Option("--check", help="Run again at a tenth of the tolerance, and say what moves.")
    ] = False,
) -> None:
    """Simulate a system; write its results and a report.

    Ctrl-C ends the simulation early and keeps what was reached.
    """
    from vvdp.base.files import result_directory
    from vvdp.cli.progress import reached
    from vvdp.cli.report import RUN, add_report
    from vvdp.cli.screen import plain, print_json, say
    from vvdp.simulation.results import write_results
    from vvdp.simulation.run import simulate
    from vvdp.systems.resolved import resolved_text
    from vvdp.systems.summary import summary
    from vvdp.systems.system import load_system

    loaded = load_system(system, settings or (), until)
    directory = out if out is not None else default_directory(loaded.name)
    with result_directory(directory, force=force) as folder:
        end = loaded.stepping.until
        with reached(end, lambda now: f"t = {now:.4g} s of {end:.4g} s") as progress:
            done = simulate(loaded.model, loaded.case, loaded.stepping, progress=progress, say=say)
        if not done.end > 0.0:
            raise KeyboardInterrupt  # nothing to keep
        if not done.finished:
            say(f"interrupted at t = {done.end:.6g} s; writing what was reached")
        found = summary(loaded, done)
        more = _origin(loaded, found, settings or [])
        changes = _checked(loaded, found, say) if check and done.finished else ()
        if changes:
            more["check"] = {move.key: move.change for move in changes}
        _copy_module(loaded, folder)
        write_results(folder, done, system=resolved_text(loaded), summary=plain(found), more=plain(more))
        reported = not no_report and add_report(RUN, folder)
    if json:
        told = {"check": more["check"]} if changes else {}
        print_json({"system": loaded.name, **found, **told, "out": str(directory)})
    else:
        _print(loaded, done, found)
        _print_check(changes)
        typer.echo(f"results: {directory}")
    if reported and not json:
        typer.echo(f"report: {directory / 'report.html'}")
    if not found.get("trusted", True):
        say("not trusted: the books of this run do not balance; see energy_residual and mass_residual")
    if not done.finished:
        raise typer.Exit(INTERRUPTED)
    if not found.get("trusted", True):
        raise typer.Exit(NOT_TRUSTED)


def _checked(system: "System", found: dict[str, Any], say: Any) -> "tuple[Move, ...]":
    """How the numbers of a run change at a tenth of its tolerance."""
    from dataclasses import replace

    from vvdp.cli.progress import reached
    from vvdp.simulation.run import simulate
    from vvdp.systems.accuracy import FINER, moves
    from vvdp.systems.summary import summary

    stepping = replace(system.stepping, relative_tolerance=max(1e-13, FINER * system.stepping.relative_tolerance))
    end = stepping.until
    with reached(end, lambda now: f"check: t = {now:.4g} s of {end:.4g} s") as progress:
        done = simulate(system.model, system.case, stepping, progress=progress, say=say)
    if not done.finished:
        say("the check was interrupted; what it would say is left out")
        return ()
    return moves(found, summary(system, done))


def _print_check(changes: "tuple[Move, ...]") -> None:
    """The numbers that move most."""
    from vvdp.cli.screen import console, grid

    if not changes:
        return
    table = grid("at a tenth of the tolerance", "moves by", right=("moves by",))
    for move in changes[:MOST_MOVED]:
        table.add_row(move.key, f"{move.change:.1e}")
    console().print(table)


def _copy_module(system: "System", folder: Path) -> None:
    """Puts a module that lies beside the system file into the results as well, which can then be read alone."""
    if system.module is not None:
        name = str(system.content["circuit"]).partition(":")[0]
        copy = folder / f"{name.replace('.', '/')}.py"
        copy.parent.mkdir(parents=True, exist_ok=True)
        copy.write_bytes(system.module.read_bytes())


def _origin(system: "System", found: dict[str, Any], settings: list[str]) -> dict[str, Any]:
    """What meta.json says of a run besides what the simulation knows."""
    return {
        "system": system.name,
        "title": system.title,
        "circuit": system.circuit_name,
        "settings": settings,
        "assumed_values": len(system.assumed),
        "written": time.strftime("%Y-%m-%dT%H:%M:%S%z"),
        **{key: found[key] for key in ("energy_residual", "mass_residual", "trusted") if key in found},
    }


def _print(system: "System", done: "Run", found: dict[str, Any]) -> None:
    from vvdp.cli.screen import console, warn
    from vvdp.simulation.balance import LIMIT
    from vvdp.systems.overview import period, warnings

    out = console()
    out.print(system.title, soft_wrap=True)
    begin, end, periods = found["averaged_from_s"], found["averaged_to_s"], found["averaged_periods"]
    over = f"{periods:g} {period(system)}s, " if periods else ""
    out.print(f"means over {over}{begin:.4g} s to {end:.4g} s; pressures gauge")
    for table in _tables(system, found):
        out.print(table)
    if "trusted" in found:
        out.print(
            f"balances: energy {found['energy_residual']:.1e}, oil {found['mass_residual']:.1e} of the throughput "
            f"(limit {LIMIT:.0e})"
        )
    out.print(f"{done.steps} steps in {done.seconds:.2f} s; {len(system.assumed)} values of the system are assumed")
    for text in done.remarks:
        out.print(f"remark: {text}", soft_wrap=True)
    for text in warnings(system, found):
        warn(text)


def _tables(system: "System", found: dict[str, Any]) -> Iterator["Table"]:
    """The overview that the system brings along; else nodes and components."""
    if system.extras is not None and system.extras.OVERVIEW:
        yield _overview(system.extras.OVERVIEW, found)
        return
    yield _nodes(system, found)
    yield _components(system, found)


def _overview(lines: "Sequence[Line]", found: dict[str, Any]) -> "Table":
    from vvdp.cli.screen import amount, grid

    table = grid("quantity", "simulated", "closed form", "unit", right=("simulated", "closed form"))
    for line in lines:
        cells = [
            amount(sum(found[key] for key in keys), line.unit) if keys and found.keys() >= set(keys) else ""
            for keys in (line.keys, line.closed_form)
        ]
        if any(cells):
            table.add_row(line.label, *cells, line.unit)
    return table


def _nodes(system: "System", found: dict[str, Any]) -> "Table":
    from vvdp.cli.screen import amount, grid
    from vvdp.systems.overview import node_lines

    table = grid("node", "quantity", "mean", "lowest", "highest", "unit", right=("mean", "lowest", "highest"))
    for line in node_lines(system, found):
        values = ("" if value is None else amount(value, line.unit) for value in (line.mean, line.low, line.high))
        table.add_row(line.name, line.quantity, *values, line.unit)
    return table


def _components(system: "System", found: dict[str, Any]) -> "Table":
    """Mean flows, losses and powers from outside."""
    from vvdp.cli.screen import amount, grid
    from vvdp.systems.overview import flow_lines, loss_lines, power_lines

    table = grid("component or node", "quantity", "mean", "unit", right=("mean",))
    for line in flow_lines(system, found):
        quantity = f"flow into {line.port}" if line.port else "flow"
        table.add_row(line.component, quantity, amount(line.flow, "lpm"), "lpm")
    for loss in loss_lines(system, found):
        table.add_row(loss.component, "loss", amount(loss.loss, "W"), "W")
        for name, power in loss.parts:
            table.add_row("", f"of it, {name.replace('_', ' ')}", amount(power, "W"), "W")
    powers = dict(power_lines(system, found))
    for name, power in powers.items():
        table.add_row(name, "power given", amount(power, "W"), "W")
    if "stored_power_W" in found:
        stored = found["stored_power_W"]
        nothing = abs(stored) < ROUNDING * max(map(abs, powers.values()), default=0.0)
        table.add_row("", "taken into store", amount(0.0 if nothing else stored, "W"), "W")
    return table
