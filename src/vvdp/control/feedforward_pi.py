"""Feedforward and PI for the gerotor drive, whose flow moves the spool: x' = Q/A_s.

The integral of the position error is a known signal and lives here: as a state of an observer it could not be seen.

Source  ours, docs/models/passivity-control.md, where a function names no other.
"""

from typing import Annotated, NamedTuple

from vvdp.base.kinds import Area, Flow, Kind
from vvdp.base.params import Params
from vvdp.base.rules import field_text, refuse_together, require_positive
from vvdp.base.select import clip
from vvdp.control.reference import Rate, Reference

SQUARE_RATE = Kind("square of a rate", "1/s^2", 0.0, 1e12, "90 1/s^2", units=("1/s^2",))
POSITION_TIME = Kind("position over time", "m*s", -1e6, 1e6, "1 m*s", scale=1e-4)

SquareRate = Annotated[float, SQUARE_RATE]
PositionTime = Annotated[float, POSITION_TIME]


class FeedforwardPI(Params):
    """Gains over the `area` A_s that the flow moves: K_p/A_s and K_i/A_s; the drive delivers within the two flows.

    Raises `ParameterError` for an area or a proportional rate of zero, or where the flows do not include zero.
    """

    area: Area
    proportional_rate: Rate
    integral_rate: SquareRate
    lowest_flow: Flow
    highest_flow: Flow

    def check(self) -> None:
        require_positive(self, "area", "proportional_rate")
        if not self.lowest_flow < 0.0 < self.highest_flow:
            low, high = field_text(self, "lowest_flow"), field_text(self, "highest_flow")
            refuse_together(
                self, f"lowest_flow, {low}, must be less than 0 and highest_flow, {high}, greater: both directions"
            )


class PIMemory(NamedTuple):
    """The integral of the position error."""

    integral: PositionTime


def pi_start() -> PIMemory:
    """The memory before the first sample."""
    return PIMemory(0.0)


def pi_step(
    memory: PIMemory, reference: Reference, position: float, interval: float, settings: FeedforwardPI
) -> tuple[PIMemory, float]:
    """The new memory and the demanded flow [m^3/s], to be held over the sample: A_s (r' + K_p/A_s e + K_i/A_s e_i).

    The integral stands still while the flow is at a limit and the error would drive it further beyond.

    reference  of this sample
    position   as estimated [m]
    interval   since the last sample, 0 at the first [s]

    Source  wang2017, eqs. 4.17 and 4.18, corrected (docs/errata.md)
    """
    error = reference.position - position
    grown = memory.integral + error * interval
    rate = reference.velocity + settings.proportional_rate * error
    flow = settings.area * (rate + settings.integral_rate * grown)
    if (flow > settings.highest_flow and error > 0.0) or (flow < settings.lowest_flow and error < 0.0):
        grown = memory.integral
        flow = settings.area * (rate + settings.integral_rate * grown)
    return PIMemory(grown), clip(flow, settings.lowest_flow, settings.highest_flow)
