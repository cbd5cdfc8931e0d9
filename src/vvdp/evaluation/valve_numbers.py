"""Numbers that a rotary valve adds to those of any drawn circuit: frequency, opening, cavitation, losses."""

from collections.abc import Iterator, Mapping
from typing import NamedTuple

import numpy as np

from vvdp.base.kinds import FRACTION, FREQUENCY, MEAN_POWER, Kind
from vvdp.base.signal import signal_value
from vvdp.components.rotary_valve import ROTARY_VALVE
from vvdp.evaluation.bench_parts import shows_all
from vvdp.evaluation.bench_validity import ValveReading, duty_bound, efficiency, transition_loss, valve_bounds
from vvdp.fluid.oil import density
from vvdp.network.network import Network, Part
from vvdp.network.nodes import DrivenShaft, HydraulicNode
from vvdp.systems.bound import Bound
from vvdp.systems.extras import LoadedSystem, Summary
from vvdp.systems.spool_travel import travel_of
from vvdp.valve.losses import full_open_loss
from vvdp.valve.rotary import RotaryValve
from vvdp.valve.torque import pwm_frequency


class PlacedValve(NamedTuple):
    """A rotary valve in a circuit, and what its numbers are called by: the part that it is alone in, else itself."""

    name: str
    part: Part

    @property
    def values(self) -> RotaryValve:
        """Its values."""
        return next(value for value in self.part.values if isinstance(value, RotaryValve))


def placed_valves(network: Network) -> Iterator[PlacedValve]:
    """The rotary valves of a network."""
    valves = [part for part in network.parts.values() if part.component is ROTARY_VALVE]
    for valve in valves:
        owners = [name for name, circuit in network.circuits.items() if valve.name in circuit.names]
        alone = [name for name in owners if sum(each.name in network.circuits[name].names for each in valves) == 1]
        yield PlacedValve(alone[0] if alone else valve.name, valve)


def driven_spools(network: Network) -> dict[str, DrivenShaft]:
    """The shafts of rotary valves whose speed is prescribed or commanded, by name."""
    spools = {
        name: network.nodes[name] for name in (str(valve.part.nodes["spool"]) for valve in placed_valves(network))
    }
    return {name: node for name, node in spools.items() if isinstance(node, DrivenShaft)}


def valve_numbers(system: LoadedSystem, means: Mapping[str, float], found: Summary) -> Summary:
    """Numbers of each rotary valve, beside those in `found`; none where the system shows them itself.

    means  of all that the books add up, by its path in them
    """
    numbers = Summary()
    for valve in () if shows_all(system) else placed_valves(system.circuit.network):
        name, own = valve.name, valve.part.name
        reading = valve_reading(system, valve, found)
        drops = sum(means[f"spent.{own}.{loss}"] for loss in ("nozzle", "centre_section", "outlet_turbine"))
        rho = density(reading.temperature, reading.oil)
        open_loss = full_open_loss(reading.flow, rho, valve.values) if reading.flow > 0.0 else 0.0
        numbers |= {
            f"{name}_pwm_frequency_Hz": reading.pwm_frequency,
            f"{name}_load_opening": means[f"totals.{own}_load_opening"],
            f"{name}_cavitation_share": float(np.clip(means[f"totals.{own}_cavitating"], 0.0, 1.0)),
            f"loss_{name}_full_open_W": open_loss,
            f"loss_{name}_transition_W": transition_loss(drops - open_loss, drops),
        }
        if shaft := own_shaft(system.circuit.network, valve.part.nodes["inlet"]):
            put_in = found[f"power_{shaft}_W"] + found.get(f"power_{valve.part.nodes['spool']}_W", 0.0)
            delivered = put_in - unit_loss(system.circuit.network, valve, found)
            numbers[f"{name}_efficiency"] = efficiency(delivered, put_in, found.get("stored_power_W", 0.0))
    return numbers


def own_shaft(network: Network, inlet: str) -> str:
    """The driven shaft that turns the pump at the inlet of a rotary valve and nothing else; empty if there is none."""
    pumps = [part for part in network.parts.values() if part.nodes.get("outlet") == inlet and "shaft" in part.nodes]
    shaft = pumps[0].nodes["shaft"] if len(pumps) == 1 else ""
    on_it = [part for part in network.parts.values() if shaft in part.nodes.values()]
    return shaft if len(on_it) == 1 and isinstance(network.nodes[shaft], DrivenShaft) else ""


def unit_loss(network: Network, valve: PlacedValve, found: Mapping[str, float | bool]) -> float:
    """Mean loss of a rotary valve, and of all that is joined to its inlet or its spool [W]."""
    own = {valve.part.nodes["inlet"], valve.part.nodes["spool"]}
    return sum(
        float(found.get(f"loss_{part.name}_W", 0.0)) for part in network.parts.values() if own & {*part.nodes.values()}
    )


def valve_reading(system: LoadedSystem, valve: PlacedValve, found: Mapping[str, float | bool]) -> ValveReading:
    """Arguments at which a run used the laws of a rotary valve."""
    network, nodes = system.circuit.network, valve.part.nodes
    inlet = network.nodes[nodes["inlet"]]
    assert isinstance(inlet, HydraulicNode)
    speeds = {end: float(found[f"speed_{end}_{nodes['spool']}_rad_s"]) for end in ("mean", "min", "max")}
    return ValveReading(
        valve=valve.values,
        oil=inlet.oil,
        temperature=signal_value(0.0, network.temperature),
        flow=-float(found[f"flow_mean_{valve.part.name}_inlet_m3_s"]),
        pwm_frequency=pwm_frequency(speeds["mean"], valve.values),
        inlet_pressure=float(found[f"pressure_mean_{nodes['inlet']}_Pa"]) + inlet.oil.reference_pressure,
        fastest=max(abs(speeds["min"]), abs(speeds["max"])),
    )


def placed_valve_bounds(system: LoadedSystem, found: Mapping[str, float | bool]) -> Iterator[Bound]:
    """The bounds of the laws of each rotary valve at what a run has `found`."""
    for valve in () if shows_all(system) else placed_valves(system.circuit.network):
        words, length = valve.name.replace("_", " "), valve.values.helix_length
        if travel := travel_of(valve.part.inputs["axial_position"]):
            yield duty_bound(f"duty ratio of {words}", travel.low / length, travel.high / length, valve.values)
        yield from valve_bounds(valve_reading(system, valve, found), words)


def valve_quantities(system: LoadedSystem) -> Iterator[tuple[str, tuple[Kind, str]]]:
    """Kind and label of the numbers of each rotary valve, by key."""
    for valve in () if shows_all(system) else placed_valves(system.circuit.network):
        name, words = valve.name, valve.name.replace("_", " ")
        yield f"{name}_pwm_frequency_Hz", (FREQUENCY, f"{words} PWM frequency")
        yield f"{name}_load_opening", (FRACTION, f"open fraction of the load port of {words}, mean")
        yield f"{name}_cavitation_share", (FRACTION, f"share of the time in which a port of {words} cavitates")
        if own_shaft(system.circuit.network, valve.part.nodes["inlet"]):
            yield f"{name}_efficiency", (FRACTION, f"{words} efficiency, pump shaft to load")
        yield f"loss_{name}_full_open_W", (MEAN_POWER, f"{words} full open loss")
        yield f"loss_{name}_transition_W", (MEAN_POWER, f"{words} transition loss")
