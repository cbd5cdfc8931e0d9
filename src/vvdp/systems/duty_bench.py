"""What a pump unit with a controlled duty ratio brings along: a bench of the rotary valve, and its axial control."""

from collections.abc import Iterable, Iterator, Mapping
from typing import TYPE_CHECKING, Any

from vvdp.base.errors import ConfigError, Fault
from vvdp.base.kinds import Kind
from vvdp.programs.axial_charts import control_charts, gerotor_charts
from vvdp.programs.axial_numbers import CHAMBER, MOTION, control_merits
from vvdp.results.chart import Chart
from vvdp.results.result import Table
from vvdp.simulation.run import Run
from vvdp.systems.axial_numbers import control_numbers, lines_of, loop_of, loop_warnings
from vvdp.systems.bench import RotaryBench
from vvdp.systems.extras import Summary
from vvdp.systems.gerotor_numbers import gerotor_numbers

if TYPE_CHECKING:
    from vvdp.simulation.record import Record
    from vvdp.systems.system import System


class HeldDuty(RotaryBench):
    """A bench whose duty ratio is asked of an axial drive; closed forms are those of the duty ratio that is asked."""

    HELD: Mapping[str, tuple[Kind, str]]
    """Numbers of its drive."""

    def __init__(self, system: "System", tables: Mapping[str, Any] | None = None) -> None:
        super().__init__(system, tables)
        self.QUANTITIES = {**self.QUANTITIES, **self.HELD}
        self.OVERVIEW = (*self.OVERVIEW, *lines_of(self.HELD))

    @property
    def is_watched(self) -> bool:
        """The encoder belongs to the axial control, which shows what it believes."""
        return False

    def hold(self) -> "RotaryBench":
        """Refused with a ConfigError: set points prescribe a duty ratio, and this one is what its control makes it."""
        message = (
            "its duty ratio is held by a control and cannot be prescribed at set points; take a bench without one, "
            "such as prototype"
        )
        raise ConfigError([Fault(self.system.name, 0, "", message)])


class DutyControl(HeldDuty):
    """A bench whose spool a chamber moves against a spring."""

    HELD = CHAMBER

    def record_numbers(self, run: Run) -> Summary:
        """How well the duty ratio was held."""
        return control_numbers(run, loop_of(self.system), self.valve.helix_length)

    def warnings(self, found: Mapping[str, Any]) -> Iterator[str]:
        """What is to be known of bench and control."""
        yield from super().warnings(found)
        yield from loop_warnings(loop_of(self.system), found)

    def merits(self, found: Mapping[str, Any]) -> Iterator[str]:
        """A storage that never rose."""
        yield from control_merits(found)

    def charts(self, record: "Record") -> Iterable[tuple[Chart, Table]]:
        """Position, pressure, storage and errors."""
        return control_charts(record, self.tables["axial_observer"].sample_period)


class GerotorDutyControl(HeldDuty):
    """A bench whose spool a gerotor pump moves."""

    HELD = MOTION

    def record_numbers(self, run: Run) -> Summary:
        """How well the duty ratio was held."""
        return gerotor_numbers(run, self.system, self.valve.helix_length)

    def charts(self, record: "Record") -> Iterable[tuple[Chart, Table]]:
        """Position, command and errors."""
        return gerotor_charts(record, self.tables["axial_observer"].sample_period)
