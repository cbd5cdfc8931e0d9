"""Report of a program with a foreign FMU: energy that its exchange creates or loses."""

from collections.abc import Iterator, Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING

from vvdp.base.kinds import EXCHANGED_ENERGY, SIGNED_FRACTION
from vvdp.programs.foreign.table import MADE, THROUGHPUT
from vvdp.programs.report import ProgramReport, Quantities

if TYPE_CHECKING:
    from vvdp.simulation.run import Run

LIMIT = 1e-3
"""Share of the energy that passes from which on a created or lost part is reported."""


class ExchangeReport(ProgramReport):
    """Of a program whose outputs and inputs exchange power with a circuit."""

    GROUP = "Exchange with an FMU"
    QUANTITIES: Quantities = MappingProxyType({
        "exchange_throughput_J": (EXCHANGED_ENERGY, "energy through the exchange with the FMU"),
        "exchange_made_J": (EXCHANGED_ENERGY, "energy created or lost by the exchange, circuit minus FMU"),
        "exchange_share": (SIGNED_FRACTION, "energy created or lost by the exchange, share of the energy through it"),
    })  # fmt: skip

    def numbers(self, run: "Run") -> dict[str, float]:
        """The energies up to the last sample of a recorded run."""
        command = getattr(run.command, self.program.name)
        if not run.times.size:
            return {}
        made, passed = (float(getattr(command, name)[-1]) for name in (MADE, THROUGHPUT))
        share = {"exchange_share": made / passed} if passed > 0.0 else {}
        return {"exchange_throughput_J": passed, "exchange_made_J": made, **share}

    def warnings(self, found: Mapping[str, float | bool]) -> Iterator[str]:
        """A sentence if the exchange creates more energy than `LIMIT`: this energy is proportional to the period, or to
        its square if outputs are extrapolated."""
        share = abs(found.get("exchange_share", 0.0))
        if share > LIMIT:
            order = 2 if self.program.type.ramps else 1
            period = self.period * (LIMIT / share) ** (1.0 / order)
            yield (
                f"the exchange with the FMU creates or loses {100.0 * share:.2g} % of the energy that passes (limit "
                f"{100.0 * LIMIT:.1g} %), so losses and efficiencies are wrong by as much; set the period of the "
                f"program to {1e3 * period:.2g} ms (now {1e3 * self.period:g} ms)"
            )
