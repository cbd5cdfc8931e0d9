"""An ideal axial drive: the spool follows the commanded position with a lag, whatever force this needs.

Source  ours, docs/models/whole-machine.md, where a function names no other.
"""

from typing import NamedTuple

from vvdp.base.kinds import Position, Time
from vvdp.base.params import Params
from vvdp.base.rules import require_positive
from vvdp.network.component import Component


class LaggingDrive(Params):
    """`lag` is the time constant with which the position follows."""

    lag: Time

    def check(self) -> None:
        require_positive(self, "lag")


class LaggingState(NamedTuple):
    """The spool's position."""

    position: Position


class LaggingMotion(NamedTuple):
    """The rate of the position."""

    rates: LaggingState


def lagging_drive(wanted: Position, state: LaggingState, values: LaggingDrive) -> LaggingMotion:
    """A drive whose position follows the `wanted` one: x' = (x_w - x)/tau."""
    return LaggingMotion(LaggingState((wanted - state.position) / values.lag))


LAGGING_DRIVE = Component(lagging_drive, symbol="electric_motor")
