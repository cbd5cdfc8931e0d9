"""Closed triangle meshes in double precision, with a name for each patch, and what can be measured on them."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

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

    @property
    def corners(self) -> Floats:
        """The corners of each triangle, (m, 3, 3) [m]."""
        corners: Floats = self.vertices[self.triangles]
        return corners

    def of(self, name: str) -> Floats:
        """The corners of the triangles of one patch [m]."""
        corners: Floats = self.corners[self.patch == self.names.index(name)]
        return corners


@dataclass(frozen=True)
class Soundness:
    """What a closed mesh is: pieces, handles of all of them, and faults."""

    components: int
    genus: int
    open_edges: int
    crossings: int


def volume(mesh: Mesh) -> float:
    """Volume enclosed [m^3], by the divergence theorem.

    Source  ours, docs/models/geometry.md
    """
    a, b, c = np.moveaxis(mesh.corners - mesh.vertices.mean(0), 1, 0)
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0)


def normal_areas(corners: Floats) -> Floats:
    """Area vector of each triangle, outwards [m^2]."""
    areas: Floats = 0.5 * np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return areas


def patch_areas(mesh: Mesh) -> dict[str, float]:
    """Area of each patch [m^2]."""
    areas = np.linalg.norm(normal_areas(mesh.corners), axis=1)
    return {name: float(areas[mesh.patch == place].sum()) for place, name in enumerate(mesh.names)}


def closing(mesh: Mesh) -> float:
    """Length of the sum of all area vectors over the area [1]; zero for a closed mesh."""
    areas = normal_areas(mesh.corners)
    return float(np.linalg.norm(areas.sum(0)) / np.linalg.norm(areas, axis=1).sum())


def polar_moment(mesh: Mesh) -> float:
    """Integral of x^2 + y^2 over what is enclosed [m^5]; times a density, the moment of inertia about the axis.

    Of each tetrahedron from the origin with edges a, b, c, V/10 (a^2 + b^2 + c^2 + ab + bc + ca) for x and y each.

    Source  ours, docs/models/geometry.md
    """
    a, b, c = np.moveaxis(mesh.corners, 1, 0)
    parts = np.einsum("ij,ij->i", a, np.cross(b, c)) / 6.0
    squares = (a**2 + b**2 + c**2 + a * b + b * c + c * a)[:, :2].sum(1)
    return float(parts @ squares / 10.0)


def open_edges(mesh: Mesh) -> int:
    """Number of directed edges that do not have exactly one opposite; 0 for a closed, oriented mesh."""
    t, n = mesh.triangles, len(mesh.vertices)
    start, end = t.ravel(), np.roll(t, -1, axis=1).ravel()
    forward, counts = np.unique(start * n + end, return_counts=True)
    backward = np.unique(end * n + start)
    return int(np.sum(counts > 1) + len(np.setdiff1d(forward, backward)))


def components(mesh: Mesh) -> tuple[int, Indices]:
    """Number of connected pieces, and the piece of each vertex."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    t, n = mesh.triangles, len(mesh.vertices)
    start, end = t.ravel(), np.roll(t, -1, axis=1).ravel()
    links = coo_array((np.ones(len(start)), (start, end)), shape=(n, n))
    count, label = connected_components(links, directed=False)
    return int(count), np.asarray(label, dtype=np.int64)


def genus(mesh: Mesh) -> int:
    """Handles of all pieces together, from Euler's V - E + F = 2 (components - genus)."""
    euler = len(np.unique(mesh.triangles)) - 3 * len(mesh.triangles) // 2 + len(mesh.triangles)
    return components(mesh)[0] - euler // 2


def crossings(mesh: Mesh, tolerance: float = 1e-9) -> int:
    """Number of pairs of an edge and a triangle, without a common corner, that pass through each other.

    The edge's ends lie more than `tolerance` [m] to either side of the triangle: booleans round to a few ulp.
    """
    corners, triangles = mesh.corners, mesh.triangles
    t = triangles
    edges = np.unique(np.sort(np.vstack([t[:, [0, 1]], t[:, [1, 2]], t[:, [2, 0]]]), axis=1), axis=0)
    pairs = _near(mesh.vertices[edges], corners)
    shares = (edges[pairs[:, 0]][:, :, None] == triangles[pairs[:, 1]][:, None, :]).any(axis=(1, 2))
    pairs = pairs[~shares]
    p, q = np.moveaxis(mesh.vertices[edges[pairs[:, 0]]], 1, 0)
    a, b, c = np.moveaxis(corners[pairs[:, 1]], 1, 0)
    normal = np.cross(b - a, c - a)
    size = np.linalg.norm(normal, axis=1)
    flat = size < tolerance**2
    normal = normal / np.where(flat, 1.0, size)[:, None]
    high, low = (np.einsum("ij,ij->i", x - a, normal) for x in (p, q))
    pierces = (high * low < 0.0) & (abs(high) > tolerance) & (abs(low) > tolerance) & ~flat
    at = p + (q - p) * (high / np.where(pierces, high - low, 1.0))[:, None]
    for x, y in ((a, b), (b, c), (c, a)):
        inwards = np.cross(normal, y - x)
        length = np.linalg.norm(inwards, axis=1)
        pierces &= np.einsum("ij,ij->i", at - x, inwards) > -tolerance * length
    return int(pierces.sum())


def _near(segments: Floats, corners: Floats) -> Indices:
    """Pairs (segment, triangle) whose boxes overlap, found over a grid of cells."""
    low_s, high_s = segments.min(1), segments.max(1)
    low_t, high_t = corners.min(1), corners.max(1)
    cell = 2.0 * np.quantile(high_t - low_t, 0.7, axis=0)  # along each axis: facets of a cylinder are long and thin
    origin = low_t.min(0)
    place_s, cell_s = _cells(low_s, high_s, origin, cell)
    place_t, cell_t = _cells(low_t, high_t, origin, cell)
    order = np.argsort(cell_t, kind="stable")
    cell_t, place_t = cell_t[order], place_t[order]
    first, last = np.searchsorted(cell_t, cell_s, "left"), np.searchsorted(cell_t, cell_s, "right")
    found: list[Indices] = []
    for begin in range(0, len(cell_s), 20_000):
        part = slice(begin, begin + 20_000)
        counts = last[part] - first[part]
        segment = np.repeat(place_s[part], counts)
        offset = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
        triangle = place_t[np.repeat(first[part], counts) + offset]
        overlap = ((low_s[segment] <= high_t[triangle]) & (low_t[triangle] <= high_s[segment])).all(1)
        found.append(np.column_stack([segment[overlap], triangle[overlap]]))
    return np.unique(np.vstack(found), axis=0)


def _cells(low: Floats, high: Floats, origin: Floats, cell: Floats) -> tuple[Indices, Indices]:
    """Every cell that each box touches: (place of the box, number of the cell)."""
    first = np.floor((low - origin) / cell).astype(np.int64)
    count = np.floor((high - origin) / cell).astype(np.int64) - first + 1
    total = count.prod(1)
    place = np.repeat(np.arange(len(low)), total)
    rest = np.arange(total.sum()) - np.repeat(np.cumsum(total) - total, total)
    n = count[place]
    i, rest = rest // (n[:, 1] * n[:, 2]), rest % (n[:, 1] * n[:, 2])
    at = first[place] + np.column_stack([i, rest // n[:, 2], rest % n[:, 2]])
    size = 1 << 20
    return place, (at[:, 0] * size + at[:, 1]) * size + at[:, 2]


def soundness(mesh: Mesh, *, pierced: bool = True) -> Soundness:
    """Components, genus, open edges and, where `pierced`, triangles that pierce each other."""
    return Soundness(components(mesh)[0], genus(mesh), open_edges(mesh), crossings(mesh) if pierced else 0)


def require_sound(mesh: Mesh, what: str, components_expected: int, genus_expected: int) -> Mesh:
    """`mesh`, when it is closed, of so many pieces and handles: a leak between two chambers would add a handle.

    Raises RunError with what was found instead.
    """
    found = components(mesh)[0], genus(mesh), open_edges(mesh)
    if found != (components_expected, genus_expected, 0) or not volume(mesh) > 0.0:
        raise RunError(
            f"{what}: the mesh has {found[0]} components, genus {found[1]} and {found[2]} open edges; expected "
            f"{components_expected}, {genus_expected} and 0. Chambers touch or a wall is too thin"
        )
    return mesh


def unwrapped(corners: Floats, radius: float, tolerance: float) -> Floats:
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
