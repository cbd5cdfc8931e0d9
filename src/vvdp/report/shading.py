"""Pictures of closed meshes: parallel projection, one lamp, lines where the surface turns away or bends sharply."""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray
from trimesh.triangles import cross

from vvdp.geometry.mesh import Floats, Indices, Mesh

Colour = tuple[float, float, float]
BACKGROUND: Colour = (1.0, 1.0, 1.0)
LINE: Colour = (0.11, 0.12, 0.14)
LAMP = np.array([-0.35, 0.55, 0.76])
"""Direction to the lamp: right, up, towards the eye."""
SAMPLES = 2
"""Points per pixel along each side."""
CHUNK = 20_000
"""Triangles that are looked at together."""


def view_frame(azimuth: float, elevation: float) -> Floats:
    """Rows: right, up, towards the eye, for an eye at `azimuth` about z and `elevation` above the plane [deg]."""
    a, e = np.radians(azimuth), np.radians(elevation)
    eye = np.array([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)])
    right = np.array([-np.sin(a), np.cos(a), 0.0])
    return np.array([right, np.cross(eye, right), eye])


def lying_frame(azimuth: float, elevation: float) -> Floats:
    """As `view_frame`, but with the axis z to the right: for things longer than they are wide."""
    right, up, eye = view_frame(azimuth, elevation)
    return np.array([up, -right, eye])


def shade(
    meshes: Sequence[Mesh], colours: Mapping[str, Colour], frame: Floats, width: int, margin: float = 0.03
) -> tuple[Floats, tuple[float, float, float, float]]:
    """The picture of all meshes (height, width, 3), and its edges in the plane of projection: left, right, low, high.

    meshes   [m]
    colours  of each patch
    frame    of the eye, see `view_frame`
    width    of the picture [pixels]; the height follows
    """
    corners = np.concatenate([mesh.corners for mesh in meshes]) @ frame.T
    paint = np.concatenate([np.array([colours[name] for name in mesh.names])[mesh.patch] for mesh in meshes])
    low, high = corners.min((0, 1))[:2], corners.max((0, 1))[:2]
    size = float((high - low).max())
    low, high = low - margin * size, high + margin * size
    columns = SAMPLES * width
    pixel = float(high[0] - low[0]) / columns
    rows = SAMPLES * int(np.ceil((high[1] - low[1]) / pixel / SAMPLES))
    nearest = _nearest(corners, low, pixel, rows, columns)
    lit = nearest >= 0
    areas = cross(corners)
    normals = areas / np.maximum(np.linalg.norm(areas, axis=1, keepdims=True), 1e-300)  # noqa: TID251
    light = 0.42 + 0.58 * np.clip(normals @ (LAMP / np.linalg.norm(LAMP)), 0.0, 1.0)
    picture = np.empty((rows, columns, 3))
    picture[:] = BACKGROUND
    picture[lit] = np.clip(paint[nearest[lit]] * light[nearest[lit], None], 0.0, 1.0)
    picture[_lines(nearest, normals)] = LINE
    picture = picture.reshape(rows // SAMPLES, SAMPLES, width, SAMPLES, 3).mean((1, 3))
    return picture[::-1], (float(low[0]), float(high[0]), float(low[1]), float(low[1] + rows * pixel))


def _nearest(corners: Floats, low: Floats, pixel: float, rows: int, columns: int) -> Indices:
    """The triangle that is seen at each point, -1 where there is none; the first row is the lowest."""
    facing = cross(corners)[:, 2]
    front = np.flatnonzero(facing > 1e-12 * facing.max())  # slivers and what is seen edge on have no depth
    flat, z = (corners[front][:, :, :2] - low) / pixel - 0.5, corners[front][:, :, 2]
    # Far triangles first: where several cover a point, the nearest of them must win, by its depth there.
    depth, seen = np.full(rows * columns, -np.inf), np.full(rows * columns, -1, dtype=np.int64)
    for part in np.array_split(np.argsort(z.mean(1)), max(1, len(front) // CHUNK)):
        place, deep, which = _covered_points(flat[part], z[part], rows, columns)
        order = np.argsort(deep, kind="stable")
        place, deep, which = place[order], deep[order], which[order]
        better = deep > depth[place]
        depth[place[better]], seen[place[better]] = deep[better], front[part][which[better]]
    return seen.reshape(rows, columns)


def _covered_points(flat: Floats, z: Floats, rows: int, columns: int) -> tuple[Indices, Floats, Indices]:
    """Every point that lies within a triangle: its place, its depth, and which triangle; found row by row."""
    x, y = flat[:, :, 0], flat[:, :, 1]
    first = np.clip(np.ceil(y.min(1)), 0, rows).astype(np.int64)
    which, offset = _runs(np.clip(np.floor(y.max(1)), -1, rows - 1).astype(np.int64) - first + 1)
    row = first[which] + offset
    left, right = np.full(len(row), np.inf), np.full(len(row), -np.inf)
    for i, j in ((0, 1), (1, 2), (2, 0)):
        x0, y0, x1, y1 = x[which, i], y[which, i], x[which, j], y[which, j]
        share = (row - y0) / np.where(y1 == y0, 1.0, y1 - y0)
        crosses = (share >= 0.0) & (share <= 1.0) & (y1 != y0)
        at = x0 + share * (x1 - x0)
        left = np.where(crosses & (at < left), at, left)
        right = np.where(crosses & (at > right), at, right)
    begin = np.clip(np.ceil(left), 0, columns).astype(np.int64)
    span, along = _runs(np.clip(np.floor(right), -1, columns - 1).astype(np.int64) - begin + 1)
    which, row, column = which[span], row[span], begin[span] + along
    a, b, c = np.moveaxis(np.concatenate([flat, z[:, :, None]], axis=-1), 1, 0)
    normal = np.cross(b - a, c - a)
    slope = -normal[:, :2] / normal[:, 2:]
    deep = a[which, 2] + slope[which, 0] * (column - a[which, 0]) + slope[which, 1] * (row - a[which, 1])
    return row * columns + column, deep, which


def _runs(lengths: Indices) -> tuple[Indices, Indices]:
    """For runs of given lengths, none where negative, one after the other: the run of each place, the place in it."""
    lengths = np.clip(lengths, 0, None)
    which = np.repeat(np.arange(len(lengths)), lengths)
    return which, np.arange(len(which)) - np.repeat(np.cumsum(lengths) - lengths, lengths)


def _lines(nearest: Indices, normals: Floats) -> NDArray[np.bool_]:
    """Where the surface begins, ends or bends by more than 35 degrees from one point to the next."""
    lit = nearest >= 0
    facing = np.where(lit[:, :, None], normals[nearest], 0.0)
    marked = np.zeros(lit.shape, bool)
    for axis in (0, 1):
        here = [slice(None), slice(None)]
        there = [slice(None), slice(None)]
        here[axis], there[axis] = slice(None, -1), slice(1, None)
        h, t = tuple(here), tuple(there)
        edge = (lit[h] != lit[t]) | (lit[h] & lit[t] & ((facing[h] * facing[t]).sum(-1) < 0.82))
        marked[h] |= edge
        marked[t] |= edge
    return marked
