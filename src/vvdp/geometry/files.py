"""Meshes as files and back, in metres: STL, binary and ASCII with a solid for each patch, and GLB for viewers.

trimesh writes and reads the formats. Which patch a triangle belongs to, and which corners are the same, is ours:
trimesh would join corners that lie within 10 nm of each other.
"""

import io
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from trimesh import Scene, Trimesh
from trimesh.exchange.gltf import export_glb, load_glb
from trimesh.exchange.stl import export_stl, export_stl_ascii, load_stl
from trimesh.visual import TextureVisuals
from trimesh.visual.material import PBRMaterial

from vvdp.base.errors import unusable
from vvdp.geometry.mesh import Floats, Mesh

Colour = tuple[float, float, float]
GREY: Colour = (0.72, 0.74, 0.77)
HEAD = b"vvdp, lengths in metres".ljust(80)
UPRIGHT = np.array([[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, -1.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]])
"""Turns z upwards where viewers have y."""

COLOURS: Mapping[str, Colour] = {
    "spool": (0.76, 0.78, 0.81),
    "sleeve": (0.82, 0.84, 0.86),
    "section": (0.90, 0.91, 0.92),
    "bore": (0.62, 0.66, 0.71),
    "windows": (0.93, 0.76, 0.52),
    "chamber": (0.56, 0.72, 0.86),
    "channels": (0.30, 0.55, 0.78),
    "collector": (0.24, 0.40, 0.60),
    "outlet": (0.08, 0.22, 0.42),
    "rail": (0.90, 0.62, 0.32),
    "nozzles": (0.85, 0.45, 0.05),
    "inlet": (0.62, 0.30, 0.02),
}
"""Of patches in pictures and GLB files; a numbered patch has the colour of its name."""


def patch_colour(name: str) -> Colour:
    """The colour of a patch, grey where it has none of its own."""
    return COLOURS.get(name.rstrip("0123456789"), GREY)


def _patches(mesh: Mesh) -> list[Trimesh]:
    """A surface for each patch, in the order of their names."""
    parts = []
    for place, name in enumerate(mesh.names):
        used, numbered = np.unique(mesh.triangles[mesh.patch == place], return_inverse=True)
        metadata = {"name": name}
        parts.append(Trimesh(mesh.vertices[used], numbered.reshape(-1, 3), process=False, metadata=metadata))
    return parts


def write_binary_stl(path: Path, mesh: Mesh) -> None:
    """One body without patches, in single precision as the format demands."""
    path.write_bytes(HEAD + export_stl(mesh.surface)[len(HEAD) :])


def write_ascii_stl(path: Path, mesh: Mesh) -> None:
    """One `solid` for each patch, see `ascii_stl`."""
    path.write_text(ascii_stl(mesh), encoding="ascii")


def ascii_stl(mesh: Mesh) -> str:
    """One `solid` for each patch, every number with its full precision, so that patches still fit at their edges."""
    return "".join(export_stl_ascii(part) for part in _patches(mesh))


def read_stl(path: Path) -> Mesh:
    """The mesh of an STL file, corners joined where they are equal. Raises ConfigError where it is none."""
    try:
        found = load_stl(io.BytesIO(path.read_bytes()))
    except ValueError:
        raise unusable(path, "is not an STL file") from None
    solids = found.get("geometry", {found.get("metadata", {}).get("name", "body"): found})
    if not solids:
        raise unusable(path, "is not an STL file")
    return _merge([solid["vertices"][solid["faces"]] for solid in solids.values()], list(solids))


def write_glb(path: Path, mesh: Mesh, name: str) -> None:
    """Binary glTF 2.0, a mesh and a material for each patch, on nodes below one that is called `name`; z points up."""
    scene = Scene(base_frame=name)
    for patch, part in zip(mesh.names, _patches(mesh), strict=True):
        material = PBRMaterial(
            name=patch,
            baseColorFactor=[*patch_colour(patch), 1.0],
            metallicFactor=0.2,
            roughnessFactor=0.6,
            doubleSided=True,
        )
        part.visual = TextureVisuals(material=material)
        scene.add_geometry(part, node_name=f"{name}, {patch}", geom_name=patch, transform=UPRIGHT)
    path.write_bytes(export_glb(scene, include_normals=False))


def read_glb(path: Path) -> Mesh:
    """The mesh of a GLB file as `write_glb` makes it, in its own coordinates. Raises ConfigError where it is none."""
    try:
        parts = load_glb(io.BytesIO(path.read_bytes()))["geometry"]
    except (ValueError, IndexError, KeyError, NotImplementedError):
        raise unusable(path, "is not a GLB file") from None
    return _merge([part["vertices"][part["faces"]] for part in parts.values()], list(parts))


def _merge(corners: Sequence[Floats], names: Sequence[str]) -> Mesh:
    """The mesh of patches that are given by the corners of their triangles."""
    patch = np.repeat(np.arange(len(corners)), [len(each) for each in corners])
    points = np.concatenate(corners).reshape(-1, 3).astype(float)
    vertices, place = np.unique(points, axis=0, return_inverse=True)
    triangles = place.reshape(-1, 3)
    whole = (triangles != np.roll(triangles, 1, axis=1)).all(1)  # rounding to single precision may shrink an edge to 0
    return Mesh(vertices, triangles[whole].astype(np.int64), patch[whole], tuple(names))
