"""Pictures: the shading, the drawings and the film."""

import io

import numpy as np
import pytest
from PIL import Image

from vvdp.geometry.facets import Faceted
from vvdp.report.geometry_figures import animation, film, telling_angle, unwrapped_figure
from vvdp.report.shading import lying_frame, shade, view_frame
from vvdp.valve.geometry import port_openings


def ball(radius: float = 1.0):
    """A ball of facets: a bent rod of almost no length."""
    return Faceted(0.05).bent_rod("ball", 3.0, radius, 0.0, 1e-3).mesh()


def test_a_ball_is_seen_as_a_disc():
    picture, (left, right, low, high) = shade([ball()], {"ball": (0.8, 0.4, 0.2)}, view_frame(20.0, 35.0), 300)
    covered = (picture < 0.99).any(-1)
    pixel = (right - left) / 300
    assert covered.sum() * pixel**2 == pytest.approx(np.pi, rel=0.02)
    assert (high - low) / (right - left) == pytest.approx(picture.shape[0] / picture.shape[1])


def test_the_lamp_is_above_and_to_the_left():
    picture, _ = shade([ball()], {"ball": (1.0, 1.0, 1.0)}, view_frame(0.0, 0.0), 200)
    n = picture.shape[0]
    assert picture[n // 3, n // 3].mean() > picture[2 * n // 3, 2 * n // 3].mean() + 0.1


def test_what_is_nearer_hides_what_is_behind():
    front, behind = Faceted(0.1).ring("front", 2.0, 0.9, 0.0).mesh(), Faceted(0.1).cylinder("behind", 0.5, -9.0, -5.0)
    colours = {"front": (1.0, 0.0, 0.0), "behind": (0.0, 0.0, 1.0)}
    above, _ = shade([front, behind.mesh()], colours, view_frame(0.0, 90.0), 201)
    middle = above[above.shape[0] // 2, above.shape[1] // 2]
    assert middle[2] > middle[0]  # through the ring
    wide = Faceted(0.1).cylinder("behind", 2.5, -9.0, -5.0).mesh()
    above, _ = shade([front, wide], colours, view_frame(0.0, 90.0), 201)
    ring = above[above.shape[0] // 2, int(above.shape[1] * (0.5 + 0.5 * 2.0 / 2.9 * 0.97))]
    assert ring[0] > ring[2]


@pytest.mark.parametrize("frame", [view_frame(33.0, 21.0), lying_frame(10.0, 40.0)])
def test_frames_are_right_handed_and_of_unit_length(frame):
    assert np.allclose(frame @ frame.T, np.eye(3))
    assert np.linalg.det(frame) == pytest.approx(1.0)


def test_figures_are_the_same_when_drawn_again(built_shape, built_valve):
    one, other = (unwrapped_figure(built_shape, built_valve, 0.01) for _ in range(2))
    assert one.svg == other.svg


@pytest.mark.parametrize("duty", [0.2, 0.5, 0.8])
def test_the_unwrapped_surface_is_drawn_while_the_nozzles_close(built_valve, duty):
    position = duty * built_valve.helix_length
    assert 0.2 < port_openings(telling_angle(built_valve, position), position, built_valve).load < 0.8


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
