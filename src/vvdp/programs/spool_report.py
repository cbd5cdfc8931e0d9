"""Report of a law that moves a spool: errors of spool and estimate, and figures."""

from collections.abc import Iterable, Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np

from vvdp.base.arrays import Array
from vvdp.network.network import Network, ProgramPart
from vvdp.network.nodes import Source
from vvdp.programs.axial_charts import DrivePaths, command_charts
from vvdp.programs.axial_numbers import MOTION, Moved, motion_numbers
from vvdp.programs.axial_stages import RUN
from vvdp.programs.chamber_observer import SeenSpool
from vvdp.programs.report import ProgramReport, Quantities, origin, read_rows, state_rows
from vvdp.results.chart import Chart
from vvdp.results.result import Table

if TYPE_CHECKING:
    from vvdp.simulation.record import Record
    from vvdp.simulation.run import Run

WATCHED = ("position", "position_deviation", "pollution", "stage")


def rows_at_samples(run: "Run", program: ProgramPart, period: float) -> tuple[Array, Array]:
    """The rows at samples, every `period` [s], at which the spool of a law is released, and those that follow, in which
    what they command stands. Samples whose next one is not recorded are left out."""
    at_sample = np.flatnonzero(np.abs(run.times / period - np.round(run.times / period)) < 1e-6)
    now: Any = at_sample[:-1]
    after: Any = at_sample[1:]
    is_used: Any = np.abs(run.times[after] - run.times[now] - period) < 1e-6 * period
    if released := program.reads.get("released"):
        is_used = is_used & (read_rows(run, released, now, after) > 0.5)
    elif stage := program.reads.get("stage"):
        is_used = is_used & (read_rows(run, stage, now, after) == RUN)
    return now[is_used], after[is_used]


def observer_rows(run: "Run", observer: ProgramPart | None, word: str, after: Array) -> Array:
    """A command of the observer, (rows,); without one nothing is off, and nothing is known."""
    if observer is None:
        return np.zeros(after.size) if word.endswith("deviation") else np.full(after.size, np.nan)
    found: Array = getattr(getattr(run.command, observer.name), word)[after]
    return found


def true_path(network: Network, source: Source | None, quantity: str) -> str:
    """The path of a true quantity of a node or component behind what a law reads, through programs that pass it on;
    empty without one."""
    program, path = origin(network, source)
    while program is not None:
        inputs = program.reads
        source = next((inputs[key] for key in ("measured", "position", "reads") if key in inputs), None)
        program, path = origin(network, source)
    owner, _, word = path.rpartition(".")
    return path if word == quantity and (owner in network.nodes or owner in network.parts) else ""


class SpoolReport(ProgramReport):
    """Of a program that reads a `reference` and a `position`, and gives the `command` of a drive.

    The truth stands where the observer's sensor looks; a law without an observer receives the true state.
    """

    GROUP = "Axial control"
    QUANTITIES: Quantities = MappingProxyType(MOTION)
    HEADLINE = ("spool_position_error_rms_m", "spool_estimate_error_rms_m")
    STEADY = False

    def __init__(self, network: Network, name: str, sample_period: float) -> None:
        super().__init__(network, name, sample_period)
        source = self.program.reads["position"]
        watch = origin(network, source)[0]
        self.observer = watch if watch is not None and isinstance(watch.type.command, SeenSpool) else None
        self.spool = true_path(network, source, "position")
        settings: Any = None if self.observer is None else self.observer.settings
        self.helix_length = np.nan if settings is None else settings.helix_length

    def numbers(self, run: "Run") -> dict[str, float]:
        """Errors, from a second after the start of control on; none without a true position."""
        if not self.spool:
            return {}
        now, after = rows_at_samples(run, self.program, self.period)
        moved = Moved(
            times=run.times[now],
            true=state_rows(run, self.spool)[now],
            reference=read_rows(run, self.program.reads["reference"], now, after),
            position=observer_rows(run, self.observer, "position", after),
            deviation=observer_rows(run, self.observer, "position_deviation", after),
            pollution=observer_rows(run, self.observer, "pollution", after),
        )
        found = motion_numbers(moved, self.helix_length)
        speed = run.end / run.seconds if run.seconds > 0.0 else np.nan
        return found | {"real_time_factor": speed} if found and np.isfinite(speed) else found

    def paths(self) -> DrivePaths | None:
        """Where a record has what is drawn; None without an observer, and where the reference is no command."""
        reference = self.program.reads["reference"]
        if not self.spool or self.observer is None or not isinstance(reference, str):
            return None
        reads: Mapping[str, object] = self.observer.reads
        return DrivePaths(
            spool=self.spool,
            reference=reference,
            measured=str(reads["measured"]),
            spool_angle=str(reads["angle"]),
            **{word: f"{self.observer.name}.{word}" for word in WATCHED},
        )

    def charts(self, record: "Record") -> Iterable[tuple[Chart, Table]]:
        """Position, command and errors."""
        paths = self.paths()
        return () if paths is None else command_charts(record, paths, f"{self.program.name}.command", self.period)
