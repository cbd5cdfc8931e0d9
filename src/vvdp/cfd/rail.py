"""The inlet rail: what enters by its port leaves by the nozzles, into an open bore or a sleeve without spool."""

import math
from collections.abc import Mapping
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from vvdp.cfd.case import Case, Fluid
from vvdp.cfd.numerics import SECOND_ORDER, UPWIND, Phase
from vvdp.cfd.passage import COLLECTOR, Passage, passage_case
from vvdp.cfd.section import INLET
from vvdp.cfd.snapping import TURN, Cylinder, Refinement, Sphere, turn_domain
from vvdp.cfd.turbulence import STANDARD, Inflow, Turbulence, duct_turbulence
from vvdp.geometry.domains import Domain, open_domain, rail_domain
from vvdp.geometry.shape import ValveShape, perpendicular_area
from vvdp.valve.geometry import nozzle_length
from vvdp.valve.rotary import RotaryValve

GRIDS: Mapping[str, float] = MappingProxyType({"coarse": 8.0, "medium": 8.0 * math.sqrt(2.0), "fine": 16.0})
"""Cells of the background per spool radius: grids of one family, each finer by the square root of two."""
NOZZLE_LEVELS: Mapping[str, int] = MappingProxyType({"nozzles": 2})
"""How often cells at the nozzles' walls are halved; those at other walls once."""


class RailOrder(NamedTuple):
    """The task: the flow [m^3/s] through the rail of a valve's shape, `grid` cells per spool radius."""

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
    levels = {INLET: 1, **dict.fromkeys(domain.mesh.names, 1), **NOZZLE_LEVELS}
    levels |= dict.fromkeys(outlets(order.valve), 3)
    return passage_case(_passage(order, domain, levels))


def turned_sleeve(order: RailOrder) -> Domain:
    """The oil of the sleeve without its spool as it is meshed."""
    return turn_domain(open_domain(order.shape, order.valve))


def sleeve_case(order: RailOrder, domain: Domain) -> Case:
    """The case of an order on the domain `turned_sleeve`: the jets enter the bore, which both collectors drain.

    Source  wang2017, section 2.4: how the drop of rail and nozzles is measured
    """
    levels = {**dict.fromkeys(domain.mesh.names, 1), **NOZZLE_LEVELS, COLLECTOR: 0}
    passage = _passage(order, domain, levels)
    within = (*passage.fine.within, *near_mouths(order.valve))
    return passage_case(passage._replace(fine=passage.fine._replace(within=within)))


def port_turbulence(flow: float, shape: ValveShape) -> Inflow:
    """Turbulence of the flow that enters by the port of the rail."""
    diameter = shape.rail_port_diameter
    return duct_turbulence(flow / (0.25 * math.pi * diameter**2), diameter)


def near_nozzles(radius: float) -> Cylinder:
    """Within it lie the nozzles up to their roots."""
    return Cylinder(1.73 * radius, -0.32 * radius, 0.32 * radius, 2)


def near_mouths(valve: RotaryValve) -> tuple[Sphere, ...]:
    """Refined spheres, each around a mouth, for mouths that are no patches: as fine as patches, so that mouths keep
    their area."""
    angles = TURN + 2.0 * math.pi / valve.sections * np.arange(round(valve.sections))
    reach = 0.55 * nozzle_length(valve)
    radius = valve.spool_radius
    return tuple(Sphere((radius * math.cos(a), radius * math.sin(a), 0.0), reach, 3) for a in angles.tolist())


def _passage(order: RailOrder, domain: Domain, levels: Mapping[str, int]) -> Passage:
    radius = order.valve.spool_radius
    return Passage(
        domain=domain,
        fluid=order.fluid,
        flow=order.flow,
        entering=port_turbulence(order.flow, order.shape),
        fine=Refinement(cell=radius / order.grid, patches=levels, edges=2, within=(near_nozzles(radius),)),
        jet=order.flow / perpendicular_area(order.shape, order.valve),
        turbulence=order.turbulence,
        phases=order.phases,
        radius=radius,
    )
