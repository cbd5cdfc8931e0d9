"""Checks of the geometric consistency of a valve and its shape."""

from collections.abc import Iterator

import numpy as np

from vvdp.geometry.shape import (
    ValveShape,
    collector_position,
    outlet_width,
    rail_arc,
    sleeve_half_length,
    sleeve_radius,
)
from vvdp.valve.geometry import barrier_width, helix_slope, nozzle_length, nozzle_width
from vvdp.valve.rotary import RotaryValve


def contradictions(shape: ValveShape, valve: RotaryValve) -> Iterator[str]:
    """Everything for which valve and shape together cannot be made, with numbers."""
    yield from _spool_faults(shape, valve)
    yield from _channel_faults(shape, valve)
    yield from _duct_faults(shape, valve)
    yield from _wall_faults(shape, valve)


def _at_most(name: str, value: float, bound: float, what: str) -> Iterator[str]:
    if not value < bound:
        yield f"{name} = {_mm(value)}; expected less than {_mm(bound)}, {what}"


def _at_least(name: str, value: float, bound: float, what: str) -> Iterator[str]:
    if not value > bound:
        yield f"{name} = {_mm(value)}; expected more than {_mm(bound)}, {what}"


def _spool_faults(shape: ValveShape, valve: RotaryValve) -> Iterator[str]:
    """Of barriers, pockets, shell and windows."""
    R, N = valve.spool_radius, valve.sections
    pitch = 2.0 * np.pi * R / N
    yield from _at_most("nozzle width", nozzle_width(valve), pitch, "the pitch")
    thickness = barrier_width(valve) * helix_slope(valve) / np.hypot(1.0, helix_slope(valve))
    gap = 2.0 * valve.radial_clearance
    yield from _at_least("barrier width across", thickness, gap, "twice the radial clearance (lap ratio too small)")
    yield from _at_most("hub_radius", shape.hub_radius, R, "the spool radius (no pocket left)")
    yield from _at_most(
        "chamber_inner_radius", shape.chamber_inner_radius, shape.chamber_outer_radius, "its outer radius"
    )
    yield from _at_most(
        "chamber_outer_radius", shape.chamber_outer_radius, R, "the spool radius (the shell has no wall)"
    )
    yield from _at_least("chamber_outer_radius", shape.chamber_outer_radius, shape.hub_radius, "the hub radius")
    if not N * 2.0 * shape.window_half_angle < 0.98 * 2.0 * np.pi:
        total = np.degrees(2.0 * N * shape.window_half_angle)
        yield f"the {N:g} windows together take {total:.3g} deg; expected less than 353 deg"


def _channel_faults(shape: ValveShape, valve: RotaryValve) -> Iterator[str]:
    """Of nozzles and outlet channels."""
    R = valve.spool_radius
    width = outlet_width(shape, valve) * max(shape.outlet_entry_taper, 1.0)
    yield from _at_most(
        "outlet_arm and half a channel",
        shape.outlet_arm + 0.5 * width,
        shape.chamber_outer_radius,
        "the chamber's outer radius (the jets would miss it)",
    )
    if shape.outlet_arm < shape.chamber_outer_radius:
        slope = np.sqrt(1.0 - (shape.outlet_arm / shape.chamber_outer_radius) ** 2)
        room = 2.0 * np.pi * shape.chamber_outer_radius * slope / shape.outlet_blades
        yield from _at_most("width of an outlet channel", width, 0.95 * room, "what its share of the shell leaves")
    yield from _at_most("nozzle_arm", shape.nozzle_arm, 0.97 * R, "97 % of the spool radius (the jets would miss it)")
    if shape.nozzle_taper < 1.0:
        yield f"nozzle_taper = {shape.nozzle_taper:g}; expected 1 or more, wider at the root"
    root = shape.nozzle_taper * nozzle_length(valve)
    yield from _at_most(
        "length of a nozzle's root", root, shape.rail_diameter, "the rail diameter (it would stick out)"
    )
    yield from _at_most(
        "nozzle width at the root", shape.nozzle_taper * nozzle_width(valve), shape.rail_diameter, "the rail diameter"
    )


def _duct_faults(shape: ValveShape, valve: RotaryValve) -> Iterator[str]:
    """Of inlet rail and collector."""
    R, rail, collector = valve.spool_radius, 0.5 * shape.rail_diameter, 0.5 * shape.collector_diameter
    yield from _at_least(
        "inside of the rail",
        shape.rail_radius - rail,
        R + 0.05 * R,
        "1.05 spool radii (the rail would open into the spool)",
    )
    ends = 2.0 * np.arcsin(min(rail / shape.rail_radius, 1.0))
    if not rail_arc(shape, valve) + ends < 2.0 * np.pi:
        yield (
            f"the rail spans {np.degrees(rail_arc(shape, valve) + ends):.4g} deg with its ends; expected less than "
            "360 deg (rail_lead and rail_tail too large)"
        )
    if shape.rail_port_angle > rail_arc(shape, valve):
        yield (
            f"rail_port_angle = {np.degrees(shape.rail_port_angle):.4g} deg; expected at most the "
            f"{np.degrees(rail_arc(shape, valve)):.4g} deg of the rail"
        )
    yield from _at_most("rail_port_diameter", shape.rail_port_diameter, shape.rail_diameter, "the rail diameter")
    yield from _at_most(
        "collector_port_diameter", shape.collector_port_diameter, shape.collector_diameter, "the collector diameter"
    )
    yield from _at_most(
        "inside of the collector",
        shape.collector_radius - collector,
        R + shape.groove_depth,
        "spool radius and groove_depth (it would not meet the groove)",
    )
    yield from _at_least(
        "collector_radius", shape.collector_radius, R + shape.groove_depth, "spool radius and groove_depth"
    )


def _wall_faults(shape: ValveShape, valve: RotaryValve) -> Iterator[str]:
    """Of what is left between the hollow spaces, and outside them."""
    rail, collector = 0.5 * shape.rail_diameter, 0.5 * shape.collector_diameter
    apart = collector_position(shape, valve) - collector - rail
    yield from _at_least("wall between inlet rail and collector", apart, 0.0, "zero")
    reach = sleeve_half_length(shape, valve) - collector_position(shape, valve) - collector
    yield from _at_least("wall between collector and end of the sleeve", reach, 0.0, "zero")
    yield from _at_least(
        "rail_radius and port_length",
        shape.rail_radius + shape.port_length,
        sleeve_radius(shape),
        "the sleeve's outer radius (the port would end inside)",
    )
    yield from _at_least(
        "collector_radius and port_length",
        shape.collector_radius + shape.port_length,
        sleeve_radius(shape),
        "the sleeve's outer radius (the port would end inside)",
    )


def _mm(length: float) -> str:
    return f"{1e3 * length:.4g} mm"
