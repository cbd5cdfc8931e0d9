"""A spool that is watched: encoder and event-based Kalman filter run along at every sample."""

from dataclasses import fields, replace
from typing import NamedTuple

from vvdp.base.errors import ParameterError
from vvdp.base.kinds import Angle, Count, Fraction, FractionSignal, Length
from vvdp.base.params import Params
from vvdp.base.rules import require_positive
from vvdp.estimation.axial_filter import Phase
from vvdp.estimation.estimator import Estimate
from vvdp.estimation.event_filter import event_filter_step
from vvdp.estimation.event_memory import EventFilterMemory, event_filter_start
from vvdp.estimation.event_settings import EventFilter, EventFilterValues, event_filter
from vvdp.programs.axial_loop import known_phase
from vvdp.sensing.encoder import (
    NO_FAULTS,
    SAMPLED,
    Encoder,
    EncoderMemory,
    Shaft,
    encoder_start,
    encoder_step,
)
from vvdp.sensing.photodiode import LightSpot
from vvdp.sensing.wheel import CodeWheel, equal_wheel


class EncoderTable(Params):
    """The [encoder] table: a code wheel of equal sectors with one edge moved to mark the index."""

    sectors: Count
    index_shift: Fraction
    spot_width: Length
    track_radius: Length
    spot_roundness: Fraction
    threshold: FractionSignal
    hysteresis: Fraction
    noise: Fraction
    counter_bits: Count
    missed_edges: Fraction
    seed: Count

    def check(self) -> None:
        require_positive(self, "track_radius")
        if self.sectors % 1.0 or self.seed % 1.0:
            raise ParameterError(f"sectors = {self.sectors:g}, seed = {self.seed:g}; expected whole numbers")
        encoder_of(self)  # here, where the line of the table is known


class WatchMemory(NamedTuple):
    """Memory of encoder and filter from sample to sample."""

    encoder: EncoderMemory
    filter: EventFilterMemory


class WatchSettings(Params):
    """Settings of the program: encoder and filter, the spool's angle at first, and the seed of the noise."""

    encoder: Encoder
    filter: EventFilter
    angle: Angle
    seed: Count


def watch_start(settings: WatchSettings) -> WatchMemory:
    """The memory before the first sample: the filter knows nothing but the wheel."""
    return WatchMemory(
        encoder=encoder_start(settings.encoder, 0.0, settings.angle, settings.seed),
        filter=event_filter_start(settings.filter, 0.0, 0.0, 0.0),
    )


def watch_step(t: float, memory: WatchMemory, reading: Shaft, settings: WatchSettings) -> tuple[WatchMemory, Estimate]:
    """Encoder and event filter take a sample; what they believe of the spool is shown."""
    encoder, seen = encoder_step(memory.encoder, reading, settings.encoder)
    remembered, estimate = event_filter_step(memory.filter, seen, settings.filter)
    return WatchMemory(encoder, remembered), estimate


def watched_phase(t: float, memory: WatchMemory, reading: Shaft, settings: WatchSettings) -> tuple[WatchMemory, Phase]:
    """Encoder and event filter take a sample; the phase of the periodic sensor error as they show it."""
    watch, estimate = watch_step(t, memory, reading, settings)
    return watch, known_phase(estimate, watch.filter.slip, memory.filter.slip)


def encoder_of(table: EncoderTable) -> Encoder:
    """The encoder that a table describes. Raises ParameterError where wheel and spot do not fit."""
    return Encoder(
        wheel=equal_wheel(int(table.sectors), table.index_shift),
        spot=LightSpot(width=table.spot_width, track_radius=table.track_radius, roundness=table.spot_roundness),
        threshold=table.threshold,
        hysteresis=table.hysteresis,
        noise=table.noise,
        counter_bits=table.counter_bits,
        acquisition=SAMPLED,
        faults=replace(NO_FAULTS, missed_edges=table.missed_edges),
    )


def filter_of(values: EventFilterValues, wheel: CodeWheel) -> EventFilter:
    """The event filter with these values for a code wheel."""
    numbers = {field.name: getattr(values, field.name) for field in fields(EventFilterValues)}
    return replace(event_filter(wheel), **numbers)


def watch_settings(table: EncoderTable, values: EventFilterValues, angle: float) -> WatchSettings:
    """Encoder and filter of two tables, for a spool that stands at `angle` [rad] at first."""
    encoder = encoder_of(table)
    return WatchSettings(encoder=encoder, filter=filter_of(values, encoder.wheel), angle=angle, seed=table.seed)
