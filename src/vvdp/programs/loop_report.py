"""Report of a program that is all of an axial drive's control: errors, storage, figures."""

from collections.abc import Iterable, Iterator, Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np

from vvdp.base.arrays import Array
from vvdp.control.chamber import ChamberReading
from vvdp.control.reference import Reference
from vvdp.network.network import Network
from vvdp.programs.axial_charts import control_charts, gerotor_charts
from vvdp.programs.axial_loop import PROGRAM, RUN, SETTLED
from vvdp.programs.axial_numbers import (
    CHAMBER,
    MOTION,
    Controlled,
    Moved,
    control_merits,
    control_warnings,
    motion_numbers,
    storage_numbers,
)
from vvdp.programs.report import ProgramReport, Quantities, state_rows
from vvdp.results.chart import Chart
from vvdp.results.result import Table

if TYPE_CHECKING:
    from vvdp.simulation.record import Record
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


class SpoolLoopReport(ProgramReport):
    """Of a program `PROGRAM` that is sensor, observer, reference and law in one, and reads the spool's `position`."""

    GROUP = "Axial control"
    QUANTITIES: Quantities = MappingProxyType(MOTION)
    HEADLINE = ("spool_position_error_rms_m", "spool_estimate_error_rms_m")

    def __init__(self, network: Network, name: str, sample_period: float) -> None:
        super().__init__(network, name, sample_period)
        settings: Any = self.program.settings
        self.loop: Any = getattr(settings, "loop", settings)

    def numbers(self, run: "Run") -> dict[str, float]:
        """How well a spool was held, from a second after the start of control on; none where it was not that long."""
        now, after = samples_under_control(run, self.period)
        shown = run.command.axial
        moved = Moved(
            times=run.times[now],
            true=state_rows(run, str(self.program.reads["position"]))[now],
            reference=shown.reference[after],
            position=shown.position[after],
            deviation=shown.position_deviation[after],
            pollution=shown.pollution[after],
        )
        found = motion_numbers(moved, self.loop.observer.pollution.helix_length)
        speed = run.end / run.seconds if run.seconds > 0.0 else np.nan
        return {**found, "real_time_factor": speed} if found else {}

    def charts(self, record: "Record") -> Iterable[tuple[Chart, Table]]:
        """Position, command and errors."""
        return gerotor_charts(record, self.period)


class ChamberLoopReport(SpoolLoopReport):
    """The same of a drive by a chamber, and whether its storage obeys passivity."""

    QUANTITIES = MappingProxyType(CHAMBER)

    def numbers(self, run: "Run") -> dict[str, float]:
        """How well the drive was controlled, from a second after the start on."""
        numbers = super().numbers(run)
        if not numbers:
            return {}
        found = rows_under_control(run, self.period)
        late = found.times >= found.times[0] + SETTLED
        margin = float(np.min(found.shown.margin[late]))
        return {**numbers, "observability_margin_lowest": margin, **storage_numbers(found, self.loop, self.period)}

    def warnings(self, found: Mapping[str, float | bool]) -> Iterator[str]:
        """Limits of the control, a sentence each."""
        yield from control_warnings(self.loop, self.loop.wanted.extremes[1], self.period, found)

    def merits(self, found: Mapping[str, float | bool]) -> Iterator[str]:
        """A storage that never rose."""
        yield from control_merits(found)

    def charts(self, record: "Record") -> Iterable[tuple[Chart, Table]]:
        """Position, pressure, storage and errors."""
        return control_charts(record, self.period)
