"""How well the machine does what it should, added up from the truth, which its control never sees.

Source  ours, docs/models/displacement-control.md
"""

from typing import NamedTuple

import numpy as np

from vvdp.base.conservation import NOTHING
from vvdp.base.kinds import Angle, Count, Fraction, Position, Pressure, Ratio, SignedFraction, Time
from vvdp.base.params import Params
from vvdp.control.pressure_modes import PressureMode
from vvdp.machines.machine_control import SAMPLE_PERIOD, MachinePaths
from vvdp.machines.machine_loop import PROGRAM
from vvdp.machines.stages import CONTROL
from vvdp.network.network import Network
from vvdp.network.program import ProgramType
from vvdp.programs.tracking import Actuated, Followed, Tracking, tracking_start, tracking_step

TALLY = "tally"
"""Name of the program that adds up."""


class MachineTruth(NamedTuple):
    """How cylinder and line truly are at a sample, and what the control has just made of it."""

    time: Time
    position: Position
    pressure_a: Pressure
    pressure_b: Pressure
    line_pressure: Pressure
    phase: Count
    reference: Position
    direction: SignedFraction
    opening: Fraction
    mode: PressureMode
    saturated: Fraction
    map_gain: Ratio
    spool_angle: Angle


class TallySettings(Params):
    """Against which pressure a chamber counts as drawn empty."""

    tank_pressure: Pressure


class MachineTally(NamedTuple):
    """Results of the tracking; between which pressures line and chambers were at samples of control; how far
    the spool has turned in what time; the last gain of the flow map."""

    tracking: Tracking
    lowest: Pressure
    highest: Pressure
    map_gain: Ratio
    spool_angle: Angle
    turned: Angle
    time: Time


def tally_start(settings: TallySettings) -> MachineTally:
    """Nothing added up yet."""
    return MachineTally(
        tracking=tracking_start(), lowest=np.inf, highest=0.0, map_gain=1.0, spool_angle=0.0, turned=0.0, time=0.0
    )


def tally_step(
    t: float, memory: MachineTally, truth: MachineTruth, settings: TallySettings
) -> tuple[MachineTally, object]:
    """Add a sample under control."""
    if truth.phase != CONTROL:
        return memory, NOTHING
    low, high = min(truth.pressure_a, truth.pressure_b), max(truth.pressure_a, truth.pressure_b)
    time = t - min(memory.tracking.begin, t)
    followed = Followed(t, truth.position - truth.reference, low - settings.tank_pressure)
    done = Actuated(truth.direction, truth.opening, truth.mode, truth.saturated)
    return MachineTally(
        tracking=tracking_step(memory.tracking, followed, done),
        lowest=min(memory.lowest, low, truth.line_pressure),
        highest=max(memory.highest, high, truth.line_pressure),
        map_gain=truth.map_gain,
        spool_angle=truth.spool_angle,
        turned=memory.turned + (truth.spool_angle - memory.spool_angle if time > 0.0 else 0.0),
        time=time,
    ), NOTHING


def add_machine_tally(net: Network, paths: MachinePaths, tank_pressure: float) -> None:
    """Add the program that adds up, after those of the control.  tank_pressure: absolute [Pa]."""
    reads = {
        "time": "t",
        "position": paths.position,
        "pressure_a": paths.pressure_a,
        "pressure_b": paths.pressure_b,
        "line_pressure": paths.line_pressure,
        "spool_angle": f"{paths.spool}.angle",
    }
    shown = [name for name in MachineTruth._fields if name not in reads]
    kind = ProgramType(tally_step, MachineTruth, NOTHING, TallySettings, tally_start)
    settings = TallySettings(tank_pressure=tank_pressure)
    net.program(TALLY, kind, settings, reads=reads | {n: f"{PROGRAM}.{n}" for n in shown}, period=SAMPLE_PERIOD)
