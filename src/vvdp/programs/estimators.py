"""Estimators and maps as programs: load observer, average over a PWM period, flow map."""

from typing import NamedTuple

import numpy as np

from vvdp.base.kinds import Area, Count, DutyRatio, Flow, Force, Fraction, Number, Position, Pressure, Speed, Velocity
from vvdp.base.params import Params
from vvdp.base.rules import require_positive
from vvdp.base.units import ATMOSPHERE
from vvdp.control.flow_map import FlowMap, duty_for_flow
from vvdp.estimation.load_observer import LoadMemory, LoadObserver, load_observer_start, load_observer_step
from vvdp.estimation.period_average import LONGEST, AverageMemory, average_start, average_step, pwm_window
from vvdp.network.program import ProgramType
from vvdp.programs.controllers import Value
from vvdp.programs.generic import GenericProgram
from vvdp.programs.quantities import Input


class CylinderLoad(LoadObserver):
    """A load observer and the areas on which the two pressures act; b is 0 for a plunger."""

    area_a: Area
    area_b: Area = 0.0


class Moved(NamedTuple):
    """The position of the rod and the pressures, absolute."""

    position: Position
    pressure_a: Pressure
    pressure_b: Pressure = ATMOSPHERE


class LoadSeen(NamedTuple):
    """Estimated position and velocity, and the force of the load in the direction of motion."""

    position: Position
    velocity: Velocity
    load_force: Force


class LoadObserverMemory(NamedTuple):
    """The memory of the observer, and whether there was a sample (1)."""

    observer: LoadMemory
    begun: Fraction


def observer_start(settings: CylinderLoad) -> LoadObserverMemory:
    """Before the first sample."""
    return LoadObserverMemory(load_observer_start(0.0, 0.0), 0.0)


def observer_step(
    t: float, memory: LoadObserverMemory, reading: Moved, settings: CylinderLoad
) -> tuple[LoadObserverMemory, LoadSeen]:
    """Velocity and load of a cylinder from its position and pressures; begins at rest with the load in balance."""
    force = settings.area_a * (reading.pressure_a - ATMOSPHERE) - settings.area_b * (reading.pressure_b - ATMOSPHERE)
    observer = memory.observer
    if memory.begun < 0.5:
        observer = load_observer_start(reading.position, -force)
    else:
        observer = load_observer_step(observer, reading.position, force, settings)
    return LoadObserverMemory(observer, 1.0), LoadSeen(observer.position, observer.velocity, observer.load_force)


class Sections(Params):
    """PWM periods per revolution: the sections of a spool; 1 for pulses at `speed`."""

    sections: Count

    def check(self) -> None:
        require_positive(self, "sections")


class Switching(NamedTuple):
    """Averaged value, and the speed that gives the length of the period."""

    reads: Input
    speed: Speed


class PeriodMemory(NamedTuple):
    """The last samples, the time of the last one, and whether there was one (1)."""

    averages: AverageMemory
    time: Number
    begun: Fraction


def period_start(settings: Sections) -> PeriodMemory:
    """Before the first sample."""
    return PeriodMemory(average_start(1), 0.0, 0.0)


def period_step(t: float, memory: PeriodMemory, reading: Switching, settings: Sections) -> tuple[PeriodMemory, Value]:
    """Mean over the last PWM period, up to 64 samples; at time t [s]."""
    window = float(LONGEST)
    if memory.begun > 0.5:
        window = pwm_window(reading.speed, settings.sections, t - memory.time)
    averages, means = average_step(memory.averages, np.array([reading.reads]), window)
    return PeriodMemory(averages, t, 1.0), Value(means[0])


class Delivery(NamedTuple):
    """The flow that is to be delivered, and the pressure against which, absolute."""

    flow: Flow
    line_pressure: Pressure


class DutyCommand(NamedTuple):
    """The duty ratio of the valve."""

    duty_ratio: DutyRatio


def flow_map_step(t: float, memory: NamedTuple, reading: Delivery, settings: FlowMap) -> tuple[NamedTuple, DutyCommand]:
    """Duty ratio that delivers a flow against a pressure, by a map of the valve."""
    return memory, DutyCommand(duty_for_flow(reading.flow, reading.line_pressure, settings))


LOAD_OBSERVER = ProgramType(observer_step, Moved, LoadSeen(0.0, 0.0, 0.0), CylinderLoad, observer_start)
PERIOD_AVERAGE = GenericProgram(ProgramType(period_step, Switching, Value(0.0), Sections, period_start))
FLOW_MAP = ProgramType(flow_map_step, Delivery, DutyCommand(0.0), FlowMap)
