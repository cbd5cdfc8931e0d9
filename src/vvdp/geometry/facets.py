"""Solids of plane facets, made with manifold3d: exact booleans in double precision, every facet knows its patch."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from manifold3d import Error, Manifold, Mesh64
from numpy.typing import NDArray

from vvdp.base.errors import RunError
from vvdp.geometry.kernel import Floats, Placed
from vvdp.geometry.mesh import Mesh

FINENESS = 25.0
"""Edges per spool radius, unless asked otherwise."""


@dataclass(frozen=True)
class Part:
    """A solid and the patch that each of its original surfaces belongs to."""

    solid: Manifold
    patches: Mapping[int, str] = field(default_factory=dict)

    def __add__(self, other: "Part") -> "Part":
        return Part(self.solid + other.solid, {**self.patches, **other.patches})

    def __sub__(self, other: "Part") -> "Part":
        return Part(self.solid - other.solid, {**self.patches, **other.patches})

    def __and__(self, other: "Part") -> "Part":
        return Part(self.solid ^ other.solid, {**self.patches, **other.patches})

    def rotate(self, angle: float) -> "Part":
        """Turned about the axis [rad]."""
        return Part(self.solid.rotate([0.0, 0.0, float(np.degrees(angle))]), self.patches)

    def translate(self, z: float) -> "Part":
        """Moved along the axis [m]."""
        return Part(self.solid.translate([0.0, 0.0, float(z)]), self.patches)

    def mirror(self, z: float = 0.0) -> "Part":
        """Mirrored at the plane at `z` [m]."""
        return Part(self.solid.mirror([0.0, 0.0, 1.0]).translate([0.0, 0.0, 2.0 * float(z)]), self.patches)

    def mesh(self) -> Mesh:
        """The surface of the solid. Raises RunError where there is none."""
        if self.solid.status() != Error.NoError or self.solid.is_empty():
            raise RunError(f"a solid could not be made ({self.solid.status()})")
        made = self.solid.to_mesh64()  # to_mesh rounds to single precision, and corners then no longer meet
        vertices = np.asarray(made.vert_properties)[:, :3]
        merged = np.arange(len(vertices))
        merged[np.asarray(made.merge_from_vert, int)] = np.asarray(made.merge_to_vert, int)
        triangles = merged[np.asarray(made.tri_verts, np.int64)]
        used, triangles = np.unique(triangles, return_inverse=True)
        runs, ids = np.asarray(made.run_index, int) // 3, np.asarray(made.run_original_id, int)
        names = tuple(dict.fromkeys(self.patches[i] for i in ids))
        patch = np.repeat([names.index(self.patches[i]) for i in ids], np.diff(runs))
        return Mesh(vertices[used], triangles.reshape(-1, 3), patch.astype(np.int64), names)


@dataclass(frozen=True)
class Faceted:
    """Kernel whose curved surfaces are facets with edges of about `edge` [m]."""

    edge: float

    def cylinder(self, patch: str, radius: float, low: float, high: float) -> Part:
        """A prism about the axis with its corners on the cylinder."""
        return _name_patch(self._prism(radius, low, high), patch)

    def radial_cylinder(self, patch: str, radius: float, angle: float, near: float, far: float, z: float) -> Part:
        """A prism whose axis is the ray at `angle`, from `near` to `far`."""
        along = self._prism(radius, near, far).rotate([0.0, 90.0, float(np.degrees(angle))])
        return _name_patch(along.translate([0.0, 0.0, float(z)]), patch)

    def _prism(self, radius: float, low: float, high: float) -> Manifold:
        segments = self._edges(2.0 * np.pi * radius, 48)
        return Manifold.cylinder(float(high - low), float(radius), circular_segments=segments).translate(
            [0.0, 0.0, float(low)]
        )

    def ring(self, patch: str, centre_radius: float, radius: float, z: float) -> Part:
        """A torus about the axis, its centre line at `z`."""
        n, m = self._edges(2.0 * np.pi * radius, 64), self._edges(np.pi * centre_radius, 48)
        phi, turn = 2.0 * np.pi * np.arange(n) / n, 2.0 * np.pi * np.arange(m)[:, None] / m
        out, height = centre_radius + radius * np.cos(phi), np.broadcast_to(z + radius * np.sin(phi), (m, n))
        return _name_patch(_tube(np.stack([out * np.cos(turn), out * np.sin(turn), height], axis=-1)), patch)

    def bent_rod(self, patch: str, centre_radius: float, radius: float, begin: float, end: float) -> Part:
        """An arc of a torus about the axis, in the plane z = 0, with a hemisphere at either end."""
        r, n = radius, self._edges(2.0 * np.pi * radius, 64)
        m = self._edges(0.5 * centre_radius * (end - begin), 16)
        cap, phi = np.linspace(0.0, 0.5 * np.pi, n // 4 + 1)[1:-1], 2.0 * np.pi * np.arange(n) / n
        # Each ring: angle of its plane, how far it lies beyond the arc, its radius.
        planes = [(begin, -r * np.cos(c), r * np.sin(c)) for c in cap]
        planes += [(angle, 0.0, r) for angle in np.linspace(begin, end, m + 1)]
        planes += [(end, r * np.cos(c), r * np.sin(c)) for c in cap[::-1]]
        rings = []
        for angle, beyond, size in planes:
            out, along = _directions(angle)
            across = np.outer(centre_radius + size * np.cos(phi), out) + np.outer(size * np.sin(phi), [0.0, 0.0, 1.0])
            rings.append(across + beyond * along)
        poles = []
        for angle, beyond in ((begin, -r), (end, r)):
            out, along = _directions(angle)
            poles.append(centre_radius * out + beyond * along)
        return _name_patch(_tube(np.array(rings), poles), patch)

    def mapped_box(self, patch: str, placed: Placed, lengths: Sequence[float]) -> Part:
        """The unit cube, its faces divided by edges, with every node moved to where `placed` puts it."""
        na, nb, nc = (self._edges(length, 1) for length in lengths)
        number = np.arange((na + 1) * (nb + 1) * (nc + 1)).reshape(na + 1, nb + 1, nc + 1)
        faces = [number[0], number[-1].T, number[:, 0].T, number[:, -1], number[:, :, 0], number[:, :, -1].T]
        triangles = []
        for face in faces:
            p, q, r, s = face[:-1, :-1], face[1:, :-1], face[1:, 1:], face[:-1, 1:]
            triangles += [np.stack([p, s, r], -1).reshape(-1, 3), np.stack([p, r, q], -1).reshape(-1, 3)]
        used, numbered = np.unique(np.vstack(triangles), return_inverse=True)
        a, b, c = np.unravel_index(used, number.shape)
        return _name_patch(_surface(placed(a / na, b / nb, c / nc), numbered.reshape(-1, 3)), patch)

    def _edges(self, length: float, least: int) -> int:
        return max(least, int(np.ceil(length / self.edge - 1e-9)))


def _name_patch(solid: Manifold, patch: str) -> Part:
    original = solid.as_original()
    return Part(original, {original.original_id(): patch})


def _directions(angle: float) -> tuple[Floats, Floats]:
    """Outwards and along the turn at `angle`."""
    cos, sin = np.cos(angle), np.sin(angle)
    return np.array([cos, sin, 0.0]), np.array([-sin, cos, 0.0])


def _surface(vertices: Floats, triangles: NDArray[np.int64]) -> Manifold:
    """The solid within a closed surface, turned outside out if need be."""
    a, b, c = np.moveaxis(vertices[triangles] - vertices.mean(0), 1, 0)
    if np.einsum("ij,ij->", a, np.cross(b, c)) < 0.0:
        triangles = triangles[:, ::-1]
    made = Manifold(Mesh64(np.ascontiguousarray(vertices), np.ascontiguousarray(triangles, dtype=np.uint64)))
    if made.status() != Error.NoError:
        raise RunError(f"a solid could not be made ({made.status()})")
    return made


def _tube(rings: Floats, poles: Sequence[Floats] = ()) -> Manifold:
    """The solid within rings of shape (m, n, 3): closed to a torus, or with a pole at either end."""
    m, n, _ = rings.shape
    number, vertices = np.arange(m * n).reshape(m, n), rings.reshape(-1, 3)
    wrapped = np.concatenate([number, number[:, :1]], axis=1)
    if not poles:
        wrapped = np.concatenate([wrapped, wrapped[:1]])
    p, q, r, s = wrapped[:-1, :-1], wrapped[1:, :-1], wrapped[1:, 1:], wrapped[:-1, 1:]
    triangles = [np.stack([p, s, r], -1).reshape(-1, 3), np.stack([p, r, q], -1).reshape(-1, 3)]
    if poles:
        first, last = wrapped[0], wrapped[-1]
        triangles.append(np.stack([np.full(n, m * n), first[1:], first[:-1]], -1))
        triangles.append(np.stack([np.full(n, m * n + 1), last[:-1], last[1:]], -1))
        vertices = np.vstack([vertices, *poles])
    return _surface(vertices, np.vstack(triangles))
