"""Encoder and event-based Kalman filter as two programs: the filter reads the edges of the encoder."""

from dataclasses import fields, replace
from typing import NamedTuple

from vvdp.base.kinds import Angle, Count, Fraction
from vvdp.base.params import Params
from vvdp.estimation.estimator import Estimate, to_estimate
from vvdp.estimation.event_filter import event_filter_step
from vvdp.estimation.event_memory import EventFilterMemory, event_filter_start
from vvdp.estimation.event_settings import EventFilter, EventFilterValues, event_filter
from vvdp.network.program import ProgramType
from vvdp.programs.generic import GenericProgram
from vvdp.programs.spool_encoder import EncoderTable, encoder_of
from vvdp.sensing.encoder import Encoder, EncoderMemory, Shaft, encoder_start, encoder_step
from vvdp.sensing.reading import Reading
from vvdp.sensing.wheel import equal_wheel


class ShaftEncoder(EncoderTable):
    """An encoder on a shaft that stands at `start_angle` at first."""

    start_angle: Angle = 0.0


class EncoderSettings(Params):
    """What the program of an encoder works with."""

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
    t: float, memory: EncoderMemory, reading: Shaft, settings: EncoderSettings
) -> tuple[EncoderMemory, Reading]:
    """Edges of a code wheel on a shaft since the last sample."""
    return encoder_step(memory, reading, settings.encoder)


class WheelFilter(EventFilterValues):
    """The event-based Kalman filter for a wheel of equal sectors, one edge moved to mark the index."""

    sectors: Count
    index_shift: Fraction = 0.0


def _filter_settings(table: WheelFilter) -> EventFilter:
    numbers = {field.name: getattr(table, field.name) for field in fields(EventFilterValues)}
    return replace(event_filter(equal_wheel(int(table.sectors), table.index_shift)), **numbers)


def filter_start(settings: EventFilter) -> EventFilterMemory:
    """Before the first sample: nothing is known but the wheel."""
    return event_filter_start(settings, 0.0, 0.0, 0.0)


def filter_step(
    t: float, memory: EventFilterMemory, reading: Reading, settings: EventFilter
) -> tuple[EventFilterMemory, Estimate]:
    """Angle and speed of a shaft from the edges of its encoder, by the event-based Kalman filter."""
    return event_filter_step(memory, reading, settings)


def _first_estimate(settings: EventFilter, reading: NamedTuple) -> Estimate:
    return to_estimate(filter_start(settings).belief, 0.0, 0.0, 0.0, 0.0)


NO_EDGE = Reading(time=0.0, edges=0.0, edge_time=0.0, edge_interval=0.0, polarity=0.0)
NOTHING_KNOWN = Estimate(
    angle=0.0,
    speed=0.0,
    angle_deviation=0.0,
    speed_deviation=0.0,
    innovation=0.0,
    innovation_deviation=0.0,
    missed_edges=0.0,
    standstill=0.0,
)
ENCODER = GenericProgram(
    ProgramType(encoder_program_step, Shaft, NO_EDGE, ShaftEncoder, encoder_program_start),
    made=encoder_settings,
)
EVENT_FILTER = GenericProgram(
    ProgramType(filter_step, Reading, NOTHING_KNOWN, WheelFilter, filter_start),
    first=_first_estimate,
    made=_filter_settings,
)
