"""`vvdp fit`."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, NamedTuple

import typer

from vvdp.cli.completion import system_names
from vvdp.cli.options import Output, Settings, flat

if TYPE_CHECKING:
    from vvdp.base.arrays import Array
    from vvdp.fitting.fitted import Fitted, Host
    from vvdp.fitting.table import Quantity
    from vvdp.systems.system import System

PARTS = ("centre", "nozzle", "outlet")
FITTED = "fitted.toml"


class _Law(NamedTuple):
    """The columns that a law needs, and what fits it to them."""

    columns: "Mapping[str, Quantity]"
    fit: "Callable[[Mapping[str, Array], Host | None], Fitted]"


@dataclass(frozen=True)
class Law:
    """Options: the law that is fitted."""

    law: Annotated[str, typer.Option("--law", metavar="LAW", help="One of drop, jet, leakage.")]
    part: Annotated[str, typer.Option("--part", metavar="PART", help="What drops: one of centre, nozzle, outlet.")] = (
        "centre"
    )


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
            help="System whose valve takes what was found: its law is drawn beside, and fitted.toml written.",
            autocompletion=system_names,
        ),
    ] = None,
    settings: Settings = None,
    output: Output,
) -> None:
    """Fit a law of the valve to a table of values.

    Columns: drop needs flow and pressure_drop, and takes diameter; jet needs opening and torque, and takes flow and
    port (closing or opening); leakage needs pressure_drop and leakage, and takes temperature.
    """
    from vvdp.base.display import readable
    from vvdp.base.files import result_directory, write_whole
    from vvdp.cli.printing import show_result, write_with_report
    from vvdp.cli.screen import print_json, tell
    from vvdp.fitting.result import confidence, fit_result
    from vvdp.fitting.table import read_columns
    from vvdp.systems.resolved import resolved_text

    chosen = _law(fitted.law, fitted.part)
    loaded, host = _host(on, settings)
    found = chosen.fit(read_columns(table, chosen.columns), host)
    result = fit_result(found, readable(table.name), host)
    directory = output.directory(f"fit-{fitted.law}")
    with result_directory(directory, force=output.force) as folder:
        if loaded:
            write_whole(folder / FITTED, _fitted_text(loaded, on or "", settings, found, table))
        reported = write_with_report(
            folder, result, resolved_text(loaded) if loaded else "", no_report=output.no_report
        )
    if output.json:
        print_json({**result.flat, "confidence_95": confidence(found), "out": str(directory)})
        return
    show_result(result, directory, json=False, reported=reported)
    if loaded:
        tell(f"system: {directory / FITTED}   run it with: vvdp run {directory / FITTED}")


def _law(law: str, part: str) -> _Law:
    """The law that the options name. Raises ConfigError where there is none."""
    from vvdp.base.errors import ConfigError, Fault
    from vvdp.fitting import drop, jet, leakage

    drops = {"centre": drop.fit_centre, "nozzle": drop.fit_nozzle, "outlet": drop.fit_outlet}
    if part not in drops:
        raise ConfigError([Fault("--part", 0, "", f"{part!r}; expected one of {', '.join(PARTS)}")])
    laws = {
        "drop": _Law(drop.COLUMNS, drops[part]),
        "jet": _Law(jet.COLUMNS, jet.fit_jet),
        "leakage": _Law(leakage.COLUMNS, leakage.fit_leakage),
    }
    if law not in laws:
        raise ConfigError([Fault("--law", 0, "", f"{law!r}; expected one of {', '.join(laws)}")])
    return laws[law]


def _host(on: str | None, settings: list[str] | None) -> "tuple[System | None, Host | None]":
    """The system that takes what was found, and its valve. Raises ConfigError for settings of no system."""
    from vvdp.base.errors import ConfigError, Fault
    from vvdp.base.signal import signal_value
    from vvdp.fitting.fitted import Host
    from vvdp.systems.bench import rotary_bench
    from vvdp.systems.system import load_system

    if on is None:
        if settings:
            raise ConfigError([Fault("--set", 0, settings[0], "there is no system to set it in; give --on SYSTEM")])
        return None, None
    loaded = load_system(on, settings or ())
    bench = rotary_bench(loaded, "fit --on")
    temperature = float(signal_value(0.0, bench.operation.oil_temperature))
    host = Host(
        name=loaded.name,
        valve=bench.valve,
        oil=bench.oil,
        temperature=temperature,
        load_pressure=bench.load_pressure,
        tank_pressure=bench.tank_pressure,
    )
    return loaded, host


def _fitted_text(loaded: "System", on: str, settings: list[str] | None, found: "Fitted", table: Path) -> str:
    """The system with what was found."""
    from vvdp.fitting.fitted import settings as fitted_settings
    from vvdp.systems.resolved import resolved_text
    from vvdp.systems.system import load_system

    return resolved_text(load_system(on, [*(settings or ()), *fitted_settings(found, table)]))
