"""`vvdp observability`."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from vvdp.cli.options import (
    AsJson,
    Force,
    NoReport,
    Settings,
    SystemName,
    default_directory,
    out_option,
    parsed_option,
)
from vvdp.cli.printing import show_result, write_with_report

if TYPE_CHECKING:
    from vvdp.systems.system import System


def observability(
    system: SystemName,
    settings: Settings = None,
    speed: Annotated[
        str | None,
        typer.Option(
            "--speed", metavar="SPEED", help='Spool speed, for example "22.5 rev/s" (default: of the system).'
        ),
    ] = None,
    harmonics: Annotated[float, typer.Option("--harmonics", metavar="K", help="Harmonics of the noise.")] = 5,
    of: Annotated[str, typer.Option("--of", metavar="ROD", help="What moves along its axis, where several do.")] = "",
    out: Annotated[Path | None, out_option("results/observability-SYSTEM-DATE-TIME")] = None,
    force: Force = False,
    json: AsJson = False,
    no_report: NoReport = False,
) -> None:
    """Tell at which spool speeds the axial sensor can show the position.

    Its noise repeats itself with every turn. Where a harmonic of it has the natural frequency of what moves, the two
    cannot be told apart. The margin is worked out over spool speed for several numbers of harmonics, with the friction,
    and with the pressure of the chamber measured as well.
    """
    from vvdp.base.files import result_directory
    from vvdp.design.observability import observability as worked_out
    from vvdp.estimation.observability import check_noise
    from vvdp.systems.axial_plant import axial_plant
    from vvdp.systems.resolved import resolved_text
    from vvdp.systems.system import load_system

    loaded = load_system(system, settings or ())
    moved = axial_plant(loaded, of)
    omega = _speed(loaded, speed)
    check_noise(omega, harmonics)
    directory = out if out is not None else default_directory(f"observability-{loaded.name}")
    with result_directory(directory, force=force) as folder:
        result = worked_out(loaded.name, moved, omega, int(harmonics))
        reported = write_with_report(folder, result, resolved_text(loaded), no_report=no_report)
    show_result(result, directory, json=json, reported=reported, names=("lost", "windows"))


def _speed(system: "System", text: str | None) -> float:
    """The spool speed of the option, else that of the system [rad/s]. Raises ConfigError without one above zero."""
    from vvdp.base.errors import ConfigError, Fault
    from vvdp.base.kinds import SPEED
    from vvdp.systems.axial_plant import SPOOL, spool_speed

    found = spool_speed(system) if text is None else parsed_option("--speed", text, SPEED)
    if found is None:
        message = f"missing; the circuit has no driven shaft {SPOOL!r} whose speed is prescribed"
        raise ConfigError([Fault("--speed", 0, "", message)])
    if not found > 0.0:
        shown = repr(text) if text is not None else f"{found:g} rad/s at the start of {system.name}"
        raise ConfigError([Fault("--speed", 0, "", f"{shown}; expected a speed greater than zero")])
    return found
