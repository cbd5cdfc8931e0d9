"""Observer of the spool position, gerotor drive: a periodic Kalman filter with the flow as input.

x' = Q/A_s, the flow taken as a line between two samples. The integral of the position is no state of it: no
measurement shows it. Derived in docs/models/axial-observer.md.

Source  ours, docs/models/axial-observer.md, where a function names no other.
"""

import numpy as np

from vvdp.base.kinds import Area, Length, Position, Time
from vvdp.base.params import Params
from vvdp.base.rules import require_positive
from vvdp.estimation.axial_filter import (
    AxialEstimate,
    AxialMemory,
    AxialSeen,
    PollutionModel,
    axial_start,
    draft_of,
    drift_in_turn,
    estimate_of,
    hold_position,
    is_frozen,
    needs_duty,
    take_duty,
    take_optical,
)


class GerotorObserver(Params):
    """The periodic Kalman filter of the gerotor drive; `area` is that of the spool's end.

    The position drifts by `position_drift` a sample and is known to `position_deviation` at first.
    """

    area: Area
    pollution: PollutionModel
    sample_period: Time
    position_drift: Length
    position_deviation: Length
    stop_position: Position

    def check(self) -> None:
        require_positive(self, "area", "sample_period", "position_drift")


def gerotor_observer_start(settings: GerotorObserver, position: float) -> AxialMemory:
    """The memory before the first sample, with the spool about at `position` [m]."""
    deviations = np.array([settings.position_deviation])
    return axial_start(np.array([position]), deviations, settings.pollution)


def gerotor_observer_step(
    memory: AxialMemory, seen: AxialSeen, settings: GerotorObserver
) -> tuple[AxialMemory, AxialEstimate]:
    """Memory and estimate after a sample; the velocity is that of the flow.

    Source  wang2017, eqs. 4.10, 4.14 and 4.15, corrected and exact in time: docs/errata.md
    """
    draft, turn = draft_of(memory, 1), memory.turn
    velocity = seen.flow / settings.area
    if seen.held > 0.0:
        hold_position(draft, settings.stop_position)
    else:
        draft.mean[0] += 0.5 * settings.sample_period * (memory.drive_input + velocity)
        # The transition is 1, so the noise alone is left of the step.
        draft.factors[0, 0] += settings.position_drift * settings.position_drift
    if not is_frozen(seen):
        turn = drift_in_turn(draft, turn, settings.pollution)
    sight = take_optical(draft, seen, settings.pollution, settings.sample_period)
    if needs_duty(seen):
        draft.row[:] = 0.0
        draft.row[0] = 1.0
        take_duty(draft, seen, velocity * seen.duty.age, settings.pollution)
    estimate = estimate_of(draft, velocity, seen, sight)
    return AxialMemory(mean=draft.mean, factors=draft.factors, drive_input=velocity, turn=turn), estimate
