"""Displacement control as chapter 6 has it: a pump as a lagging source, ideal directional valve, throttled return.

`chapter6` returns the `Network` that a system file names as its circuit; its argument is the record of its tables.
"""

from dataclasses import dataclass

from vvdp.base.kinds import BulkModulus, Force, ForceSignal, Mass, Position, Pressure, TemperatureSignal, Time
from vvdp.base.params import Params
from vvdp.components.directed_flows import DIRECTED_RETURN, DIRECTED_SOURCE
from vvdp.components.rods import CYLINDER, LOAD_FORCE, ROD_FRICTION
from vvdp.control.adaptation import Adaptation
from vvdp.control.capacities import CylinderModel, SupplyLine
from vvdp.control.cylinder_force import ForceGains
from vvdp.control.direction import DirectionSettings
from vvdp.control.displacement import DisplacementSettings, SupplySupport
from vvdp.control.pressure_modes import PressureBounds
from vvdp.control.reference import ReferenceFilter
from vvdp.machines.chapter6_extras import Chapter6Extras
from vvdp.machines.chapter6_loop import (
    AT_REST,
    PROGRAM,
    Chapter6Loop,
    CylinderPlace,
    chapter6_start,
    chapter6_step,
)
from vvdp.machines.chapter6_reach import Chapter6Plant, refuse_impossible
from vvdp.network.network import Network
from vvdp.network.program import ProgramType
from vvdp.programs.machine.cycle import OwnCycle, Triangle, points_of


class CylinderOperation(Params):
    """The [operation] table: what is prescribed from outside; `load_force` acts in the direction of the position."""

    load_force: ForceSignal
    oil_temperature: TemperatureSignal


class InitialCylinder(Params):
    """The [initial] table: where a run starts."""

    position: Position
    pressure_a: Pressure
    pressure_b: Pressure


class Belief(Params):
    """The [belief] table: what the controller takes load, mass and oil to be; all else it knows as it is."""

    load_force: Force
    moving_mass: Mass
    bulk_modulus: BulkModulus


class Sampling(Params):
    """The [sampling] table: how often the controller is called."""

    sample_period: Time


@dataclass(frozen=True, kw_only=True)
class Chapter6Tables(Chapter6Plant):
    """The tables of the circuit: what is moved, the cycle, and the control."""

    cycle: Triangle | OwnCycle
    reference: ReferenceFilter
    gains: ForceGains
    direction: DirectionSettings
    pressure_bounds: PressureBounds
    belief: Belief
    sampling: Sampling
    operation: CylinderOperation
    initial: InitialCylinder
    adaptation: Adaptation | None = None


def chapter6(tables: Chapter6Tables) -> Network:
    """A cylinder under displacement control, its pump a source."""
    refuse_impossible(
        tables, tables.cycle, tables.pressure_bounds, tables.operation.load_force, tables.initial.position
    )
    net = plant_network(tables, tables.operation, tables.initial)
    net.extras = Chapter6Extras
    period = tables.sampling.sample_period
    settings = Chapter6Loop(
        control=DisplacementSettings(
            cylinder=believed_cylinder(tables, tables.belief),
            gains=tables.gains,
            direction=tables.direction,
            split=tables.flow_split,
            bounds=tables.pressure_bounds,
            support=SupplySupport(),
            adaptation=tables.adaptation or Adaptation(),
            sample_period=period,
        ),
        cycle=points_of(tables.cycle),
        reference=tables.reference,
        load_force=tables.belief.load_force,
    )
    reads = {
        "time": "t",
        "position": "rod.position",
        "velocity": "rod.velocity",
        "pressure_a": "chamber_a.pressure",
        "pressure_b": "chamber_b.pressure",
        "flow": "pump.flow",
    }
    kind = ProgramType(chapter6_step, CylinderPlace, AT_REST, Chapter6Loop, chapter6_start)
    net.program(PROGRAM, kind, settings, reads=reads, period=period)
    return net


def plant_network(plant: Chapter6Plant, operation: CylinderOperation, initial: InitialCylinder) -> Network:
    """Pump, valves, cylinder and load, commanded by the program `PROGRAM`."""
    net = Network(plant.oil, temperature=operation.oil_temperature, operation=operation, initial=initial)
    net.tank("tank")
    net.volume("chamber_a", plant.chamber_a, start="initial.pressure_a")
    net.volume("chamber_b", plant.chamber_b, start="initial.pressure_b")
    net.rod("rod", plant.load, position="initial.position")
    direction = f"{PROGRAM}.direction"
    ends = {"tank": "tank", "a": "chamber_a", "b": "chamber_b"}
    net.add("pump", DIRECTED_SOURCE, plant.pump, **ends, command=f"{PROGRAM}.flow", direction=direction)
    net.add(
        "return_valve", DIRECTED_RETURN, plant.return_valve, **ends, opening=f"{PROGRAM}.opening", direction=direction
    )
    net.add("cylinder", CYLINDER, plant.cylinder, a="chamber_a", b="chamber_b", rod="rod")
    net.add("friction", ROD_FRICTION, plant.friction, rod="rod")
    net.add("load", LOAD_FORCE, rod="rod", force=operation.load_force)
    return net


def believed_cylinder(plant: Chapter6Plant, belief: Belief) -> CylinderModel:
    """The cylinder as its controller knows it: without a line, mass and oil as believed."""
    cylinder, reference = plant.cylinder, plant.oil.reference_pressure
    return CylinderModel(
        area_a=cylinder.area_a,
        area_b=cylinder.area_b,
        oil_volume_a=plant.chamber_a.volume,
        oil_volume_b=plant.chamber_b.volume + cylinder.area_b * cylinder.stroke,
        lowest_position=0.0,
        highest_position=cylinder.stroke,
        moving_mass=belief.moving_mass,
        viscous_friction=plant.friction.viscous_friction,
        bulk_modulus=belief.bulk_modulus,
        line=SupplyLine(
            oil_volume=0.0, hose_compliance=0.0, gas_volume=0.0, precharge_pressure=reference, gas_exponent=1.4
        ),
        return_conductance=plant.return_valve.conductance,
        tank_pressure=reference,
        reference_pressure=reference,
    )
