"""Volumes that the oil fills, as closed surfaces with a name for each patch, ready for a mesher.

In sleeve coordinates. Patches that turn with the spool: spool, windows, chamber, channels. Radial clearance and
leakage are left out: lands touch the sleeve. `angle` is the spool's and `position` its axial position; only the load
side is built, the tank side is its mirror image with half a pitch and L - x, see `tank_side`.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from vvdp.base.errors import ParameterError
from vvdp.geometry.facets import FINENESS, Faceted, Part
from vvdp.geometry.kernel import Floats, union
from vvdp.geometry.mesh import Mesh, patch_areas, require_sound, volume
from vvdp.geometry.shape import (
    ValveShape,
    collector_position,
    nozzle_reach,
    rail_arc,
    sleeve_half_length,
    stations,
    travel,
)
from vvdp.geometry.solids import (
    BEYOND,
    OVERLAP,
    chamber_cutter,
    channel_cutter,
    collector,
    collector_port,
    facet_kernel,
    nozzle,
    nozzles,
    pocket_cutter,
    port_angle,
    rail,
    rail_angles,
    rail_port,
    wrap,
)
from vvdp.geometry.unrolled import clipped_openings
from vvdp.valve.geometry import nozzle_width, pitch
from vvdp.valve.rotary import RotaryValve

TURNING = ("spool", "windows", "chamber", "channels")
"""Patches that turn with the spool."""

LEAST_OPENING = 1e-4
"""Share of the nozzle area below which nozzles count as closed."""
STUB = 0.197
"""Length of the nozzle stubs that feed the centre section alone, over the spool radius: 2.5 mm on 12.7 mm."""
APART = 0.04
"""Half the angle for which nozzles have to be closed where pieces meet along the bore, over half a pitch."""
ROUNDING = 1e-11
"""Length [m] by which a position may miss the stroke."""
APPROACH = 0.63
"""Length of chamber upstream of the channels of the outlet turbine alone, over the spool radius: 8 mm."""


@dataclass(frozen=True)
class Domain:
    """A closed volume of oil: its surface, and a point well inside [m] for a mesher to start from.

    Where it is in several pieces, `further` has a point in each piece but the first.
    """

    name: str
    mesh: Mesh
    inside: tuple[float, float, float]
    further: tuple[tuple[float, float, float], ...] = ()

    @property
    def volume(self) -> float:
        """Volume enclosed [m^3]."""
        return volume(self.mesh)

    @property
    def areas(self) -> dict[str, float]:
        """Area of each patch [m^2]."""
        return patch_areas(self.mesh)


def _beyond_port(shape: ValveShape, valve: RotaryValve, radius: float, z: float, patch: str, kernel: Faceted) -> Part:
    """A block that cuts the port of a rail off at its end, and names the end."""
    far, size = radius + shape.port_length, 2.0 * max(shape.rail_port_diameter, shape.collector_port_diameter)
    return kernel.radial_cylinder(patch, size, port_angle(shape, valve), far, far + size, z)


def _inlet(shape: ValveShape, valve: RotaryValve, kernel: Faceted) -> Part:
    """Rail, nozzles and port, the port ended."""
    port = rail_port(shape, valve, kernel) - _beyond_port(shape, valve, shape.rail_radius, 0.0, "inlet", kernel)
    return union([rail(shape, valve, kernel), nozzles(shape, valve, valve.spool_radius, kernel), port])


def rail_domain(shape: ValveShape, valve: RotaryValve, fineness: float = FINENESS) -> Domain:
    """Inlet rail, nozzles and port; patches inlet, rail, nozzles, outlet1 to outletN in the bore.

    Source  ours, docs/models/geometry.md
    """
    kernel = facet_kernel(valve, fineness)
    fluid = _inlet(shape, valve, kernel)
    for number in range(round(valve.sections)):
        # Each mouth has its own sector of the bore; the angles lie clear of all mouths.
        sector = _sector(f"outlet{number + 1}", valve, shape.rail_diameter, kernel)
        fluid = fluid - sector.rotate(number * 2.0 * np.pi / valve.sections)
    mesh = require_sound(fluid.mesh(), "rail", 1, 0)
    middle = rail_angles(shape, valve)[0] + 0.5 * rail_arc(shape, valve)
    inside = (float(shape.rail_radius * np.cos(middle)), float(shape.rail_radius * np.sin(middle)), 0.0)
    return Domain("rail", mesh, inside)


def rail_without_port(shape: ValveShape, valve: RotaryValve, fineness: float = FINENESS) -> Mesh:
    """Rail and nozzles up to the bore, of which `rail_volume` is the volume."""
    kernel, R, reach = facet_kernel(valve, fineness), valve.spool_radius, shape.rail_diameter
    whole = rail(shape, valve, kernel) + nozzles(shape, valve, R, kernel)
    return require_sound((whole - kernel.cylinder("bore", R, -reach, reach)).mesh(), "rail without port", 1, 0)


def _sector(patch: str, valve: RotaryValve, height: float, kernel: Faceted) -> Part:
    """The part of the bore round the mouth at angle 0: a sector as wide as its pitch, from the axis to the bore."""
    R, half = valve.spool_radius, 0.5 * pitch(valve)

    def sector(a: Floats, b: Floats, c: Floats) -> Floats:
        return wrap((2.0 * a - 1.0) * 0.96 * half, (c - 0.5) * height, R * (0.5 + 0.5 * b), R)

    return kernel.mapped_box(patch, sector, (4.0 * half, 0.0, 0.0))


def _require_open(angle: float, position: float, shape: ValveShape, valve: RotaryValve) -> None:
    """Raises ParameterError where the nozzles are closed, or the spool is beyond its stroke.

    What a nozzle sees of the load is in one piece, round a barrier's tip too: its sides are parallel to the barriers.
    """
    require_within_stroke(position, shape, valve)
    if clipped_openings(angle, position, valve).load < LEAST_OPENING:
        raise ParameterError(
            f"the nozzles are closed towards this side at a spool angle of {np.degrees(angle):.4g} deg and an axial "
            f"position of {1e3 * position:.4g} mm, so there is no way for the oil"
        )


def require_within_stroke(position: float, shape: ValveShape, valve: RotaryValve) -> None:
    """Raises ParameterError where the sleeve does not let the spool get to an axial position."""
    low, high = travel(shape, valve)
    if not low - ROUNDING <= position <= high + ROUNDING:
        raise ParameterError(
            f"the axial position {1e3 * position:.4g} mm is outside the stroke, {1e3 * low:.4g} to {1e3 * high:.4g} mm"
        )


def _pockets(shape: ValveShape, valve: RotaryValve, kernel: Faceted, bore: str = "sleeve") -> Part:
    """The oil on the spool from the load pockets to the ring behind the windows, in spool coordinates.

    `bore` is the patch along the bore.
    """
    end = 2.0 * stations(shape, valve).spool_end
    return pocket_cutter(shape, valve, kernel) & kernel.cylinder(bore, valve.spool_radius, -end, end)


def _ended_pockets(shape: ValveShape, valve: RotaryValve, kernel: Faceted, bore: str = "sleeve") -> Part:
    """The same, ended in the ring behind the windows by the patch outlet."""
    R, ring_end = valve.spool_radius, stations(shape, valve).ring_end
    end = kernel.cylinder("outlet", 2.0 * R, ring_end - OVERLAP * R, 2.0 * ring_end)
    return _pockets(shape, valve, kernel, bore) - end


def _stubs(length: float, shape: ValveShape, valve: RotaryValve, within: Part, kernel: Faceted) -> list[Part]:
    """The nozzles' stubs of a length [m], which patches inlet1 to inletN end outside, and `within` towards the bore."""
    N = round(valve.sections)
    whole = nozzle(shape, valve, valve.spool_radius, length + nozzle_width(valve), kernel)
    ends = [_across_jet(f"inlet{number + 1}", shape, valve, length, kernel) for number in range(N)]
    return [(whole - end - within).rotate(2.0 * np.pi * number / N) for number, end in enumerate(ends)]


def _spool_within(shape: ValveShape, valve: RotaryValve, kernel: Faceted) -> Part:
    """Body that ends the nozzles where the spool covers them, slightly inside the bore so that nozzles and pockets
    overlap."""
    return kernel.cylinder("spool", (1.0 - OVERLAP) * valve.spool_radius, -shape.rail_diameter, shape.rail_diameter)


def centre_domain(
    shape: ValveShape, valve: RotaryValve, angle: float, position: float, fineness: float = FINENESS, stub: float = STUB
) -> Domain:
    """Centre section: nozzles as far as `stub` [spool radii] from their mouths, load pockets, windows.

    Patches inlet1 to inletN, nozzles, sleeve, spool, windows, outlet. The oil enters through the stubs' ends, across
    their axes, and leaves axially through the ring behind the windows. Raises ParameterError where a nozzle is closed,
    and for a stub that ends in its mouth or beyond the rail.

    Source  ours, docs/models/geometry.md
    """
    N, kernel = round(valve.sections), facet_kernel(valve, fineness)
    _require_open(angle, position, shape, valve)
    pockets = _ended_pockets(shape, valve, kernel).rotate(angle).translate(-position)
    length = _stub_length(stub, shape, valve)
    fluid = union([pockets, *_stubs(length, shape, valve, _spool_within(shape, valve, kernel), kernel)])
    mesh = require_sound(fluid.mesh(), "centre section", 1, N + 1)
    return Domain("centre", mesh, _in_ring(shape, valve, angle, position))


def sliding_domain(shape: ValveShape, valve: RotaryValve, position: float, fineness: float = FINENESS) -> Domain:
    """Centre section in pieces that meet along the bore: the oil on the spool, and each nozzle stub.

    The spool stands half a pitch back, where the nozzles are closed. Patches as of `centre_domain`, but for the bore:
    mouths ends the stubs, rim the pockets. Raises ParameterError where the nozzles hardly close.

    Source  ours, docs/models/cfd.md, "A period of the turning spool"
    """
    N, R, kernel = round(valve.sections), valve.spool_radius, facet_kernel(valve, fineness)
    require_within_stroke(position, shape, valve)
    closed, apart = -np.pi / N, APART * np.pi / N
    if any(clipped_openings(closed + turn, position, valve).load > 0.0 for turn in (-apart, apart)):
        raise ParameterError(
            f"the nozzles are closed towards this side for less than {2.0 * np.degrees(apart):.3g} deg of a turn at an "
            f"axial position of {1e3 * position:.4g} mm, so that pockets and nozzles are nowhere apart; expected a "
            f"lower one"
        )
    pockets = _ended_pockets(shape, valve, kernel, "rim").rotate(closed).translate(-position)
    bore = kernel.cylinder("mouths", R, -shape.rail_diameter, shape.rail_diameter)
    length = _stub_length(STUB, shape, valve)
    mesh = union([pockets, *_stubs(length, shape, valve, bore, kernel)]).mesh()
    sound = require_sound(mesh, "centre section in pieces", N + 1, N + 1)
    middle, tilt = 0.5 * length, _jet_tilt(shape, valve)
    places = (R + middle * np.exp(1j * tilt)) * np.exp(2j * np.pi * np.arange(N) / N)
    further = tuple((float(place.real), float(place.imag), 0.0) for place in places)
    return Domain("sliding", sound, _in_ring(shape, valve, closed, position), further)


def _stub_length(stub: float, shape: ValveShape, valve: RotaryValve) -> float:
    """Length of nozzle stubs [m]. Raises ParameterError where their ends cut the oblique mouths, or lie in the rail."""
    length, R = stub * valve.spool_radius, valve.spool_radius
    least, most = 0.5 * nozzle_width(valve) * shape.nozzle_arm / R, nozzle_reach(shape, valve)
    if not least < length <= most:
        raise ParameterError(
            f"nozzle stubs of {1e3 * length:.4g} mm; expected more than {1e3 * least:.4g} mm, the depth of their "
            f"oblique mouths, and at most {1e3 * most:.4g} mm, where the rail's centre line is"
        )
    return length


def _in_ring(shape: ValveShape, valve: RotaryValve, angle: float, position: float) -> tuple[float, float, float]:
    """A point in the ring between the barriers' tips and the windows."""
    at, between = stations(shape, valve), 0.5 * (shape.hub_radius + valve.spool_radius)
    height = 0.5 * (at.tip + at.pocket_end) - position
    return float(between * np.cos(angle)), float(between * np.sin(angle)), float(height)


def _jet_tilt(shape: ValveShape, valve: RotaryValve) -> float:
    """Direction of the axis of the nozzle at angle 0, from its mouth outwards [rad]."""
    return -float(np.arcsin(shape.nozzle_arm / valve.spool_radius))


def _across_jet(patch: str, shape: ValveShape, valve: RotaryValve, distance: float, kernel: Faceted) -> Part:
    """The block beyond the plane across the axis of the nozzle at angle 0, at `distance` from its mouth."""
    R, tilt = valve.spool_radius, _jet_tilt(shape, valve)

    def block(a: Floats, b: Floats, c: Floats) -> Floats:
        s, q = distance + a * R, (2.0 * b - 1.0) * R
        x, y = R + s * np.cos(tilt) - q * np.sin(tilt), s * np.sin(tilt) + q * np.cos(tilt)
        return np.stack([x, y, (2.0 * c - 1.0) * R], axis=-1)

    return kernel.mapped_box(patch, block, (0.0, 0.0, 0.0))


def _collecting(shape: ValveShape, valve: RotaryValve, patch: str, kernel: Faceted) -> Part:
    """Collector and port of the load, reaching into the bore, ended at the port's end by `patch`."""
    end = _beyond_port(shape, valve, shape.collector_radius, collector_position(shape, valve), patch, kernel)
    return collector(shape, valve, kernel) + (collector_port(shape, valve, kernel) - end)


def _outlet(shape: ValveShape, valve: RotaryValve, kernel: Faceted) -> Part:
    """Collector and port, in sleeve coordinates, ended at the bore and at the port's end."""
    spool = kernel.cylinder("spool", valve.spool_radius, 0.0, 2.0 * collector_position(shape, valve))
    return _collecting(shape, valve, "outlet", kernel) - spool


def turbine_domain(
    shape: ValveShape, valve: RotaryValve, angle: float, position: float, fineness: float = FINENESS
) -> Domain:
    """Outlet turbine: chamber, channels, collector and port.

    Patches inlet, chamber, channels, spool, collector, outlet.

    Source  ours, docs/models/geometry.md
    """
    R, at, kernel = valve.spool_radius, stations(shape, valve), facet_kernel(valve, fineness)
    require_within_stroke(position, shape, valve)
    start = at.channel_start - APPROACH * R
    chamber = chamber_cutter(shape, valve, start - BEYOND * R, kernel)
    chamber = chamber - kernel.cylinder("inlet", 2.0 * R, start - R, start)
    rotor = chamber + channel_cutter(shape, valve, R * (1.0 + 4.0 * OVERLAP), kernel)
    fluid = rotor.rotate(angle).translate(-position) + _outlet(shape, valve, kernel)
    mesh = require_sound(fluid.mesh(), "outlet turbine", 1, 1 + round(shape.outlet_blades))
    radius = 0.5 * (shape.chamber_inner_radius + shape.chamber_outer_radius)
    return Domain("turbine", mesh, (float(radius), 0.0, float(0.5 * (start + at.channel_start) - position)))


def valve_domain(
    shape: ValveShape, valve: RotaryValve, angle: float, position: float, fineness: float = FINENESS
) -> Domain:
    """The whole way of the oil to the load: rail, nozzles, centre section, outlet turbine, collector.

    Patches inlet, rail, nozzles, sleeve, spool, windows, chamber, channels, collector, outlet.
    Raises ParameterError where a nozzle is closed.

    Source  ours, docs/models/geometry.md
    """
    N, R, at, kernel = round(valve.sections), valve.spool_radius, stations(shape, valve), facet_kernel(valve, fineness)
    _require_open(angle, position, shape, valve)
    inlet = _inlet(shape, valve, kernel) - _spool_within(shape, valve, kernel)
    rotor = union(
        [
            _pockets(shape, valve, kernel),
            chamber_cutter(shape, valve, at.ring_end - OVERLAP * R, kernel),
            channel_cutter(shape, valve, R * (1.0 + 4.0 * OVERLAP), kernel),
        ]
    )
    fluid = inlet + rotor.rotate(angle).translate(-position) + _outlet(shape, valve, kernel)
    mesh = require_sound(fluid.mesh(), "whole valve", 1, 2 * N + round(shape.outlet_blades))
    return Domain("valve", mesh, _in_ring(shape, valve, angle, position))


def open_domain(shape: ValveShape, valve: RotaryValve, fineness: float = FINENESS) -> Domain:
    """The sleeve with the spool taken out, as rail and nozzles are measured: rail, nozzles, bore, both collectors.

    Patches inlet, rail, nozzles, bore, collector, outlet-load, outlet-tank. The bore is closed at the sleeve's ends.

    Source  ours, docs/models/geometry.md; wang2017, section 2.4
    """
    kernel, R, half = facet_kernel(valve, fineness), valve.spool_radius, sleeve_half_length(shape, valve)
    parts = [
        _inlet(shape, valve, kernel),
        kernel.cylinder("bore", R, -half, half),
        _collecting(shape, valve, "outlet-load", kernel),
        _collecting(shape, valve, "outlet-tank", kernel).mirror(),
    ]
    mesh = require_sound(union(parts).mesh(), "sleeve without spool", 1, round(valve.sections) - 1)
    return Domain("without-spool", mesh, (0.0, 0.0, 0.5 * half))


def tank_side(
    build: Callable[..., Domain],
    shape: ValveShape,
    valve: RotaryValve,
    angle: float,
    position: float,
    fineness: float = FINENESS,
) -> Domain:
    """The same domain on the tank's side: built at half a pitch and L - x, then mirrored at the nozzles' plane."""
    load = build(shape, valve, angle + np.pi / valve.sections, valve.helix_length - position, fineness)
    flip = np.array([1.0, 1.0, -1.0])
    mesh = replace(load.mesh, vertices=load.mesh.vertices * flip, triangles=load.mesh.triangles[:, ::-1])
    x, y, z = load.inside
    return Domain(f"{load.name}-tank", mesh, (x, y, -z))


def load_domains(
    shape: ValveShape, valve: RotaryValve, angle: float, position: float, fineness: float = FINENESS
) -> Mapping[str, Callable[[], Domain]]:
    """The domains of the load's side by their names, each built when called; the rail serves both sides."""
    return {
        "rail": lambda: rail_domain(shape, valve, fineness),
        "without-spool": lambda: open_domain(shape, valve, fineness),
        "centre": lambda: centre_domain(shape, valve, angle, position, fineness),
        "turbine": lambda: turbine_domain(shape, valve, angle, position, fineness),
        "valve": lambda: valve_domain(shape, valve, angle, position, fineness),
    }


def tank_domains(
    shape: ValveShape, valve: RotaryValve, angle: float, position: float, fineness: float = FINENESS
) -> Mapping[str, Callable[[], Domain]]:
    """The domains of the tank's side by their names, each built when called."""

    def side(build: Callable[..., Domain]) -> Callable[[], Domain]:
        return lambda: tank_side(build, shape, valve, angle, position, fineness)

    return {"centre-tank": side(centre_domain), "turbine-tank": side(turbine_domain), "valve-tank": side(valve_domain)}
