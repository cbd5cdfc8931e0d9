"""The console entry: all verbs, and the one place where errors become messages and exit codes."""

import gc
import io
import sys
from typing import Annotated

import typer

from vvdp.base.errors import ConfigError, NetworkError, ParameterError, VvdpError
from vvdp.cli import check, compare, design, estimate, geometry, listing, new, report, rig, run, show, study, valve
from vvdp.cli import map as maps

BAD_INPUT = 2
FAILED = 1
INTERRUPTED = 130
COLLECT_AFTER = 50_000
"""New objects between two searches for garbage. While libraries load, nearly all are kept: a tenth of a short run."""

app = typer.Typer(
    help="Simulate and judge virtually variable displacement pumps and other digital hydraulics.",
    epilog="Exit codes: 0 fine, 1 failed, 2 bad input, 3 result not trusted, 130 interrupted.",
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode=None,  # rich would triple the time of --help
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)
app.command("run")(run.run)
app.command("valve")(valve.valve)
app.command("study")(study.study)
app.command("estimate")(estimate.estimate)
app.add_typer(compare.app, name="compare")
app.add_typer(design.app, name="design")
app.command("map")(maps.map)
app.add_typer(rig.app, name="rig")
app.command("geometry")(geometry.geometry)
app.command("list")(listing.systems)
app.command("show")(show.show)
app.command("new")(new.new)
app.command("report")(report.report)
app.command("check")(check.check)


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
