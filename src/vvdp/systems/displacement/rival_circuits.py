"""The circuits that are compared: a system, how it is sized for a duty, and where its powers are read."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

from vvdp.systems.displacement.cylinder_load import InitialCylinder
from vvdp.systems.displacement.duties import Duty
from vvdp.systems.system import System, load_system

LOW_SIDE = 5e5
"""At which a side that carries nothing starts where no supply holds it, gauge [Pa]."""


class Sink(NamedTuple):
    """Where power is lost: a key of the table, and what a person calls it."""

    key: str
    label: str


RELIEF = Sink("loss_relief_W", "relief valve")
METERING = Sink("loss_valves_W", "valves at the cylinder")
RETURN = Sink("loss_return_W", "throttle in the return")
SWITCHING = Sink("loss_rotary_W", "rotary valve")
LEAKAGE = Sink("loss_leakage_W", "leakage")
CHARGE = Sink("loss_charge_W", "charge relief")
SINKS = (RELIEF, METERING, RETURN, SWITCHING, LEAKAGE, CHARGE)
"""Where power is lost before the rod, in the order in which it is shown."""

Tables = Mapping[str, Any]


@dataclass(frozen=True)
class RivalCircuit:
    """A circuit: the system that is run, what of its tables follows the duty, and which keys of a run's summary make a
    sink.

    `charge` gives the pressure below which, less a margin, its low side must not fall; None where nothing charges it.
    """

    name: str
    title: str
    system: str
    size: Callable[[Tables, Duty], Tables]
    sinks: Mapping[Sink, tuple[str, ...]]
    charge: Callable[[Tables], float] | None = None

    def system_for(self, duty: Duty) -> System:
        """The system for a duty, its cylinder at rest under the first force."""
        system = load_system(self.system)
        tables = {**system.tables, "duty_cycle": duty.cycle, **self.size(system.tables, duty)}
        return system.with_tables(tables)


def start_of(tables: Tables, duty: Duty, level: float, supply: float | None = None) -> InitialCylinder:
    """Where a run starts: at rest under the first force, the lower side at `level`, absolute [Pa].

    supply  pressure of what feeds the cylinder, absolute [Pa]; that of the higher side where none is given
    """
    cylinder, reference = tables["cylinder"], tables["oil"].reference_pressure
    low, force = level - reference, duty.cycle.forces[0]
    a, b = low, (low * cylinder.area_a + force) / cylinder.area_b
    if b < low:
        a, b = (low * cylinder.area_b - force) / cylinder.area_a, low
    return InitialCylinder(
        position=duty.cycle.positions[0],
        pressure_a=reference + a,
        pressure_b=reference + b,
        supply_pressure=reference + max(a, b) if supply is None else supply,
    )


def _relief(tables: Tables, name: str, duty: Duty) -> Any:
    return replace(tables[name], cracking_pressure=tables["oil"].reference_pressure + duty.relief_pressure)


def _size_throttle(tables: Tables, duty: Duty) -> Tables:
    relief, reference = _relief(tables, "relief_valve", duty), tables["oil"].reference_pressure
    start = start_of(tables, duty, reference + LOW_SIDE, relief.cracking_pressure)
    return {"relief_valve": relief, "initial": start}


def _size_one_way(tables: Tables, duty: Duty) -> Tables:
    valve = replace(tables["directional_valve"], return_conductance=duty.return_conductance)
    start = start_of(tables, duty, tables["oil"].reference_pressure + LOW_SIDE)
    return {"relief_valve": _relief(tables, "relief_valve", duty), "directional_valve": valve, "initial": start}


def _size_closed(tables: Tables, duty: Duty) -> Tables:
    charge = charge_pressure(tables)
    return {"relief_valves": _relief(tables, "relief_valves", duty), "initial": start_of(tables, duty, charge, charge)}


def _size_open(tables: Tables, duty: Duty) -> Tables:
    return {
        "relief_valve": _relief(tables, "relief_valve", duty),
        "initial": start_of(tables, duty, reservoir_pressure(tables)),
    }


def charge_pressure(tables: Tables) -> float:
    """The charge pressure of a closed circuit, absolute [Pa]."""
    return float(tables["charge_relief_valve"].cracking_pressure)


def reservoir_pressure(tables: Tables) -> float:
    """The pressure of the reservoir of an open circuit, absolute [Pa]."""
    return float(tables["reservoir"].pressure.extremes[0])


CLOSED_SINKS: Mapping[Sink, tuple[str, ...]] = {
    RELIEF: ("loss_relief_valve_a_W", "loss_relief_valve_b_W"),
    LEAKAGE: ("loss_pump_leakage_W", "loss_cylinder_W"),
    CHARGE: ("loss_charge_relief_valve_W",),
}
FOUR_VALVES = tuple(f"loss_{way}_valve_{side}_W" for way in ("supply", "return") for side in "ab")
FILLING = tuple(f"loss_anti_cavitation_{where}_W" for where in ("supply", "a", "b"))

CIRCUITS = (
    RivalCircuit(
        name="throttle",
        title="fixed pump of 40 lpm, relief valve, 4/3 proportional valve",
        system="throttle-control",
        size=_size_throttle,
        sinks={
            RELIEF: ("loss_relief_valve_W",),
            METERING: ("loss_directional_valve_W",),
            LEAKAGE: ("loss_pump_W", "loss_cylinder_W"),
        },
    ),
    RivalCircuit(
        name="ideal-pump",
        title="ideal variable pump one way, directional valve, throttle in the return",
        system="ideal-pump-control",
        size=_size_one_way,
        sinks={
            RELIEF: ("loss_relief_valve_W",),
            METERING: ("loss_directional_valve_edges_W",),
            RETURN: ("loss_directional_valve_return_throttle_W",),
            LEAKAGE: ("loss_pump_leakage_W", "loss_cylinder_W"),
        },
    ),
    RivalCircuit(
        name="shuttle",
        title="closed circuit, pump over centre, commanded shuttle valve (fig. 1.6)",
        system="shuttle-circuit",
        size=_size_closed,
        sinks={**CLOSED_SINKS, METERING: ("loss_shuttle_valve_W", "loss_charge_check_a_W", "loss_charge_check_b_W")},
        charge=charge_pressure,
    ),
    RivalCircuit(
        name="pilot-checks",
        title="closed circuit, pump over centre, pilot-operated checks (fig. 1.7)",
        system="pilot-check-circuit",
        size=_size_closed,
        sinks={**CLOSED_SINKS, METERING: ("loss_pilot_check_a_W", "loss_pilot_check_b_W")},
        charge=charge_pressure,
    ),
    RivalCircuit(
        name="four-valves",
        title="open circuit, pump over centre, four 2-way valves (fig. 1.8)",
        system="four-valve-circuit",
        size=_size_open,
        sinks={
            RELIEF: ("loss_relief_valve_W",),
            METERING: (*FOUR_VALVES, *FILLING),
            LEAKAGE: ("loss_pump_leakage_W", "loss_cylinder_W"),
        },
        charge=reservoir_pressure,
    ),
)
"""All circuits; another one is another value."""
