"""What a controlled chamber drive comes to, added up sample by sample while it runs: no record is needed.

Source  ours, docs/models/axial-control.md, where a function names no other.
"""

from typing import Annotated, NamedTuple

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.conservation import NOTHING
from vvdp.base.kinds import (
    NUMBER,
    Count,
    Energy,
    ExchangedPower,
    Length,
    Position,
    PositionSignal,
    Pressure,
    SignedFraction,
    Time,
    Velocity,
)
from vvdp.base.params import Params
from vvdp.base.signal import signal_value
from vvdp.control.chamber import ChamberDrive, ChamberReading, PositionGains, desired_pressure
from vvdp.control.reference import Reference, ReferenceFilter, reference_at_rest, reference_step
from vvdp.control.storage import StorageBalance, pressure_storage, storage_excess
from vvdp.network.network import Network
from vvdp.network.program import ProgramType
from vvdp.programs.axial_loop import PROGRAM, RUN, SETTLED
from vvdp.simulation.layout import as_memory
from vvdp.simulation.model import Case

TALLY = "tally"
"""Name of the program that adds up."""

RISEN = 1e-3
"""Share of the largest storage by which it may rise between two samples before that counts: a law that acts at samples
is passive but for what the drive does between them."""

Sum = Annotated[float, NUMBER]


class AxialTruth(NamedTuple):
    """How the drive truly stands at a sample, and what its control has just made of it."""

    time: Time
    position: Position
    velocity: Velocity
    pressure: Pressure
    drive: SignedFraction
    stage: Count
    believed: Position


class TallySettings(Params):
    """The `drive` as it truly is, what its control follows, every `sample_period`, and the gains that its storage is
    calculated with. Samples count from `settling_time` after the start of control on."""

    drive: ChamberDrive
    gains: PositionGains
    reference: ReferenceFilter
    wanted: PositionSignal
    sample_period: Time
    stop_position: Position
    settling_time: Time = SETTLED


class Tally(NamedTuple):
    """Sums over the samples that count, and what the next sample needs of the last.

    Squares of the error against the reference [m^2], of that of the estimate [m^2], of the valve's command [1] and of
    its change from sample to sample [1]; `peak` is the largest error against the reference.
    """

    begin: Time
    reference: Reference
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
    return Tally(**{**sums, "begin": np.inf, "reference": reference_at_rest(settings.stop_position)})  # type: ignore[arg-type]


def tally_step(t: float, memory: Tally, truth: AxialTruth, settings: TallySettings) -> tuple[Tally, object]:
    """Add a sample. A rise of W_P beyond what the spool gave counts where it exceeds `RISEN` of the largest W_P so far.

    Source  wang2017, eq. 5.27, for what counts as a rise
    """
    is_run = truth.stage == RUN
    reference, begin = reference_at_rest(settings.stop_position), np.inf
    if is_run:
        wanted = signal_value(t, settings.wanted)
        reference = reference_step(memory.reference, wanted, settings.sample_period, settings.reference)
        begin = min(memory.begin, t)
    true = ChamberReading(truth.position, truth.velocity, truth.pressure)
    desired = desired_pressure(reference, true, settings.gains, settings.drive)
    storage = pressure_storage(desired, true, settings.drive)
    given = -(true.pressure - desired.pressure) * settings.drive.area * desired.velocity_error
    largest = max(memory.largest, storage) if is_run else 0.0
    excess = storage_excess(
        StorageBalance(memory.storage, memory.supply), StorageBalance(storage, given), settings.sample_period
    )
    share = 1.0 if t >= begin + settings.settling_time else 0.0
    tracking, estimation = truth.position - reference.position, truth.believed - truth.position
    change = truth.drive - memory.drive
    return Tally(
        begin=begin,
        reference=reference,
        drive=truth.drive,
        storage=storage,
        supply=given,
        largest=largest,
        samples=memory.samples + share,
        tracking=memory.tracking + share * tracking * tracking,
        peak=max(memory.peak, share * abs(tracking)),
        estimation=memory.estimation + share * estimation * estimation,
        command=memory.command + share * truth.drive * truth.drive,
        change=memory.change + share * change * change,
        rises=memory.rises + (share if excess > RISEN * largest else 0.0),
    ), NOTHING


def tally_of(case: Case, memories: Array) -> Tally:
    """What was added up in a run of a case, from the numbers of its memories at the end, shape (n,)."""
    found: Tally = as_memory(case, memories)[TALLY]
    return found


def add_tally(net: Network, settings: TallySettings) -> None:
    """Add the program that adds up what the control of the network's chamber drive comes to; after that control."""
    kind = ProgramType(tally_step, AxialTruth, NOTHING, TallySettings, tally_start)
    reads = {
        "time": "t",
        "position": "slide.position",
        "velocity": "slide.velocity",
        "pressure": "pilot_chamber.pressure",
        "drive": f"{PROGRAM}.drive",
        "stage": f"{PROGRAM}.stage",
        "believed": f"{PROGRAM}.position",
    }
    net.program(TALLY, kind, settings, reads=reads, period=settings.sample_period)
