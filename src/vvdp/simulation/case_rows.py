"""What a batch keeps of its cases: arrays with a row for each, which the loops change in place."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from vvdp.base.arrays import Array
from vvdp.simulation import places
from vvdp.simulation.layout import rows as rows_of
from vvdp.simulation.model import Case
from vvdp.simulation.prepare import Prepared, start_run
from vvdp.simulation.stepping import Stepping


class CaseRows(NamedTuple):
    """Where each case stands, as `Reached` with its parameters, and what is kept of its run.

    A `status` of HANDED says that a case is still to be run by itself.
    """

    state: Array  # (cases, n)
    command: Array
    memory: Array
    params: Array
    agenda: Array
    waiting: Array
    clock: Array
    course: Array
    mark_times: Array  # (cases, room)
    mark_states: Array  # (cases, room, n)
    span_states: Array  # (cases, spans, n)
    low: Array  # (cases, n)
    high: Array  # (cases, n)
    status: npt.NDArray[np.int64]
    moving: npt.NDArray[np.int64]  # whether any of its signals moves, which lanes have to know

    def progress(self) -> tuple[Array, ...]:
        """The arrays of where each case stands."""
        return self[:8]

    def put(self, some: npt.NDArray[np.int64], again: "CaseRows") -> None:
        """Takes over what has become of `some` of the cases, which were run again with the same parameters."""
        for whole, piece in zip(self, again, strict=True):
            if whole is not self.params:  # rows as long as those of the longest case beside
                whole[some] = piece


def case_rows(cases: Sequence[Case], ready: Prepared, stepping: Stepping, room: int) -> CaseRows:
    """Rows of cases before their first step, with `room` for so many marks of each."""
    count, n = len(cases), ready.vectors.state.size
    state, command, memory, params = rows_of(cases)
    agenda, waiting, clock, course = (np.stack([part] * count) for part in start_run(ready, stepping)[3:])
    return CaseRows(
        state=state,
        command=command,
        memory=memory,
        params=params,
        agenda=agenda,
        waiting=waiting,
        clock=clock,
        course=course,
        mark_times=np.zeros((count, room)),
        mark_states=np.zeros((count, room, n)),
        span_states=np.zeros((count, stepping.span_times.size, n)),
        low=state.copy(),
        high=state.copy(),
        status=np.full(count, places.HANDED),
        moving=np.zeros(count, np.int64),
    )
