"""The chamber drive of a system as a test rig of its control: the drive that is and the one that its control knows
may differ, the control is any program, and every case has noise of its own.

Source  ours, docs/models/axial-control.md
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from vvdp.base.kinds import SpeedSignal, TemperatureSignal
from vvdp.base.params import Params, field_kinds
from vvdp.base.tables import build as build_table
from vvdp.components.axial_drive import ChamberDrive
from vvdp.control.chamber import ChamberReading
from vvdp.control.reference import Reference
from vvdp.machines.axial_control import AxialControl, add_chamber_control, add_drive, chamber_loop, known_drive
from vvdp.machines.axial_tables import InitialChamber, PilotSupply
from vvdp.machines.axial_tally import TallySettings, add_tally
from vvdp.network.build import Circuit, build
from vvdp.network.network import Network
from vvdp.programs.axial_loop import PROGRAM, RUN
from vvdp.programs.axial_numbers import Controlled
from vvdp.programs.axial_sensor import AxialSensorTable
from vvdp.programs.chamber_loop import ChamberLoop
from vvdp.sensing.axial_sensor import AxialSensor, Pollution
from vvdp.simulation.model import Case, initial_case
from vvdp.simulation.run import Run, Stepping
from vvdp.systems.system import System

COMPONENTS = {
    "piston": "axial_piston",
    "spring": "axial_spring",
    "friction": "axial_friction",
    "stops": "axial_stops",
    "valve": "pilot_valve",
}
"""Components of the drive, by what they are called here."""
PART = "drive"
"""Name of the part `chamber-drive` in the system of a bench."""


class BenchOperation(Params):
    """What is prescribed from outside: how fast the spool is turned, and the oil's temperature."""

    spool_speed: SpeedSignal
    oil_temperature: TemperatureSignal


@dataclass(frozen=True)
class ChamberBench:
    """A chamber drive with what feeds it, what turns its spool, its sensor's table, where it starts, and how it is
    stepped."""

    parts: ChamberDrive
    pilot: PilotSupply
    operation: BenchOperation
    initial: InitialChamber
    sensor: AxialSensorTable
    helix_length: float
    stepping: Stepping

    def loop(self, control: AxialControl) -> ChamberLoop:
        """The values of a control that knows this drive."""
        return chamber_loop(control, self.parts, self.pilot)


def chamber_bench(system: System) -> ChamberBench:
    """The bench of a system with a part `chamber-drive` called `PART`, its oil that of the circuit."""
    network = system.circuit.network
    nodes: Any = network.nodes
    chamber, slide = nodes[f"{PART}_pilot_chamber"], nodes[f"{PART}_slide"]
    values = {name: network.parts[f"{PART}_{word}"].values[0] for name, word in COMPONENTS.items()}
    parts = ChamberDrive(
        **values,  # type: ignore[arg-type]
        chamber=chamber.values,
        oil=network.oil,
        pressure="initial.chamber_pressure",
        position="initial.axial_position",
    )
    observer: Any = network.programs[f"{PART}_observer"].settings
    return ChamberBench(
        parts=parts,
        pilot=PilotSupply(supply_pressure=nodes["pilot_supply"].pressure, tank_pressure=nodes["pilot_tank"].pressure),
        operation=BenchOperation(spool_speed=nodes["spool"].speed, oil_temperature=network.temperature),
        initial=InitialChamber(axial_position=slide.position, chamber_pressure=chamber.start),
        sensor=_sensor_table(system),
        helix_length=observer.observer.pollution.helix_length,
        stepping=system.stepping,
    )


def _sensor_table(system: System) -> AxialSensorTable:
    """The sensor of the drive as its file has it."""
    path = f"programs.{PART}_sensor"
    entry = system.content["programs"][f"{PART}_sensor"]
    given = {key: value for key, value in entry.items() if key in field_kinds(AxialSensorTable)}
    table, _ = build_table(AxialSensorTable, given, path, system.table, [])
    assert table is not None
    return table


def controlled_circuit(bench: ChamberBench, control: AxialControl, loop: ChamberLoop) -> Circuit:
    """The drive of a bench under a control with the values `loop`, and the tally of its results."""
    operation = bench.operation
    net = Network(
        bench.parts.oil,
        temperature=operation.oil_temperature,
        operation=operation,
        pilot=bench.pilot,
        initial=bench.initial,
    )
    net.driven_shaft("spool", operation.spool_speed)
    add_drive(net, bench.parts, bench.pilot)
    add_chamber_control(net, control, loop, "spool")
    settings = TallySettings(
        drive=known_drive(bench.parts, bench.pilot),
        gains=loop.gains,  # type: ignore[attr-defined]
        reference=loop.reference,
        wanted=loop.wanted,
        sample_period=loop.observer.sample_period,
        stop_position=loop.observer.stop_position,
    )
    add_tally(net, settings)
    return build(net)


def seeded_case(circuit: Circuit, seed: int) -> Case:
    """The case of a controlled circuit whose sensor has noise, and a place of its periodic sensor error on the
    spool, of a seed.
    """
    loop = circuit.case.settings[PROGRAM]
    turned = float(np.random.default_rng([seed, 4]).uniform(0.0, 2.0 * np.pi))
    sensor = replace(turn_sensor(loop.sensor, turned), instrument=replace(loop.sensor.instrument, seed=float(seed)))
    settings = {**circuit.case.settings, PROGRAM: replace(loop, sensor=sensor)}
    return initial_case(circuit.model, type(circuit.case.command), circuit.case.params, settings)


def turn_sensor(sensor: AxialSensor, angle: float) -> AxialSensor:
    """The sensor on a spool whose polluted end is turned by an angle [rad]."""
    return replace(sensor, near=turn_pollution(sensor.near, angle), far=turn_pollution(sensor.far, angle))


def turn_pollution(pollution: Pollution, angle: float) -> Pollution:
    """The periodic sensor error of a spool whose end is turned by an angle [rad]."""
    phases = tuple(phase + (g + 1.0) * angle for g, phase in enumerate(pollution.phases))
    return replace(pollution, phases=phases)


def rows_under_control(run: Run, period: float) -> Controlled:
    """The rows of a run on a bench at samples, every `period` [s], at which its drive is controlled.

    A row at a sample has the command of the sample before, so that commands are read from the next row. Samples whose
    next one is not recorded are left out.
    """
    at_sample = np.flatnonzero(np.abs(run.times / period - np.round(run.times / period)) < 1e-6)
    now, after = at_sample[:-1], at_sample[1:]
    shown, state = run.command.axial, run.state
    is_next = np.abs(run.times[after] - run.times[now] - period) < 1e-6 * period
    is_used = is_next & (shown.stage[after] == RUN)
    now, after = now[is_used], after[is_used]
    return Controlled(
        times=run.times[now],
        true=ChamberReading(state.slide.position[now], state.slide.velocity[now], state.pilot_chamber[now]),
        shown=type(shown)(*(column[after] for column in shown)),
        reference=Reference(*(column[after] for column in run.memory[PROGRAM].reference)),
    )
