"""Piston pump whose pistons deliver or idle one by one: a valve of each piston decides at every stroke.

A piston at its bottom dead centre closes its inlet valve and delivers, or leaves it open and gives its oil back to the
inlet. Outlet valves are check valves, so an idle piston stands at the pressure of the inlet.

Source  ours, docs/models/components.md, where a function names no other.
"""

import math
from typing import NamedTuple

import numpy as np

from vvdp.base.kinds import Count, Energy, FlowCoefficient, Fraction, Ratio
from vvdp.base.rules import refuse, require_positive
from vvdp.base.select import maximum
from vvdp.hydraulics.pump import Pump

MOST_PISTONS = 100.0
"""Half of them are remembered as the bits of a number."""


class DigitalPump(Pump):
    """A pump of an even number of `pistons`, which it has instead of a ripple; its values are those with all enabled.

    `valve_conductance` is that of the inlet valve of a piston, `valve_energy` what closing it takes.
    """

    pistons: Count
    valve_conductance: FlowCoefficient
    valve_energy: Energy

    def check(self) -> None:
        require_positive(self, "displacement", "valve_conductance")
        if not 2.0 <= self.pistons <= MOST_PISTONS or self.pistons % 2.0 != 0.0:
            refuse(self, "pistons", f"must be an even number from 2 to {MOST_PISTONS:g}")
        if self.ripple_amplitude != 0.0:
            refuse(self, "ripple_amplitude", "must be 0: its pistons make the ripple")


class EnabledPistons(NamedTuple):
    """Enabled pistons: the sums of cosine and sine of the shaft angles at which they began, their share of all pistons
    in their delivery stroke, and 1 if the last one to begin is among them."""

    cosine: Ratio
    sine: Ratio
    enabled: Fraction
    actuated: Fraction


def stroke_share(shaft_angle: float, cosine: float, sine: float, pump: DigitalPump) -> float:
    """Flow of the enabled pistons over the mean flow of all [1]: (pi/N) sum of sin(theta - theta_k), not below 0.

    A piston that begins at theta_k moves V/2 (1 - cos(theta - theta_k)), V = 2 pi D/N; the sine of a difference gives
    the sum as sin(theta) C - cos(theta) S.

    shaft_angle   theta [rad]
    cosine, sine  C and S, sums over the enabled pistons in their delivery stroke [1]

    >>> pump = DigitalPump(displacement=3e-6, leakage_conductance=0.0, friction_torque=0.0, pistons=2.0,
    ...     valve_conductance=1e-6, valve_energy=0.0)
    >>> print(round(stroke_share(1.570796327, 1.0, 0.0, pump), 4))  # pi/2 in the middle of its stroke
    1.5708
    """
    found: float = maximum(math.pi / pump.pistons * (np.sin(shaft_angle) * cosine - np.cos(shaft_angle) * sine), 0.0)
    return found


def breathing_torque(shaft_speed: float, enabled: float, pump: DigitalPump) -> float:
    """Size of the mean torque that pushes oil through the inlet valves [N m]: N (2 - e) V^3 omega^2/(12 pi K^2).

    A stroke at the flow V/2 omega sin(phi) loses the integral of (q/K)^2 q over its time,
    (4/3)(V/2)^3 omega^2/K^2. All N pistons take oil in once in a revolution, and those that idle give it back.

    shaft_speed  omega, either way [rad/s]
    enabled      e, share of the pistons that deliver [1]

    >>> pump = DigitalPump(displacement=3e-6, leakage_conductance=0.0, friction_torque=0.0, pistons=2.0,
    ...     valve_conductance=1e-6, valve_energy=0.0)
    >>> print(round(breathing_torque(100.0, 0.5, pump), 4))  # V = 9.4248e-6: 2 1.5 8.3717e-16 1e4/(12 pi 1e-12)
    0.6662
    """
    V = 2.0 * math.pi * pump.displacement / pump.pistons
    loss: float = (2.0 - enabled) * V**3 * shaft_speed**2 / (6.0 * pump.valve_conductance**2)
    return pump.pistons * loss / (2.0 * math.pi)


def actuation_power(shaft_speed: float, actuated: float, pump: DigitalPump) -> float:
    """Mean power of the inlet valves between two pistons [W]: N |omega|/(2 pi) E for one that is closed, else 0.

    shaft_speed  omega [rad/s]
    actuated     1 if the last piston that came to its bottom dead centre was enabled
    """
    return actuated * pump.valve_energy * pump.pistons * abs(shaft_speed) / (2.0 * math.pi)


def decision_period(pistons: float, shaft_speed: float) -> float:
    """Time between two pistons at their bottom dead centre [s]: 2 pi/(N omega).

    pistons      N [1]
    shaft_speed  omega [rad/s]

    >>> round(decision_period(12.0, 60.0 * math.pi), 9)  # 360 in a second
    0.002777778
    """
    return 2.0 * math.pi / (pistons * shaft_speed)
