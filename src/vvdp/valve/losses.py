"""Losses of the valve in closed form, and their limits of validity.

Derived in docs/models/rotary-valve.md, "Losses". They count volumes: with a compressible oil expect differences of the
size of its volume change.

Source  ours, docs/models/rotary-valve.md, where a function names no other.
"""

from typing import NamedTuple

import numpy as np

from vvdp.base.kinds import Flow, Fraction, Power
from vvdp.base.select import maximum, select
from vvdp.fluid.mixture import NODES, WEIGHTS, compression_energy_per_volume
from vvdp.fluid.oil import Oil
from vvdp.valve.branch import BranchDrops, branch_law, choking_drop, nozzle_resistance, turbulent_drops
from vvdp.valve.condition import Condition
from vvdp.valve.geometry import barrier_width, nozzle_width, pitch, transition_fraction
from vvdp.valve.joined_ports import Ends, joined_ports
from vvdp.valve.leakage import leakage_conductance
from vvdp.valve.rotary import RotaryValve

LEAST_DROP = 1e-6
"""Below any drop that lets oil through [Pa]."""


class PortRamp(NamedTuple):
    """Transition of one port that opens or closes by itself: the open fraction below which the relief valve is open,
    the flows over it and through the port until then and the drop in excess of the fully open valve, all integrated
    over the open fraction.

    Flows are counted in parts of the pump flow.
    """

    relief_opening: float  # 1
    relief_flow: float  # 1
    relieved_port_flow: float  # 1
    excess_drop: float  # Pa


class TransitionLoss(NamedTuple):
    """Mean power lost in the transitions, mean flow that the load misses, mean flow over the relief valve, and the open
    fractions of the load and the tank port below which the relief valve is open."""

    loss: Power
    load_flow_lost: Flow
    relief_flow: Flow
    load_relief_opening: Fraction
    tank_relief_opening: Fraction


def full_open_drop(flow: float, density: float, valve: RotaryValve) -> BranchDrops:
    """Pressure drops of the fully open valve [Pa].

    flow     [m^3/s]
    density  [kg/m^3]

    Source  wang2017, eqs. 2.3 to 2.5
    """
    return turbulent_drops(flow, 1.0, density, valve)


def full_open_loss(flow: float, density: float, valve: RotaryValve) -> float:
    """Power throttled by the fully open valve, Q times its drop [W].

    flow     [m^3/s]
    density  [kg/m^3]

    Source  wang2017, eqs. 2.3 to 2.5
    Holds   for turbulent flow; see `nozzle_reynolds_number`

    >>> print(round(full_open_loss(6.3e-4, 870.0, valve), 1))
    373.6
    """
    drops = full_open_drop(flow, density, valve)
    return flow * (drops.nozzle + drops.centre_section + drops.outlet_turbine)


def throttling_power(flow: float, opening: float, density: float, valve: RotaryValve) -> float:
    """Power that the nozzles of a branch lose because their ports are not fully open [W]: R_n |Q|^3 (1/a^2 - 1).

    Without the smoothing at zero drop, where the power is next to nothing.

    flow     Q, at the inlet's pressure [m^3/s]
    opening  a, open fraction of the branch's ports; nothing flows through closed ones [1]
    density  [kg/m^3]

    >>> print(round(throttling_power(3e-4, 0.5, 870.0, valve), 2))  # three times what they lose fully open
    71.08
    """
    is_open = opening > 0.0
    a = select(is_open, opening, 1.0)
    power: float = nozzle_resistance(density, valve) * abs(flow) ** 3 * (1.0 / (a * a) - 1.0)
    return select(is_open, power, 0.0)


def relief_rise(at: Condition) -> float:
    """Rise of the pressure above the setting of the relief valve with the whole pump flow over it [Pa].

    o Q / Q_r root((P_R + o - P_T) / (P_R + o Q / Q_r - P_T)): the valve's law, exact at its rated flow Q_r.
    """
    yields = at.relief_override > 0.0
    level = at.relief_pressure - at.tank_pressure
    rise = at.relief_override * at.flow / select(yields, at.relief_rated_flow, 1.0)
    settled: float = rise * np.sqrt((level + at.relief_override) / (level + rise))
    return settled


def port_ramp(port_pressure: float, at: Condition, full_drops: BranchDrops, joint: float = 0.0) -> PortRamp:
    """Integrals over the open fraction while one port alone opens, from `joint` to 1 [1, 1, Pa].

    With n the nozzle's and r the other drop at full flow, H = P_R - P_S and o the `relief_rise`: the relief valve is
    open below a* = sqrt(n / (H - r)), held at 1. Until then the inlet is at P_R + o (1 - q), so that the port passes
    q = a (sqrt(o^2 a^2 + 4 (H + o) (n + r a^2)) - o a) / (2 (n + r a^2)), and the excess drop is n (1/a* - 2 + a*)
    + int_0^a* (q H + (1 - q) (P_R - P_T) + o (1 - q)) da - a* (n + r). By 16 Gauss points; at o = 0
    int q da = sqrt(H) (sqrt(n + r a*^2) - sqrt(n)) / r. With a joint above 0 it takes the place of 0, and of a* where
    that is smaller.

    port_pressure  P_S, absolute [Pa]
    at             with a flow > 0
    joint          open fraction below which the other port is open as well [1]
    """
    n, r = full_drops.nozzle, full_drops.centre_section + full_drops.outlet_turbine
    H, o = maximum(at.relief_pressure - port_pressure, 0.0), relief_rise(at)
    relief_opening = np.sqrt(n / maximum(H - r, n))
    end = maximum(relief_opening, joint)
    passed = relieved = 0.0
    for i in range(16):
        a = joint + (0.5 + NODES[i]) * (end - joint)
        c = n + r * a * a
        # sqrt(o^2 a^2 + 4 (H + o) c) - o a without the cancellation; 0 where H + o is
        q = 2.0 * a * (H + o) / maximum(o * a + np.sqrt(o * o * a * a + 4.0 * (H + o) * c), LEAST_DROP)
        passed = passed + WEIGHTS[i] * (end - joint) * q
        spilled = (1.0 - q) * (at.relief_pressure - at.tank_pressure + o)
        relieved = relieved + WEIGHTS[i] * (end - joint) * (q * H + spilled)
    excess = n * (1.0 / end - 2.0 + end) + relieved - (end - joint) * (n + r)
    return PortRamp(relief_opening, end - joint - passed, passed, excess)


def transition_loss(at: Condition, valve: RotaryValve) -> TransitionLoss:
    """Mean power lost while ports open and close, beyond the loss of the fully open valve, and its flows [W, m^3/s, 1].

    L = (2 d_c / pitch) Q (E_load + E_tank + E_both) + 2 max(b - d_c, 0) / pitch Q (P_R + o - P_T - dP_open), E from
    `port_ramp` and, for barriers narrower than the nozzles, `joined_ports`; o from `relief_rise`, for a relief valve
    without lag, constant load pressure and stiff oil. It does not depend on the spool speed, nor on the duty ratio
    between kappa and 1 - kappa; `range_warnings` shows where it holds.

    at  with a flow > 0

    Holds   where `range_warnings` gives no warning

    >>> at = Condition(flow=6.3e-4, load_pressure=70e5, relief_pressure=80e5, tank_pressure=1e5, density=870.0)
    >>> print(round(transition_loss(at, valve).loss, 1))
    959.8
    """
    Q, P_T, rise = at.flow, at.tank_pressure, relief_rise(at)
    drops = full_open_drop(Q, at.density, valve)
    n, r = drops.nozzle, drops.centre_section + drops.outlet_turbine
    joint = maximum(1.0 - valve.lap_ratio, 0.0)
    load = port_ramp(at.load_pressure, at, drops, joint)
    tank = port_ramp(P_T, at, drops, joint)
    over_load = maximum(at.relief_pressure - at.load_pressure, 1.0)
    both = joined_ports(joint, Ends(over_load, at.relief_pressure - P_T, rise, n, r))
    ramps = 2.0 * nozzle_width(valve) / pitch(valve)
    blocked = 2.0 * maximum(barrier_width(valve) - nozzle_width(valve), 0.0) / pitch(valve)
    highest = at.relief_pressure + rise - P_T - n - r
    return TransitionLoss(
        loss=Q * (ramps * (load.excess_drop + tank.excess_drop + both.excess_drop) + blocked * highest),
        load_flow_lost=Q * (ramps * (load.relief_flow + 0.5 * joint - both.load_flow) + 0.5 * blocked),
        relief_flow=Q * (ramps * (load.relief_flow + tank.relief_flow + both.relief_flow) + blocked),
        load_relief_opening=load.relief_opening,
        tank_relief_opening=tank.relief_opening,
    )


def closed_form_load_flow(duty_ratio: float, at: Condition, valve: RotaryValve) -> float:
    """Mean flow to the load, Q d_0 minus the flow over the relief valve in the transitions [m^3/s].

    duty_ratio  d_0, between kappa and 1 - kappa [1]
    at          with a flow > 0
    """
    return at.flow * duty_ratio - transition_loss(at, valve).load_flow_lost


def compressibility_loss(pwm_frequency: float, volume: float, pressure: float, tank_pressure: float, oil: Oil) -> float:
    """Nominal power lost by filling and emptying the inlet volume once per PWM period, f V W_V [W].

    W_V is the energy that oil with air stores per volume; with a constant modulus it is P^2 / (2 beta). Between none
    and twice of it is lost in fact, see `compression_regime`.

    pwm_frequency            [Hz]
    volume                   [m^3]
    pressure, tank_pressure  absolute [Pa]

    Source  wang2017, eq. 2.10, with the frequency counted once and the energy of oil with air

    >>> print(round(compressibility_loss(60.0, 1e-4, 70e5, 101325.0, oil), 1))
    132.5
    """
    return pwm_frequency * volume * compression_energy_per_volume(pressure, tank_pressure, oil)


def compression_regime(
    pwm_frequency: float, volume: float, pressure_rise: float, mean_bulk_modulus: float, flow: float, valve: RotaryValve
) -> float:
    """Time that filling the inlet volume takes over the time that a port takes to open [1].

    Lambda = (V P / (beta Q)) / (d_c / (pitch f)). Far below 1 the filling uses flow that would go over the relief valve
    anyway and costs almost nothing; above 3 it costs once to twice the nominal loss.

    pwm_frequency                     [Hz]
    volume                            [m^3]
    pressure_rise, mean_bulk_modulus  [Pa]
    flow                              of the pump, > 0 [m^3/s]
    """
    filling = volume * pressure_rise / (mean_bulk_modulus * flow)
    return filling * pwm_frequency * pitch(valve) / nozzle_width(valve)


def leakage_loss(pressure_difference: float, viscosity: float, valve: RotaryValve) -> float:
    """Power lost by leakage from the load region, G dP^2 [W]. That region is always under load pressure.

    pressure_difference  of load over tank [Pa]
    viscosity            dynamic [Pa s]
    """
    return leakage_conductance(viscosity, valve) * pressure_difference * pressure_difference


def friction_loss(spool_speed: float, friction_coefficient: float) -> float:
    """Power of the viscous friction on the spool, k_f omega^2 [W]. The flow's drop already contains it.

    spool_speed           [rad/s]
    friction_coefficient  [N m s]

    Source  wang2017, eq. 2.9
    """
    return friction_coefficient * spool_speed * spool_speed


def range_warnings(duty_ratio: float, at: Condition, valve: RotaryValve) -> tuple[str, ...]:
    """Doubts about the closed form of the transition loss at an operating point, in sentences; empty without any.

    duty_ratio  [1]
    """
    found = []
    kappa = transition_fraction(valve)
    if kappa > 0.5:
        found.append(
            f"a transition takes {kappa:.4g} of a period: at no duty ratio do both ports open fully, and the closed "
            f"form of the transition loss does not hold"
        )
    elif not kappa <= duty_ratio <= 1.0 - kappa:
        port = "load" if duty_ratio < kappa else "tank"
        found.append(
            f"duty ratio {duty_ratio:.4g} lies outside {kappa:.4g} to {1.0 - kappa:.4g}: the {port} port is never "
            f"fully open, and the analytic transition loss does not hold"
        )
    needed = at.load_pressure - at.tank_pressure + full_open_loss(at.flow, at.density, valve) / at.flow
    setting = at.relief_pressure - at.tank_pressure
    if setting <= needed:
        found.append(
            f"the relief setting of {1e-5 * setting:.4g} bar does not exceed the {1e-5 * needed:.4g} bar that the load "
            f"and the open valve need over the tank: the relief valve is open even with the load port fully open"
        )
    choking = choking_drop(at.relief_pressure, branch_law(at.density, valve, at.vapour_pressure))
    if valve.pressure_recovery > 0.0 and choking < setting:
        found.append(
            f"the nozzles choke from a drop of {1e-5 * choking:.4g} bar on, and the tank port opens and closes "
            "under up "
            f"to {1e-5 * setting:.4g} bar: the analytic transition loss does not hold"
        )
    return tuple(found)


def best_relief_pressure(
    flow: float, load_pressure: float, tank_pressure: float, density: float, valve: RotaryValve
) -> float:
    """Relief pressure with the least transition loss, absolute [Pa].

    A lower one sends more of the load's flow over the relief valve, a higher one costs more per volume sent over it.
    Golden section between the pressure that the open valve needs and four times as far above the load.

    flow                          of the pump, > 0 [m^3/s]
    load_pressure, tank_pressure  absolute [Pa]
    density                       [kg/m^3]
    """

    def loss(relief_pressure: float) -> float:
        at = Condition(
            flow=flow,
            load_pressure=load_pressure,
            relief_pressure=relief_pressure,
            tank_pressure=tank_pressure,
            density=density,
        )
        return transition_loss(at, valve).loss

    open_drop = full_open_loss(flow, density, valve) / flow
    low = load_pressure + open_drop
    high = low + 3.0 * open_drop + (load_pressure - tank_pressure)
    shrink = 0.5 * (5.0**0.5 - 1.0)
    for _ in range(60):
        left, right = high - shrink * (high - low), low + shrink * (high - low)
        falling = loss(left) > loss(right)
        low, high = select(falling, left, low), select(falling, high, right)
    return 0.5 * (low + high)
