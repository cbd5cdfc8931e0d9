"""`vvdp valve`."""

from itertools import product
from typing import TYPE_CHECKING, Annotated, Any

import typer

from vvdp.cli.options import AsJson, Settings, SystemName, ValveName

if TYPE_CHECKING:
    from vvdp.base.kinds import Kind
    from vvdp.evaluation.ranges import Ranges
    from vvdp.evaluation.valve_unit import ValveUnit
    from vvdp.systems.system import System
    from vvdp.valve.operating_point import OperatingPoint

Row = dict[str, Any]


def valve(
    system: SystemName,
    flow: Annotated[
        list[str] | None,
        typer.Option("--flow", metavar="FLOW", help='Flow that the pump delivers, for example "40 lpm" (repeatable).'),
    ] = None,
    temperature: Annotated[
        list[str] | None,
        typer.Option("--temperature", metavar="TEMP", help='Oil temperature, for example "40 degC" (repeatable).'),
    ] = None,
    part: ValveName = "",
    settings: Settings = None,
    json: AsJson = False,
) -> None:
    """Show the valve's drops, torques, speeds and losses.

    They are analytic, without a simulation. Flow and temperature default to those at the start of the run; several
    values give one row per pair. The load pressure is the prescribed one, or the initial one if the load makes its own.
    Numbers that a value with a range moves by more than 1 % are shown with how far.
    """
    from vvdp.base.kinds import FLOW, TEMPERATURE
    from vvdp.cli.screen import print_json
    from vvdp.cli.valve_table import print_point, print_points
    from vvdp.evaluation.valve_unit import valve_unit
    from vvdp.systems.system import load_system

    loaded = load_system(system, settings or ())
    unit = valve_unit(loaded, "valve", part)
    flows = _flows(flow, FLOW, unit.delivered_flow(unit.load_pressure))
    temperatures = _values("--temperature", temperature, TEMPERATURE) or [unit.temperature]
    rows = [_row(loaded.name, unit, q, t) for q, t in product(flows, temperatures)]
    ranges = _ranges(loaded, part, rows[0], flows[0]) if len(rows) == 1 and loaded.uncertainties else None
    if json:
        columns = rows[0] if len(rows) == 1 else {key: [row[key] for row in rows] for key in rows[0]}
        spans = {"ranges": ranges.flat} if ranges else {}
        print_json({"verb": "valve", "system": loaded.name, "finished": True, **columns, **spans})
    elif len(rows) == 1:
        print_point(loaded.title, unit, rows[0], ranges)
    else:
        print_points(loaded.title, unit, rows)


def _values(option: str, texts: list[str] | None, kind: "Kind") -> list[float]:
    """The SI values of an option. Raises ConfigError with all that is wrong with them."""
    from vvdp.base.errors import ConfigError, Fault, ParameterError
    from vvdp.base.units import parse

    values, faults = [], []
    for text in texts or ():
        try:
            values.append(parse(text, kind))
        except ParameterError as problem:
            faults.append(Fault(option, 0, "", str(problem)))
    if faults:
        raise ConfigError(faults)
    return values


def _flows(texts: list[str] | None, kind: "Kind", delivered: float) -> list[float | None]:
    """The flows of an option, none for what the pump of the system delivers."""
    from vvdp.base.errors import ConfigError, Fault
    from vvdp.base.rules import POSITIVE

    flows = _values("--flow", texts, kind)
    faults = [
        Fault("--flow", 0, "", f"{text!r} {POSITIVE}")
        for text, value in zip(texts or (), flows, strict=True)
        if not value > 0.0
    ]
    if not flows and not delivered > 0.0:
        faults = [Fault("--flow", 0, "", "the pump delivers nothing at the start of the run; give a flow")]
    if faults:
        raise ConfigError(faults)
    return [*flows] or [None]


def _ranges(loaded: "System", part: str, row: Row, flow: float | None) -> "Ranges":
    """The numbers of a row over the ranges of values, at the same temperature and `flow`, that of the pump if None."""
    from dataclasses import replace

    from vvdp.evaluation.ranges import at_ends, ranges_of, spans_together
    from vvdp.evaluation.valve_unit import valve_unit

    def numbers(system: "System") -> Row:
        unit = valve_unit(system, "valve", part)
        return _row(system.name, unit, flow, row["temperature_K"], averaged=True)

    found = [reason if each is None else numbers(each) for each, reason in at_ends(loaded)]
    keys = [key for key, value in row.items() if isinstance(value, float)]
    alone = ranges_of(loaded, keys, row, found)
    return replace(alone, together=spans_together(loaded, alone, numbers))


def _row(name: str, unit: "ValveUnit", flow: float | None, temperature: float, *, averaged: bool = False) -> Row:
    """Everything that docs/keys.md describes for `vvdp valve`.

    `averaged` is whether the quasi-steady average gives the transition loss where its closed form does not hold.
    """
    from vvdp.base.errors import ParameterError
    from vvdp.valve.operating_point import average_transition, operating_point

    reference, load = unit.oil.reference_pressure, unit.load_pressure
    set_point = unit.set_point(load)._replace(temperature=temperature)
    if flow is not None:
        set_point = set_point.delivering(flow, unit.oil, unit.valve)
    try:
        point = operating_point(set_point, unit.inlet_volume, unit.oil, unit.valve)
    except ArithmeticError as problem:
        raise ParameterError(f"{name}: the formulas have no value here ({problem})") from None
    if averaged and point.warnings:
        point = average_transition(point)
    asked = {
        "flow_m3_s": point.flow,
        "temperature_K": temperature,
        "duty_ratio": set_point.duty_ratio,
        "load_pressure_Pa": load - reference,
        "relief_pressure_Pa": set_point.relief_pressure - reference,
    }
    found = {key: float(value) for key, value in (asked | _numbers(point)).items()}
    return found | {"warnings": [*point.warnings, *unit.average_limits()]}


def _numbers(point: "OperatingPoint") -> dict[str, float]:
    """Results of the formulas at an operating point, by key."""
    return {
        "pressure_drop_nozzle_Pa": point.nozzle_drop,
        "pressure_drop_centre_section_Pa": point.centre_drop,
        "pressure_drop_outlet_turbine_Pa": point.outlet_drop,
        "pressure_drop_total_Pa": point.total_drop,
        "torque_inlet_N_m": point.inlet_torque,
        "torque_outlet_N_m": point.outlet_torque,
        "torque_friction_N_m": point.friction_torque,
        "spool_speed_rad_s": point.spool_speed,
        "pwm_frequency_Hz": point.full_open_pwm_frequency,
        "pwm_frequency_averaged_Hz": point.averaged_pwm_frequency,
        "transition_fraction": point.transition_fraction,
        "loss_full_open_W": point.full_open_loss,
        "loss_transition_W": point.transition_loss,
        "loss_compressibility_W": point.compressibility_loss,
        "loss_leakage_W": point.leakage_loss,
        "loss_total_W": point.total_loss,
        "spool_friction_power_W": point.friction_loss,
        "compression_regime": point.compression_regime,
        "nozzle_reynolds_number": point.nozzle_reynolds_number,
        "mean_load_flow_m3_s": point.cycle.load_flow,
    }
