"""`vvdp rig`."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from vvdp.cli.map import Span, Spans, Temperatures, chosen_axes
from vvdp.cli.options import (
    Cores,
    Output,
    OwnCycles,
    Restart,
    RigCase,
    Verb,
    flat,
)
from vvdp.cli.printing import show_result, write_with_report

if TYPE_CHECKING:
    from vvdp.results.result import Result
    from vvdp.steady.test_stand import Stand

INTERRUPTED = 130

app = typer.Typer(no_args_is_help=True, rich_markup_mode=None)

Steps = Annotated[
    tuple[float, float], typer.Option("--step", metavar="FROM TO", help="Duty ratios before and after the step.")
]


@dataclass(frozen=True)
class Work(Output):
    """Options: where a rig writes, what is shown, how many cores it takes."""

    cores: Cores = None


@dataclass(frozen=True)
class Resumed(Work):
    """The options of a rig that keeps what an earlier call has finished."""

    force: Restart = False


@app.callback()
def rig() -> None:
    """Run a virtual test based on an ISO standard."""


@app.command("pressure-drop", cls=Verb)
@flat("results/RIG-SYSTEM-DATE-TIME")
def pressure_drop(
    *,
    case: RigCase,
    temperature: Temperatures = None,
    work: Work,
) -> None:
    """Measure pressure drop against flow, based on ISO 4411.

    It is calculated at once, on one core whatever --cores says.
    """
    from vvdp.rigs.pressure_drop import pressure_drop as measured

    def measure(held: "Stand") -> "Result":
        chosen = chosen_axes(held, Spans(temperature=temperature)).temperatures
        return measured(held, temperatures=chosen)

    _run("pressure-drop", case, work, measure)


@app.command("derived-capacity", cls=Verb)
@flat("results/RIG-SYSTEM-DATE-TIME")
def derived_capacity(
    *,
    case: RigCase,
    duty: Span = None,
    work: Work,
) -> None:
    """Derive the capacity at each duty ratio, based on ISO 8426.

    It is the flow per angle, extrapolated to no pressure difference: what ISO efficiencies are measured against.
    """
    from vvdp.cli.screen import say
    from vvdp.rigs.derived_capacity import DUTY_RATIOS
    from vvdp.rigs.derived_capacity import derived_capacity as measured
    from vvdp.rigs.map_axes import default_axes

    def measure(held: "Stand") -> "Result":
        usual = replace(default_axes(held), duty_ratios=DUTY_RATIOS)
        chosen = chosen_axes(held, Spans(duty=duty), usual).duty_ratios
        return measured(held, chosen, cores=work.cores, say=say)

    _run("derived-capacity", case, work, measure)


@app.command(cls=Verb)
@flat("results/RIG-SYSTEM-DATE-TIME")
def ripple(
    *,
    case: RigCase,
    work: Work,
) -> None:
    """Measure pressure ripple, based on ISO 10767.

    The ripple is found over duty ratio, PWM frequency and accumulator.
    """
    from vvdp.cli.screen import say
    from vvdp.rigs.ripple import ripple as measured

    _run("ripple", case, work, lambda held: measured(held, cores=work.cores, say=say))


@app.command(cls=Verb)
@flat("results/RIG-SYSTEM-DATE-TIME")
def step(
    *,
    case: RigCase,
    between: Steps = (0.4, 0.6),
    work: Work,
) -> None:
    """Measure step and frequency response, based on ISO 17559.

    The response is that of the delivered flow to the duty ratio.
    """
    from vvdp.cli.screen import say
    from vvdp.rigs.step import dynamics

    def measure(held: "Stand") -> "Result":
        return dynamics(held, between, cores=work.cores, say=say)

    _run("step", case, work, measure)


@app.command(cls=Verb)
@flat("results/pump-SYSTEM")
def pump(
    *,
    case: RigCase,
    spans: Spans,
    between: Steps = (0.4, 0.6),
    work: Resumed,
) -> None:
    """Test it as a controlled pump, based on ISO 17559 and 4409.

    The test covers steady and dynamic behaviour. Finished points of the steady maps are kept; rerun the same command to
    resume.
    """
    from vvdp.cli.progress import count_lines
    from vvdp.cli.screen import say
    from vvdp.rigs.maps import map_directory
    from vvdp.rigs.pump import PumpTest, pump_axes
    from vvdp.rigs.pump import pump as measured
    from vvdp.steady.test_stand import stand
    from vvdp.systems.resolved import resolved_text

    loaded = case.on_rig("rig pump")
    held = stand(loaded, "rig pump")
    test = PumpTest(chosen_axes(held, spans, pump_axes(held)), between)
    directory = work.out if work.out is not None else Path("results", f"pump-{loaded.name}")
    with map_directory(directory, "rig pump", force=work.force):
        with count_lines("points") as progress:
            result = measured(held, directory, test, cores=work.cores, progress=progress, say=say)
        leave_out = work.no_report or not result.finished
        reported = write_with_report(directory, result, resolved_text(loaded), no_report=leave_out)
    show_result(result, directory, json=work.json, reported=reported)
    if not result.finished:
        say("interrupted; rerun the same command to resume")
        raise typer.Exit(INTERRUPTED)


@app.command(cls=Verb)
@flat("results/RIG-SYSTEM-DATE-TIME")
def claims(
    *,
    case: RigCase,
    own: OwnCycles = None,
    work: Work,
) -> None:
    """Check the published claims for the rotary valve.

    They compare it with throttling, load sensing, variable pumps and linear valves, self-spinning with driven, and
    judge its ripple.
    """
    from vvdp.cli.screen import say
    from vvdp.machines.duties import known_cylinder, read_duty
    from vvdp.rivals.claims import claims as worked_out

    moved = known_cylinder()
    duties = [read_duty(path, *moved) for path in own or ()]

    def measure(held: "Stand") -> "Result":
        return worked_out(held, duties, cores=work.cores, say=say)

    _run("claims", case, work, measure)


def _run(name: str, case: RigCase, work: Work, measure: Callable[["Stand"], "Result"]) -> None:
    """Puts a system on its stand, measures there, and writes and shows what comes of it."""
    from vvdp.base.files import result_directory
    from vvdp.cli.screen import say
    from vvdp.steady.test_stand import stand
    from vvdp.systems.resolved import resolved_text

    loaded = case.on_rig(f"rig {name}")
    held = stand(loaded, f"rig {name}")
    directory = work.directory(f"{name}-{loaded.name}")
    with result_directory(directory, force=work.force) as folder:
        try:
            result = measure(held)
        except KeyboardInterrupt:
            say("interrupted; a part of this has no meaning, nothing is written")
            raise
        reported = write_with_report(folder, result, resolved_text(loaded), no_report=work.no_report)
    names = (*result.listings, *(name for name in result.tables if name == "verdicts"))
    show_result(result, directory, json=work.json, reported=reported, names=names)
    if not result.finished:
        say("interrupted; what was finished is written")
        raise typer.Exit(INTERRUPTED)
