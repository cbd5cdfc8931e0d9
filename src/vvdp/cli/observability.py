"""`vvdp observability`."""

from typing import Annotated

import typer

from vvdp.cli.options import (
    Case,
    Output,
    flat,
    parsed_option,
)
from vvdp.cli.printing import show_result, write_with_report

USUAL_HARMONICS = 5
"""Of the noise, where a system does not say: ten functions, as the source has them."""


@flat("results/observability-SYSTEM-DATE-TIME")
def observability(
    *,
    case: Case,
    speed: Annotated[
        str | None,
        typer.Option(
            "--speed", metavar="SPEED", help='Spool speed, for example "22.5 rev/s" (default: of the system).'
        ),
    ] = None,
    harmonics: Annotated[
        float | None,
        typer.Option("--harmonics", metavar="K", help="Harmonics of the noise (default: of the system, else 5)."),
    ] = None,
    of: Annotated[str, typer.Option("--of", metavar="ROD", help="What moves along its axis, where several do.")] = "",
    output: Output,
) -> None:
    """Show at which spool speeds the axial sensor can see.

    Its noise repeats itself with every turn. Where a harmonic of it has the natural frequency of what moves, the two
    cannot be distinguished. The margin is calculated over spool speed for several numbers of harmonics, with the
    friction, and with the pressure of the chamber measured as well.
    """
    from vvdp.base.files import result_directory
    from vvdp.design.observability import observability as worked_out
    from vvdp.estimation.observability import check_noise
    from vvdp.evaluation.axial_plant import axial_plant, axial_sight
    from vvdp.systems.resolved import resolved_text

    loaded = case.load()
    sight = axial_sight(loaded)
    moved = axial_plant(loaded, of)
    omega = _speed(loaded.name, speed, sight.spool_speed)
    count = harmonics if harmonics is not None else sight.harmonics or USUAL_HARMONICS
    check_noise(omega, count)
    directory = output.directory(f"observability-{loaded.name}")
    with result_directory(directory, force=output.force) as folder:
        result = worked_out(loaded.name, moved, omega, int(count))
        reported = write_with_report(folder, result, resolved_text(loaded), no_report=output.no_report)
    names = [name for name in ("lost", "windows") if result.tables[name].rows]
    show_result(result, directory, json=output.json, reported=reported, names=names)


def _speed(system: str, text: str | None, own: float | None) -> float:
    """The spool speed of the option, else a system's own [rad/s]. Raises ConfigError without one above zero."""
    from vvdp.base.display import value_text
    from vvdp.base.errors import ConfigError, Fault
    from vvdp.base.kinds import SPEED
    from vvdp.base.rules import POSITIVE

    found = own if text is None else parsed_option("--speed", text, SPEED)
    if found is None:
        message = f"missing; {system} has no axial sensor on a shaft whose speed is prescribed"
        raise ConfigError([Fault("--speed", 0, "", message)])
    if not found > 0.0:
        shown = repr(text) if text is not None else f"{value_text(found, SPEED)} at the start of {system}"
        raise ConfigError([Fault("--speed", 0, "", f"{shown} {POSITIVE}")])
    return found
