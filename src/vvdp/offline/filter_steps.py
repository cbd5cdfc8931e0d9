"""The steps that are taken over a log: the event filter's and the fusion's, each showing the last edge as well."""

from collections.abc import Callable
from typing import NamedTuple

from vvdp.estimation.estimator import Estimate
from vvdp.estimation.event_filter import event_filter_step
from vvdp.estimation.event_memory import EventFilterMemory, event_filter_start
from vvdp.estimation.event_settings import EventFilter
from vvdp.estimation.fusion import Fusion, FusionMemory, FusionReading, fusion_start, fusion_step
from vvdp.sensing.reading import Reading
from vvdp.simulation.replay import Replay


class Shown(NamedTuple):
    """What is kept of each row: the estimate, and the number of the last edge, on the wheel as it was met."""

    angle: float
    speed: float
    angle_deviation: float
    speed_deviation: float
    innovation: float
    innovation_deviation: float
    missed_edges: float
    standstill: float
    edge: float


def tracked_step(memory: EventFilterMemory, reading: Reading, settings: EventFilter) -> tuple[EventFilterMemory, Shown]:
    """The event filter's step, showing the edge as well.

    Source  wang2017, eqs. 3.5 to 3.10, corrected: docs/errata.md
    """
    memory, estimate = event_filter_step(memory, reading, settings)
    return memory, shown_with(estimate, memory.last.number)


def shown_with(estimate: Estimate, edge: float) -> Shown:
    """An estimate with the number of the last edge."""
    e = estimate
    return Shown(
        angle=e.angle,
        speed=e.speed,
        angle_deviation=e.angle_deviation,
        speed_deviation=e.speed_deviation,
        innovation=e.innovation,
        innovation_deviation=e.innovation_deviation,
        missed_edges=e.missed_edges,
        standstill=e.standstill,
        edge=edge,
    )


SPEED, STANDSTILL, EDGE = (Shown._fields.index(name) for name in ("speed", "standstill", "edge"))


class FusedShown(NamedTuple):
    """The same of the fusion, and what it believes of the pressure's wave."""

    encoder: Shown
    phase: float
    duty_ratio: float
    duty_deviation: float
    lag: float


def fused_step(memory: FusionMemory, reading: FusionReading, settings: Fusion) -> tuple[FusionMemory, FusedShown]:
    """The fusion's step, showing the edge as well.

    Source  ours, docs/models/pressure-fusion.md
    """
    memory, f = fusion_step(memory, reading, settings)
    shown = shown_with(f.estimate, memory.filter.last.number)
    return memory, FusedShown(shown, f.phase, f.duty_ratio, f.duty_deviation, f.lag)


def replay_of(settings: EventFilter, fusion: Fusion | None, say: Callable[[str], None]) -> Replay:
    """The compiled step, with the fusion where there is one."""
    example = Reading(0.0, 0.0, 0.0, 0.0, 0.0)
    if fusion is None:
        return Replay(tracked_step, event_filter_start(settings, 0.0, 0.0, 0.0), example, settings, say=say)
    both = FusionReading(
        encoder=example,
        pressure_edges=0.0,
        pressure_edge_time=0.0,
        pressure_edge_interval=0.0,
        pressure_polarity=0.0,
        duty_ratio=0.0,
    )
    return Replay(fused_step, fusion_start(fusion, 0.0, 0.0, 0.0), both, fusion, say=say)
