"""Results of the control of a whole machine: alarms, mean powers, tracking errors of the spool."""

from collections.abc import Iterable, Iterator, Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np

from vvdp.base.kinds import DURATION, EFFICIENCY, LENGTH, MEAN_POWER, NUMBER, TIME
from vvdp.network.network import Network
from vvdp.programs.machine.charts import machine_charts, with_phases
from vvdp.programs.machine.checks import machine_loop_of
from vvdp.programs.machine.power import PARTS, SHARES, mean_powers, whole_periods
from vvdp.programs.machine.supervision import WATCHED
from vvdp.programs.report import ProgramReport, Quantities, origin, state_rows
from vvdp.programs.spool_report import true_path
from vvdp.programs.tracking import SETTLED
from vvdp.results.chart import Chart
from vvdp.results.result import Table

if TYPE_CHECKING:
    from vvdp.simulation.outcome import Outcome
    from vvdp.simulation.record import Record
    from vvdp.simulation.run import Run

MACHINE: Quantities = MappingProxyType(
    {
        "spool_position_error_rms_m": (LENGTH, "spool position: error against its reference"),
        "spool_position_error_max_m": (LENGTH, "spool position: largest error"),
        "spool_estimate_error_rms_m": (LENGTH, "spool position: error of the estimate"),
        "control_time_s": (DURATION, "time since control of the cylinder began"),
        "alarm": (NUMBER, "number of the alarm that stopped the machine, 0 without one"),
        "alarm_time_s": (TIME, "when it was reported"),
        **{key: (MEAN_POWER, label) for key, (label, _) in PARTS.items()},
        **{key: (EFFICIENCY, label) for key, (label, _) in SHARES.items()},
    }
)


class MachineReport(ProgramReport):
    """Of the program that leads a machine: its keys stand without a name although the law of the spool has some, too.

    Means are those of whole periods of the cycle, once control has settled.
    """

    GROUP = "Whole machine"
    QUANTITIES = MACHINE
    STEADY = False
    LEADS = True

    def __init__(self, network: Network, name: str, sample_period: float) -> None:
        super().__init__(network, name, sample_period)
        self.loop = machine_loop_of(self.program.settings)
        self.spool = true_path(network, self.program.reads["spool_position"], "position")
        self.shown = [origin(network, self.program.reads[each]) for each in ("spool_reference", "spool_position")]

    def outcome_numbers(self, run: "Outcome", found: Mapping[str, float | bool]) -> dict[str, float]:  # noqa: ARG002
        """Duration of the control of the cylinder; the alarm, and its time."""
        memory = run.memory[self.program.name]
        alarm, controlled = memory.supervision.alarm, max(run.end - memory.begin, 0.0)
        told = {"alarm_time_s": alarm.time} if alarm.alarm else {}
        return {"control_time_s": controlled, "alarm": alarm.alarm, **told}

    def numbers(self, run: "Run") -> dict[str, float]:
        """Mean powers and errors of the spool; empty where the run holds no whole period of settled control."""
        period = self.loop.points.times[-1]
        begin = run.final_memory[self.program.name].begin + SETTLED
        if run.end < begin + period:
            return {}
        begin, end = whole_periods(run, begin, period)
        rows = np.flatnonzero((run.times >= begin) & (run.times <= end))
        return mean_powers(run, begin, end) | (self.spool_numbers(run, rows) if self.spool else {})

    def spool_numbers(self, run: "Run", rows: Any) -> dict[str, float]:
        """Tracking and estimation errors of the spool at these rows.

        A row shows the command of the sample before it; the spool hardly moves in between.
        """
        position = state_rows(run, self.spool)[rows]
        reference, believed = (
            getattr(getattr(run.command, program.name), field)[rows] if program else position
            for program, field in self.shown
        )
        errors, doubts = position - reference, believed - position
        return {
            "spool_position_error_rms_m": float(np.sqrt(np.mean(errors**2))),
            "spool_position_error_max_m": float(np.max(np.abs(errors))),
            "spool_estimate_error_rms_m": float(np.sqrt(np.mean(doubts**2))),
        }

    def warnings(self, found: Mapping[str, float | bool]) -> Iterator[str]:
        """A control that never began, and an alarm."""
        if found.get("control_time_s") == 0.0:
            yield "control never began: the spool was not homed, or its angle not found, or the line not charged"
        if told := int(found.get("alarm", 0.0)):
            yield f"supervision stopped the machine at {found['alarm_time_s']:.4g} s: {WATCHED[told - 1]}"

    def charts(self, record: "Record") -> Iterable[tuple[Chart, Table]]:
        """Charts of the pressures, and of the commands of the drives."""
        return machine_charts(record, self.program, self.loop.law.bounds)

    def complete(self, chart: Chart, record: "Record") -> Chart:
        """A figure over time with the phases of the machine."""
        return with_phases(chart, record, self.program.name)
