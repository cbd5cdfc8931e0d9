"""Which command gives a wanted flow of the gerotor drive: its calibration, read backwards.

A drive with a dead band has no inverse there. Between the smallest flows that are believed, one either way, the command
goes in straight lines through zero: a reference at rest then leaves the command within the dead band.

Source  ours, docs/models/passivity-control.md, where a function names no other.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from vvdp.base.errors import ParameterError


@dataclass(frozen=True)
class Calibration:
    """Points of a static map, by increasing command [1]; `flows` [m^3/s] increase as well.

    Raises `ParameterError` where they do not, with the row.
    """

    commands: tuple[float, ...]
    flows: tuple[float, ...]

    def __post_init__(self) -> None:
        if len(self.commands) != len(self.flows) or len(self.commands) < 2:
            raise ParameterError(
                f"a calibration of {len(self.commands)} commands and {len(self.flows)} flows; "
                "expected as many of both, at least 2"
            )
        _refuse_falling(self.commands, self.flows, level=False)


def calibrated_command(flow: float, calibration: Calibration) -> float:
    """The command [1] that gives a flow, in straight lines between the points; beyond them, that of the last one.

    flow  wanted [m^3/s]
    """
    flows, commands = calibration.flows, calibration.commands
    if flow <= flows[0]:
        return commands[0]
    for i in range(1, len(flows)):
        if flow <= flows[i]:
            share = (flow - flows[i - 1]) / (flows[i] - flows[i - 1])
            return commands[i - 1] + share * (commands[i] - commands[i - 1])
    return commands[-1]


def measured_calibration(commands: Sequence[float], flows: Sequence[float], least_flow: float) -> Calibration:
    """The calibration of a measured table; rows below `least_flow` either way give way to a line through zero.

    Raises `ParameterError` with the row, counted from 1, where commands do not increase or flows fall, and where the
    table does not reach `least_flow` both ways.
    """
    if len(commands) != len(flows):
        raise ParameterError(f"a calibration of {len(commands)} commands and {len(flows)} flows; expected as many")
    _refuse_falling(commands, flows, level=True)
    rows = [(c, q) for c, q in zip(commands, flows, strict=True) if abs(q) >= least_flow > 0.0]
    if not rows or not (rows[0][1] < 0.0 < rows[-1][1]):
        raise ParameterError(
            f"a calibration with least_flow {least_flow:g} m^3/s; expected one above 0 that the flows, "
            f"{min(flows, default=0.0):g} to {max(flows, default=0.0):g} m^3/s, reach both ways"
        )
    kept = [*(row for row in rows if row[1] < 0.0), (0.0, 0.0), *(row for row in rows if row[1] > 0.0)]
    return Calibration(tuple(float(c) for c, _ in kept), tuple(float(q) for _, q in kept))


def dead_band_calibration(
    full_flows: tuple[float, float], dead_bands: tuple[float, float], least_flow: float
) -> Calibration:
    """The calibration of a drive with a dead band, straight beyond it.

    full_flows  at the commands -1 and 1 [m^3/s]
    dead_bands  the commands at which it begins to deliver, backward and forward [1]
    least_flow  below which the command goes through zero in a straight line [m^3/s]

    Raises `ParameterError` as `measured_calibration` does.
    """
    commands, flows = [], []
    for end, full, dead in zip((-1.0, 1.0), full_flows, dead_bands, strict=True):
        commands += [end, dead + (end - dead) * end * least_flow / full]
        flows += [full, end * least_flow]
    order = (0, 1, 3, 2)
    return measured_calibration([commands[i] for i in order], [flows[i] for i in order], least_flow)


def _refuse_falling(commands: Sequence[float], flows: Sequence[float], *, level: bool) -> None:
    """Refuse commands that do not increase, and flows that fall; or stay `level`, where that is not allowed."""
    for row in range(1, len(commands)):
        if not commands[row] > commands[row - 1]:
            raise ParameterError(
                f"row {row + 1} of a calibration: command {commands[row]:g} does not exceed {commands[row - 1]:g}"
            )
        if not (flows[row] > flows[row - 1] or (level and flows[row] == flows[row - 1])):
            raise ParameterError(
                f"row {row + 1} of a calibration: at command {commands[row]:g} the flow is {flows[row]:g} m^3/s, "
                f"{flows[row - 1]:g} m^3/s in the row before; a map that is not monotone has no inverse"
            )
