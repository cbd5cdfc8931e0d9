"""`vvdp reproduce`."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from vvdp.cli.options import AsJson, Force, NoReport, default_directory, out_option

if TYPE_CHECKING:
    from collections.abc import Iterable

    from vvdp.reproduction.item import Item

CHANGED, INTERRUPTED = 1, 130


def reproduce(
    items: Annotated[
        list[str] | None,
        typer.Argument(metavar="[ITEM]...", help="Such as 3.9 (a figure), section-3.5, chapter-3, or all."),
    ] = None,
    show: Annotated[bool, typer.Option("--list", help="List the items (default without an ITEM).")] = False,
    out: Annotated[Path | None, out_option("results/reproduce-DATE-TIME")] = None,
    force: Force = False,
    json: AsJson = False,
    no_report: NoReport = False,
) -> None:
    """Reproduce the source dissertation, item by item.

    Each figure, table, equation and claimed number stands beside what vvdp finds, with a verdict. Exit code 1 if a
    verdict is not the expected one. After Ctrl-C the same command with the same --out goes on where it stopped.
    """
    from vvdp.reproduction.items import ITEMS, chosen_items

    if show or not items:
        _list(ITEMS, json)
        return
    _work(chosen_items(items), out if out is not None else default_directory("reproduce"), force, json, no_report)


def _work(items: "tuple[Item, ...]", directory: Path, force: bool, json: bool, no_report: bool) -> None:
    """Works the items out, writes and shows them, and exits with what came of it."""
    import time

    from vvdp.base.display import long_time
    from vvdp.base.files import result_directory
    from vvdp.cli.printing import MOST_ROWS, print_result, write_with_report
    from vvdp.cli.screen import print_json, say, tell
    from vvdp.reproduction.expectation import VERDICTS, expected_verdicts, verdict_changes, verdicts_of
    from vvdp.reproduction.kept import stopped_items, take_over
    from vvdp.reproduction.result import json_rows, verdict_result
    from vvdp.reproduction.runner import all_statements, reproduce
    from vvdp.results.result import json_value

    began, outcomes = time.perf_counter(), []
    say(f"{len(items)} item{'s' if len(items) > 1 else ''}, about {long_time(usual_seconds(items))}")
    done = {} if force else stopped_items(directory, items)
    with result_directory(directory, force=force or bool(done)) as folder:
        take_over(directory, folder, tuple(done))
        try:
            for outcome in reproduce(items, folder, say, done):
                outcomes.append(outcome)
        except KeyboardInterrupt:
            if not outcomes:
                raise
        names = [each.item.name for each in outcomes]
        changes = verdict_changes(verdicts_of(all_statements(outcomes)), expected_verdicts(), names)
        missing = [each.name for each in items[len(outcomes) :]]
        result = verdict_result(outcomes, changes, time.perf_counter() - began, missing)
        reported = write_with_report(folder, result, "", no_report=no_report)
    if json:
        counts = {key: json_value(number) for key, number in result.numbers.items()}
        told = {"changed": changes, "finished": not missing, "missing": missing, "out": str(directory)}
        print_json({"items": json_rows(outcomes), **counts, **told})
    else:
        short = result.tables[VERDICTS].rows <= MOST_ROWS
        print_result(result, (VERDICTS,) if short else ("chapters",))
        tell(f"results: {directory}" + (f"\nreport: {directory / 'report.html'}" if reported else ""))
    if missing:
        raise typer.Exit(INTERRUPTED)
    if changes or any(each.failure for each in outcomes):
        raise typer.Exit(CHANGED)


def usual_seconds(items: "Iterable[Item]") -> float:
    """The time that items usually take [s], from processor times on one core; a second for one that was never timed."""
    from importlib import resources

    text = resources.files("vvdp.reproduction").joinpath("seconds.csv").read_text("utf-8")
    known = dict(line.split(",") for line in text.splitlines()[1:])
    return sum(float(known.get(each.name, 1.0)) for each in items)


def _list(items: "tuple[Item, ...]", json: bool) -> None:
    from vvdp.cli.screen import console, grid, print_json

    if json:
        rows = [{"item": each.name, "kind": each.kind.value, "title": each.title} for each in items]
        print_json({"items": rows})
        return
    shown = grid("item", "what it is", title="Items of the dissertation")
    for each in items:
        shown.add_row(each.name, each.title)
    console().print(shown)
