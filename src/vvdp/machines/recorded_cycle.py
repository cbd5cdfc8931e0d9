"""A cycle for a cylinder out of a log: the course of a recorded position."""

from pathlib import Path

import numpy as np

from vvdp.base.errors import ConfigError, Fault, ParameterError, unusable
from vvdp.base.kinds import POSITION
from vvdp.base.units import line_to_si
from vvdp.logs.source import open_log
from vvdp.programs.machine.cycle import OwnCycle
from vvdp.systems.changed import with_tables
from vvdp.systems.system import System

CHANNEL = "position"
"""Channel that is read unless another is named."""
SAMPLES = 100_000
MOST = 200_000
"""Rows that a cycle may have."""


def recorded_cycle(path: Path, channel: str = CHANNEL) -> OwnCycle:
    """The cycle that a channel of a log goes through, from its first sample on.

    channel  of positions, in m where the log names no unit

    Raises ConfigError, with the row of the channel, for a log that cannot be read, times that do not rise and samples
    that are missing.
    """
    with open_log(path) as log:
        name = log.channel(channel).name
        if any(each.name == f"{name} #2" for each in log.channels()):
            raise unusable(path, f"has several columns {name!r}; leave one")
        unit = log.channel(channel).unit or "m"
        parts = [portion[name] for portion in log.portions([name], SAMPLES)]
    times, values = (np.concatenate([getattr(part, each) for part in parts]) for each in ("times", "values"))
    if not 2 <= times.size <= MOST:
        raise unusable(path, f"{times.size} samples of {name!r}; expected 2 to {MOST}")
    if lost := np.flatnonzero(~np.isfinite(values)).tolist():
        raise unusable(path, f"row {lost[0] + 1}: no {name}; expected a number in each row")
    try:
        slope, offset = line_to_si(unit, POSITION)
        positions = slope * values + offset
        return OwnCycle(times=tuple(map(float, times - times[0])), positions=tuple(map(float, positions)))
    except ParameterError as problem:
        raise ConfigError([Fault(str(path), 0, "", str(problem))]) from None


def with_cycle(system: System, path: Path, channel: str = CHANNEL) -> System:
    """The system with the cycle of a log instead of its own, its rod at first where that begins.

    Raises ConfigError where the system follows no cycle, or cannot follow this one.
    """
    content = system.table.content
    if "cycle" not in content or "cylinder_position" not in content.get("initial", {}):
        raise unusable(path, f"{system.name} has no cylinder that follows a cycle; displacement-control has one")
    cycle = recorded_cycle(path, channel)
    own = {
        "times": [f"{time!r} s" for time in cycle.times],
        "positions": [f"{position!r} m" for position in cycle.positions],
    }
    start = {**content["initial"], "cylinder_position": f"{cycle.positions[0]!r} m"}
    return with_tables(system, {"cycle": own, "initial": start})
