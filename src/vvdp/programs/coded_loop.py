"""Position loop of a cylinder whose pump is metered by a digital flow control unit: on/off valves in parallel.

Source  wang2017, section 1.2.1
"""

from typing import NamedTuple

import numpy as np

from vvdp.base.kinds import Count, Flow, Force, Fraction, Position, Pressure, PressureDifference, SignedFraction
from vvdp.base.params import Params
from vvdp.base.rules import require_positive
from vvdp.network.program import ProgramType
from vvdp.programs.generic import GenericProgram
from vvdp.programs.position_loop import CylinderReading, LoopMemory, PositionLoop, loop_start, one_way_step
from vvdp.programs.position_loops import RoundReport, ValveLoop, position_loop

LEAST_DROP = 1e5
"""Drop over a unit below which its loop calculates with this one [Pa]."""


class CodedLoop(Params):
    """A position loop that opens a unit by codes up to `highest_code`, from a pump that it takes to be at a pressure.

    The smallest valve of the unit passes `rated_flow` at `rated_drop`.
    """

    loop: PositionLoop
    rated_flow: Flow
    rated_drop: PressureDifference
    highest_code: Count
    pump_pressure: Pressure


class CodedCommand(NamedTuple):
    """Commands: the unit's code, the directional valve, the meter-out throttle; `reference` is given for the record,
    and `force` is that of the duty cycle on the rod."""

    code: Count
    valve: SignedFraction
    opening: Fraction
    reference: Position
    force: Force


def coded_step(
    t: float, memory: LoopMemory, seen: CylinderReading, settings: CodedLoop
) -> tuple[LoopMemory, CodedCommand]:
    """Position loop of a cylinder behind a digital flow control unit: the code whose flow is closest to the demand, a
    directional valve for the sign, a meter-out throttle."""
    kept, command = one_way_step(t, memory, seen, settings.loop)
    drop = max(settings.pump_pressure - kept.pressures.supply, LEAST_DROP)
    unit = settings.rated_flow * np.sqrt(drop / settings.rated_drop)
    code = min(float(np.floor(command.flow / unit + 0.5)), settings.highest_code)
    coded = CodedCommand(
        code=code, valve=command.valve, opening=command.opening, reference=command.reference, force=command.force
    )
    return kept, coded


def coded_start(settings: CodedLoop) -> LoopMemory:
    """The memory before the first sample: at rest at the beginning of the cycle."""
    return loop_start(settings.loop)


class CodedTable(ValveLoop):
    """As `ValveLoop`, with a unit whose smallest valve passes `rated_flow` at `rated_drop`, and the pressure of what
    feeds it."""

    rated_flow: Flow
    rated_drop: PressureDifference
    highest_code: Count
    pump_pressure: Pressure

    def check(self) -> None:
        require_positive(self, "rated_flow", "rated_drop")


def coded_loop(table: CodedTable) -> CodedLoop:
    """The settings of the loop as its step takes them. Raises ParameterError for a cycle that it cannot follow."""
    return CodedLoop(
        loop=position_loop(table),
        rated_flow=table.rated_flow,
        rated_drop=table.rated_drop,
        highest_code=table.highest_code,
        pump_pressure=table.pump_pressure,
    )


CODED_POSITION_LOOP = GenericProgram(
    ProgramType(
        coded_step,
        CylinderReading,
        CodedCommand(code=0.0, valve=0.0, opening=0.0, reference=0.0, force=0.0),
        CodedTable,
        coded_start,
        report=RoundReport,
    ),
    made=coded_loop,
)
