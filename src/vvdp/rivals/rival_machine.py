"""The whole machine among the rival circuits: how it follows a duty cycle, at its own pump speed or a slower one."""

from collections.abc import Callable, Mapping
from dataclasses import fields, replace
from typing import Any

import numpy as np

from vvdp.base.errors import RunError
from vvdp.base.signal import Signal, constant, table
from vvdp.control.duty_cycle import cycle_period, resting_pressures
from vvdp.hydraulics.relief_valve import LoadReliefValve
from vvdp.programs.machine.cycle import OwnCycle
from vvdp.machines.duties import Duty
from vvdp.programs.machine.loop import PROGRAM
from vvdp.programs.machine.phases import CONTROL
from vvdp.rivals.sizing import loop_settings
from vvdp.simulation.run import Run
from vvdp.systems.system import load_system
from vvdp.valve.rotary import RotaryValve

LOW_SIDE = 3e5
"""At which the side that carries nothing starts, gauge [Pa]."""
LEAST_BOUND, BELOW_RELIEF = 50e5, 10e5
"""Upper bound of the chambers' pressures at least, gauge, and how far below the relief valve it else is [Pa]."""
SLOW_SPEED, SLOW_FLOW = 1200.0 * np.pi / 30.0, 40.0 / 60e3 * 1200.0 / 1800.0
"""A pump speed at which the valve still spins itself, at 30 Hz, and what the pump gives then [rad/s, m^3/s]."""

RIVAL = "ideal-pump-control"
"""The system whose position loop leads the machine."""

MARGIN, LEAST_SETTING = 20e5, 30e5
"""Of a relief valve that follows the line: above its pressure, and gauge at least [Pa]."""

Tables = Mapping[str, Any]
MachineSize = Callable[[Tables, Duty, float, int], Tables]
"""The tables of the whole machine that follow a duty that begins with control at a time [s], for some rounds."""


def control_begin(run: Run) -> float:
    """When control of the cylinder began in a run of the whole machine [s]. Raises RunError where it never did."""
    phase = getattr(run.command, PROGRAM).phase
    controlled = np.flatnonzero(phase == CONTROL)
    if not controlled.size:
        raise RunError(f"the machine was not ready within {run.end:g} s")
    return float(run.times[controlled[0]])


def size_machine(tables: Tables, duty: Duty, begin: float, rounds: int) -> Tables:
    """The tables of the whole machine, led by the position loop of its rivals; else as `size_published_machine`."""
    return {**size_published_machine(tables, duty, begin, rounds), "loop": loop_settings(load_system(RIVAL)).table}


def size_published_machine(tables: Tables, duty: Duty, begin: float, rounds: int) -> Tables:
    """The tables of the whole machine with its own laws for a duty that begins with control at `begin` [s].

    It is not supervised: the limits of its supervision are those of the shipped cycle.
    """
    reference, cycle = tables["oil"].reference_pressure, duty.cycle
    relief = reference + duty.relief_pressure
    highest = max(LEAST_BOUND, duty.relief_pressure - BELOW_RELIEF)
    a, b = resting_pressures(cycle.forces[0], LOW_SIDE, tables["cylinder"])
    positions = (*cycle.positions[:-1], cycle.positions[0])
    belief = replace(
        tables["belief"],
        relief_pressure=relief,
        return_conductance=duty.return_conductance,
        load_force=cycle.forces[0],
    )
    return {
        "relief_valve": replace(tables["relief_valve"], cracking_pressure=relief),
        "directional_valve": replace(tables["directional_valve"], return_conductance=duty.return_conductance),
        "pressure_bounds": replace(tables["pressure_bounds"], highest_pressure=highest + reference),
        "belief": belief,
        "supervision": None,
        "cycle": OwnCycle(times=cycle.times, positions=positions, repeats=1.0),
        "operation": replace(tables["operation"], load_force=load_signal(duty, begin, rounds)),
        "initial": replace(
            tables["initial"], pressure_a=reference + a, pressure_b=reference + b, cylinder_position=positions[0]
        ),
    }


def size_slow_machine(tables: Tables, duty: Duty, begin: float, rounds: int) -> Tables:
    """The same with a pump that turns more slowly, as little flow as the valve still spins itself with."""
    found = size_machine(tables, duty, begin, rounds)
    return {
        **found,
        "operation": replace(found["operation"], pump_speed=constant(SLOW_SPEED)),
        "flow_split": replace(tables["flow_split"], largest_flow=SLOW_FLOW),
    }


def size_following_machine(tables: Tables, duty: Duty, begin: float, rounds: int) -> Tables:
    """The same as the whole machine with a relief valve that follows the line's pressure."""
    found = size_machine(tables, duty, begin, rounds)
    relief, reference = found["relief_valve"], tables["oil"].reference_pressure
    known = {each.name: getattr(relief, each.name) for each in fields(relief)}
    following = LoadReliefValve(**known, margin=MARGIN, least_pressure=reference + LEAST_SETTING)
    return {**found, "relief_valve": following}


def size_other_valve(valve: RotaryValve, tables: Tables, duty: Duty, begin: float, rounds: int) -> Tables:
    """The same as the whole machine with another rotary valve."""
    return {**size_machine(tables, duty, begin, rounds), "valve": valve}


def load_signal(duty: Duty, begin: float, rounds: int) -> Signal:
    """The force of a duty on the rod over the time of a run, its first value held until `begin` [s]."""
    cycle, period = duty.cycle, cycle_period(duty.cycle)
    if len(set(cycle.forces)) == 1:
        return constant(cycle.forces[0])
    times = [begin + k * period + t for k in range(rounds) for t in cycle.times]
    return table(times, cycle.forces * rounds)
