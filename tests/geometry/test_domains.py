"""The volumes of oil: patches, leaks, and what is refused."""

from dataclasses import replace

import numpy as np
import pytest
from tests.words import wording

from vvdp.base.errors import ParameterError
from vvdp.geometry.domains import (
    STUB,
    TURNING,
    centre_domain,
    rail_domain,
    tank_side,
    turbine_domain,
    valve_domain,
)
from vvdp.geometry.mesh import components, genus, open_edges
from vvdp.geometry.shape import nozzle_reach, perpendicular_area, stations
from vvdp.geometry.solids import COARSEST, OVERLAP
from vvdp.geometry.unrolled import nozzle_outline, open_parts
from vvdp.valve.geometry import barrier_width, helix_slope, pitch, port_openings

FINE = 15.0


@pytest.fixture(scope="module")
def oil(built_shape, built_valve):
    x = 0.5 * built_valve.helix_length
    made = [rail_domain(built_shape, built_valve, FINE)]
    made += [build(built_shape, built_valve, 0.0, x, FINE) for build in (centre_domain, turbine_domain, valve_domain)]
    return {domain.name: domain for domain in made}


NAMES = ("rail", "centre", "turbine", "valve")


@pytest.mark.sampled(4)
@pytest.mark.parametrize("name", NAMES)
def test_oil_is_enclosed(oil, name, closing, crossings):
    mesh = oil[name].mesh
    assert components(mesh) == 1
    assert open_edges(mesh) == 0
    assert closing(mesh) < 1e-14
    assert crossings(mesh) == 0


@pytest.mark.parametrize(
    ("name", "patches"),
    [
        ("rail", {"inlet", "rail", "nozzles", "outlet1", "outlet2", "outlet3"}),
        ("centre", {"inlet1", "inlet2", "inlet3", "nozzles", "sleeve", "spool", "windows", "outlet"}),
        ("turbine", {"inlet", "chamber", "channels", "spool", "collector", "outlet"}),
        (
            "valve",
            {"inlet", "rail", "nozzles", "sleeve", "spool", "windows", "chamber", "channels", "collector", "outlet"},
        ),
    ],
)
def test_patches(oil, name, patches):
    assert set(oil[name].areas) == patches
    assert min(oil[name].areas.values()) > 0.0
    assert set(TURNING) <= {"spool", "windows", "chamber", "channels"}


def test_mouths_of_the_rail_are_the_nozzles(oil, built_valve):
    for number in (1, 2, 3):
        assert oil["rail"].areas[f"outlet{number}"] == pytest.approx(36.5e-6 / 3.0, rel=5e-3)


def test_inlets_of_the_centre_section_lie_across_the_jets(oil, built_shape, built_valve):
    """A_perp (1 + g s)^2 / N at a distance s from the mouth."""
    growth = (built_shape.nozzle_taper - 1.0) / nozzle_reach(built_shape, built_valve)
    section = perpendicular_area(built_shape, built_valve) / 3.0
    nominal = section * (1.0 + growth * STUB * built_valve.spool_radius) ** 2
    for number in (1, 2, 3):
        # Wrapping the rhombus on the bore bends it: its projection loses 0.2 %.
        assert oil["centre"].areas[f"inlet{number}"] == pytest.approx(nominal, rel=5e-3)


def test_ends_have_the_areas_of_their_sections(oil, built_shape, built_valve):
    s, R = built_shape, built_valve.spool_radius
    assert oil["centre"].areas["outlet"] == pytest.approx(np.pi * (R**2 - s.hub_radius**2), rel=5e-3)
    ring = np.pi * (s.chamber_outer_radius**2 - s.chamber_inner_radius**2)
    assert oil["turbine"].areas["inlet"] == pytest.approx(ring, rel=5e-3)
    assert oil["turbine"].areas["outlet"] == pytest.approx(0.25 * np.pi * s.collector_port_diameter**2, rel=5e-3)
    assert oil["valve"].areas["inlet"] == pytest.approx(0.25 * np.pi * s.rail_port_diameter**2, rel=5e-3)


def test_volume_of_the_centre_section(oil, built_shape, built_valve):
    """Pockets, windows and ring between hub and bore, and three stubs; by formula."""
    s, valve, at = built_shape, built_valve, stations(built_shape, built_valve)
    R, L, apex = valve.spool_radius, valve.helix_length, 0.5 * barrier_width(valve) * helix_slope(valve)
    depth = 0.5 * (R**2 - s.hub_radius**2)
    open_length = at.pocket_end - apex - 0.5 * L + s.ring_length
    pockets = depth * (2.0 * np.pi * open_length + 3.0 * 2.0 * s.window_half_angle * s.window_length)
    growth, t = (s.nozzle_taper - 1.0) / nozzle_reach(s, valve), STUB * R
    stubs = perpendicular_area(s, valve) * ((1.0 + growth * t) ** 3 - 1.0) / (3.0 * growth)
    assert oil["centre"].volume == pytest.approx(pockets + stubs, rel=5e-3)


def test_longer_stubs_widen_as_the_nozzles_do(oil, built_shape, built_valve):
    """Across a nozzle's axis, at the distance t, the section is (1 + g t)^2 times that of the mouth."""
    s, valve, R = built_shape, built_valve, built_valve.spool_radius
    growth, area = (s.nozzle_taper - 1.0) / nozzle_reach(s, valve), perpendicular_area(s, valve)
    made = centre_domain(s, valve, 0.0, 0.5 * valve.helix_length, FINE, stub=0.7)
    near, far = (1.0 + growth * length * R for length in (STUB, 0.7))
    ends = sum(made.areas[f"inlet{number}"] for number in (1, 2, 3))
    assert ends == pytest.approx(area * far**2, rel=5e-3)
    added = area * (far**3 - near**3) / (3.0 * growth)
    assert made.volume - oil["centre"].volume == pytest.approx(added, rel=5e-3)


@pytest.mark.parametrize("stub", [0.1, 1.3])
def test_stubs_that_end_in_their_mouths_or_beyond_the_rail_are_refused(stub, built_shape, built_valve):
    """The mouth is 3.991 mm wide and meets the jet at asin(8.7/12.7): 1.367 mm deep; the rail is 15.25 mm away."""
    with pytest.raises(ParameterError, match=r"more than 1\.367 mm, .* and at most 15\.25 mm"):
        centre_domain(built_shape, built_valve, 0.0, 0.5 * built_valve.helix_length, 10.0, stub=stub)


def test_the_whole_valve_is_the_sum_of_its_parts(oil, built_shape, built_valve):
    """Less the stubs, which the rail's nozzles replace, plus the chamber between ring and the turbine's inlet."""
    s, valve, at = built_shape, built_valve, stations(built_shape, built_valve)
    growth, t = (s.nozzle_taper - 1.0) / nozzle_reach(s, valve), STUB * valve.spool_radius
    stubs = perpendicular_area(s, valve) * ((1.0 + growth * t) ** 3 - 1.0) / (3.0 * growth)
    between = at.channel_start - 0.63 * valve.spool_radius - at.ring_end
    chamber = np.pi * (s.chamber_outer_radius**2 - s.chamber_inner_radius**2) * between
    parts = oil["rail"].volume + oil["centre"].volume + oil["turbine"].volume
    assert oil["valve"].volume == pytest.approx(parts - stubs + chamber, rel=5e-3)


@pytest.mark.parametrize("name", NAMES)
def test_the_point_inside_is_inside(oil, name):
    """The solid angles of all triangles seen from the point add up to 4 pi."""
    a, b, c = np.moveaxis(oil[name].mesh.corners - np.array(oil[name].inside), 1, 0)
    la, lb, lc = (np.linalg.norm(x, axis=1) for x in (a, b, c))
    below = la * lb * lc + (a * b).sum(1) * lc + (b * c).sum(1) * la + (c * a).sum(1) * lb
    angle = 2.0 * np.arctan2(np.einsum("ij,ij->i", a, np.cross(b, c)), below).sum()
    assert angle == pytest.approx(4.0 * np.pi, rel=1e-9)


@pytest.mark.parametrize("duty", [0.2, 0.5, 0.95])
@pytest.mark.parametrize("angle", [-0.5, -0.2, 0.3, 1.0])
def test_oil_can_be_made_wherever_the_nozzles_are_open(built_shape, built_valve, duty, angle):
    x = duty * built_valve.helix_length
    open_to = port_openings(angle, x, built_valve)
    for share, make in (
        (open_to.load, lambda: centre_domain(built_shape, built_valve, angle, x, 10.0)),
        (open_to.tank, lambda: tank_side(centre_domain, built_shape, built_valve, angle, x, 10.0)),
    ):
        if share > 1e-3:
            assert make().volume > 0.0
        elif share == 0.0:
            with pytest.raises(ParameterError, match=wording.geometry.shut_towards + ".* mm"):
                make()


def test_a_nozzle_round_the_tip_of_a_barrier_has_one_opening(built_shape, built_valve):
    """Underlap, duty ratio 0.95, half a pitch on: a nozzle sees two load pockets, joined past the tip, so no handle."""
    valve, shape = replace(built_valve, lap_ratio=0.5), replace(built_shape, pocket_gap=2e-3)
    x, angle = 0.95 * valve.helix_length, np.pi / 3.0
    load, _ = open_parts(nozzle_outline(valve, 0.5 * pitch(valve), x), valve)
    assert sum(len(part) > 2 for part in load) == 2
    assert genus(centre_domain(shape, valve, angle, x, 10.0).mesh) == 4


def test_the_tanks_side_is_the_mirror_image(built_shape, built_valve):
    """Half a period after the nozzles are open to the load they are to the tank, at half the helix."""
    x = 0.5 * built_valve.helix_length
    load = centre_domain(built_shape, built_valve, 0.0, x, FINE)
    tank = tank_side(centre_domain, built_shape, built_valve, np.pi / 3.0, x, FINE)
    assert tank.name == "centre-tank"
    assert tank.volume == pytest.approx(load.volume)
    assert tank.inside[2] == pytest.approx(-load.inside[2])
    assert tank.mesh.vertices[:, 2].min() == pytest.approx(-load.mesh.vertices[:, 2].max())
    assert open_edges(tank.mesh) == 0


@pytest.mark.sampled(5)
@pytest.mark.parametrize("angle", np.linspace(-0.25, 0.25, 5))
def test_the_coarsest_parts_overlap(built_shape, built_valve, angle):
    """ceil(2 pi 10) = 63 edges dip 1 - cos(pi/63) = 1.24e-3 of the radius inside, less than the overlap of 1.6e-3."""
    assert 1.0 - np.cos(np.pi / np.ceil(2.0 * np.pi * COARSEST)) == pytest.approx(1.243e-3, abs=1e-6)
    x = 0.5 * built_valve.helix_length
    for build in (centre_domain, valve_domain):
        assert open_edges(build(built_shape, built_valve, angle, x, COARSEST).mesh) == 0


def test_too_coarse_parts_are_refused(built_shape, built_valve, command):
    """ceil(2 pi 8) = 51 edges dip 1.9e-3 of the radius inside, more than the overlap."""
    assert 1.0 - np.cos(np.pi / 51.0) > OVERLAP
    x = 0.5 * built_valve.helix_length
    with pytest.raises(ParameterError, match=wording.geometry.edges_per_radius.format(count=8, least=10)):
        centre_domain(built_shape, built_valve, 0.0, x, 8.0)
    said = command("prototype", "--fineness", "9.9")
    assert said.code == 2
    assert "Invalid value for '--fineness'" in said.err


def test_beyond_the_stroke_is_refused(built_shape, built_valve):
    with pytest.raises(
        ParameterError, match=wording.geometry.outside_stroke.format(position="21.34 mm", low=0, high="20.32 mm")
    ):
        turbine_domain(built_shape, built_valve, 0.0, 1.05 * built_valve.helix_length, 10.0)
