"""Spool and sleeve as solids, from whichever kernel makes them.

Spool coordinates: z along the axis, the apex lines of the load pockets at angles 0, 2 pi/N, ... and z = 0, the load's
outlet towards +z. Sleeve coordinates: mouths of the nozzles at the same angles and z = 0. A spool turned by its angle
and moved by -x stands in the sleeve at axial position x. Jets and rotation are positive about +z.
"""

import numpy as np

from vvdp.base.errors import ParameterError
from vvdp.geometry.facets import FINENESS, Faceted
from vvdp.geometry.kernel import Floats, Kernel, S, around, union
from vvdp.geometry.mesh import Mesh, require_sound
from vvdp.geometry.shape import (
    ValveShape,
    collector_position,
    groove_length,
    nozzle_lag,
    nozzle_reach,
    outlet_width,
    rail_arc,
    sleeve_half_length,
    sleeve_radius,
    stations,
)
from vvdp.valve.geometry import barrier_width, helix_slope, nozzle_length, nozzle_width, pitch
from vvdp.valve.rotary import RotaryValve

OVERLAP = 1.6e-3
"""By how much parts of a domain overlap so that no two faces coincide, over the spool radius: 20 um on 12.7 mm."""
COARSEST = 10.0
"""Least edges per spool radius. A cylinder of n = ceil(2 pi f) edges dips R (1 - cos(pi/n)) inside: with f = 10 it is
1.2e-3 R, within OVERLAP; from f = 8.7 downwards (n = 55) more than that, and parts turned to each other leave gaps."""
BEYOND = 0.06
"""By how much a cutter reaches beyond what it cuts, over the spool radius."""


def facet_kernel(valve: RotaryValve, fineness: float = FINENESS) -> Faceted:
    """The kernel of facets with `fineness` edges per spool radius. Raises ParameterError where they are too coarse."""
    if not fineness >= COARSEST:
        raise ParameterError(
            f"{fineness:g} edges per spool radius; expected at least {COARSEST:g}, as coarser parts of the oil do not "
            f"overlap everywhere"
        )
    return Faceted(valve.spool_radius / fineness)


def wrap(u: Floats, z: Floats, r: Floats, radius: float) -> Floats:
    """Points of the unwrapped surface of `radius`, at radii r."""
    return np.stack([r * np.cos(u / radius), r * np.sin(u / radius), z], axis=-1)


def spool_reach(shape: ValveShape, valve: RotaryValve) -> tuple[float, float]:
    """Both ends of the spool in its own coordinates [m]."""
    end = stations(shape, valve).spool_end
    return valve.helix_length - end, end


def pocket_cutter(shape: ValveShape, valve: RotaryValve, kernel: Kernel[S]) -> S:
    """Body that is cut out of the spool for the load pockets, their ring, the windows and the ring behind them.

    It reaches beyond the spool's surface; the part within is the fluid.
    """
    at, R, N = stations(shape, valve), valve.spool_radius, valve.sections
    low, high = shape.hub_radius - BEYOND * R, R + BEYOND * R
    P, slope, gap = pitch(valve), helix_slope(valve), shape.pocket_gap
    # The sides go on a third of the gap beyond the barriers' tips, so that neighbours overlap there.
    half = 0.5 * P + gap / (3.0 * slope)
    apex = 0.5 * barrier_width(valve) * slope
    shoulder = apex + half * slope
    corners = np.array([(0.0, apex), (half, shoulder), (0.0, at.tip + 0.7 * gap), (-half, shoulder)])
    side = float(np.hypot(half, half * slope))

    def kite(a: Floats, b: Floats, c: Floats) -> Floats:
        weights = np.stack([(1 - a) * (1 - b), a * (1 - b), a * b, (1 - a) * b], -1)
        u, z = np.moveaxis(weights @ corners, -1, 0)
        return wrap(u, z, low + c * (high - low), R)

    def window(a: Floats, b: Floats, c: Floats) -> Floats:
        z = at.pocket_end - OVERLAP * R + b * (shape.window_length + 2.0 * OVERLAP * R)
        return wrap((2.0 * a - 1.0) * shape.window_half_angle * R, z, low + c * (high - low), R)

    cut = [
        around(kernel.mapped_box("spool", kite, (side, side, high - low)), N),
        around(kernel.mapped_box("windows", window, (2.0 * shape.window_half_angle * R, 0.0, 0.0)), N),
        kernel.cylinder("spool", high, at.tip + gap / 6.0, at.pocket_end),
        kernel.cylinder("spool", high, at.window_end, at.ring_end),
    ]
    return union(cut) - kernel.cylinder("spool", shape.hub_radius, -at.spool_end, 2.0 * at.spool_end)


def chamber_cutter(shape: ValveShape, valve: RotaryValve, start: float, kernel: Kernel[S]) -> S:
    """The annular chamber of the outlet turbine from `start` to the end of its channels."""
    end = stations(shape, valve).chamber_end
    outer = kernel.cylinder("chamber", shape.chamber_outer_radius, start, end)
    return outer - kernel.cylinder("chamber", shape.chamber_inner_radius, start - end, 2.0 * end)


def channel_cutter(shape: ValveShape, valve: RotaryValve, reach: float, kernel: Kernel[S]) -> S:
    """The straight channels of the outlet turbine, from within the chamber to the cylinder of radius `reach`.

    They taper from the shell's inside to the mouth on the spool's surface, where their width is that of `outlet_width`.
    """
    at, R, arm = stations(shape, valve), valve.spool_radius, shape.outlet_arm
    width, taper = outlet_width(shape, valve), shape.outlet_entry_taper
    half = 0.5 * width * max(taper, 1.0)
    entry = np.sqrt(shape.chamber_outer_radius**2 - (arm + half) ** 2)
    mouth = np.sqrt(R**2 - arm**2)
    start, end = entry - BEYOND * R, np.sqrt((reach + BEYOND * R) ** 2 - max(arm - half, 0.0) ** 2)
    inset = 1e-3 * shape.outlet_height  # ends of chamber and channels do not coincide

    def channel(a: Floats, b: Floats, c: Floats) -> Floats:
        s = start + a * (end - start)
        size = taper + (1.0 - taper) * (s - entry) / (mouth - entry)
        z = at.channel_start + c * (shape.outlet_height - inset)
        return np.stack([s, arm + (b - 0.5) * width * size, z], axis=-1)

    channels = around(kernel.mapped_box("channels", channel, (0.0, 0.0, 0.0)), shape.outlet_blades)
    low, high = at.channel_start - shape.outlet_height, at.chamber_end + shape.outlet_height
    return channels & kernel.cylinder("channels", reach, low, high)


def spool_part(shape: ValveShape, valve: RotaryValve, kernel: Kernel[S]) -> S:
    """The spool: barriers on a hub, windows and an outlet turbine on either side, end lands."""
    low, high = spool_reach(shape, valve)
    R, ring_end = valve.spool_radius, stations(shape, valve).ring_end
    load = union(
        [
            pocket_cutter(shape, valve, kernel),
            chamber_cutter(shape, valve, ring_end - OVERLAP * R, kernel),
            channel_cutter(shape, valve, R * (1.0 + BEYOND), kernel),
        ]
    )
    tank = load.mirror(0.5 * valve.helix_length).rotate(np.pi / valve.sections)
    return kernel.cylinder("spool", R, low, high) - (load + tank)


def spool(shape: ValveShape, valve: RotaryValve, fineness: float = FINENESS) -> Mesh:
    """Surface of the spool, in its own coordinates. Raises RunError where it is not what it should be.

    Source  ours, docs/models/geometry.md
    """
    mesh = spool_part(shape, valve, facet_kernel(valve, fineness)).mesh()
    return require_sound(mesh, "spool", 1, 2 * round(shape.outlet_blades))


def nozzle(shape: ValveShape, valve: RotaryValve, bore: float, end: float, kernel: Kernel[S]) -> S:
    """The nozzle at angle 0, from a little within the bore to `end` along its axis, counted outwards from its mouth.

    The mouth, at 0, is the rhombus of the hydraulic model, wrapped on the bore; the section grows linearly from there.
    """
    R, arm = valve.spool_radius, shape.nozzle_arm
    width, length = nozzle_width(valve), nozzle_length(valve)
    outwards = np.array([np.sqrt(1.0 - (arm / bore) ** 2), -arm / bore, 0.0])
    centre, start = np.array([bore, 0.0, 0.0]), -4.0 * OVERLAP * R
    growth = (shape.nozzle_taper - 1.0) / nozzle_reach(shape, valve)

    def sweep(a: Floats, b: Floats, c: Floats) -> Floats:
        u, z = 0.5 * width * (a - b), 0.5 * length * (a + b - 1.0)
        t = (start + c * (end - start))[:, None]
        mouth = wrap(u, z, np.full(u.shape, bore), R)
        points: Floats = centre + t * outwards + (1.0 + growth * t) * (mouth - centre)
        return points

    # Twice as fine as the rest: what the spool opens is measured here.
    side = float(np.hypot(width, length))
    return kernel.mapped_box("nozzles", sweep, (side, side, 0.0))


def rail_angles(shape: ValveShape, valve: RotaryValve) -> tuple[float, float]:
    """Angles of both ends of the rail's centre line [rad]; the first nozzle's mouth is at 0."""
    begin = -nozzle_lag(shape, valve) - shape.rail_lead
    return begin, begin + rail_arc(shape, valve)


def port_angle(shape: ValveShape, valve: RotaryValve) -> float:
    """Angle of all ports [rad], of the rail and of the collectors."""
    return rail_angles(shape, valve)[0] + shape.rail_port_angle


def rail(shape: ValveShape, valve: RotaryValve, kernel: Kernel[S]) -> S:
    """The inlet rail: an arc of a torus with a hemisphere at either end."""
    return kernel.bent_rod("rail", shape.rail_radius, 0.5 * shape.rail_diameter, *rail_angles(shape, valve))


def nozzles(shape: ValveShape, valve: RotaryValve, bore: float, kernel: Kernel[S]) -> S:
    """All nozzles, from a little within the bore to the rail's centre line."""
    return around(nozzle(shape, valve, bore, nozzle_reach(shape, valve), kernel), valve.sections)


def rail_port(shape: ValveShape, valve: RotaryValve, kernel: Kernel[S]) -> S:
    """The port of the inlet rail, reaching beyond its end."""
    far = shape.rail_radius + shape.port_length + BEYOND * valve.spool_radius
    angle = port_angle(shape, valve)
    return kernel.radial_cylinder("rail", 0.5 * shape.rail_port_diameter, angle, shape.rail_radius, far, 0.0)


def collector(shape: ValveShape, valve: RotaryValve, kernel: Kernel[S]) -> S:
    """Groove and torus that collect the outlet turbine's flow on the load side, reaching into the bore."""
    R, z, half = valve.spool_radius, collector_position(shape, valve), 0.5 * groove_length(shape, valve)
    groove = kernel.cylinder("collector", R + shape.groove_depth, z - half, z + half)
    core = kernel.cylinder("collector", R - BEYOND * R, z - 2.0 * half, z + 2.0 * half)
    return kernel.ring("collector", shape.collector_radius, 0.5 * shape.collector_diameter, z) + (groove - core)


def collector_port(shape: ValveShape, valve: RotaryValve, kernel: Kernel[S]) -> S:
    """The port of the load's collector, reaching beyond its end."""
    radius, near = 0.5 * shape.collector_port_diameter, shape.collector_radius
    far = near + shape.port_length + BEYOND * valve.spool_radius
    angle = port_angle(shape, valve)
    return kernel.radial_cylinder("collector", radius, angle, near, far, collector_position(shape, valve))


def sleeve_part(shape: ValveShape, valve: RotaryValve, kernel: Kernel[S]) -> S:
    """The sleeve with bore, nozzles, inlet rail, both outlet collectors and three ports."""
    half, bore = sleeve_half_length(shape, valve), valve.spool_radius + valve.radial_clearance
    outlet = collector(shape, valve, kernel) + collector_port(shape, valve, kernel)
    cut = [
        rail(shape, valve, kernel),
        nozzles(shape, valve, bore, kernel),
        rail_port(shape, valve, kernel),
        outlet,
        outlet.mirror(),
        kernel.cylinder("bore", bore, -2.0 * half, 2.0 * half),
    ]
    return kernel.cylinder("sleeve", sleeve_radius(shape), -half, half) - union(cut)


def sleeve(shape: ValveShape, valve: RotaryValve, fineness: float = FINENESS) -> Mesh:
    """Surface of the sleeve, in its own coordinates. Raises RunError where it is not what it should be.

    Source  ours, docs/models/geometry.md
    """
    mesh = sleeve_part(shape, valve, facet_kernel(valve, fineness)).mesh()
    return require_sound(mesh, "sleeve", 1, round(valve.sections) + 3)


def half_sleeve(shape: ValveShape, valve: RotaryValve, fineness: float = FINENESS) -> Mesh:
    """The sleeve without its half at x > 0, to be looked into; the cut is the patch `section`."""
    kernel, far = facet_kernel(valve, fineness), 2.0 * (sleeve_half_length(shape, valve) + sleeve_radius(shape))

    def half(a: Floats, b: Floats, c: Floats) -> Floats:
        return far * np.stack([a, 2.0 * b - 1.0, 2.0 * c - 1.0], axis=-1)

    cut = kernel.mapped_box("section", half, (0.0, 0.0, 0.0))
    return (sleeve_part(shape, valve, kernel) - cut).mesh()
