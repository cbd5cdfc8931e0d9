"""The lengths of a shape, its volumes by formula, and what is refused."""

import re
from dataclasses import replace

import numpy as np
import pytest
from tests.words import wording

from vvdp.base.errors import ConfigError, ParameterError
from vvdp.geometry.makeable import contradictions
from vvdp.geometry.shape import (
    collector_position,
    groove_length,
    nozzle_reach,
    outlet_width,
    perpendicular_area,
    rail_arc,
    rail_volume,
    sleeve_radius,
    spool_volume,
    stations,
    travel,
)
from vvdp.geometry.shape_tables import given_shape, prototype_table, shape_text, shipped_shapes, valve_shape
from vvdp.valve.geometry import nozzle_length


def test_stations_of_the_prototype_by_hand(built_shape, built_valve):
    at = stations(built_shape, built_valve)
    # Pitch 2 pi 12.7 / 3 = 26.599 mm; slope 2 x 20.32 / 26.599 = 1.52790; width sqrt(2 x 12.1667 / 1.52790) = 3.9908.
    # Tip 20.32 + 3.9908 x 1.52790 / 2 = 23.3687; pockets 1.5 more; windows and ring 2 each.
    assert at.tip == pytest.approx(23.3687e-3, abs=1e-7)
    assert at.pocket_end == pytest.approx(24.8687e-3, abs=1e-7)
    assert at.window_end == pytest.approx(26.8687e-3, abs=1e-7)
    assert at.ring_end == pytest.approx(28.8687e-3, abs=1e-7)
    # The groove travels 20.32 + 0.5 beyond a seal of 3: 52.6887; the channels are 5.2 high; then travel and land of 10.
    assert at.channel_start == pytest.approx(52.6887e-3, abs=1e-7)
    assert at.chamber_end == pytest.approx(57.8887e-3, abs=1e-7)
    assert at.spool_end == pytest.approx((52.6887 + 5.2 + 20.82 + 10.0) * 1e-3, abs=1e-7)


@pytest.mark.parametrize("ratio", [0.5, 1.0, 1.66, 2.5])
def test_pocket_and_groove_stay_apart_over_the_whole_stroke(built_shape, built_valve, ratio):
    """In the sleeve the ring behind the windows ends below the groove, the channels stay within it, and the nozzles
    within the pockets."""
    shape = replace(built_shape, stroke_ratio=ratio)
    at, groove = stations(shape, built_valve), collector_position(shape, built_valve)
    half = 0.5 * groove_length(shape, built_valve)
    assert list(contradictions(shape, built_valve)) == []
    for x in travel(shape, built_valve):
        assert at.ring_end - x <= groove - half - shape.seal_length + 1e-12
        assert groove - half <= at.channel_start - x + 1e-12
        assert at.chamber_end - x <= groove + half + 1e-12
        assert x + 0.5 * nozzle_length(built_valve) <= at.pocket_end - shape.pocket_gap + 1e-12


def test_the_full_stroke_by_hand(built_valve):
    """1.66 of 20.32 mm is 33.73 mm: from -6.706 to 27.026 mm, and the pockets end 27.026 + 6.0975/2 + 1.5 mm up."""
    shape, rows = given_shape(built_valve, "full-stroke", ())
    assert travel(shape, built_valve) == pytest.approx((-6.7056e-3, 27.0256e-3), abs=1e-8)
    assert stations(shape, built_valve).pocket_end == pytest.approx(31.5744e-3, abs=1e-6)
    assert next(row for row in rows if row.key == "stroke_ratio").status == "derived"


@pytest.mark.parametrize("name", sorted(shipped_shapes()))
def test_shipped_shapes_can_be_made_and_say_where_they_come_from(built_valve, name):
    for row in given_shape(built_valve, name, ()).rows:
        assert row.status in ("assumed", "derived", "published")
        assert row.note or row.source or row.status == "assumed"


def test_nozzle_lengths_by_hand(built_shape, built_valve):
    # sqrt(26^2 - 8.7^2) - sqrt(12.7^2 - 8.7^2) = 24.5012 - 9.2520
    assert nozzle_reach(built_shape, built_valve) == pytest.approx(15.2492e-3, abs=1e-7)
    # 36.5 x 9.2520 / 12.7
    assert perpendicular_area(built_shape, built_valve) == pytest.approx(26.590e-6, rel=1e-4)
    # 46.8 / (6 x 5.2)
    assert outlet_width(built_shape, built_valve) == pytest.approx(1.5e-3)
    # 19.5 + 7.5 + 5 is less than 26 + 5.165 + 5
    assert sleeve_radius(built_shape) == pytest.approx(36.165e-3)
    # 60 + 240 + 10 deg
    assert rail_arc(built_shape, built_valve) == pytest.approx(np.radians(310.0))


def test_the_rail_holds_what_is_published(built_shape, built_valve):
    """12.7 cm^3 [wang2017, section 2.7]."""
    assert rail_volume(built_shape, built_valve) == pytest.approx(12.7e-6, abs=0.05e-6)


def test_the_spool_weighs_about_what_is_published(built_shape, built_valve):
    """0.5 kg [wang2017, section 5.1]; ends and rod for the axial sensor are not drawn."""
    assert built_shape.spool_density * spool_volume(built_shape, built_valve) == pytest.approx(0.5, rel=0.12)


def test_rail_volume_of_radial_untapered_nozzles(built_shape, built_valve):
    """Thin radial nozzles of constant section are prisms from bore to rail."""
    thin = replace(built_valve, nozzle_area=0.3e-6)
    straight = replace(built_shape, nozzle_arm=1e-9, nozzle_taper=1.0)
    r, R = 0.5 * straight.rail_diameter, straight.rail_radius
    body = np.pi * r**2 * R * rail_arc(straight, thin) + 4.0 / 3.0 * np.pi * r**3
    prisms = thin.nozzle_area * (R - r - thin.spool_radius)
    assert rail_volume(straight, thin) - body == pytest.approx(prisms, rel=2e-3)


def test_a_larger_valve_is_the_same_in_proportion(built_shape, built_valve, larger_valve):
    shape, rows = valve_shape(larger_valve)
    assert shape.rail_radius == pytest.approx(1.25 * built_shape.rail_radius)
    assert shape.window_half_angle == built_shape.window_half_angle
    assert spool_volume(shape, larger_valve) == pytest.approx(1.25**3 * spool_volume(built_shape, built_valve))
    assert rail_volume(shape, larger_valve) == pytest.approx(1.25**3 * rail_volume(built_shape, built_valve))
    assert wording.geometry.scaled.format(factor=1.25) in next(row.note for row in rows if row.key == "rail_radius")


def test_every_length_has_a_status_and_a_reason():
    for key, entry in prototype_table().content["geometry"].items():
        assert entry["status"] == "assumed", key


def test_shape_is_written_and_read(built_shape, built_valve, tmp_path):
    _, rows = valve_shape(built_valve)
    path = tmp_path / "geometry.toml"
    path.write_text(shape_text(rows), encoding="utf-8")
    again, origin = given_shape(built_valve, str(path), ())
    assert again == built_shape
    assert {row.status for row in origin} == {"assumed"}


def test_settings_replace_lengths_and_are_the_users(built_valve):
    shape, rows = given_shape(built_valve, None, ["geometry.rail_radius=28 mm"])
    assert shape.rail_radius == pytest.approx(28e-3)
    assert next(row.status for row in rows if row.key == "rail_radius") == "given"


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"hub_radius": 13e-3}, "hub_radius = 13 mm; " + wording.files.expected_less_than.format(limit="12.7 mm")),
        ({"window_half_angle": 1.1}, wording.geometry.windows_together.format(count=3, angle="378 deg")),
        (
            {"outlet_arm": 11e-3},
            "outlet_arm and half a channel = 11.81 mm; " + wording.files.expected_less_than.format(limit="11.2 mm"),
        ),
        ({"outlet_height": 0.9e-3}, wording.geometry.outlet_channel.format(width="9.36 mm")),
        ({"nozzle_arm": 12.6e-3}, "nozzle_arm = 12.6 mm; " + wording.files.expected_less_than.format(limit="12.32 mm")),
        ({"nozzle_taper": 0.8}, r"nozzle_taper = 0\.8; expected 1 or more"),
        ({"rail_diameter": 7e-3}, wording.geometry.nozzles_root.format(found="9.146 mm", limit="7 mm")),
        ({"rail_radius": 18e-3}, wording.geometry.rail_inside.format(found="12.8. mm", limit=13.3)),
        ({"rail_tail": 1.5}, wording.geometry.rail_spans.format(angle="408.9 deg")),
        (
            {"rail_port_diameter": 11e-3},
            "rail_port_diameter = 11 mm; " + wording.files.expected_less_than.format(limit="10.33 mm"),
        ),
        ({"collector_radius": 24e-3}, wording.geometry.collector_inside.format(found="16.5 mm", limit="14.7 mm")),
        ({"stroke_ratio": 0.0, "seal_length": 1e-3, "collector_diameter": 40e-3}, wording.geometry.wall_between),
        (
            {"port_length": 8e-3},
            "rail_radius and port_length = 34 mm; " + wording.files.expected_more_than.format(limit="36.17 mm"),
        ),
    ],
)
def test_what_cannot_be_made_is_refused_with_numbers(built_shape, built_valve, changes, words):
    assert re.search(words, "\n".join(contradictions(replace(built_shape, **changes), built_valve)))


def test_a_nozzle_wider_than_the_pitch_is_refused(built_valve):
    with pytest.raises(ParameterError, match=r"nozzle width 31\.5 mm and barrier width 3\.15 mm .* pitch of 26\.6 mm"):
        replace(built_valve, nozzle_area=2280e-6, lap_ratio=0.1)


def test_a_clearance_larger_than_the_land_is_refused(built_shape, built_valve):
    """A barrier 0.3 mm wide is 0.25 mm thick across, less than twice a clearance of 0.2 mm."""
    thin = replace(built_valve, lap_ratio=0.3 / 3.9908, radial_clearance=0.2e-3)
    found = list(contradictions(built_shape, thin))
    assert wording.geometry.barrier_across.format(found="0.251 mm", limit="0.4 mm") in found[0]


def test_a_negative_lap_beyond_the_barrier_is_refused(built_valve):
    with pytest.raises(ParameterError, match=r"lap_ratio: -0\.1 is outside 0"):
        replace(built_valve, lap_ratio=-0.1)
    with pytest.raises(ParameterError, match="lap_ratio: " + wording.files.must_be_greater_than_zero.format(value="0")):
        replace(built_valve, lap_ratio=0.0)


@pytest.mark.parametrize("name", ["hub_radius", "pocket_gap", "outlet_blades", "nozzle_taper", "sleeve_wall"])
def test_nothing_is_refused(built_shape, name):
    with pytest.raises(ParameterError, match=f"{name}: .* must be greater than 0"):
        replace(built_shape, **{name: 0.0})


def test_half_a_blade_is_refused(built_shape):
    with pytest.raises(ParameterError, match=r"outlet_blades: 5\.5 must be a whole number"):
        replace(built_shape, outlet_blades=5.5)


def test_all_faults_of_a_file_at_once(built_valve, tmp_path):
    path = tmp_path / "shape.toml"
    path.write_text('[geometry]\nrail_radious = "26 mm"\nhub_radius = "7.6"\n', encoding="utf-8")
    with pytest.raises(ConfigError) as refused:
        given_shape(built_valve, str(path), ())
    assert wording.files.did_you_mean.format(name="rail_radius") in str(refused.value)
    assert f"{path}:3: geometry.hub_radius" in str(refused.value)


def test_other_tables_are_refused(built_valve, tmp_path):
    path = tmp_path / "shape.toml"
    path.write_text('[valve]\nspool_radius = "12.7 mm"\n', encoding="utf-8")
    with pytest.raises(ConfigError, match="unknown table; expected one of geometry"):
        given_shape(built_valve, str(path), ())
