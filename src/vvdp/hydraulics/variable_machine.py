"""Pump or motor of variable displacement, overcentre: how its setting follows, and which losses it has.

Source  ours, docs/models/components.md, where a function names no other.
"""

from typing import NamedTuple

import numpy as np

from vvdp.base.kinds import Fraction, Rate, Ratio, SignedFraction, Time
from vvdp.base.modes import between
from vvdp.base.params import Params
from vvdp.base.rules import require_positive
from vvdp.base.select import clip
from vvdp.hydraulics.flow import signed_root
from vvdp.hydraulics.friction import shaft_friction_torque, smooth_sign
from vvdp.hydraulics.motor import Motor
from vvdp.hydraulics.ports import Medium

SLIP_TRANSITION = 1e5
"""Drop below about which turbulent slip turns to a straight line [Pa]; assumed."""


class SettingDrive(Params):
    """Actuation of a displacement: it follows its command with the time constant `response_time`.

    It does so never faster than `largest_rate`.
    """

    response_time: Time
    largest_rate: Rate
    initial_setting: SignedFraction = 0.0

    def check(self) -> None:
        require_positive(self, "response_time", "largest_rate")


class VariableMachine(Motor, SettingDrive):
    """A machine whose displacement is `displacement` times its setting, -1 to 1.

    Of the torque at full displacement, the share `pressure_friction` is lost. The losses of Wilson and Schloesser come
    on top, by their numbers without unit: `laminar_slip`, `turbulent_slip`, `viscous_drag` and `kinetic_drag`, with
    `setting_drag` as the part of the last that is in proportion to the setting.
    """

    pressure_friction: Fraction = 0.0
    laminar_slip: Ratio = 0.0
    turbulent_slip: Ratio = 0.0
    viscous_drag: Ratio = 0.0
    kinetic_drag: Ratio = 0.0
    setting_drag: Ratio = 0.0


class SettingState(NamedTuple):
    """Displacement over its largest value, negative overcentre."""

    setting: SignedFraction


def _wanted_rate(wanted: float, setting: float, drive: SettingDrive) -> float:
    return (clip(wanted, -1.0, 1.0) - setting) / drive.response_time


def setting_rate(wanted: float, setting: float, drive: SettingDrive) -> float:
    """Rate of the setting [1/s]: (s_wanted - s)/T, held within the largest rate either way.

    wanted, setting  s_wanted, held between -1 and 1, and s [1]
    """
    rate: float = clip(_wanted_rate(wanted, setting, drive), -drive.largest_rate, drive.largest_rate)
    return rate


def setting_side(wanted: float, setting: float, drive: SettingDrive) -> float:
    """Whether a setting moves at its largest rate, either way, or below it [1]; see `base.modes.between`.

    wanted, setting  as in `setting_rate`
    """
    return between(0.5 + 0.5 * _wanted_rate(wanted, setting, drive) / drive.largest_rate)


def slip_flow(pressure_drop: float, medium: Medium, machine: VariableMachine) -> float:
    """Flow that leaks from the higher to the lower side [m^3/s], at the higher pressure and signed like the drop.

    (G + C_s D/mu) dp + C_st D^(2/3) root(2 dp/rho), whatever the setting

    pressure_drop  dp [Pa]

    Source  wilson1949 (laminar slip), schloesser1961 (turbulent slip)

    >>> machine = VariableMachine(displacement=1e-5, leakage_conductance=0.0, shaft_damping=0.0, coulomb_torque=0.0,
    ...     coulomb_speed=1.0, inertia=0.01, response_time=0.1, largest_rate=5.0, laminar_slip=3e-9)
    >>> print(round(slip_flow(2e7, Medium(density=870.0, viscosity=0.03), machine), 12))  # 3e-9 1e-5 2e7/0.03
    2e-05
    """
    D = machine.displacement
    laminar = machine.leakage_conductance * pressure_drop + machine.laminar_slip * D / medium.viscosity * pressure_drop
    root = signed_root(pressure_drop, SLIP_TRANSITION) * np.sqrt(2.0 / medium.density)
    flow: float = laminar + machine.turbulent_slip * D ** (2.0 / 3.0) * root
    return flow


def drag_torque(
    shaft_speed: float, pressure_drop: float, setting: float, medium: Medium, machine: VariableMachine
) -> float:
    """Torque against the speed [N m].

    (b + C_v mu D) omega + (T_c + C_p D |dp|) sign(omega) + (C_h + C_s |s|) rho D^(5/3) omega |omega|, the sign smooth

    shaft_speed    omega [rad/s]
    pressure_drop  dp between the ports [Pa]
    setting        s, either way [1]

    Source  wilson1949 (viscous drag, friction of pressure), schloesser1961 (kinetic drag), pourmovahed1992 (that of the
            setting)
    """
    D = machine.displacement
    pressing = machine.pressure_friction * D * abs(pressure_drop) * smooth_sign(shaft_speed, machine.coulomb_speed)
    viscous = machine.viscous_drag * medium.viscosity * D * shaft_speed
    stirring = machine.kinetic_drag + machine.setting_drag * abs(setting)
    kinetic = stirring * medium.density * D ** (5.0 / 3.0) * shaft_speed * abs(shaft_speed)
    torque: float = shaft_friction_torque(shaft_speed, machine) + pressing + viscous + kinetic
    return torque
