"""The prototype's valve, its shape and its solids, made once; what tests alone measure on meshes; a command line."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from trimesh.triangles import cross

from vvdp.cli.main import main
from vvdp.geometry.mesh import Floats, Indices, Mesh
from vvdp.geometry.shape import ValveShape
from vvdp.geometry.shape_tables import valve_shape
from vvdp.geometry.solids import sleeve, spool
from vvdp.systems.system import load_system
from vvdp.valve.rotary import RotaryValve


@pytest.fixture(scope="session")
def built_valve() -> RotaryValve:
    return load_system("prototype", ()).case.params.valve


@pytest.fixture(scope="session")
def built_shape(built_valve) -> ValveShape:
    return valve_shape(built_valve)[0]


@pytest.fixture(scope="session")
def larger_valve(built_valve) -> RotaryValve:
    """A quarter larger in all lengths."""
    lengths = ("spool_radius", "helix_length", "land_length", "inlet_radius", "outlet_radius", "radial_clearance")
    longer = {name: 1.25 * getattr(built_valve, name) for name in lengths}
    wider = {name: 1.25**2 * getattr(built_valve, name) for name in ("nozzle_area", "outlet_area")}
    return replace(built_valve, **longer, **wider)


@pytest.fixture(scope="session")
def spool_mesh(built_shape, built_valve) -> Mesh:
    return spool(built_shape, built_valve, 25.0)


@pytest.fixture(scope="session")
def sleeve_mesh(built_shape, built_valve) -> Mesh:
    return sleeve(built_shape, built_valve, 25.0)


@pytest.fixture
def closing() -> Callable[[Mesh], float]:
    """Measures whether the area vectors of a mesh add up to nothing."""
    return _closing


@pytest.fixture
def crossings() -> Callable[[Mesh], int]:
    """Counts where a mesh passes through itself."""
    return _crossings


class Said(NamedTuple):
    code: int
    out: str
    err: str


@pytest.fixture
def command(capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[..., Said]:
    """Runs `vvdp geometry` in an empty folder."""
    monkeypatch.chdir(tmp_path)

    def call(*arguments: str) -> Said:
        capsys.readouterr()
        with pytest.raises(SystemExit) as ended:
            main(["geometry", *arguments])
        code = ended.value.code
        return Said(code if isinstance(code, int) else 0, *capsys.readouterr())

    return call


def _closing(mesh: Mesh) -> float:
    """Length of the sum of all area vectors over the area [1]; zero for a closed mesh."""
    areas = cross(mesh.corners)
    return float(np.linalg.norm(areas.sum(0)) / np.linalg.norm(areas, axis=1).sum())


def _crossings(mesh: Mesh, tolerance: float = 1e-9) -> int:
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
