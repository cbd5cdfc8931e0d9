"""Meshes as files and back, in metres: STL, binary and ASCII with a solid for each patch, and GLB for viewers."""

import json
import struct
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from vvdp.base.errors import unusable
from vvdp.geometry.mesh import Floats, Mesh, normal_areas

Colour = tuple[float, float, float]
GREY: Colour = (0.72, 0.74, 0.77)
_GLB, _JSON, _BIN = 0x46546C67, 0x4E4F534A, 0x004E4942
_TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("more", "<u2")])


def _normals(corners: Floats) -> Floats:
    areas = normal_areas(corners)
    size = np.linalg.norm(areas, axis=1, keepdims=True)
    normals: Floats = areas / np.where(size > 0.0, size, 1.0)
    return normals


def write_binary_stl(path: Path, mesh: Mesh) -> None:
    """One body without patches, in single precision as the format demands."""
    records = np.zeros(len(mesh.triangles), _TRIANGLE)
    records["corners"], records["normal"] = mesh.corners, _normals(mesh.corners)
    head = b"vvdp, lengths in metres".ljust(80) + struct.pack("<I", len(records))
    path.write_bytes(head + records.tobytes())


def write_ascii_stl(path: Path, mesh: Mesh) -> None:
    """One `solid` for each patch, every number with its full precision, so that patches still fit at their edges."""
    with path.open("w", encoding="ascii") as file:
        for name in mesh.names:
            corners = mesh.of(name)
            file.write(f"solid {name}\n")
            for normal, triangle in zip(_normals(corners).tolist(), corners.tolist(), strict=True):
                points = "".join(f"vertex {x!r} {y!r} {z!r}\n" for x, y, z in triangle)
                a, b, c = normal
                file.write(f"facet normal {a:.6g} {b:.6g} {c:.6g}\nouter loop\n{points}endloop\nendfacet\n")
            file.write(f"endsolid {name}\n")


def read_stl(path: Path) -> Mesh:
    """The mesh of an STL file, corners joined where they are equal. Raises ConfigError where it is none."""
    content = path.read_bytes()
    if len(content) >= 84 and len(content) == 84 + 50 * struct.unpack("<I", content[80:84])[0]:
        corners = np.frombuffer(content, _TRIANGLE, offset=84)["corners"].astype(float)
        return _merged(corners, np.zeros(len(corners), np.int64), ("body",))
    names: list[str] = []
    numbers: list[str] = []
    patch: list[int] = []
    for line in content.decode("ascii", "replace").splitlines():
        words = line.split()
        if words[:1] == ["solid"]:
            names.append(words[1] if len(words) > 1 else "body")
        elif words[:1] == ["vertex"]:
            numbers += words[1:]
        elif words[:1] == ["endfacet"]:
            patch.append(len(names) - 1)
    if not patch or len(numbers) != 9 * len(patch):
        raise unusable(path, "is not an STL file")
    return _merged(np.array(numbers, float).reshape(-1, 3, 3), np.array(patch, np.int64), tuple(names))


def _merged(corners: Floats, patch: "np.ndarray[tuple[int], np.dtype[np.int64]]", names: tuple[str, ...]) -> Mesh:
    vertices, place = np.unique(corners.reshape(-1, 3), axis=0, return_inverse=True)
    triangles = place.reshape(-1, 3)
    whole = (triangles != np.roll(triangles, 1, axis=1)).all(1)  # rounding to single precision may shrink an edge to 0
    return Mesh(vertices, triangles[whole].astype(np.int64), patch[whole], names)


def write_glb(path: Path, mesh: Mesh, name: str, colours: Mapping[str, Colour] | None = None) -> None:
    """Binary glTF 2.0, a primitive and a material for each patch; turned so that z points up, where viewers have y."""
    views, accessors, primitives, materials, blobs = [], [], [], [], []
    offset = 0
    for place, patch in enumerate(mesh.names):
        chosen = mesh.triangles[mesh.patch == place]
        used, numbered = np.unique(chosen, return_inverse=True)
        points = mesh.vertices[used].astype("<f4")
        for data, target in ((points.tobytes(), 34962), (numbered.astype("<u4").tobytes(), 34963)):
            views.append({"buffer": 0, "byteOffset": offset, "byteLength": len(data), "target": target})
            blobs.append(data)
            offset += len(data)
        low, high = (bound.astype(float).tolist() for bound in (points.min(0), points.max(0)))
        accessors.append(
            {
                "bufferView": 2 * place,
                "componentType": 5126,
                "count": len(used),
                "type": "VEC3",
                "min": low,
                "max": high,
            }
        )
        accessors.append({"bufferView": 2 * place + 1, "componentType": 5125, "count": chosen.size, "type": "SCALAR"})
        primitives.append({"attributes": {"POSITION": 2 * place}, "indices": 2 * place + 1, "material": place})
        colour = [*(colours or {}).get(patch, GREY), 1.0]
        metal = {"baseColorFactor": colour, "metallicFactor": 0.2, "roughnessFactor": 0.6}
        materials.append({"name": patch, "pbrMetallicRoughness": metal, "doubleSided": True})
    half = float(np.sqrt(0.5))
    content = {
        "asset": {"version": "2.0", "generator": "vvdp"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"name": name, "mesh": 0, "rotation": [-half, 0.0, 0.0, half]}],
        "meshes": [{"name": name, "primitives": primitives}],
        "materials": materials,
        "accessors": accessors,
        "bufferViews": views,
        "buffers": [{"byteLength": offset}],
    }
    text = json.dumps(content, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    binary = b"".join(blobs)
    binary += b"\0" * (-len(binary) % 4)
    chunks = struct.pack("<II", len(text), _JSON) + text + struct.pack("<II", len(binary), _BIN) + binary
    path.write_bytes(struct.pack("<III", _GLB, 2, 12 + len(chunks)) + chunks)


def read_glb(path: Path) -> Mesh:
    """The mesh of a GLB file as `write_glb` makes it, in its own coordinates. Raises ConfigError where it is none."""
    content = path.read_bytes()
    if len(content) < 28 or struct.unpack("<III", content[:12])[::2] != (_GLB, len(content)):
        raise unusable(path, "is not a GLB file")
    size, kind = struct.unpack("<II", content[12:20])
    after = 20 + size
    length, second = struct.unpack("<II", content[after : after + 8])
    if (kind, second) != (_JSON, _BIN):
        raise unusable(path, "is not a GLB file with JSON and binary chunk")
    document, binary = json.loads(content[20:after]), content[after + 8 : after + 8 + length]

    def data(number: int, kind: str) -> "np.ndarray[tuple[int], np.dtype[np.float64]]":
        view = document["bufferViews"][document["accessors"][number]["bufferView"]]
        return np.frombuffer(binary, kind, view["byteLength"] // 4, view["byteOffset"])

    corners, patch, names = [], [], []
    for place, primitive in enumerate(document["meshes"][0]["primitives"]):
        points = data(primitive["attributes"]["POSITION"], "<f4").reshape(-1, 3).astype(float)
        corners.append(points[data(primitive["indices"], "<u4")].reshape(-1, 3, 3))
        patch.append(np.full(len(corners[-1]), place, np.int64))
        names.append(document["materials"][primitive["material"]]["name"])
    return _merged(np.concatenate(corners), np.concatenate(patch), tuple(names))
