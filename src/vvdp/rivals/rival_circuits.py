"""The circuits that are compared: a system, how it is sized for a duty, and where its powers are read."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, NamedTuple

from vvdp.base.errors import ConfigError, Fault
from vvdp.hydraulics.flow_control_unit import code_count
from vvdp.machines.cylinder_load import LOW_SIDE, InitialCylinder, start_at_rest
from vvdp.machines.duties import Duty
from vvdp.machines.machine_loop import PROGRAM
from vvdp.rivals.rival_machine import (
    Tables,
    control_begin,
    size_following_machine,
    size_machine,
    size_other_valve,
    size_published_machine,
    size_slow_machine,
)
from vvdp.rivals.rivals import LOOP
from vvdp.simulation.run import Run
from vvdp.systems.system import load_system

SAFETY = 20e5
"""By how much the relief valve of a pump that holds its pressure lies above that [Pa]."""


class Sink(NamedTuple):
    """Where power is lost: a key of the table, and what a user calls it."""

    key: str
    label: str


RELIEF = Sink("loss_relief_W", "relief valve")
METERING = Sink("loss_valves_W", "valves")
COMPENSATORS = Sink("loss_compensators_W", "compensators")
RETURN = Sink("loss_return_W", "meter-out throttle")
SWITCHING = Sink("loss_rotary_W", "PWM valve")
LEAKAGE = Sink("loss_leakage_W", "leakage")
PUMP_FRICTION = Sink("loss_pump_friction_W", "pump friction")
PISTON_VALVES = Sink("loss_piston_valves_W", "piston valves")
CHARGE = Sink("loss_charge_W", "charge relief")
SINKS = (RELIEF, METERING, COMPENSATORS, RETURN, SWITCHING, LEAKAGE, PUMP_FRICTION, PISTON_VALVES, CHARGE)
"""Where power is lost before the rod, in the order in which it is shown."""


@dataclass(frozen=True)
class RivalCircuit:
    """A circuit: the system that is run, what of its tables follows the duty, and which of its parts make a sink,
    by their names in the books.

    `size(tables, duty, begin, rounds)` gives the tables that follow; `program` is that whose command has the reference.
    `begin` reports a run when control began, where that is not at once. `charge` gives the pressure below which, less
    a margin, its low side must not fall; None where nothing charges it. Where `shares` holds, one pump feeds all
    cylinders of a duty, by the tables [second] and [third]; else each has a circuit of its own. Where the losses of
    its pump are `measured`, none of them is assumed.
    """

    name: str
    title: str
    system: str
    size: Callable[[Tables, Duty, float, int], Tables]
    sinks: Mapping[Sink, tuple[str, ...]]
    charge: Callable[[Tables], float] | None = None
    program: str = LOOP
    begin: Callable[[Run], float] | None = None
    shares: bool = False
    measured: bool = False


def start_of(tables: Tables, duty: Duty, level: float, supply: float | None = None) -> InitialCylinder:
    """Where a run on a duty starts; see `start_at_rest`."""
    return start_at_rest(duty.cycle, tables["cylinder"], tables["oil"].reference_pressure, level, supply)


def _relief(tables: Tables, name: str, duty: Duty) -> Any:
    return replace(tables[name], cracking_pressure=tables["oil"].reference_pressure + duty.relief_pressure)


def _size_throttle(tables: Tables, duty: Duty) -> Tables:
    relief, reference = _relief(tables, "relief_valve", duty), tables["oil"].reference_pressure
    start = start_of(tables, duty, reference + LOW_SIDE, relief.cracking_pressure)
    return {"relief_valve": relief, "initial": start, **_further(duty)}


def _further(duty: Duty) -> Tables:
    """The tables of the further cylinders of a duty."""
    return {name: each.cycle for name, each in zip(("second", "third"), duty.further, strict=False)}


def _size_one_way(tables: Tables, duty: Duty) -> Tables:
    valve = replace(tables["directional_valve"], return_conductance=duty.return_conductance)
    start = start_of(tables, duty, tables["oil"].reference_pressure + LOW_SIDE)
    return {"relief_valve": _relief(tables, "relief_valve", duty), "directional_valve": valve, "initial": start}


def _size_load_sensing(tables: Tables, duty: Duty) -> Tables:
    """A controlled pump, and a meter-out throttle."""
    return {**_size_one_way(tables, duty), **_size_controlled_pump(tables, duty)}


def _size_controlled_pump(tables: Tables, duty: Duty) -> Tables:
    """The pump's pressure ends where relief valves of others open; its own one opens 20 bar above."""
    highest = tables["oil"].reference_pressure + duty.relief_pressure
    relief = replace(tables["relief_valve"], cracking_pressure=highest + SAFETY)
    control = replace(tables["pump_control"], highest_pressure=highest)
    return {"relief_valve": relief, "pump_control": control, **_further(duty)}


def _size_independent_valves(tables: Tables, duty: Duty) -> Tables:
    """The valves out of the chambers are as large as the meter-out throttle of other circuits."""
    valve = replace(tables["return_valve"], conductance=duty.return_conductance)
    start = start_of(tables, duty, tables["oil"].reference_pressure + LOW_SIDE)
    return {**_size_controlled_pump(tables, duty), "return_valve": valve, "initial": start}


def _size_independent_units(tables: Tables, duty: Duty) -> Tables:
    """The units out of the chambers are as large with all their valves open."""
    unit = tables["return_unit"]
    smallest = duty.return_conductance / (code_count(unit.parts) - 1)
    start = start_of(tables, duty, tables["oil"].reference_pressure + LOW_SIDE)
    unit = replace(unit, rated_flow=smallest * math.sqrt(unit.rated_drop))
    return {**_size_controlled_pump(tables, duty), "return_unit": unit, "initial": start}


def _size_constant_pressure(tables: Tables, duty: Duty) -> Tables:
    """The same with a pump that holds the pressure at which load sensing ends: its margin is as large."""
    found = _size_load_sensing(tables, duty)
    control = found["pump_control"]
    return {**found, "pump_control": replace(control, margin=control.highest_pressure)}


def _size_closed(tables: Tables, duty: Duty) -> Tables:
    charge = charge_pressure(tables)
    return {"relief_valves": _relief(tables, "relief_valves", duty), "initial": start_of(tables, duty, charge, charge)}


def _size_open(tables: Tables, duty: Duty) -> Tables:
    return {
        "relief_valve": _relief(tables, "relief_valve", duty),
        "initial": start_of(tables, duty, reservoir_pressure(tables)),
    }


def _at_once(size: Callable[[Tables, Duty], Tables]) -> Callable[[Tables, Duty, float, int], Tables]:
    """The same for a circuit whose control begins at time 0, with its duty cycle as a table."""
    return partial(_tables_at_once, size)


def _tables_at_once(
    size: Callable[[Tables, Duty], Tables], tables: Tables, duty: Duty, begin: float, rounds: int
) -> Tables:
    return {"duty_cycle": duty.cycle, **size(tables, duty)}


def charge_pressure(tables: Tables) -> float:
    """The charge pressure of a closed circuit, absolute [Pa]."""
    return float(tables["charge_relief_valve"].cracking_pressure)


def reservoir_pressure(tables: Tables) -> float:
    """The pressure of the reservoir of an open circuit, absolute [Pa]."""
    return float(tables["reservoir"].pressure.extremes[0])


PUMP_LEAKAGE = ("pump.leakage", "pump.compression", "cylinder")
PUMP_SINKS: Mapping[Sink, tuple[str, ...]] = {LEAKAGE: PUMP_LEAKAGE, PUMP_FRICTION: ("pump.friction",)}
ONE_WAY_SINKS: Mapping[Sink, tuple[str, ...]] = {
    RELIEF: ("relief_valve",),
    METERING: ("directional_valve.edges",),
    RETURN: ("directional_valve.return_throttle",),
    **PUMP_SINKS,
}
LOAD_SENSING_SINKS: Mapping[Sink, tuple[str, ...]] = {
    **ONE_WAY_SINKS,
    METERING: ("flow_valve.metering", "directional_valve.edges"),
    COMPENSATORS: ("flow_valve.compensator",),
}
CLOSED_SINKS: Mapping[Sink, tuple[str, ...]] = {
    RELIEF: ("relief_valve_a", "relief_valve_b"),
    LEAKAGE: ("pump_leakage", "cylinder"),
    CHARGE: ("charge_relief_valve",),
}
FOUR_VALVES = tuple(f"{way}_valve_{side}" for way in ("supply", "return") for side in "ab")
FILLING = tuple(f"anti_cavitation_{where}" for where in ("supply", "a", "b"))

MACHINE_SINKS: Mapping[Sink, tuple[str, ...]] = {
    **ONE_WAY_SINKS,
    SWITCHING: (
        "valve.nozzle",
        "valve.centre_section",
        "valve.outlet_turbine",
        "valve.spool_friction",
        "valve.to_spool",
        "coupling",
        "pilot_valve",
        "axial_friction",
        "axial_stops",
    ),
    LEAKAGE: (*PUMP_LEAKAGE, "valve.leakage"),
}
WHOLE_MACHINE = partial(
    RivalCircuit, system="displacement-control", sinks=MACHINE_SINKS, program=PROGRAM, begin=control_begin
)
CIRCUITS = (
    WHOLE_MACHINE(
        name="vvdp",
        title="the whole machine: fixed pump of 40 lpm, rotary valve, directional valve, meter-out throttle",
        size=size_machine,
    ),
    WHOLE_MACHINE(
        name="vvdp-slow",
        title="the same with its pump at 1200 rpm, 26.7 lpm",
        size=size_slow_machine,
    ),
    WHOLE_MACHINE(
        name="vvdp-following",
        title="the whole machine with a relief valve 20 bar above the line's pressure, at 30 bar at least",
        size=size_following_machine,
    ),
    WHOLE_MACHINE(
        name="vvdp-chapter-6",
        title="the whole machine as published: flow and meter-out throttle by the laws of chapter 6",
        size=size_published_machine,
    ),
    RivalCircuit(
        name="throttle",
        title="fixed pump of 40 lpm, relief valve, 4/3 proportional valve",
        system="throttle-control",
        size=_at_once(_size_throttle),
        sinks={
            RELIEF: ("relief_valve",),
            METERING: ("directional_valve",),
            **PUMP_SINKS,
        },
        shares=True,
    ),
    RivalCircuit(
        name="bleed-off",
        title="fixed pump of 40 lpm at the load's pressure, a throttle beside the cylinder lets the rest to the tank",
        system="bleed-off-control",
        size=_at_once(_size_one_way),
        sinks={**ONE_WAY_SINKS, METERING: ("bleed_valve", "directional_valve.edges")},
    ),
    RivalCircuit(
        name="constant-pressure",
        title="variable pump that holds one pressure, compensated throttles, directional valves",
        system="load-sensing",
        size=_at_once(_size_constant_pressure),
        sinks=LOAD_SENSING_SINKS,
        shares=True,
    ),
    RivalCircuit(
        name="load-sensing",
        title="variable pump 20 bar above the highest load, compensated throttles, directional valves",
        system="load-sensing",
        size=_at_once(_size_load_sensing),
        sinks=LOAD_SENSING_SINKS,
        shares=True,
    ),
    RivalCircuit(
        name="independent-valves",
        title="variable pump 10 bar above the highest load, four proportional valves at each cylinder",
        system="independent-valves",
        size=_at_once(_size_independent_valves),
        sinks={
            **ONE_WAY_SINKS,
            METERING: ("supply_valve_a", "supply_valve_b"),
            RETURN: ("return_valve_a", "return_valve_b"),
        },
        shares=True,
    ),
    RivalCircuit(
        name="independent-units",
        title="the same with four digital flow control units of five on/off valves at each cylinder",
        system="independent-units",
        size=_at_once(_size_independent_units),
        sinks={
            **ONE_WAY_SINKS,
            METERING: tuple(f"supply_{side}_{number}" for side in "ab" for number in range(1, 6)),
            RETURN: tuple(f"return_{side}_{number}" for side in "ab" for number in range(1, 6)),
        },
        shares=True,
    ),
    RivalCircuit(
        name="flow-control-unit",
        title="fixed pump of 40 lpm, relief valve, one unit of five on/off valves that meters in, directional valve",
        system="flow-control-unit",
        size=_at_once(_size_one_way),
        sinks={**ONE_WAY_SINKS, METERING: (*(f"unit_{number}" for number in range(1, 6)), "directional_valve.edges")},
    ),
    RivalCircuit(
        name="linear-valves",
        title="the machine's circuit with fast linear on/off valves at 75 Hz instead of the rotary one",
        system="linear-valves",
        size=_at_once(_size_one_way),
        sinks={**ONE_WAY_SINKS, SWITCHING: ("switching_valve",)},
    ),
    RivalCircuit(
        name="ideal-pump",
        title="ideal variable pump one way, directional valve, meter-out throttle",
        system="ideal-pump-control",
        size=_at_once(_size_one_way),
        sinks={**ONE_WAY_SINKS, LEAKAGE: ("pump_leakage", "cylinder")},
    ),
    RivalCircuit(
        name="measured-pump",
        title="the same with a variable pump that has the losses of a measured one",
        system="measured-pump-control",
        size=_at_once(_size_one_way),
        sinks=ONE_WAY_SINKS,
        measured=True,
    ),
    RivalCircuit(
        name="digital-pump",
        title="the same with a pump of twelve pistons that deliver or idle one by one",
        system="digital-pump-control",
        size=_at_once(_size_one_way),
        sinks={**ONE_WAY_SINKS, PISTON_VALVES: ("pump.breathing", "pump.actuation")},
    ),
    RivalCircuit(
        name="shuttle",
        title="closed circuit, overcentre pump, commanded shuttle valve (fig. 1.6)",
        system="shuttle-circuit",
        size=_at_once(_size_closed),
        sinks={**CLOSED_SINKS, METERING: ("shuttle_valve", "charge_check_a", "charge_check_b")},
        charge=charge_pressure,
    ),
    RivalCircuit(
        name="pilot-checks",
        title="closed circuit, overcentre pump, pilot-operated checks (fig. 1.7)",
        system="pilot-check-circuit",
        size=_at_once(_size_closed),
        sinks={**CLOSED_SINKS, METERING: ("pilot_check_a", "pilot_check_b")},
        charge=charge_pressure,
    ),
    RivalCircuit(
        name="four-valves",
        title="open circuit, overcentre pump, four 2-way valves (fig. 1.8)",
        system="four-valve-circuit",
        size=_at_once(_size_open),
        sinks={
            RELIEF: ("relief_valve",),
            METERING: (*FOUR_VALVES, *FILLING),
            LEAKAGE: ("pump_leakage", "cylinder"),
        },
        charge=reservoir_pressure,
    ),
)
"""All circuits; another one is another value."""


def with_value(circuit: RivalCircuit, name: str, table: str, field: str, value: float) -> RivalCircuit:
    """A circuit with another value in one of its tables [SI], under a name of its own."""
    return replace(circuit, name=name, size=partial(_size_with_value, circuit.size, (table, field, value)))


def _size_with_value(
    size: Callable[[Tables, Duty, float, int], Tables],
    changed: tuple[str, str, float],
    tables: Tables,
    duty: Duty,
    begin: float,
    rounds: int,
) -> Tables:
    table, field, value = changed
    other = {table: replace(tables[table], **{field: value})}
    return {**other, **size({**tables, **other}, duty, begin, rounds)}


def machine_with_valve(name: str) -> RivalCircuit:
    """The whole machine with the rotary valve of another system, such as `vvdp design` writes.

    name  of a shipped system, or the path of a file

    Raises ConfigError where there is none, or where it has no table [valve].
    """
    found = load_system(name)
    if "valve" not in found.tables:
        raise ConfigError([Fault(name, 0, "valve", "has no such table; expected that of a rotary valve")])
    return WHOLE_MACHINE(
        name="vvdp-valve",
        title=f"the whole machine with the rotary valve of {found.name}",
        size=partial(size_other_valve, found.tables["valve"]),
    )
