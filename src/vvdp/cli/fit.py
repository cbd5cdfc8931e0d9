"""`vvdp fit`."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import typer

from vvdp.cli.completion import system_names
from vvdp.cli.options import Output, Settings, flat

if TYPE_CHECKING:
    from vvdp.base.arrays import Array
    from vvdp.fitting.fitted import Fitted, Host
    from vvdp.fitting.orifice import Restriction
    from vvdp.fitting.table import Quantity
    from vvdp.systems.system import System

PARTS = ("centre", "nozzle", "outlet")
FITTED = "fitted.toml"
ORIFICE = "orifice"


class _Law(NamedTuple):
    """The columns that a law needs, and what fits it to them."""

    columns: "Mapping[str, Quantity]"
    fit: "Callable[[Mapping[str, Array], Any], Fitted]"


@dataclass(frozen=True)
class Law:
    """Options: the law that is fitted."""

    law: Annotated[str, typer.Option("--law", metavar="LAW", help="One of orifice, drop, jet, leakage.")] = ORIFICE
    part: Annotated[str, typer.Option("--part", metavar="PART", help="What drops: one of centre, nozzle, outlet.")] = (
        "centre"
    )
    area: Annotated[str, typer.Option("--area", metavar="AREA", help="Of the orifice; gives its C_d.")] = ""
    density: Annotated[
        str, typer.Option("--density", metavar="DENSITY", help="Of the oil that was measured; else the usual oil's.")
    ] = ""
    component: Annotated[
        str, typer.Option("--component", metavar="NAME", help="Component of the system that takes the values.")
    ] = ""


@flat("results/fit-LAW-DATE-TIME")
def fit(
    *,
    table: Annotated[Path, typer.Argument(metavar="TABLE", help="A CSV file with a heading such as `flow [lpm]`.")],
    fitted: Law,
    on: Annotated[
        str | None,
        typer.Option(
            "--on",
            metavar="SYSTEM",
            help="System that takes what was found, written to fitted.toml; the law of its valve is drawn beside.",
            autocompletion=system_names,
        ),
    ] = None,
    settings: Settings = None,
    output: Output,
) -> None:
    """Fit an orifice or a law of the valve to measured data.

    Columns: orifice needs flow and pressure_drop; drop needs flow and pressure_drop, and takes diameter; jet needs
    opening and torque, and takes flow and port (closing or opening); leakage needs pressure_drop and leakage, and takes
    temperature.
    """
    from vvdp.base.display import readable
    from vvdp.base.files import result_directory
    from vvdp.cli.printing import show_result, write_with_report
    from vvdp.cli.screen import print_json
    from vvdp.fitting.fitted import settings as fitted_settings
    from vvdp.fitting.result import confidence, fit_result
    from vvdp.fitting.table import read_columns
    from vvdp.systems.resolved import resolved_text

    chosen = _law(fitted.law, fitted.part)
    loaded = _system(on, settings)
    host = _restriction(fitted, loaded) if fitted.law == ORIFICE else _host(loaded, fitted.component)
    found = chosen.fit(read_columns(table, chosen.columns), host)
    result = fit_result(found, readable(table.name), host)
    written = [*(settings or ()), *fitted_settings(found, table, host)] if host else []
    resolved = resolved_text(loaded) if loaded else ""
    directory = output.directory(f"fit-{fitted.law}")
    with result_directory(directory, force=output.force) as folder:
        _write_system(folder / FITTED, on, written)
        reported = write_with_report(folder, result, resolved, no_report=output.no_report)
    if output.json:
        print_json({**result.flat, "confidence_95": confidence(found), "out": str(directory)})
        return
    show_result(result, directory, json=False, reported=reported)
    _print_use(found, directory / FITTED if on else None)


def _write_system(path: Path, on: str | None, settings: list[str]) -> None:
    """Writes the system with what was found, if there is one."""
    from vvdp.base.files import write_whole
    from vvdp.systems.resolved import resolved_text
    from vvdp.systems.system import load_system

    if on is not None:
        write_whole(path, resolved_text(load_system(on, settings)))


def _print_use(found: "Fitted", path: Path | None) -> None:
    """Prints how to use what was found: the file that has it, or the line for a file of the user."""
    from vvdp.cli.screen import tell
    from vvdp.fitting.orifice import K, key_line

    if path:
        tell(f"system: {path}   run it with: vvdp run {path}")
    elif K in found.valve:
        tell(f"in a system file: {key_line(found)}")


def _law(law: str, part: str) -> _Law:
    """The law that the options name. Raises ConfigError where there is none."""
    from vvdp.base.errors import ConfigError, Fault
    from vvdp.fitting import drop, jet, leakage, orifice

    drops = {"centre": drop.fit_centre, "nozzle": drop.fit_nozzle, "outlet": drop.fit_outlet}
    if part not in drops:
        raise ConfigError([Fault("--part", 0, "", f"{part!r}; expected one of {', '.join(PARTS)}")])
    laws = {
        ORIFICE: _Law(orifice.WITHOUT_DIAMETER, orifice.fit_orifice),
        "drop": _Law(drop.COLUMNS, drops[part]),
        "jet": _Law(jet.COLUMNS, jet.fit_jet),
        "leakage": _Law(leakage.COLUMNS, leakage.fit_leakage),
    }
    if law not in laws:
        raise ConfigError([Fault("--law", 0, "", f"{law!r}; expected one of {', '.join(laws)}")])
    return laws[law]


def _system(on: str | None, settings: list[str] | None) -> "System | None":
    """The system that takes what was found. Raises ConfigError for settings of no system."""
    from vvdp.base.errors import ConfigError, Fault
    from vvdp.systems.system import load_system

    if on is None and settings:
        raise ConfigError([Fault("--set", 0, settings[0], "there is no system to set it in; give --on SYSTEM")])
    return None if on is None else load_system(on, settings or ())


def _host(loaded: "System | None", name: str) -> "Host | None":
    """The rotary valve of the system, of several the one with a `name`."""
    from vvdp.evaluation.valve_unit import chosen_valve, valve_unit
    from vvdp.fitting.fitted import Host
    from vvdp.systems.short_paths import path_in_file

    if loaded is None:
        return None
    placed = chosen_valve(loaded, "fit --on", name, "--component")
    unit = valve_unit(loaded, "fit --on", placed.name)
    full = path_in_file(loaded.table, f"components.{placed.part.name}")
    own = next((key for key, table in loaded.tables.items() if table is unit.valve), full)
    return Host(
        name=loaded.name,
        table=own,
        valve=unit.valve,
        oil=unit.oil,
        temperature=unit.temperature,
        load_pressure=unit.load_pressure,
        tank_pressure=unit.tank_pressure,
    )


def _restriction(given: Law, loaded: "System | None") -> "Restriction":
    """Known values of the restriction that was measured. Raises ConfigError for options that do not fit together."""
    from vvdp.base.errors import ConfigError, Fault
    from vvdp.base.kinds import AREA, DENSITY
    from vvdp.base.units import parse
    from vvdp.components.library import UsualOil
    from vvdp.fitting.orifice import USUAL_TEMPERATURE, Restriction, restriction_of
    from vvdp.fluid.oil import density
    from vvdp.systems.short_paths import path_in_file

    if (loaded is None) != (not given.component):
        raise ConfigError([Fault("--component", 0, given.component, "give it together with --on SYSTEM")])
    known = Restriction(float(density(USUAL_TEMPERATURE, UsualOil())))
    if loaded is not None and "components" not in loaded.content:
        raise ConfigError(
            [Fault("--on", 0, loaded.name, "its file has no [components]; give one that draws its circuit")]
        )
    if loaded is not None:
        place = path_in_file(loaded.table, f"components.{given.component}")
        known = restriction_of(loaded.circuit.network, loaded.name, given.component, place)
    if given.density:
        known = known._replace(density=parse(given.density, DENSITY))
    return known._replace(area=parse(given.area, AREA)) if given.area else known
