"""`vvdp map`."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Annotated

import typer

from vvdp.cli.engines import HERE, Resumable
from vvdp.cli.options import RigCase, flat
from vvdp.cli.printing import show_result, write_with_report

if TYPE_CHECKING:
    from vvdp.base.errors import Fault
    from vvdp.base.kinds import Kind
    from vvdp.rigs.map_axes import Axes
    from vvdp.steady.test_stand import Stand

POINT_SECONDS = 0.15
"""Usual time of a simulated point on one core [s]: 21 points of the prototype take 3 s."""
INTERRUPTED = 130
NOT_TRUSTED = 3

Span = Annotated[
    tuple[str, str, int] | None,
    typer.Option("--duty", metavar="FROM TO COUNT", help="Duty ratios (default: 12 up to 1)."),
]
Levels = Annotated[
    tuple[str, str, int] | None,
    typer.Option(
        "--pressure",
        metavar="FROM TO COUNT",
        help='Load pressures, for example "10 bar" "110 bar" 10 (default: 10 up to 95 % of the relief setting).',
    ),
]
Speeds = Annotated[
    list[str] | None,
    typer.Option("--speed", metavar="SPEED", help='Pump speed, for example "1500 rpm" (repeatable).'),
]
Temperatures = Annotated[
    list[str] | None,
    typer.Option("--temperature", metavar="TEMP", help='Oil temperature, for example "40 degC" (repeatable).'),
]


@dataclass(frozen=True)
class Spans:
    """Options: the operating points of a map, along each axis."""

    duty: Span = None
    pressure: Levels = None
    speed: Speeds = None
    temperature: Temperatures = None


@flat("results/map-SYSTEM")
def map(  # noqa: A001 - the name of the verb
    *,
    case: RigCase,
    analytic: Annotated[
        bool, typer.Option("--analytic", help="Compute quasi-steady averages at once instead of simulating.")
    ] = False,
    spans: Spans,
    work: Resumable,
) -> None:
    """Map flow and efficiencies over duty ratio and load.

    Every point is simulated to its periodic steady state. Finished points are kept; rerun the same command to resume.
    Pump speed and oil temperature can be further axes.
    """
    from vvdp.base.errors import unusable
    from vvdp.cli.progress import count_lines
    from vvdp.cli.screen import say
    from vvdp.rigs.map_result import map_result
    from vvdp.rigs.maps import NOT_RUN, analytic_map, map_directory, simulated_map
    from vvdp.steady.test_stand import stand
    from vvdp.systems.resolved import resolved_text

    loaded = case.on_rig("map")
    held = stand(loaded, "map")
    axes = chosen_axes(held, spans)
    directory = work.directory(f"{'analytic-' if analytic else ''}map-{loaded.name}")
    engine = work.engine(directory)
    if analytic and work.on != HERE:
        raise unusable("--on", f"{work.on!r}; an analytic map is calculated at once, here")
    with map_directory(directory, simulated=not analytic, force=work.force):
        if analytic:
            found = analytic_map(held, axes, cores=work.cores, say=say)
        else:
            with count_lines("points", POINT_SECONDS / work.shared_cores) as progress:
                found = simulated_map(held, axes, directory, engine=engine, progress=progress, say=say)
        result = map_result(found)
        reported = write_with_report(directory, result, resolved_text(loaded), no_report=work.no_report)
    if not work.json:
        say(f"{found.ran} points run in {found.seconds:.2f} s")
    show_result(result, directory, json=work.json, reported=reported)
    if not found.is_finished:
        say(f"interrupted with {found.reasons.count(NOT_RUN)} points to go; rerun the same command to resume")
        raise typer.Exit(INTERRUPTED)
    if "untrusted_points" in result.numbers and result.numbers["untrusted_points"].value > 0.0:
        say("the balances of some points do not close; see the column trusted")
        raise typer.Exit(NOT_TRUSTED)


def chosen_axes(held: "Stand", spans: Spans, default: "Axes | None" = None) -> "Axes":
    """The axes that options ask for, the default ones where they do not. Raises ConfigError with all faults."""
    from vvdp.base.errors import ConfigError, Fault
    from vvdp.base.kinds import FRACTION, PRESSURE_LEVEL, SPEED, TEMPERATURE
    from vvdp.rigs.map_axes import default_axes

    faults: list[Fault] = []
    given = {
        "duty_ratios": _stretch("--duty", spans.duty, FRACTION, faults),
        "load_pressures": _stretch("--pressure", spans.pressure, PRESSURE_LEVEL, faults),
        "pump_speeds": tuple(sorted(set(_parse_axis("--speed", spans.speed or (), SPEED, faults)))),
        "temperatures": tuple(sorted(set(_parse_axis("--temperature", spans.temperature or (), TEMPERATURE, faults)))),
    }
    if faults:
        raise ConfigError(faults)
    return replace(default or default_axes(held), **{name: values for name, values in given.items() if values})


def _stretch(option: str, ends: tuple[str, str, int] | None, kind: "Kind", faults: list["Fault"]) -> tuple[float, ...]:
    """Evenly spaced values of an option; none where it is not given or at fault."""
    from vvdp.base.errors import Fault

    if ends is None:
        return ()
    if not 1 <= ends[2] <= 10_000:
        faults.append(Fault(option, 0, str(ends[2]), "expected 1 to 10000 values"))
        return ()
    found = _parse_axis(option, ends[:2], kind, faults)
    if len(found) < 2:
        return ()
    low, high = found
    if ends[2] == 1 or low == high:
        return (low,)
    if low > high:
        faults.append(Fault(option, 0, "", f"{ends[0]!r} to {ends[1]!r}; expected increasing values"))
        return ()
    step = (high - low) / (ends[2] - 1)
    return tuple(low + step * place for place in range(ends[2] - 1)) + (high,)


def _parse_axis(option: str, texts: Sequence[str], kind: "Kind", faults: list["Fault"]) -> list[float]:
    from vvdp.base.errors import Fault, ParameterError
    from vvdp.base.units import parse

    values = []
    for text in texts:
        try:
            values.append(parse(text, kind))
        except ParameterError as problem:
            faults.append(Fault(option, 0, "", str(problem)))
    return values
