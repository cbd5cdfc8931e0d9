"""What the system of chapter 6 brings along: how well the cylinder follows its reference, and pictures of it."""

from collections.abc import Iterable, Iterator, Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np

from vvdp.base.kinds import ENERGY, FLOW, GAUGE_PRESSURE, NUMBER, Kind
from vvdp.machines.chapter6_charts import displacement_charts
from vvdp.machines.chapter6_loop import PROGRAM
from vvdp.machines.tracking import GROUP, SETTLED, TRACKING, TRACKING_LINES, tracking_numbers
from vvdp.results.chart import Chart
from vvdp.results.result import Table
from vvdp.simulation.values import leaves
from vvdp.systems.extras import Extras, Line, Summary

if TYPE_CHECKING:
    from vvdp.simulation.outcome import Outcome
    from vvdp.simulation.record import Record
    from vvdp.simulation.run import Run

CHAMBERS = ("chamber_a", "chamber_b")
OTHERS: Mapping[str, tuple[Kind, str]] = MappingProxyType(
    {
        "pressure_min_Pa": (GAUGE_PRESSURE, "lowest pressure under control"),
        "pressure_max_Pa": (GAUGE_PRESSURE, "highest pressure under control"),
        "pump_flow_max_m3_s": (FLOW, "largest flow of the pump"),
        "real_time_factor": (NUMBER, "simulated over computing time"),
    }
)
"""Numbers beside those of the tracking."""
ENERGIES: Mapping[str, tuple[Kind, str]] = MappingProxyType(
    {
        f"mode_{mode}_{key}_J": (ENERGY, f"{words} in mode {mode}")
        for key, words in (("pump_energy", "energy from the pump"), ("return_loss", "lost in the return valve"))
        for mode in range(1, 6)
    }
)
"""What each pressure mode uses, with its transition."""


class Chapter6Extras(Extras):
    """What the system of chapter 6 brings along."""

    STEADY = False
    QUANTITIES: Mapping[str, tuple[Kind, str]] = MappingProxyType({**TRACKING, **OTHERS, **ENERGIES})
    OVERVIEW = (*TRACKING_LINES, *(Line(label, (key,), kind, (), GROUP) for key, (kind, label) in OTHERS.items()))
    HEADLINE = ("tracking_error_max_m", "tracking_error_rms_m")

    def simulation_numbers(self, run: "Outcome", found: Summary) -> Summary:
        """Extremes over every step, and the pace."""
        paths = [path for path, _, _ in leaves(run.case.state)]
        return {
            "pressure_min_Pa": min(found[f"pressure_min_{chamber}_Pa"] for chamber in CHAMBERS),
            "pressure_max_Pa": max(found[f"pressure_max_{chamber}_Pa"] for chamber in CHAMBERS),
            "pump_flow_max_m3_s": float(run.high[paths.index("pump.flow")]),
            "real_time_factor": run.end / run.seconds if run.seconds > 0.0 else np.nan,
        }

    def record_numbers(self, run: "Run") -> Summary:
        """How well the cylinder followed, and what each pressure mode used."""
        return tracking_numbers(run.final_memory[PROGRAM].tracking) | mode_energies(run)

    def warnings(self, found: Mapping[str, float | bool]) -> Iterator[str]:
        """A chamber that was drawn empty."""
        if share := found.get("below_tank_share"):
            yield (
                f"a chamber was below tank pressure {100.0 * share:.2g} % of the time: raise "
                "pressure_bounds.lowest_pressure, or make the pump faster"
            )

    def merits(self, found: Mapping[str, float | bool]) -> Iterator[str]:
        """Bounds that were never near."""
        if found.get("mode_1_share") == 1.0:
            yield "both chambers stayed clear of their bounds: no pressure mode acted"

    def charts(self, record: "Record") -> Iterable[tuple[Chart, Table]]:
        """Motion, pressures, actuation."""
        return displacement_charts(record, self.tables["pressure_bounds"], self.tables["sampling"].sample_period)


def mode_energies(run: "Run") -> Summary:
    """Energy from the pump and lost in the return valve [J] while each mode was commanded, from `SETTLED` on.

    Of the balances that the run integrates: nothing is lost between rows. Empty for a run that was not longer.
    """
    books: Any = run.state.books
    rows = np.flatnonzero(run.times >= SETTLED)
    modes = np.floor(getattr(run.command, PROGRAM).mode[rows[1:]])  # a row has the command that held until then
    used = {"pump_energy": books.supplied.pump, "return_loss": books.spent.return_valve}
    return {
        f"mode_{mode}_{key}_J": float(np.sum(np.diff(sums[rows])[modes == mode]))
        for key, sums in used.items()
        for mode in range(1, 6)
        if rows.size > 1
    }
