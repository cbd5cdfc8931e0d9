"""The console entry: all verbs, and the one place where errors become messages and exit codes."""

import gc
import io
import sys
from typing import Annotated, Any

import typer
from typer.core import TyperGroup

from vvdp.base.errors import ConfigError, NetworkError, ParameterError, VvdpError
from vvdp.cli import (
    check,
    compare,
    design,
    docs,
    estimate,
    geometry,
    listing,
    new,
    report,
    rig,
    run,
    show,
    study,
    valve,
)
from vvdp.cli import map as maps
from vvdp.cli.options import Verb

BAD_INPUT = 2
FAILED = 1
INTERRUPTED = 130
COLLECT_AFTER = 50_000
"""New objects between two searches for garbage. While libraries load, nearly all are kept: a tenth of a short run."""

ORDER = ("run", "valve", "map", "rig", "study", "design", "compare", "estimate", "geometry")
"""Verbs that compute, in the order of their use; the others follow."""


class _InOrder(TyperGroup):
    """The verbs, those that compute before those that list and write files; Typer puts groups last."""

    def list_commands(self, ctx: Any) -> list[str]:
        """Names of all verbs, in order."""
        names = super().list_commands(ctx)
        return sorted(names, key=lambda name: ORDER.index(name) if name in ORDER else len(ORDER) + names.index(name))


app = typer.Typer(
    cls=_InOrder,
    help="Simulate and evaluate virtually variable displacement pumps and other digital hydraulics.",
    epilog="Exit codes: 0 success, 1 failure, 2 bad input, 3 balances do not close, 130 interrupted.",
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode=None,  # rich would triple the time of --help
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)
app.command("run", cls=Verb)(run.run)
app.command("valve", cls=Verb)(valve.valve)
app.command("map", cls=Verb)(maps.map)
app.add_typer(rig.app, name="rig")
app.command("study", cls=Verb)(study.study)
app.add_typer(design.app, name="design")
app.add_typer(compare.app, name="compare")
app.command("estimate", cls=Verb)(estimate.estimate)
app.command("geometry", cls=Verb)(geometry.geometry)
app.command("show", cls=Verb)(show.show)
app.command("list", cls=Verb)(listing.systems)
app.command("new", cls=Verb)(new.new)
app.command("report", cls=Verb)(report.report)
app.command("check", cls=Verb)(check.check)
app.command("docs", cls=Verb)(docs.docs)


def _version(wanted: bool) -> None:
    if wanted:
        import vvdp

        typer.echo(f"vvdp {vvdp.__version__}")
        raise typer.Exit


@app.callback()
def _common(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version and exit.")
    ] = False,
) -> None:
    pass


def main(arguments: list[str] | None = None) -> None:
    """Runs the verb in `arguments` (those of the process by default) and exits with its code."""
    gc.set_threshold(COLLECT_AFTER)
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):  # a file's name may hold bytes that are no text
            stream.reconfigure(errors="backslashreplace")
    try:
        app(arguments, prog_name="vvdp")
    except VvdpError as problem:
        typer.echo(str(problem), err=True)
        sys.exit(BAD_INPUT if isinstance(problem, ConfigError | NetworkError | ParameterError) else FAILED)
    except KeyboardInterrupt:
        sys.exit(INTERRUPTED)
    except OSError as problem:
        typer.echo(f"vvdp: {problem}", err=True)
        sys.exit(FAILED)
