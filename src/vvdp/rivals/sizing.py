"""How a rival circuit is sized for a duty: by values at the paths of its file, and a copy for each further cylinder.

Source  ours, docs/circuits-compared.md
"""

import math
from collections.abc import Callable, Collection, Mapping
from typing import Any, NamedTuple

from vvdp.hydraulics.cylinder import Cylinder
from vvdp.hydraulics.flow_control_unit import UnitValve
from vvdp.machines.cylinder_load import LOW_SIDE, start_at_rest
from vvdp.machines.duties import Duty
from vvdp.network.nodes import Tank
from vvdp.systems.changed import Number, with_copies, with_numbers
from vvdp.systems.part_files import GROUPS
from vvdp.systems.system import System

LOOP = "loop"
"""Name of the program of a position loop."""
SUFFIXES = ("", "_second", "_third")
"""Suffixes of the names of the first, second and third cylinder and of all that belongs to it."""
SENSED = ("second_pressure", "third_pressure")
"""Inputs of a load-sensing pump for the pressures of further cylinders."""
SAFETY = 20e5
"""By how much the relief valve of a pump that holds its pressure lies above that [Pa]."""

Numbers = Mapping[str, Number | Mapping[str, Any]]
"""Values by their paths in a file [SI]."""
Sizes = Callable[[System, Duty], Numbers]
"""Values of a circuit that follow from a duty, besides the cycle."""


class Task(NamedTuple):
    """Task that a circuit is sized for: a duty that begins at `begin` [s], goes through `rounds`, behind poles of
    `rate` [1/s]."""

    duty: Duty
    begin: float
    rounds: int
    rate: float


def size_drawn(sizes: Sizes, shared: Collection[str], system: System, task: Task) -> System:
    """A drawn circuit sized for a task, with as many cylinders as its duty has if these share a supply.

    shared  names of the parts that all cylinders share; empty if each has a circuit of its own

    Raises ConfigError where it cannot follow.
    """
    found = with_numbers(system, {**_cycle_numbers(task.duty, task.rate), **sizes(system, task.duty)})
    further = dict(zip(SUFFIXES[1:], task.duty.further if shared else (), strict=False))
    if not further:
        return found
    content, numbers = found.table.content, dict[str, Any]()
    names = [name for group in GROUPS for name in content[group] if name not in shared]
    found = with_copies(found, names, list(further))
    for sensed, (suffix, each) in zip(SENSED, further.items(), strict=False):
        numbers |= _cycle_numbers(each, task.rate, suffix) | _start_numbers(found, each, suffix=suffix)
        if (source := content["components"]["pump"].get("load_pressure")) is not None:
            head, _, key = source["from"].partition(".")
            numbers[f"components.pump.{sensed}"] = {"from": f"{head}{suffix}.{key}"}
    return with_numbers(found, numbers)


def _cycle_numbers(duty: Duty, rate: float, suffix: str = "") -> dict[str, Any]:
    cycle, loop = duty.cycle, f"programs.{LOOP}{suffix}"
    return {
        f"{loop}.times": cycle.times,
        f"{loop}.positions": cycle.positions,
        f"{loop}.forces": cycle.forces,
        f"{loop}.filter_rate": rate,
    }


def _start_numbers(
    system: System, duty: Duty, level: float | None = None, supply: float | None = None, suffix: str = ""
) -> dict[str, Any]:
    """Where a cylinder and what feeds it start: at rest, its lower side at `level` [Pa]; see `start_at_rest`."""
    network = system.circuit.network
    cylinder, reference = known_cylinder_of(system), network.oil.reference_pressure
    start = start_at_rest(duty.cycle, cylinder, reference, reference + LOW_SIDE if level is None else level, supply)
    supplies = ("supply", "charge_line", *(() if suffix else ("pump_line",)))
    return {
        f"nodes.rod{suffix}.position": start.position,
        f"nodes.chamber_a{suffix}.start": start.pressure_a,
        f"nodes.chamber_b{suffix}.start": start.pressure_b,
        **{f"nodes.{name}{suffix}.start": start.supply_pressure for name in supplies if name + suffix in network.nodes},
    }


def known_cylinder_of(system: System) -> Cylinder:
    """The cylinder of a circuit."""
    found = system.circuit.network.parts["cylinder"].values[0]
    assert isinstance(found, Cylinder)
    return found


def relief_of(system: System, duty: Duty) -> float:
    """The setting of a relief valve for a duty, absolute [Pa]."""
    return system.circuit.network.oil.reference_pressure + duty.relief_pressure


def throttle_sizes(system: System, duty: Duty) -> Numbers:
    """A fixed pump at its relief valve."""
    relief = relief_of(system, duty)
    return {"components.relief_valve.cracking_pressure": relief, **_start_numbers(system, duty, supply=relief)}


def one_way_sizes(system: System, duty: Duty) -> Numbers:
    """A pump that gives flow one way, and a meter-out throttle."""
    return {
        "components.relief_valve.cracking_pressure": relief_of(system, duty),
        "components.directional_valve.return_conductance": duty.return_conductance,
        f"programs.{LOOP}.valve_conductance": duty.return_conductance,
        **_start_numbers(system, duty),
    }


def unit_sizes(system: System, duty: Duty) -> Numbers:
    """The same with a digital flow control unit behind a pump at its relief valve."""
    relief = relief_of(system, duty)
    return {
        **one_way_sizes(system, duty),
        "nodes.pump_line.start": relief,
        f"programs.{LOOP}.pump_pressure": relief,
    }


def _controlled_pump_sizes(system: System, duty: Duty) -> dict[str, Any]:
    """The pump's pressure ends where relief valves of others open; its own one opens 20 bar above."""
    highest = relief_of(system, duty)
    return {
        "components.relief_valve.cracking_pressure": highest + SAFETY,
        "components.pump.highest_pressure": highest,
    }


def load_sensing_sizes(system: System, duty: Duty) -> Numbers:
    """A controlled pump, and a meter-out throttle."""
    return {**one_way_sizes(system, duty), **_controlled_pump_sizes(system, duty)}


def constant_pressure_sizes(system: System, duty: Duty) -> Numbers:
    """The same with a pump that holds the pressure at which load sensing ends: its margin is as large."""
    return {**load_sensing_sizes(system, duty), "components.pump.margin": relief_of(system, duty)}


def independent_valve_sizes(system: System, duty: Duty) -> Numbers:
    """The valves out of the chambers are as large as the meter-out throttle of other circuits."""
    return {
        **_controlled_pump_sizes(system, duty),
        **{f"components.return_valve_{side}.conductance": duty.return_conductance for side in "ab"},
        f"programs.{LOOP}.return_step": duty.return_conductance,
        **_start_numbers(system, duty),
    }


def independent_unit_sizes(system: System, duty: Duty) -> Numbers:
    """The units out of the chambers are as large with all their valves open."""
    smallest, settings = system.circuit.network.parts["return_a_1"].values[0], loop_settings(system)
    assert isinstance(smallest, UnitValve)
    step = duty.return_conductance / settings.highest
    return {
        **_controlled_pump_sizes(system, duty),
        **{f"components.return_{side}.rated_flow": step * math.sqrt(smallest.rated_drop) for side in "ab"},
        f"programs.{LOOP}.return_step": step,
        **_start_numbers(system, duty),
    }


def loop_settings(system: System) -> Any:
    """The settings of the position loop of a drawn circuit."""
    return system.circuit.network.programs[LOOP].settings


def closed_sizes(system: System, duty: Duty) -> Numbers:
    """A closed circuit, with relief valves at both chambers and a charge line."""
    charge = charge_pressure(system)
    return {
        **{f"components.relief_valve_{side}.cracking_pressure": relief_of(system, duty) for side in "ab"},
        **_start_numbers(system, duty, charge, charge),
    }


def open_sizes(system: System, duty: Duty) -> Numbers:
    """An open circuit at a tank under pressure."""
    return {
        "components.relief_valve.cracking_pressure": relief_of(system, duty),
        **_start_numbers(system, duty, tank_pressure(system)),
    }


def charge_pressure(system: System) -> float:
    """The charge pressure of a closed circuit, absolute [Pa]."""
    valve: Any = system.circuit.network.parts["charge_relief_valve"].values[0]
    return float(valve.cracking_pressure)


def tank_pressure(system: System) -> float:
    """The pressure of the tank of a circuit, absolute [Pa]."""
    tank = system.circuit.network.nodes["tank"]
    assert isinstance(tank, Tank)
    return float(tank.pressure.extremes[0])
