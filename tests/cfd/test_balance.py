"""Torque by angular momentum: what a face carries, and a turning cylinder of known torque."""

from itertools import pairwise

import numpy as np
import pytest

from vvdp.cfd.section import Section


def face(points, velocity, pressure=0.0):
    """One square face with the same flow everywhere."""
    count = len(points)
    return Section(
        points=np.array(points, float),
        corners=np.arange(count),
        ends=np.array([count]),
        pressure=np.full(count, pressure),
        velocity=np.tile(np.array(velocity, float), (count, 1)),
    )


SQUARE = [(2.0, 0.0, 0.0), (2.0, 1.0, 0.0), (2.0, 1.0, 1.0), (2.0, 0.0, 1.0)]
"""At x = 2, facing along x, its middle at y = 1/2."""


def test_a_face_carries_the_moment_of_what_leaves():
    """x v - y u = 2 times 3 - 1/2 times 5 = 3.5, and 5 m^3/s pass: 17.5; a pressure of 4 adds -1/2 times 4."""
    assert face(SQUARE, (5.0, 3.0, 7.0)).axial_moment == pytest.approx(17.5)
    assert face(SQUARE, (0.0, 3.0, 7.0), 4.0).axial_moment == pytest.approx(-2.0)
    assert face(SQUARE[::-1], (5.0, 3.0, 7.0)).axial_moment == pytest.approx(-17.5)


def test_what_turns_as_a_body_carries_its_moment():
    """A ring of faces across the axis in oil that turns with 3 rad/s and leaves with 2 m/s: pi/2 omega w R^4."""
    angles = np.linspace(0.0, 2.0 * np.pi, 361)[:-1]
    radii = np.linspace(0.0, 1.0, 21)
    points, corners = [], []
    for low, high in pairwise(radii):
        for left, right in zip(angles, np.roll(angles, -1), strict=True):
            corners.append(len(points) + np.arange(4))
            points += [
                (r * np.cos(a), r * np.sin(a), 0.0) for r, a in ((low, left), (high, left), (high, right), (low, right))
            ]
    places = np.array(points)
    velocity = np.column_stack([-3.0 * places[:, 1], 3.0 * places[:, 0], np.full(len(places), 2.0)])
    found = Section(
        places, np.concatenate(corners), 4 * np.arange(1, len(corners) + 1), np.zeros(len(places)), velocity
    )
    assert found.axial_moment == pytest.approx(0.5 * np.pi * 3.0 * 2.0, rel=5e-3)
