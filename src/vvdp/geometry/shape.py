"""Lengths that the solids of a rotary valve need beyond its hydraulic model, and those that follow."""

from dataclasses import fields
from typing import Annotated, NamedTuple

import numpy as np

from vvdp.base.errors import ParameterError
from vvdp.base.kinds import Area, Count, Kind, Length, Position, Ratio, Volume
from vvdp.base.params import Params
from vvdp.base.rules import refuse, require_positive
from vvdp.geometry.kernel import Floats
from vvdp.valve.geometry import barrier_width, helix_slope, nozzle_length, nozzle_width
from vvdp.valve.rotary import RotaryValve

FixedAngle = Annotated[float, Kind("angle", "rad", 0.0, 2.0 * np.pi, "60 deg", units=("deg", "rad"))]
MaterialDensity = Annotated[float, Kind("density of a material", "kg/m^3", 500.0, 25000.0, "7850 kg/m^3")]


class ValveShape(Params):
    """Dimensions of spool and sleeve that no hydraulic formula uses.

    Along the spool, on either side: the pockets, `pocket_gap` beyond what barriers and nozzles reach over the stroke, a
    land of `window_length` with as many windows as sections, each `window_half_angle` to either side, `ring_length`,
    then the annular chamber of the outlet turbine, whose shell carries `outlet_blades` straight channels. Channels and
    nozzles are tangent to circles of radius `outlet_arm` and `nozzle_arm`; their tapers are entry over mouth, for
    nozzles at the rail's centre line. The rail begins `rail_lead` before the first nozzle's root and ends `rail_tail`
    after the last one's; its port is `rail_port_angle` from where it begins. `stroke_ratio` is the axial
    travel over the helix length.
    """

    hub_radius: Length
    pocket_gap: Length
    window_length: Length
    window_half_angle: FixedAngle
    ring_length: Length
    chamber_inner_radius: Length
    chamber_outer_radius: Length
    outlet_blades: Count
    outlet_height: Length
    outlet_arm: Length
    outlet_entry_taper: Ratio
    stroke_ratio: Ratio
    seal_length: Length
    groove_depth: Length
    groove_margin: Length
    collector_radius: Length
    collector_diameter: Length
    collector_port_diameter: Length
    nozzle_arm: Length
    nozzle_taper: Ratio
    rail_radius: Length
    rail_diameter: Length
    rail_lead: FixedAngle
    rail_tail: FixedAngle
    rail_port_angle: FixedAngle
    rail_port_diameter: Length
    port_length: Length
    sleeve_wall: Length
    spool_density: MaterialDensity

    def check(self) -> None:
        """Refuse lengths that are not there, and blades that are no number of blades."""
        free = ("stroke_ratio", "rail_tail", "rail_port_angle")
        require_positive(self, *(field.name for field in fields(self) if field.name not in free))
        if self.outlet_blades != round(self.outlet_blades):
            refuse(self, "outlet_blades", "must be a whole number")


class Stations(NamedTuple):
    """Axial positions of the load side along the spool [m]; apexes of the barriers' centre lines at 0 and L."""

    tip: Position
    pocket_end: Position
    window_end: Position
    ring_end: Position
    channel_start: Position
    chamber_end: Position
    spool_end: Position


def stations(shape: ValveShape, valve: RotaryValve) -> Stations:
    """Axial positions of the load side along the spool [m]; the tank side is its mirror image about L/2.

    Pockets, chamber and end land are as long as the stroke asks: the nozzles stay within the pockets, pocket and
    outlet groove apart by the sealing length, and the end land of `land_length` whole.

    Source  ours, docs/models/geometry.md
    """
    tip = valve.helix_length + 0.5 * barrier_width(valve) * helix_slope(valve)
    corner = travel(shape, valve).high + 0.5 * nozzle_length(valve)
    pocket_end = max(tip, corner) + shape.pocket_gap
    window_end = pocket_end + shape.window_length
    ring_end = window_end + shape.ring_length
    clear = stroke(shape, valve) + shape.groove_margin
    channel_start = ring_end + clear + shape.seal_length
    chamber_end = channel_start + shape.outlet_height
    spool_end = chamber_end + clear + valve.land_length
    return Stations(
        tip=float(tip),
        pocket_end=float(pocket_end),
        window_end=float(window_end),
        ring_end=float(ring_end),
        channel_start=float(channel_start),
        chamber_end=float(chamber_end),
        spool_end=float(spool_end),
    )


def stroke(shape: ValveShape, valve: RotaryValve) -> float:
    """Axial travel of the spool that the sleeve allows [m], to equal parts on both sides of duty ratio 1/2.

    Source  ours, docs/models/geometry.md
    """
    return shape.stroke_ratio * valve.helix_length


class Travel(NamedTuple):
    """Axial positions between which the spool moves [m]."""

    low: Position
    high: Position


def travel(shape: ValveShape, valve: RotaryValve) -> Travel:
    """Axial positions of the spool that the sleeve allows [m].

    Source  ours, docs/models/geometry.md
    """
    middle, half = 0.5 * valve.helix_length, 0.5 * stroke(shape, valve)
    return Travel(middle - half, middle + half)


def collector_position(shape: ValveShape, valve: RotaryValve) -> float:
    """Distance of either outlet collector from the plane of the nozzles [m].

    Source  ours, docs/models/geometry.md
    """
    at = stations(shape, valve)
    return 0.5 * (at.channel_start + at.chamber_end - valve.helix_length)


def groove_length(shape: ValveShape, valve: RotaryValve) -> float:
    """Axial length of an outlet groove [m].

    Source  ours, docs/models/geometry.md
    """
    return shape.outlet_height + stroke(shape, valve) + 2.0 * shape.groove_margin


def sleeve_half_length(shape: ValveShape, valve: RotaryValve) -> float:
    """Half the length of the sleeve [m].

    Source  ours, docs/models/geometry.md
    """
    return collector_position(shape, valve) + 0.5 * groove_length(shape, valve) + valve.land_length


def sleeve_radius(shape: ValveShape) -> float:
    """Outer radius of the sleeve [m].

    Source  ours, docs/models/geometry.md
    """
    return shape.sleeve_wall + max(
        shape.rail_radius + 0.5 * shape.rail_diameter, shape.collector_radius + 0.5 * shape.collector_diameter
    )


def outlet_width(shape: ValveShape, valve: RotaryValve) -> float:
    """Width of one outlet channel at its mouth, perpendicular to its jet, A_out/(N_b h) [m].

    Source  ours, docs/models/geometry.md
    """
    return valve.outlet_area / (shape.outlet_blades * shape.outlet_height)


def nozzle_reach(shape: ValveShape, valve: RotaryValve) -> float:
    """Length of a nozzle's axis from bore to the rail's centre line, sqrt(R_r^2 - e^2) - sqrt(R^2 - e^2) [m].

    Source  ours, docs/models/geometry.md
    """
    arm = shape.nozzle_arm
    reach: float = np.sqrt(shape.rail_radius**2 - arm**2) - np.sqrt(valve.spool_radius**2 - arm**2)
    return reach


def nozzle_lag(shape: ValveShape, valve: RotaryValve) -> float:
    """Lead angle of a nozzle's mouth over its root on the rail's centre line [rad].

    Source  ours, docs/models/geometry.md
    """
    lag: float = np.arccos(shape.nozzle_arm / shape.rail_radius) - np.arccos(shape.nozzle_arm / valve.spool_radius)
    return lag


def perpendicular_area(shape: ValveShape, valve: RotaryValve) -> Area:
    """Section of all jets perpendicular to them, A_in sqrt(1 - (e/R)^2) [m^2].

    The nozzle area of the hydraulic model is that of the openings in the bore.

    Source  ours, docs/models/geometry.md
    """
    return float(valve.nozzle_area * np.sqrt(1.0 - (shape.nozzle_arm / valve.spool_radius) ** 2))


def rail_volume(shape: ValveShape, valve: RotaryValve) -> Volume:
    """Volume of inlet rail and nozzles without the port [m^3].

    V = pi r^2 R_r phi + 4/3 pi r^3 + N V_n: arc, both hemispheres, and of each nozzle what lies between bore and rail.
    V_n sums thin pyramids along the jet over the mouth, x = m_0 + t j + (1 + g t) (m - m_0), from t = 0 to the wall:
    V_n = integral of (m_u x m_z) . (j + g (m - m_0)) ((1 + g t)^3 - 1)/(3 g) over the rhombus, by Gauss's rule.

    Source  ours, docs/models/geometry.md
    """
    R, arm, r = valve.spool_radius, shape.nozzle_arm, 0.5 * shape.rail_diameter
    width, length = nozzle_width(valve), nozzle_length(valve)
    growth = (shape.nozzle_taper - 1.0) / nozzle_reach(shape, valve)
    jet = np.array([np.sqrt(1.0 - (arm / R) ** 2), -arm / R, 0.0])
    nodes, weights = np.polynomial.legendre.leggauss(8)
    nozzle = 0.0
    for a, weight_a in zip(0.5 + 0.5 * nodes, 0.5 * weights, strict=True):
        for b, weight_b in zip(0.5 + 0.5 * nodes, 0.5 * weights, strict=True):
            turn, z = 0.5 * width * (a - b) / R, 0.5 * length * (a + b - 1.0)
            off = np.array([R * np.cos(turn) - R, R * np.sin(turn), z])
            out = np.array([np.cos(turn), np.sin(turn), 0.0])  # m_u x m_z of a cylinder
            t = _way_to_rail(np.array([R, 0.0, 0.0]) + off, jet + growth * off, shape.rail_radius, r)
            deep = t if growth == 0.0 else ((1.0 + growth * t) ** 3 - 1.0) / (3.0 * growth)
            nozzle += weight_a * weight_b * 0.5 * width * length * float(out @ (jet + growth * off)) * deep
    arc = np.pi * r**2 * shape.rail_radius * rail_arc(shape, valve)
    return float(arc + 4.0 / 3.0 * np.pi * r**3 + valve.sections * nozzle)


def _way_to_rail(start: Floats, direction: Floats, rail_radius: float, r: float) -> float:
    """The least t at which start + t direction enters the torus, by bisection after the first step within."""

    def outside(t: float) -> bool:
        x, y, z = start + t * direction
        return bool((np.hypot(x, y) - rail_radius) ** 2 + z**2 > r**2)

    low, high, step = 0.0, 0.0, 0.02 * rail_radius
    while outside(high):
        low, high = high, high + step
        if high > 2.0 * rail_radius:
            raise ParameterError("a nozzle does not meet the rail")
    for _ in range(50):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if outside(middle) else (low, middle)
    return high


def spool_volume(shape: ValveShape, valve: RotaryValve) -> Volume:
    """Volume of the spool's material [m^3].

    Flanks and windows are radial, so what they leave open between hub and surface is (R^2 - r_h^2)/2 times an angle
    times a length; with the pocket's end at z_p, the apex of its edges at z_a, on each side
    pockets 2 pi (z_p - z_a - L/2), windows N 2 W l_w, ring 2 pi l_r; then chambers, and channels as wide as half-way.

    Source  ours, docs/models/geometry.md
    """
    R, at, L = valve.spool_radius, stations(shape, valve), valve.helix_length
    apex = at.tip - L
    open_length = at.pocket_end - apex - 0.5 * L + shape.ring_length
    windows = valve.sections * 2.0 * shape.window_half_angle * shape.window_length
    pockets = 0.5 * (R**2 - shape.hub_radius**2) * (2.0 * np.pi * open_length + windows)
    outer, arm = shape.chamber_outer_radius, shape.outlet_arm
    chamber = np.pi * (outer**2 - shape.chamber_inner_radius**2) * (at.chamber_end - at.ring_end)
    wall = np.sqrt(R**2 - arm**2) - np.sqrt(outer**2 - arm**2)
    channels = valve.outlet_area * 0.5 * (1.0 + shape.outlet_entry_taper) * wall
    whole = np.pi * R**2 * (2.0 * at.spool_end - L)
    return float(whole - 2.0 * (pockets + chamber + channels))


def rail_arc(shape: ValveShape, valve: RotaryValve) -> float:
    """Angle from one end of the rail's centre line to the other [rad].

    Source  ours, docs/models/geometry.md
    """
    return float(shape.rail_lead + (valve.sections - 1.0) * 2.0 * np.pi / valve.sections + shape.rail_tail)
