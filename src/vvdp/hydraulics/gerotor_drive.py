"""Axial drive by a gerotor pump: a motor turns it, and the oil that it moves between both ends pushes the spool.

Source  ours, docs/models/axial-drives.md, where a function names no other.
"""

from typing import Annotated, NamedTuple

from vvdp.base.display import value_text
from vvdp.base.kinds import (
    FLOW,
    SIGNED_FRACTION,
    SIGNED_PRESSURE,
    Area,
    Conductance,
    Flow,
    Fraction,
    Mode,
    Position,
    Power,
    Ratio,
    Time,
    ViscousFriction,
)
from vvdp.base.modes import side
from vvdp.base.params import Params
from vvdp.base.rules import refuse, refuse_rows, require_less, require_positive, require_rising
from vvdp.base.select import clip, minimum, select
from vvdp.numerics.piecewise import piecewise_linear

SignedPressure = Annotated[float, SIGNED_PRESSURE]


class GerotorDrive(Params):
    """Spool of end `area` between hard ends, and the pump that moves it with a time constant `lag`.

    What the pump's passages resist is 1/`conductance`; an end that holds the spool lets the pump slip at the same drop.
    """

    area: Area
    lag: Time
    conductance: Conductance
    viscous_friction: ViscousFriction
    lower_end: Position
    upper_end: Position

    def check(self) -> None:
        require_positive(self, "area", "lag", "conductance")
        require_less(self, "lower_end", "upper_end")


class GerotorMap(Params):
    """Flow of a gerotor drive over its command: a dead band either way, then a straight line to the largest flow.

    Backwards the largest flow is `backward_gain` times `largest_flow`.
    """

    largest_flow: Flow
    forward_dead_band: Fraction
    backward_dead_band: Fraction
    backward_gain: Ratio

    def check(self) -> None:
        require_positive(self, "largest_flow")
        require_positive(self, "backward_gain", why="the drive would never come back")
        for band in ("forward_dead_band", "backward_dead_band"):
            if getattr(self, band) >= 1.0:
                refuse(self, band, "must be less than 1, or the drive would never move")


class GerotorBelief(GerotorMap):
    """The map in a controller; a flow demanded below `straight_flow` goes straight through the dead band."""

    straight_flow: Flow

    def check(self) -> None:
        require_positive(self, "straight_flow")
        most = self.largest_flow * min(1.0, self.backward_gain)
        if not self.straight_flow < most:
            refuse(
                self,
                "straight_flow",
                f"must be less than the largest flow in either direction, {value_text(most, FLOW)}",
            )


class GerotorCalibration(Params):
    """Measured rows of command and flow; between them straight lines, beyond them the outermost flows.

    The flow may be constant from row to row, as within the dead band, but never fall.
    """

    commands: Annotated[tuple[float, ...], SIGNED_FRACTION]
    flows: Annotated[tuple[float, ...], FLOW]

    def check(self) -> None:
        if len(self.commands) < 2 or len(self.commands) != len(self.flows):
            refuse_rows(
                self,
                "flows",
                f"{len(self.flows)} rows for {len(self.commands)} commands; expected one for each of at least two",
            )
        require_rising(self, "commands")
        require_rising(self, "flows", strictly=False)


class GerotorState(NamedTuple):
    """Present flow of the pump, and position of the spool."""

    flow: Flow
    position: Position


class GerotorEnds(NamedTuple):
    """Whether the lower and the upper end hold the spool."""

    lower: Mode
    upper: Mode


class GerotorEffort(NamedTuple):
    """Effort to move the spool: pressure difference over the pump, and the power losses."""

    pressure_difference: SignedPressure
    passages: Power
    friction: Power


def gerotor_flow(command: float, characteristic: GerotorMap) -> float:
    """Flow of a gerotor drive that has settled [m^3/s], positive forward.

    Q (u - d)/(1 - d) beyond the dead band d, 0 within it; backwards with its own dead band and gain.

    command  u, held between -1 and 1 [1]

    Source  wang2017, section 4.4 (dead band and saturation)
    """
    d, e = characteristic.forward_dead_band, characteristic.backward_dead_band
    forward = clip((command - d) / (1.0 - d), 0.0, 1.0)
    backward = clip((-command - e) / (1.0 - e), 0.0, 1.0)
    return characteristic.largest_flow * (forward - characteristic.backward_gain * backward)


def gerotor_command(flow: float, belief: GerotorBelief) -> float:
    """Command [1] for a flow, from -1 to 1; inverse of `gerotor_flow` but where the flow is small.

    Below `straight_flow` the command goes in a straight line through zero, so that noise does not jump over the dead
    band.

    flow  demanded, positive forward [m^3/s]
    """
    small = clip(flow / belief.straight_flow, -1.0, 1.0) * belief.straight_flow
    largest_back = belief.backward_gain * belief.largest_flow
    d, e, s = belief.forward_dead_band, belief.backward_dead_band, belief.straight_flow
    forward = d + (1.0 - d) * clip(flow, s, belief.largest_flow) / belief.largest_flow
    backward = e + (1.0 - e) * clip(-flow, s, largest_back) / largest_back
    return select(small >= 0.0, forward, -backward) * abs(small) / s


def calibrated_flow(command: float, calibration: GerotorCalibration) -> float:
    """Flow of a gerotor drive that has settled [m^3/s], from measured rows.

    command  held between the outermost rows [1]
    """
    return piecewise_linear(command, calibration.commands, calibration.flows)


def calibrated_command(flow: float, calibration: GerotorCalibration) -> float:
    """Command [1] for a flow, from measured rows; 0 for none, and where several give it that at the end of their range.

    flow  demanded, positive forward, held between the outermost rows [m^3/s]
    """
    commands, flows = calibration.commands, calibration.flows
    command = commands[0]
    for i in range(len(flows) - 1):
        rise = flows[i + 1] - flows[i]
        passed = select(flow > flows[i], 1.0, 0.0)
        share = select(rise > 0.0, clip((flow - flows[i]) / select(rise > 0.0, rise, 1.0), 0.0, 1.0), passed)
        command = command + (commands[i + 1] - commands[i]) * share
    return select(flow == 0.0, 0.0, command)


def gerotor_rate(
    settled_flow: float, state: GerotorState, at_lower: float, at_upper: float, drive: GerotorDrive
) -> GerotorState:
    """Rates of the flow [m^3/s^2] and of the position [m/s]: (settled - Q)/lag, and Q/A while no end holds the spool.

    settled_flow        in the steady state of the command [m^3/s]
    at_lower, at_upper  1 while that end holds the spool, else 0

    Source  wang2017, eq. 4.17; lag and ends: ours, docs/models/axial-drives.md
    """
    free = 1.0 - at_lower - at_upper
    return GerotorState((settled_flow - state.flow) / drive.lag, free * state.flow / drive.area)


def gerotor_ends(state: GerotorState, at_lower: float, at_upper: float, drive: GerotorDrive) -> GerotorEnds:
    """Whether an end holds the spool, from when it comes there until the flow turns round [1]; `base.modes.side`.

    at_lower, at_upper  as in `gerotor_rate`
    """
    travel = drive.upper_end - drive.lower_end
    outward = state.flow * drive.lag / (drive.area * travel)
    above, below = (state.position - drive.upper_end) / travel, (drive.lower_end - state.position) / travel
    return GerotorEnds(
        side(select(at_lower > 0.5, -outward, minimum(-outward, below))),
        side(select(at_upper > 0.5, outward, minimum(outward, above))),
    )


def gerotor_effort(flow: float, velocity: float, drive: GerotorDrive) -> GerotorEffort:
    """Drop over the pump [Pa] and powers [W] that a flow takes: Q/G + b v/A, Q^2/G in the passages and b v^2.

    flow      Q of the pump [m^3/s]
    velocity  v of the spool; 0 while an end holds it [m/s]
    """
    friction = drive.viscous_friction * velocity
    return GerotorEffort(
        flow / drive.conductance + friction / drive.area, flow * flow / drive.conductance, friction * velocity
    )


def spool_velocity(flow: float, at_lower: float, at_upper: float, drive: GerotorDrive) -> float:
    """Velocity of the spool [m/s], Q/A while no end holds it."""
    return (1.0 - at_lower - at_upper) * flow / drive.area
