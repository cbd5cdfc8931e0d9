"""Rival circuits that move the same cylinder through the same duty cycle, each with its own position loop.

The functions that return a `Network` are what a system file names as its circuit; their arguments are its tables.

Source  wang2017, section 1.3
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

from vvdp.base.kinds import PressureSignal
from vvdp.base.params import Params
from vvdp.base.select import clip
from vvdp.components.controlled_valves import PROPORTIONAL_VALVE
from vvdp.components.directional_valves import (
    DIRECTIONAL_VALVE,
    THREE_WAY_PROPORTIONAL_VALVE,
    THROTTLED_DIRECTIONAL_VALVE,
    ThreeWayProportionalValve,
    ThrottledDirectionalValve,
)
from vvdp.components.flow_sources import FLOW_SOURCE
from vvdp.components.machines import PUMP
from vvdp.components.resistances import LAMINAR_GAP, LaminarGap
from vvdp.components.self_acting_valves import CHECK_VALVE, PILOT_CHECK_VALVE, RELIEF_VALVE, SHOCK_VALVE
from vvdp.control.reference import ReferenceFilter
from vvdp.fluid.oil import Oil
from vvdp.hydraulics.check_valve import CheckValve
from vvdp.hydraulics.directional_valve import DirectionalValve
from vvdp.hydraulics.flow_source import FlowSource
from vvdp.hydraulics.pilot_check_valve import PilotCheckValve
from vvdp.hydraulics.proportional_valve import ProportionalValve
from vvdp.hydraulics.pump import Pump
from vvdp.hydraulics.relief_valve import ReliefValve, ShockValve
from vvdp.hydraulics.volume import Vessel
from vvdp.machines.cylinder_load import (
    LOW_SIDE,
    InitialCylinder,
    LoadedCylinder,
    add_cylinder,
    start_at_rest,
)
from vvdp.machines.duty_cycle import DutyCycle, refuse_fast_cycle, refuse_long_cycle
from vvdp.machines.rival_loop import (
    CLOSED_LOOP,
    FEWEST,
    ONE_WAY_LOOP,
    OPEN_LOOP,
    THROTTLE_LOOP,
    LoopTable,
    RivalLoop,
    loop_gain,
)
from vvdp.machines.rival_tables import ChargeSupply, PumpDrive, Reservoir, VariablePump
from vvdp.network.network import Network
from vvdp.network.nodes import Connection
from vvdp.network.program import ProgramType
from vvdp.systems.extras import Extras

LOOP = "loop"
"""Name of the program of a position loop."""


SUFFIXES = ("", "_2", "_3")
"""What stands behind the names of the first, second and third cylinder and of all that belongs to it."""


class RoundOfWork(Extras):
    """What a rival brings along: its means are those of a round of its cycle, never steady."""

    STEADY = False


@dataclass(frozen=True, kw_only=True)
class Rival(LoadedCylinder):
    """The tables of all rival circuits: oil, cylinder with its load, duty cycle, reference, loop, where they start."""

    oil: Oil
    duty_cycle: DutyCycle
    reference: ReferenceFilter
    loop: LoopTable
    initial: InitialCylinder

    def settings(
        self, largest_flow: float, valve_conductance: float = FEWEST, bleed_conductance: float = FEWEST
    ) -> RivalLoop:
        """The values of the position loop. Raises ParameterError for a cycle that pump or cylinder cannot follow."""
        cylinder, stops = self.cylinder, self.end_stops
        refuse_long_cycle(self.duty_cycle, stops.lower_end, stops.upper_end)
        refuse_fast_cycle(self.duty_cycle, largest_flow / max(cylinder.area_a, cylinder.area_b))
        mass = (self.load.mass if self.load else 0.0) + cylinder.moving_mass
        return RivalLoop(
            cycle=self.duty_cycle,
            reference=self.reference,
            table=self.loop,
            position_gain=loop_gain(self.friction.viscous_friction, mass, self.loop.gain_margin),
            area_a=cylinder.area_a,
            area_b=cylinder.area_b,
            reference_pressure=self.oil.reference_pressure,
            largest_flow=largest_flow,
            valve_conductance=valve_conductance,
            bleed_conductance=bleed_conductance,
        )

    def network(
        self, program: ProgramType, settings: Params, supply: str, tank: PressureSignal | None = None
    ) -> Network:
        """A network with the cylinder and the loop that moves it; `supply` is the volume that feeds it.

        tank  its pressure, where it is not the oil's reference pressure [Pa, absolute]
        """
        net = Network(self.oil)
        net.extras = RoundOfWork
        net.tank("tank", tank)
        self.add_actuator(net, program, settings, supply)
        return net

    def add_actuator(self, net: Network, program: ProgramType, settings: Params, supply: str, suffix: str = "") -> None:
        """Add the cylinder and the loop that moves it; `suffix` goes behind their names where there are several."""
        net.values["initial" + suffix] = self.initial
        add_cylinder(net, self, f"{LOOP}{suffix}.force", suffix=suffix)
        reads = {
            "position": f"rod{suffix}.position",
            "pressure_a": f"chamber_a{suffix}.pressure",
            "pressure_b": f"chamber_b{suffix}.pressure",
            "supply_pressure": f"{supply}.pressure",
        }
        net.program(LOOP + suffix, program, settings, reads=reads, period=self.loop.sample_period)


@dataclass(frozen=True, kw_only=True)
class SharedSupply(Rival):
    """The same with up to two further cylinders that one pump feeds, by the duty cycles of these."""

    second: DutyCycle | None = None
    third: DutyCycle | None = None

    @property
    def rivals(self) -> Mapping[str, Rival]:
        """All cylinders, by the suffix of their names: alike but for their cycles, further ones at rest at first."""
        level = self.oil.reference_pressure
        found: dict[str, Rival] = {"": self}
        for suffix, cycle in zip(SUFFIXES[1:], (self.second, self.third), strict=True):
            if cycle is not None:
                start = start_at_rest(cycle, self.cylinder, level, level + LOW_SIDE)
                found[suffix] = replace(self, duty_cycle=cycle, initial=start)
        return found


@dataclass(frozen=True, kw_only=True)
class FixedPump(Rival):
    """The tables of a pump that turns steadily, with its relief valve."""

    pump: Pump
    pump_drive: PumpDrive
    relief_valve: ReliefValve

    @property
    def largest_flow(self) -> float:
        """Of the pump [m^3/s]."""
        return float(self.pump.displacement * self.pump_drive.speed.extremes[0])

    def add_pump(self, net: Network, outlet: str) -> None:
        """Add the pump between the tank and a volume, and the relief valve of that."""
        self.add_shaft(net)
        net.add("pump", PUMP, self.pump, inlet="tank", outlet=outlet, shaft="pump_shaft")
        net.add("relief_valve", RELIEF_VALVE, self.relief_valve, a=outlet, b="tank")

    def add_shaft(self, net: Network) -> None:
        """Add the shaft of the pump."""
        net.values["pump_drive"] = self.pump_drive
        net.driven_shaft("pump_shaft", self.pump_drive.speed)


@dataclass(frozen=True, kw_only=True)
class ThrottleControl(SharedSupply, FixedPump):
    """The tables of throttle control."""

    supply_line: Vessel
    directional_valve: DirectionalValve


def throttle_control(tables: ThrottleControl) -> Network:
    """Fixed pump, relief valve, 4/3 proportional valve: what the cylinder does not take goes over the relief valve.

    Further cylinders have such a valve of their own each.
    """
    valve = tables.directional_valve
    limits = tables.largest_flow, valve.conductance
    net = tables.network(THROTTLE_LOOP, tables.settings(*limits), "supply")
    net.volume("supply", tables.supply_line, start="initial.supply_pressure")
    tables.add_pump(net, "supply")
    for suffix, each in tables.rivals.items():
        if suffix:
            each.add_actuator(net, THROTTLE_LOOP, each.settings(*limits), "supply", suffix)
        ports = valve_ports("supply", suffix)
        net.add("directional_valve" + suffix, DIRECTIONAL_VALVE, valve, command=f"{LOOP}{suffix}.valve", **ports)
    return net


@dataclass(frozen=True, kw_only=True)
class IdealPump(Rival):
    """The tables of a pump whose flow the loop commands."""

    variable_pump: VariablePump

    def add_variable_pump(self, net: Network, inlet: str, outlet: str) -> None:
        """Add the pump between two nodes, and what leaks back through it."""
        gap = LaminarGap(conductance=self.variable_pump.leakage_conductance)
        net.add("pump", FLOW_SOURCE, FlowSource(), a=inlet, b=outlet, flow=f"{LOOP}.flow")
        net.add("pump_leakage", LAMINAR_GAP, gap, a=outlet, b=inlet)


@dataclass(frozen=True, kw_only=True)
class IdealPumpControl(IdealPump):
    """The tables of an ideal pump that gives flow one way."""

    supply_line: Vessel
    relief_valve: ReliefValve
    directional_valve: ThrottledDirectionalValve


def ideal_pump_control(tables: IdealPumpControl) -> Network:
    """An ideal variable pump that gives flow one way, a directional valve for the sign, a meter-out throttle."""
    settings = tables.settings(tables.variable_pump.largest_flow, tables.directional_valve.return_conductance)
    net = tables.network(ONE_WAY_LOOP, settings, "supply")
    net.volume("supply", tables.supply_line, start="initial.supply_pressure")
    tables.add_variable_pump(net, "tank", "supply")
    net.add("relief_valve", RELIEF_VALVE, tables.relief_valve, a="supply", b="tank")
    add_throttled_valve(net, tables.directional_valve)
    return net


@dataclass(frozen=True, kw_only=True)
class ClosedCircuit(IdealPump):
    """The tables of a pump between both chambers, with a charge line."""

    charge: ChargeSupply
    charge_line: Vessel
    charge_relief_valve: ReliefValve
    relief_valves: ShockValve

    def closed_network(self) -> Network:
        """The cylinder with its loop, pump, and the charge line: its pump, its relief valve, those of both chambers."""
        net = self.network(CLOSED_LOOP, self.settings(self.variable_pump.largest_flow), "charge_line")
        net.values["charge"] = self.charge
        net.volume("charge_line", self.charge_line, start="initial.supply_pressure")
        self.add_variable_pump(net, "chamber_b", "chamber_a")
        net.add("charge_pump", FLOW_SOURCE, FlowSource(), a="tank", b="charge_line", flow=self.charge.flow)
        net.add("charge_relief_valve", RELIEF_VALVE, self.charge_relief_valve, a="charge_line", b="tank")
        for side in "ab":
            net.add(f"relief_valve_{side}", SHOCK_VALVE, self.relief_valves, a=f"chamber_{side}", b="charge_line")
        return net


@dataclass(frozen=True, kw_only=True)
class ShuttleCircuit(ClosedCircuit):
    """The tables of a closed circuit with a shuttle valve."""

    charge_check_valves: CheckValve
    shuttle_valve: ThreeWayProportionalValve


def shuttle_circuit(tables: ShuttleCircuit) -> Network:
    """A closed circuit whose low side a commanded 3/2 valve joins to a charge line, after wang2017, fig. 1.6."""
    net = tables.closed_network()
    for side in "ab":
        net.add(f"charge_check_{side}", CHECK_VALVE, tables.charge_check_valves, a="charge_line", b=f"chamber_{side}")
    net.add(
        "shuttle_valve",
        THREE_WAY_PROPORTIONAL_VALVE,
        tables.shuttle_valve,
        pressure="chamber_b",
        tank="chamber_a",
        a="charge_line",
        command=f"{LOOP}.side",
    )
    return net


@dataclass(frozen=True, kw_only=True)
class PilotCheckCircuit(ClosedCircuit):
    """The tables of a closed circuit with pilot-operated check valves."""

    pilot_check_valves: PilotCheckValve


def pilot_check_circuit(tables: PilotCheckCircuit) -> Network:
    """A closed circuit whose low side pilot-operated check valves join to a charge line, after wang2017, fig. 1.7."""
    net = tables.closed_network()
    for side, other in ("ab", "ba"):
        joints = {"a": "charge_line", "b": f"chamber_{side}", "pilot": f"chamber_{other}"}
        net.add(f"pilot_check_{side}", PILOT_CHECK_VALVE, tables.pilot_check_valves, **joints)
    return net


@dataclass(frozen=True, kw_only=True)
class FourValveCircuit(IdealPump):
    """The tables of an open circuit with four 2-way valves."""

    reservoir: Reservoir
    supply_line: Vessel
    relief_valve: ReliefValve
    two_way_valves: ProportionalValve
    anti_cavitation_valves: CheckValve


def four_valve_circuit(tables: FourValveCircuit) -> Network:
    """An open circuit: a pump that also motors, and four 2-way valves about the cylinder, after wang2017, fig. 1.8."""
    valve, check, reservoir = tables.two_way_valves, tables.anti_cavitation_valves, tables.reservoir
    settings = tables.settings(tables.variable_pump.largest_flow)
    net = tables.network(OPEN_LOOP, settings, "supply", reservoir.pressure)
    net.values["reservoir"] = reservoir
    net.volume("supply", tables.supply_line, start="initial.supply_pressure")
    tables.add_variable_pump(net, "tank", "supply")
    net.add("relief_valve", RELIEF_VALVE, tables.relief_valve, a="supply", b="tank")
    net.add("anti_cavitation_supply", CHECK_VALVE, check, a="tank", b="supply")
    for side, loaded, other in (("a", load_side, far_side), ("b", far_side, load_side)):
        chamber = f"chamber_{side}"
        to_pump, to_tank = Connection(loaded, (f"{LOOP}.side",)), Connection(other, (f"{LOOP}.side",))
        net.add(f"supply_valve_{side}", PROPORTIONAL_VALVE, valve, a="supply", b=chamber, command=to_pump)
        net.add(f"return_valve_{side}", PROPORTIONAL_VALVE, valve, a=chamber, b="tank", command=to_tank)
        net.add(f"anti_cavitation_{side}", CHECK_VALVE, check, a="tank", b=chamber)
    return net


def load_side(side: float) -> float:
    """How far the valves that belong to chamber A's carrying the load are open [1], for a `side` from -1 to 1."""
    return clip(side, 0.0, 1.0)


def far_side(side: float) -> float:
    """How far the valves that belong to chamber B's carrying the load are open [1], for a `side` from -1 to 1."""
    return clip(-side, 0.0, 1.0)


def valve_ports(supply: str, suffix: str) -> Mapping[str, str]:
    """Where the ports of a 4/3 valve lead; `suffix` stands behind the names of its cylinder's chambers."""
    return {"pressure": supply, "tank": "tank", "a": f"chamber_a{suffix}", "b": f"chamber_b{suffix}"}


def add_throttled_valve(net: Network, valve: ThrottledDirectionalValve, suffix: str = "") -> None:
    """A directional valve with a throttle in its return, between `supply` and the chambers; `suffix` as there."""
    commands = {"command": f"{LOOP}{suffix}.valve", "return_command": f"{LOOP}{suffix}.opening"}
    ports = valve_ports("supply" + suffix, suffix)
    net.add("directional_valve" + suffix, THROTTLED_DIRECTIONAL_VALVE, valve, **commands, **ports)
