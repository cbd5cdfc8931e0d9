"""The inlet rail with its nozzles: a flow enters by the port and leaves by the mouths into the open bore."""

import math
from collections.abc import Mapping
from functools import partial
from types import MappingProxyType
from typing import NamedTuple

from vvdp.cfd.boundary import flow_inlet, pressure_outlet, wall
from vvdp.cfd.case import Case, Fluid
from vvdp.cfd.numerics import SECOND_ORDER, UPWIND, Phase
from vvdp.cfd.snapping import PROGRAMS, Cylinder, Refinement, meshing_files, turn_domain
from vvdp.cfd.turbulence import STANDARD, Turbulence, duct_turbulence
from vvdp.cfd.watching import drop_monitors, read_drop
from vvdp.geometry.domains import Domain, rail_domain
from vvdp.geometry.shape import ValveShape, perpendicular_area
from vvdp.valve.rotary import RotaryValve

GRIDS: Mapping[str, float] = MappingProxyType({"coarse": 8.0, "medium": 8.0 * math.sqrt(2.0), "fine": 16.0})
"""Cells of the background per spool radius: grids of one family, each finer by the square root of two."""
IMPOSSIBLE = 1e3
"""Dynamic pressures of the jets: a drop beyond them is a run that diverges."""
INLET = "inlet"


class RailOrder(NamedTuple):
    """What is to be computed: the rail of a valve's shape at a flow [m^3/s], `grid` cells per spool radius."""

    valve: RotaryValve
    shape: ValveShape
    fluid: Fluid
    flow: float
    grid: float
    turbulence: Turbulence = STANDARD
    phases: tuple[Phase, ...] = (UPWIND, SECOND_ORDER)


def three_grids(finest: float) -> dict[str, float]:
    """Three grids of the family by name, the coarsest first [cells per spool radius]."""
    family = (0.5 * finest, math.sqrt(0.5) * finest, finest)
    known = {f"{cells:.6g}": (name, cells) for name, cells in GRIDS.items()}
    return dict(known.get(f"{cells:.6g}", (f"R/{cells:.3g}", cells)) for cells in family)


def outlets(valve: RotaryValve) -> tuple[str, ...]:
    """The patches of the mouths, in the order of the nozzles."""
    return tuple(f"outlet{number + 1}" for number in range(round(valve.sections)))


def turned_rail(order: RailOrder) -> Domain:
    """The oil of the rail as it is meshed."""
    return turn_domain(rail_domain(order.shape, order.valve))


def rail_case(order: RailOrder, domain: Domain) -> Case:
    """The case of an order on its domain, `turned_rail`.

    The mesh is finest at the mouths, an eighth of the background's cells, and a quarter of them in the nozzles.

    Source  ours, docs/models/cfd.md
    """
    valve, shape = order.valve, order.shape
    mouths, diameter = outlets(valve), shape.rail_port_diameter
    jet = order.flow / perpendicular_area(shape, valve)
    entering = duct_turbulence(order.flow / (0.25 * math.pi * diameter**2), diameter)
    patches = {
        INLET: flow_inlet(order.flow, entering),
        "rail": wall(entering),
        "nozzles": wall(entering),
        **{mouth: pressure_outlet(entering) for mouth in mouths},
    }
    kinds = {name: patch.kind for name, patch in patches.items()}
    openings = (INLET, *mouths)
    return Case(
        mesh_files=meshing_files(domain, kinds, _refinement(order)),
        mesh_programs=PROGRAMS,
        patches=patches,
        monitors=drop_monitors(INLET, openings),
        read_history=partial(read_drop, openings, order.fluid.density),
        fluid=order.fluid,
        turbulence=order.turbulence,
        start=entering,
        phases=order.phases,
        largest=IMPOSSIBLE * 0.5 * order.fluid.density * jet**2,
    )


def _refinement(order: RailOrder) -> Refinement:
    radius = order.valve.spool_radius
    levels = {INLET: 1, "rail": 1, "nozzles": 2, **dict.fromkeys(outlets(order.valve), 3)}
    # Within it lie the nozzles up to their roots.
    near = Cylinder(1.73 * radius, -0.32 * radius, 0.32 * radius, 2)
    return Refinement(cell=radius / order.grid, patches=levels, edges=2, within=near)
