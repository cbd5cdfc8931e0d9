"""Results that no machine could show: pressures and speeds beyond all components, relief valves that stay closed,
throttles that are laminar at any drop; and orifices that throttle nothing, which may be meant."""

import math
from collections.abc import Iterator, Mapping

from vvdp.base.display import with_unit
from vvdp.base.kinds import FLOW, PRESSURE_DIFFERENCE, SPEED, VELOCITY
from vvdp.hydraulics.line import Line
from vvdp.hydraulics.orifice import Orifice
from vvdp.hydraulics.pipe import LinePipe
from vvdp.hydraulics.relief_valve import LoadReliefValve, ReliefValve
from vvdp.network.network import Part
from vvdp.network.nodes import HydraulicNode, Junction, OilVolume, Shaft
from vvdp.systems.bound import Bound
from vvdp.systems.extras import LoadedSystem
from vvdp.systems.limits import Limits

ABOVE_SETTING = 1.2
"""Pressure above the outside, over that at which a relief valve passes its rated flow, from which one that stays closed
is a mistake."""


LARGEST_TRANSITION = 20e5
"""Drop up to which a throttle may be laminar [Pa]: an orifice of 1 mm turns turbulent at some bar."""


LEAST_SHARE = 15.0**-0.5
"""Drop of an orifice over its transition pressure below which it passes less than half of what the root law has."""
LEAST_FLOW = 1e-6
"""Mean flow from which an orifice is to throttle [m^3/s]: less leads to a volume that only breathes."""


def plausible_bounds(system: LoadedSystem, found: Mapping[str, float | bool]) -> Iterator[Bound]:
    """The bounds of what components can take, at what a run has `found`: the nodes that go furthest."""
    limits = system.tables.get("limits") or Limits()
    nodes = system.circuit.network.nodes
    highest = {name: _highest(system, found, name) for name, node in nodes.items() if isinstance(node, HydraulicNode)}
    if highest:
        top = max(highest, key=highest.__getitem__)
        yield Bound(
            label=f"highest absolute pressure, at {top.replace('_', ' ')}",
            kind=PRESSURE_DIFFERENCE,
            low=highest[top],
            high=highest[top],
            most=limits.largest_pressure,
            otherwise="no component stands it: is a unit wrong, a port the wrong way round, or a relief valve missing? "
            "limits.largest_pressure moves the limit",
        )
    for name, node in nodes.items():
        if isinstance(node, Shaft):
            ends = (float(found[f"speed_{end}_{name}_rad_s"]) for end in ("min", "max"))
            fastest = max(map(abs, ends))
            yield Bound(
                label=f"speed of {name.replace('_', ' ')}",
                kind=SPEED,
                low=fastest,
                high=fastest,
                most=limits.largest_speed,
                otherwise="no shaft turns so fast: is a unit wrong, or a load missing? limits.largest_speed moves "
                "the limit",
            )
    for part in system.circuit.network.parts.values():
        yield from _velocity(found, part, limits)
        yield from _transitions(part)
        for relief in (value for value in part.values if isinstance(value, ReliefValve)):
            yield from _stays_closed(system, found, part, relief)


def _transitions(part: Part) -> Iterator[Bound]:
    """Of a throttle, the drop up to which its flow is laminar."""
    for transition in (value.transition_pressure for value in part.values if hasattr(value, "transition_pressure")):
        yield Bound(
            label=f"transition pressure of {part.name.replace('_', ' ')}",
            kind=PRESSURE_DIFFERENCE,
            low=transition,
            high=transition,
            most=LARGEST_TRANSITION,
            otherwise="its flow would be laminar up to so large a drop: is a unit wrong?",
        )


def _velocity(found: Mapping[str, float | bool], part: Part, limits: Limits) -> Iterator[Bound]:
    """Of a line or a piece of one, how fast its oil flows in the mean."""
    key = f"flow_mean_{part.name}_m3_s"
    for line in (value for value in part.values if key in found and isinstance(value, Line | LinePipe)):
        velocity = abs(float(found[key])) / (0.25 * math.pi * line.diameter**2)
        yield Bound(
            label=f"mean velocity in {part.name.replace('_', ' ')}",
            kind=VELOCITY,
            low=velocity,
            high=velocity,
            most=limits.largest_velocity,
            otherwise="no line is laid out for it: is a unit wrong, or its diameter? limits.largest_velocity moves the "
            "limit",
        )


def _highest(system: LoadedSystem, found: Mapping[str, float | bool], node: str) -> float:
    """The highest pressure of a node [Pa, absolute]."""
    oil = system.circuit.network.nodes[node].oil  # type: ignore[union-attr]
    return float(found[f"pressure_max_{node}_Pa"]) + float(oil.reference_pressure)


def _stays_closed(
    system: LoadedSystem, found: Mapping[str, float | bool], part: Part, relief: ReliefValve
) -> Iterator[Bound]:
    """Of a relief valve through which nothing flowed, the highest pressure behind it; its setting is its bound.

    Only where a prescribed pressure is before it, which no valve limits: between two volumes either may be the higher.
    """
    if isinstance(relief, LoadReliefValve) or not {"a", "b"} <= part.nodes.keys():
        return
    before = system.circuit.network.nodes[part.nodes["a"]]
    if isinstance(before, OilVolume | Junction) or found.get(f"flow_mean_{part.name}_m3_s") != 0.0:
        return
    highest = _highest(system, found, part.nodes["b"])
    yield Bound(
        label=f"pressure at port b of {part.name.replace('_', ' ')}, through which nothing flowed",
        kind=PRESSURE_DIFFERENCE,
        low=highest,
        high=highest,
        most=ABOVE_SETTING * (relief.cracking_pressure + relief.override_pressure),
        otherwise="it limits the pressure at its port a: are its ports the wrong way round?",
    )


def idle_orifices(system: LoadedSystem, found: Mapping[str, float | bool]) -> Iterator[str]:
    """A sentence for each orifice with a flow that throttles nothing, as one in cm^2 for mm^2; it may be meant so."""
    for part in system.circuit.network.parts.values():
        flow = abs(found.get(f"flow_mean_{part.name}_m3_s", 0.0))
        if flow < LEAST_FLOW or not {"a", "b"} <= part.nodes.keys():
            continue
        ends = part.nodes["a"], part.nodes["b"]
        for orifice in (value for value in part.values if type(value) is Orifice):  # a valve may well open wide
            drop = max(found[f"pressure_max_{a}_Pa"] - found[f"pressure_min_{b}_Pa"] for a, b in (ends, ends[::-1]))
            if drop < LEAST_SHARE * orifice.transition_pressure:
                yield (
                    f"{part.name} throttles nothing: its drop never exceeds {with_unit(drop, PRESSURE_DIFFERENCE)} at "
                    f"{with_unit(flow, FLOW)}; is the unit of its area wrong?"
                )
