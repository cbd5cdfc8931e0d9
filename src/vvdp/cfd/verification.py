"""Flows that are known in closed form, as cases without fitted values: they show what the numerics are worth."""

import math
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import NamedTuple

import numpy as np

from vvdp.cfd.blocks import BLOCK_MESH, Point, arc, block, block_mesh_text
from vvdp.cfd.boundary import NO_GRADIENT, Patch, constraint, pressure_outlet, rotation, wall
from vvdp.cfd.case import Case, Fluid
from vvdp.cfd.convergence import History
from vvdp.cfd.numerics import Phase
from vvdp.cfd.turbulence import LAMINAR, Inflow
from vvdp.cfd.watching import force_monitors, read_axial_force, read_torque

STILL = Inflow(0.0, 0.0, 0.0)
WEDGE = math.radians(1.0)
"""Angle of the slice that stands for an axisymmetric flow [rad]."""
EXACTLY = Phase("exact", "bounded Gauss linear", (0.3, 0.9, 0.5), most=3000, window=20, tolerance=1e-6)
"""Without any numerical viscosity, until nothing moves any more."""


class Pipe(NamedTuple):
    """A round pipe that a developed laminar flow enters: radius, length [m], mean velocity [m/s]."""

    radius: float
    length: float
    velocity: float


class Cylinders(NamedTuple):
    """Two coaxial cylinders, the inner one turning: radii, length [m], speed [rad/s]."""

    inner: float
    outer: float
    length: float
    speed: float


def pipe_force(pipe: Pipe, fluid: Fluid) -> float:
    """Force of a developed laminar flow on the wall of a pipe [N], 8 pi mu v L.

    Source  merritt1967, laminar flow in pipes
    """
    return float(8.0 * np.pi * fluid.viscosity * pipe.velocity * pipe.length)


def cylinders_torque(pair: Cylinders, fluid: Fluid) -> float:
    """Torque of the oil on the turning inner cylinder [N m], -4 pi mu omega l R1^2 R2^2 / (R2^2 - R1^2).

    Source  merritt1967, flow between surfaces that move
    """
    inner, outer = pair.inner**2, pair.outer**2
    return float(-4.0 * np.pi * fluid.viscosity * pair.speed * pair.length * inner * outer / (outer - inner))


def pipe_case(pipe: Pipe, fluid: Fluid, cells: int) -> Case:
    """A slice of a pipe with so many cells along its radius; the force is that on the slice's wall."""
    # Mean of 2 v (1 - (r/R)^2) over each ring of faces: the flow that enters is exact.
    edges = np.linspace(0.0, 1.0, cells + 1) ** 2
    speeds = 2.0 * pipe.velocity * (1.0 - 0.5 * (edges[1:] + edges[:-1]))
    profile = " ".join(f"( 0 0 {float(speed)!r} )" for speed in speeds)
    entering = {"type": "fixedValue", "value": f"nonuniform List<vector> {cells} ( {profile} )"}
    patches = {
        "inlet": Patch("patch", {"U": entering, "p": NO_GRADIENT}),
        "outlet": pressure_outlet(STILL),
        "wall": wall(STILL),
        "front": constraint("wedge"),
        "back": constraint("wedge"),
    }
    largest = 1e6 * pipe_force(pipe, fluid)
    return _exact_case(_pipe_mesh(pipe, cells), patches, fluid, ("wall", read_axial_force, largest))


def _pipe_mesh(pipe: Pipe, cells: int) -> str:
    half = 0.5 * WEDGE
    x, y = pipe.radius * math.cos(half), pipe.radius * math.sin(half)
    vertices = [(*corner, z) for z in (0.0, pipe.length) for corner in ((0.0, 0.0), (x, -y), (x, y))]
    along = max(4, round(0.5 * cells * pipe.length / pipe.radius))
    faces = {
        "inlet": ("patch", [(0, 2, 1, 0)]),
        "outlet": ("patch", [(3, 4, 5, 3)]),
        "wall": ("wall", [(1, 2, 5, 4)]),
        "front": ("wedge", [(0, 1, 4, 3)]),
        "back": ("wedge", [(0, 3, 5, 2)]),
    }
    return block_mesh_text(vertices, [block((0, 1, 2, 0, 3, 4, 5, 3), (cells, 1, along))], faces)


def cylinders_case(pair: Cylinders, fluid: Fluid, cells: int) -> Case:
    """Both cylinders with so many cells across the gap, one along the axis, in four quarters."""
    patches = {
        "inner": wall(STILL, rotation(pair.speed)),
        "outer": wall(STILL),
        "front": constraint("empty"),
        "back": constraint("empty"),
    }
    largest = 1e6 * abs(cylinders_torque(pair, fluid))
    return _exact_case(_cylinders_mesh(pair, cells), patches, fluid, ("inner", read_torque, largest))


def _cylinders_mesh(pair: Cylinders, cells: int) -> str:
    """Corners 0 to 3 lie on the inner cylinder, 4 to 7 on the outer one, 8 to 15 above them."""
    radii, heights = (pair.inner, pair.outer), (0.0, pair.length)
    vertices = [_on_circle(r, quarter, z) for z in heights for r in radii for quarter in range(4)]
    blocks, edges = [], []
    sides: dict[str, list[tuple[int, ...]]] = {"inner": [], "outer": [], "front": [], "back": []}
    for here in range(4):
        there = (here + 1) % 4
        base = (here, here + 4, there + 4, there)
        above = tuple(place + 8 for place in base)
        blocks.append(block((*base, *above), (cells, 4 * cells, 1)))
        sides["back"].append(base)
        sides["front"].append(above)
        for ring, name in ((0, "inner"), (4, "outer")):
            sides[name].append((here + ring, here + ring + 8, there + ring + 8, there + ring))
        for place, (r, z) in enumerate((r, z) for z in heights for r in radii):
            edges.append(arc((here + 4 * place, there + 4 * place), _on_circle(r, here + 0.5, z)))
    kinds = {"inner": "wall", "outer": "wall", "front": "empty", "back": "empty"}
    return block_mesh_text(vertices, blocks, {name: (kinds[name], each) for name, each in sides.items()}, edges)


def _on_circle(radius: float, quarter: float, height: float) -> Point:
    angle = 0.5 * math.pi * quarter
    return radius * math.cos(angle), radius * math.sin(angle), height


def _exact_case(
    mesh: str, patches: Mapping[str, Patch], fluid: Fluid, watched: tuple[str, Callable[[Path], History], float]
) -> Case:
    """A laminar case on a mesh of blocks, judged by what acts on the wall that is `watched`."""
    watched_wall, read, largest = watched
    return Case(
        mesh_files={BLOCK_MESH: mesh},
        mesh_programs=(("blockMesh",),),
        patches=patches,
        monitors=force_monitors((watched_wall,), fluid.density),
        read_history=read,
        fluid=fluid,
        turbulence=LAMINAR,
        start=STILL,
        phases=(EXACTLY,),
        largest=largest,
    )
