"""The console entry: all verbs, and the one place where errors become messages and exit codes."""

import gc
import io
import os
import platform
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import cache
from types import FrameType
from typing import Annotated, Any

import typer
from typer.core import TyperGroup
from typer.main import get_command

from vvdp.base.errors import ConfigError, NetworkError, ParameterError, VvdpError
from vvdp.cli import (
    cfd,
    cfd_parts,
    check,
    compare,
    design,
    docs,
    estimate,
    export,
    fit,
    geometry,
    listing,
    new,
    observability,
    plot,
    report,
    reproduce,
    rig,
    run,
    show,
    study,
    valve,
    workbench,
)
from vvdp.cli import map as maps
from vvdp.cli.library import pages_for
from vvdp.cli.mistake import report_mistake
from vvdp.cli.options import LightVerb, Verb

BAD_INPUT = 2
FAILED = 1
MISTAKE = 70
"""A mistake of vvdp, as EX_SOFTWARE of sysexits.h."""
INTERRUPTED = 130
COLLECT_AFTER = 50_000
"""New objects between two searches for garbage. While libraries load, nearly all are kept: a tenth of a short run."""

ORDER = (
    "run",
    "valve",
    "map",
    "rig",
    "study",
    "design",
    "compare",
    "plot",
    "export",
    "estimate",
    "observability",
    "geometry",
    "cfd",
    "fit",
    "reproduce",
    "workbench",
)
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
    epilog="Exit codes: 0 success, 1 failure, 2 bad input, 3 not balanced, 70 mistake of vvdp, "
    "130 interrupted (by a signal 143, 129).",
    no_args_is_help=True,
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
app.command("plot", cls=Verb)(plot.plot)
app.add_typer(export.app, name="export")
app.command("estimate", cls=Verb)(estimate.estimate)
app.command("observability", cls=Verb)(observability.observability)
app.command("geometry", cls=Verb)(geometry.geometry)
cfd.app.command("sleeve", cls=Verb)(cfd_parts.sleeve)
cfd.app.command("valve", cls=Verb)(cfd_parts.valve)
cfd.app.command("period", cls=Verb)(cfd_parts.period)
app.add_typer(cfd.app, name="cfd")
app.command("fit", cls=Verb)(fit.fit)
app.command("reproduce", cls=Verb)(reproduce.reproduce)
app.command("show", cls=LightVerb)(show.show)
app.command("list", cls=LightVerb)(listing.systems)
app.command("new", cls=LightVerb)(new.new)
app.command("report", cls=Verb)(report.report)
app.command("check", cls=LightVerb)(check.check)
app.command("docs", cls=LightVerb)(docs.docs)
app.command("workbench", cls=Verb)(workbench.workbench)


def _version(wanted: bool) -> None:
    if wanted:
        from vvdp.base.version import VERSION

        typer.echo(f"vvdp {VERSION}")
        raise typer.Exit


@app.callback()
def _common(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version and exit.")
    ] = False,
) -> None:
    pass


@cache
def _verbs() -> Callable[..., Any]:
    """All verbs as the parser takes them. Typer would build them again, with all their options, at each call."""
    return get_command(app)


def main(arguments: list[str] | None = None) -> None:
    """Runs the verb in `arguments` (those of the process by default) and exits with its code."""
    gc.set_threshold(COLLECT_AFTER)
    vars(platform.uname())["processor"] = platform.machine()  # h5py asks for it, and Python would start `uname -p`
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):  # a file's name may hold bytes that are no text
            stream.reconfigure(errors="backslashreplace")
    with _ended_as_by_ctrl_c() as came:
        code = _run(arguments)
    sys.exit(128 + came[-1] if code == INTERRUPTED and came else code)


def _run(arguments: list[str] | None) -> int:
    """Runs a verb; its exit code. What went wrong is reported in lines that a user can act on."""
    try:
        _verbs()(arguments, prog_name="vvdp")
    except SystemExit as end:
        if end.__context__ is not None and isinstance(end.__context__.__cause__, KeyboardInterrupt):
            _tell("interrupted", INTERRUPTED)  # no verb has caught it
        return end.code if isinstance(end.code, int) else 0
    except ConfigError as problem:
        return _tell("\n".join(filter(None, [str(problem), pages_for(problem)])), BAD_INPUT)
    except (NetworkError, ParameterError) as problem:
        return _tell(str(problem), BAD_INPUT)
    except VvdpError as problem:
        return _tell(str(problem), FAILED)
    except KeyboardInterrupt:
        return _tell("interrupted", INTERRUPTED)
    except OSError as problem:
        return _tell(f"vvdp: {problem}", FAILED)
    except MemoryError as problem:
        return _tell(" ".join(f"vvdp: not enough memory. {problem}".split()), FAILED)
    except Exception as problem:
        return _tell(report_mistake(problem), MISTAKE)
    return 0


def _tell(line: str, code: int) -> int:
    with suppress(OSError):  # no one can be determined
        typer.echo(line, err=True)
    return code


@contextmanager
def _ended_as_by_ctrl_c() -> Iterator[list[int]]:
    """Within the block SIGTERM and SIGHUP do what Ctrl-C does at that moment; yields those that have come.

    What is ignored stays so (`nohup`). A terminal that has gone is written to no more: what was reached is kept, where
    an error of writing would lose it.
    """
    came: list[int] = []
    terminals = [number for number in (1, 2) if os.isatty(number)]

    def end(number: int, frame: FrameType | None) -> None:
        came.append(number)
        if number == signal.SIGHUP:
            for terminal in terminals:
                os.dup2(os.open(os.devnull, os.O_WRONLY), terminal)
        ctrl_c = signal.getsignal(signal.SIGINT)
        if not callable(ctrl_c):
            raise KeyboardInterrupt
        ctrl_c(number, frame)

    signals = [signal.SIGTERM, signal.SIGHUP] if threading.current_thread() is threading.main_thread() else []
    before = {number: signal.signal(number, end) for number in signals if signal.getsignal(number) is signal.SIG_DFL}
    try:
        yield came
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
