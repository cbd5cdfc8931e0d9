"""Whether the books of a run balance: nothing is computed as the difference of the others."""

from dataclasses import dataclass
from typing import Any

from vvdp.numerics.tableaus import Array
from vvdp.simulation.model import Case, Model
from vvdp.simulation.run import Run
from vvdp.simulation.values import as_value, flat

LIMIT = 1e-6
"""A residual above this share of the throughput marks a run as not to be trusted."""


@dataclass(frozen=True)
class Balance:
    """Energy [J] and oil [m^3 at tank conditions] in, out, and into store over a run."""

    energy_in: float
    energy_out: float
    energy_stored: float
    volume_in: float
    volume_out: float
    volume_stored: float

    @property
    def energy_residual(self) -> float:
        """(in - out - stored) over the throughput."""
        return _residual(self.energy_in, self.energy_out, self.energy_stored)

    @property
    def mass_residual(self) -> float:
        """(in - out - stored) over the throughput."""
        return _residual(self.volume_in, self.volume_out, self.volume_stored)

    @property
    def is_trusted(self) -> bool:
        """Whether both residuals are below the limit."""
        return abs(self.energy_residual) <= LIMIT and abs(self.mass_residual) <= LIMIT


def _residual(taken: float, given: float, stored: float) -> float:
    throughput = max(abs(taken), abs(given), abs(stored))
    return (taken - given - stored) / throughput if throughput > 0.0 else 0.0


def balance(run: Run) -> Balance | None:
    """The balance of a whole run; None when the model keeps no books."""
    return balance_between(run.model, run.case, flat(run.case.state), run.final)


def balance_between(model: Model, case: Case, start: Array, end: Array) -> Balance | None:
    """The balance between two states, shape (n,) each; None when the model keeps no books."""
    if model.stored is None:
        return None
    before, after = as_value(case.state, start), as_value(case.state, end)
    held, holds = model.stored(before, case.params), model.stored(after, case.params)
    return Balance(
        energy_in=_change(before.books.supplied, after.books.supplied),
        energy_out=_change(before.books.spent, after.books.spent),
        energy_stored=holds.energy - held.energy,
        volume_in=after.books.taken_in - before.books.taken_in,
        volume_out=after.books.given_out - before.books.given_out,
        volume_stored=holds.volume - held.volume,
    )


def _change(before: Any, after: Any) -> float:
    return float(sum(b - a for a, b in zip(flat(before), flat(after), strict=True)))
