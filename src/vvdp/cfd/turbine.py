"""The outlet turbine: the oil leaves the turning spool by its channels into the collector and the port."""

import math
from collections.abc import Mapping
from functools import partial
from typing import NamedTuple

from vvdp.cfd.boundary import flow_inlet, pressure_outlet, rotation, wall
from vvdp.cfd.case import Case, Fluid
from vvdp.cfd.dictionary import Entry, dictionary_text
from vvdp.cfd.numerics import SECOND_ORDER, UPWIND, Phase, patch_mean
from vvdp.cfd.snapping import PROGRAMS, Cylinder, Refinement, meshing_files, turn_domain
from vvdp.cfd.turbulence import STANDARD, Turbulence, duct_turbulence
from vvdp.cfd.watching import drop_monitors, force_monitors, read_drop
from vvdp.geometry.domains import TURNING, Domain, turbine_domain
from vvdp.geometry.shape import ValveShape
from vvdp.valve.rotary import RotaryValve

ROTOR = "rotor"
"""The zone of cells that is solved in the frame of the spool."""
INLET, OUTLET, COLLECTOR = "inlet", "outlet", "collector"
BEHIND = "pressure-collector"
"""Function object of the mean pressure on the collector's walls: what the turbine alone leaves."""
IMPOSSIBLE = 1e3
"""Dynamic pressures of the jets: a drop beyond them is a run that diverges."""


class TurbineOrder(NamedTuple):
    """What is to be computed: the outlet turbine of a valve's shape at a flow [m^3/s], its spool turning [rad/s].

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


def turbine_case(order: TurbineOrder, domain: Domain) -> Case:
    """The case of an order on its domain, `turned_turbine`.

    Oil within the spool's radius is solved in the frame that turns with it, as if the spool stood at this one angle.

    Source  ours, docs/models/cfd.md
    """
    shape, speed = order.shape, order.speed
    width = shape.chamber_outer_radius - shape.chamber_inner_radius
    annulus = math.pi * (shape.chamber_outer_radius**2 - shape.chamber_inner_radius**2)
    entering = duct_turbulence(order.flow / annulus, 2.0 * width)
    patches = {
        INLET: flow_inlet(order.flow, entering),
        OUTLET: pressure_outlet(entering),
        COLLECTOR: wall(entering),
        **{name: wall(entering, rotation(speed)) for name in rotor_patches(domain)},
    }
    openings = (INLET, OUTLET)
    kinds = {name: patch.kind for name, patch in patches.items()}
    jet = order.flow / order.valve.outlet_area
    return Case(
        mesh_files={**meshing_files(domain, kinds, _refinement(order, domain)), **_zone_files(order)},
        mesh_programs=(*PROGRAMS, ("topoSet",)),
        patches=patches,
        monitors={
            **drop_monitors(INLET, openings),
            BEHIND: patch_mean(COLLECTOR, "areaAverage", "p"),
            **force_monitors(rotor_patches(domain), order.fluid.density),
        },
        read_history=partial(read_drop, openings, order.fluid.density),
        fluid=order.fluid,
        turbulence=order.turbulence,
        start=entering,
        phases=order.phases,
        largest=IMPOSSIBLE * 0.5 * order.fluid.density * jet**2,
        further_files=_frame_files(speed),
    )


def rotor_patches(domain: Domain) -> tuple[str, ...]:
    """The patches of a domain that turn with the spool."""
    return tuple(name for name in domain.mesh.names if name in TURNING)


def _refinement(order: TurbineOrder, domain: Domain) -> Refinement:
    """Cells are finest in the channels and where their jets leave."""
    radius, heights = order.valve.spool_radius, domain.mesh.of("channels")[:, :, 2]
    margin = 0.08 * radius
    near = Cylinder(1.12 * radius, float(heights.min()) - margin, float(heights.max()) + margin, 2)
    levels = {**dict.fromkeys(domain.mesh.names, 1), "channels": 2}
    return Refinement(cell=radius / order.grid, patches=levels, edges=2, within=near)


def _zone_files(order: TurbineOrder) -> dict[str, str]:
    """What makes a zone of the cells within the spool's radius."""
    far = 100.0 * order.valve.spool_radius
    cells = f"{ROTOR}Cells"
    within: Mapping[str, Entry] = {
        "source": "cylinderToCell",
        "p1": (0, 0, -far),
        "p2": (0, 0, far),
        "radius": order.valve.spool_radius,
    }
    actions: tuple[Mapping[str, Entry], ...] = (
        {"name": cells, "type": "cellSet", "action": "new", **within},
        {"name": ROTOR, "type": "cellZoneSet", "action": "new", "source": "setToCellZone", "set": cells},
    )
    return {"system/topoSetDict": dictionary_text({"actions": actions}, "topoSetDict")}


def _frame_files(speed: float) -> dict[str, str]:
    """The frame of the rotor's zone; a patch that is not named here is taken to turn with it."""
    frame: Mapping[str, Entry] = {
        "cellZone": ROTOR,
        "active": True,
        "nonRotatingPatches": (INLET, OUTLET, COLLECTOR),
        "origin": (0, 0, 0),
        "axis": (0, 0, 1),
        "omega": speed,
    }
    return {"constant/MRFProperties": dictionary_text({ROTOR: frame}, "MRFProperties")}
