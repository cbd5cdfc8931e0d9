"""A sharp orifice in a pipe, whose drop a standard knows to half a percent: what schemes and turbulence are worth."""

import math
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import numpy as np

from vvdp.base.arrays import Array
from vvdp.cfd.blocks import BLOCK_MESH, block, block_mesh_text
from vvdp.cfd.boundary import Patch, constraint, flow_inlet, pressure_outlet, wall
from vvdp.cfd.case import Case, Fluid
from vvdp.cfd.convergence import History
from vvdp.cfd.monitor import read_monitor
from vvdp.cfd.numerics import SECOND_ORDER, UPWIND, patch_mean
from vvdp.cfd.turbulence import STANDARD, duct_turbulence
from vvdp.cfd.verification import WEDGE
from vvdp.cfd.watching import align

UPSTREAM, DOWNSTREAM, CORNER = 4.0, 12.0, 0.9
"""Lengths of pipe before and behind the plate, and where the corners begin on it, over the pipe's radius."""
GROWTH = 8.0
"""Length of the cells at the ends of the pipe over that of those at the plate."""
MOST = 3000
"""Iterations at most."""
TOLERANCE = 1e-4
TAPS = ("before", "behind")


class Orifice(NamedTuple):
    """A sharp orifice in a pipe: radii of both, thickness of the plate [m], mean velocity in the pipe [m/s]."""

    hole: float
    pipe: float
    plate: float
    velocity: float


def orifice_coefficient(ratio: float, reynolds: float) -> float:
    """Discharge coefficient of a sharp orifice with taps in the corners between plate and pipe [1], to 0.5 %.

    ratio     diameter of the hole over that of the pipe, 0.1 to 0.6
    reynolds  number of the pipe, 5000 or more; pipes of 71 mm or more

    Source  iso5167

    >>> print(f"{orifice_coefficient(0.5, 1e5):.4f}")
    0.6069
    """
    a = (19_000.0 * ratio / reynolds) ** 0.8
    still = 0.5961 + 0.0261 * ratio**2 - 0.216 * ratio**8
    slow = (0.0188 + 0.0063 * a) * ratio**3.5 * (1e6 / reynolds) ** 0.3
    return float(still + 0.000521 * (1e6 * ratio / reynolds) ** 0.7 + slow)


def orifice_drop(orifice: Orifice, fluid: Fluid) -> float:
    """Pressure across the plate [Pa], rho/2 (v / (C beta^2))^2 (1 - beta^4); see `orifice_coefficient`.

    Source  iso5167
    """
    ratio = orifice.hole / orifice.pipe
    reynolds = 2.0 * orifice.pipe * orifice.velocity * fluid.density / fluid.viscosity
    jet = orifice.velocity / (orifice_coefficient(ratio, reynolds) * ratio**2)
    return 0.5 * fluid.density * jet**2 * (1.0 - ratio**4)


def orifice_case(orifice: Orifice, fluid: Fluid, cells: int) -> Case:
    """A slice of the pipe with so many cells along its radius, judged by the pressure across the plate in its corners.

    The flow enters with the profile of turbulent flow, (1 - r/R)^(1/7).

    Source  iso5167
    """
    entering = duct_turbulence(orifice.velocity, 2.0 * orifice.pipe)
    speeds = _speeds(orifice.velocity, np.concatenate(_rings(orifice, cells)))
    profile = " ".join(f"( 0 0 {float(speed)!r} )" for speed in speeds)
    velocity = {"type": "fixedValue", "value": f"nonuniform List<vector> {len(speeds)} ( {profile} )"}
    patches = {
        "inlet": Patch("patch", {**flow_inlet(1.0, entering).conditions, "U": velocity}),
        "outlet": pressure_outlet(entering),
        **dict.fromkeys(("wall", *TAPS), wall(entering)),
        "front": constraint("wedge"),
        "back": constraint("wedge"),
    }
    return Case(
        mesh_files={BLOCK_MESH: _mesh(orifice, cells)},
        mesh_programs=(("blockMesh",),),
        patches=patches,
        monitors={tap: patch_mean(tap, "areaAverage", "p") for tap in TAPS},
        read_history=partial(_across_plate, fluid.density),
        fluid=fluid,
        turbulence=STANDARD,
        start=entering,
        phases=(UPWIND, SECOND_ORDER._replace(most=MOST, tolerance=TOLERANCE)),
        largest=1e3 * orifice_drop(orifice, fluid),
    )


def _across_plate(density: float, case: Path) -> History:
    before, behind = align([read_monitor(case, tap) for tap in TAPS])
    return History(before.iterations, density * (before.values[:, 0] - behind.values[:, 0]), {})


def _rings(orifice: Orifice, cells: int) -> list[Array]:
    """Edges of the cells of each ring of blocks, over the pipe's radius: hole, plate, corner."""
    ends = (0.0, orifice.hole / orifice.pipe, CORNER, 1.0)
    return [np.linspace(low, high, 1 + max(2, round(cells * (high - low)))) for low, high in pairwise(ends)]


def _speeds(mean: float, edges: Array) -> Array:
    """Mean of a turbulent profile over each ring of faces, between edges of which neighbours may be equal [m/s]."""
    s = 1.0 - edges
    whole = 2.0 * (7.0 / 8.0 * s ** (8.0 / 7.0) - 7.0 / 15.0 * s ** (15.0 / 7.0))
    area = np.diff(edges**2)
    inside = area > 0.0
    speeds: Array = mean * -np.diff(whole)[inside] / (area[inside] * (whole[0] - whole[-1]))
    return speeds


def _mesh(orifice: Orifice, cells: int) -> str:
    """Seven blocks: three rings before and behind the plate, one in the hole. A station along the axis has one corner
    on it and two for each ring."""
    radius, half = orifice.pipe, 0.5 * WEDGE
    rings = _rings(orifice, cells)
    stations = (-UPSTREAM * radius, 0.0, orifice.plate, orifice.plate + DOWNSTREAM * radius)
    rims = [(radius * each[-1] * math.cos(half), radius * each[-1] * math.sin(half)) for each in rings]
    vertices = [(x, y, z) for z in stations for x, y in [(0.0, 0.0), *((x, s * y) for x, y in rims for s in (-1, 1))]]
    length = [abs(np.diff(stations))[place] * cells / radius for place in range(3)]
    packed = math.log(GROWTH) / (GROWTH - 1.0)
    along = (round(length[0] * packed), max(2, round(length[1])), round(length[2] * packed))
    growth = (1.0 / GROWTH, 1.0, GROWTH)
    places = [(part, ring) for part in (0, 1, 2) for ring in range(3) if part != 1 or ring == 0]
    blocks = []
    for part, ring in places:
        counts = (len(rings[ring]) - 1, 1, along[part])
        blocks.append(block((*_quad(part, ring), *_quad(part + 1, ring)), counts, (1.0, 1.0, growth[part])))
    faces = {
        "inlet": ("patch", [_quad(0, ring) for ring in range(3)]),
        "outlet": ("patch", [_quad(3, ring) for ring in range(3)]),
        "wall": ("wall", [_quad(1, 1), _quad(2, 1), _outside(0, 2), _outside(1, 0), _outside(2, 2)]),
        "before": ("wall", [_quad(1, 2)]),
        "behind": ("wall", [_quad(2, 2)]),
        "front": ("wedge", [_side(part, ring, 0) for part, ring in places]),
        "back": ("wedge", [_side(part, ring, 1) for part, ring in places]),
    }
    return block_mesh_text(vertices, blocks, faces)


def _corner(station: int, rim: int, side: int) -> int:
    """A corner of a station: rim 0 is the axis."""
    return 7 * station + (1 + 2 * (rim - 1) + side if rim else 0)


def _quad(station: int, ring: int) -> tuple[int, ...]:
    """The face of a ring across the axis."""
    rims = ((ring, 0), (ring + 1, 0), (ring + 1, 1), (ring, 1))
    return tuple(_corner(station, rim, side) for rim, side in rims)


def _outside(part: int, ring: int) -> tuple[int, ...]:
    """The outer face of a block."""
    ends = ((part, 0), (part, 1), (part + 1, 1), (part + 1, 0))
    return tuple(_corner(station, ring + 1, side) for station, side in ends)


def _side(part: int, ring: int, side: int) -> tuple[int, ...]:
    """The face of a block on one side of the slice."""
    ends = ((part, ring), (part, ring + 1), (part + 1, ring + 1), (part + 1, ring))
    return tuple(_corner(station, rim, side) for station, rim in ends)
