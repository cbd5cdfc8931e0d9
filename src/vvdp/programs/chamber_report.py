"""Report of a law of the chamber drive: errors of spool and estimate, storage, reach, figures."""

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
from vvdp.network.network import Network
from vvdp.programs.axial_charts import ChamberPaths, chamber_charts
from vvdp.programs.axial_numbers import (
    CHAMBER,
    Controlled,
    ExactLaw,
    control_merits,
    control_warnings,
    storage_numbers,
)
from vvdp.programs.axial_stages import SETTLED
from vvdp.programs.report import read_rows, state_rows
from vvdp.programs.spool_report import SpoolReport, observer_rows, rows_at_samples, true_path
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
MOTION_WORDS = ("reference", "reference_velocity", "reference_acceleration", "reference_jerk")


class Shown(NamedTuple):
    """What was commanded and believed at samples, each (rows,)."""

    drive: Array
    position_deviation: Array
    velocity_deviation: Array


def static_reach_of(drive: ChamberDrive) -> float:
    """The position that the supply of a drive holds against the spring [m]."""
    lifted = drive.area * (drive.valve.supply_pressure - drive.oil.reference_pressure)
    return (lifted - drive.preload) / drive.stiffness


def reach_numbers(drive: ChamberDrive, helix_length: float) -> dict[str, float]:
    """The position that the supply of a drive holds, and its duty ratio; `helix_length` [m]."""
    reach = static_reach_of(drive)
    return {"axial_reach_m": reach, "duty_reach": reach / helix_length}


class ChamberLawReport(SpoolReport):
    """Of a law that reads the `pressure` of a chamber too: what the chamber stores, and how far its supply reaches."""

    QUANTITIES = MappingProxyType({**CHAMBER, **REACH})

    def __init__(self, network: Network, name: str, sample_period: float) -> None:
        super().__init__(network, name, sample_period)
        self.pressure = true_path(network, self.program.reads["pressure"], "pressure")

    @property
    def law(self) -> ExactLaw | None:
        """Its settings where it is one of the laws whose storage is known; else None."""
        settings: Any = self.program.settings
        is_known = isinstance(getattr(settings, "gains", None), PassivityGains | BacksteppingGains)
        return settings if is_known else None

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
                pressure=state_rows(run, self.pressure)[now],
            ),
            shown=Shown(command, *(observer_rows(run, self.observer, word, after) for word in Shown._fields[1:])),
            reference=Reference(*motion),
        )

    def numbers(self, run: "Run") -> dict[str, float]:
        """Errors and storage, from a second after the start of control on, and the reach."""
        numbers = super().numbers(run)
        if numbers:
            now, after = rows_at_samples(run, self.program, self.period)
            late = run.times[now] >= run.times[now][0] + SETTLED
            margin = observer_rows(run, self.observer, "margin", after)
            numbers["observability_margin_lowest"] = float(np.min(margin[late]))
            if self.law is not None and self.pressure:
                numbers |= storage_numbers(self.run_rows(run), self.law, self.period)
        if self.law is not None:
            numbers |= reach_numbers(self.law.drive, self.helix_length)
        return {key: value for key, value in numbers.items() if np.isfinite(value)}

    def warnings(self, found: Mapping[str, float | bool]) -> Iterator[str]:
        """Limits of the control, and a storage that rose."""
        if self.law is None:
            return
        reach = reach_numbers(self.law.drive, self.helix_length)["axial_reach_m"]
        highest = found.get(f"position_max_{self.spool.rpartition('.')[0]}_m", reach)
        yield from control_warnings(self.law, highest, self.period, found)

    def merits(self, found: Mapping[str, float | bool]) -> Iterator[str]:
        """A storage that never rose."""
        yield from control_merits(found)

    def charts(self, record: "Record") -> Iterable[tuple[Chart, Table]]:
        """Position, pressure, storage and errors."""
        paths, name = self.paths(), self.program.name
        if paths is None or not self.pressure:
            return ()
        chamber = ChamberPaths(self.pressure, f"{name}.desired_pressure", f"{name}.storage")
        return chamber_charts(record, paths, chamber, self.period)
