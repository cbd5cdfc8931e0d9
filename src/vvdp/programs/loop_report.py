"""What a program that is all of an axial drive's control adds to the results: errors, storage, figures."""

from typing import TYPE_CHECKING

import numpy as np

from vvdp.base.arrays import Array
from vvdp.control.chamber import ChamberReading
from vvdp.control.reference import Reference
from vvdp.programs.axial_loop import PROGRAM, RUN
from vvdp.programs.axial_numbers import (
    Controlled,
)

if TYPE_CHECKING:
    from vvdp.simulation.run import Run


def samples_under_control(run: "Run", period: float) -> tuple[Array, Array]:
    """The rows of a run at samples, every `period` [s], at which its axial drive is controlled, and those that follow.

    A row at a sample shows what was commanded before it: what is commanded there stands in the row of the next sample.
    Samples whose next one is not recorded are left out.
    """
    at_sample = np.flatnonzero(np.abs(run.times / period - np.round(run.times / period)) < 1e-6)
    now, after = at_sample[:-1], at_sample[1:]
    is_next = np.abs(run.times[after] - run.times[now] - period) < 1e-6 * period
    is_used = is_next & (run.command.axial.stage[after] == RUN)
    return now[is_used], after[is_used]


def rows_under_control(run: "Run", period: float) -> Controlled:
    """The rows of a run at samples, every `period` [s], in which its chamber drive is controlled."""
    now, after = samples_under_control(run, period)
    shown, state, memory = run.command.axial, run.state, run.memory[PROGRAM]
    loop = getattr(memory, "loop", memory)
    return Controlled(
        times=run.times[now],
        true=ChamberReading(state.slide.position[now], state.slide.velocity[now], state.pilot_chamber[now]),
        shown=type(shown)(*(column[after] for column in shown)),
        reference=Reference(*(column[after] for column in loop.reference)),
    )
