"""How well an axial drive is controlled: errors of position and estimate, and whether the storage obeys passivity."""

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.kinds import Kind
from vvdp.control.chamber import ChamberReading
from vvdp.control.reference import Reference
from vvdp.programs.axial_loop import PROGRAM, RUN, SETTLED
from vvdp.programs.axial_numbers import (
    Controlled,
    ExactLaw,
    Moved,
    control_warnings,
    motion_numbers,
    storage_numbers,
)
from vvdp.programs.chamber_loop import ChamberLoop, WatchedLoop
from vvdp.systems.extras import Line as Row
from vvdp.systems.extras import LoadedSystem, Summary

if TYPE_CHECKING:
    from vvdp.simulation.run import Run

GROUP = "Axial control"


def lines_of(quantities: Mapping[str, tuple[Kind, str]]) -> tuple[Row, ...]:
    """A line of the overview for each number."""
    return tuple(Row(label, (key,), kind, (), GROUP) for key, (kind, label) in quantities.items())


def loop_of(system: LoadedSystem) -> ChamberLoop:
    """The values of the loop of a system."""
    settings = system.circuit.network.programs[PROGRAM].settings
    found = settings.loop if isinstance(settings, WatchedLoop) else settings
    assert isinstance(found, ChamberLoop)
    return found


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


def spool_numbers(run: "Run", position: Array, period: float, helix_length: float) -> Summary:
    """How well a spool was held, from `SETTLED` after the start of control on; empty where it was not that long.

    position      of the spool, row by row [m]
    period        of the samples [s]
    helix_length  duty ratio 0 to 1 [m]
    """
    now, after = samples_under_control(run, period)
    shown = run.command.axial
    moved = Moved(
        times=run.times[now],
        true=position[now],
        reference=shown.reference[after],
        position=shown.position[after],
        deviation=shown.position_deviation[after],
        pollution=shown.pollution[after],
    )
    found = motion_numbers(moved, helix_length)
    speed = run.end / run.seconds if run.seconds > 0.0 else np.nan
    return {**found, "real_time_factor": speed} if found else {}


def control_numbers(run: "Run", loop: ChamberLoop, helix_length: float) -> Summary:
    """How well a chamber drive was controlled, from `SETTLED` after the start on; empty where it was not that long."""
    period = loop.observer.sample_period
    numbers = spool_numbers(run, run.state.slide.position, period, helix_length)
    if not numbers:
        return {}
    found = rows_under_control(run, period)
    late = found.times >= found.times[0] + SETTLED
    margin = float(np.min(found.shown.margin[late]))
    return {**numbers, "observability_margin_lowest": margin, **storage_numbers(found, law_of(loop), period)}


def loop_warnings(loop: ChamberLoop, found: Mapping[str, Any]) -> Iterator[str]:
    """What limits the control of a loop, a sentence each."""
    yield from control_warnings(law_of(loop), loop.wanted.extremes[1], loop.observer.sample_period, found)


def law_of(loop: ChamberLoop) -> ExactLaw:
    """The law of a loop: each class of loops has gains."""
    law: Any = loop
    return law  # type: ignore[no-any-return]
