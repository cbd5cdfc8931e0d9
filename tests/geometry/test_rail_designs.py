"""The rail designs of table 2.1, the port of a rail, and the sleeve with the spool taken out."""

import json
from dataclasses import replace

import numpy as np
import pytest
from tests.words import wording

from vvdp.geometry.domains import Domain, open_domain, rail_domain, rail_without_port
from vvdp.geometry.makeable import contradictions
from vvdp.geometry.measure import jet_area, jets
from vvdp.geometry.mesh import components, genus, open_edges, volume
from vvdp.geometry.product import Order, make_product
from vvdp.geometry.shape import (
    ValveShape,
    collector_position,
    groove_length,
    perpendicular_area,
    rail_volume,
    sleeve_half_length,
)
from vvdp.geometry.shape_tables import given_shape
from vvdp.geometry.solids import nozzle_lag, port_angle, rail_angles

FINE = 15.0
DESIGNS = ("a", "b", "c", "d", "final")


@pytest.fixture(scope="module")
def designs(built_valve) -> dict[str, ValveShape]:
    return {name: given_shape(built_valve, f"rail-{name}", ()).shape for name in DESIGNS}


@pytest.fixture(scope="module")
def rails(designs, built_valve) -> dict[str, Domain]:
    return {name: rail_domain(shape, built_valve, FINE) for name, shape in designs.items()}


def test_design_a_is_the_prototype(designs, built_shape):
    assert designs["a"] == built_shape


def test_what_each_design_changes(designs):
    """(b) the port, (c) the rail's diameter by 16 %, (d) its section by 30 %; the final one all three."""
    a, b, c, d, final = (designs[name] for name in DESIGNS)
    assert c.rail_radius / a.rail_radius == pytest.approx(0.84)
    assert d.rail_diameter / a.rail_diameter == pytest.approx(0.70, abs=1e-3)
    assert c == replace(a, rail_radius=c.rail_radius)
    assert b == replace(a, rail_lead=b.rail_lead, rail_port_angle=b.rail_port_angle)
    assert d == replace(
        a, rail_diameter=d.rail_diameter, nozzle_taper=d.nozzle_taper, rail_port_diameter=d.rail_port_diameter
    )
    assert final == replace(d, rail_radius=c.rail_radius, rail_lead=b.rail_lead, rail_port_angle=b.rail_port_angle)


@pytest.mark.parametrize("name", ["b", "final"])
def test_a_port_in_the_middle_lies_at_the_second_nozzle(designs, built_valve, name):
    """Rails of 260 deg: the middle is 130 deg from either end, at the root of the nozzle whose mouth is at 120 deg."""
    shape = designs[name]
    begin, end = rail_angles(shape, built_valve)
    assert port_angle(shape, built_valve) == pytest.approx(0.5 * (begin + end))
    assert port_angle(shape, built_valve) == pytest.approx(2.0 * np.pi / 3.0 - nozzle_lag(shape, built_valve))


@pytest.mark.parametrize("name", DESIGNS)
def test_the_port_is_where_it_should_be(rails, designs, built_valve, name):
    """The inlet patch is a disc across the port's direction, at the port's end."""
    corners = rails[name].mesh.of("inlet")
    middle, shape = corners.reshape(-1, 3).mean(0), designs[name]
    turn = np.arctan2(middle[1], middle[0]) - port_angle(shape, built_valve)
    assert np.cos(turn) == pytest.approx(1.0, abs=1e-6)
    assert np.hypot(*middle[:2]) == pytest.approx(shape.rail_radius + shape.port_length, rel=2e-2)
    section = 0.25 * np.pi * shape.rail_port_diameter**2
    assert rails[name].areas["inlet"] == pytest.approx(section, rel=0.01)


@pytest.mark.parametrize("name", DESIGNS)
def test_a_rail_is_one_piece_with_all_its_patches(rails, built_valve, name):
    mesh = rails[name].mesh
    assert (components(mesh), genus(mesh), open_edges(mesh)) == (1, 0, 0)
    assert set(rails[name].areas) == {"inlet", "rail", "nozzles", "outlet1", "outlet2", "outlet3"}
    for number in (1, 2, 3):  # the opening in the bore is the same in all, 36.5 mm^2
        assert rails[name].areas[f"outlet{number}"] == pytest.approx(36.5e-6 / 3.0, rel=1e-3)


# From a model of the same lengths in another program, with rhombi of another shape; final: 3.7 printed.
@pytest.mark.parametrize(("name", "cc"), [("a", 12.7), ("b", 10.8), ("c", 10.6), ("d", 6.4), ("final", 4.5)])
def test_volumes_of_the_designs(designs, built_valve, name, cc):
    by_formula = rail_volume(designs[name], built_valve)
    assert by_formula == pytest.approx(cc * 1e-6, rel=0.02)
    assert volume(rail_without_port(designs[name], built_valve, FINE)) == pytest.approx(by_formula, rel=5e-3)


def test_section_across_the_jets(built_shape, built_valve, sleeve_mesh):
    """26.59 mm^2 by formula; wrapped on the bore, the mouths show d_c^2/(48 R^2) = 0.206 % less."""
    formula = perpendicular_area(built_shape, built_valve)
    assert formula == pytest.approx(26.590e-6, rel=1e-4)
    rail = rail_without_port(built_shape, built_valve, 40.0)
    assert jet_area(rail, jets(sleeve_mesh, built_valve), built_valve) / formula == pytest.approx(0.99794, abs=4e-4)


def test_a_port_beyond_the_rail_is_refused(built_shape, built_valve):
    (found,) = contradictions(replace(built_shape, rail_port_angle=np.radians(320.0)), built_valve)
    assert found == "rail_port_angle = 320 deg; " + wording.geometry.at_most_of_rail.format(angle="310 deg")


@pytest.fixture(scope="module")
def opened(built_shape, built_valve) -> Domain:
    return open_domain(built_shape, built_valve, FINE)


@pytest.mark.thorough
def test_the_sleeve_without_spool_is_one_way(opened, closing, crossings):
    """Three nozzles join rail and bore, which makes two handles; collectors are open to the bore all round."""
    assert (components(opened.mesh), genus(opened.mesh), open_edges(opened.mesh)) == (1, 2, 0)
    assert closing(opened.mesh) < 1e-14
    assert crossings(opened.mesh) == 0
    assert set(opened.areas) == {"inlet", "rail", "nozzles", "bore", "collector", "outlet-load", "outlet-tank"}


def test_the_sleeve_without_spool_by_formula(opened, built_shape, built_valve):
    """Ends of ports are discs, one at each collector; of the bore's cylinder mouths and grooves are missing."""
    s, R = built_shape, built_valve.spool_radius
    assert opened.areas["inlet"] == pytest.approx(0.25 * np.pi * s.rail_port_diameter**2, rel=5e-3)
    ends = [0.25 * np.pi * s.collector_port_diameter**2] * 2
    assert [opened.areas["outlet-load"], opened.areas["outlet-tank"]] == pytest.approx(ends, rel=5e-3)
    z, half = collector_position(s, built_valve), sleeve_half_length(s, built_valve)
    low, high = opened.mesh.vertices[:, 2].min(), opened.mesh.vertices[:, 2].max()
    assert (low, high) == pytest.approx((-half, half))
    tank, load = opened.mesh.of("outlet-tank"), opened.mesh.of("outlet-load")
    assert (tank[..., 2].mean(), load[..., 2].mean()) == pytest.approx((-z, z), rel=1e-3)
    wall = 2.0 * np.pi * R * (2.0 * half - 2.0 * groove_length(s, built_valve)) - 36.5e-6 + 2.0 * np.pi * R**2
    assert opened.areas["bore"] == pytest.approx(wall, rel=5e-3)


@pytest.mark.sampled(2)
@pytest.mark.parametrize("name", ["b", "final"])
def test_a_whole_valve_takes_another_rail(designs, built_valve, name, tmp_path):
    """Everything is made of it, the ports of collectors beside that of the rail; described as all domains are."""
    order = Order(name=name, valve=built_valve, shape=designs[name], rows=(), angle=0.0,
                  position=0.5 * built_valve.helix_length, fineness=10.0)  # fmt: skip
    made = make_product(tmp_path, order, lambda _: None)
    assert {"rail", "without-spool", "centre", "turbine", "valve", "turbine-tank"} == {d.name for d in made.domains}
    described = json.loads((tmp_path / "oil" / "domains.json").read_text("utf-8"))["without-spool"]
    assert described["turning_patches"] == []
    assert described["genus"] == 2
    assert described["patch_area_m2"]["outlet-tank"] == pytest.approx(made.domains[1].areas["outlet-tank"])
