"""Closed triangle meshes in double precision, with a name for each patch, and what can be measured on them.

trimesh measures. What it does not know is ours: patches, edges that are open or turned, and a cylinder unwrapped.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from trimesh import Trimesh

from vvdp.base.errors import RunError

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]


@dataclass(frozen=True)
class Mesh:
    """Vertices [m], triangles counterclockwise seen from outside, and the patch of each triangle."""

    vertices: Floats  # (n, 3)
    triangles: Indices  # (m, 3)
    patch: Indices  # (m,), place in `names`
    names: tuple[str, ...]

    @cached_property
    def surface(self) -> Trimesh:
        """The same vertices and triangles as trimesh has them, neither merged nor sorted."""
        return Trimesh(self.vertices, self.triangles, process=False)

    @property
    def corners(self) -> Floats:
        """The corners of each triangle, (m, 3, 3) [m]."""
        corners: Floats = self.vertices[self.triangles]
        return corners

    def of(self, name: str) -> Floats:
        """The corners of the triangles of one patch [m]."""
        corners: Floats = self.corners[self.patch == self.names.index(name)]
        return corners


def volume(mesh: Mesh) -> float:
    """Volume enclosed [m^3], by the divergence theorem."""
    return float(mesh.surface.volume)


def patch_areas(mesh: Mesh) -> dict[str, float]:
    """Area of each patch [m^2]."""
    areas = np.bincount(mesh.patch, mesh.surface.area_faces, len(mesh.names))
    return dict(zip(mesh.names, areas.tolist(), strict=True))


def polar_moment(mesh: Mesh) -> float:
    """Integral of x^2 + y^2 over what is enclosed [m^5]; times a density, the moment of inertia about the axis."""
    return float(mesh.surface.moment_inertia_frame(np.eye(4))[2, 2])


def open_edges(mesh: Mesh) -> int:
    """Number of directed edges that do not have exactly one opposite; 0 for a closed, oriented mesh."""
    n, (start, end) = len(mesh.vertices), mesh.surface.edges.T
    forward, counts = np.unique(start * n + end, return_counts=True)
    return int(np.sum(counts > 1) + len(np.setdiff1d(forward, end * n + start)))


def components(mesh: Mesh) -> int:
    """Number of connected pieces."""
    return int(mesh.surface.body_count)


def genus(mesh: Mesh) -> int:
    """Handles of all pieces together, from Euler's V - E + F = 2 (components - genus)."""
    return components(mesh) - int(mesh.surface.euler_number) // 2


def require_sound(mesh: Mesh, what: str, components_expected: int, genus_expected: int) -> Mesh:
    """`mesh`, when it is closed, of so many pieces and handles: a leak between two chambers would add a handle.

    Raises RunError with what was found instead.
    """
    found = components(mesh), genus(mesh), open_edges(mesh)
    if found != (components_expected, genus_expected, 0) or not volume(mesh) > 0.0:
        raise RunError(
            f"{what}: the mesh has {found[0]} components, genus {found[1]} and {found[2]} open edges; expected "
            f"{components_expected}, {genus_expected} and 0. Chambers touch or a wall is too thin"
        )
    return mesh


def unwrap(corners: Floats, radius: float, tolerance: float) -> Floats:
    """Triangles that lie on the cylinder of `radius`, as (arc, axial) [m], each unwrapped about its own middle.

    The arc is counted from -pi R to pi R at the triangle's middle.
    """
    r = np.hypot(corners[:, :, 0], corners[:, :, 1])
    on = corners[(abs(r - radius) <= tolerance).all(1)]
    middle = on.mean(1)
    turn = np.arctan2(middle[:, 1], middle[:, 0])
    cos, sin = np.cos(turn)[:, None], np.sin(turn)[:, None]
    x, y = on[:, :, 0] * cos + on[:, :, 1] * sin, on[:, :, 1] * cos - on[:, :, 0] * sin
    arc = radius * (turn[:, None] + np.arctan2(y, x))
    flat: Floats = np.stack([arc, on[:, :, 2]], axis=-1)
    return flat
