"""Numbers and figures of displacement control: energy in each pressure mode, and the largest flow.

Source  ours, docs/models/displacement-chapter6.md
"""

from collections.abc import Iterable, Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np

from vvdp.base.kinds import ENERGY, FLOW
from vvdp.control.displacement import DisplacementSettings
from vvdp.network.network import Network
from vvdp.programs.displacement_charts import law_charts
from vvdp.programs.report import ProgramReport, Quantities
from vvdp.programs.tracking import SETTLED
from vvdp.results.chart import Chart
from vvdp.results.result import Table
from vvdp.simulation.values import leaves, names

if TYPE_CHECKING:
    from vvdp.simulation.outcome import Outcome
    from vvdp.simulation.record import Record
    from vvdp.simulation.run import Run

ENERGIES: Quantities = MappingProxyType(
    {
        f"mode_{mode}_{key}_J": (ENERGY, f"{words} in mode {mode}")
        for key, words in (("pump_energy", "energy from the pump"), ("return_loss", "lost in the return valve"))
        for mode in range(1, 6)
    }
)
"""Energies of each pressure mode, its transition included."""


class DisplacementReport(ProgramReport):
    """Of a law that commands `flow`, `opening` and `direction`, and reads the flow that the pump gives."""

    GROUP = "Displacement control"
    QUANTITIES = MappingProxyType({"pump_flow_max_m3_s": (FLOW, "largest flow of the pump"), **ENERGIES})
    UNSHOWN = frozenset(ENERGIES)
    STEADY = False

    def __init__(self, network: Network, name: str, sample_period: float) -> None:
        super().__init__(network, name, sample_period)
        parts = network.parts.values()
        self.pump = next((part.name for part in parts if f"{name}.flow" in part.inputs.values()), "")
        self.return_valve = next((p.name for p in parts if p.inputs.get("opening") == f"{name}.opening"), "")

    def outcome_numbers(self, run: "Outcome", found: Mapping[str, float | bool]) -> dict[str, float]:  # noqa: ARG002
        """The largest flow of the pump over every step, if it is a state."""
        paths = [path for path, _, _ in leaves(run.case.state)]
        flow = self.program.reads.get("delivered_flow")
        return {"pump_flow_max_m3_s": float(run.high[paths.index(flow)])} if flow in paths else {}

    def numbers(self, run: "Run") -> dict[str, float]:
        """Energy from the pump and lost in the return valve [J] while each mode was commanded, from `SETTLED` on.

        Of the balances that the run integrates: nothing is lost between rows. Empty for a run that was not longer.
        """
        books: Any = run.state.books
        rows = np.flatnonzero(run.times >= SETTLED)
        mode = getattr(run.command, self.program.name).mode
        modes = np.floor(mode[rows[1:]])  # a row has the command that held until then
        sides = (("pump_energy", books.supplied, self.pump), ("return_loss", books.spent, self.return_valve))
        return {
            f"mode_{mode}_{key}_J": float(np.sum(np.diff(getattr(sums, part)[rows])[modes == mode]))
            for key, sums, part in sides
            if part in names(sums) and rows.size > 1
            for mode in range(1, 6)
        }

    def charts(self, record: "Record") -> Iterable[tuple[Chart, Table]]:
        """Charts of the pressures within their bounds, and of the commands of the drives."""
        name, settings = self.program.name, self.program.settings
        assert isinstance(settings, DisplacementSettings)
        commands = {key: f"{name}.{key}" for key in ("flow", "opening", "direction", "mode")}
        return law_charts(record, {**self.program.reads, **commands}, settings.bounds)
