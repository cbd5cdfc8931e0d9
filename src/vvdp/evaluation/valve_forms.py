"""Closed forms of rotary valves, to stand beside what a run finds: of a bench, and of units in any circuit."""

from collections.abc import Iterator, Mapping
from typing import Any

from vvdp.base.errors import ConfigError
from vvdp.base.kinds import Kind
from vvdp.base.signal import Signal, constant
from vvdp.evaluation.bench_overview import ANALYTIC, QUANTITIES
from vvdp.evaluation.bench_parts import shows_all
from vvdp.evaluation.bench_validity import switching_limits
from vvdp.evaluation.bench_values import BenchValues
from vvdp.evaluation.valve_numbers import PlacedValve, placed_valves
from vvdp.evaluation.valve_unit import ValveUnit, valve_unit
from vvdp.hydraulics.pump import pump_friction_power
from vvdp.hydraulics.volume import Vessel
from vvdp.network.network import Network
from vvdp.network.nodes import Connection, Shaft, Source
from vvdp.systems.extras import LoadedSystem, Summary
from vvdp.valve.losses import range_warnings
from vvdp.valve.validity import CAVITATION_PRESSURE


def unit_forms(unit: ValveUnit, load_pressure: float) -> dict[str, float]:
    """The analytic results of a unit against `load_pressure` [Pa, absolute], by the keys `ANALYTIC`.

    They take as long to calculate as a short run.
    """
    point = unit.operating_point(load_pressure)
    pump = point.cycle.pump_loss + pump_friction_power(unit.pump_speed, unit.pump)
    values = (
        point.averaged_pwm_frequency,
        point.full_open_pwm_frequency,
        point.full_open_loss,
        point.transition_loss,
        point.leakage_loss,
        point.compressibility_loss,
        pump,
        point.total_loss + pump,
        point.cycle.load_flow,
    )
    return {key: float(value) for key, value in zip(ANALYTIC, values, strict=True)}


def unit_limits(
    unit: ValveUnit, load_pressure: float, bench: BenchValues, found: Mapping[str, float | bool]
) -> Iterator[str]:
    """Why the closed forms do not describe a run, a sentence each; none where they do.

    load_pressure  mean [Pa, absolute]
    bench, found   what the checks of switching read of the unit, and of its run
    """
    point = unit.set_point(load_pressure)._replace(flow=unit.delivered_flow(load_pressure))
    yield from unit.average_limits()
    yield from switching_limits(bench, found)
    if point.flow > 0.0:
        yield from range_warnings(point.duty_ratio, point.condition(unit.oil), unit.valve)
    else:
        yield "the pump's leakage takes all of its flow"


def placed_forms(system: LoadedSystem, found: Mapping[str, float | bool]) -> Summary:
    """The analytic results of each rotary valve in a drawn circuit, its name before their keys.

    There are none where anything prescribed changes, a program commands, the flow does not turn the spool alone, the
    run has not settled, or `unit_limits` says why.
    """
    network, numbers = system.circuit.network, Summary()
    if shows_all(system) or not found.get("settled") or not is_steady(network):
        return numbers
    for placed in placed_valves(network):
        unit = _closed_unit(system, placed)
        load: Any = network.nodes[placed.part.nodes["load"]]
        if unit is None or (unit.makes_pressure and not isinstance(load.values, Vessel)):
            continue
        pressure = float(found[f"pressure_mean_{load.name}_Pa"]) + unit.oil.reference_pressure
        values = _bench_values(unit, load.values if unit.makes_pressure else None)
        if pressure > unit.tank_pressure and not any(unit_limits(unit, pressure, values, _own_numbers(placed, found))):
            numbers |= {f"{placed.name}_{key}": value for key, value in unit_forms(unit, pressure).items()}
    return numbers


def placed_form_quantities(system: LoadedSystem) -> Iterator[tuple[str, tuple[Kind, str]]]:
    """Kind and label of the analytic results of each rotary valve, by key."""
    for placed in () if shows_all(system) else placed_valves(system.circuit.network):
        for key in ANALYTIC:
            kind, label = QUANTITIES[key]
            yield f"{placed.name}_{key}", (kind, f"{placed.name.replace('_', ' ')} {label}")


def is_steady(network: Network) -> bool:
    """Whether nothing prescribed in a network changes over time, and no program commands it."""
    nodes = (getattr(node, name, None) for node in network.nodes.values() for name in ("pressure", "speed"))
    inputs = (source for part in network.parts.values() for source in part.inputs.values())
    return not network.programs and all(map(_is_constant, (network.temperature, *nodes, *inputs)))


def _is_constant(source: Source | None) -> bool:
    sources = source.sources if isinstance(source, Connection) else (source,)
    return all(each.is_constant for each in sources if isinstance(each, Signal))


def _closed_unit(system: LoadedSystem, placed: PlacedValve) -> ValveUnit | None:
    """The unit of a valve whose spool the flow alone turns; None where it has no pump or no relief valve."""
    network, spool = system.circuit.network, placed.part.nodes["spool"]
    on_it = [part.name for part in network.parts.values() if spool in part.nodes.values()]
    if on_it != [placed.part.name] or not isinstance(network.nodes[spool], Shaft):
        return None
    try:
        unit = valve_unit(system, "run", placed.name)
    except ConfigError:
        return None
    return unit if unit.nominal_flow > 0.0 else None


def _bench_values(unit: ValveUnit, line: Vessel | None) -> BenchValues:
    return BenchValues(
        valve=unit.valve,
        oil=unit.oil,
        load_line=line,
        duty_ratio=constant(unit.duty_ratio),
        axial_position=constant(unit.duty_ratio * unit.valve.helix_length),
        is_placed=True,
        temperature=unit.temperature,
        reference=unit.oil.reference_pressure,
        tank_pressure=unit.tank_pressure,
        cavitation_pressure=CAVITATION_PRESSURE,
        inlet_volume=unit.inlet_volume,
        ripple_amplitude=unit.pump.ripple_amplitude,
    )


def _own_numbers(placed: PlacedValve, found: Mapping[str, float | bool]) -> Mapping[str, float | bool]:
    """The numbers of one valve in a run, as a bench calls them."""
    part = placed.part
    return {
        **found,
        "pressure_mean_load_line_Pa": found[f"pressure_mean_{part.nodes['load']}_Pa"],
        "mean_load_flow_m3_s": found[f"flow_mean_{part.name}_load_m3_s"],
        "mean_pump_flow_m3_s": -float(found[f"flow_mean_{part.name}_inlet_m3_s"]),
        "pwm_frequency_Hz": found[f"{placed.name}_pwm_frequency_Hz"],
    }
