"""Flow, loss and speed of the valve averaged over a PWM period, without its dynamics.

Quasi-steady: a relief valve without lag, constant pressures at load and tank, stiff oil. Holds at any duty ratio; the
inlet pressure is found by bisection at each of many angles, so these functions are for maps and tables, not for the
simulation's loop. See docs/models/rotary-valve.md, "Flow map".

Source  ours, docs/models/rotary-valve.md, where a function names no other.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.kinds import Flow, Power, Pressure
from vvdp.base.select import maximum, minimum, select
from vvdp.valve.branch import BranchFlow, branch_law, search_flow, throttled_flow
from vvdp.valve.condition import Condition
from vvdp.valve.geometry import EVEN, Openings, port_openings
from vvdp.valve.rotary import RotaryValve
from vvdp.valve.torque import friction_coefficient, spool_torque

ANGLES, FEWER_ANGLES = 1000, 250
BISECTIONS = 24
"""To within some Pa; a straight line between these ends is then right to 1e-12."""
SECANTS, CORRECTIONS = 7, 4
"""Steps after which hardly any pressure is in another interval than bisection ends in, and of those that are."""
LEAST_FLOW = 1e-30
"""Least divisor of a ratio of flows [m^3/s]."""


class Cycle(NamedTuple):
    """Half a PWM period, the other half being its mirror image, as arrays over equally spaced angles."""

    openings: Openings
    inlet_pressure: Any  # Pa, absolute
    load: BranchFlow
    tank: BranchFlow
    relief_flow: Any  # m^3/s


class CycleMean(NamedTuple):
    """Means over a PWM period: flows to load, tank, over the relief valve and back through the pump, inlet pressure,
    and power lost, `pump_loss` of it by the pump's leakage."""

    load_flow: Flow
    tank_flow: Flow
    relief_flow: Flow
    pump_leakage_flow: Flow
    inlet_pressure: Pressure
    loss: Power
    pump_loss: Power


def static_relief_flow(
    pressure: float, cracking_pressure: float, override: float, rated_flow: float, tank_pressure: float
) -> float:
    """Flow over a relief valve without lag at a pressure [m^3/s]; 0 for an ideal one, whose flow no pressure shows.

    Q_r (P - P_cr) / override root((P - P_T) / (P_cr + override - P_T)) above P_cr: it opens in proportion, and passes
    Q_r at the override. The simulated valve has the same law.

    pressure, cracking_pressure, tank_pressure  absolute [Pa]
    override                                    0 or more [Pa]
    rated_flow                                  Q_r [m^3/s]
    """
    yields = override > 0.0
    opening = maximum(pressure - cracking_pressure, 0.0) / select(yields, override, 1.0)
    design_drop = cracking_pressure + override - tank_pressure
    root = np.sqrt(maximum(pressure - tank_pressure, 0.0) / select(design_drop > 0.0, design_drop, cracking_pressure))
    flow: float = select(yields, rated_flow * opening * root, 0.0)
    return flow


def highest_inlet_pressure(flow: float, cracking_pressure: float, override: float, rated_flow: float) -> float:
    """A pressure at which a relief valve without lag passes at least the pump flow, absolute [Pa].

    flow, rated_flow   of pump and relief valve [m^3/s]
    cracking_pressure  absolute [Pa]
    override           0 or more [Pa]
    """
    yields = override > 0.0
    share = maximum(flow / select(yields, rated_flow, 1.0), 1.0)
    return cracking_pressure + select(yields, override * share, 0.0)


def quasi_steady_cycle(duty_ratio: float, at: Condition, valve: RotaryValve) -> Cycle:
    """State of the valve at equally spaced angles over half a PWM period.

    At each angle the inlet pressure is the one at which both branches, the relief valve and the pump's leakage together
    take the pump flow.

    duty_ratio  axial position over helix length, any value [1]
    at          with the relief pressure highest
    """
    angle: Any = np.pi / valve.sections * (np.arange(ANGLES) + 0.5) / ANGLES
    return balanced_cycle(port_openings(angle, duty_ratio * valve.helix_length, valve), at, valve)


def balanced_cycle(openings: Openings, at: Condition, valve: RotaryValve) -> Cycle:
    """State of the valve at given openings, arrays of shape (n,); see `quasi_steady_cycle`.

    at  whose load pressure may be an array of shape (m, 1): then all but the openings has the shape (m, n)
    """
    law = branch_law(at.density, valve, at.vapour_pressure)
    shape = np.broadcast_shapes(np.shape(openings.load), np.shape(at.load_pressure))
    relief = at.relief_pressure, at.relief_override, at.relief_rated_flow

    tank_open: Any = openings.tank > 0.0
    tank_opening: Any = np.extract(tank_open, openings.tank)

    def total_flow(pressure: Any) -> Any:
        flow: Any = search_flow(pressure, at.load_pressure, openings.load, law)
        flow[..., tank_open] += search_flow(pressure[..., tank_open], at.tank_pressure, tank_opening, law)
        spilled = static_relief_flow(pressure, *relief, at.tank_pressure)
        return flow + spilled + at.pump_leakage * (pressure - at.tank_pressure)

    # Without override the search ends at the relief pressure, and what it leaves over is the relief flow.
    bottom: Any = np.full(shape, minimum(at.load_pressure, at.tank_pressure))
    top: Any = np.full(shape, highest_inlet_pressure(at.flow, *relief))
    low, least, high, most = _bracket(total_flow, at.flow, bottom, at.relief_pressure, top)
    missing = maximum(at.flow - least, 0.0)
    inlet = low + missing / maximum(maximum(most - least, missing), LEAST_FLOW) * (high - low)
    load = throttled_flow(inlet, at.load_pressure, openings.load, law)
    tank = throttled_flow(inlet, at.tank_pressure, openings.tank, law)
    leakage = at.pump_leakage * (inlet - at.tank_pressure)
    spilled = maximum(at.flow - leakage - load.flow - tank.flow, 0.0)
    return Cycle(openings=openings, inlet_pressure=inlet, load=load, tank=tank, relief_flow=spilled)


def _bracket(
    flow_at: Callable[[Any], Any], flow: float, bottom: Any, cracking: float, top: Any
) -> tuple[Any, Any, Any, Any]:
    """The interval in which bisection ends: its low end, the flow there, its high end, and there.

    The flow grows with the pressure, so which half is chosen follows from where the flow is reached. This is found in
    fewer evaluations, and then both ends are checked; bisection itself is the last resort.

    flow_at           flow at each of an array of pressures [m^3/s]
    flow              that is to be reached [m^3/s]
    bottom, top       between which pressures, arrays of one shape [Pa]
    cracking          as in `_reaching_pressure` [Pa]
    """
    found: Any = _reaching_pressure(flow_at, flow, bottom, cracking, top)
    for _ in range(CORRECTIONS):
        low, high = _bisect(found.__gt__, bottom, top)
        least, most = flow_at(low), flow_at(high)
        above, below = (least >= flow) & (low > bottom), (most < flow) & (high < top)
        if not (above | below).any():
            return low, least, high, most
        found = np.where(above, low, np.where(below, np.nextafter(high, np.inf), found))
    low, high = _bisect(lambda middle: flow_at(middle) < flow, bottom, top)
    return low, flow_at(low), high, flow_at(high)


def _bisect(is_short: Callable[[Any], Any], low: Any, high: Any) -> tuple[Any, Any]:
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        short = is_short(middle)
        low, high = np.where(short, middle, low), np.where(short, high, middle)
    return low, high


def _reaching_pressure(flow_at: Callable[[Any], Any], flow: float, bottom: Any, cracking: float, top: Any) -> Any:
    """About where a flow is reached [Pa]: the squares of flows through orifices are straight lines (Illinois).

    cracking  above which the relief valve takes its part [Pa]
    """

    def excess(pressure: Any) -> Any:
        found = flow_at(pressure)
        return found * abs(found) - flow * flow

    (low, under), (high, over), short = (bottom, excess(bottom)), (top, excess(top)), None
    middle: Any = np.clip(cracking, bottom, top)
    for _ in range(SECANTS):
        found, before = excess(middle), short
        short = found < 0.0
        kept = np.where(short == before, 0.5, 1.0)  # an end that stays a second time counts half
        low, under = np.where(short, middle, low), np.where(short, found, kept * under)
        high, over = np.where(short, high, middle), np.where(short, kept * over, found)
        middle = low + np.clip(under / minimum(under - over, -(LEAST_FLOW**2)), 0.0, 1.0) * (high - low)
    return middle


def delivered_flows(duty_ratios: Array, at: Condition, valve: RotaryValve) -> Array:
    """Mean flows to the load at many duty ratios [m^3/s], shape (n,) or (m, n); `quasi_steady_mean` for one.

    A quarter of the angles of `quasi_steady_mean`, and each pair of openings balanced only once: within 0.02 % of the
    pump flow of that, and 30 times faster.

    duty_ratios  axial position over helix length, shape (n,) [1]
    at           with the relief pressure highest; its load pressure may be an array of shape (m, 1)
    """
    angle = np.pi / valve.sections * (np.arange(FEWER_ANGLES) + 0.5) / FEWER_ANGLES
    position = np.asarray(duty_ratios)[:, np.newaxis] * valve.helix_length
    found: Any = port_openings(angle, position, valve)  # type: ignore[arg-type]  # on arrays too
    feeds = found.load > 0.0
    pairs, place = np.unique(found.load[feeds] + 1j * found.tank[feeds], return_inverse=True)
    openings: Any = Openings(pairs.real.copy(), pairs.imag.copy())  # type: ignore[arg-type]
    balanced: Any = balanced_cycle(openings, at, valve).load.flow
    flows = np.zeros((*balanced.shape[:-1], *feeds.shape))
    flows[..., feeds] = balanced[..., place]
    means: Array = np.mean(flows, axis=-1)
    return means


def quasi_steady_mean(duty_ratio: float, at: Condition, valve: RotaryValve) -> CycleMean:
    """Mean flows, inlet pressure and power lost over a PWM period [m^3/s, Pa, W].

    The loss is the pump's power less the load's, both against the tank.

    duty_ratio  axial position over helix length, any value [1]
    at          with the relief pressure highest
    """
    return mean_of_cycle(quasi_steady_cycle(duty_ratio, at, valve), at)


def mean_of_cycle(cycle: Cycle, at: Condition) -> CycleMean:
    """Mean flows, inlet pressure and power lost of a cycle [m^3/s, Pa, W]; see `quasi_steady_mean`.

    at  condition of the cycle
    """
    load_flow, rise = float(np.mean(cycle.load.flow)), cycle.inlet_pressure - at.tank_pressure
    mean_rise = float(np.mean(rise))
    return CycleMean(
        load_flow=load_flow,
        tank_flow=float(np.mean(cycle.tank.flow)),
        relief_flow=float(np.mean(cycle.relief_flow)),
        pump_leakage_flow=at.pump_leakage * mean_rise,
        inlet_pressure=mean_rise + at.tank_pressure,
        loss=at.flow * mean_rise - load_flow * (at.load_pressure - at.tank_pressure),
        pump_loss=at.pump_leakage * float(np.mean(rise * rise)),
    )


def averaged_spool_speed(duty_ratio: float, at: Condition, viscosity: float, valve: RotaryValve) -> float:
    """Speed at which the torques balance on average over a PWM period, ports partly open included [rad/s].

    The torque is linear in the speed, so its means at two speeds give the balance. The speed's own ripple within a
    period is left out.

    duty_ratio  axial position over helix length, any value [1]
    at          with the relief pressure highest
    viscosity   dynamic, in the films between load and tank [Pa s]
    """
    return speed_of_cycle(quasi_steady_cycle(duty_ratio, at, valve), at.density, viscosity, valve)


def speed_of_cycle(cycle: Cycle, density: float, viscosity: float, valve: RotaryValve) -> float:
    """Speed at which the torques of a cycle balance on average [rad/s]; see `averaged_spool_speed`.

    density    [kg/m^3]
    viscosity  dynamic, in the films between load and tank [Pa s]
    """
    k_f = friction_coefficient(viscosity, valve)
    at_rest = _mean_net_torque(cycle, 0.0, density, k_f, valve)
    turning = _mean_net_torque(cycle, 1.0, density, k_f, valve)
    return at_rest / (at_rest - turning)


def _mean_net_torque(cycle: Cycle, spool_speed: float, density: float, k_f: float, valve: RotaryValve) -> float:
    torque = spool_torque(cycle.load, cycle.tank, cycle.openings, EVEN, spool_speed, density, k_f, valve)
    return float(np.mean(torque.turbine - torque.friction))
