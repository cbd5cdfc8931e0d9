"""A mesh of hexahedra from a closed surface with named patches, by blockMesh and snappyHexMesh."""

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from vvdp.cfd.blocks import BLOCK_MESH, Point, block, block_mesh_text
from vvdp.cfd.dictionary import Entry, dictionary_text
from vvdp.cfd.rotor import ROTOR, STATOR
from vvdp.cfd.sliding import RING
from vvdp.geometry.domains import Domain
from vvdp.geometry.files import ascii_stl
from vvdp.geometry.mesh import Floats

SURFACE = "constant/triSurface/oil.stl"
MARGIN = 0.77
"""Cells that the background reaches beyond the surface: never on it, where a face would fall together with one."""
FEATURE_ANGLE = 150
"""Edges whose faces meet at less than this [deg] are kept."""


TURN = math.radians(10.0)
"""A valve is turned so far about its axis that no nozzle lies along the cells: mouths keep their area within 0.6 %,
where one that does loses 4 %."""


def turn_domain(domain: Domain) -> Domain:
    """The same oil, turned by `TURN` about the axis."""
    cos, sin = math.cos(TURN), math.sin(TURN)
    turn = np.array([[cos, sin, 0.0], [-sin, cos, 0.0], [0.0, 0.0, 1.0]])
    inside, *further = ((x, y, z) for x, y, z in (np.array([domain.inside, *domain.further]) @ turn).tolist())
    mesh = replace(domain.mesh, vertices=domain.mesh.vertices @ turn)
    return replace(domain, mesh=mesh, inside=inside, further=tuple(further))


class Cylinder(NamedTuple):
    """An upright cylinder about the axis within which cells are halved `level` times [m]."""

    radius: float
    low: float
    high: float
    level: int

    @property
    def entry(self) -> Mapping[str, Entry]:
        """As snappyHexMesh knows it."""
        ends: Mapping[str, Entry] = {"point1": (0, 0, self.low), "point2": (0, 0, self.high)}
        return {"type": "searchableCylinder", **ends, "radius": self.radius}


class Sphere(NamedTuple):
    """A sphere [m] within which cells are halved `level` times."""

    centre: Point
    radius: float
    level: int

    @property
    def entry(self) -> Mapping[str, Entry]:
        """As snappyHexMesh knows it."""
        return {"type": "searchableSphere", "centre": self.centre, "radius": self.radius}


class Ring(NamedTuple):
    """A cylinder [m] that parts the mesh: what lies within is a zone of its own, and may slide along what does not."""

    cylinder: Cylinder
    zone: str


class Refinement(NamedTuple):
    """Size of the background's cells [m], how often they are halved at each patch, along edges, and in some bodies."""

    cell: float
    patches: Mapping[str, int]
    edges: int
    within: tuple[Cylinder | Sphere, ...]
    ring: Ring | None = None


def meshing_files(domain: Domain, kinds: Mapping[str, str], fine: Refinement) -> dict[str, str]:
    """The surface of a domain, and the dictionaries of all programs that make its mesh, by path.

    kinds  type of each patch
    """
    features: Mapping[str, Entry] = {
        "oil.stl": {
            "extractionMethod": "extractFromSurface",
            "extractFromSurfaceCoeffs": {"includedAngle": FEATURE_ANGLE},
            "includedAngle": FEATURE_ANGLE,
            "writeObj": False,
        }
    }
    return {
        SURFACE: ascii_stl(domain.mesh),
        BLOCK_MESH: _background(domain.mesh.vertices, fine.cell),
        "system/surfaceFeatureExtractDict": dictionary_text(features, "surfaceFeatureExtractDict"),
        "system/snappyHexMeshDict": dictionary_text(_snapping(domain, kinds, fine), "snappyHexMeshDict"),
    }


PROGRAMS = (("blockMesh",), ("surfaceFeatureExtract",), ("snappyHexMesh", "-overwrite"))
"""Programs that make the mesh, one after the other."""
ORDERING = ("renumberMesh", "-overwrite")
"""Then it is solved faster."""


def _background(points: Floats, cell: float) -> str:
    """A box of cubes round all points."""
    low = points.min(0) - MARGIN * cell
    counts = np.ceil((points.max(0) + MARGIN * cell - low) / cell).astype(int)
    ends = np.array([low, low + counts * cell])
    corners = [(x, y, z) for z in (0, 1) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))]
    vertices = [(float(ends[x, 0]), float(ends[y, 1]), float(ends[z, 2])) for x, y, z in corners]
    sides = ((0, 4, 7, 3), (2, 6, 5, 1), (1, 5, 4, 0), (3, 7, 6, 2), (0, 3, 2, 1), (4, 5, 6, 7))
    nx, ny, nz = counts.tolist()
    return block_mesh_text(vertices, [block(range(8), (nx, ny, nz))], {"background": ("patch", sides)})


def _snapping(domain: Domain, kinds: Mapping[str, str], fine: Refinement) -> Mapping[str, Entry]:
    bodies: Mapping[str, Entry] = {name: within.entry for name, within in _near(fine).items()}
    rings: Mapping[str, Entry] = {RING: fine.ring.cylinder.entry} if fine.ring else {}
    named: Mapping[str, Entry] = {name: {"name": name} for name in fine.patches}
    return {
        "castellatedMesh": True,
        "snap": True,
        "addLayers": False,
        "geometry": {"oil.stl": {"type": "triSurfaceMesh", "name": "oil", "regions": named}, **bodies, **rings},
        "castellatedMeshControls": _castellation(domain, kinds, fine),
        "snapControls": {
            "nSmoothPatch": 3,
            "tolerance": 2.0,
            "nSolveIter": 50,
            "nRelaxIter": 5,
            "nFeatureSnapIter": 15,
            "implicitFeatureSnap": False,
            "explicitFeatureSnap": True,
            "multiRegionFeatureSnap": False,
        },
        "addLayersControls": _NO_LAYERS,
        "meshQualityControls": _QUALITY,
        "mergeTolerance": 1e-6,
    }


def _near(fine: Refinement) -> dict[str, Cylinder | Sphere]:
    """The bodies within which cells are smaller, by their names."""
    return {f"near{place or ''}": within for place, within in enumerate(fine.within)}


def _parting(ring: Ring | None) -> Mapping[str, Entry]:
    """Entry that makes the faces on a ring a zone, and the cells within it another."""
    if ring is None:
        return {}
    level = ring.cylinder.level
    zones: Mapping[str, Entry] = {"faceZone": RING, "cellZone": ring.zone, "cellZoneInside": "inside"}
    return {RING: {"level": (level, level), **zones}}


def _places(domain: Domain) -> Mapping[str, Entry]:
    """Where the oil is; of several pieces the first is the zone of cells that turns."""
    if not domain.further:
        return {"locationInMesh": domain.inside}
    return {"locationsInMesh": ((domain.inside, ROTOR), *((place, STATOR) for place in domain.further))}


def _castellation(domain: Domain, kinds: Mapping[str, str], fine: Refinement) -> Mapping[str, Entry]:
    """How cells are halved before they are moved to the surface."""
    regions: Mapping[str, Entry] = {
        name: {"level": (level, level), "patchInfo": {"type": kinds[name]}} for name, level in fine.patches.items()
    }
    lowest = min(fine.patches.values())
    return {
        "maxLocalCells": 20_000_000,
        "maxGlobalCells": 40_000_000,
        "minRefinementCells": 0,
        "nCellsBetweenLevels": 2,
        "resolveFeatureAngle": 30,
        "features": ({"file": '"oil.eMesh"', "level": fine.edges},),
        "refinementSurfaces": {"oil": {"level": (lowest, lowest), "regions": regions}, **_parting(fine.ring)},
        "refinementRegions": {
            name: {"mode": "inside", "levels": ((1e15, within.level),)} for name, within in _near(fine).items()
        },
        **_places(domain),
        "allowFreeStandingZoneFaces": False,
    }


_NO_LAYERS: Mapping[str, Entry] = {
    "relativeSizes": True,
    "layers": {},
    "expansionRatio": 1.0,
    "finalLayerThickness": 0.3,
    "minThickness": 0.1,
    "nGrow": 0,
    "featureAngle": 60,
    "nRelaxIter": 3,
    "nSmoothSurfaceNormals": 1,
    "nSmoothNormals": 3,
    "nSmoothThickness": 10,
    "maxFaceThicknessRatio": 0.5,
    "maxThicknessToMedialRatio": 0.3,
    "minMedialAxisAngle": 90,
    "nBufferCellsNoExtrude": 0,
    "nLayerIter": 50,
}
"""Read even where no layers are added."""
_QUALITY: Mapping[str, Entry] = {
    "maxNonOrtho": 65,
    "maxBoundarySkewness": 3.8,
    "maxInternalSkewness": 3.8,
    "maxConcave": 180,
    "minVol": 1e-18,
    "minTetQuality": 1e-15,
    "minArea": -1,
    "minTwist": 0.02,
    "minDeterminant": 0.001,
    "minFaceWeight": 0.05,
    "minVolRatio": 0.01,
    "minTriangleTwist": -1,
    "nSmoothScale": 4,
    "errorReduction": 0.75,
    "relaxed": {"maxNonOrtho": 75},
}
"""Lengths are metres: the usual least volume of 1e-13 would be (46 um)^3. Where an oblique nozzle meets the bore, cells
that follow its sharp edge are skewed; with the usual bounds it is cut off, and the mouth is up to 4 % too small."""
