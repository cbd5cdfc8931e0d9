"""How well a gerotor drive is controlled: errors of position and estimate, and their pictures."""

from collections.abc import Iterable
from typing import TYPE_CHECKING

from vvdp.programs.axial_charts import gerotor_charts
from vvdp.programs.axial_loop import PROGRAM
from vvdp.programs.axial_numbers import MOTION
from vvdp.programs.gerotor_loop import GerotorControl, WatchedGerotor
from vvdp.results.chart import Chart
from vvdp.results.result import Table
from vvdp.systems.axial_numbers import lines_of, spool_numbers
from vvdp.systems.extras import Extras, LoadedSystem, Summary

if TYPE_CHECKING:
    from vvdp.simulation.record import Record
    from vvdp.simulation.run import Run


def gerotor_numbers(run: "Run", system: LoadedSystem, helix_length: float) -> Summary:
    """How well the drive of a system was controlled; `helix_length` [m]."""
    settings = system.circuit.network.programs[PROGRAM].settings
    loop = settings.loop if isinstance(settings, WatchedGerotor) else settings
    assert isinstance(loop, GerotorControl)
    return spool_numbers(run, run.state.gerotor.position, loop.sample_period, helix_length)


class GerotorHeld(Extras):
    """What a controlled gerotor drive brings along."""

    STEADY = False
    OVERVIEW = lines_of(MOTION)
    QUANTITIES = MOTION
    HEADLINE = ("spool_position_error_rms_m", "spool_estimate_error_rms_m")

    def record_numbers(self, run: "Run") -> Summary:
        """How well the drive was controlled."""
        return gerotor_numbers(run, self.system, self.tables["stroke"].helix_length)

    def charts(self, record: "Record") -> Iterable[tuple[Chart, Table]]:
        """Position, command and errors."""
        return gerotor_charts(record, self.tables["axial_observer"].sample_period)
