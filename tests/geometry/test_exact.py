"""STEP: solids of exact and polynomial surfaces, against formulas and against the facets."""

from dataclasses import replace

import numpy as np
import pytest
from tests.words import wording

from vvdp.base.errors import ConfigError
from vvdp.geometry.exact import (
    DEGREE,
    Body,
    Exact,
    _bernstein,
    _nodes,
    is_valid,
    read_step,
    shape_volume,
    write_step,
)
from vvdp.geometry.mesh import volume
from vvdp.geometry.shape import rail_volume, spool_volume
from vvdp.geometry.solids import nozzles, rail, sleeve_part, spool_part


def test_primitives_have_the_volumes_of_the_books():
    kernel = Exact()
    # pi r^2 h, 2 pi^2 R r^2, and an arc of the torus with a sphere at its ends
    assert shape_volume(kernel.cylinder("", 2e-3, -1e-3, 4e-3).shape()) == pytest.approx(np.pi * 20e-9)
    assert shape_volume(kernel.ring("", 3e-3, 1e-3, 5e-3).shape()) == pytest.approx(2.0 * np.pi**2 * 3e-9)
    rod = shape_volume(kernel.bent_rod("", 3e-3, 1e-3, 0.2, 1.7).shape())
    assert rod == pytest.approx((1.5 * 3.0 * np.pi + 4.0 / 3.0 * np.pi) * 1e-9)


def test_a_box_bent_by_polynomials_is_a_sector():
    """Wrapping a box about the axis: area of a ring's sector times its height."""

    def sector(a, b, c):
        turn, r = 1.2 * a, (2.0 + b) * 1e-3
        return np.stack([r * np.cos(turn), r * np.sin(turn), 4e-3 * c], axis=-1)

    body = Exact().mapped_box("", sector, (1.0, 1.0, 1.0))
    assert shape_volume(body.shape()) == pytest.approx(0.5 * 1.2 * (9.0 - 4.0) * 4e-9, rel=1e-9)
    assert is_valid(body.shape())


def test_polynomials_follow_a_helix():
    """Over a sixth of a turn, far more than a barrier's flank needs, they are within 1e-11 radii of it."""
    t = np.linspace(0.0, 1.0, 400)
    poles = np.linalg.solve(_bernstein(DEGREE), np.exp(1j * np.pi / 3.0 * _nodes(DEGREE)))
    basis = np.array([_binomial(DEGREE, k) * t**k * (1.0 - t) ** (DEGREE - k) for k in range(DEGREE + 1)]).T
    assert abs(basis @ poles - np.exp(1j * np.pi / 3.0 * t)).max() < 1e-11


def _binomial(n, k):
    from math import comb

    return comb(n, k)


def test_turning_moving_and_mirroring_keep_the_volume(built_shape, built_valve):
    one = Exact().cylinder("", 1e-3, 0.0, 2e-3)
    for put in (one.rotate(0.7), one.translate(3e-3), one.mirror(1e-3)):
        assert shape_volume(put.shape()) == pytest.approx(2.0 * np.pi * 1e-9)


def test_rail_and_nozzles_agree_with_the_formula(built_shape, built_valve):
    """Booleans of exact surfaces and Gauss's rule along the jets are independent of each other."""
    kernel, R = Exact(), built_valve.spool_radius
    whole = Body(((rail(built_shape, built_valve, kernel) + nozzles(built_shape, built_valve, R, kernel)).shape(),))
    fluid = whole - kernel.cylinder("", R, -0.05, 0.05)
    assert shape_volume(fluid.shape()) == pytest.approx(rail_volume(built_shape, built_valve), rel=1e-6)


@pytest.mark.thorough
def test_step_of_the_spool_opens_again_with_its_volume(built_shape, built_valve, spool_mesh, tmp_path):
    path = tmp_path / "spool.step"
    written = write_step(path, spool_part(built_shape, built_valve, Exact()))
    again = read_step(path).shape()
    assert is_valid(again)
    assert shape_volume(again) == pytest.approx(written, rel=1e-7)
    # The formula takes the channels as wide as half-way along.
    assert written == pytest.approx(spool_volume(built_shape, built_valve), rel=1e-4)
    assert written == pytest.approx(volume(spool_mesh), rel=1e-3)


@pytest.mark.thorough
def test_step_of_the_sleeve_opens_again_with_its_volume(built_shape, built_valve, sleeve_mesh, tmp_path):
    path = tmp_path / "sleeve.step"
    written = write_step(path, sleeve_part(built_shape, built_valve, Exact()))
    again = read_step(path).shape()
    assert is_valid(again)
    assert shape_volume(again) == pytest.approx(written, rel=1e-7)
    assert written == pytest.approx(volume(sleeve_mesh), rel=1e-3)


def test_step_says_nothing_on_stdout(tmp_path, capfd):
    write_step(tmp_path / "rod.step", Exact().cylinder("", 1e-3, 0.0, 1e-3))
    read_step(tmp_path / "rod.step")
    assert capfd.readouterr().out == ""


def test_step_has_no_time_in_it_and_the_same_bytes_again(tmp_path):
    texts = []
    for folder in ("a", "b"):
        (tmp_path / folder).mkdir()
        write_step(tmp_path / folder / "rod.step", Exact().cylinder("", 1e-3, 0.0, 1e-3))
        texts.append((tmp_path / folder / "rod.step").read_text("ascii"))
    assert texts[0] == texts[1]
    assert "1970-01-01T00:00:00" in texts[0]
    assert "PRODUCT('rod','rod'" in texts[0]


def test_other_files_are_no_step(tmp_path):
    path = tmp_path / "wrong.step"
    path.write_text("hello", encoding="utf-8")
    with pytest.raises(ConfigError, match=wording.geometry.no_step_file):
        read_step(path)


@pytest.mark.slow
def test_a_wider_barrier_is_another_solid(built_shape, built_valve):
    """The volume follows the parameters, not a drawing."""
    wide = replace(built_valve, lap_ratio=1.2)
    made = shape_volume(spool_part(built_shape, wide, Exact()).shape())
    assert made == pytest.approx(spool_volume(built_shape, wide), rel=1e-4)
