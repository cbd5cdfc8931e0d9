"""Rivals whose fixed pump is metered by on/off valves: parallel ones with a code, or fast linear ones with pulses.

Both stand instead of the rotary valve, in the machine's circuit: a line behind them, a directional valve for the
sign, a meter-out throttle.

Source  wang2017, sections 1.2.1 and 1.2.2
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from vvdp.base.kinds import Count, Force, Fraction, Position, Pressure, SignedFraction
from vvdp.base.params import Params
from vvdp.base.rules import refuse
from vvdp.base.select import select
from vvdp.components.directional_valves import ThrottledDirectionalValve
from vvdp.components.flow_control_units import add_flow_control_unit
from vvdp.components.switching_valves import MODULATED_SWITCHING_VALVE, ModulatedThreeWayValve
from vvdp.hydraulics.flow_control_unit import OnOffValve, UnitValve, binary_valves, equal_valves
from vvdp.hydraulics.pump import Pump
from vvdp.hydraulics.volume import Vessel
from vvdp.machines.rival_loop import (
    ONE_WAY_LOOP,
    CylinderReading,
    LoopMemory,
    RivalLoop,
    loop_start,
    one_way_step,
)
from vvdp.network.network import Network
from vvdp.network.nodes import Chamber, Connection
from vvdp.network.program import ProgramType
from vvdp.rivals.rivals import LOOP, FixedPump, add_throttled_valve

LEAST_DROP = 1e5
"""Drop over a unit below which its loop calculates with this one [Pa]."""
LEAST_SHARE = 0.03
"""Duty ratio below which no pulse is sent: at 75 Hz it would hardly open the port to the line, or not at all."""


class FlowControlUnit(OnOffValve):
    """A unit of `valves` on/off valves: the values are those of the smallest.

    Sizes double from valve to valve; where `equal_sizes` is 1, all are as large as the smallest.
    """

    valves: Count
    equal_sizes: Fraction = 0.0

    def check(self) -> None:
        super().check()
        if self.valves < 1.0 or self.valves != round(self.valves):
            refuse(self, "valves", "must be a whole number of at least 1")
        if self.equal_sizes not in (0.0, 1.0):
            refuse(self, "equal_sizes", "must be 0 or 1")

    @property
    def parts(self) -> tuple[UnitValve, ...]:
        """Its valves, the smallest first."""
        return (equal_valves if self.equal_sizes else binary_valves)(int(self.valves), self)


class CodedLoop(Params):
    """A position loop that opens a unit by codes up to `highest_code`, from a supply that it takes to be at a level."""

    loop: RivalLoop
    smallest: OnOffValve
    highest_code: Count
    supply_level: Pressure


class CodedCommand(NamedTuple):
    """What it commands: the unit's code, the directional valve, the meter-out throttle; `reference` is shown,
    and `force` is what the duty cycle puts on the rod."""

    code: Count
    valve: SignedFraction
    opening: Fraction
    reference: Position
    force: Force


def coded_step(
    t: float, memory: LoopMemory, seen: CylinderReading, settings: CodedLoop
) -> tuple[LoopMemory, CodedCommand]:
    """Program: as `one_way_step`, with the code whose flow is closest to the one that is wanted."""
    kept, command = one_way_step(t, memory, seen, settings.loop)
    drop = max(settings.supply_level - kept.pressures.supply, LEAST_DROP)
    unit = settings.smallest.rated_flow * np.sqrt(drop / settings.smallest.rated_drop)
    code = min(float(np.floor(command.flow / unit + 0.5)), settings.highest_code)
    coded = CodedCommand(
        code=code, valve=command.valve, opening=command.opening, reference=command.reference, force=command.force
    )
    return kept, coded


def coded_start(settings: CodedLoop) -> LoopMemory:
    """The memory before the first sample: at rest at the beginning of the cycle."""
    return loop_start(settings.loop)


CODED_LOOP = ProgramType(
    step=coded_step,
    reading=CylinderReading,
    command=CodedCommand(code=0.0, valve=0.0, opening=0.0, reference=0.0, force=0.0),
    settings=CodedLoop,
    start=coded_start,
)


@dataclass(frozen=True, kw_only=True)
class DigitalSupply(FixedPump):
    """The tables of a fixed pump, of what its flow goes to, and of the valves behind that."""

    supply_line: Vessel
    directional_valve: ThrottledDirectionalValve


@dataclass(frozen=True, kw_only=True)
class UnitSupply(DigitalSupply):
    """The same with a digital flow control unit in between."""

    pump_line: Vessel
    unit: FlowControlUnit


def flow_control_unit(tables: UnitSupply) -> Network:
    """Fixed pump at its relief setting, metered by a digital flow control unit."""
    parts, level = tables.unit.parts, tables.relief_valve.cracking_pressure
    settings = CodedLoop(
        loop=tables.settings(tables.largest_flow, tables.directional_valve.return_conductance),
        smallest=tables.unit,
        highest_code=max(valve.modulus for valve in parts) - 1.0,
        supply_level=level,
    )
    net = tables.network(CODED_LOOP, settings, "supply")
    net.volume("pump_line", tables.pump_line, start=level)
    tables.add_pump(net, "pump_line")
    net.volume("supply", tables.supply_line, start="initial.supply_pressure")
    add_flow_control_unit(net, "unit", parts, ("pump_line", "supply"), f"{LOOP}.code")
    add_throttled_valve(net, tables.directional_valve)
    return net


@dataclass(frozen=True, kw_only=True)
class SwitchedSupply(DigitalSupply):
    """The same with pulsed linear valves in between."""

    inlet: Chamber
    switching_valve: ModulatedThreeWayValve


def linear_valves(tables: SwitchedSupply) -> Network:
    """Fixed pump whose flow pulsed linear valves send to the line or back to the tank."""
    settings = tables.settings(tables.largest_flow, tables.directional_valve.return_conductance)
    net = tables.network(ONE_WAY_LOOP, settings, "supply")
    net.volume("pump_line", tables.inlet, start="initial.supply_pressure")
    tables.add_pump(net, "pump_line")
    net.volume("supply", tables.supply_line, start="initial.supply_pressure")
    net.add(
        "switching_valve",
        MODULATED_SWITCHING_VALVE,
        tables.switching_valve,
        pressure="pump_line",
        first="supply",
        second="tank",
        duty_ratio=Connection(pump_share, (tables.pump, tables.pump_drive.speed, f"{LOOP}.flow")),
    )
    add_throttled_valve(net, tables.directional_valve)
    return net


def pump_share(pump: Pump, speed: float, flow: float) -> float:
    """A flow over that of a pump [1]; none below `LEAST_SHARE`.

    speed  of its shaft [rad/s]
    flow   [m^3/s]
    """
    share = flow / (pump.displacement * speed)
    return select(share < LEAST_SHARE, 0.0, share)
