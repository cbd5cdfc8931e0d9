"""The control of the whole machine as a part of a network: both programs with their values, from a system's tables."""

from dataclasses import dataclass, replace

from vvdp.base.errors import ParameterError
from vvdp.base.kinds import (
    Count,
    Force,
    Length,
    Pressure,
    PressureDifference,
    Time,
)
from vvdp.base.params import Params
from vvdp.control.adaptation import Adaptation
from vvdp.control.capacities import (
    CylinderBelief,
    CylinderEnds,
    CylinderModel,
    LineBelief,
    cylinder_model,
)
from vvdp.control.cylinder_force import ForceGains
from vvdp.control.direction import DirectionSettings
from vvdp.control.displacement import DisplacementSettings, SupplySupport
from vvdp.control.flow_gain import FlowGain
from vvdp.control.flow_map import FlowMap
from vvdp.control.flow_split import FlowSplit
from vvdp.control.pressure_modes import PressureBounds
from vvdp.control.reference import Rate, ReferenceFilter
from vvdp.estimation.load_observer import LoadObserver
from vvdp.machines.common_loop import COMMON_LOOP, CommonLoop, common_law
from vvdp.machines.cycle import OwnCycle, Triangle, first_direction, points_of, refuse_fast_points
from vvdp.machines.inner_loop import LedGerotorPlace, LedPlace, led_gerotor_step, led_step
from vvdp.machines.machine_loop import (
    IDLE,
    PROGRAM,
    GerotorMachinePlace,
    MachineLoop,
    MachinePlace,
    SpoolRange,
    gerotor_machine_step,
    machine_start,
    machine_step,
)
from vvdp.machines.machine_tables import MachineOperation
from vvdp.machines.stages import MachineSequence
from vvdp.machines.supervision import SpoolSpring, Supervised, Supervision
from vvdp.network.network import Network
from vvdp.network.program import ProgramType
from vvdp.programs.axial_loop import PROGRAM as AXIAL
from vvdp.programs.axial_loop import UNKNOWN
from vvdp.programs.chamber_loop import PassiveLoop, WatchedLoop, watched_start
from vvdp.programs.gerotor_loop import GerotorLoop, WatchedGerotor, watched_gerotor_start
from vvdp.programs.loop_report import ChamberLoopReport, SpoolLoopReport
from vvdp.programs.position_loop import LoopTable
from vvdp.programs.spool_encoder import WatchSettings
from vvdp.sensing.instrument import Instrument, ideal_instrument

SAMPLE_PERIOD = 1e-3
"""Of the outer loop [s]."""


class MachineBelief(CylinderBelief, LineBelief):
    """The [belief] table: what the control takes cylinder, line, load and relief valve to be, right or wrong.

    Oil volumes are those of the chambers with their hoses at position 0; `return_conductance` is K_v of the return
    valve, fully open; `relief_pressure` is where the flow map takes the relief valve to crack.
    """

    load_force: Force
    relief_pressure: Pressure


class LoadObserverTable(Params):
    """The [load_observer] table: how fast its three errors fade, and the reported load follows."""

    observer_rate: Rate
    load_rate: Rate


class CylinderSensors(Params):
    """The [cylinder_sensors] table: noise, as a deviation, its first seed, and how late a command acts."""

    position_noise: Length
    pressure_noise: PressureDifference
    latency: Time
    seed: Count


@dataclass(frozen=True)
class MachineTables:
    """The tables of the machine's outer loop, by their names in a system file."""

    belief: MachineBelief
    gains: ForceGains
    direction: DirectionSettings
    flow_split: FlowSplit
    pressure_bounds: PressureBounds
    supply_support: SupplySupport
    load_observer: LoadObserverTable
    reference: ReferenceFilter
    cycle: Triangle | OwnCycle
    machine_sequence: MachineSequence
    flow_gain: FlowGain
    adaptation: Adaptation
    supervision: Supervision | None
    operation: MachineOperation
    spool_spring: SpoolSpring


@dataclass(frozen=True)
class MachinePaths:
    """Paths of what is measured: position of the cylinder, pressures, shaft and position of the spool."""

    position: str
    pressure_a: str
    pressure_b: str
    line_pressure: str
    spool: str
    spool_position: str
    chamber_pressure: str = ""


def displacement_laws(tables: MachineTables, model: CylinderModel) -> DisplacementSettings:
    """The laws of the tables, for a cylinder as it is believed."""
    return DisplacementSettings(
        cylinder=model,
        gains=tables.gains,
        direction=tables.direction,
        split=tables.flow_split,
        bounds=tables.pressure_bounds,
        support=tables.supply_support,
        adaptation=tables.adaptation,
        sample_period=SAMPLE_PERIOD,
    )


def machine_loop(
    tables: MachineTables, cylinder: CylinderEnds, spool: SpoolRange, flow_map: FlowMap, tank_pressure: float
) -> MachineLoop:
    """The values of the outer loop. Raises ParameterError where the cycle leaves the cylinder or is too fast.

    flow_map       as it is believed
    tank_pressure  absolute [Pa]
    """
    model = cylinder_model(tables.belief, cylinder, tables.belief, tank_pressure)
    refuse_cycle(tables.cycle, cylinder, tables.flow_split.largest_flow)
    observer = LoadObserver(
        moving_mass=model.moving_mass,
        viscous_friction=model.viscous_friction,
        observer_rate=tables.load_observer.observer_rate,
        load_rate=tables.load_observer.load_rate,
        sample_period=SAMPLE_PERIOD,
    )
    return MachineLoop(
        law=displacement_laws(tables, model),
        observer=observer,
        reference=tables.reference,
        points=points_of(tables.cycle),
        sequence=tables.machine_sequence,
        flow_map=flow_map,
        gain=tables.flow_gain,
        spool=spool,
        load_force=tables.belief.load_force,
        supervised=Supervised(
            watches=0.0 if tables.supervision is None else 1.0,
            limits=tables.supervision or Supervision(),
            cylinder=model,
            spring=tables.spool_spring,
            pump_speed=tables.operation.pump_speed,
            sample_period=SAMPLE_PERIOD,
        ),
        first_direction=first_direction(tables.cycle),
    )


def refuse_cycle(cycle: Triangle | OwnCycle, cylinder: CylinderEnds, largest_flow: float) -> None:
    """Raises ParameterError where a cycle leaves the cylinder's stroke or is faster than the pump, with its row.

    largest_flow  of the pump [m^3/s]
    """
    positions = points_of(cycle).positions
    low, high = min(positions), max(positions)
    if low < cylinder.lowest_position or high > cylinder.highest_position:
        raise ParameterError(
            f"cycle: {1e3 * low:.4g} to {1e3 * high:.4g} mm are asked for; the cylinder goes from "
            f"{1e3 * cylinder.lowest_position:.4g} to {1e3 * cylinder.highest_position:.4g} mm"
        )
    refuse_fast_points(cycle, largest_flow / max(cylinder.area_a, cylinder.area_b))


def instruments(table: CylinderSensors) -> dict[str, Instrument]:
    """What stands between the cylinder and the program, by the field of its reading."""
    position, pressure = ideal_instrument(-10.0, 10.0), ideal_instrument(0.0, 1e8)
    found = {"position": replace(position, noise=table.position_noise, seed=table.seed)}
    for number, name in enumerate(("pressure_a", "pressure_b", "line_pressure"), 1):
        found[name] = replace(pressure, noise=table.pressure_noise, seed=table.seed + number)
    return found


def add_outer_loop(
    net: Network, loop: MachineLoop, sensors: CylinderSensors, paths: MachinePaths, table: LoopTable | None = None
) -> None:
    """Add the program that controls the cylinder, by the position loop of a `table` instead of its laws if any.

    It comes before the axial one, which thus follows it at once; what it receives of that one is a sample old.
    """
    reads = {
        "time": "t",
        "position": paths.position,
        "pressure_a": paths.pressure_a,
        "pressure_b": paths.pressure_b,
        "line_pressure": paths.line_pressure,
        "spool_stage": f"{AXIAL}.stage",
        "spool_known": f"{AXIAL}.known",
        "spool_position": f"{AXIAL}.position",
        "spool_speed": f"{AXIAL}.spool_speed",
        "spool_measured": f"{AXIAL}.measured",
        "spool_reference": f"{AXIAL}.reference",
        "pump_speed": "pump_motor.speed",
    }
    kind = ProgramType(gerotor_machine_step, GerotorMachinePlace, IDLE, MachineLoop, machine_start)
    if paths.chamber_pressure:
        kind = ProgramType(machine_step, MachinePlace, IDLE, MachineLoop, machine_start)
        reads["chamber_pressure"] = paths.chamber_pressure
    net.program(
        PROGRAM,
        kind if table is None else COMMON_LOOP,
        loop if table is None else CommonLoop(machine=loop, law=common_law(loop, table)),
        reads=reads,
        sensors=instruments(sensors),
        period=loop.law.sample_period,
        latency=sensors.latency,
        previous=True,
    )


def add_led_drive(net: Network, loop: PassiveLoop | GerotorLoop, watch: WatchSettings, paths: MachinePaths) -> None:
    """Add the program that moves the spool to where the outer loop wants it."""
    reads = {
        "time": "t",
        "angle": f"{paths.spool}.angle",
        "speed": f"{paths.spool}.speed",
        "position": paths.spool_position,
        "wanted": f"{PROGRAM}.spool_position",
        "energised": f"{PROGRAM}.energised",
    }
    if isinstance(loop, GerotorLoop):
        kind = ProgramType(
            led_gerotor_step, LedGerotorPlace, UNKNOWN, WatchedGerotor, watched_gerotor_start, report=SpoolLoopReport
        )
        settings = WatchedGerotor(watch=watch, loop=loop)
        net.program(AXIAL, kind, settings, reads=reads, period=loop.sample_period)
        return
    kind = ProgramType(led_step, LedPlace, UNKNOWN, WatchedLoop, watched_start, report=ChamberLoopReport)
    net.program(
        AXIAL,
        kind,
        WatchedLoop(watch=watch, loop=loop),
        reads=reads | {"pressure": paths.chamber_pressure},
        period=loop.observer.sample_period,
    )
