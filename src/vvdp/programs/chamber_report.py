"""What a law of the chamber drive adds to the results: errors of spool and estimate, storage, reach, figures."""

from collections.abc import Iterable, Iterator, Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.kinds import DUTY_RATIO, POSITION
from vvdp.control.backstepping import BacksteppingGains
from vvdp.control.chamber import ChamberDrive, ChamberReading
from vvdp.control.passivity import PassivityGains
from vvdp.control.reference import Reference
from vvdp.network.network import Network, ProgramPart
from vvdp.network.nodes import Source
from vvdp.programs.axial_charts import ChamberPaths, DrivePaths, chamber_charts
from vvdp.programs.axial_loop import SETTLED
from vvdp.programs.axial_numbers import (
    CHAMBER,
    Controlled,
    ExactLaw,
    Moved,
    control_merits,
    control_warnings,
    motion_numbers,
    storage_numbers,
)
from vvdp.programs.chamber_observer import SeenSpool
from vvdp.programs.report import ProgramReport, origin, read_rows, state_rows
from vvdp.results.chart import Chart
from vvdp.results.result import Table

if TYPE_CHECKING:
    from vvdp.simulation.record import Record
    from vvdp.simulation.run import Run

REACH = MappingProxyType(
    {
        "axial_reach_m": (POSITION, "position that the pilot supply holds against the spring"),
        "duty_reach": (DUTY_RATIO, "duty ratio of the position that the pilot supply holds"),
    }
)
WATCHED = ("position", "position_deviation", "pollution", "stage")
MOTION_WORDS = ("reference", "reference_velocity", "reference_acceleration", "reference_jerk")


class Shown(NamedTuple):
    """What was commanded and believed at samples, each (rows,)."""

    drive: Array
    position_deviation: Array
    velocity_deviation: Array


def rows_at_samples(run: "Run", program: ProgramPart, period: float) -> tuple[Array, Array]:
    """The rows at samples, every `period` [s], at which the spool of a law is released, and those that follow, in which
    what they command stands. Samples whose next one is not recorded are left out."""
    at_sample = np.flatnonzero(np.abs(run.times / period - np.round(run.times / period)) < 1e-6)
    now: Any = at_sample[:-1]
    after: Any = at_sample[1:]
    is_used: Any = np.abs(run.times[after] - run.times[now] - period) < 1e-6 * period
    if released := program.reads.get("released"):
        is_used = is_used & (read_rows(run, released, now, after) > 0.5)
    return now[is_used], after[is_used]


def observer_rows(run: "Run", observer: ProgramPart | None, word: str, after: Array) -> Array:
    """A command of the observer, (rows,); without one nothing is off, and nothing is known."""
    if observer is None:
        return np.zeros(after.size) if word.endswith("deviation") else np.full(after.size, np.nan)
    found: Array = getattr(getattr(run.command, observer.name), word)[after]
    return found


def true_path(network: Network, source: Source | None) -> str:
    """The path of the true position behind what a law reads, through observer and sensor; empty without one."""
    program, path = origin(network, source)
    while program is not None:
        inputs = program.reads
        source = next((inputs[key] for key in ("measured", "position", "reads") if key in inputs), None)
        program, path = origin(network, source)
    return path if path.endswith(".position") else ""


def reach_numbers(drive: ChamberDrive, helix_length: float) -> dict[str, float]:
    """The position that the supply of a drive holds against the spring, and its duty ratio; `helix_length` [m]."""
    lifted = drive.area * (drive.valve.supply_pressure - drive.oil.reference_pressure)
    reach = (lifted - drive.preload) / drive.stiffness
    return {"axial_reach_m": reach, "duty_reach": reach / helix_length}


class ChamberLawReport(ProgramReport):
    """Of a program that reads a `reference`, a `position` and a `pressure`, and gives the `command` of a valve.

    The truth stands where the observer's sensor looks; a law without an observer is told the truth itself.
    """

    GROUP = "Axial control"
    QUANTITIES = MappingProxyType({**CHAMBER, **REACH})
    HEADLINE = ("spool_position_error_rms_m", "spool_estimate_error_rms_m")
    STEADY = False

    def __init__(self, network: Network, name: str, sample_period: float) -> None:
        super().__init__(network, name, sample_period)
        source = self.program.reads["position"]
        watch = origin(network, source)[0]
        self.observer = watch if watch is not None and isinstance(watch.type.command, SeenSpool) else None
        self.spool = true_path(network, source)
        settings: Any = None if self.observer is None else self.observer.settings
        self.helix_length = np.nan if settings is None else settings.observer.pollution.helix_length

    def run_rows(self, run: "Run") -> Controlled:
        """The samples under control: true motion, commands and reference."""
        now, after = rows_at_samples(run, self.program, self.period)
        reads, rod = self.program.reads, self.spool.rpartition(".")[0]
        command = getattr(run.command, self.program.name).command[after]
        motion: Any = (read_rows(run, reads[word], now, after) for word in MOTION_WORDS)
        return Controlled(
            times=run.times[now],
            true=ChamberReading(
                position=state_rows(run, self.spool)[now],
                velocity=state_rows(run, f"{rod}.velocity")[now],
                pressure=state_rows(run, str(reads["pressure"]))[now],
            ),
            shown=Shown(command, *(observer_rows(run, self.observer, word, after) for word in Shown._fields[1:])),
            reference=Reference(*motion),
        )

    def numbers(self, run: "Run") -> dict[str, float]:
        """Errors and storage, from a second after the start of control on, and the reach."""
        if not self.spool:
            return {}
        found, (_, after) = self.run_rows(run), rows_at_samples(run, self.program, self.period)
        moved = Moved(
            times=found.times,
            true=found.true.position,
            reference=found.reference.position,
            position=observer_rows(run, self.observer, "position", after),
            deviation=observer_rows(run, self.observer, "position_deviation", after),
            pollution=observer_rows(run, self.observer, "pollution", after),
        )
        numbers = motion_numbers(moved, self.helix_length)
        if numbers:
            late = found.times >= found.times[0] + SETTLED
            numbers["real_time_factor"] = run.end / run.seconds if run.seconds > 0.0 else np.nan
            numbers["observability_margin_lowest"] = float(
                np.min(observer_rows(run, self.observer, "margin", after)[late])
            )
            if self.law is not None:
                numbers |= storage_numbers(found, self.law, self.period)
        if self.law is not None:
            numbers |= reach_numbers(self.law.drive, self.helix_length)
        return {key: value for key, value in numbers.items() if np.isfinite(value)}

    @property
    def law(self) -> ExactLaw | None:
        """Its settings where it is one of the laws whose storage is known; else None."""
        settings: Any = self.program.settings
        is_known = isinstance(getattr(settings, "gains", None), PassivityGains | BacksteppingGains)
        return settings if is_known else None

    def warnings(self, found: Mapping[str, Any]) -> Iterator[str]:
        """What limits the control, and a storage that rose."""
        if self.law is None:
            return
        reach = reach_numbers(self.law.drive, self.helix_length)["axial_reach_m"]
        highest = found.get(f"position_max_{self.spool.rpartition('.')[0]}_m", reach)
        yield from control_warnings(self.law, highest, self.period, found)

    def merits(self, found: Mapping[str, Any]) -> Iterator[str]:
        """A storage that never rose."""
        yield from control_merits(found)

    def charts(self, record: "Record") -> Iterable[tuple[Chart, Table]]:
        """Position, pressure, storage and errors; none without an observer."""
        if not self.spool or self.observer is None or not isinstance(self.program.reads["reference"], str):
            return ()
        name, watch, reads = self.program.name, self.observer.name, self.observer.reads
        paths = DrivePaths(
            spool=self.spool,
            reference=str(self.program.reads["reference"]),
            measured=str(reads["measured"]),
            spool_angle=str(reads["angle"]),
            **{word: f"{watch}.{word}" for word in WATCHED},
        )
        chamber = ChamberPaths(str(self.program.reads["pressure"]), f"{name}.desired_pressure", f"{name}.storage")
        return chamber_charts(record, paths, chamber, self.observer.period or self.period)
