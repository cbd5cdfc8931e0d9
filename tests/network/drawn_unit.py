"""A pump unit drawn in Python, with the values of the prototype."""

from typing import NamedTuple

from vvdp.components.drives import DRIVE_COUPLING
from vvdp.components.machines import PUMP
from vvdp.components.rotary_valve import ROTARY_VALVE
from vvdp.components.self_acting_valves import RELIEF_VALVE
from vvdp.fluid.oil import Oil
from vvdp.hydraulics.check_valve import CheckPoppet
from vvdp.hydraulics.pump import Pump
from vvdp.hydraulics.relief_valve import ReliefValve
from vvdp.hydraulics.spool_drive import SpoolDrive
from vvdp.network.network import Network
from vvdp.network.nodes import Chamber, Source
from vvdp.systems.system import load_system
from vvdp.valve.rotary import RotaryValve


class Unit(NamedTuple):
    """Values of a pump unit."""

    oil: Oil
    pump: Pump
    inlet: Chamber
    relief_valve: ReliefValve
    valve: RotaryValve
    check_valve: CheckPoppet
    spool_drive: SpoolDrive


def prototype_unit() -> Unit:
    network = load_system("prototype").circuit.network
    parts = {name: part.values for name, part in network.parts.items()}
    valve, check_valve = parts["valve"]
    return Unit(network.oil, parts["pump"][0], network.nodes["inlet"].values, parts["relief_valve"][0], valve,
                check_valve, parts["coupling"][0])  # fmt: skip


class Moves(NamedTuple):
    """Where speed of the pump [rad/s], position of the spool [m] and speed of its motor [rad/s] come from."""

    pump_speed: Source = 188.0
    axial_position: Source = 5e-3
    spool_motor_speed: Source = 0.0


def add_unit(net: Network, unit: Unit, load: str, moves: Moves) -> None:
    net.volume("inlet", unit.inlet, start=2e6)
    net.driven_shaft("pump_shaft", moves.pump_speed)
    net.driven_shaft("spool_motor", moves.spool_motor_speed)
    net.shaft("spool")
    net.add("pump", PUMP, unit.pump, inlet="tank", outlet="inlet", shaft="pump_shaft")
    ports = {"inlet": "inlet", "load": load, "tank": "tank", "spool": "spool"}
    position = {"axial_position": moves.axial_position, "cavitation_pressure": 3e4}
    net.add("valve", ROTARY_VALVE, unit.valve, unit.check_valve, **ports, **position)
    net.add("relief_valve", RELIEF_VALVE, unit.relief_valve, a="inlet", b="tank")
    net.add("coupling", DRIVE_COUPLING, unit.spool_drive, motor="spool_motor", spool="spool")
