"""Encoder and event filter as a file describes them."""

from dataclasses import fields, replace

from vvdp.base.errors import ParameterError
from vvdp.base.kinds import Count, Fraction, FractionSignal, Length
from vvdp.base.params import Params
from vvdp.base.rules import require_positive
from vvdp.estimation.event_settings import EventFilter, EventFilterValues, event_filter
from vvdp.sensing.encoder import NO_FAULTS, SAMPLED, Encoder
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
