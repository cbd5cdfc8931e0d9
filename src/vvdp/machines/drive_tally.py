"""Results of a controlled chamber drive, added up sample by sample while it runs: no record is needed.

Source  ours, docs/models/axial-control.md, where a function names no other.
"""

from typing import Annotated, NamedTuple

import numpy as np

from vvdp.base.kinds import (
    NUMBER,
    Count,
    Energy,
    ExchangedPower,
    Fraction,
    Length,
    Position,
    Pressure,
    SignedFraction,
    Time,
    Velocity,
)
from vvdp.base.params import Params
from vvdp.control.chamber import ChamberDrive, ChamberReading, PositionGains, desired_pressure
from vvdp.control.reference import Jerk, Reference, SignedAcceleration
from vvdp.control.storage import StorageBalance, pressure_storage, storage_excess
from vvdp.network.program import ProgramType
from vvdp.programs.axial_stages import SETTLED

RISEN = 1e-3
"""Share of the largest storage by which it may rise between two samples before that counts: a law that acts at samples
is passive but for what the drive does between them."""

Sum = Annotated[float, NUMBER]


class LoopTruth(NamedTuple):
    """True state of the drive at a sample, the reference of its law with its derivatives, the command of the valve, and
    the position that the observer believes. `released` is 1 while the drive is controlled."""

    position: Position
    velocity: Velocity
    pressure: Pressure
    reference: Position
    reference_velocity: Velocity
    reference_acceleration: SignedAcceleration
    reference_jerk: Jerk
    command: SignedFraction
    believed: Position
    released: Fraction


class LoopError(NamedTuple):
    """Position minus reference at the last sample; 0 until the drive is controlled."""

    error: Position


class TallySettings(Params):
    """The `drive` as it truly is, and the gains of the law, for its storage. Samples count from `settling_time` after
    the start of control on."""

    drive: ChamberDrive
    gains: PositionGains
    sample_period: Time
    settling_time: Time = SETTLED


class Tally(NamedTuple):
    """Sums over the samples that count, and what the next sample needs of the last.

    Squares of the error against the reference [m^2], of that of the estimate [m^2], of the valve's command [1] and of
    its change from sample to sample [1]; `peak` is the largest error against the reference.
    """

    begin: Time
    drive: SignedFraction
    storage: Energy
    supply: ExchangedPower
    largest: Energy
    samples: Count
    tracking: Sum
    peak: Length
    estimation: Sum
    command: Sum
    change: Sum
    rises: Sum


def tally_start(settings: TallySettings) -> Tally:
    """Nothing added up yet."""
    sums = dict.fromkeys(Tally._fields, 0.0)
    return Tally(**{**sums, "begin": np.inf})


def tally_step(t: float, memory: Tally, truth: LoopTruth, settings: TallySettings) -> tuple[Tally, LoopError]:
    """Add a sample. A rise of W_P beyond what the spool gave counts where it exceeds `RISEN` of the largest W_P so far.

    Source  wang2017, eq. 5.27, for what counts as a rise
    """
    is_run = truth.released > 0.5
    begin = min(memory.begin, t) if is_run else np.inf
    reference = Reference(truth.reference, truth.reference_velocity, truth.reference_acceleration, truth.reference_jerk)
    true = ChamberReading(truth.position, truth.velocity, truth.pressure)
    desired = desired_pressure(reference, true, settings.gains, settings.drive)
    storage = pressure_storage(desired, true, settings.drive)
    given = -(true.pressure - desired.pressure) * settings.drive.area * desired.velocity_error
    largest = max(memory.largest, storage) if is_run else 0.0
    excess = storage_excess(
        StorageBalance(memory.storage, memory.supply), StorageBalance(storage, given), settings.sample_period
    )
    share = 1.0 if t >= begin + settings.settling_time else 0.0
    tracking, estimation = truth.position - truth.reference, truth.believed - truth.position
    change = truth.command - memory.drive
    return Tally(
        begin=begin,
        drive=truth.command,
        storage=storage,
        supply=given,
        largest=largest,
        samples=memory.samples + share,
        tracking=memory.tracking + share * tracking * tracking,
        peak=max(memory.peak, share * abs(tracking)),
        estimation=memory.estimation + share * estimation * estimation,
        command=memory.command + share * truth.command * truth.command,
        change=memory.change + share * change * change,
        rises=memory.rises + (share if excess > RISEN * largest else 0.0),
    ), LoopError(tracking if is_run else 0.0)


TALLY = ProgramType(tally_step, LoopTruth, LoopError(0.0), TallySettings, tally_start)
