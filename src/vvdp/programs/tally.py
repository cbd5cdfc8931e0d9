"""Tracking errors of a cylinder under displacement control, added up by a program from true values.

It commands nothing, so its inputs may be values that a control cannot measure.

Source  ours, docs/models/displacement-control.md
"""

from collections.abc import Iterable, Iterator, Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from vvdp.base.kinds import (
    FREQUENCY,
    GAUGE_PRESSURE,
    NUMBER,
    TIME,
    Angle,
    Count,
    Fraction,
    Position,
    Pressure,
    Ratio,
    SignedFraction,
    Time,
)
from vvdp.base.params import Params
from vvdp.base.units import ATMOSPHERE
from vvdp.control.pressure_modes import PressureMode
from vvdp.network.network import Network
from vvdp.network.program import ProgramType
from vvdp.programs.displacement_charts import motion_charts
from vvdp.programs.report import ProgramReport
from vvdp.programs.tracking import (
    TOGETHER,
    TRACKING,
    Actuated,
    Followed,
    Tracking,
    tracking_numbers,
    tracking_start,
    tracking_step,
)
from vvdp.results.chart import Chart
from vvdp.results.result import Table

if TYPE_CHECKING:
    from vvdp.simulation.outcome import Outcome
    from vvdp.simulation.record import Record


class CylinderTruth(NamedTuple):
    """True motion and pressures of a cylinder at a sample, its reference, and the commands of its control.

    `line_pressure`, the gain of a flow map and the angle of a spool are those of a supply by a rotary valve; a sample
    counts where `counted` is 1.
    """

    position: Position
    reference: Position
    pressure_a: Pressure
    pressure_b: Pressure
    direction: SignedFraction
    opening: Fraction
    mode: PressureMode
    saturated: Fraction
    line_pressure: Pressure = ATMOSPHERE
    map_gain: Ratio = 1.0
    spool_angle: Angle = 0.0
    counted: Fraction = 1.0


class TrackingError(NamedTuple):
    """Position minus reference at the last sample that counts."""

    error: Position


class TallySettings(Params):
    """Against which pressure a chamber counts as drawn empty, and how many PWM periods a turn of a spool has."""

    tank_pressure: Pressure = ATMOSPHERE
    sections: Count = 1.0


class Tally(NamedTuple):
    """Results of the tracking; the lowest pressure of the line at samples that count; how far the spool has turned in
    what time; the last gain of the flow map."""

    tracking: Tracking
    lowest: Pressure
    map_gain: Ratio
    spool_angle: Angle
    turned: Angle
    time: Time


def tally_start(settings: TallySettings) -> Tally:
    """Nothing added up yet."""
    return Tally(tracking=tracking_start(), lowest=np.inf, map_gain=1.0, spool_angle=0.0, turned=0.0, time=0.0)


def tally_step(t: float, memory: Tally, reading: CylinderTruth, settings: TallySettings) -> tuple[Tally, TrackingError]:
    """Errors of a cylinder under displacement control, its pressure modes and its valves, added up."""
    if reading.counted <= 0.5:
        return memory, TrackingError(0.0)
    time = t - min(memory.tracking.begin, t)
    least = min(reading.pressure_a, reading.pressure_b) - settings.tank_pressure
    error = reading.position - reading.reference
    done = Actuated(reading.direction, reading.opening, reading.mode, reading.saturated)
    return Tally(
        tracking=tracking_step(memory.tracking, Followed(t, error, least), done),
        lowest=min(memory.lowest, reading.line_pressure),
        map_gain=reading.map_gain,
        spool_angle=reading.spool_angle,
        turned=memory.turned + (reading.spool_angle - memory.spool_angle if time > 0.0 else 0.0),
        time=time,
    ), TrackingError(error)


PRESSURES = ("pressure_a", "pressure_b", "line_pressure")


class TallyReport(ProgramReport):
    """Report of tracking errors, extremes of pressures, and the real-time factor of the run."""

    GROUP = "Displacement control"
    QUANTITIES = MappingProxyType(
        {
            **TRACKING,
            "control_begin_s": (TIME, "start of control"),
            "pressure_min_Pa": (GAUGE_PRESSURE, "lowest pressure under control"),
            "pressure_max_Pa": (GAUGE_PRESSURE, "highest pressure under control"),
            "pwm_frequency_Hz": (FREQUENCY, "PWM frequency under control"),
            "flow_map_gain": (NUMBER, "gain of the flow map, at the end"),
            "real_time_factor": (NUMBER, "simulated over computing time"),
        }
    )
    TOGETHER = TOGETHER
    UNSHOWN = frozenset(key for keys in TOGETHER.values() for key in keys)
    HEADLINE = ("tracking_error_max_m", "tracking_error_rms_m")
    STEADY = False
    LEADS = True

    def __init__(self, network: Network, name: str, sample_period: float) -> None:
        super().__init__(network, name, sample_period)
        self.reference_pressure = network.oil.reference_pressure

    def outcome_numbers(self, run: "Outcome", found: Mapping[str, float | bool]) -> dict[str, float]:
        """Tracking errors and further sums of the run, and the extremes of the chambers over every step."""
        tally: Tally = run.memory[self.program.name]
        pace = {"real_time_factor": run.end / run.seconds if run.seconds > 0.0 else np.nan}
        if tally.tracking.begin == np.inf:
            return pace
        numbers = tracking_numbers(tally.tracking) | self._pressures(tally, found) | pace
        reads, settings = self.program.reads, self.program.settings
        if "counted" in reads:
            numbers["control_begin_s"] = tally.tracking.begin
        if "map_gain" in reads:
            numbers["flow_map_gain"] = tally.map_gain
        if "spool_angle" in reads and tally.time > 0.0 and isinstance(settings, TallySettings):
            numbers["pwm_frequency_Hz"] = settings.sections * tally.turned / tally.time / (2.0 * np.pi)
        return numbers

    def _pressures(self, tally: Tally, found: Mapping[str, float | bool]) -> dict[str, float]:
        """Lowest and highest pressure, gauge [Pa]; of the line, empty at first, the lowest at samples that count."""
        reads = self.program.reads
        nodes = {key: str(reads[key]).removesuffix(".pressure") for key in PRESSURES if key in reads}
        low = {key: found.get(f"pressure_min_{node}_Pa", np.nan) for key, node in nodes.items()}
        high = [found.get(f"pressure_max_{node}_Pa", np.nan) for node in nodes.values()]
        if "line_pressure" in nodes:
            low["line_pressure"] = tally.lowest - self.reference_pressure
        numbers = {"pressure_min_Pa": float(np.min([*low.values()])), "pressure_max_Pa": float(np.max(high))}
        return {key: value for key, value in numbers.items() if np.isfinite(value)}

    def warnings(self, found: Mapping[str, float | bool]) -> Iterator[str]:
        """A chamber that was drawn empty."""
        if share := found.get("below_tank_share"):
            yield (
                f"a chamber was below tank pressure {100.0 * share:.2g} % of the time: raise lowest_pressure of the "
                "control, or make the pump faster"
            )

    def merits(self, found: Mapping[str, float | bool]) -> Iterator[str]:
        """Bounds that were never near."""
        if found.get("mode_1_share") == 1.0:
            yield "both chambers stayed clear of their bounds: no pressure mode acted"

    def charts(self, record: "Record") -> Iterable[tuple[Chart, Table]]:
        """The rod, its reference, and the error."""
        return motion_charts(record, {**self.program.reads, "error": f"{self.program.name}.error"})


TALLY = ProgramType(
    tally_step, CylinderTruth, TrackingError(0.0), TallySettings, tally_start, report=TallyReport, is_drawn=False
)
