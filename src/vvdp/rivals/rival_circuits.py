"""The circuits that are compared: a system, how it is sized for a duty, and where its powers are read."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import NamedTuple

from vvdp.base.errors import ConfigError, Fault
from vvdp.rivals.rival_machine import (
    PROGRAM,
    control_begin,
    following_machine,
    machine,
    other_valve_machine,
    published_machine,
    slow_machine,
)
from vvdp.rivals.sizing import (
    LOOP,
    SUFFIXES,
    Sizes,
    Task,
    charge_pressure,
    closed_sizes,
    constant_pressure_sizes,
    independent_unit_sizes,
    independent_valve_sizes,
    load_sensing_sizes,
    one_way_sizes,
    open_sizes,
    size_drawn,
    tank_pressure,
    throttle_sizes,
    unit_sizes,
)
from vvdp.simulation.run import Run
from vvdp.systems.changed import with_numbers
from vvdp.systems.system import System, load_system
from vvdp.valve.rotary import RotaryValve


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

    `size(system, task)` gives the sized one; `program` is that whose command has the reference. `begin` reports a run
    when control began, where that is not at once. `charge` gives the pressure below which, less a margin, its low side
    must not fall; None where nothing charges it. Where `shares` holds, one pump feeds all cylinders of a duty; else
    each has a circuit of its own. `leakage` is the path of its pump's leakage. Where the losses of its pump are
    `measured`, none of them is assumed.
    """

    name: str
    title: str
    system: str
    size: Callable[[System, Task], System]
    sinks: Mapping[Sink, tuple[str, ...]]
    charge: Callable[[System], float] | None = None
    leakage: str = "components.pump.leakage_conductance"
    program: str = LOOP
    begin: Callable[[Run], float] | None = None
    shares: bool = False
    measured: bool = False


def _from_file(sizes: Sizes, shared: tuple[str, ...] = ()) -> Callable[[System, Task], System]:
    """How a drawn circuit is sized, whose control begins at time 0."""
    return partial(size_drawn, sizes, shared)


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


def _valves_of_units(way: str) -> tuple[str, ...]:
    """The valves of the units into or out of the chambers of all cylinders."""
    return tuple(f"{way}_{side}{suffix}_{number}" for side in "ab" for suffix in SUFFIXES for number in range(1, 6))


PUMP_NAMES = ("pump_shaft", "pump", "relief_valve")
SHARED_LINE = ("tank", "pump_line", *PUMP_NAMES)
"""Parts that a circuit has once for all its cylinders."""
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
    RivalCircuit,
    system="displacement-control",
    sinks=MACHINE_SINKS,
    leakage="pump.leakage_conductance",
    program=PROGRAM,
    begin=control_begin,
)
CIRCUITS = (
    WHOLE_MACHINE(
        name="vvdp",
        title="the whole machine: fixed pump of 40 lpm, rotary valve, directional valve, meter-out throttle",
        size=machine,
    ),
    WHOLE_MACHINE(
        name="vvdp-slow",
        title="the same with its pump at 1200 rpm, 26.7 lpm",
        size=slow_machine,
    ),
    WHOLE_MACHINE(
        name="vvdp-following",
        title="the whole machine with a relief valve 20 bar above the line's pressure, at 30 bar at least",
        size=following_machine,
    ),
    WHOLE_MACHINE(
        name="vvdp-chapter-6",
        title="the whole machine as published: flow and meter-out throttle by the laws of chapter 6",
        size=published_machine,
    ),
    RivalCircuit(
        name="throttle",
        title="fixed pump of 40 lpm, relief valve, 4/3 proportional valve",
        system="throttle-control",
        size=_from_file(throttle_sizes, ("tank", "supply", *PUMP_NAMES)),
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
        size=_from_file(one_way_sizes),
        sinks={**ONE_WAY_SINKS, METERING: ("bleed_valve", "directional_valve.edges")},
    ),
    RivalCircuit(
        name="constant-pressure",
        title="variable pump that holds one pressure, compensated throttles, directional valves",
        system="load-sensing",
        size=_from_file(constant_pressure_sizes, SHARED_LINE),
        sinks=LOAD_SENSING_SINKS,
        shares=True,
    ),
    RivalCircuit(
        name="load-sensing",
        title="variable pump 20 bar above the highest load, compensated throttles, directional valves",
        system="load-sensing",
        size=_from_file(load_sensing_sizes, SHARED_LINE),
        sinks=LOAD_SENSING_SINKS,
        shares=True,
    ),
    RivalCircuit(
        name="independent-valves",
        title="variable pump 10 bar above the highest load, four proportional valves at each cylinder",
        system="independent-valves",
        size=_from_file(independent_valve_sizes, SHARED_LINE),
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
        size=_from_file(independent_unit_sizes, SHARED_LINE),
        sinks={
            **ONE_WAY_SINKS,
            METERING: _valves_of_units("supply"),
            RETURN: _valves_of_units("return"),
        },
        shares=True,
    ),
    RivalCircuit(
        name="flow-control-unit",
        title="fixed pump of 40 lpm, relief valve, one unit of five on/off valves that meters in, directional valve",
        system="flow-control-unit",
        size=_from_file(unit_sizes),
        sinks={**ONE_WAY_SINKS, METERING: (*(f"unit_{number}" for number in range(1, 6)), "directional_valve.edges")},
    ),
    RivalCircuit(
        name="linear-valves",
        title="the machine's circuit with fast linear on/off valves at 75 Hz instead of the rotary one",
        system="linear-valves",
        size=_from_file(one_way_sizes),
        sinks={**ONE_WAY_SINKS, SWITCHING: ("switching_valve",)},
    ),
    RivalCircuit(
        name="ideal-pump",
        title="ideal variable pump one way, directional valve, meter-out throttle",
        system="ideal-pump-control",
        size=_from_file(one_way_sizes),
        sinks={**ONE_WAY_SINKS, LEAKAGE: ("pump_leakage", "cylinder")},
        leakage="components.pump_leakage.conductance",
    ),
    RivalCircuit(
        name="measured-pump",
        title="the same with a variable pump that has the losses of a measured one",
        system="measured-pump-control",
        size=_from_file(one_way_sizes),
        sinks=ONE_WAY_SINKS,
        measured=True,
    ),
    RivalCircuit(
        name="digital-pump",
        title="the same with a pump of twelve pistons that deliver or idle one by one",
        system="digital-pump-control",
        size=_from_file(one_way_sizes),
        sinks={**ONE_WAY_SINKS, PISTON_VALVES: ("pump.breathing", "pump.actuation")},
    ),
    RivalCircuit(
        name="shuttle",
        title="closed circuit, overcentre pump, commanded shuttle valve (fig. 1.6)",
        system="shuttle-circuit",
        size=_from_file(closed_sizes),
        sinks={**CLOSED_SINKS, METERING: ("shuttle_valve", "charge_check_a", "charge_check_b")},
        charge=charge_pressure,
        leakage="components.pump_leakage.conductance",
    ),
    RivalCircuit(
        name="pilot-checks",
        title="closed circuit, overcentre pump, pilot-operated checks (fig. 1.7)",
        system="pilot-check-circuit",
        size=_from_file(closed_sizes),
        sinks={**CLOSED_SINKS, METERING: ("pilot_check_a", "pilot_check_b")},
        charge=charge_pressure,
        leakage="components.pump_leakage.conductance",
    ),
    RivalCircuit(
        name="four-valves",
        title="open circuit, overcentre pump, four 2-way valves (fig. 1.8)",
        system="four-valve-circuit",
        size=_from_file(open_sizes),
        sinks={
            RELIEF: ("relief_valve",),
            METERING: (*FOUR_VALVES, *FILLING),
            LEAKAGE: ("pump_leakage", "cylinder"),
        },
        charge=tank_pressure,
        leakage="components.pump_leakage.conductance",
    ),
)
"""All circuits; another one is another value."""


def with_value(circuit: RivalCircuit, name: str, path: str, value: float) -> RivalCircuit:
    """A circuit with another value at a path of its file [SI], under a name of its own."""
    return replace(circuit, name=name, size=partial(_sized_with_value, circuit.size, path, value))


def _sized_with_value(
    size: Callable[[System, Task], System], path: str, value: float, system: System, task: Task
) -> System:
    return size(with_numbers(system, {path: value}), task)


def machine_with_valve(name: str) -> RivalCircuit:
    """The whole machine with the rotary valve of another system, such as `vvdp design` writes.

    name  of a shipped system, or the path of a file

    Raises ConfigError where there is none, or where it has not one rotary valve.
    """
    found = load_system(name)
    parts = found.circuit.network.parts.values()
    valves = {value for part in parts for value in part.values if isinstance(value, RotaryValve)}
    if len(valves) != 1:
        raise ConfigError([Fault(name, 0, "valve", f"has {len(valves)} rotary valves; expected one")])
    return WHOLE_MACHINE(
        name="vvdp-valve",
        title=f"the whole machine with the rotary valve of {found.name}",
        size=partial(other_valve_machine, valves.pop()),
    )
