"""Circuits of the comparison of controllers: the shipped chamber drive with other values, and its results added up."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from vvdp.base.arrays import Array
from vvdp.machines.drive_tally import TALLY, Tally, TallySettings
from vvdp.network.build import Circuit, build
from vvdp.programs.spool_report import rows_at_samples
from vvdp.sensing.axial_sensor import AxialSensor, Pollution
from vvdp.simulation.layout import as_memory
from vvdp.simulation.model import Case, initial_case
from vvdp.simulation.run import Run
from vvdp.systems.changed import with_numbers
from vvdp.systems.system import System, load_system

SENSOR, OBSERVER, LAW, RESULTS = "drive_sensor", "drive_observer", "drive_law", "tally"
"""Names of programs: those of the drive, and the one that adds up."""
READS = {
    "position": "drive_slide.position",
    "velocity": "drive_slide.velocity",
    "pressure": "drive_pilot_chamber.pressure",
    "reference": "drive_reference.value",
    "reference_velocity": "drive_reference.rate",
    "reference_acceleration": "drive_reference.second_derivative",
    "reference_jerk": "drive_reference.third_derivative",
    "command": f"{LAW}.command",
    "believed": f"{OBSERVER}.position",
    "released": f"{OBSERVER}.released",
}
"""Inputs of the program that adds up."""


def drawn_loop(values: Mapping[str, Any]) -> System:
    """The drive with other values, by their paths, and without friction, as the source and the controllers have it.

    Raises ConfigError.
    """
    return with_numbers(load_system("axial-chamber"), {"parts.drive.viscous_friction": "0 N*s/m", **values})


def law_of(system: System) -> Any:
    """The settings of the law of a drive."""
    return system.circuit.network.programs[LAW].settings


def with_tally(system: System) -> Circuit:
    """The circuit of a drive, and the program that adds up its results, with the oil as it truly is."""
    network, period = system.circuit.network, system.stepping.sample_period
    law = law_of(system)
    oil = replace(law.drive.oil, air_fraction=network.oil.air_fraction)
    settings = TallySettings(drive=replace(law.drive, oil=oil), gains=law.gains, sample_period=period)
    network.program(RESULTS, TALLY, settings, reads=READS, period=period)
    return build(network)


def seeded_case(circuit: Circuit, seed: int) -> Case:
    """The case of a circuit whose sensor has the noise, and the place of its periodic error on the spool, of a seed."""
    sensor = circuit.case.settings[SENSOR]
    turned = float(np.random.default_rng([seed, 4]).uniform(0.0, 2.0 * np.pi))
    seeded = replace(turn_sensor(sensor, turned), instrument=replace(sensor.instrument, seed=float(seed)))
    settings = {**circuit.case.settings, SENSOR: seeded}
    return initial_case(circuit.model, type(circuit.case.command), circuit.case.params, settings)


def turn_sensor(sensor: AxialSensor, angle: float) -> AxialSensor:
    """The sensor on a spool whose polluted end is turned by an angle [rad]."""
    return replace(sensor, near=turn_pollution(sensor.near, angle), far=turn_pollution(sensor.far, angle))


def turn_pollution(pollution: Pollution, angle: float) -> Pollution:
    """The periodic sensor error of a spool whose end is turned by an angle [rad]."""
    phases = tuple(phase + (g + 1.0) * angle for g, phase in enumerate(pollution.phases))
    return replace(pollution, phases=phases)


def tally_of(case: Case, memories: Array) -> Tally:
    """What was added up in a run of a case, from the numbers of its memories at the end, shape (n,)."""
    found: Tally = as_memory(case, memories)[RESULTS]
    return found


def errors_under_control(run: Run, circuit: Circuit, period: float) -> tuple[Array, Array]:
    """Times [s] of the samples of a run at which its drive is controlled, and position minus reference at them [m].

    period  of the samples [s]
    """
    now, after = rows_at_samples(run, circuit.network.programs[LAW], period)
    return run.times[now], getattr(run.command, RESULTS).error[after]
