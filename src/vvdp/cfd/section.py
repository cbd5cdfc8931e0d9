"""Plane sections through a computed flow: OpenFOAM cuts them, and what it writes is read back for pictures."""

import base64
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple
from xml.etree import ElementTree

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.errors import RunError
from vvdp.cfd.case import write_files
from vvdp.cfd.dictionary import Entry, dictionary_text
from vvdp.cfd.engine import OpenFoam
from vvdp.cfd.monitor import FOLDER, starts, times
from vvdp.cfd.programs import run_program
from vvdp.cfd.streamlines import STREAMLINES, streamline_function
from vvdp.geometry.mesh import Floats, Indices

SECTIONS, FRAMES, INLET = "sections", "frames", "inlet"
DICTIONARY = f"system/{SECTIONS}"


class Plane(NamedTuple):
    """A plane through a point [m], with its normal."""

    point: tuple[float, float, float]
    normal: tuple[float, float, float]


class Section(NamedTuple):
    """A cut: points [m], corners and ends of the polygons that the cells leave in it, fields at the points.

    Pressures are kinematic, over the density [m^2/s^2]; velocities [m/s].
    """

    points: Floats
    corners: Indices
    ends: Indices
    pressure: Array
    velocity: Floats

    @property
    def polygons(self) -> list[Indices]:
        """The corners of each polygon, as places of points."""
        return np.split(self.corners, self.ends[:-1])

    @property
    def triangles(self) -> Indices:
        """The polygons in triangles, each fanned out from its first corner."""
        fans = [np.column_stack([np.full(len(each) - 2, each[0]), each[1:-1], each[2:]]) for each in self.polygons]
        return np.concatenate(fans)

    @property
    def axial_moment(self) -> float:
        """Angular momentum about z that leaves through it with the moment of the pressure, over the density [m^5/s^2].

        A patch faces outwards, so that oil which leaves takes its momentum along.
        """
        corners = self.points[self.triangles]
        areas = 0.5 * np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        middles, speeds = corners.mean(1), self.velocity[self.triangles].mean(1)
        pressures = self.pressure[self.triangles].mean(1)
        pushed = speeds * (speeds * areas).sum(1)[:, None] + pressures[:, None] * areas
        return float(np.cross(middles, pushed)[:, 2].sum())


def cut_sections(planes: Mapping[str, Plane], patches: Sequence[str], case: Path, openfoam: OpenFoam) -> float:
    """Lets OpenFOAM cut the last state of a case and show it on patches, as `read_section` reads it; the seconds.

    From patches that are inlets streamlines are followed.
    """
    functions: dict[str, Entry] = {SECTIONS: _surface_writer([*_plane_entries(planes), *_patch_entries(patches)], 1)}
    if inlets := [patch for patch in patches if patch.startswith(INLET)]:
        functions[STREAMLINES] = streamline_function(inlets)
    write_files(case, {DICTIONARY: dictionary_text({"functions": functions}, SECTIONS)})
    return run_program(("postProcess", "-latestTime", "-dict", DICTIONARY, "-fields", "(p U)"), case, openfoam)


def frame_function(name: str, plane: Plane, interval: int) -> Mapping[str, Entry]:
    """A function object, to be called `FRAMES`, that cuts the flow every `interval` steps; `read_frames` reads it.

    It cuts tetrahedra: cells whose faces are there twice, where meshes slide, would be left out.
    """
    return _surface_writer([name, _cut("cuttingPlane", plane)], interval)


def _cut(kind: str, plane: Plane) -> Mapping[str, Entry]:
    through: Mapping[str, Entry] = {"point": plane.point, "normal": plane.normal}
    return {
        "type": kind,
        "planeType": "pointAndNormal",
        "pointAndNormalDict": through,
        "triangulate": False,
        "interpolate": True,
    }


def _plane_entries(planes: Mapping[str, Plane]) -> list[Entry]:
    """Planes by their names."""
    return [entry for name, plane in planes.items() for entry in (name, _cut("plane", plane))]


def _patch_entries(patches: Sequence[str]) -> list[Entry]:
    """Patches by their names."""
    surfaces: list[Entry] = []
    for patch in patches:
        surfaces += [patch, {"type": "patch", "patches": (patch,), "triangulate": False, "interpolate": True}]
    return surfaces


def _surface_writer(surfaces: Sequence[Entry], interval: int) -> Mapping[str, Entry]:
    """A function object that writes pressure and velocity on surfaces every `interval` steps."""
    return {
        "type": "surfaces",
        "libs": ("sampling",),
        "fields": ("p", "U"),
        "surfaceFormat": "vtk",
        "interpolationScheme": "cellPoint",
        "executeControl": "timeStep",
        "executeInterval": interval,
        "writeControl": "timeStep",
        "writeInterval": interval,
        "surfaces": surfaces,
    }


def read_frames(case: Path, name: str) -> dict[float, Section]:
    """The sections of a plane that were cut while a flow was computed, by the time [s]."""
    found = times(case / FOLDER / FRAMES)
    return {time: _read(path) for time, folder in found.items() if (path := folder / f"{name}.vtp").is_file()}


def read_section(case: Path, name: str) -> Section | None:
    """A section that was cut last, None where none was. Raises RunError where its file is damaged."""
    found = [path for start in starts(case, SECTIONS) if (path := start / f"{name}.vtp").is_file()]
    return _read(found[-1]) if found else None


def _read(path: Path) -> Section:
    """A section. Raises RunError where its file is damaged."""
    try:
        piece = ElementTree.parse(path).getroot().find("PolyData/Piece")
        assert piece is not None
        return Section(
            points=_array(piece, "Points/DataArray").reshape(-1, 3),
            corners=_array(piece, "Polys/DataArray[@Name='connectivity']").astype(np.int64),
            ends=_array(piece, "Polys/DataArray[@Name='offsets']").astype(np.int64),
            pressure=_array(piece, "PointData/DataArray[@Name='p']"),
            velocity=_array(piece, "PointData/DataArray[@Name='U']").reshape(-1, 3),
        )
    except (ElementTree.ParseError, AssertionError, ValueError) as problem:
        raise RunError(f"{path} is damaged: {problem}") from None


TYPES: Mapping[str, str] = {"Float32": "<f4", "Float64": "<f8", "Int32": "<i4", "Int64": "<i8"}
HEADER = 8
"""Bytes that say how many follow."""


def _array(piece: ElementTree.Element, path: str) -> Array:
    """The numbers of a DataArray, as text or in base 64."""
    found = piece.find(path)
    if found is None or found.text is None:
        raise ValueError(f"{path} missing")
    if found.get("format") == "ascii":
        return np.array(found.text.split(), float)
    content = base64.b64decode("".join(found.text.split()))
    numbers: Array = np.frombuffer(content[HEADER:], TYPES[str(found.get("type"))]).astype(float)
    return numbers
