"""A PWM period of the centre section: the spool turns, and its barriers close and open the nozzles as they pass."""

import math
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np

from vvdp.base.arrays import Array
from vvdp.cfd.balance import torque_monitors
from vvdp.cfd.boundary import MOVING, meeting, pressure_inlet, pressure_outlet, rotation, slip, wall
from vvdp.cfd.case import Case
from vvdp.cfd.centre import CentreOrder, centre_refinement, end_monitors, inlets, read_total_drop, stub_inflow
from vvdp.cfd.numerics import INTERVAL, PASSING
from vvdp.cfd.passage import IMPOSSIBLE, OUTLET
from vvdp.cfd.rotor import motion_files, rotor_patches
from vvdp.cfd.section import FRAMES, Plane, frame_function
from vvdp.cfd.series import MIDDLE, NamedCase, case_folder, solve_series
from vvdp.cfd.sliding import MEETING_PROGRAMS, Side, meeting_files
from vvdp.cfd.snapping import ORDERING, PROGRAMS, meshing_files, turn_domain
from vvdp.cfd.solve import Hear, Solved
from vvdp.cfd.watching import flow_monitors, read_torque
from vvdp.geometry.domains import Domain, sliding_domain
from vvdp.geometry.shape import perpendicular_area
from vvdp.studies.engine import Engine
from vvdp.valve.branch import turbulent_drops
from vvdp.valve.geometry import port_openings

STEPS = 240
"""Steps of a period: half a degree each where there are three nozzles."""
PICTURES = 16
"""Pictures of the flow in a period."""
MOUTHS = Side("mouths", "mouths-open", "lands")
RIM = Side("rim", "rim-open", "sleeve")


class PeriodOrder(NamedTuple):
    """A period of a centre section whose spool turns, under a total drop [Pa] that is held.

    The flow of `centre` is about the one to come: its turbulence enters. Its angle is not used.
    """

    centre: CentreOrder
    drop: float

    @property
    def begin(self) -> float:
        """Angle of the spool at which the period begins, its nozzles closed [rad]."""
        return -math.pi / round(self.centre.valve.sections)

    @property
    def step(self) -> float:
        """Time of a step [s]."""
        return 2.0 * abs(self.begin) / (STEPS * self.centre.speed)


class PeriodRun(NamedTuple):
    """A period that was computed, step by step.

    angle, opening      of the spool [rad]; open fraction of the nozzles by the formula [1]
    entering, leaving   flow in and out [m^3/s]
    torque              on the spool [N m]; until the nozzles open, as at the end of the period
    """

    order: PeriodOrder
    solved: Solved
    angle: Array
    opening: Array
    entering: Array
    leaving: Array
    torque: Array


def law_drop(order: CentreOrder) -> float:
    """Total drop of open nozzles at the flow of an order by the system's laws [Pa]: static, and that of the jets."""
    jet = order.flow / perpendicular_area(order.shape, order.valve)
    static = turbulent_drops(order.flow, 1.0, order.fluid.density, order.valve).centre_section
    return static + 0.5 * order.fluid.density * jet**2


def turned_period(order: PeriodOrder) -> Domain:
    """The oil as it is meshed. Raises ParameterError where the nozzles hardly close."""
    centre = order.centre
    return turn_domain(sliding_domain(centre.shape, centre.valve, centre.position))


def period_case(order: PeriodOrder, domain: Domain) -> Case:
    """The case of an order on its domain, `turned_period`, from rest; judged by the total drop, which is held.

    The mesh of the spool's oil turns within the bore. It sees the stubs as far as mouths and pockets cover each other;
    what is left of the mouths is a wall that turns, what is left of the pockets a wall at rest.

    Source  ours, docs/models/cfd.md
    """
    centre, entering, density = order.centre, stub_inflow(order.centre), order.centre.fluid.density
    ends, turning = inlets(centre.valve), rotor_patches(domain)
    patches = {
        **dict.fromkeys(ends, pressure_inlet(order.drop / density, entering)),
        OUTLET: pressure_outlet(entering),
        "nozzles": slip(),
        **dict.fromkeys(turning, wall(entering, MOVING)),
        MOUTHS.open: meeting(entering),
        MOUTHS.closed: wall(entering, rotation(centre.speed)),
        RIM.open: meeting(entering),
        RIM.closed: wall(entering),
    }
    kinds = {name: patches[name].kind if name in patches else "patch" for name in domain.mesh.names}
    fine = centre_refinement(centre, domain)
    fine = fine._replace(patches={**fine.patches, MOUTHS.patch: fine.patches["nozzles"]})
    # Facets of the rim do not turn quite along themselves: what they sweep is counted with the flows.
    return Case(
        mesh_files={**meshing_files(domain, kinds, fine), **meeting_files(MOUTHS, RIM)},
        mesh_programs=(*PROGRAMS, *MEETING_PROGRAMS, ORDERING),
        patches=patches,
        monitors={
            **flow_monitors((*ends, OUTLET, RIM.closed)),
            **end_monitors(ends),
            **torque_monitors((*turning, MOUTHS.closed), (RIM.closed,), density),
            FRAMES: frame_function(MIDDLE, _middle(order), STEPS // PICTURES),
        },
        read_history=partial(read_total_drop, ends, (OUTLET, RIM.closed), density),
        fluid=centre.fluid,
        turbulence=centre.turbulence,
        start=entering,
        phases=(PASSING._replace(most=STEPS, window=INTERVAL),),
        largest=IMPOSSIBLE * order.drop,
        further_files=motion_files(centre.speed),
        step=order.step,
    )


def _middle(order: PeriodOrder) -> Plane:
    """The plane of the nozzles; a hair off it, where their corners lie."""
    return Plane((0.0, 0.0, 1e-3 * order.centre.valve.spool_radius), (0.0, 0.0, 1.0))


def run_period(order: PeriodOrder, directory: Path, engine: Engine, hear: Hear) -> PeriodRun:
    """Computes a period, or goes on with it; see `solve`. Raises ParameterError where the nozzles hardly close."""
    case = NamedCase("", period_case(order, turned_period(order)))
    (solved,) = solve_series([case], _middle(order), directory, engine, hear)
    history, ends = solved.history, inlets(order.centre.valve)
    angle = order.begin + order.step * order.centre.speed * history.iterations
    torque = read_torque(case_folder(directory, 0)).value
    # The oil on the spool starts from rest; were it the second period, it would be as at the end of the first.
    opening = np.array([port_openings(each, order.centre.position, order.centre.valve).load for each in angle.tolist()])
    opened = opening.cumsum() > 0.0
    return PeriodRun(
        order=order,
        solved=solved,
        angle=angle,
        opening=opening,
        entering=-np.sum([history.flows[end] for end in ends], axis=0),
        leaving=history.flows[OUTLET] + history.flows[RIM.closed],
        torque=np.where(opened, torque, torque[-1]),
    )
