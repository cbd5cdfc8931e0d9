"""The spool's surface unwrapped into a plane: barriers, pockets and nozzles as polygons, and their exact overlaps.

u is the arc on the spool surface, z the axial distance; the apex lines of the load pockets are at u = 0, P, 2 P, ...
and z = 0. Points are rows of arrays of shape (n, 2).
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from vvdp.valve.geometry import Openings, barrier_width, helix_slope, nozzle_length, nozzle_width, pitch
from vvdp.valve.rotary import RotaryValve

Points = NDArray[np.float64]
HalfPlane = tuple[float, float, float]
"""(a, b, c) is the side a u + b z <= c."""


def nozzle_outline(valve: RotaryValve, u: float = 0.0, z: float = 0.0, scale: float = 1.0) -> Points:
    """The rhombus of a nozzle round (u, z), counterclockwise [m]."""
    half_width, half_length = 0.5 * scale * nozzle_width(valve), 0.5 * scale * nozzle_length(valve)
    return np.array([(u + half_width, z), (u, z + half_length), (u - half_width, z), (u, z - half_length)])


def nozzle_positions(spool_angle: float, axial_position: float, valve: RotaryValve) -> Points:
    """Centres of the nozzles on the spool's unwrapped surface [m], each within half a turn of u = 0."""
    turn = 2.0 * np.pi * valve.spool_radius
    u = pitch(valve) * np.arange(round(valve.sections)) - valve.spool_radius * spool_angle
    u -= turn * np.floor(u / turn + 0.5)
    return np.column_stack([u, np.full(u.shape, axial_position)])


def load_wedge(number: int, valve: RotaryValve) -> tuple[HalfPlane, HalfPlane]:
    """The two half planes that bound load pocket `number`: both barriers' edges that face it."""
    slope, half_barrier = helix_slope(valve), 0.5 * barrier_width(valve)
    apex = number * pitch(valve)
    return (slope, -1.0, slope * (apex - half_barrier)), (-slope, -1.0, -slope * (apex + half_barrier))


def tank_wedge(number: int, valve: RotaryValve) -> tuple[HalfPlane, HalfPlane]:
    """The two half planes that bound tank pocket `number`, whose apex is half a pitch after the load pocket's."""
    slope, half_barrier = helix_slope(valve), 0.5 * barrier_width(valve)
    apex, L = (number + 0.5) * pitch(valve), valve.helix_length
    return (slope, 1.0, slope * (apex - half_barrier) + L), (-slope, 1.0, -slope * (apex + half_barrier) + L)


def clip_polygon(polygon: Points, sides: Sequence[HalfPlane]) -> Points:
    """The part of a convex polygon that lies within all half planes; no rows where nothing is left."""
    for a, b, c in sides:
        if not len(polygon):
            return polygon
        inside = a * polygon[:, 0] + b * polygon[:, 1] - c
        kept = []
        for start, end, here, there in zip(polygon, np.roll(polygon, -1, 0), inside, np.roll(inside, -1), strict=True):
            if here <= 0.0:
                kept.append(start)
            if here * there < 0.0:
                kept.append(start + (end - start) * here / (here - there))
        polygon = np.array(kept).reshape(-1, 2)
    return polygon


def area(polygon: Points) -> float:
    """Area of a simple polygon, positive when counterclockwise [m^2]."""
    if len(polygon) < 3:
        return 0.0
    u, z = (polygon - polygon[0]).T
    return float(0.5 * np.sum(u * np.roll(z, -1) - z * np.roll(u, -1)))


def open_parts(nozzle: Points, valve: RotaryValve) -> tuple[list[Points], list[Points]]:
    """The parts of a nozzle's outline that see load pockets, and those that see tank pockets."""
    P = pitch(valve)
    numbers = range(int(np.floor(nozzle[:, 0].min() / P)) - 2, int(np.ceil(nozzle[:, 0].max() / P)) + 3)
    load = [part for n in numbers if len(part := clip_polygon(nozzle, load_wedge(n, valve)))]
    tank = [part for n in numbers if len(part := clip_polygon(nozzle, tank_wedge(n, valve)))]
    return load, tank


def clipped_openings(spool_angle: float, axial_position: float, valve: RotaryValve) -> Openings:
    """Open fractions of the nozzles, from clipping their outlines with the pockets' [1].

    Wedges overlap beyond the barriers' tips; their union is counted by inclusion and exclusion of neighbours, and of
    the next but one where a nozzle is nearly a pitch wide.

    Source  ours, docs/models/geometry.md
    """
    whole = nozzle_outline(valve)
    shares = [0.0, 0.0]
    for u, z in nozzle_positions(spool_angle, axial_position, valve):
        for side, wedge in enumerate((load_wedge, tank_wedge)):
            nearest = round(u / pitch(valve))
            sides = [wedge(n, valve) for n in range(nearest - 3, nearest + 4)]
            shares[side] += _union([clip_polygon(whole + (u, z), each) for each in sides], sides) / area(whole)
    return Openings(shares[0] / valve.sections, shares[1] / valve.sections)


def _union(parts: list[Points], sides: list[tuple[HalfPlane, HalfPlane]]) -> float:
    """Area of the union of convex parts of one polygon, each cut out by its half planes, in their order along u.

    Where part i and part j > i meet, all between contain what they share, so the union is the sum of the parts less
    what each shares with the one before.
    """
    shared = [area(clip_polygon(part, before)) for part, before in zip(parts[1:], sides[:-1], strict=True)]
    return sum(area(part) for part in parts) - sum(shared)
