"""The estimators that are compared, each with its usual settings, and what each is given besides the encoder."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.params import Params
from vvdp.base.signal import signal_value
from vvdp.comparison.scenarios import (
    RATE,
    SECTORS,
    USUAL_TURNS,
    WARM_OIL,
    Record,
    Scenario,
    drive,
    driving_flow,
    encoder_of,
)
from vvdp.comparison.scores import Traces
from vvdp.comparison.smoothing import smoothed_traces, used_edge_step
from vvdp.estimation.baselines.finite_difference import finite_difference, finite_difference_estimator
from vvdp.estimation.baselines.inverse_time import inverse_time, inverse_time_estimator
from vvdp.estimation.baselines.m_over_t import m_over_t, m_over_t_estimator
from vvdp.estimation.baselines.time_stamping import time_stamping, time_stamping_estimator
from vvdp.estimation.baselines.torque_filter import TorqueFilter, TorqueReading, torque_filter, torque_filter_estimator
from vvdp.estimation.baselines.tracking_loop import tracking_loop, tracking_loop_estimator
from vvdp.estimation.estimator import Estimator
from vvdp.estimation.event_filter import event_filter_estimator
from vvdp.estimation.event_memory import event_filter_start
from vvdp.estimation.event_settings import EventFilter, event_filter
from vvdp.estimation.fusion import FusionReading, fusion, fusion_start, fusion_step, pressure_edge_angle
from vvdp.estimation.threshold import (
    AdaptedThreshold,
    EdgeOffset,
    ThresholdAdaptation,
    ThresholdMemory,
    edge_offset_estimator,
    threshold_adaptation,
    threshold_start,
    threshold_step,
)
from vvdp.sensing.encoder import Encoder, EncoderMemory, Shaft, encoder_reading, encoder_start
from vvdp.sensing.photodiode import ramp_width
from vvdp.sensing.reading import Reading
from vvdp.sensing.wheel import TURN, equal_wheel

READING = Reading(0.0, 0.0, 0.0, 0.0, 0.0)
FLOW_DEVIATION, TEMPERATURE_DEVIATION = 0.02, 2.0
"""Standard deviations of the constant errors with which the flow [1] and the oil's temperature [K] are known."""
DUTY_RATIO, DUTY_DEVIATION, PRESSURE_DEVIATION = 0.5, 0.01, 0.04
"""Of the wave of the inlet pressure: duty ratio, noise of its sensor [1], scatter of the wave's edges [rad]."""
SECTIONS = 3.0
"""PWM periods in a turn of the spool."""
WAVE = TURN / SECTIONS
"""A period of that wave [rad]."""
LARGEST_RIPPLE = 0.05
"""By which the speed may swing within a period, as far as is known before [1]."""
NEVER = 1e6
"""A gate that no sum of innovations reaches [1]."""


def readings_alone(scenario: Scenario, record: Record) -> Array:
    """Output of the encoder, (samples, 5)."""
    return record.readings


@dataclass(frozen=True)
class Contender:
    """An estimator with its values, an example of its reading, and `rows`, the readings of a record.

    With a `loop` it acts on the encoder: that step over the shaft's motion is run in place of its own. With
    `afterwards` what the step has shown is no estimate yet: that function of times, shown rows and settings makes it.
    """

    name: str
    title: str
    step: Callable[[Any, Any, Any], tuple[Any, Any]]
    memory: Any
    settings: Any
    reading: Any = READING
    rows: Callable[[Scenario, Record], Array] = readings_alone
    loop: Callable[[Any, Any, Any], tuple[Any, Any]] | None = None
    afterwards: Callable[[Array, Array, Any], Traces] | None = None


class AdaptingMemory(NamedTuple):
    """Encoder and estimator in a loop."""

    encoder: EncoderMemory
    estimator: ThresholdMemory


class AdaptingSettings(Params):
    """Encoder and estimator in a loop."""

    encoder: Encoder
    estimator: ThresholdAdaptation


def adapting_step(
    memory: AdaptingMemory, shaft: Shaft, settings: AdaptingSettings
) -> tuple[AdaptingMemory, AdaptedThreshold]:
    """One sample of encoder and estimator, the comparator working with the threshold that the estimator wants.

    What the encoder's own threshold would have drifted comes on top: it is the light that changes.

    Source  ours, docs/models/threshold-adaptation.md
    """
    own = settings.encoder.threshold
    drifted = signal_value(shaft.time, own) - signal_value(0.0, own)
    threshold = memory.estimator.comparator_threshold + drifted
    encoder, reading = encoder_reading(memory.encoder, shaft, threshold, settings.encoder)
    estimator, shown = threshold_step(memory.estimator, reading, settings.estimator)
    return AdaptingMemory(encoder, estimator), shown


def adapting_start(scenario: Scenario, record: Record, settings: ThresholdAdaptation) -> AdaptingMemory:
    """Encoder and estimator before the first sample of `record`, the threshold that of the encoder at time 0."""
    truth = record.truth
    encoder = encoder_start(scenario.encoder, float(truth.time[0]), float(truth.angle[0]), float(record.seed))
    threshold = float(signal_value(0.0, scenario.encoder.threshold))
    return AdaptingMemory(encoder, threshold_start(settings, threshold, 0.0, 0.0, 0.0))


def with_flow(scenario: Scenario, record: Record) -> Array:
    """The encoder's readings, the flow that drives the spool, and the oil's temperature, (samples, 7).

    Flow and temperature are each wrong by a constant that follows from the seed.
    """
    random = np.random.default_rng([record.seed, 4])
    time = record.truth.time
    flow = driving_flow(scenario.motion.by_flow, time - 0.5 / scenario.rate) * (
        1.0 + FLOW_DEVIATION * random.standard_normal()
    )
    temperature = np.full(time.size, WARM_OIL + TEMPERATURE_DEVIATION * random.standard_normal())
    return np.column_stack([record.readings, flow, temperature])


def with_pressure(scenario: Scenario, record: Record) -> Array:
    """The encoder's readings, the edges of the inlet pressure, and a measured duty ratio, (samples, 10).

    The wave is that of a spool with three sections whose mounting angle follows from the seed; its edges scatter, and
    are sampled by the clock that samples the encoder.
    """
    random = np.random.default_rng([record.seed, 5])
    time, angle, _ = record.truth
    phase = random.uniform(-0.5 * WAVE, 0.5 * WAVE)
    pulses = np.arange(np.floor(angle.min() / WAVE) - 2.0, np.ceil(angle.max() / WAVE) + 3.0)
    signs = np.repeat([1.0, -1.0], pulses.size)
    places = pressure_edge_angle(np.tile(pulses, 2), signs, DUTY_RATIO, phase, 0.0, SECTIONS)  # type: ignore[arg-type]
    seen = places + PRESSURE_DEVIATION * random.standard_normal(signs.size)
    order = np.argsort(seen)
    behind = np.searchsorted(seen[order], angle, side="right")
    passed = np.diff(behind, prepend=behind[0])
    edges, last = np.abs(passed), np.where(passed > 0, behind - 1, np.clip(behind, 0, signs.size - 1))
    polarity = np.where(passed == 0, 0.0, np.sign(passed) * signs[order][last])  # backwards a pulse ends where it began
    period = np.full(time.size, 1.0 / scenario.rate)
    duty = DUTY_RATIO + DUTY_DEVIATION * random.standard_normal(time.size)
    return np.column_stack([record.readings, edges, time - 0.5 * period, period, polarity, duty])


def contenders(sectors: int = SECTORS, rate: float = RATE) -> tuple[Contender, ...]:
    """All estimators for a wheel of `sectors` equal sectors sampled at `rate` [Hz]; none receives angle or speed.

    The settings are those that each comes with; the blur of an edge alone goes with the width of the sectors. Raises
    ParameterError for an odd number of sectors.
    """
    wheel = equal_wheel(sectors)
    blur = event_filter(wheel).edge_variance * (SECTORS / sectors) ** 2
    events = replace(event_filter(wheel), edge_variance=blur)
    slope, torque = ramp_width(encoder_of(sectors).spot), torque_filter(wheel, drive().oil, drive().valve)
    return (
        _alone("event-filter", event_filter_estimator(events)),
        _with_ripple(events),
        _without_manoeuvres(events),
        _learning_the_offset(events, slope),
        _setting_the_threshold(events, slope, 1.0 / rate),
        _with_torque(replace(torque, edge_variance=blur, film_thickening=drive().thickening)),
        _with_pressure(events),
        _alone("tracking-loop", tracking_loop_estimator(tracking_loop(wheel))),
        _alone("time-stamping", time_stamping_estimator(time_stamping(wheel))),
        _alone("m-over-t", m_over_t_estimator(m_over_t(wheel))),
        _alone("finite-difference", finite_difference_estimator(finite_difference(wheel))),
        _alone("inverse-time", inverse_time_estimator(inverse_time(wheel))),
        _smoothing(events),
    )


def _alone(name: str, estimator: Estimator) -> Contender:
    return Contender(name, estimator.title, estimator.step, estimator.memory, estimator.settings)


def _with_ripple(events: EventFilter) -> Contender:
    rippled = replace(events, ripple_order=SECTIONS, ripple_variance=0.5 * LARGEST_RIPPLE**2)
    contender = _alone("ripple-filter", event_filter_estimator(rippled))
    return replace(contender, title="event filter that knows that the speed swings three times a turn")


def _without_manoeuvres(events: EventFilter) -> Contender:
    contender = _alone("no-manoeuvres", event_filter_estimator(replace(events, manoeuvre_gate=NEVER)))
    return replace(contender, title="event filter without manoeuvre detection")


def _learning_the_offset(events: EventFilter, slope: float) -> Contender:
    settings = EdgeOffset(
        filter=events, offset_variance=(0.2 * slope) ** 2, offset_drift=1e-4, threshold=0.5, ramp_slope=slope
    )
    contender = _alone("edge-offset", edge_offset_estimator(settings))
    return replace(contender, title="event filter that learns the offset of the edges")


def _setting_the_threshold(events: EventFilter, slope: float, period: float) -> Contender:
    settings = threshold_adaptation(events, slope, period, USUAL_TURNS * TURN)
    memory = threshold_start(settings, 0.5, 0.0, 0.0, 0.0)
    title = "event filter that sets the comparator's threshold"
    return Contender("adaptive-threshold", title, threshold_step, memory, settings, loop=adapting_step)


def _with_torque(settings: TorqueFilter) -> Contender:
    contender = _alone("torque-filter", torque_filter_estimator(settings))
    title = "event filter that knows the torques: flow and oil"
    return replace(contender, title=title, reading=TorqueReading(READING, 0.0, WARM_OIL), rows=with_flow)


def _with_pressure(events: EventFilter) -> Contender:
    settings = fusion(events)
    memory = fusion_start(settings, 0.0, 0.0, 0.0)
    reading = FusionReading(
        encoder=READING,
        pressure_edges=0.0,
        pressure_edge_time=0.0,
        pressure_edge_interval=0.0,
        pressure_polarity=0.0,
        duty_ratio=DUTY_RATIO,
    )
    title = "event filter on encoder and inlet pressure"
    return Contender(
        name="fusion",
        title=title,
        step=fusion_step,
        memory=memory,
        settings=settings,
        reading=reading,
        rows=with_pressure,
    )


def _smoothing(events: EventFilter) -> Contender:
    memory = event_filter_start(events, 0.0, 0.0, 0.0)
    title = "smoother, which knows the edges to come as well: a mark, not a rival"
    return Contender("smoother", title, used_edge_step, memory, events, afterwards=smoothed_traces)
