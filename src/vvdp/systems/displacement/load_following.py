"""Rivals whose pump follows the load: load sensing for one to three cylinders, and a fixed pump that is bled off.

Source  wang2017, section 1.1
"""

from vvdp.components.controlled_valves import COMPENSATED_THROTTLE, PROPORTIONAL_VALVE
from vvdp.components.directional_valves import ThrottledDirectionalValve
from vvdp.components.machines import CONTROLLED_PUMP, PUMP
from vvdp.components.self_acting_valves import RELIEF_VALVE
from vvdp.control.reference import ReferenceFilter
from vvdp.fluid.oil import Oil
from vvdp.hydraulics.compensated_throttle import CompensatedThrottle, flow_opening
from vvdp.hydraulics.cylinder import Cylinder
from vvdp.hydraulics.friction import RodFriction
from vvdp.hydraulics.proportional_valve import ProportionalValve
from vvdp.hydraulics.pump import Pump
from vvdp.hydraulics.relief_valve import ReliefValve
from vvdp.hydraulics.rod import EndStop
from vvdp.hydraulics.variable_pump import PumpControl, held_level
from vvdp.hydraulics.volume import Vessel
from vvdp.network.network import Network
from vvdp.network.nodes import Connection, Load
from vvdp.systems.displacement.cylinder_load import InitialCylinder
from vvdp.systems.displacement.duty_cycle import DutyCycle
from vvdp.systems.displacement.rival_loop import BLEED_LOOP, ONE_WAY_LOOP, LoopTable
from vvdp.systems.displacement.rival_tables import PumpDrive
from vvdp.systems.displacement.rivals import (
    LOOP,
    SUFFIXES,
    Rival,
    add_throttled_valve,
    further_rivals,
    loaded_cylinder,
)


def load_sensing(
    oil: Oil,
    pump: Pump,
    pump_drive: PumpDrive,
    pump_control: PumpControl,
    pump_line: Vessel,
    relief_valve: ReliefValve,
    flow_valve: CompensatedThrottle,
    supply_line: Vessel,
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
    second: DutyCycle | None = None,
    third: DutyCycle | None = None,
) -> Network:
    """A variable pump that holds a margin above the highest load; before each cylinder a pressure compensator and a
    metering throttle.

    Cylinders and valves are alike; `second` and `third` are the duty cycles of further ones, which start at rest.
    """
    moved = loaded_cylinder(cylinder, (chamber_a, chamber_b), load, friction, end_stops)
    first = Rival(oil=oil, moved=moved, duty_cycle=duty_cycle, reference=reference, loop=loop, initial=initial)
    limits = pump.displacement * pump_drive.speed.extremes[0], directional_valve.return_conductance
    net = first.network(ONE_WAY_LOOP, first.settings(*limits), "supply")
    net.values["pump_drive"] = pump_drive
    net.driven_shaft("pump_shaft", pump_drive.speed)
    net.volume("pump_line", pump_line, start="initial.supply_pressure")
    rivals = further_rivals(first, second, third)
    for suffix, rival in rivals.items():
        supply = "supply" + suffix
        if suffix:
            rival.add_actuator(net, ONE_WAY_LOOP, rival.settings(*limits), supply, suffix)
        net.volume(supply, supply_line, start=f"initial{suffix}.supply_pressure")
        opening = Connection(flow_opening, (flow_valve, f"{LOOP}{suffix}.flow"))
        net.add("flow_valve" + suffix, COMPENSATED_THROTTLE, flow_valve, a="pump_line", b=supply, command=opening)
        add_throttled_valve(net, directional_valve, suffix)
    add_following_pump(net, pump, pump_control, relief_valve, [f"supply{suffix}.pressure" for suffix in rivals])
    return net


def bleed_off_control(
    oil: Oil,
    pump: Pump,
    pump_drive: PumpDrive,
    bleed_valve: ProportionalValve,
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
    """Fixed pump at the pressure of its load: a throttle beside the cylinder lets what it does not take to the tank."""
    moved = loaded_cylinder(cylinder, (chamber_a, chamber_b), load, friction, end_stops)
    rival = Rival(oil=oil, moved=moved, duty_cycle=duty_cycle, reference=reference, loop=loop, initial=initial)
    flow = pump.displacement * pump_drive.speed.extremes[0]
    settings = rival.settings(flow, directional_valve.return_conductance, bleed_valve.conductance)
    net = rival.network(BLEED_LOOP, settings, "supply")
    net.values["pump_drive"] = pump_drive
    net.volume("supply", supply_line, start="initial.supply_pressure")
    net.driven_shaft("pump_shaft", pump_drive.speed)
    net.add("pump", PUMP, pump, inlet="tank", outlet="supply", shaft="pump_shaft")
    net.add("relief_valve", RELIEF_VALVE, relief_valve, a="supply", b="tank")
    net.add("bleed_valve", PROPORTIONAL_VALVE, bleed_valve, a="supply", b="tank", command=f"{LOOP}.bleed")
    add_throttled_valve(net, directional_valve)
    return net


def add_following_pump(
    net: Network, pump: Pump, control: PumpControl, relief_valve: ReliefValve, loads: list[str]
) -> None:
    """A controlled pump that feels the pressures at the paths `loads`, and the relief valve of its line."""
    felt = (loads * len(SUFFIXES))[: len(SUFFIXES)]
    level = Connection(held_level, (control, *felt))
    ports = {"inlet": "tank", "outlet": "pump_line", "shaft": "pump_shaft"}
    net.add("pump", CONTROLLED_PUMP, pump, control, level=level, **ports)
    net.add("relief_valve", RELIEF_VALVE, relief_valve, a="pump_line", b="tank")
