"""How well an axial drive is controlled: errors of position and estimate, and whether the storage obeys passivity."""

from collections.abc import Iterable, Iterator, Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.kinds import COUNT, DUTY_RATIO, EFFICIENCY, ENERGY, LENGTH, NUMBER, POSITION, TIME, Kind
from vvdp.base.select import maximum
from vvdp.control.backstepping import backstepping_law
from vvdp.control.chamber import ChamberReading, chamber_volume, desired_pressure, volume_compliance
from vvdp.control.orifice import valve_flow
from vvdp.control.passivity import PassivityGains, exact_feedforward, passivity_law, pressure_error_gain
from vvdp.control.reference import Reference
from vvdp.control.storage import StorageBalance, pressure_balance, storage_excess
from vvdp.control.tuning import sampling_limits, sampling_warning
from vvdp.hydraulics.chamber_drive import static_reach
from vvdp.programs.axial_loop import PROGRAM, RUN, SETTLED
from vvdp.programs.chamber_loop import ChamberLoop, WatchedLoop
from vvdp.results.chart import Chart
from vvdp.results.result import Table
from vvdp.systems.axial_charts import control_charts
from vvdp.systems.extras import Extras, LoadedSystem, Summary
from vvdp.systems.extras import Line as Row

if TYPE_CHECKING:
    from vvdp.simulation.outcome import Outcome
    from vvdp.simulation.record import Record
    from vvdp.simulation.run import Run

EXPLAINED = 3.0
"""So many of the deviations that an observer states explain a flow that is off."""
MOTION: Mapping[str, tuple[Kind, str]] = MappingProxyType(
    {
        "control_begin_s": (TIME, "start of control"),
        "duty_error_rms": (DUTY_RATIO, "duty ratio: error against the reference"),
        "spool_position_error_rms_m": (LENGTH, "spool position: error against the reference"),
        "spool_position_error_max_m": (LENGTH, "spool position: largest error"),
        "spool_estimate_error_rms_m": (LENGTH, "spool position: error of the estimate"),
        "spool_estimate_deviation_rms_m": (LENGTH, "spool position: stated deviation"),
        "spool_estimate_coverage": (EFFICIENCY, "spool position: errors within two deviations"),
        "pollution_rms_m": (LENGTH, "pollution of the axial sensor"),
        "real_time_factor": (NUMBER, "simulated over computing time"),
    }
)
"""Numbers of any controlled drive."""
QUANTITIES: Mapping[str, tuple[Kind, str]] = MappingProxyType(
    {
        **MOTION,
        "observability_margin_lowest": (NUMBER, "observability margin, lowest"),
        "storage_rises": (COUNT, "samples in which the storage rose beyond its supply"),
        "storage_rise_largest_J": (ENERGY, "largest such rise"),
        "storage_rise_time_s": (TIME, "time of the largest rise, or of the closest to one"),
        "storage_largest_J": (ENERGY, "storage of the chamber, largest"),
    }
)
"""Numbers of a controlled chamber drive."""
GROUP = "Axial control"


def lines_of(quantities: Mapping[str, tuple[Kind, str]]) -> tuple[Row, ...]:
    """A line of the overview for each number."""
    return tuple(Row(label, (key,), kind, (), GROUP) for key, (kind, label) in quantities.items())


LINES = lines_of(QUANTITIES)


class Controlled(NamedTuple):
    """What a run of a controlled drive has recorded, while it was controlled: true motion and chamber pressure, and the
    program's commands and reference, each of shape (rows,)."""

    times: Array
    true: Any
    shown: Any
    reference: Any


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


def motion_numbers(run: "Run", position: Array, period: float, helix_length: float) -> Summary:
    """How well a spool was held, from `SETTLED` after the start of control on; empty where it was not that long.

    position      of the spool, row by row [m]
    period        of the samples [s]
    helix_length  duty ratio 0 to 1 [m]
    """
    rows, after = samples_under_control(run, period)
    if rows.size < 2 or run.times[rows[-1]] - run.times[rows[0]] < SETTLED:
        return {}
    settled = run.times[rows] >= run.times[rows[0]] + SETTLED
    late, shown, true = after[settled], run.command.axial, position[rows[settled]]
    tracking, estimation = true - shown.reference[late], shown.position[late] - true
    deviation = shown.position_deviation[late]

    def rms(values: Array) -> float:
        return float(np.sqrt(np.mean(values**2)))

    found = {
        "control_begin_s": float(run.times[rows[0]]),
        "duty_error_rms": rms(tracking) / helix_length,
        "spool_position_error_rms_m": rms(tracking),
        "spool_position_error_max_m": float(np.max(np.abs(tracking))),
        "spool_estimate_error_rms_m": rms(estimation),
        "pollution_rms_m": rms(shown.pollution[late]),
        "real_time_factor": run.end / run.seconds if run.seconds > 0.0 else np.nan,
    }
    if np.all(np.isfinite(deviation)):
        found["spool_estimate_deviation_rms_m"] = rms(deviation)
        found["spool_estimate_coverage"] = float(np.mean(np.abs(estimation) <= 2.0 * deviation))
    return found


def control_numbers(run: "Run", loop: ChamberLoop, helix_length: float) -> Summary:
    """How well a chamber drive was controlled, from `SETTLED` after the start on; empty where it was not that long."""
    period = loop.observer.sample_period
    numbers = motion_numbers(run, run.state.slide.position, period, helix_length)
    if not numbers:
        return {}
    found = rows_under_control(run, period)
    late = found.times >= found.times[0] + SETTLED
    margin = float(np.min(found.shown.margin[late]))
    return {**numbers, "observability_margin_lowest": margin, **storage_numbers(found, loop)}


def storage_numbers(found: Controlled, loop: ChamberLoop) -> Summary:
    """How often W_P of the true states rose, from sample to sample, beyond what is allowed.

    Empty where rows are not one sample apart.

    Allowed is what the spool gave, eq. 5.27: W_P' <= -(P - P_d) A e_v; and what the exact law does not answer for: that
    the flow is held over a sample, and that its estimate is off, by up to `EXPLAINED` of the deviations it states.

    Source  ours, docs/models/axial-control.md
    """
    period, drive = loop.observer.sample_period, loop.drive
    if np.any(np.abs(np.diff(found.times) - period) > 1e-6 * period):
        return {}
    desired = desired_pressure(found.reference, found.true, _gains(loop), drive)
    flow = valve_flow(found.shown.drive, found.true.pressure, drive.valve)
    stored: Any = pressure_balance(flow, desired, found.true, drive).storage
    error = found.true.pressure - desired.pressure
    given: Any = -error * drive.area * desired.velocity_error
    effort: Any = np.abs(error + stored / chamber_volume(found.true.position, drive))
    held = np.abs(np.diff(exact_feedforward(desired, found.true, drive)))
    doubt = EXPLAINED * flow_deviation(found, loop)[:-1]
    before, after = StorageBalance(stored[:-1], given[:-1]), StorageBalance(stored[1:], given[1:])
    excess: Any = storage_excess(before, after, period)
    excess = excess - period * maximum(effort[:-1], effort[1:]) * (held + doubt)
    late = found.times[1:] >= found.times[0] + SETTLED
    worst = int(np.argmax(excess[late]))
    return {
        "storage_rises": float(np.count_nonzero(excess[late] > 0.0)),
        "storage_rise_largest_J": float(max(excess[late][worst], 0.0)),
        "storage_rise_time_s": float(found.times[1:][late][worst]),
        "storage_largest_J": float(np.max(stored[1:][late])),
    }


def flow_deviation(found: Controlled, loop: ChamberLoop) -> Array:
    """How far the flow that the law asks for may be off [m^3/s], by the observer's stated deviations; shape (rows,)."""
    gains, true, shown = _gains(loop), found.true, found.shown
    law: Any = passivity_law if isinstance(gains, PassivityGains) else backstepping_law

    def law_flow(reading: ChamberReading) -> Array:
        flow: Array = law(found.reference, reading, gains, loop.drive).flow
        return flow

    right = law_flow(true)
    by_position = law_flow(true._replace(position=true.position + shown.position_deviation)) - right
    by_velocity = law_flow(true._replace(velocity=true.velocity + shown.velocity_deviation)) - right
    return np.hypot(by_position, by_velocity)


def _gains(loop: ChamberLoop) -> Any:
    return loop.gains  # type: ignore[attr-defined]


def control_merits(found: Mapping[str, Any]) -> Iterator[str]:
    """That the storage never rose, where that is so."""
    if found.get("storage_rises") == 0.0:
        yield (
            "what the chamber stores against its desired pressure never rose beyond what the spool gave it: at every "
            "sample the control was passive"
        )


def control_warnings(loop: ChamberLoop, found: Mapping[str, Any]) -> Iterator[str]:
    """What limits the control, a sentence each: a pressure loop too fast for its samples where the oil is stiffest, at
    the highest pressure that is asked for; and a storage that rose."""
    gains, drive = _gains(loop), loop.drive
    position = loop.wanted.extremes[1]
    pressure = drive.oil.reference_pressure + (drive.preload + drive.stiffness * position) / drive.area
    compliance = volume_compliance(position, pressure, drive)
    is_passive = isinstance(gains, PassivityGains)
    gain = pressure_error_gain(position, pressure, gains, drive) if is_passive else gains.flow_gain
    if warning := sampling_warning(sampling_limits(gain, compliance), loop.observer.sample_period):
        yield warning
    if rises := found.get("storage_rises"):
        yield (
            f"what the chamber stores rose beyond what the spool gave it in {rises:.0f} samples, most by "
            f"{found['storage_rise_largest_J']:.2g} J at {found['storage_rise_time_s']:.4g} s: it is not passive"
        )


class ChamberReach(Extras):
    """How far the supply of a chamber drive holds the spool against its spring."""

    STEADY = False
    QUANTITIES = MappingProxyType(
        {
            "axial_reach_m": (POSITION, "position that the pilot supply holds against the spring"),
            "duty_reach": (DUTY_RATIO, "duty ratio of the position that the pilot supply holds"),
        }
    )

    def simulation_numbers(self, run: "Outcome", found: Summary) -> Summary:  # noqa: ARG002
        """The reach, and the duty ratio there, at the lowest pressure of the supply."""
        tables = self.tables
        pressure = tables["pilot"].supply_pressure.extremes[0]
        reference = tables["pilot_oil"].reference_pressure
        reach = static_reach(pressure, reference, tables["axial_piston"], tables["axial_spring"])
        reach = min(reach, tables["axial_stops"].upper_end)
        return {"axial_reach_m": reach, "duty_reach": reach / tables["stroke"].helix_length}


class AxialLoop(ChamberReach):
    """What a controlled axial drive brings along."""

    OVERVIEW = LINES
    QUANTITIES = MappingProxyType({**QUANTITIES, **ChamberReach.QUANTITIES})
    HEADLINE = ("spool_position_error_rms_m", "spool_estimate_error_rms_m")

    def record_numbers(self, run: "Run") -> Summary:
        """How well the drive was controlled."""
        return control_numbers(run, loop_of(self.system), self.tables["stroke"].helix_length)

    def warnings(self, found: Mapping[str, Any]) -> Iterator[str]:
        """What limits the control."""
        yield from control_warnings(loop_of(self.system), found)

    def merits(self, found: Mapping[str, Any]) -> Iterator[str]:
        """A storage that never rose."""
        yield from control_merits(found)

    def charts(self, record: "Record") -> Iterable[tuple[Chart, Table]]:
        """Position, pressure, storage and errors."""
        return control_charts(record, self.tables["axial_observer"].sample_period)
