"""Oil that passes a part of the valve: in by its inlet, out by its outlets at pressure 0, along walls that may turn."""

from collections.abc import Mapping
from functools import partial
from typing import NamedTuple

from vvdp.cfd.balance import torque_monitors
from vvdp.cfd.boundary import constraint, flow_inlet, pressure_outlet, rotation, wall
from vvdp.cfd.case import Case, Fluid
from vvdp.cfd.numerics import Phase, patch_mean
from vvdp.cfd.rotor import ZONE_PROGRAM, frame_files, rotor_patches, zone_files
from vvdp.cfd.section import INLET
from vvdp.cfd.sliding import PARTING_PROGRAMS, RING_PATCHES, parting_files
from vvdp.cfd.snapping import ORDERING, PROGRAMS, Refinement, meshing_files
from vvdp.cfd.turbulence import Inflow, Turbulence
from vvdp.cfd.watching import drop_monitors, read_drop
from vvdp.geometry.domains import Domain

COLLECTOR, OUTLET = "collector", "outlet"
BEHIND = "pressure-collector"
"""Function object of the mean pressure on the collector's walls: what the turbine alone leaves."""
IMPOSSIBLE = 1e3
"""Dynamic pressures of the jets: a drop beyond them is a run that diverges."""


class Passage(NamedTuple):
    """A flow [m^3/s] through a domain, from its patch inlet to its patches outlet...

    entering  turbulence at the inlet
    fine      how the domain is meshed
    jet       speed of the fastest jets [m/s]
    radius    of what turns [m], where a patch does, and its speed [rad/s]
    """

    domain: Domain
    fluid: Fluid
    flow: float
    entering: Inflow
    fine: Refinement
    jet: float
    turbulence: Turbulence
    phases: tuple[Phase, ...]
    radius: float
    speed: float = 0.0


def passage_case(passage: Passage) -> Case:
    """The case of a passage, judged by the static pressure at its inlet.

    Where walls turn, the oil within their radius is solved in the frame that turns with them, as if they stood at this
    one angle.

    Source  ours, docs/models/cfd.md
    """
    domain, entering, density = passage.domain, passage.entering, passage.fluid.density
    names, turning = domain.mesh.names, rotor_patches(domain)
    openings = (INLET, *(name for name in names if name.startswith(OUTLET)))
    walls = tuple(name for name in names if name not in (*openings, *turning))
    patches = {
        INLET: flow_inlet(passage.flow, entering),
        **dict.fromkeys(walls, wall(entering)),
        **dict.fromkeys(openings[1:], pressure_outlet(entering)),
        **dict.fromkeys(turning, wall(entering, rotation(passage.speed))),
    }
    kinds = {name: patch.kind for name, patch in patches.items()}
    files, programs, sides = _zone(passage) if turning else ({}, (ORDERING,), ())
    return Case(
        mesh_files={**meshing_files(domain, kinds, passage.fine), **files},
        mesh_programs=(*PROGRAMS, *programs),
        patches={**patches, **dict.fromkeys(sides, constraint("cyclicAMI"))},
        monitors={
            **drop_monitors(INLET, openings),
            **({BEHIND: patch_mean(COLLECTOR, "areaAverage", "p")} if COLLECTOR in walls else {}),
            **(torque_monitors(turning, walls, density) if turning else {}),
        },
        read_history=partial(read_drop, openings, density),
        fluid=passage.fluid,
        turbulence=passage.turbulence,
        start=entering,
        phases=passage.phases,
        largest=IMPOSSIBLE * 0.5 * density * passage.jet**2,
        further_files=frame_files(passage.speed, (*openings, *walls, *sides)) if turning else {},
    )


def _zone(passage: Passage) -> tuple[Mapping[str, str], tuple[tuple[str, ...], ...], tuple[str, ...]]:
    """Zone of cells that turn: files and programs that make it, and the patches at its edge where the mesh is
    parted."""
    if passage.fine.ring:
        return parting_files(), (*PARTING_PROGRAMS, ORDERING), RING_PATCHES
    return zone_files(passage.radius), (ORDERING, ZONE_PROGRAM), ()
