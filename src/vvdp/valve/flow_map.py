"""Flow, loss and speed of the valve averaged over a PWM period, without its dynamics.

Quasi-steady: a relief valve without lag, constant pressures at load and tank, stiff oil. Holds at any duty ratio; the
inlet pressure is found by bisection at each of many angles, so these functions are for maps and tables, not for the
simulation's loop. See docs/models/rotary-valve.md, "Flow map".

Source  ours, docs/models/rotary-valve.md, where a function names no other.
"""

from typing import Any, NamedTuple

import numpy as np

from vvdp.base.kinds import Flow, Power, Pressure
from vvdp.base.select import maximum, minimum, select
from vvdp.valve.branch import BranchFlow, branch_flow
from vvdp.valve.condition import Condition
from vvdp.valve.geometry import EVEN, Openings, port_openings
from vvdp.valve.rotary import RotaryValve
from vvdp.valve.torque import friction_coefficient, spool_torque

ANGLES = 1000
BISECTIONS = 50


class Cycle(NamedTuple):
    """Half a PWM period, the other half being its mirror image, as arrays over equally spaced angles."""

    openings: Openings
    inlet_pressure: Any  # Pa, absolute
    load: BranchFlow
    tank: BranchFlow
    relief_flow: Any  # m^3/s


class CycleMean(NamedTuple):
    """Means over a PWM period: flows to load, tank and over the relief valve, inlet pressure, and power lost."""

    load_flow: Flow
    tank_flow: Flow
    relief_flow: Flow
    inlet_pressure: Pressure
    loss: Power


def quasi_steady_cycle(duty_ratio: float, at: Condition, valve: RotaryValve, relief_override: float = 0.0) -> Cycle:
    """State of the valve at equally spaced angles over half a PWM period.

    At each angle the inlet pressure is the one at which both branches and the relief valve together take the pump
    flow.

    duty_ratio       axial position over helix length, any value [1]
    at               with the relief pressure highest
    relief_override  rise of the relief pressure at the full pump flow; 0 is ideal [Pa]
    """
    angle: Any = np.pi / valve.sections * (np.arange(ANGLES) + 0.5) / ANGLES
    openings = port_openings(angle, duty_ratio * valve.helix_length, valve)
    low: Any = np.full(ANGLES, minimum(at.load_pressure, at.tank_pressure))
    high: Any = np.full(ANGLES, at.relief_pressure + relief_override)
    # Without override the search ends at the relief pressure, and what it leaves over is the relief flow.
    yields = relief_override > 0.0
    relief_conductance = select(yields, at.flow / select(yields, relief_override, 1.0), 0.0)
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        load = branch_flow(middle - at.load_pressure, openings.load, at.density, valve)
        tank = branch_flow(middle - at.tank_pressure, openings.tank, at.density, valve)
        relief = relief_conductance * maximum(middle - at.relief_pressure, 0.0)
        short = load.flow + tank.flow + relief < at.flow
        low, high = select(short, middle, low), select(short, high, middle)
    load = branch_flow(high - at.load_pressure, openings.load, at.density, valve)
    tank = branch_flow(high - at.tank_pressure, openings.tank, at.density, valve)
    spilled = maximum(at.flow - load.flow - tank.flow, 0.0)
    return Cycle(openings=openings, inlet_pressure=high, load=load, tank=tank, relief_flow=spilled)


def quasi_steady_mean(duty_ratio: float, at: Condition, valve: RotaryValve, relief_override: float = 0.0) -> CycleMean:
    """Mean flows, inlet pressure and power lost over a PWM period [m^3/s, Pa, W].

    The loss is the pump's power less the load's, both against the tank.

    duty_ratio       axial position over helix length, any value [1]
    at               with the relief pressure highest
    relief_override  rise of the relief pressure at the full pump flow; 0 is ideal [Pa]
    """
    cycle = quasi_steady_cycle(duty_ratio, at, valve, relief_override)
    load_flow, inlet = float(np.mean(cycle.load.flow)), float(np.mean(cycle.inlet_pressure))
    return CycleMean(
        load_flow=load_flow,
        tank_flow=float(np.mean(cycle.tank.flow)),
        relief_flow=float(np.mean(cycle.relief_flow)),
        inlet_pressure=inlet,
        loss=at.flow * (inlet - at.tank_pressure) - load_flow * (at.load_pressure - at.tank_pressure),
    )


def averaged_spool_speed(
    duty_ratio: float, at: Condition, viscosity: float, valve: RotaryValve, relief_override: float = 0.0
) -> float:
    """Speed at which the torques balance on average over a PWM period, ports partly open included [rad/s].

    The torque is linear in the speed, so its means at two speeds give the balance. The speed's own ripple within a
    period is left out.

    duty_ratio       axial position over helix length, any value [1]
    at               with the relief pressure highest
    viscosity        dynamic, in the films between load and tank [Pa s]
    relief_override  rise of the relief pressure at the full pump flow; 0 is ideal [Pa]
    """
    cycle = quasi_steady_cycle(duty_ratio, at, valve, relief_override)
    k_f = friction_coefficient(viscosity, valve)
    at_rest = _mean_net_torque(cycle, 0.0, at.density, k_f, valve)
    turning = _mean_net_torque(cycle, 1.0, at.density, k_f, valve)
    return at_rest / (at_rest - turning)


def _mean_net_torque(cycle: Cycle, spool_speed: float, density: float, k_f: float, valve: RotaryValve) -> float:
    torque = spool_torque(cycle.load, cycle.tank, cycle.openings, EVEN, spool_speed, density, k_f, valve)
    return float(np.mean(torque.turbine - torque.friction))
