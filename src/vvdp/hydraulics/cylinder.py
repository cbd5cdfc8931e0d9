"""Double-acting cylinder: two chambers, a moving mass with friction, and an elastic stop at each end."""

from typing import Annotated, NamedTuple

import numpy as np

from vvdp.base.books import Stored
from vvdp.base.errors import ParameterError
from vvdp.base.kinds import (
    Area,
    Force,
    Kind,
    Length,
    Mass,
    Position,
    Power,
    Pressure,
    Stiffness,
    Velocity,
    ViscousFriction,
)
from vvdp.base.params import Params
from vvdp.base.select import maximum
from vvdp.fluid.mixture import FluidState
from vvdp.fluid.oil import Oil
from vvdp.hydraulics.volume import Vessel, pressure_rate, stored

IMPACT_DAMPING = Kind("impact damping", "s/m", 0.0, 1e4, "1 s/m")
ImpactDamping = Annotated[float, IMPACT_DAMPING]


class Cylinder(Params):
    """A cylinder and what moves with its rod; the position counts from the end where chamber A is smallest.

    A chamber is its vessel, the dead volume with hose, and what the piston has swept. `coulomb_velocity` is where the
    dry friction has 71 % of its full force. A stop gives `stop_stiffness` times the depth, more by `stop_damping`
    times the speed going in and less coming out.
    """

    area_a: Area
    area_b: Area
    stroke: Length
    moving_mass: Mass
    viscous_friction: ViscousFriction
    coulomb_friction: Force
    coulomb_velocity: Velocity
    stop_stiffness: Stiffness
    stop_damping: ImpactDamping
    chamber_a: Vessel
    chamber_b: Vessel

    def check(self) -> None:
        for name in ("area_a", "area_b", "stroke", "moving_mass", "coulomb_velocity", "stop_stiffness"):
            if getattr(self, name) <= 0.0:
                raise ParameterError(f"Cylinder.{name}: {getattr(self, name):g}; expected a value above zero")
        if self.coulomb_friction < 0.0:
            raise ParameterError(f"Cylinder.coulomb_friction: {self.coulomb_friction:g} N would drive the piston")


class CylinderState(NamedTuple):
    """Piston position and velocity, absolute pressures in both chambers."""

    position: Position
    velocity: Velocity
    pressure_a: Pressure
    pressure_b: Pressure


class StopForce(NamedTuple):
    """What the end stops do to the piston: `force` in the direction of the position; `loss`, power turned to heat."""

    force: Force
    loss: Power


def cylinder_rate(
    state: CylinderState,
    flow_a: float,
    flow_b: float,
    load_force: float,
    fluid_a: FluidState,
    fluid_b: FluidState,
    cylinder: Cylinder,
    reference_pressure: float,
) -> CylinderState:
    """Rates of a cylinder: velocity [m/s], acceleration [m/s^2] and pressures [Pa/s].

    m v' = (P_a - ref) A_a - (P_b - ref) A_b - friction + stops + F; pressures as in a vessel with moving wall.

    flow_a, flow_b      into the chambers [tank volumes, m^3/s]
    load_force          F, in the direction of the position [N]
    fluid_a, fluid_b    oil in the chambers
    reference_pressure  outside, absolute [Pa]

    Source  wang2017, eq. 6.1, 6.3; conserving mass, friction and stops: ours, docs/models/components.md
    """
    x, v, P_a, P_b = state
    A_a, A_b = cylinder.area_a, cylinder.area_b
    pressure_force = (P_a - reference_pressure) * A_a - (P_b - reference_pressure) * A_b
    force = pressure_force - cylinder_friction_force(v, cylinder) + stop_force(x, v, cylinder).force + load_force
    swept_a, swept_b = A_a * x, A_b * (cylinder.stroke - x)
    return CylinderState(
        v,
        force / cylinder.moving_mass,
        pressure_rate(flow_a, A_a * v, P_a, fluid_a, cylinder.chamber_a, reference_pressure, swept_a),
        pressure_rate(flow_b, -A_b * v, P_b, fluid_b, cylinder.chamber_b, reference_pressure, swept_b),
    )


def cylinder_friction_force(velocity: float, cylinder: Cylinder) -> float:
    """Friction of a cylinder [N], against the velocity: b v + F_c v / sqrt(v^2 + v_c^2).

    velocity  v [m/s]

    Source  wang2017, eq. 6.1 (viscous); dry friction: ours, docs/models/components.md
    """
    v, v_c = velocity, cylinder.coulomb_velocity
    dry: float = cylinder.coulomb_friction * v / np.sqrt(v**2 + v_c**2)
    return cylinder.viscous_friction * v + dry


def cylinder_friction_power(velocity: float, cylinder: Cylinder) -> float:
    """Power that the friction of a cylinder turns to heat [W], never negative.

    velocity  [m/s]

    Source  ours, docs/models/components.md
    """
    return cylinder_friction_force(velocity, cylinder) * velocity


def stop_force(position: float, velocity: float, cylinder: Cylinder) -> StopForce:
    """Force of the end stops on the piston [N] and their loss [W], never negative.

    At depth s, going in with s': k s max(1 + c s', 0) outward, of which k s is given back. The force begins and ends
    at zero and never holds the piston.

    position  [m]
    velocity  [m/s]

    Source  hunt1975; without pull: ours, docs/models/components.md
    """
    k, c = cylinder.stop_stiffness, cylinder.stop_damping
    near = maximum(-position, 0.0)
    far = maximum(position - cylinder.stroke, 0.0)
    damped_near = maximum(-c * velocity, -1.0)
    damped_far = maximum(c * velocity, -1.0)
    return StopForce(
        k * near * (1.0 + damped_near) - k * far * (1.0 + damped_far),
        k * velocity * (far * damped_far - near * damped_near),
    )


def cylinder_stored(state: CylinderState, oil: Oil, cylinder: Cylinder) -> Stored:
    """Energy [J] of a cylinder, its two chambers, m v^2/2 and the stops' k s^2/2, and its tank volumes [m^3].

    Source  ours, docs/models/components.md
    """
    x, v, P_a, P_b = state
    a = stored(P_a, oil, cylinder.chamber_a, cylinder.area_a * x)
    b = stored(P_b, oil, cylinder.chamber_b, cylinder.area_b * (cylinder.stroke - x))
    depth = maximum(-x, 0.0) + maximum(x - cylinder.stroke, 0.0)
    kinetic = 0.5 * cylinder.moving_mass * v**2
    stop = 0.5 * cylinder.stop_stiffness * depth**2
    return Stored(a.energy + b.energy + kinetic + stop, a.volume + b.volume)
