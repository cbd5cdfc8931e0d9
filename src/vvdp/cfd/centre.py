"""The centre section: jets from nozzle stubs meet the pockets of the spool and leave by its windows."""

import math
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np

from vvdp.base.arrays import Array
from vvdp.cfd.balance import torque_monitors
from vvdp.cfd.boundary import flow_inlet, pressure_outlet, rotation, slip, wall
from vvdp.cfd.case import Case, Fluid
from vvdp.cfd.convergence import History
from vvdp.cfd.monitor import Monitor, read_monitor
from vvdp.cfd.numerics import SECOND_ORDER, UPWIND, Phase, patch_mean
from vvdp.cfd.passage import IMPOSSIBLE, OUTLET
from vvdp.cfd.rotor import ZONE_PROGRAM, frame_files, rotor_patches, zone_files
from vvdp.cfd.snapping import ORDERING, PROGRAMS, Cylinder, Refinement, meshing_files, turn_domain
from vvdp.cfd.turbulence import STANDARD, Inflow, Turbulence, duct_turbulence
from vvdp.cfd.watching import Monitors, align, flow_monitors, flow_name
from vvdp.geometry.domains import STUB, Domain, centre_domain
from vvdp.geometry.shape import ValveShape, perpendicular_area
from vvdp.valve.geometry import nozzle_length
from vvdp.valve.rotary import RotaryValve


class CentreOrder(NamedTuple):
    """The task: the flow [m^3/s] through the centre section of a valve's shape.

    `angle`, `position` and `speed` are those of the spool [rad, m, rad/s], `grid` the cells per spool radius, `stub`
    the length of the nozzles [spool radii].
    """

    valve: RotaryValve
    shape: ValveShape
    fluid: Fluid
    flow: float
    angle: float
    position: float
    grid: float
    turbulence: Turbulence = STANDARD
    phases: tuple[Phase, ...] = (UPWIND, SECOND_ORDER)
    speed: float = 0.0
    stub: float = STUB


def scale_radially(order: CentreOrder, diameter: float) -> CentreOrder:
    """The same section with a spool of another diameter [m], every length along the spool as before.

    Pockets, nozzles and the arm of the jets grow with the diameter, and the helix angle shrinks.

    Source  wang2017, section 2.4.2
    """
    valve, shape = order.valve, order.shape
    factor = 0.5 * diameter / valve.spool_radius
    across = {name: factor * getattr(valve, name) for name in ("spool_radius", "inlet_radius", "outlet_radius")}
    wider = replace(valve, nozzle_area=factor * valve.nozzle_area, **across)
    lengths = {name: factor * getattr(shape, name) for name in ("hub_radius", "nozzle_arm", "rail_radius")}
    made = replace(shape, **lengths)
    return order._replace(valve=wider, shape=made)


def turned_centre(order: CentreOrder) -> Domain:
    """The oil of the centre section as it is meshed. Raises ParameterError where the nozzles are closed."""
    return turn_domain(centre_domain(order.shape, order.valve, order.angle, order.position, stub=order.stub))


def inlets(valve: RotaryValve) -> tuple[str, ...]:
    """The patches at the ends of the stubs."""
    return tuple(f"inlet{number + 1}" for number in range(round(valve.sections)))


def stub_inflow(order: CentreOrder) -> Inflow:
    """Turbulence of the flow in a stub."""
    area = perpendicular_area(order.shape, order.valve)
    return duct_turbulence(order.flow / area, math.sqrt(area / round(order.valve.sections)))


def centre_case(order: CentreOrder, domain: Domain) -> Case:
    """The case of an order on its domain, `turned_centre`; each stub has its share of the flow, and walls that slip.

    Judged by the total pressure that the jets lose: static pressure at the stubs' ends and their dynamic pressure, both
    on the area that a stub has in the mesh. Of a static drop alone, a stub 2 % too small would make a tenth.

    Source  ours, docs/models/cfd.md
    """
    valve, shape = order.valve, order.shape
    sections, jet, entering = round(valve.sections), order.flow / perpendicular_area(shape, valve), stub_inflow(order)
    ends, turning = inlets(valve), rotor_patches(domain)
    patches = {
        **dict.fromkeys(ends, flow_inlet(order.flow / sections, entering)),
        OUTLET: pressure_outlet(entering),
        "nozzles": slip(),
        "sleeve": wall(entering),
        **dict.fromkeys(turning, wall(entering, rotation(order.speed))),
    }
    kinds = {name: patch.kind for name, patch in patches.items()}
    openings, spins = (*ends, OUTLET), order.speed != 0.0
    surface = meshing_files(domain, kinds, centre_refinement(order, domain))
    return Case(
        mesh_files={**surface, **(zone_files(valve.spool_radius) if spins else {})},
        mesh_programs=(*PROGRAMS, ORDERING, *([ZONE_PROGRAM] if spins else [])),
        patches=patches,
        monitors={
            **flow_monitors(openings),
            **end_monitors(ends),
            **torque_monitors(turning, ("sleeve",), order.fluid.density),
        },
        read_history=partial(read_total_drop, ends, (OUTLET,), order.fluid.density),
        fluid=order.fluid,
        turbulence=order.turbulence,
        start=entering,
        phases=order.phases,
        largest=IMPOSSIBLE * 0.5 * order.fluid.density * jet**2,
        further_files=frame_files(order.speed, (*openings, "nozzles", "sleeve")) if spins else {},
    )


def _pressure_name(patch: str) -> str:
    return f"pressure-{patch}"


def end_monitors(ends: tuple[str, ...]) -> Monitors:
    """Function objects for the mean pressure at each stub's end."""
    return {_pressure_name(end): patch_mean(end, "areaAverage", "p") for end in ends}


def read_total_drop(ends: tuple[str, ...], others: tuple[str, ...], density: float, case: Path) -> History:
    """The mean over the stubs of static and dynamic pressure at their ends [Pa]; flows by these and `others`."""
    count = len(ends)
    pressures = [read_monitor(case, _pressure_name(end)) for end in ends]
    flows = [read_monitor(case, flow_name(patch)) for patch in (*ends, *others)]
    tables = align([*pressures, *flows])
    total = [_total(*pair) for pair in zip(tables[:count], tables[count : 2 * count], strict=True)]
    values = {patch: flow.values[:, 0] for patch, flow in zip((*ends, *others), tables[count:], strict=True)}
    return History(tables[0].iterations, density * np.mean(total, axis=0), values)


def _total(pressure: Monitor, flow: Monitor) -> Array:
    """Static and dynamic pressure over the density [m^2/s^2]."""
    speed = flow.values[:, 0] / pressure.area
    return pressure.values[:, 0] + 0.5 * speed**2


def centre_refinement(order: CentreOrder, domain: Domain) -> Refinement:
    """Cells are finest in the stubs, whose area sets the jets' speed, and fine where the jets meet the pockets."""
    radius, half = order.valve.spool_radius, 0.5 * nozzle_length(order.valve)
    reach = half + 0.08 * radius
    levels = {
        **dict.fromkeys(domain.mesh.names, 1),
        "nozzles": 3,
        "windows": 2,
        **dict.fromkeys(inlets(order.valve), 3),
    }
    within = Cylinder(1.05 * radius, -reach, reach, 2)
    return Refinement(cell=radius / order.grid, patches=levels, edges=2, within=(within,))
