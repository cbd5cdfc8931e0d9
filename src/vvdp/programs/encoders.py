"""Encoder and event-based Kalman filter as two programs: the filter reads the edges of the encoder."""

from typing import NamedTuple

from vvdp.base.kinds import Angle, Count, Fraction, Number, Ratio, SignedFraction, Speed, Time
from vvdp.base.params import Params
from vvdp.base.rules import refuse
from vvdp.base.signal import signal_value
from vvdp.estimation.bounded_filter import (
    BoundedMemory,
    PassedEdges,
    WatchedAngle,
    bounded_start,
    bounded_step,
    watched_angle,
)
from vvdp.estimation.estimator import to_estimate
from vvdp.estimation.event_settings import EventFilter, EventFilterValues
from vvdp.estimation.threshold import (
    RampSlope,
    SignalLevel,
    ThresholdAdaptation,
    ThresholdMemory,
    threshold_start,
    threshold_step,
)
from vvdp.network.program import ProgramType
from vvdp.programs.estimate_report import EstimateReport
from vvdp.programs.generic import GenericProgram
from vvdp.programs.spool_encoder import EncoderTable, encoder_of, filter_of
from vvdp.sensing.encoder import Encoder, EncoderMemory, Shaft, encoder_reading, encoder_start
from vvdp.sensing.reading import Reading
from vvdp.sensing.wheel import equal_wheel


class ShaftEncoder(EncoderTable):
    """An encoder on a shaft that stands at `start_angle` at first."""

    start_angle: Angle = 0.0


class WatchedShaft(NamedTuple):
    """The shaft at a sample, and the value added to the threshold of the comparator."""

    time: Time
    angle: Angle
    speed: Speed
    threshold_shift: SignedFraction = 0.0


class SeenEdges(NamedTuple):
    """One sample of an encoder: its `Reading`, the time since the sample before, and that since the last edge."""

    time: Time
    edges: Count
    edge_time: Time
    edge_interval: Time
    polarity: Number
    elapsed: Time
    edge_age: Time


class EncoderSettings(Params):
    """Settings of the program of an encoder."""

    encoder: Encoder
    angle: Angle
    seed: Count


def encoder_settings(table: ShaftEncoder) -> EncoderSettings:
    """The settings of an encoder as its step takes them."""
    return EncoderSettings(encoder=encoder_of(table), angle=table.start_angle, seed=table.seed)


def encoder_program_start(settings: EncoderSettings) -> EncoderMemory:
    """Before the first sample."""
    return encoder_start(settings.encoder, 0.0, settings.angle, settings.seed)


def encoder_program_step(
    t: float, memory: EncoderMemory, reading: WatchedShaft, settings: EncoderSettings
) -> tuple[EncoderMemory, SeenEdges]:
    """Edges of a code wheel on a shaft since the last sample."""
    shaft = Shaft(reading.time, reading.angle, reading.speed)
    threshold = signal_value(reading.time, settings.encoder.threshold) + reading.threshold_shift
    after, seen = encoder_reading(memory, shaft, threshold, settings.encoder)
    return after, SeenEdges(
        time=seen.time,
        edges=seen.edges,
        edge_time=seen.edge_time,
        edge_interval=seen.edge_interval,
        polarity=seen.polarity,
        elapsed=reading.time - memory.time,
        edge_age=reading.time - seen.edge_time,
    )


class WheelFilter(EventFilterValues):
    """The event-based Kalman filter for a wheel of equal sectors, one edge moved to mark the index."""

    sectors: Count
    index_shift: Fraction = 0.0

    def check(self) -> None:
        if self.sectors % 1.0:
            refuse(self, "sectors", "must be a whole number")


def filter_settings(table: WheelFilter) -> EventFilter:
    """The settings of an event filter as its step takes them."""
    return filter_of(table, equal_wheel(int(table.sectors), table.index_shift))


def filter_step(
    t: float, memory: BoundedMemory, reading: PassedEdges, settings: EventFilter
) -> tuple[BoundedMemory, WatchedAngle]:
    """Angle and speed of a shaft from the edges of its encoder, by the event-based Kalman filter."""
    return bounded_step(memory, reading, settings)


class AdaptedFilter(WheelFilter):
    """The event filter and what adapts the `threshold` of the comparator, which is that of the encoder at first."""

    threshold: SignalLevel
    ramp_slope: RampSlope
    adaptation_gain: Ratio = 0.02
    lowest: SignalLevel = 0.1
    highest: SignalLevel = 0.9
    dither: Ratio = 0.0


class ThresholdSettings(Params):
    """Settings of the program of a threshold."""

    adaptation: ThresholdAdaptation
    threshold: SignalLevel


class ThresholdSeen(NamedTuple):
    """Angle and speed of the shaft, the threshold without dither, and the value that the encoder adds to its own
    threshold."""

    angle: Angle
    speed: Speed
    threshold: SignalLevel
    threshold_shift: SignedFraction


def threshold_settings(table: AdaptedFilter) -> ThresholdSettings:
    """The settings of a threshold that is adapted as its step takes them."""
    adaptation = ThresholdAdaptation(
        filter=filter_settings(table),
        gain=table.adaptation_gain,
        ramp_slope=table.ramp_slope,
        lowest=table.lowest,
        highest=table.highest,
        dither=table.dither,
    )
    return ThresholdSettings(adaptation=adaptation, threshold=table.threshold)


def threshold_program_start(settings: ThresholdSettings) -> ThresholdMemory:
    """Before the first sample: nothing is known but the wheel and the threshold."""
    return threshold_start(settings.adaptation, settings.threshold, 0.0, 0.0, 0.0)


def threshold_program_step(
    t: float, memory: ThresholdMemory, reading: Reading, settings: ThresholdSettings
) -> tuple[ThresholdMemory, ThresholdSeen]:
    """Angle, speed and the threshold of the comparator from the edges of an encoder, by an event filter that adapts."""
    after, found = threshold_step(memory, reading, settings.adaptation)
    shift = found.comparator_threshold - settings.threshold
    return after, ThresholdSeen(found.estimate.angle, found.estimate.speed, found.threshold, shift)


def _first_estimate(settings: EventFilter, reading: NamedTuple) -> WatchedAngle:
    belief = bounded_start(settings).filter.belief
    return watched_angle(to_estimate(belief, 0.0, 0.0, 0.0, 0.0), 0.0, 0.0)


NO_EDGE = SeenEdges(**dict.fromkeys(SeenEdges._fields, 0.0))
NOTHING_KNOWN = WatchedAngle(**dict.fromkeys(WatchedAngle._fields, 0.0))
ENCODER = GenericProgram(
    ProgramType(encoder_program_step, WatchedShaft, NO_EDGE, ShaftEncoder, encoder_program_start, is_drawn=False),
    made=encoder_settings,
)
EVENT_FILTER = GenericProgram(
    ProgramType(
        filter_step,
        PassedEdges,
        NOTHING_KNOWN,
        WheelFilter,
        bounded_start,
        report=EstimateReport,
        is_bounded=True,
    ),
    first=_first_estimate,
    made=filter_settings,
)
THRESHOLD = GenericProgram(
    ProgramType(
        threshold_program_step, Reading, ThresholdSeen(0.0, 0.0, 0.5, 0.0), AdaptedFilter, threshold_program_start
    ),
    made=threshold_settings,
)
