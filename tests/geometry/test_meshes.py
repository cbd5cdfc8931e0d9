"""Spool and sleeve as meshes: closed, free of crossings, and as large as the formulas say."""

from dataclasses import replace

import numpy as np
import pytest
from manifold3d import Error, Manifold, Mesh64
from tests.words import wording

from vvdp.base.errors import RunError
from vvdp.geometry.domains import rail_without_port
from vvdp.geometry.measure import comparisons, openings_over_a_period
from vvdp.geometry.mesh import (
    Mesh,
    components,
    genus,
    open_edges,
    patch_areas,
    polar_moment,
    require_sound,
    volume,
)
from vvdp.geometry.shape import rail_volume, spool_volume
from vvdp.geometry.solids import sleeve, spool
from vvdp.valve.geometry import port_openings

CUBE = np.array([(x, y, z) for x in (0.0, 1.0) for y in (0.0, 1.0) for z in (0.0, 1.0)])
FACES = np.array(
    [(0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1), (2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4),
     (1, 5, 7), (1, 7, 3)]
)  # fmt: skip


def cube(shift: object = 0.0) -> Mesh:
    return Mesh(CUBE + shift, FACES, np.zeros(12, np.int64), ("all",))


def both(one: Mesh, other: Mesh) -> Mesh:
    triangles = np.vstack([one.triangles, other.triangles + len(one.vertices)])
    return Mesh(np.vstack([one.vertices, other.vertices]), triangles, np.zeros(len(triangles), np.int64), ("all",))


# What the measuring itself says of bodies that are known.


def test_a_cube_by_hand(closing, crossings):
    mesh = cube(5.0)
    assert volume(mesh) == pytest.approx(1.0)
    assert patch_areas(mesh) == {"all": pytest.approx(6.0)}
    assert (components(mesh), genus(mesh), open_edges(mesh), crossings(mesh)) == (1, 0, 0, 0)
    assert closing(mesh) < 1e-15
    # Integral of x^2 + y^2 over the unit cube at the origin: 1/3 + 1/3.
    assert polar_moment(cube()) == pytest.approx(2.0 / 3.0)
    # Of a box of 1, 2 and 3 along x, y and z: volume times (1 + 4)/3.
    assert polar_moment(replace(cube(), vertices=CUBE * [1.0, 2.0, 3.0])) == pytest.approx(10.0)


def test_a_hole_is_seen(closing):
    mesh = cube()
    holed = replace(mesh, triangles=mesh.triangles[1:], patch=mesh.patch[1:])
    assert open_edges(holed) == 3
    assert closing(holed) > 0.05
    with pytest.raises(RunError, match=wording.geometry.open_edges.format(count=3)):
        require_sound(holed, "cube", 1, 0)


def test_a_triangle_turned_inside_out_is_seen():
    mesh = cube()
    turned = mesh.triangles.copy()
    turned[0] = turned[0, ::-1]
    assert open_edges(replace(mesh, triangles=turned)) > 0


def test_crossing_bodies_are_seen(crossings):
    assert crossings(both(cube(), cube(np.array([0.3, 0.2, 0.1])))) > 0
    assert crossings(both(cube(), cube(0.3))) > 0  # edges through diagonals of faces
    assert crossings(both(cube(), cube(2.0))) == 0
    assert components(both(cube(), cube(2.0))) == 2


def test_a_ring_has_a_handle():
    ring = faceted_ring()
    assert genus(ring) == 1
    # Pappus: 2 pi^2 R r^2 less what facets of a 64-gon lack, sin(2 pi/64)/(2 pi/64) = 0.9984 in the section.
    assert volume(ring) == pytest.approx(2.0 * np.pi**2 * 3.0 * 1.0, rel=3e-3)


def faceted_ring() -> Mesh:
    from vvdp.geometry.facets import Faceted

    return Faceted(0.05).ring("all", 3.0, 1.0, 0.0).mesh()


# Spool and sleeve.


@pytest.mark.parametrize("name", ["spool", "sleeve"])
def test_meshes_are_closed_and_in_one_piece(name, spool_mesh, sleeve_mesh, closing):
    mesh = {"spool": spool_mesh, "sleeve": sleeve_mesh}[name]
    assert open_edges(mesh) == 0
    assert closing(mesh) < 1e-14
    # Two turbines of six channels; three nozzles and three ports through the wall.
    assert (components(mesh), genus(mesh)) == (1, {"spool": 12, "sleeve": 6}[name])


@pytest.mark.thorough
def test_meshes_do_not_cross_themselves(built_shape, built_valve, crossings):
    assert crossings(spool(built_shape, built_valve, 10.0)) == 0
    assert crossings(sleeve(built_shape, built_valve, 10.0)) == 0


def test_the_kernel_accepts_the_finished_meshes(spool_mesh, sleeve_mesh):
    for mesh in (spool_mesh, sleeve_mesh):
        again = Manifold(Mesh64(np.ascontiguousarray(mesh.vertices), mesh.triangles.astype(np.uint64)))
        assert again.status() == Error.NoError
        assert again.volume() == pytest.approx(volume(mesh), rel=1e-12)


def test_meshes_measure_what_the_formulas_say(built_shape, built_valve, spool_mesh, sleeve_mesh):
    rail = rail_without_port(built_shape, built_valve, 25.0)
    found = comparisons(built_shape, built_valve, spool_mesh, sleeve_mesh, rail)
    assert {each.key: each.difference for each in found if abs(each.difference) > 5e-3} == {}
    assert len(found) == 7


@pytest.mark.parametrize("duty", [0.1, 0.35, 0.5, 0.8])
def test_openings_over_a_period_agree_with_the_hydraulic_model(duty, built_valve, spool_mesh, sleeve_mesh):
    x = duty * built_valve.helix_length
    over = openings_over_a_period(spool_mesh, sleeve_mesh, x, built_valve, 49)
    formula = np.array([port_openings(float(angle), x, built_valve) for angle in over[:, 0]])
    assert abs(over[:, 1:] - formula).max() < 5e-3


@pytest.fixture(scope="module")
def wide_parts(built_shape, built_valve):
    """Spool and sleeve with the travel for both ends of the duty ratio."""
    wide = replace(built_shape, stroke_ratio=1.66)
    return spool(wide, built_valve, 20.0), sleeve(wide, built_valve, 20.0)


@pytest.mark.parametrize("position", [-6.2e-3, -1e-3, 21.5e-3, 26.4e-3])
def test_openings_beyond_the_helix_agree_with_the_hydraulic_model(position, built_valve, wide_parts):
    """At the ends one port has all nozzles over the whole period: neither barrier nor end of a pocket is there."""
    over = openings_over_a_period(*wide_parts, position, built_valve, 49)
    formula = np.array([port_openings(float(angle), position, built_valve) for angle in over[:, 0]])
    assert abs(over[:, 1:] - formula).max() < 5e-3
    if position in (-6.2e-3, 26.4e-3):
        port = 1 if position > 0.0 else 2
        assert over[:, port].min() > 0.995


def test_a_wrong_barrier_is_noticed(built_shape, built_valve, sleeve_mesh):
    """Barriers a tenth too wide leave openings that the comparison above would not pass."""
    wide = spool(built_shape, replace(built_valve, lap_ratio=1.1), 25.0)
    over = openings_over_a_period(wide, sleeve_mesh, 0.5 * built_valve.helix_length, built_valve, 49)
    formula = np.array(
        [port_openings(float(angle), 0.5 * built_valve.helix_length, built_valve) for angle in over[:, 0]]
    )
    assert abs(over[:, 1:] - formula).max() > 0.04


def test_facets_converge_to_the_formulas(built_shape, built_valve):
    """Errors of inscribed polygons fall with the square of their edges: a quarter when the edges are halved."""
    errors = []
    for fineness in (12.0, 24.0):
        errors.append(spool_volume(built_shape, built_valve) / volume(spool(built_shape, built_valve, fineness)) - 1.0)
    assert 3.0 < errors[0] / errors[1] < 5.5


def test_rail_volume_from_below(built_shape, built_valve):
    rail = volume(rail_without_port(built_shape, built_valve, 30.0))
    assert 0.996 < rail / rail_volume(built_shape, built_valve) < 1.0


def test_inertia_of_the_spool(built_shape, built_valve, spool_mesh):
    """Less than that of the full cylinder of its volume's mass at R, more than of one of the hub's radius."""
    inertia = polar_moment(spool_mesh) / volume(spool_mesh)
    assert 0.5 * built_shape.hub_radius**2 < inertia < 0.5 * built_valve.spool_radius**2


@pytest.mark.sampled(4)
@pytest.mark.parametrize(
    "changes",
    [
        {"sections": 2.0},
        {"lap_ratio": 1.6},
        {"helix_length": 12e-3, "nozzle_area": 20e-6},
        {"spool_radius": 20e-3, "inlet_radius": 20e-3, "outlet_radius": 20e-3, "nozzle_area": 60e-6},
    ],
)
def test_other_valves_are_made_as_well(built_valve, changes):
    from vvdp.geometry.shape_tables import valve_shape

    valve = replace(built_valve, **changes)
    shape, _ = valve_shape(valve)
    spool_mesh, sleeve_mesh = spool(shape, valve, 20.0), sleeve(shape, valve, 20.0)
    assert volume(spool_mesh) == pytest.approx(spool_volume(shape, valve), rel=2e-3)
    x = 0.4 * valve.helix_length
    over = openings_over_a_period(spool_mesh, sleeve_mesh, x, valve, 25)
    formula = np.array([port_openings(float(angle), x, valve) for angle in over[:, 0]])
    assert abs(over[:, 1:] - formula).max() < 5e-3
