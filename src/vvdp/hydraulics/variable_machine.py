"""Pump or motor of variable displacement, overcentre, with losses that are linear in speed and pressure.

Source  ours, docs/models/components.md, where a function names no other.
"""

from typing import NamedTuple

from vvdp.base.kinds import Fraction, Rate, SignedFraction, Time
from vvdp.base.modes import between
from vvdp.base.params import require_positive
from vvdp.base.select import clip
from vvdp.fluid.mixture import FluidState
from vvdp.hydraulics.friction import smooth_sign
from vvdp.hydraulics.motor import Motor


class VariableMachine(Motor):
    """A machine whose displacement is `displacement` times its setting, -1 to 1.

    The setting follows what is asked of it with the time constant `response_time`, never faster than `largest_rate`.
    Of the torque at full displacement, the share `pressure_friction` is lost.
    """

    pressure_friction: Fraction = 0.0
    response_time: Time
    largest_rate: Rate
    initial_setting: SignedFraction = 0.0

    def check(self) -> None:
        super().check()
        require_positive(self, "response_time", "largest_rate")


class SettingState(NamedTuple):
    """Displacement over its largest value, negative overcentre."""

    setting: SignedFraction


def _wanted_rate(wanted: float, setting: float, machine: VariableMachine) -> float:
    return (clip(wanted, -1.0, 1.0) - setting) / machine.response_time


def setting_rate(wanted: float, setting: float, machine: VariableMachine) -> float:
    """Rate of the setting [1/s]: (s_wanted - s)/T, held within the largest rate either way.

    wanted, setting  s_wanted, held between -1 and 1, and s [1]
    """
    rate: float = clip(_wanted_rate(wanted, setting, machine), -machine.largest_rate, machine.largest_rate)
    return rate


def setting_side(wanted: float, setting: float, machine: VariableMachine) -> float:
    """Whether a setting moves at its largest rate, either way, or below it [1]; see `base.modes.between`.

    wanted, setting  as in `setting_rate`
    """
    return between(0.5 + 0.5 * _wanted_rate(wanted, setting, machine) / machine.largest_rate)


def pressure_friction_torque(shaft_speed: float, a: FluidState, b: FluidState, machine: VariableMachine) -> float:
    """Friction that grows with the pressure [N m], against the speed: c_p D |P_a - P_b| sign(omega), made smooth.

    shaft_speed  omega [rad/s]
    a, b         oil at both ports
    """
    size = machine.pressure_friction * machine.displacement * abs(a.pressure - b.pressure)
    return size * smooth_sign(shaft_speed, machine.coulomb_speed)
