"""Settings of the event-based Kalman filter.

Source  ours, docs/models/event-filter.md, where a function names no other.
"""

import numpy as np

from vvdp.base.kinds import (
    AccelerationDensity,
    AngularVariance,
    Count,
    Frequency,
    Ratio,
    RatioDrift,
    Speed,
    SpeedVariance,
)
from vvdp.base.params import Params
from vvdp.base.rules import field_text, refuse, require_positive
from vvdp.sensing.wheel import CodeWheel


class EventFilterValues(Params):
    """The numbers of the event-based Kalman filter, for any wheel; `event_filter` has the usual ones.

    `edge_variance` is the part of the noise that is an angle, the other follows from the interval in which an edge
    passed, taken at no less than `lowest_speed`. Edges are counted until the speed is known to
    `association_speed_deviation`. A manoeuvre is declared when the sum of innovations exceeds `manoeuvre_gate`; the
    acceleration then has `manoeuvre_density`, which fades over `manoeuvre_edges` edges.

    Stops, and slow passages, begin at `stop_rate`; with 0 a silence carries no information. A ripple of `ripple_order`
    periods a turn is estimated, 0: none; `ripple_variance` is that of its cosine and of its sine part, each over the
    mean speed, before the first edge, and `ripple_drift` lets them change.
    """

    acceleration_density: AccelerationDensity
    edge_variance: AngularVariance
    lowest_speed: Speed
    angle_variance: AngularVariance
    speed_variance: SpeedVariance
    association_speed_deviation: Speed
    manoeuvre_density: AccelerationDensity
    manoeuvre_gate: Ratio
    manoeuvre_edges: Count
    stop_rate: Frequency = 0.0
    ripple_order: Count = 0.0
    ripple_variance: Ratio = 0.0
    ripple_drift: RatioDrift = 0.0

    def check(self) -> None:
        require_positive(self, "edge_variance", why="no edge is known exactly")
        if not self.manoeuvre_edges >= 1.0:
            refuse(self, "manoeuvre_edges", "must be at least 1")
        if self.manoeuvre_density < self.acceleration_density:
            least = field_text(self, "acceleration_density")
            refuse(self, "manoeuvre_density", f"must be at least acceleration_density, {least}")
        if self.ripple_order > 0.0:
            require_positive(self, "ripple_variance", why=f"a ripple of order {self.ripple_order:g} is to be estimated")


class EventFilter(EventFilterValues):
    """Settings of the event-based Kalman filter.

    The index of the `wheel` has been found when `index_turns` turns agree about it; 0 where it has none.
    """

    wheel: CodeWheel
    index_turns: Count = 0.0

    def check(self) -> None:
        if self.index_turns > 0.0 and not self.wheel.has_index:
            refuse(self, "index_turns", "must be 0: the wheel looks the same after less than a revolution")


def event_filter(wheel: CodeWheel) -> EventFilter:
    """The published settings, completed; change one with `dataclasses.replace`.

    Source  wang2017, section 3.5; manoeuvre, association, silence and index are ours, docs/models/event-filter.md
    """
    return EventFilter(
        wheel=wheel,
        acceleration_density=0.25,
        edge_variance=3.47e-3,  # with the sampling part, 2.06e-3 at 157 rad/s and 1 ms, the published 5.53e-3
        lowest_speed=2.0 * np.pi,
        angle_variance=1000.0,
        speed_variance=1000.0,
        association_speed_deviation=10.0,
        manoeuvre_density=2e4,
        manoeuvre_gate=6.0,
        manoeuvre_edges=4.0,
        stop_rate=0.01,
        index_turns=2.0 if wheel.has_index else 0.0,
    )
