"""Rivals whose pump follows the load: load sensing for one to three cylinders, and a fixed pump that is bled off.

Source  wang2017, section 1.1
"""

from dataclasses import dataclass

from vvdp.components.controlled_valves import COMPENSATED_THROTTLE, PROPORTIONAL_VALVE
from vvdp.components.directional_valves import ThrottledDirectionalValve
from vvdp.components.machines import CONTROLLED_PUMP
from vvdp.components.self_acting_valves import RELIEF_VALVE
from vvdp.hydraulics.compensated_throttle import CompensatedThrottle, flow_opening
from vvdp.hydraulics.proportional_valve import ProportionalValve
from vvdp.hydraulics.variable_pump import PumpControl, held_level
from vvdp.hydraulics.volume import Vessel
from vvdp.machines.rival_loop import BLEED_LOOP, ONE_WAY_LOOP
from vvdp.network.network import Network
from vvdp.network.nodes import Connection
from vvdp.rivals.rivals import LOOP, SUFFIXES, FixedPump, SharedSupply, add_throttled_valve


@dataclass(frozen=True, kw_only=True)
class FollowingPump(SharedSupply, FixedPump):
    """The tables of a pump that holds its pressure above that of its loads, and of the cylinders that it feeds."""

    pump_control: PumpControl
    pump_line: Vessel

    def add_following_pump(self, net: Network, loads: list[str]) -> None:
        """Add a controlled pump that receives the pressures at the paths `loads`, and the relief valve of its line."""
        felt = (loads * len(SUFFIXES))[: len(SUFFIXES)]
        level = Connection(held_level, (self.pump_control, *felt))
        ports = {"inlet": "tank", "outlet": "pump_line", "shaft": "pump_shaft"}
        net.add("pump", CONTROLLED_PUMP, self.pump, self.pump_control, level=level, **ports)
        net.add("relief_valve", RELIEF_VALVE, self.relief_valve, a="pump_line", b="tank")


@dataclass(frozen=True, kw_only=True)
class LoadSensing(FollowingPump):
    """The tables of load sensing."""

    flow_valve: CompensatedThrottle
    supply_line: Vessel
    directional_valve: ThrottledDirectionalValve


def load_sensing(tables: LoadSensing) -> Network:
    """A variable pump that holds a margin above the highest load; before each cylinder a pressure compensator and a
    metering throttle.

    Cylinders and valves are alike; further ones start at rest.
    """
    flow_valve = tables.flow_valve
    limits = tables.largest_flow, tables.directional_valve.return_conductance
    net = tables.network(ONE_WAY_LOOP, tables.settings(*limits), "supply")
    tables.add_shaft(net)
    net.volume("pump_line", tables.pump_line, start="initial.supply_pressure")
    rivals = tables.rivals
    for suffix, rival in rivals.items():
        supply = "supply" + suffix
        if suffix:
            rival.add_actuator(net, ONE_WAY_LOOP, rival.settings(*limits), supply, suffix)
        net.volume(supply, tables.supply_line, start=f"initial{suffix}.supply_pressure")
        opening = Connection(flow_opening, (flow_valve, f"{LOOP}{suffix}.flow"))
        net.add("flow_valve" + suffix, COMPENSATED_THROTTLE, flow_valve, a="pump_line", b=supply, command=opening)
        add_throttled_valve(net, tables.directional_valve, suffix)
    tables.add_following_pump(net, [f"supply{suffix}.pressure" for suffix in rivals])
    return net


@dataclass(frozen=True, kw_only=True)
class BleedOff(FixedPump):
    """The tables of a fixed pump that is bled off."""

    bleed_valve: ProportionalValve
    supply_line: Vessel
    directional_valve: ThrottledDirectionalValve


def bleed_off_control(tables: BleedOff) -> Network:
    """Fixed pump at the pressure of its load: a throttle beside the cylinder lets what it does not take to the tank."""
    bleed, valve = tables.bleed_valve, tables.directional_valve
    settings = tables.settings(tables.largest_flow, valve.return_conductance, bleed.conductance)
    net = tables.network(BLEED_LOOP, settings, "supply")
    net.volume("supply", tables.supply_line, start="initial.supply_pressure")
    tables.add_pump(net, "supply")
    net.add("bleed_valve", PROPORTIONAL_VALVE, bleed, a="supply", b="tank", command=f"{LOOP}.bleed")
    add_throttled_valve(net, valve)
    return net
