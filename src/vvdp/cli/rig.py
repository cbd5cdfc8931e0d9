"""`vvdp rig`."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from vvdp.cli.map import Levels, Span, Speeds, Temperatures, chosen_axes
from vvdp.cli.options import (
    AsJson,
    Cores,
    Force,
    NoReport,
    OwnCycles,
    Restart,
    Settings,
    SystemName,
    Verb,
    default_directory,
    out_option,
)
from vvdp.cli.printing import show_result, write_with_report

if TYPE_CHECKING:
    from vvdp.results.result import Result
    from vvdp.steady.test_stand import Stand

INTERRUPTED = 130

app = typer.Typer(no_args_is_help=True, rich_markup_mode=None)

Out = Annotated[Path | None, out_option("results/RIG-SYSTEM-DATE-TIME")]
Steps = Annotated[
    tuple[float, float], typer.Option("--step", metavar="FROM TO", help="Duty ratios before and after the step.")
]


@app.callback()
def rig() -> None:
    """Run a virtual test based on an ISO standard."""


@app.command("pressure-drop", cls=Verb)
def pressure_drop(
    system: SystemName,
    settings: Settings = None,
    temperature: Temperatures = None,
    out: Out = None,
    force: Force = False,
    cores: Cores = None,
    json: AsJson = False,
    no_report: NoReport = False,
) -> None:
    """Measure pressure drop against flow, based on ISO 4411.

    It is worked out at once, on one core whatever --cores says.
    """
    from vvdp.rigs.pressure_drop import pressure_drop as measured

    def work(held: "Stand") -> "Result":
        chosen = chosen_axes(held, None, None, None, temperature).temperatures
        return measured(held, temperatures=chosen)

    _run("pressure-drop", system, settings, work, out, force, json, no_report)


@app.command("derived-capacity", cls=Verb)
def derived_capacity(
    system: SystemName,
    settings: Settings = None,
    duty: Span = None,
    out: Out = None,
    force: Force = False,
    cores: Cores = None,
    json: AsJson = False,
    no_report: NoReport = False,
) -> None:
    """Derive the capacity at each duty ratio, based on ISO 8426.

    It is the flow per angle, extrapolated to no pressure difference: what ISO efficiencies are measured against.
    """
    from dataclasses import replace

    from vvdp.cli.screen import say
    from vvdp.rigs.derived_capacity import DUTY_RATIOS
    from vvdp.rigs.derived_capacity import derived_capacity as measured
    from vvdp.rigs.map_axes import default_axes

    def work(held: "Stand") -> "Result":
        usual = replace(default_axes(held), duty_ratios=DUTY_RATIOS)
        chosen = chosen_axes(held, duty, None, None, None, usual).duty_ratios
        return measured(held, chosen, cores=cores, say=say)

    _run("derived-capacity", system, settings, work, out, force, json, no_report)


@app.command(cls=Verb)
def ripple(
    system: SystemName,
    settings: Settings = None,
    out: Out = None,
    force: Force = False,
    cores: Cores = None,
    json: AsJson = False,
    no_report: NoReport = False,
) -> None:
    """Measure pressure ripple, based on ISO 10767.

    The ripple is found over duty ratio, PWM frequency and accumulator.
    """
    from vvdp.cli.screen import say
    from vvdp.rigs.ripple import ripple as measured

    _run("ripple", system, settings, lambda held: measured(held, cores=cores, say=say), out, force, json, no_report)


@app.command(cls=Verb)
def step(
    system: SystemName,
    settings: Settings = None,
    between: Steps = (0.4, 0.6),
    out: Out = None,
    force: Force = False,
    cores: Cores = None,
    json: AsJson = False,
    no_report: NoReport = False,
) -> None:
    """Measure step and frequency response, based on ISO 17559.

    The response is that of the delivered flow to the duty ratio.
    """
    from vvdp.cli.screen import say
    from vvdp.rigs.step import dynamics

    def work(held: "Stand") -> "Result":
        return dynamics(held, between, cores=cores, say=say)

    _run("step", system, settings, work, out, force, json, no_report)


@app.command(cls=Verb)
def pump(
    system: SystemName,
    settings: Settings = None,
    duty: Span = None,
    pressure: Levels = None,
    speed: Speeds = None,
    temperature: Temperatures = None,
    between: Steps = (0.4, 0.6),
    out: Annotated[Path | None, out_option("results/pump-SYSTEM")] = None,
    force: Restart = False,
    cores: Cores = None,
    json: AsJson = False,
    no_report: NoReport = False,
) -> None:
    """Test it as a controlled pump, based on ISO 17559 and 4409.

    The test covers steady and dynamic behaviour. Finished points of the steady maps are kept; rerun the same command to
    resume.
    """
    from vvdp.cli.progress import count_lines
    from vvdp.cli.screen import say
    from vvdp.rigs.maps import map_directory
    from vvdp.rigs.pump import pump as measured
    from vvdp.rigs.pump import pump_axes
    from vvdp.steady.test_stand import stand
    from vvdp.systems.resolved import resolved_text
    from vvdp.systems.system import load_system

    loaded = load_system(system, settings or ())
    held = stand(loaded, "rig pump")
    axes = chosen_axes(held, duty, pressure, speed, temperature, pump_axes(held))
    directory = out if out is not None else Path("results", f"pump-{loaded.name}")
    with map_directory(directory, "rig pump", force=force):
        with count_lines("points") as progress:
            result = measured(held, directory, axes, between, cores=cores, progress=progress, say=say)
        leave_out = no_report or not result.finished
        reported = write_with_report(directory, result, resolved_text(loaded), no_report=leave_out)
    show_result(result, directory, json=json, reported=reported)
    if not result.finished:
        say("interrupted; rerun the same command to resume")
        raise typer.Exit(INTERRUPTED)


@app.command(cls=Verb)
def claims(
    system: SystemName,
    settings: Settings = None,
    own: OwnCycles = None,
    out: Out = None,
    force: Force = False,
    cores: Cores = None,
    json: AsJson = False,
    no_report: NoReport = False,
) -> None:
    """Check the published claims for the rotary valve.

    They compare it with throttling, load sensing, variable pumps and linear valves, self-spinning with driven, and
    judge its ripple.
    """
    from vvdp.cli.screen import say
    from vvdp.rigs.claims import claims as worked_out
    from vvdp.systems.displacement.duties import known_cylinder, read_duty

    moved = known_cylinder()
    duties = [read_duty(path, *moved) for path in own or ()]

    def work(held: "Stand") -> "Result":
        return worked_out(held, duties, cores=cores, say=say)

    _run("claims", system, settings, work, out, force, json, no_report)


def _run(
    name: str,
    system: str,
    settings: list[str] | None,
    work: Callable[["Stand"], "Result"],
    out: Path | None,
    force: bool,
    json: bool,
    no_report: bool,
) -> None:
    """Puts a system on its stand, has `work` done there, and writes and shows what comes of it."""
    from vvdp.base.files import result_directory
    from vvdp.cli.screen import say
    from vvdp.steady.test_stand import stand
    from vvdp.systems.resolved import resolved_text
    from vvdp.systems.system import load_system

    loaded = load_system(system, settings or ())
    held = stand(loaded, f"rig {name}")
    directory = out if out is not None else default_directory(f"{name}-{loaded.name}")
    with result_directory(directory, force=force) as folder:
        try:
            result = work(held)
        except KeyboardInterrupt:
            say("interrupted; a part of this has no meaning, nothing is written")
            raise
        reported = write_with_report(folder, result, resolved_text(loaded), no_report=no_report)
    names = (*result.listings, *(name for name in result.tables if name == "verdicts"))
    show_result(result, directory, json=json, reported=reported, names=names)
    if not result.finished:
        say("interrupted; what was finished is written")
        raise typer.Exit(INTERRUPTED)
