"""The phases of the whole machine: from rest to control, and back to rest.

Source  ours, docs/models/displacement-control.md
"""

from typing import NamedTuple

from vvdp.base.kinds import Count, Flow, Fraction, Length, Pressure, PressureDifference, Time
from vvdp.base.params import Params
from vvdp.base.rules import refuse, require_positive

HOME, SPIN, LEARN, PRECHARGE, CONTROL, HOLD, RETURN, REST, EMERGENCY = (float(number) for number in range(9))
"""Phases: the spool goes to its stop; the pump turns it until its angle is known; the periodic sensor error is
learned at the stop; the line is charged; the cylinder follows its reference; it holds the last one; the spool
returns to its stop; all is off; the machine is de-energised for good."""

PHASES = ("home", "spin", "learn", "precharge", "control", "hold", "return", "rest", "emergency")
"""Names of the phases, in the order of their numbers."""

NEVER = 1e6
"""A time that no run reaches [s]."""


class MachineSequence(Params):
    """The [machine_sequence] table: what starts and stops the machine.

    It is charged with `precharge_flow` until the line is within `precharge_margin` of the first supply chamber. A stop
    at `stop_time` holds the reference for `hold_time` before the directional valve closes. An emergency stop at
    `emergency_time` de-energises everything at once. The spool counts as returned within `return_tolerance` of its
    stop.
    """

    precharge_flow: Flow
    precharge_margin: PressureDifference
    hold_time: Time
    return_tolerance: Length
    stop_time: Time = NEVER
    emergency_time: Time = NEVER

    def check(self) -> None:
        require_positive(self, "return_tolerance")
        if self.precharge_flow < 0.0:
            refuse(self, "precharge_flow", "must be at least 0")


class Phase(NamedTuple):
    """Phase of the machine, and the time of its begin."""

    number: Count
    since: Time


class Progress(NamedTuple):
    """Measured values and flags that can end a phase.

    homed          1 once the spool has rested at its stop
    known          1 while the spool's angle is known
    learned        1 once the periodic sensor error is learned
    line_pressure  [Pa]
    supply         pressure of the chamber that is filled first [Pa]
    above_stop     of the spool, as estimated [m]
    """

    homed: Fraction
    known: Fraction
    learned: Fraction
    line_pressure: Pressure
    supply: Pressure
    above_stop: Length


class Orders(NamedTuple):
    """Drives that a phase has switched on: `pump` and axial drive `energised`, and whether the cylinder is
    `controlled`."""

    pump: Fraction
    energised: Fraction
    controlled: Fraction


def first_phase() -> Phase:
    """The phase at the start."""
    return Phase(HOME, 0.0)


def next_phase(phase: Phase, time: float, progress: Progress, sequence: MachineSequence) -> Phase:
    """The phase at a sample; phases that have nothing to do are passed at once.

    time      of the sample [s]
    progress  measured values and flags of the machine
    """
    number, since = phase.number, phase.since
    if time >= sequence.emergency_time or number == EMERGENCY:
        return Phase(EMERGENCY, since if number == EMERGENCY else time)
    if time >= sequence.stop_time and number <= CONTROL:
        return Phase(HOLD if number == CONTROL else RETURN, time)
    number = (
        _after_start(number, progress, sequence) if number < CONTROL else _after_stop(phase, time, progress, sequence)
    )
    return Phase(number, since if number == phase.number else time)


def _after_start(number: float, progress: Progress, sequence: MachineSequence) -> float:
    if number == HOME and progress.homed > 0.0:
        number = SPIN
    if number == SPIN and progress.known > 0.0:
        number = LEARN
    if number == LEARN and progress.learned > 0.0:
        number = PRECHARGE
    is_charged = progress.line_pressure >= progress.supply - sequence.precharge_margin
    if number == PRECHARGE and (is_charged or sequence.precharge_flow == 0.0):
        number = CONTROL
    return number


def _after_stop(phase: Phase, time: float, progress: Progress, sequence: MachineSequence) -> float:
    number = phase.number
    if number == HOLD and time - phase.since >= sequence.hold_time:
        number = RETURN
    if number == RETURN and progress.above_stop <= sequence.return_tolerance:
        number = REST
    return number


def orders_of(number: float) -> Orders:
    """Drives that a phase has switched on.

    number  of the phase
    """
    pump = 1.0 if SPIN <= number <= RETURN else 0.0
    energised = 0.0 if number == EMERGENCY else 1.0
    return Orders(pump, energised, 1.0 if number in (CONTROL, HOLD) else 0.0)
