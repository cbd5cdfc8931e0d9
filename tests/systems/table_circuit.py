"""A circuit that a function draws from its tables, as a user may write one: a pump unit with its load."""

from dataclasses import dataclass

from tests.network.drawn_unit import Moves, Unit, add_unit

from vvdp.base.kinds import AreaSignal, DutySignal, Power, Pressure, PressureSignal, SpeedSignal, TemperatureSignal
from vvdp.base.params import Params
from vvdp.components.resistances import ORIFICE
from vvdp.components.rotary_valve import duty_position
from vvdp.fluid.oil import Oil
from vvdp.hydraulics.check_valve import CheckPoppet
from vvdp.hydraulics.orifice import Orifice
from vvdp.hydraulics.pump import Pump
from vvdp.hydraulics.relief_valve import ReliefValve
from vvdp.hydraulics.spool_drive import SpoolDrive
from vvdp.hydraulics.volume import Vessel
from vvdp.network.network import Network
from vvdp.network.nodes import Chamber, Connection
from vvdp.systems.limits import Limits
from vvdp.valve.rotary import RotaryValve


class Load(Orifice):
    area: AreaSignal


class Motor(Params):
    rated_power: Power


class Operation(Params):
    pump_speed: SpeedSignal
    oil_temperature: TemperatureSignal
    duty_ratio: DutySignal
    spool_motor_speed: SpeedSignal
    tank_pressure: PressureSignal


class Placed(Params):
    load_pressure: Pressure


@dataclass(frozen=True, kw_only=True)
class Tables:
    oil: Oil
    pump: Pump
    motor: Motor
    inlet: Chamber
    relief_valve: ReliefValve
    valve: RotaryValve
    spool_drive: SpoolDrive
    check_valve: CheckPoppet
    load_line: Vessel
    load: Load
    operation: Operation
    initial: Placed
    limits: Limits


def unit_on_load(tables: Tables) -> Network:
    moves = tables.operation
    net = Network(tables.oil, temperature=moves.oil_temperature, operation=moves, load=tables.load,
                  initial=tables.initial, spool_drive=tables.spool_drive, limits=tables.limits)  # fmt: skip
    net.tank("tank", moves.tank_pressure)
    net.volume("load_line", tables.load_line, start="initial.load_pressure")
    unit = Unit(tables.oil, tables.pump, tables.inlet, tables.relief_valve, tables.valve, tables.check_valve,
                tables.spool_drive)  # fmt: skip
    position = Connection(duty_position, (moves.duty_ratio, tables.valve))
    add_unit(net, unit, "load_line", Moves(moves.pump_speed, position, moves.spool_motor_speed))
    net.add("load", ORIFICE, tables.load, a="load_line", b="tank", area=tables.load.area)
    return net
