"""The whole machine among the rival circuits: how it follows a duty cycle, at its own pump speed or a slower one."""

import json
from collections.abc import Callable
from typing import Any

import numpy as np

from vvdp.base.errors import RunError
from vvdp.base.params import field_kinds, field_values
from vvdp.control.duty_cycle import cycle_period, resting_pressures
from vvdp.machines.duties import Duty
from vvdp.programs.machine.phases import CONTROL
from vvdp.programs.position_loop import LoopTable
from vvdp.rivals.sizing import Numbers, Task, known_cylinder_of, loop_settings
from vvdp.simulation.run import Run
from vvdp.systems.changed import setting_text, with_numbers, with_tables
from vvdp.systems.system import System, load_system
from vvdp.valve.rotary import RotaryValve

PROGRAM = "displacement"
"""Name of the program that leads the machine."""
LOW_SIDE = 3e5
"""At which the side that carries nothing starts, gauge [Pa]."""
LEAST_BOUND, BELOW_RELIEF = 50e5, 10e5
"""Upper bound of the chambers' pressures at least, gauge, and how far below the relief valve it else is [Pa]."""
SLOW_SPEED, SLOW_FLOW = 1200.0 * np.pi / 30.0, 40.0 / 60e3 * 1200.0 / 1800.0
"""A pump speed at which the valve still spins itself, at 30 Hz, and what the pump gives then [rad/s, m^3/s]."""

RIVAL = "ideal-pump-control"
"""The system whose position loop leads the machine."""

FOLLOWING = {"margin": "20 bar", "least_pressure": "30 bar"}
"""Of a relief valve that follows the line: above its pressure, and at least."""

Size = Callable[[System, Task], System]


def control_begin(run: Run) -> float:
    """When control of the cylinder began in a run of the whole machine [s]. Raises RunError where it never did."""
    phase = getattr(run.command, PROGRAM).phase
    controlled = np.flatnonzero(phase == CONTROL)
    if not controlled.size:
        raise RunError(f"the machine was not ready within {run.end:g} s")
    return float(run.times[controlled[0]])


def machine(system: System, task: Task) -> System:
    """The whole machine, led by the position loop of its rivals; else as `published_machine`."""
    values = field_values(LoopTable, loop_settings(load_system(RIVAL)).table)
    kinds = field_kinds(LoopTable)
    loop = {key: json.loads(setting_text(value, kinds[key])) for key, value in values.items()}
    return with_tables(published_machine(system, task), {"loop": loop})


def published_machine(system: System, task: Task) -> System:
    """The whole machine with its own laws, sized for a duty.

    It is not supervised: the limits of its supervision are those of the shipped cycle.
    """
    duty, reference = task.duty, system.circuit.network.oil.reference_pressure
    cycle, relief = duty.cycle, reference + duty.relief_pressure
    a, b = resting_pressures(cycle.forces[0], LOW_SIDE, known_cylinder_of(system))
    positions = (*cycle.positions[:-1], cycle.positions[0])
    numbers: Numbers = {
        "reference.filter_rate": task.rate,
        "relief_valve.cracking_pressure": relief,
        "directional_valve.return_conductance": duty.return_conductance,
        "pressure_bounds.highest_pressure": reference + max(LEAST_BOUND, duty.relief_pressure - BELOW_RELIEF),
        "belief.relief_pressure": relief,
        "belief.return_conductance": duty.return_conductance,
        "belief.load_force": cycle.forces[0],
        "operation.load_force": load_force(duty, task),
        "initial.pressure_a": reference + a,
        "initial.pressure_b": reference + b,
        "initial.cylinder_position": positions[0],
    }
    own = {
        "times": [f"{time!r} s" for time in cycle.times],
        "positions": [f"{position!r} m" for position in positions],
        "repeats": "1",
    }
    return with_tables(with_numbers(system, numbers), {"cycle": own, "supervision": None})


def slow_machine(system: System, task: Task) -> System:
    """The same with a pump that turns more slowly, as little flow as the valve still spins itself with."""
    slow = {"operation.pump_speed": SLOW_SPEED, "flow_split.largest_flow": SLOW_FLOW}
    return with_numbers(machine(system, task), slow)


def following_machine(system: System, task: Task) -> System:
    """The same as the whole machine with a relief valve that follows the line's pressure."""
    path = "components.relief_valve"
    following: dict[str, Any] = {f"{path}.type": "load-relief-valve", f"{path}.pilot": "line"}
    return with_numbers(machine(system, task), following | {f"relief_valve.{k}": v for k, v in FOLLOWING.items()})


def other_valve_machine(valve: RotaryValve, system: System, task: Task) -> System:
    """The same as the whole machine with another rotary valve."""
    values = {f"valve.{key}": value for key, value in field_values(RotaryValve, valve).items()}
    return with_numbers(machine(system, task), values)


def load_force(duty: Duty, task: Task) -> float | dict[str, Any]:
    """The force of a duty on the rod over the time of a run, its first value held until control begins [N]."""
    cycle, period = duty.cycle, cycle_period(duty.cycle)
    if len(set(cycle.forces)) == 1:
        return cycle.forces[0]
    times = [task.begin + k * period + t for k in range(task.rounds) for t in cycle.times]
    return {"table": [[f"{t!r} s", f"{f!r} N"] for t, f in zip(times, cycle.forces * task.rounds, strict=True)]}
