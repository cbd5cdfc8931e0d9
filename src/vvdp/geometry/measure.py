"""Measures of the finished meshes of spool and sleeve, independent of the formulas that they were made from."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from manifold3d import CrossSection, FillRule
from trimesh.triangles import cross

from vvdp.base.errors import RunError
from vvdp.base.kinds import ANGLE, AREA, LENGTH, VOLUME, Area, Kind
from vvdp.geometry.mesh import Floats, Mesh, unwrap, volume
from vvdp.geometry.shape import ValveShape, perpendicular_area, rail_volume, spool_volume
from vvdp.valve.geometry import Openings, barrier_width, pitch
from vvdp.valve.rotary import RotaryValve

UNIT = 1e-3
"""Outlines are clipped in millimetres: the clipper rounds to 8 decimals."""


class Jet(NamedTuple):
    """The axis of a nozzle as measured: its mouth's angle and its inclination to the radius [rad], moment arm [m]."""

    mouth_angle: float
    inclination: float
    arm: float


class Surface(NamedTuple):
    """The unwrapped lands of a spool between the pockets, and the unwrapped mouths of a sleeve's nozzles."""

    lands: CrossSection
    mouths: tuple[CrossSection, ...]


class Mouth(NamedTuple):
    """Opening of a nozzle in the bore, and the section across its jet there [m^2]."""

    opening: Area
    across_jet: Area


def jets(sleeve: Mesh, valve: RotaryValve) -> list[Jet]:
    """The axes of the nozzles, from the planes of their side walls."""
    bore = valve.spool_radius + valve.radial_clearance
    found = []
    for mouth in _mouths(sleeve, valve):
        low_u, low_z, high_u, high_z = mouth.bounds()
        turn = 0.5 * (low_u + high_u) * UNIT / valve.spool_radius
        centre = np.array([np.cos(turn), np.sin(turn), 0.0]) * bore + [0, 0, 0.5e-3 * (low_z + high_z)]
        axis = _jet_axis(centre, sleeve.of("nozzles"), valve)
        radial = centre / np.linalg.norm(centre)
        inclination = float(np.arccos(np.clip(-axis @ radial, -1.0, 1.0)))
        found.append(Jet(float(turn), inclination, float(np.cross(centre, axis)[2])))
    return found


def _jet_axis(centre: Floats, walls: Floats, valve: RotaryValve) -> Floats:
    """The direction of the jet from the nozzle whose mouth has its middle at `centre`, inwards.

    All planes of its walls pass through one point, the apex of the taper, found in homogeneous coordinates so that it
    may be at infinity; the axis leads from the mouth's middle to it.
    """
    middle, areas = walls.mean(1), 0.5 * cross(walls)
    size = np.linalg.norm(areas, axis=1)
    # Walls up to a spool radius from the mouth; those of the neighbours are farther away.
    near = (np.linalg.norm(middle - centre, axis=1) < valve.spool_radius) & (size > 1e-6 * size.max())
    normal = areas[near] / size[near, None]
    planes = np.column_stack([normal, -np.einsum("ij,ij->i", normal, middle[near] - centre) / valve.spool_radius])
    apex = np.linalg.svd(planes * np.sqrt(size[near])[:, None])[2][-1]
    axis: Floats = apex[:3] if abs(apex[3]) < 1e-9 else apex[:3] / apex[3]
    axis = axis / np.linalg.norm(axis)
    return axis if axis @ centre < 0.0 else -axis


def rail_mouths(rail: Mesh, valve: RotaryValve) -> list[Mouth]:
    """Openings of the nozzles in the bore and across their jets, from the patches outlet1 to outletN of a rail."""
    found = []
    for number in range(round(valve.sections)):
        corners = rail.of(f"outlet{number + 1}")
        areas = 0.5 * cross(corners)
        size = np.linalg.norm(areas, axis=1)
        centre: Floats = size @ corners.mean(1) / size.sum()
        axis = _jet_axis(centre, rail.of("nozzles"), valve)
        found.append(Mouth(float(size.sum()), float(abs(areas.sum(0) @ axis))))
    return found


def _flat(triangles: Floats) -> CrossSection:
    """The union of plane triangles [m], as a cross section in millimetres."""
    return CrossSection(list(triangles / UNIT), FillRule.NonZero)


def _mouths(sleeve: Mesh, valve: RotaryValve) -> tuple[CrossSection, ...]:
    """Openings in the bore's wall within half a pitch of each nozzle."""
    bore = valve.spool_radius + valve.radial_clearance
    wall = unwrap(sleeve.of("bore"), bore, 2e-3 * bore)
    # Seen in arcs of the spool's surface.
    wall = wall * np.array([valve.spool_radius / bore, 1.0])
    P, turn = pitch(valve), 2.0 * np.pi * valve.spool_radius
    reach = 0.5 * valve.helix_length + 0.3 * P
    mouths = []
    for number in range(round(valve.sections)):
        u = number * P
        shifted = wall.copy()
        shifted[:, :, 0] -= turn * np.round((wall[:, :, 0].mean(1) - u) / turn)[:, None]
        around = (abs(shifted[:, :, 0] - u) < 0.75 * P).any(1)
        window = CrossSection([_box(u - 0.45 * P, u + 0.45 * P, reach)])
        open_here = max((window - _flat(shifted[around])).decompose(), key=lambda part: part.area(), default=None)
        if open_here is None:
            raise RunError(f"the sleeve has no mouth for nozzle {number + 1}")
        mouths.append(open_here)
    return tuple(mouths)


def _box(low: float, high: float, reach: float) -> Floats:
    return np.array([(low, -reach), (high, -reach), (high, reach), (low, reach)]) / UNIT


class Comparison(NamedTuple):
    """One quantity by formula and as the finished mesh has it, SI."""

    key: str
    title: str
    kind: Kind
    formula: float
    measured: float

    @property
    def difference(self) -> float:
        """Measured less formula, over the formula [1]."""
        return self.measured / self.formula - 1.0


def comparisons(shape: ValveShape, valve: RotaryValve, spool: Mesh, sleeve: Mesh, rail: Mesh) -> tuple[Comparison, ...]:
    """Measures of the meshes by formula, beside those that they have.

    Source  ours, docs/models/geometry.md
    """
    found = jets(sleeve, valve)
    bore = valve.spool_radius + valve.radial_clearance
    inclination = float(np.mean([jet.inclination for jet in found]))
    arm = float(np.mean([jet.arm for jet in found]))
    return (
        Comparison("nozzle_area_m2", "area of all nozzles", AREA, valve.nozzle_area, mouth_area(sleeve, valve)),
        Comparison("jet_area_m2", "section across all jets", AREA,
                   perpendicular_area(shape, valve), jet_area(rail, found, valve)),
        Comparison("nozzle_arm_m", "moment arm of the jets", LENGTH, shape.nozzle_arm, arm),
        Comparison("nozzle_inclination_rad", "angle from jet to radius", ANGLE,
                   float(np.arcsin(shape.nozzle_arm / bore)), inclination),
        Comparison("barrier_width_m", "barrier width", LENGTH,
                   float(barrier_width(valve)), barrier_width_on(spool, valve)),
        Comparison("rail_volume_m3", "inlet rail and nozzles", VOLUME, rail_volume(shape, valve), volume(rail)),
        Comparison("spool_volume_m3", "material of the spool", VOLUME, spool_volume(shape, valve), volume(spool)),
    )  # fmt: skip


def surface_of(spool: Mesh, sleeve: Mesh, valve: RotaryValve) -> Surface:
    """The unwrapped surfaces of both, to be laid over each other by `measured_openings`."""
    R, P, L = valve.spool_radius, pitch(valve), valve.helix_length
    lands = unwrap(spool.of("spool"), R, 2e-3 * R)
    inside = (lands[:, :, 1].max(1) > -0.5 * L) & (lands[:, :, 1].min(1) < 1.5 * L)
    lands = lands[inside]
    turn = 2.0 * np.pi * R
    # A turn and a pitch, so that a nozzle that straddles the seam sees whole barriers.
    copies = [lands + np.array([shift, 0.0]) for shift in (-turn, 0.0, turn)]
    near = [copy[(abs(copy[:, :, 0]) < 0.5 * turn + P).any(1)] for copy in copies]
    return Surface(_flat(np.concatenate(near)), _mouths(sleeve, valve))


def measured_openings(spool_angle: float, axial_position: float, surface: Surface, valve: RotaryValve) -> Openings:
    """Open fractions of the nozzles as the meshes have them, over the nozzle area [1].

    Mouths are laid on the spool's surface; what its lands leave open belongs to the load where it lies beyond the
    barriers' centre line, to the tank where it lies before it.
    """
    R, P, L = valve.spool_radius, pitch(valve), valve.helix_length
    turn = 2.0 * np.pi * R
    load = tank = 0.0
    for number, mouth in enumerate(surface.mouths):
        u = number * P - R * spool_angle
        shift = -R * spool_angle - turn * np.floor(u / turn + 0.5)
        moved = mouth.translate((shift / UNIT, axial_position / UNIT))
        for part in (moved - surface.lands).decompose():
            if part.is_empty():
                continue
            outline = np.concatenate(part.to_polygons()) * UNIT
            beyond = outline[:, 1] - L * abs(2.0 * (outline[:, 0] / P - np.floor(outline[:, 0] / P + 0.5)))
            if beyond.mean() > 0.0:
                load += part.area() * UNIT**2
            else:
                tank += part.area() * UNIT**2
    return Openings(load / valve.nozzle_area, tank / valve.nozzle_area)


def openings_over_a_period(spool: Mesh, sleeve: Mesh, position: float, valve: RotaryValve, count: int) -> Floats:
    """Open fractions that the meshes have at `count` spool angles over one PWM period, both ends included.

    Columns: spool angle [rad], towards the load, towards the tank.
    """
    surface = surface_of(spool, sleeve, valve)
    angles = np.linspace(0.0, 2.0 * np.pi / valve.sections, count)
    return np.array([(angle, *measured_openings(float(angle), position, surface, valve)) for angle in angles])


def mouth_area(sleeve: Mesh, valve: RotaryValve) -> float:
    """Area of all mouths in the bore, unwrapped [m^2]."""
    return float(sum(mouth.area() for mouth in _mouths(sleeve, valve))) * UNIT**2


def jet_area(rail: Mesh, found: Sequence[Jet], valve: RotaryValve) -> float:
    """Section of all jets across them [m^2]: the mouths of a `rail` in its bore, seen along the measured axes.

    A mouth is bent round the bore, so the section is 0.2 % less than its area times a cosine.
    """
    corners = rail.of("bore")
    areas, middle = 0.5 * cross(corners), corners.mean(1)
    turn = np.arctan2(middle[:, 1], middle[:, 0])
    seen = 0.0
    for jet in found:
        near = abs(np.remainder(turn - jet.mouth_angle + np.pi, 2.0 * np.pi) - np.pi) < np.pi / valve.sections
        along = jet.mouth_angle - np.arcsin(
            jet.arm / valve.spool_radius
        )  # outwards, from a mouth on the spool's radius
        seen += abs(areas[near].sum(0) @ np.array([np.cos(along), np.sin(along), 0.0]))
    return float(seen)


def barrier_width_on(spool: Mesh, valve: RotaryValve) -> float:
    """Circumferential width of the barriers half-way up [m]: what they take of the circle there, over 2 N."""
    R, L = valve.spool_radius, valve.helix_length
    lands = unwrap(spool.of("spool"), R, 2e-3 * R)
    lands = lands[(lands[:, :, 1].max(1) > 0.3 * L) & (lands[:, :, 1].min(1) < 0.7 * L)]
    low, high, far = 0.48 * L / UNIT, 0.52 * L / UNIT, 4.0 * np.pi * R / UNIT
    band = CrossSection([np.array([(-far, low), (far, low), (far, high), (-far, high)])])
    return float((_flat(lands) ^ band).area() / (high - low) / (2.0 * valve.sections)) * UNIT
