"""Means over a PWM period without dynamics, one operating point at a time and compiled: what analytic maps are made of.

The same physics as `vvdp.valve.flow_map`, which works on whole arrays of angles. Here every angle is solved by itself,
in closed form where one port alone is open below the relief setting, so that ten thousand points take part of a second.
"""

from typing import NamedTuple

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.conservation import Nothing
from vvdp.base.kinds import (
    Conductance,
    Coupling,
    Density,
    DutyRatio,
    DynamicViscosity,
    Flow,
    Pressure,
    PressureDifference,
    Ratio,
    Speed,
)
from vvdp.base.select import maximum, minimum
from vvdp.valve.branch import BranchFlow, BranchLaw, branch_drops, branch_law, choking_ratio, throttled_flow
from vvdp.valve.flow_map import highest_inlet_pressure, static_relief_flow
from vvdp.valve.geometry import EVEN, Openings, PortShape, port_shape, shape_openings
from vvdp.valve.rotary import RotaryValve
from vvdp.valve.torque import friction_coefficient, spool_inertia, spool_torque

ANGLES = 500
"""Equally spaced over half a PWM period, the other half being its mirror image."""
SLOWEST = 3.0
"""Slowness beyond which a spool counts as one that stops: those that turn have up to 1.7, the others 3.9 or more."""
CREEP = 1e-9
"""Speed that takes the place of none in a quotient [rad/s]."""
MOST_TRIALS = 60
CLOSE = 1e-12
"""Width of the bracket, over the highest pressure, at which the inlet pressure counts as found."""


class CyclePoint(NamedTuple):
    """Conditions of a valve: pressures absolute, `flow` what the pump displaces.

    The relief valve passes its rated flow at its override; with an override of 0 it is ideal.
    """

    duty_ratio: DutyRatio
    load_pressure: Pressure
    tank_pressure: Pressure
    relief_pressure: Pressure
    relief_override: PressureDifference
    relief_rated_flow: Flow
    flow: Flow
    pump_leakage: Conductance
    density: Density
    viscosity: DynamicViscosity
    vapour_pressure: Pressure = 0.0


class CycleMeans(NamedTuple):
    """Means over a PWM period, the speed at which the torques balance over it, and how slow the spool is against that.

    `resistance` is the torque that the spool loses per speed: to turn at omega takes resistance times
    (omega - spool_speed) from outside.

    `slowness` is the time that the spool takes for half a period, driven by the torque at each angle with its own
    inertia, over the time at `spool_speed`: about 1 for a spool that turns, beyond `SLOWEST` for one that stops where
    both ports are nearly closed.
    """

    load_flow: Flow
    tank_flow: Flow
    relief_flow: Flow
    inlet_pressure: Pressure
    spool_speed: Speed
    resistance: Coupling
    slowness: Ratio


class Instant(NamedTuple):
    """The valve at one angle; `passed` is what the relief valve gets."""

    inlet_pressure: Pressure
    load: BranchFlow
    tank: BranchFlow
    passed: Flow


def taken_flow(pressure: float, openings: Openings, point: CyclePoint, law: BranchLaw) -> float:
    """Flow that both ports, the relief valve's override and the pump's leakage take at an inlet pressure [m^3/s].

    pressure  at the inlet, absolute [Pa]
    openings  open fractions of the ports [1]

    Source  ours, docs/models/rotary-valve.md
    """
    ports = (
        throttled_flow(pressure, point.load_pressure, openings.load, law).flow
        + throttled_flow(pressure, point.tank_pressure, openings.tank, law).flow
    )
    relief = static_relief_flow(
        pressure, point.relief_pressure, point.relief_override, point.relief_rated_flow, point.tank_pressure
    )
    return ports + relief + point.pump_leakage * (pressure - point.tank_pressure)


def inlet_pressure_between(low: float, high: float, openings: Openings, point: CyclePoint, law: BranchLaw) -> float:
    """The inlet pressure between two others at which all passages together take the pump flow, absolute [Pa].

    Regula falsi with the Illinois weight; the flow grows with the pressure, so there is one. It goes by the squares of
    flows, which are nearly straight over the pressure, so that few trials are needed.

    low, high  below and above it, absolute [Pa]
    openings   open fractions of the ports [1]

    Source  ours, docs/models/rotary-valve.md
    """
    below = surplus_square(low, openings, point, law)
    above = surplus_square(high, openings, point, law)
    last = 0.0
    for _ in range(MOST_TRIALS):
        if high - low <= CLOSE * high or above <= 0.0 or below >= 0.0:
            break
        trial = high - above * (high - low) / (above - below)
        left = surplus_square(trial, openings, point, law)
        if left > 0.0:
            high, above = trial, left
            if last > 0.0:
                below = 0.5 * below
            last = 1.0
        else:
            low, below = trial, left
            if last < 0.0:
                above = 0.5 * above
            last = -1.0
        if abs(left) <= 2.0 * CLOSE * point.flow * point.flow:
            return trial
    return low if below >= 0.0 else high


def surplus_square(pressure: float, openings: Openings, point: CyclePoint, law: BranchLaw) -> float:
    """Square of the flow that all passages take, with its sign, less that of the pump flow [m^6/s^2].

    pressure  at the inlet, absolute [Pa]
    openings  open fractions of the ports [1]

    Source  ours, docs/models/rotary-valve.md
    """
    taken = taken_flow(pressure, openings, point, law)
    return taken * abs(taken) - point.flow * point.flow


def instant(openings: Openings, point: CyclePoint, law: BranchLaw, valve: RotaryValve) -> Instant:
    """Inlet pressure and branch flows at one angle [Pa, m^3/s].

    openings  open fractions of the ports [1]

    Source  ours, docs/models/rotary-valve.md
    """
    if point.pump_leakage == 0.0 and openings.load * openings.tank == 0.0 and openings.load + openings.tank > 0.0:
        opening = openings.load + openings.tank
        behind = point.load_pressure if openings.load > 0.0 else point.tank_pressure
        drops = branch_drops(point.flow, opening, point.density, valve)
        pressure = behind + drops.nozzle + drops.centre_section + drops.outlet_turbine
        # What a closed port would pass per open fraction, and the shares of the drop, are of no account here.
        whole = BranchFlow(point.flow, point.flow / opening, 1.0, 0.0, 0.0)
        if pressure <= point.relief_pressure and choking_ratio(whole, pressure, law) <= 1.0:
            none = BranchFlow(0.0, 0.0, 1.0, 0.0, 0.0)
            if openings.load > 0.0:
                return Instant(pressure, whole, none, 0.0)
            return Instant(pressure, none, whole, 0.0)
    return searched_instant(openings, point, law)


def searched_instant(openings: Openings, point: CyclePoint, law: BranchLaw) -> Instant:
    """Inlet pressure and branch flows at one angle [Pa, m^3/s], without the closed form for a single open port.

    openings  open fractions of the ports [1]

    Source  ours, docs/models/rotary-valve.md
    """
    highest = highest_inlet_pressure(point.flow, point.relief_pressure, point.relief_override, point.relief_rated_flow)
    at_highest = flows_at(highest, openings, point, law)
    if point.relief_override == 0.0 and at_highest.passed >= 0.0:
        return at_highest
    low = minimum(point.load_pressure, point.tank_pressure)
    found = flows_at(inlet_pressure_between(low, highest, openings, point, law), openings, point, law)
    return Instant(found.inlet_pressure, found.load, found.tank, maximum(found.passed, 0.0))


def flows_at(pressure: float, openings: Openings, point: CyclePoint, law: BranchLaw) -> Instant:
    """Branch flows at an inlet pressure, and what of the pump flow they and the leakage leave over [m^3/s].

    pressure  at the inlet, absolute [Pa]
    openings  open fractions of the ports [1]

    Source  ours, docs/models/rotary-valve.md
    """
    load = throttled_flow(pressure, point.load_pressure, openings.load, law)
    tank = throttled_flow(pressure, point.tank_pressure, openings.tank, law)
    leakage = point.pump_leakage * (pressure - point.tank_pressure)
    return Instant(pressure, load, tank, point.flow - leakage - load.flow - tank.flow)


def cycle_means(point: CyclePoint, valve: RotaryValve) -> CycleMeans:
    """Mean flows [m^3/s] and inlet pressure [Pa] over a PWM period, and the averaged spool speed [rad/s], among others.

    Quasi-steady: stiff oil, constant pressures at load and tank, a relief valve without lag. The torque is linear in
    the speed, so its means at two speeds give the balance.

    Source  ours, docs/models/rotary-valve.md
    """
    law, shape = branch_law(point.density, valve, point.vapour_pressure), port_shape(valve)
    k_f = friction_coefficient(point.viscosity, valve)
    load_flow, tank_flow, relief_flow, inlet = 0.0, 0.0, 0.0, 0.0
    at_rest, slowed = 0.0, 0.0
    torque, resistance = np.zeros(ANGLES), np.zeros(ANGLES)
    openings = angle_openings(0, point, shape)
    alike = 1.0  # neighbours with the same openings, as while a port is fully open
    for i in range(1, ANGLES + 1):
        following = angle_openings(i, point, shape)
        if i < ANGLES and following.load == openings.load and following.tank == openings.tank:
            alike += 1.0
            continue
        now = instant(openings, point, law, valve)
        still = spool_torque(now.load, now.tank, openings, EVEN, 0.0, point.density, k_f, valve)
        moving = spool_torque(now.load, now.tank, openings, EVEN, 1.0, point.density, k_f, valve)
        load_flow += alike * now.load.flow
        tank_flow += alike * now.tank.flow
        relief_flow += alike * now.passed
        inlet += alike * now.inlet_pressure
        lost = still.turbine - moving.turbine + moving.friction
        at_rest += alike * still.turbine
        slowed += alike * lost
        torque[i - int(alike) : i] = still.turbine
        resistance[i - int(alike) : i] = lost
        openings, alike = following, 1.0
    balanced = at_rest / slowed
    inertia, stretch = spool_inertia(valve), np.pi / shape.sections / ANGLES
    slowness = balanced * half_period(torque, resistance, inertia, stretch) / (stretch * ANGLES)
    return CycleMeans(
        load_flow=load_flow / ANGLES,
        tank_flow=tank_flow / ANGLES,
        relief_flow=relief_flow / ANGLES,
        inlet_pressure=inlet / ANGLES,
        spool_speed=balanced,
        resistance=slowed / ANGLES,
        slowness=slowness,
    )


def half_period(torque: Array, resistance: Array, inertia: float, stretch: float) -> float:
    """Mean time of the two halves of a period through which the spool turns by these torques [s].

    It begins at the fastest balance of torques, and the first of two turns to and fro is not counted.

    torque      on the spool at rest, at equal stretches of half a period [N m]
    resistance  torque lost per speed there, > 0 [N m s]
    inertia     [kg m^2]
    stretch     [rad]

    Source  ours, docs/rigs.md
    """
    speed = maximum((torque / resistance).max(), CREEP)
    elapsed, n = 0.0, torque.size
    for number in range(4 * n):
        place = number % (2 * n)
        if place >= n:
            place = 2 * n - 1 - place
        speed = speed_after(stretch, speed, torque[place], resistance[place], inertia)
        if number >= 2 * n:
            elapsed += stretch / speed
    return 0.5 * elapsed


def speed_after(stretch: float, speed: float, torque: float, resistance: float, inertia: float) -> float:
    """Speed of the spool at the end of a stretch of angle with a torque tau - b omega [rad/s].

    J (omega^2 - omega_0^2) / 2 = (tau - b omega) stretch

    stretch     of the angle [rad]
    speed       at its start [rad/s]
    torque      on the spool at rest [N m]
    resistance  torque lost per speed, > 0 [N m s]
    inertia     [kg m^2]

    Source  ours, docs/rigs.md
    """
    b = resistance * stretch
    energy = maximum(0.5 * inertia * speed * speed + torque * stretch, 0.0)
    # The root without the difference of two like numbers.
    return maximum(2.0 * energy / (b + np.sqrt(b * b + 2.0 * inertia * energy)), CREEP)


def angle_openings(number: int, point: CyclePoint, shape: PortShape) -> Openings:
    """Open fractions of the ports at one of the equally spaced angles [1].

    number  of the angle, 0 to ANGLES - 1

    Source  ours, docs/models/rotary-valve.md
    """
    angle = np.pi / shape.sections * (number + 0.5) / ANGLES
    return shape_openings(angle, point.duty_ratio * shape.helix_length, shape)


def cycle_step(memory: Nothing, point: CyclePoint, valve: RotaryValve) -> tuple[Nothing, CycleMeans]:
    """`cycle_means` in the form in which a record of points is run through, compiled.

    Source  ours, docs/models/rotary-valve.md
    """
    return memory, cycle_means(point, valve)
