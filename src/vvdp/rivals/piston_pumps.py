"""Rivals whose pump gives the flow that the cylinder takes and has losses of its own: measured, or of single pistons.

Both stand instead of the rotary valve, in the machine's circuit: a line behind them, a directional valve for the sign,
a meter-out throttle.

Source  ours, docs/circuits-compared.md
"""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from vvdp.base.errors import ParameterError
from vvdp.base.kinds import Count, Flow, Ratio, SignedFraction
from vvdp.base.params import Params
from vvdp.base.select import clip
from vvdp.components.digital_pumps import DIGITAL_PUMP
from vvdp.components.directional_valves import ThrottledDirectionalValve
from vvdp.components.self_acting_valves import RELIEF_VALVE
from vvdp.components.variable_machines import VARIABLE_PUMP
from vvdp.hydraulics.digital_pump import DigitalPump, EnabledPistons, decision_period
from vvdp.hydraulics.relief_valve import ReliefValve
from vvdp.hydraulics.variable_machine import VariableMachine
from vvdp.hydraulics.volume import Vessel
from vvdp.machines.rival_loop import ONE_WAY_LOOP
from vvdp.machines.rival_tables import PumpDrive
from vvdp.network.network import Network
from vvdp.network.nodes import Connection
from vvdp.network.program import ProgramType
from vvdp.rivals.rivals import LOOP, Rival, add_throttled_valve

PISTONS = "pistons"
"""Name of the program that enables pistons."""


class PistonLaw(Params):
    """A pump of so many `pistons` that gives the `largest_flow` with all of them."""

    pistons: Count
    largest_flow: Flow


class FlowDemand(NamedTuple):
    """The flow that is asked of the pump."""

    flow: Flow


class PistonMemory(NamedTuple):
    """What the law carries from piston to piston: how many strokes it owes, the number of the piston, which of the
    last half revolution were enabled as the bits of a number, and the sums over those."""

    owed: Ratio
    place: Count
    enabled: Count
    cosine: Ratio
    sine: Ratio


def piston_start(settings: PistonLaw) -> PistonMemory:
    """The memory before the first piston: all idle."""
    return PistonMemory(0.0, 0.0, 0.0, 0.0, 0.0)


def piston_step(
    t: float, memory: PistonMemory, asked: FlowDemand, settings: PistonLaw
) -> tuple[PistonMemory, EnabledPistons]:
    """Program, called for each piston at its bottom dead centre: enable it if half a stroke or more is owed.

    What is owed grows by the flow over the largest one, and falls by 1 with each enabled piston, so that it stays
    between -1/2 and 1/2. The piston half a revolution before ends its stroke.
    """
    half, angle = settings.pistons / 2.0, 2.0 * math.pi * memory.place / settings.pistons
    owed = memory.owed + clip(asked.flow / settings.largest_flow, 0.0, 1.0)
    enable = 1.0 if owed >= 0.5 else 0.0
    top = 2.0 ** (half - 1.0)
    ended = 1.0 if memory.enabled >= top else 0.0
    enabled = 2.0 * (memory.enabled - ended * top) + enable
    some, change = (1.0 if enabled > 0.0 else 0.0), enable + ended  # the angle of the ended one is less by pi
    cosine = some * (memory.cosine + change * float(np.cos(angle)))
    sine = some * (memory.sine + change * float(np.sin(angle)))
    place = 0.0 if memory.place + 1.0 >= settings.pistons else memory.place + 1.0
    after = PistonMemory(owed - enable, place, enabled, cosine, sine)
    return after, EnabledPistons(cosine, sine, ones(enabled) / half, enable)


def ones(number: float) -> float:
    """How many bits of a whole number are 1.

    >>> ones(11.0)
    3.0
    """
    left, count = number, 0.0
    while left > 0.0:
        half = float(np.floor(left / 2.0))
        count, left = count + left - 2.0 * half, half
    return count


PISTON_LAW = ProgramType(piston_step, FlowDemand, EnabledPistons(0.0, 0.0, 0.0, 0.0), PistonLaw, piston_start)


@dataclass(frozen=True, kw_only=True)
class PistonPumpTables(Rival):
    """The tables of a pump that gives the flow of one cylinder."""

    pump: DigitalPump | VariableMachine
    pump_drive: PumpDrive
    supply_line: Vessel
    relief_valve: ReliefValve
    directional_valve: ThrottledDirectionalValve

    @property
    def speed(self) -> float:
        """Of the pump, the lowest where it varies [rad/s]."""
        return float(self.pump_drive.speed.extremes[0])


def piston_pump_control(tables: PistonPumpTables) -> Network:
    """A pump that gives the flow of the cylinder by its setting, or by enabling pistons; a directional valve for the
    sign, a meter-out throttle.
    """
    pump, speed = tables.pump, tables.speed
    largest = pump.displacement * speed
    settings = tables.settings(largest, tables.directional_valve.return_conductance)
    net = tables.network(ONE_WAY_LOOP, settings, "supply")
    net.values["pump_drive"] = tables.pump_drive
    net.volume("supply", tables.supply_line, start="initial.supply_pressure")
    net.driven_shaft("pump_shaft", tables.pump_drive.speed)
    ports = {"inlet": "tank", "outlet": "supply", "shaft": "pump_shaft"}
    match pump:
        case VariableMachine():
            setting = Connection(pump_setting, (pump, tables.pump_drive.speed, f"{LOOP}.flow"))
            net.add("pump", VARIABLE_PUMP, pump, setting=setting, **ports)
        case DigitalPump():
            refuse_changing_speed(tables.pump_drive)
            law = PistonLaw(pistons=pump.pistons, largest_flow=largest)
            reads, period = {"flow": f"{LOOP}.flow"}, decision_period(pump.pistons, speed)
            net.program(PISTONS, PISTON_LAW, law, reads=reads, period=period)
            told = {name: f"{PISTONS}.{name}" for name in EnabledPistons._fields}
            net.add("pump", DIGITAL_PUMP, pump, **ports, **told)
    net.add("relief_valve", RELIEF_VALVE, tables.relief_valve, a="supply", b="tank")
    add_throttled_valve(net, tables.directional_valve)
    return net


def pump_setting(pump: VariableMachine, speed: float, flow: float) -> SignedFraction:
    """The setting at which a pump displaces a flow [1]: Q/(D omega).

    speed  omega of its shaft [rad/s]
    flow   Q [m^3/s]
    """
    setting: float = flow / (pump.displacement * speed)
    return setting


def refuse_changing_speed(drive: PumpDrive) -> None:
    """Raises ParameterError for a speed that changes: pistons are enabled at times that follow from the speed."""
    lowest, highest = drive.speed.extremes
    if lowest != highest:
        raise ParameterError("pump_drive.speed: must be constant for a pump of enabled pistons")
