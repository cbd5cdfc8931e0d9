"""The outlet turbine, and the whole way of the oil to the load: what turns is solved in the frame of the spool."""

import math
from typing import NamedTuple

from vvdp.cfd.boundary import MOVING
from vvdp.cfd.case import Case, Fluid
from vvdp.cfd.numerics import SECOND_ORDER, UPWIND, Phase
from vvdp.cfd.passage import COLLECTOR, Passage, passage_case
from vvdp.cfd.rail import NOZZLE_LEVELS, near_mouths, near_nozzles, port_turbulence
from vvdp.cfd.rotor import ROTOR, motion_files
from vvdp.cfd.snapping import Cylinder, Refinement, Ring, Sphere, turn_domain
from vvdp.cfd.turbulence import STANDARD, Turbulence, duct_turbulence
from vvdp.geometry.domains import Domain, turbine_domain, valve_domain
from vvdp.geometry.shape import ValveShape, perpendicular_area
from vvdp.valve.rotary import RotaryValve


class TurbineOrder(NamedTuple):
    """The task: a flow [m^3/s] through outlet turbine or whole valve of a shape, its spool turning [rad/s].

    `position` is the axial position of the spool [m], `grid` the cells per spool radius.
    """

    valve: RotaryValve
    shape: ValveShape
    fluid: Fluid
    flow: float
    speed: float
    position: float
    grid: float
    turbulence: Turbulence = STANDARD
    phases: tuple[Phase, ...] = (UPWIND, SECOND_ORDER)


def turned_turbine(order: TurbineOrder) -> Domain:
    """The oil of the outlet turbine as it is meshed, the spool at the angle 0."""
    return turn_domain(turbine_domain(order.shape, order.valve, 0.0, order.position))


def turned_valve(order: TurbineOrder) -> Domain:
    """The oil of the whole way to the load as it is meshed, the spool at the angle 0, where its nozzles are open."""
    return turn_domain(valve_domain(order.shape, order.valve, 0.0, order.position))


def turbine_case(order: TurbineOrder, domain: Domain, *, parted: bool = False) -> Case:
    """The case of an order on its domain, `turned_turbine`: the oil enters the chamber along the axis.

    The mesh may be `parted` by a cylinder through the collector, as `sliding_case` needs it.

    Source  ours, docs/models/cfd.md
    """
    shape = order.shape
    width = shape.chamber_outer_radius - shape.chamber_inner_radius
    annulus = math.pi * (shape.chamber_outer_radius**2 - shape.chamber_inner_radius**2)
    levels = {**dict.fromkeys(domain.mesh.names, 1), "channels": 2}
    fine = Refinement(
        cell=order.valve.spool_radius / order.grid, patches=levels, edges=2, within=(_near_channels(order, domain),)
    )
    if parted:
        # Through the middle of the torus, which it meets at right angles: both rims are round.
        fine = fine._replace(ring=Ring(Cylinder(shape.collector_radius, *_beyond(domain), 1), ROTOR))
    entering = duct_turbulence(order.flow / annulus, 2.0 * width)
    return passage_case(_passage(order, domain, fine)._replace(entering=entering))


def _beyond(domain: Domain) -> tuple[float, float]:
    """Heights below and above all of a domain [m]."""
    heights = domain.mesh.vertices[:, 2]
    low, high = float(heights.min()), float(heights.max())
    return 2.0 * low - high, 2.0 * high - low


def sliding_case(frozen: Case, speed: float, phase: Phase, step: float) -> Case:
    """A parted case in which what turns does turn [rad/s], in steps of time [s]; it begins with the flow of `frozen`.

    Source  ours, docs/models/cfd.md
    """
    moving = {
        name: patch._replace(conditions={**patch.conditions, "U": MOVING})
        for name, patch in frozen.patches.items()
        if patch.conditions["U"]["type"] == "rotatingWallVelocity"
    }
    patches = {**frozen.patches, **moving}
    return frozen._replace(patches=patches, phases=(phase,), further_files=motion_files(speed), step=step)


def valve_case(order: TurbineOrder, domain: Domain) -> Case:
    """The case of an order on the domain `turned_valve`, from the port of the rail to that of the collector.

    Source  ours, docs/models/cfd.md
    """
    radius = order.valve.spool_radius
    levels = {**dict.fromkeys(domain.mesh.names, 1), **NOZZLE_LEVELS, "channels": 2, "windows": 2, COLLECTOR: 0}
    within: tuple[Cylinder | Sphere, ...] = (
        near_nozzles(radius),
        _near_channels(order, domain),
        *near_mouths(order.valve),
    )
    return passage_case(
        _passage(order, domain, Refinement(cell=radius / order.grid, patches=levels, edges=2, within=within))
    )


def _passage(order: TurbineOrder, domain: Domain, fine: Refinement) -> Passage:
    valve, narrowest = order.valve, min(order.valve.outlet_area, perpendicular_area(order.shape, order.valve))
    return Passage(
        domain=domain,
        fluid=order.fluid,
        flow=order.flow,
        entering=port_turbulence(order.flow, order.shape),
        fine=fine,
        jet=order.flow / narrowest,
        turbulence=order.turbulence,
        phases=order.phases,
        radius=valve.spool_radius,
        speed=order.speed,
    )


def _near_channels(order: TurbineOrder, domain: Domain) -> Cylinder:
    """Within it lie the channels and where their jets leave."""
    radius, heights = order.valve.spool_radius, domain.mesh.of("channels")[:, :, 2]
    margin = 0.08 * radius
    return Cylinder(1.12 * radius, float(heights.min()) - margin, float(heights.max()) + margin, 2)
