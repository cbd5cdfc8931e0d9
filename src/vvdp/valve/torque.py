"""Torques on the spool and the speed at which they balance.

Derived in docs/models/rotary-valve.md, "Torque".

Source  ours, docs/models/rotary-valve.md, where a function names no other.
"""

from typing import Annotated, NamedTuple

import numpy as np

from vvdp.base.errors import ParameterError
from vvdp.base.kinds import Fraction, Kind, Length, Ratio
from vvdp.base.params import Params
from vvdp.base.powers import power
from vvdp.base.select import maximum, select
from vvdp.valve.branch import BranchFlow
from vvdp.valve.geometry import JetSkews, Openings
from vvdp.valve.rotary import RotaryValve

Torque = Annotated[float, Kind("torque", "N*m", -1e6, 1e6, "0.2 N*m", scale=1e-3)]


class SpoolTorque(NamedTuple):
    """Torque of the turbines in the direction of rotation and friction torque against it; they balance when equal."""

    turbine: Torque
    friction: Torque


def friction_coefficient(viscosity: float, valve: RotaryValve) -> float:
    """Viscous friction torque over spool speed, k_f = A_surf mu R^2 / (c sqrt(1 - eps^2)) [N m s].

    eps is the spool's eccentricity: the mean of 1/(1 + eps cos) round the circumference is 1/sqrt(1 - eps^2).

    viscosity  dynamic, in the film [Pa s]; `fluid.oil.film_viscosity`

    Source  wang2017, eq. 2.9; eccentricity: sommerfeld1904
    Holds   for laminar flow (`taylor_number` below 41.2) through films that are short in the direction of the axis

    >>> print(f"{friction_coefficient(0.03, valve):.3g}")
    0.00103
    """
    R, e = valve.spool_radius, valve.eccentricity
    off_centre: float = 1.0 / np.sqrt(1.0 - e * e)
    return valve.friction_area * viscosity * R * R / valve.radial_clearance * off_centre


def jet_section(opening: float, skew: float, exponent: float) -> float:
    """a^(1 - s) (a + skew) [1]: how the torque of a jet at a given drop falls as its port closes.

    opening   open fraction a, 0 to 1 [1]
    skew      addition by the jet's asymmetry, `geometry.JetSkews` [1]
    exponent  s, 0 to 1 [1]
    """
    concentration: float = power(opening, 1.0 - exponent)
    return concentration * (opening + skew)


def jet_section_compiled(opening: float, skew: float, exponent: float) -> float:
    """The same as `jet_section`, which it replaces in compiled code: most of the time a port is closed or open.

    opening   open fraction a, 0 to 1 [1]
    skew      addition by the jet's asymmetry [1]
    exponent  s, 0 to 1 [1]
    """
    if exponent == 0.0 or opening == 0.0 or opening == 1.0:
        return opening * (opening + skew)
    concentration: float = power(opening, 1.0 - exponent)
    return concentration * (opening + skew)


def jet_arm(valve: RotaryValve) -> float:
    """Torque of the jets of open nozzles over the momentum rho Q^2, R_in / (r A_in) [1/m].

    Source  wang2017, eq. 2.6; the ratio r of the effective area to A_in is ours, docs/models/rotary-valve.md
    """
    return valve.inlet_radius / (valve.inlet_area_ratio * valve.nozzle_area)


def inlet_torque(
    full_section_flow: float, opening: float, density: float, valve: RotaryValve, skew: float = 0.0
) -> float:
    """Torque of the nozzle jets of one branch on a spool [N m]: rho R_in Q^2 / (r A_in a^s) (1 + skew / a).

    Zero for reversed flow. Written with the flow per open fraction, Q = a Q_f, so that it stays finite when the port
    closes.

    full_section_flow  flow over open fraction [m^3/s]
    opening            open fraction a, 0 to 1 [1]
    density            [kg/m^3]
    skew               addition to the opening by the jet's asymmetry, `geometry.JetSkews` [1]

    Source  wang2017, eq. 2.6, with the area of all nozzles; exponent s, skew and the ratio r of the effective area to
            it are ours, docs/models/rotary-valve.md
    """
    Q = maximum(full_section_flow, 0.0)
    return density * jet_arm(valve) * Q * Q * jet_section(opening, skew, valve.jet_exponent)


def outlet_torque(flow: float, spool_speed: float, density: float, valve: RotaryValve) -> float:
    """Torque of the outlet turbine of one branch, with the swirl that the leaving fluid carries off [N m].

    rho R_out Q^2 / A_out,eff - rho R_out^2 omega Q;  for reversed flow, which enters without swirl and leaves
    through the nozzles with that of the spool, - rho R_in^2 omega |Q|.

    flow         [m^3/s]
    spool_speed  [rad/s]
    density      [kg/m^3]

    Source  wang2017, eq. 2.7; reversed flow is ours, docs/models/rotary-valve.md
    """
    Q: float = maximum(flow, 0.0)
    radius: float = select(flow < 0.0, valve.inlet_radius, valve.outlet_radius)
    reaction = density * valve.outlet_radius / valve.outlet_effective_area * Q * Q
    return reaction - density * radius * radius * spool_speed * abs(flow)


def spool_torque(
    load: BranchFlow,
    tank: BranchFlow,
    openings: Openings,
    skews: JetSkews,
    spool_speed: float,
    density: float,
    friction_coefficient: float,
    valve: RotaryValve,
) -> SpoolTorque:
    """Turbine torque of both branches and friction torque [N m]; the spool accelerates by their difference.

    With the skews `geometry.EVEN` it is the mean over two angles at which the ports open alike, one before and one
    behind the middle of a wedge, as far as their flows are alike.

    spool_speed           [rad/s]
    density               [kg/m^3]
    friction_coefficient  friction torque over spool speed [N m s]

    Source  wang2017, eqs. 2.6, 2.7 and 2.9; partly open ports are ours, docs/models/rotary-valve.md
    """
    turbine = (
        inlet_torque(load.full_section_flow, openings.load, density, valve, skews.load)
        + outlet_torque(load.flow, spool_speed, density, valve)
        + inlet_torque(tank.full_section_flow, openings.tank, density, valve, skews.tank)
        + outlet_torque(tank.flow, spool_speed, density, valve)
    )
    return SpoolTorque(turbine, friction_coefficient * spool_speed)


def spool_inertia(valve: RotaryValve) -> float:
    """Moment of inertia of the spool taken as a solid cylinder, M R^2 / 2 [kg m^2]."""
    return 0.5 * valve.spool_mass * valve.spool_radius * valve.spool_radius


def flow_damping(flow: float, density: float, valve: RotaryValve) -> float:
    """Torque over speed that the leaving fluid takes for its swirl, rho R_out^2 Q [N m s], flow forward.

    flow     [m^3/s]
    density  [kg/m^3]

    Source  wang2017, eq. 2.7, second term
    """
    return density * valve.outlet_radius * valve.outlet_radius * flow


def stall_torque(flow: float, density: float, valve: RotaryValve) -> float:
    """Turbine torque of the fully open valve on a spool at rest, rho Q^2 (R_in / A_in + R_out / A_out,eff) [N m].

    flow     [m^3/s]
    density  [kg/m^3]

    Source  wang2017, eqs. 2.6 and 2.7
    """
    return density * flow * flow * (jet_arm(valve) + valve.outlet_radius / valve.outlet_effective_area)


def equilibrium_speed(flow: float, density: float, viscosity: float, valve: RotaryValve) -> float:
    """Speed at which the fully open valve spins by itself [rad/s].

    omega = rho Q^2 (R_in / A_in + R_out / A_out,eff) / (A_surf mu R^2 / c + rho R_out^2 Q)

    flow       [m^3/s]
    density    [kg/m^3]
    viscosity  dynamic [Pa s]

    Source  wang2017, eqs. 2.6, 2.7 and 2.9 in balance
    Holds   at a steady flow above zero through ports that are fully open; laminar friction

    >>> speed = equilibrium_speed(6.3e-4, 870.0, 0.03, valve)
    >>> print(round(pwm_frequency(speed, valve), 1))
    81.2
    """
    resistance = friction_coefficient(viscosity, valve) + flow_damping(flow, density, valve)
    return stall_torque(flow, density, valve) / resistance


def driven_speed(
    motor_speed: float, coupling: float, flow: float, density: float, viscosity: float, valve: RotaryValve
) -> float:
    """Speed of the fully open valve's spool with a motor on a slipping coupling, or by itself at coupling 0 [rad/s].

    omega = (tau_stall + K omega_m) / (k_f + rho R_out^2 Q + K)

    motor_speed  [rad/s]
    coupling     K, torque per slip [N m s]
    flow         > 0 [m^3/s]
    density      [kg/m^3]
    viscosity    dynamic [Pa s]

    Source  wang2017, eqs. 2.6, 2.7 and 2.9 in balance; the coupling is ours, docs/models/components.md
    """
    resistance = friction_coefficient(viscosity, valve) + flow_damping(flow, density, valve)
    return (stall_torque(flow, density, valve) + coupling * motor_speed) / (resistance + coupling)


def pwm_frequency(spool_speed: float, valve: RotaryValve) -> float:
    """Switching cycles per second, N omega / (2 pi) [Hz].

    spool_speed  [rad/s]

    Source  wang2017, section 2.5; eq. 2.10 counts N twice
    Error   none: a matter of counting

    >>> print(round(pwm_frequency(100.0, valve), 2))
    47.75
    """
    return valve.sections * spool_speed / (2.0 * np.pi)


def spool_time_constant(flow: float, density: float, viscosity: float, valve: RotaryValve) -> float:
    """Time constant of the spool speed at a constant flow, J / (k_f + rho R_out^2 Q) [s].

    flow       [m^3/s]
    density    [kg/m^3]
    viscosity  dynamic [Pa s]
    """
    return spool_inertia(valve) / (friction_coefficient(viscosity, valve) + flow_damping(flow, density, valve))


def fit_friction_area(pwm_frequency: float, flow: float, density: float, viscosity: float, valve: RotaryValve) -> float:
    """Friction area with which the fully open valve spins at a stated PWM frequency [m^2].

    pwm_frequency  [Hz]
    flow           [m^3/s]
    density        [kg/m^3]
    viscosity      dynamic, in the films between load and tank [Pa s]; `fluid.oil.film_viscosity`

    Raises  ParameterError when the valve would not reach that frequency even without friction.
    Source  wang2017, eqs. 2.6, 2.7 and 2.9 in balance
    """
    omega = 2.0 * np.pi * pwm_frequency / valve.sections
    friction = stall_torque(flow, density, valve) / omega - flow_damping(flow, density, valve)
    if not friction > 0.0:
        ceiling = valve.sections / (2.0 * np.pi) * stall_torque(flow, density, valve)
        raise ParameterError(
            f"a PWM frequency of {pwm_frequency:g} Hz cannot be reached: without any friction the valve spins at "
            f"{ceiling / flow_damping(flow, density, valve):.4g} Hz"
        )
    return friction / friction_coefficient(viscosity, valve) * valve.friction_area


class SpoolSurface(Params):
    """The part of the spool's surface that runs close to the sleeve.

    `bearing_length` is plain land; over `pocket_length` the fraction `pocket_coverage` of the circumference is cut
    back by `pocket_depth`. `pocket_drag_factor` is the shear on the sleeve relative to plane Couette flow over the
    depth: 1 for a groove all the way round, 4 for a pocket closed in the direction of rotation.
    """

    bearing_length: Length
    pocket_length: Length
    pocket_coverage: Fraction
    pocket_depth: Length
    pocket_drag_factor: Ratio


def friction_area_from_lands(surface: SpoolSurface, valve: RotaryValve) -> float:
    """Area of land that would drag as much as the lands and pockets together [m^2].

    A_surf = 2 pi R (l_b + l_p (1 - f) + l_p f k c / (c + h)): laminar shear goes with one over the gap, which is
    the clearance c over the lands and c + h over a pocket of depth h.

    Source  ours, docs/models/rotary-valve.md, after wang2017, section 2.5
    """
    c, f = valve.radial_clearance, surface.pocket_coverage
    weight = surface.pocket_drag_factor * c / (c + surface.pocket_depth)
    length = surface.bearing_length + surface.pocket_length * (1.0 - f + f * weight)
    return 2.0 * np.pi * valve.spool_radius * length
