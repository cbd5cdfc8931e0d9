"""A bench whose spool is watched: encoder and event-based Kalman filter run along at every sample."""

from collections.abc import Mapping
from dataclasses import fields, replace
from typing import Any, NamedTuple

import numpy as np

from vvdp.base.errors import ParameterError
from vvdp.base.kinds import Angle, Count, Fraction, FractionSignal, Length, Speed, Time
from vvdp.base.params import Params
from vvdp.circuits.supply import Command, SupplyParams, conditions
from vvdp.estimation.event_filter import (
    EventFilter,
    EventFilterMemory,
    EventFilterValues,
    event_filter,
    event_filter_start,
    event_filter_step,
)
from vvdp.numerics.tableaus import Array
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
from vvdp.sensing.wheel import equal_wheel
from vvdp.simulation.model import Case, Model

SETTLED = 0.5
"""From this time of a run on the errors of the estimate are counted [s]: the filter has found speed and index."""


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
        if self.sectors % 1.0 or self.seed % 1.0:
            raise ParameterError(f"sectors = {self.sectors:g}, seed = {self.seed:g}; expected whole numbers")


WATCHING: Mapping[str, type[Params]] = {"encoder": EncoderTable, "spool_filter": EventFilterValues}
"""Tables of a watched bench; a system file has both or neither."""


class SpoolEstimate(NamedTuple):
    """What is believed of the spool, and the time of the sample at which it was."""

    time: Time
    angle: Angle
    speed: Speed
    angle_deviation: Angle
    speed_deviation: Speed
    innovation: Angle
    innovation_deviation: Angle
    missed_edges: Count


class WatchMemory(NamedTuple):
    """What encoder and filter carry from sample to sample."""

    encoder: EncoderMemory
    filter: EventFilterMemory


class WatchSettings(Params):
    """What the program of a watched bench works with."""

    supply: SupplyParams
    encoder: Encoder
    filter: EventFilter


def watching_program(
    t: float, memory: WatchMemory, measured: Any, settings: WatchSettings
) -> tuple[WatchMemory, Command]:
    """The program of a bench whose spool is watched: nothing is controlled, the estimate is shown."""
    spool = measured.supply.spool
    encoder, reading = encoder_step(memory.encoder, Shaft(t, spool.angle, spool.speed), settings.encoder)
    remembered, e = event_filter_step(memory.filter, reading, settings.filter)
    estimate = SpoolEstimate(
        t,
        e.angle,
        e.speed,
        e.angle_deviation,
        e.speed_deviation,
        e.innovation,
        e.innovation_deviation,
        e.missed_edges,
    )
    return WatchMemory(encoder, remembered), Command(conditions(t, settings.supply), estimate)


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


def watched(model: Model, case: Case, table: EncoderTable, values: EventFilterValues) -> tuple[Model, Case]:
    """Model and case of a bench with an encoder and a filter that knows nothing at the start but the wheel."""
    encoder = encoder_of(table)
    numbers = {field.name: getattr(values, field.name) for field in fields(EventFilterValues)}
    settings = WatchSettings(
        supply=case.params.supply, encoder=encoder, filter=replace(event_filter(encoder.wheel), **numbers)
    )
    spool = case.state.supply.spool
    memory = WatchMemory(
        encoder_start(encoder, 0.0, spool.angle, table.seed), event_filter_start(settings.filter, 0.0, 0.0, 0.0)
    )
    start = SpoolEstimate(
        0.0,
        0.0,
        0.0,
        float(np.sqrt(values.angle_variance)),
        float(np.sqrt(values.speed_variance)),
        0.0,
        0.0,
        0.0,
    )
    command = Command(case.command.conditions, start)
    return (
        replace(model, program=watching_program),
        replace(case, command=command, memory=memory, settings=settings),
    )


def estimate_errors(
    times: Array, spool_angle: Array, spool_speed: Array, shown: Mapping[str, Array]
) -> tuple[Array, Array]:
    """Errors of the estimate at recorded `times` [s]: of the angle, within half a turn [rad], and of the speed [rad/s].

    Between samples the estimate is carried on at its own speed, as a controller would. Arguments and results have the
    shape (rows,); `shown` holds the columns of `SpoolEstimate`.
    """
    ahead = times - shown["time"]
    error = shown["angle"] + ahead * shown["speed"] - spool_angle
    return np.pi - np.mod(np.pi - error, 2.0 * np.pi), shown["speed"] - spool_speed
