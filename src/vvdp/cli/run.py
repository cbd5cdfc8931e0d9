"""`vvdp run`."""

import time
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from vvdp.cli.options import AsJson, Force, Settings, SystemName, default_directory, out_option

if TYPE_CHECKING:
    from vvdp.simulation.run import Run
    from vvdp.systems.system import System

NOT_TRUSTED = 3
INTERRUPTED = 130


def run(
    system: SystemName,
    settings: Settings = None,
    until: Annotated[
        str | None, typer.Option("--until", metavar="TIME", help='Simulated time, for example "2 s".')
    ] = None,
    out: Annotated[
        Path | None,
        out_option("Where to write; by default results/SYSTEM-DATE-TIME."),
    ] = None,
    force: Force = False,
    json: AsJson = False,
    no_report: Annotated[bool, typer.Option("--no-report", help="Write no report.")] = False,
) -> None:
    """Simulate a system; write its results and a report.

    Ctrl-C ends the simulation early and keeps what was reached.
    """
    from vvdp.cli.progress import reached
    from vvdp.cli.screen import plain, print_json, say
    from vvdp.simulation.results import result_directory, write_results
    from vvdp.simulation.run import simulate
    from vvdp.systems.summary import summary
    from vvdp.systems.system import load_system, resolved_text

    loaded = load_system(system, settings or (), until)
    directory = out if out is not None else default_directory(loaded.name)
    with result_directory(directory, force=force) as folder:
        end = loaded.stepping.until
        with reached(end, lambda now: f"t = {now:.4g} s of {end:.4g} s") as progress:
            done = simulate(loaded.model, loaded.case, loaded.stepping, progress=progress, say=say)
        if not done.end > 0.0:
            raise KeyboardInterrupt  # nothing to keep
        if not done.finished:
            say(f"interrupted at t = {done.end:.6g} s; writing what was reached")
        found = summary(loaded, done)
        more = _origin(loaded, found, settings or [])
        write_results(folder, done, system=resolved_text(loaded), summary=plain(found), more=plain(more))
    if json:
        print_json({"system": loaded.name, **found, "out": str(directory)})
    else:
        _print(loaded, done, found)
        typer.echo(f"results: {directory}")
    if not no_report:
        from vvdp.report.report import write_report

        report = write_report(directory)
        if not json:
            typer.echo(f"report: {report}")
    if not found.get("trusted", True):
        say("not trusted: the books of this run do not balance; see energy_residual and mass_residual")
    if not done.finished:
        raise typer.Exit(INTERRUPTED)
    if not found.get("trusted", True):
        raise typer.Exit(NOT_TRUSTED)


def _origin(system: "System", found: dict[str, Any], settings: list[str]) -> dict[str, Any]:
    """What meta.json says of a run besides what the simulation knows."""
    return {
        "system": system.name,
        "title": system.title,
        "circuit": system.circuit,
        "settings": settings,
        "assumed_values": len(system.assumed),
        "written": time.strftime("%Y-%m-%dT%H:%M:%S%z"),
        **{key: found[key] for key in ("energy_residual", "mass_residual", "trusted") if key in found},
    }


VALVE_LOSS = ("loss_full_open_W", "loss_transition_W")

# What a person is shown: label, keys that are added up, those of the closed form, name of the unit.
SHOWN = (
    ("PWM frequency", ("pwm_frequency_Hz",), ("analytic_pwm_frequency_Hz",), "Hz"),
    ("pump flow", ("mean_pump_flow_m3_s",), (), "lpm"),
    ("flow to the load", ("mean_load_flow_m3_s",), ("analytic_load_flow_m3_s",), "lpm"),
    ("flow to the tank", ("mean_tank_flow_m3_s",), (), "lpm"),
    ("flow over the relief valve", ("mean_relief_flow_m3_s",), (), "lpm"),
    ("leakage of the valve", ("mean_leakage_flow_m3_s",), (), "lpm"),
    ("inlet pressure, mean", ("mean_inlet_pressure_Pa",), (), "bar"),
    ("inlet pressure, lowest", ("inlet_pressure_min_Pa",), (), "bar"),
    ("inlet pressure, highest", ("inlet_pressure_max_Pa",), (), "bar"),
    ("load pressure, mean", ("mean_load_pressure_Pa",), (), "bar"),
    ("load pressure, lowest", ("load_pressure_min_Pa",), (), "bar"),
    ("load pressure, highest", ("load_pressure_max_Pa",), (), "bar"),
    ("spool angle, error of the estimate", ("spool_angle_error_rms_rad",), (), "rad"),
    ("spool speed, error of the estimate", ("spool_speed_error_rms_rad_s",), (), "rad/s"),
    ("input power, pump shaft", ("input_power_W",), (), "W"),
    ("input power, spool motor", ("spool_motor_power_W",), (), "W"),
    ("load power", ("load_power_W",), (), "W"),
    ("efficiency", ("efficiency",), (), ""),
    ("loss, valve and relief valve", VALVE_LOSS, tuple(f"analytic_{key}" for key in VALVE_LOSS), "W"),
    ("loss, compressibility", (), ("analytic_loss_compressibility_W",), "W"),
    ("loss, leakage of the valve", ("loss_valve_leakage_W",), ("analytic_loss_leakage_W",), "W"),
    ("taken into store", ("stored_power_W",), (), "W"),
    ("input less load", ("loss_total_W",), ("analytic_loss_total_W",), "W"),
)


def _print(system: "System", done: "Run", found: dict[str, Any]) -> None:
    from vvdp.cli.screen import amount, console, grid, warn
    from vvdp.simulation.balance import LIMIT

    out = console()
    out.print(system.title, soft_wrap=True)
    begin, end = found["averaged_from_s"], found["averaged_to_s"]
    out.print(f"means over {found['averaged_periods']:g} PWM periods, {begin:.4g} s to {end:.4g} s; pressures gauge")
    table = grid("quantity", "simulated", "closed form", "unit", right=("simulated", "closed form"))
    for label, simulated, analytic, unit in SHOWN:
        cells = [
            amount(sum(found[key] for key in keys), unit) if keys and found.keys() >= set(keys) else ""
            for keys in (simulated, analytic)
        ]
        if any(cells):
            table.add_row(label, *cells, unit)
    out.print(table)
    if "trusted" in found:
        out.print(
            f"balances: energy {found['energy_residual']:.1e}, oil {found['mass_residual']:.1e} of the throughput "
            f"(limit {LIMIT:.0e})"
        )
    out.print(f"{done.steps} steps in {done.seconds:.2f} s; {len(system.assumed)} values of the system are assumed")
    for text in _warnings(found):
        warn(text)


def _warnings(found: dict[str, Any]) -> Iterator[str]:
    if not found.get("trusted", True):
        yield "not trusted: the balances are above the limit; try a tenth of run.relative_tolerance"
    if not found["finished"]:
        yield f"the run was interrupted at {found['duration_s']:.6g} s"
    if found["averaged_periods"] < 1:
        yield "no whole PWM period lies in the averaging window: the means are over plain time"
    elif not found["settled"]:
        if found["steady"]:
            yield "the PWM frequency has not settled within the averaging window: run longer"
        else:
            yield "what is prescribed changes over time: the means are those of the averaging window, no steady state"
    if found["cavitation"]:
        yield "the inlet pressure falls below the cavitation limit"
    if found["motor_overloaded"]:
        power, rated = found["input_power_W"], found["motor_rated_power_W"]
        yield f"the input power of {power:.4g} W exceeds the motor's {rated:.4g} W"
