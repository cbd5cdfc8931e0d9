"""The pump unit as a part of any network: pump, inlet volume, relief valve, rotary valve and its spool, and what
switches it softly."""

from dataclasses import dataclass

from vvdp.components.drives import DRIVE_COUPLING
from vvdp.components.machines import PUMP
from vvdp.components.resistances import ORIFICE
from vvdp.components.rotary_valve import ROTARY_VALVE
from vvdp.components.self_acting_valves import CHECK_VALVE, LOAD_RELIEF_VALVE, RELIEF_VALVE
from vvdp.hydraulics.check_valve import CheckPoppet, CheckValve
from vvdp.hydraulics.orifice import Orifice
from vvdp.hydraulics.pump import Pump
from vvdp.hydraulics.relief_valve import LoadReliefValve, ReliefValve
from vvdp.hydraulics.soft_switching import SwitchChamber, released_area
from vvdp.hydraulics.spool_drive import SpoolDrive
from vvdp.network.network import Network
from vvdp.network.nodes import Chamber, Connection, Source, Start
from vvdp.valve.rotary import RotaryValve
from vvdp.valve.validity import CAVITATION_PRESSURE


@dataclass(frozen=True)
class PumpUnit:
    """The values of a pump unit, and where it starts: absolute pressure [Pa], spool angle [rad] and speed [rad/s].

    `bypass`, a check valve past the load port, and `chamber`, which takes the pump flow while the tank port is partly
    open, switch it softly.
    """

    pump: Pump
    inlet: Chamber
    relief_valve: ReliefValve
    valve: RotaryValve
    spool_drive: SpoolDrive
    check_valve: CheckPoppet
    inlet_pressure: Start
    spool_angle: Start = 0.0
    spool_speed: Start = 0.0
    bypass: CheckValve | None = None
    chamber: SwitchChamber | None = None


@dataclass(frozen=True)
class UnitJoints:
    """The nodes that a pump unit joins, and what moves it: signals, states or commands [rad/s, m, rad/s].

    `cavitation_pressure` is that below which cavitation is assumed at the valve's ports, absolute [Pa].
    """

    tank: str
    load: str
    pump_speed: Source
    axial_position: Source
    spool_motor_speed: Source = 0.0
    cavitation_pressure: Source = CAVITATION_PRESSURE


def add_pump_unit(net: Network, unit: PumpUnit, joints: UnitJoints, prefix: str = "") -> None:
    """Add a pump unit to a network; `prefix` goes before its names where there are several.

    Its nodes are `inlet`, `pump_shaft`, `spool_motor` and `spool`, its components `pump`, `valve`, `relief_valve` and
    `coupling`; those of soft switching `bypass`, `chamber` and, between inlet and chamber, `mouth`.
    """
    inlet, shaft, motor, spool = (prefix + name for name in ("inlet", "pump_shaft", "spool_motor", "spool"))
    net.volume(inlet, unit.inlet, start=unit.inlet_pressure)
    net.driven_shaft(shaft, joints.pump_speed)
    net.driven_shaft(motor, joints.spool_motor_speed)
    net.shaft(spool, angle=unit.spool_angle, speed=unit.spool_speed)
    net.add(prefix + "pump", PUMP, unit.pump, inlet=joints.tank, outlet=inlet, shaft=shaft)
    net.add(
        prefix + "valve",
        ROTARY_VALVE,
        unit.valve,
        unit.check_valve,
        inlet=inlet,
        load=joints.load,
        tank=joints.tank,
        spool=spool,
        axial_position=joints.axial_position,
        cavitation_pressure=joints.cavitation_pressure,
    )
    if isinstance(unit.relief_valve, LoadReliefValve):
        pilot = {"a": inlet, "b": joints.tank, "pilot": joints.load}
        net.add(prefix + "relief_valve", LOAD_RELIEF_VALVE, unit.relief_valve, **pilot)
    else:
        net.add(prefix + "relief_valve", RELIEF_VALVE, unit.relief_valve, a=inlet, b=joints.tank)
    net.add(prefix + "coupling", DRIVE_COUPLING, unit.spool_drive, motor=motor, spool=spool)
    if unit.bypass is not None:
        net.add(prefix + "bypass", CHECK_VALVE, unit.bypass, a=inlet, b=joints.load)
    if unit.chamber is not None:
        area = Connection(released_area, (f"{prefix}valve.tank_opening", unit.chamber))
        net.volume(prefix + "chamber", unit.chamber, start=unit.chamber.precharge_pressure)
        net.add(prefix + "mouth", ORIFICE, Orifice(), a=inlet, b=prefix + "chamber", area=area)
