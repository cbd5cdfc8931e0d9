"""What the whole machine brings along: how well its cylinder follows, what that takes, and pictures of it."""

from collections.abc import Iterable, Iterator, Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np

from vvdp.base.kinds import FREQUENCY, GAUGE_PRESSURE, LENGTH, NUMBER, TIME, Kind
from vvdp.machines.cycle import reference_period
from vvdp.machines.machine_charts import charts_with_phases, machine_charts
from vvdp.machines.machine_loop import PROGRAM
from vvdp.machines.machine_power import POWERS, mean_powers, whole_periods
from vvdp.machines.machine_tally import TALLY, MachineTally
from vvdp.machines.supervision import WATCHED
from vvdp.programs.axial_loop import PROGRAM as AXIAL
from vvdp.programs.tracking import SETTLED, TRACKING, tracking_numbers
from vvdp.results.chart import Chart
from vvdp.results.result import Table
from vvdp.simulation.values import leaves
from vvdp.systems.extras import Extras, Line, Summary

if TYPE_CHECKING:
    from vvdp.base.arrays import Array
    from vvdp.simulation.outcome import Outcome
    from vvdp.simulation.record import Record
    from vvdp.simulation.run import Run

MOTION: Mapping[str, tuple[Kind, str]] = MappingProxyType(
    {
        **TRACKING,
        "control_begin_s": (TIME, "start of control"),
        "pressure_min_Pa": (GAUGE_PRESSURE, "lowest pressure under control"),
        "pressure_max_Pa": (GAUGE_PRESSURE, "highest pressure under control"),
        "pwm_frequency_Hz": (FREQUENCY, "PWM frequency under control"),
        "flow_map_gain": (NUMBER, "gain of the flow map, at the end"),
        "spool_position_error_rms_m": (LENGTH, "spool position: error against its reference"),
        "spool_position_error_max_m": (LENGTH, "spool position: largest error"),
        "spool_estimate_error_rms_m": (LENGTH, "spool position: error of the estimate"),
        "real_time_factor": (NUMBER, "simulated over computing time"),
        "alarm": (NUMBER, "number of the alarm that stopped the machine, 0 without one"),
        "alarm_time_s": (TIME, "when it was reported"),
    }
)
"""Kind and label of the numbers beside the powers."""
GROUP, POWER_GROUP = "Displacement control", "Power, mean over whole periods of the reference"


class MachineExtras(Extras):
    """What a machine brings along, whatever moves its spool."""

    STEADY = False
    QUANTITIES = MappingProxyType({**MOTION, **POWERS})
    OVERVIEW = (
        *(Line(label, (key,), kind, (), GROUP) for key, (kind, label) in MOTION.items()),
        *(Line(label, (key,), kind, (), POWER_GROUP) for key, (kind, label) in POWERS.items()),
    )
    HEADLINE = ("tracking_error_max_m", "tracking_error_rms_m")

    def simulation_numbers(self, run: "Outcome", found: Summary) -> Summary:
        """How well the cylinder followed, between which pressures, and the pace. Chambers count over every step, closed
        before control begins; the line counts at samples, since it is empty at first, but its peak over every step."""
        numbers: Summary = {"real_time_factor": run.end / run.seconds if run.seconds > 0.0 else np.nan}
        alarm = run.memory[PROGRAM].supervision.alarm
        numbers |= {"alarm": alarm.alarm} | ({"alarm_time_s": alarm.time} if alarm.alarm else {})
        tally: MachineTally = run.memory[TALLY]
        if tally.tracking.begin == np.inf:
            return numbers
        reference = self.tables["oil"].reference_pressure
        chambers = [found[f"pressure_min_{name}_Pa"] for name in ("chamber_a", "chamber_b")]
        peaks = [found[f"pressure_max_{name}_Pa"] for name in ("chamber_a", "chamber_b", "line")]
        turned = tally.turned / tally.time if tally.time > 0.0 else np.nan
        return numbers | {
            **tracking_numbers(tally.tracking),
            "control_begin_s": tally.tracking.begin,
            "pressure_min_Pa": min(*chambers, tally.lowest - reference),
            "pressure_max_Pa": max(peaks),
            "pwm_frequency_Hz": self.tables["valve"].sections * turned / (2.0 * np.pi),
            "flow_map_gain": tally.map_gain,
        }

    def record_numbers(self, run: "Run") -> Summary:
        """Mean powers over whole periods of the reference once control has settled, and the spool's errors; empty where
        the run holds no such period."""
        begin = run.final_memory[TALLY].tracking.begin + SETTLED
        period = reference_period(self.tables["cycle"])
        if run.end < begin + period:
            return {}
        begin, end = whole_periods(run, begin, period)
        rows = np.flatnonzero((run.times >= begin) & (run.times <= end))
        return mean_powers(run, begin, end) | spool_numbers(run, self.spool_position(run), rows)

    def spool_position(self, run: "Run") -> "Array":
        """The spool's position, row by row [m]."""
        paths = [path for path, _, _ in leaves(run.case.state)]
        source = self.system.circuit.network.programs[AXIAL].reads["position"]
        found: Array = run.states[:, paths.index(str(source))]
        return found

    def warnings(self, found: Mapping[str, float | bool]) -> Iterator[str]:
        """What a user has to know of the control."""
        if "control_begin_s" not in found:
            yield "control never began: the spool was not homed, or its angle not found, or the line not charged"
        if told := int(found.get("alarm", 0.0)):
            yield f"supervision stopped the machine at {found['alarm_time_s']:.4g} s: {WATCHED[told - 1]}"
        if share := found.get("below_tank_share"):
            yield f"a chamber was below tank pressure for {100.0 * share:.2g} % of the time: oil evaporates there"
        if found.get("saturated_share", 0.0) > SATURATED:
            yield (
                f"the return valve stood at an end for {100.0 * found['saturated_share']:.2g} % of the time, where it "
                "cannot make up for what the pump does not deliver"
            )

    def charts(self, record: "Record") -> "Iterable[tuple[Chart, Table]]":
        """The cylinder's course, pressures, what is asked of the drives; then those of the axial drive; the phase
        under all that are drawn over time."""
        yield from charts_with_phases(machine_charts(record, self.tables["pressure_bounds"]), record)
        network = self.system.circuit.network
        axial = network.programs[AXIAL]
        if axial.type.report is not None and axial.period is not None:
            report = axial.type.report(network, AXIAL, axial.period)
            yield from charts_with_phases(report.charts(record), record)


SATURATED = 0.2
"""From this share of the time on a return valve at an end is worth a word."""


def spool_numbers(run: "Run", position: "Array", rows: Any) -> Summary:
    """How well the spool follows and is known.

    A row shows what was commanded at the sample before it; the spool hardly moves in between.

    position  of the spool, row by row [m]
    rows      that count
    """
    shown = run.command.axial
    errors, doubts = position[rows] - shown.reference[rows], shown.position[rows] - position[rows]
    return {
        "spool_position_error_rms_m": float(np.sqrt(np.mean(errors**2))),
        "spool_position_error_max_m": float(np.max(np.abs(errors))),
        "spool_estimate_error_rms_m": float(np.sqrt(np.mean(doubts**2))),
    }
