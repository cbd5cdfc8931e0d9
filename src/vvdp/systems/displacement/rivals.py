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
from vvdp.hydraulics.cylinder import Cylinder
from vvdp.hydraulics.directional_valve import DirectionalValve
from vvdp.hydraulics.flow_source import FlowSource
from vvdp.hydraulics.friction import RodFriction
from vvdp.hydraulics.pilot_check_valve import PilotCheckValve
from vvdp.hydraulics.proportional_valve import ProportionalValve
from vvdp.hydraulics.pump import Pump
from vvdp.hydraulics.relief_valve import ReliefValve, ShockValve
from vvdp.hydraulics.rod import EndStop
from vvdp.hydraulics.volume import Vessel
from vvdp.network.network import Network
from vvdp.network.nodes import Connection, Load
from vvdp.network.program import ProgramType
from vvdp.systems.displacement.cylinder_load import (
    LOW_SIDE,
    InitialCylinder,
    LoadedCylinder,
    add_cylinder,
    start_at_rest,
)
from vvdp.systems.displacement.duty_cycle import DutyCycle, refuse_fast_cycle, refuse_long_cycle
from vvdp.systems.displacement.rival_loop import (
    CLOSED_LOOP,
    FEWEST,
    ONE_WAY_LOOP,
    OPEN_LOOP,
    THROTTLE_LOOP,
    LoopTable,
    RivalLoop,
    loop_gain,
)
from vvdp.systems.displacement.rival_tables import ChargeSupply, PumpDrive, Reservoir, VariablePump
from vvdp.systems.extras import Extras

LOOP = "loop"
"""Name of the program of a position loop."""


SUFFIXES = ("", "_2", "_3")
"""What stands behind the names of the first, second and third cylinder and of all that belongs to it."""


class RoundOfWork(Extras):
    """What a rival brings along: its means are those of a round of its cycle, never steady."""

    STEADY = False


@dataclass(frozen=True)
class Rival:
    """What all rival circuits share: oil, cylinder with its load, duty cycle, reference, loop, and where they start."""

    oil: Oil
    moved: LoadedCylinder
    duty_cycle: DutyCycle
    reference: ReferenceFilter
    loop: LoopTable
    initial: InitialCylinder

    def settings(
        self, largest_flow: float, valve_conductance: float = FEWEST, bleed_conductance: float = FEWEST
    ) -> RivalLoop:
        """The values of the position loop. Raises ParameterError for a cycle that pump or cylinder cannot follow."""
        cylinder, stops = self.moved.cylinder, self.moved.end_stops
        refuse_long_cycle(self.duty_cycle, stops.lower_end, stops.upper_end)
        refuse_fast_cycle(self.duty_cycle, largest_flow / max(cylinder.area_a, cylinder.area_b))
        mass = (self.moved.load.mass if self.moved.load else 0.0) + cylinder.moving_mass
        return RivalLoop(
            cycle=self.duty_cycle,
            reference=self.reference,
            table=self.loop,
            position_gain=loop_gain(self.moved.friction.viscous_friction, mass, self.loop.gain_margin),
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
        add_cylinder(net, self.moved, f"{LOOP}{suffix}.force", suffix=suffix)
        reads = {
            "position": f"rod{suffix}.position",
            "pressure_a": f"chamber_a{suffix}.pressure",
            "pressure_b": f"chamber_b{suffix}.pressure",
            "supply_pressure": f"{supply}.pressure",
        }
        net.program(LOOP + suffix, program, settings, reads=reads, period=self.loop.sample_period)


def further_rivals(first: Rival, second: DutyCycle | None, third: DutyCycle | None) -> Mapping[str, Rival]:
    """The rival with the further ones that one pump feeds, by suffix: alike but for their cycles, at rest at first."""
    level, cylinder = first.oil.reference_pressure, first.moved.cylinder
    found = {"": first}
    for suffix, cycle in zip(SUFFIXES[1:], (second, third), strict=True):
        if cycle is not None:
            start = start_at_rest(cycle, cylinder, level, level + LOW_SIDE)
            found[suffix] = replace(first, duty_cycle=cycle, initial=start)
    return found


def throttle_control(
    oil: Oil,
    pump: Pump,
    pump_drive: PumpDrive,
    supply_line: Vessel,
    relief_valve: ReliefValve,
    directional_valve: DirectionalValve,
    cylinder: Cylinder,
    chamber_a: Vessel,
    chamber_b: Vessel,
    load: Load,
    friction: RodFriction,
    end_stops: EndStop,
    duty_cycle: DutyCycle,
    reference: ReferenceFilter,
    loop: LoopTable,
    initial: InitialCylinder,
    second: DutyCycle | None = None,
    third: DutyCycle | None = None,
) -> Network:
    """Fixed pump, relief valve, 4/3 proportional valve: what the cylinder does not take goes over the relief valve.

    `second` and `third` are the duty cycles of further cylinders, each with such a valve of its own.
    """
    moved = loaded_cylinder(cylinder, (chamber_a, chamber_b), load, friction, end_stops)
    rival = Rival(oil=oil, moved=moved, duty_cycle=duty_cycle, reference=reference, loop=loop, initial=initial)
    limits = pump.displacement * pump_drive.speed.extremes[0], directional_valve.conductance
    net = rival.network(THROTTLE_LOOP, rival.settings(*limits), "supply")
    net.values["pump_drive"] = pump_drive
    net.volume("supply", supply_line, start="initial.supply_pressure")
    net.driven_shaft("pump_shaft", pump_drive.speed)
    net.add("pump", PUMP, pump, inlet="tank", outlet="supply", shaft="pump_shaft")
    net.add("relief_valve", RELIEF_VALVE, relief_valve, a="supply", b="tank")
    for suffix, each in further_rivals(rival, second, third).items():
        if suffix:
            each.add_actuator(net, THROTTLE_LOOP, each.settings(*limits), "supply", suffix)
        ports = valve_ports("supply", suffix)
        net.add(
            "directional_valve" + suffix, DIRECTIONAL_VALVE, directional_valve, command=f"{LOOP}{suffix}.valve", **ports
        )
    return net


def ideal_pump_control(
    oil: Oil,
    variable_pump: VariablePump,
    supply_line: Vessel,
    relief_valve: ReliefValve,
    directional_valve: ThrottledDirectionalValve,
    cylinder: Cylinder,
    chamber_a: Vessel,
    chamber_b: Vessel,
    load: Load,
    friction: RodFriction,
    end_stops: EndStop,
    duty_cycle: DutyCycle,
    reference: ReferenceFilter,
    loop: LoopTable,
    initial: InitialCylinder,
) -> Network:
    """An ideal variable pump that gives flow one way, a directional valve for the sign, a meter-out throttle."""
    moved = loaded_cylinder(cylinder, (chamber_a, chamber_b), load, friction, end_stops)
    rival = Rival(oil=oil, moved=moved, duty_cycle=duty_cycle, reference=reference, loop=loop, initial=initial)
    settings = rival.settings(variable_pump.largest_flow, directional_valve.return_conductance)
    net = rival.network(ONE_WAY_LOOP, settings, "supply")
    net.volume("supply", supply_line, start="initial.supply_pressure")
    _add_variable_pump(net, variable_pump, "tank", "supply")
    net.add("relief_valve", RELIEF_VALVE, relief_valve, a="supply", b="tank")
    add_throttled_valve(net, directional_valve)
    return net


def shuttle_circuit(
    oil: Oil,
    variable_pump: VariablePump,
    charge: ChargeSupply,
    charge_line: Vessel,
    charge_relief_valve: ReliefValve,
    charge_check_valves: CheckValve,
    relief_valves: ShockValve,
    shuttle_valve: ThreeWayProportionalValve,
    cylinder: Cylinder,
    chamber_a: Vessel,
    chamber_b: Vessel,
    load: Load,
    friction: RodFriction,
    end_stops: EndStop,
    duty_cycle: DutyCycle,
    reference: ReferenceFilter,
    loop: LoopTable,
    initial: InitialCylinder,
) -> Network:
    """A closed circuit whose low side a commanded 3/2 valve joins to a charge line, after wang2017, fig. 1.6."""
    moved = loaded_cylinder(cylinder, (chamber_a, chamber_b), load, friction, end_stops)
    rival = Rival(oil=oil, moved=moved, duty_cycle=duty_cycle, reference=reference, loop=loop, initial=initial)
    net = rival.network(CLOSED_LOOP, rival.settings(variable_pump.largest_flow), "charge_line")
    _add_closed_pump(net, variable_pump, charge, (charge_line, charge_relief_valve, relief_valves))
    for side in "ab":
        net.add(f"charge_check_{side}", CHECK_VALVE, charge_check_valves, a="charge_line", b=f"chamber_{side}")
    net.add(
        "shuttle_valve",
        THREE_WAY_PROPORTIONAL_VALVE,
        shuttle_valve,
        pressure="chamber_b",
        tank="chamber_a",
        a="charge_line",
        command=f"{LOOP}.side",
    )
    return net


def pilot_check_circuit(
    oil: Oil,
    variable_pump: VariablePump,
    charge: ChargeSupply,
    charge_line: Vessel,
    charge_relief_valve: ReliefValve,
    pilot_check_valves: PilotCheckValve,
    relief_valves: ShockValve,
    cylinder: Cylinder,
    chamber_a: Vessel,
    chamber_b: Vessel,
    load: Load,
    friction: RodFriction,
    end_stops: EndStop,
    duty_cycle: DutyCycle,
    reference: ReferenceFilter,
    loop: LoopTable,
    initial: InitialCylinder,
) -> Network:
    """A closed circuit whose low side pilot-operated check valves join to a charge line, after wang2017, fig. 1.7."""
    moved = loaded_cylinder(cylinder, (chamber_a, chamber_b), load, friction, end_stops)
    rival = Rival(oil=oil, moved=moved, duty_cycle=duty_cycle, reference=reference, loop=loop, initial=initial)
    net = rival.network(CLOSED_LOOP, rival.settings(variable_pump.largest_flow), "charge_line")
    _add_closed_pump(net, variable_pump, charge, (charge_line, charge_relief_valve, relief_valves))
    for side, other in ("ab", "ba"):
        joints = {"a": "charge_line", "b": f"chamber_{side}", "pilot": f"chamber_{other}"}
        net.add(f"pilot_check_{side}", PILOT_CHECK_VALVE, pilot_check_valves, **joints)
    return net


def four_valve_circuit(
    oil: Oil,
    variable_pump: VariablePump,
    reservoir: Reservoir,
    supply_line: Vessel,
    relief_valve: ReliefValve,
    two_way_valves: ProportionalValve,
    anti_cavitation_valves: CheckValve,
    cylinder: Cylinder,
    chamber_a: Vessel,
    chamber_b: Vessel,
    load: Load,
    friction: RodFriction,
    end_stops: EndStop,
    duty_cycle: DutyCycle,
    reference: ReferenceFilter,
    loop: LoopTable,
    initial: InitialCylinder,
) -> Network:
    """An open circuit: a pump that also motors, and four 2-way valves about the cylinder, after wang2017, fig. 1.8."""
    moved = loaded_cylinder(cylinder, (chamber_a, chamber_b), load, friction, end_stops)
    rival = Rival(oil=oil, moved=moved, duty_cycle=duty_cycle, reference=reference, loop=loop, initial=initial)
    net = rival.network(OPEN_LOOP, rival.settings(variable_pump.largest_flow), "supply", reservoir.pressure)
    net.values["reservoir"] = reservoir
    net.volume("supply", supply_line, start="initial.supply_pressure")
    _add_variable_pump(net, variable_pump, "tank", "supply")
    net.add("relief_valve", RELIEF_VALVE, relief_valve, a="supply", b="tank")
    net.add("anti_cavitation_supply", CHECK_VALVE, anti_cavitation_valves, a="tank", b="supply")
    for side, loaded, other in (("a", load_side, far_side), ("b", far_side, load_side)):
        chamber = f"chamber_{side}"
        to_pump, to_tank = Connection(loaded, (f"{LOOP}.side",)), Connection(other, (f"{LOOP}.side",))
        net.add(f"supply_valve_{side}", PROPORTIONAL_VALVE, two_way_valves, a="supply", b=chamber, command=to_pump)
        net.add(f"return_valve_{side}", PROPORTIONAL_VALVE, two_way_valves, a=chamber, b="tank", command=to_tank)
        net.add(f"anti_cavitation_{side}", CHECK_VALVE, anti_cavitation_valves, a="tank", b=chamber)
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


def loaded_cylinder(
    cylinder: Cylinder, chambers: tuple[Vessel, Vessel], load: Load, friction: RodFriction, stops: EndStop
) -> LoadedCylinder:
    """A cylinder between its two chambers, with what it moves."""
    return LoadedCylinder(
        cylinder=cylinder,
        chamber_a=chambers[0],
        chamber_b=chambers[1],
        load=load,
        friction=friction,
        end_stops=stops,
    )


def _add_variable_pump(net: Network, pump: VariablePump, inlet: str, outlet: str) -> None:
    """A pump between two nodes whose flow the loop commands, and what leaks back through it."""
    net.add("pump", FLOW_SOURCE, FlowSource(), a=inlet, b=outlet, flow=f"{LOOP}.flow")
    net.add("pump_leakage", LAMINAR_GAP, LaminarGap(conductance=pump.leakage_conductance), a=outlet, b=inlet)


def _add_closed_pump(
    net: Network, pump: VariablePump, charge: ChargeSupply, line: tuple[Vessel, ReliefValve, ShockValve]
) -> None:
    """A pump between both chambers, and the charge line: its pump, its relief valve, and those of both chambers."""
    vessel, charge_relief, relief = line
    net.values["charge"] = charge
    net.volume("charge_line", vessel, start="initial.supply_pressure")
    _add_variable_pump(net, pump, "chamber_b", "chamber_a")
    net.add("charge_pump", FLOW_SOURCE, FlowSource(), a="tank", b="charge_line", flow=charge.flow)
    net.add("charge_relief_valve", RELIEF_VALVE, charge_relief, a="charge_line", b="tank")
    for side in "ab":
        net.add(f"relief_valve_{side}", SHOCK_VALVE, relief, a=f"chamber_{side}", b="charge_line")
