"""Pictures: the shading, the figures, the film, and the command that makes all of it."""

import io
import json

import numpy as np
import pytest
from PIL import Image

from vvdp.geometry.facets import Faceted
from vvdp.geometry.files import read_stl
from vvdp.geometry.mesh import components, open_edges, volume
from vvdp.report.geometry_figures import animation, film, openings_figure, unwrapped_figure
from vvdp.report.shading import lying_frame, shaded, view_frame
from vvdp.valve.geometry import port_openings


def ball(radius: float = 1.0):
    """A ball of facets: a bent rod of almost no length."""
    return Faceted(0.05).bent_rod("ball", 3.0, radius, 0.0, 1e-3).mesh()


def test_a_ball_is_seen_as_a_disc():
    picture, (left, right, low, high) = shaded([ball()], {"ball": (0.8, 0.4, 0.2)}, view_frame(20.0, 35.0), 300)
    covered = (picture < 0.99).any(-1)
    pixel = (right - left) / 300
    assert covered.sum() * pixel**2 == pytest.approx(np.pi, rel=0.02)
    assert (high - low) / (right - left) == pytest.approx(picture.shape[0] / picture.shape[1])


def test_the_lamp_is_above_and_to_the_left():
    picture, _ = shaded([ball()], {"ball": (1.0, 1.0, 1.0)}, view_frame(0.0, 0.0), 200)
    n = picture.shape[0]
    assert picture[n // 3, n // 3].mean() > picture[2 * n // 3, 2 * n // 3].mean() + 0.1


def test_what_is_nearer_hides_what_is_behind():
    front, behind = Faceted(0.1).ring("front", 2.0, 0.9, 0.0).mesh(), Faceted(0.1).cylinder("behind", 0.5, -9.0, -5.0)
    colours = {"front": (1.0, 0.0, 0.0), "behind": (0.0, 0.0, 1.0)}
    above, _ = shaded([front, behind.mesh()], colours, view_frame(0.0, 90.0), 201)
    middle = above[above.shape[0] // 2, above.shape[1] // 2]
    assert middle[2] > middle[0]  # through the ring
    wide = Faceted(0.1).cylinder("behind", 2.5, -9.0, -5.0).mesh()
    above, _ = shaded([front, wide], colours, view_frame(0.0, 90.0), 201)
    ring = above[above.shape[0] // 2, int(above.shape[1] * (0.5 + 0.5 * 2.0 / 2.9 * 0.97))]
    assert ring[0] > ring[2]


@pytest.mark.parametrize("frame", [view_frame(33.0, 21.0), lying_frame(10.0, 40.0)])
def test_frames_are_right_handed_and_of_unit_length(frame):
    assert np.allclose(frame @ frame.T, np.eye(3))
    assert np.linalg.det(frame) == pytest.approx(1.0)


def test_figures_are_the_same_when_drawn_again(built_shape, built_valve):
    one, other = (unwrapped_figure(built_shape, built_valve, 0.3, 0.01) for _ in range(2))
    assert (one.svg, one.png) == (other.svg, other.png)


def test_the_caption_names_the_largest_difference(built_valve):
    angles = np.linspace(0.0, 2.0, 9)
    measured = np.array([port_openings(float(angle), 0.01, built_valve) for angle in angles]) + [0.002, -0.001]
    assert "at most 0.2 %" in openings_figure(built_valve, 0.01, np.column_stack([angles, measured])).caption


def test_the_film_shows_the_open_nozzles(built_shape, built_valve):
    """Dark blue of the load at the middle of the period, at its ends light blue of the tank."""
    load, tank = (11, 60, 111), (106, 174, 214)
    frames = [np.asarray(frame) for frame in film(built_shape, built_valve, 0.5 * built_valve.helix_length, 2)]

    def amount(frame, colour):
        return (abs(frame[: frame.shape[0] // 2].astype(int) - colour).max(-1) < 4).sum()

    assert amount(frames[0], tank) > 300 > 100 > amount(frames[0], load)
    assert amount(frames[1], load) > 300 > 100 > amount(frames[1], tank)


def test_the_animation_is_an_endless_gif(built_shape, built_valve):
    heard: list[int] = []
    gif = Image.open(io.BytesIO(animation(built_shape, built_valve, 0.01, 4, heard.append)))
    assert gif.n_frames == 4
    assert gif.info["loop"] == 0
    assert heard == [1, 2, 3, 4]


def test_the_command_makes_and_tells_everything(command, tmp_path, keys_as_described):
    said = command("prototype", "--out", "made", "--fineness", "10", "--frames", "2", "--angle", "21 deg", "--json")
    assert said.code == 0
    told = json.loads(said.out)
    keys_as_described("geometry", told)
    assert told["finished"] is True
    assert abs(told["openings_difference"]) < 0.02
    assert told["rail_volume_m3"] == pytest.approx(12.7e-6, rel=2e-3)
    assert told["rail_volume_measured_m3"] == pytest.approx(told["rail_volume_m3"], rel=0.02)
    made = tmp_path / "made"
    for name in ("spool.stl", "sleeve.stl", "spool.glb", "geometry.toml", "openings.csv", "period.gif", "report.html"):
        assert (made / name).is_file(), name
    assert {path.stem for path in (made / "figures").glob("*.png")} == {"unwrapped", "openings", "solids", "oil"}
    described = json.loads((made / "oil" / "domains.json").read_text("utf-8"))
    assert set(described) == {"rail", "centre", "turbine", "valve", "turbine-tank"}
    for name, each in described.items():
        mesh = read_stl(made / "oil" / each["file"])
        assert (components(mesh), open_edges(mesh)) == (1, 0), name
        assert volume(mesh) == pytest.approx(each["volume_m3"])
        assert set(mesh.names) == set(each["patch_area_m2"])
    assert set(described["valve"]["turning_patches"]) == {"spool", "windows", "chamber", "channels"}


def test_the_command_refuses_with_all_faults(command):
    said = command("prototype", "--set", "geometry.hub_radius=13 mm", "--set", "geometry.nozzle_arm=12.6 mm")
    assert said.code == 2
    assert "hub_radius = 13 mm; expected less than 12.7 mm" in said.err
    assert "nozzle_arm = 12.6 mm; expected less than 12.32 mm" in said.err


def test_the_command_refuses_a_valve_that_cannot_be(command):
    said = command("prototype", "--set", "valve.nozzle_area=2000 mm^2")
    assert said.code == 2
    assert "do not fit into the pitch of 26.6 mm" in said.err


def test_an_interruption_keeps_what_is_made(command, tmp_path, monkeypatch):
    from vvdp.report import geometry_product

    def stop(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(geometry_product, "sleeve", stop)
    said = command("prototype", "--out", "made", "--fineness", "10", "--frames", "2", "--json")
    assert said.code == 130
    assert json.loads(said.out)["finished"] is False
    assert (tmp_path / "made" / "spool.stl").is_file()
    assert "Interrupted" in (tmp_path / "made" / "report.html").read_text("utf-8")


def test_the_command_refuses_early(command, tmp_path):
    """Before anything is made: an angle without unit, a position that the sleeve does not allow."""
    said = command("prototype", "--angle", "3")
    assert said.code == 2
    assert said.err.startswith("--angle: '3' has no unit")
    said = command("prototype", "--set", "operation.duty_ratio=1.2")
    assert said.code == 2
    assert "the axial position 24.38 mm is outside the stroke, 0 to 20.32 mm" in said.err
    assert list(tmp_path.iterdir()) == []
