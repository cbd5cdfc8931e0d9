"""Whether the books of a run balance: nothing is computed as the difference of the others."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from vvdp.base.arrays import Array
from vvdp.base.conservation import Books
from vvdp.base.kinds import EXCHANGED_ENERGY
from vvdp.simulation.model import Case, Model
from vvdp.simulation.run import Run
from vvdp.simulation.values import as_value, flat, leaves

LIMIT = 1e-6
"""A residual above this share of the throughput marks a run as not to be trusted; a sink that gives more as well."""

SLACK = 1e-3
"""Share of the scale of a state by which it may leave its range: the tolerance of a coarse run."""


@dataclass(frozen=True)
class OilBalance:
    """One oil in, out, and stored over a run [m^3 at tank conditions]."""

    taken_in: float
    given_out: float
    stored: float
    throughput: float

    @property
    def residual(self) -> float:
        """(in - out - stored) over the throughput: what went through, but at least what the system holds."""
        return _share(self.taken_in - self.given_out - self.stored, self.throughput)


@dataclass(frozen=True)
class Balance:
    """Energy [J] in, out, and stored over a run, and the balance of each oil.

    `falling` names the entries of `spent` that gave energy back (flow that runs up the pressure, a friction that
    drives), but for those of the kind `EXCHANGED_ENERGY`; `outside` the states that left the range of their kind.
    """

    energy_in: float
    energy_out: float
    energy_stored: float
    energy_throughput: float
    oils: tuple[OilBalance, ...]
    falling: tuple[str, ...] = ()
    outside: tuple[str, ...] = ()

    @property
    def energy_residual(self) -> float:
        """(in - out - stored) over the throughput: all entries, whatever their sign, but at least what is held."""
        return _share(self.energy_in - self.energy_out - self.energy_stored, self.energy_throughput)

    @property
    def mass_residual(self) -> float:
        """The largest residual of an oil: none makes up for another."""
        return max((oil.residual for oil in self.oils), key=abs)

    @property
    def is_closed(self) -> bool:
        """Whether both residuals are below the limit."""
        return abs(self.energy_residual) <= LIMIT and abs(self.mass_residual) <= LIMIT

    @property
    def is_possible(self) -> bool:
        """Whether the second law holds: no sink gave energy back, and every state is one that can be."""
        return not self.falling and not self.outside

    @property
    def is_trusted(self) -> bool:
        """Whether the books close and what they hold is possible."""
        return self.is_closed and self.is_possible


def _share(missing: float, throughput: float) -> float:
    return missing / throughput if throughput > 0.0 else 0.0


def balance(run: Run) -> Balance | None:
    """The balance of a whole run; None when the model keeps no books."""
    return balance_between(run.model, run.case, run.initial, run.final, (run.low, run.high))


def balance_between(
    model: Model, case: Case, start: Array, end: Array, extremes: tuple[Array, Array] | None = None
) -> Balance | None:
    """The balance between two states, shape (n,) each; None when the model keeps no books.

    `extremes` are the lowest and the highest states in between, where they are known, shape (n,) each.
    """
    if model.stored is None:
        return None
    before, after = as_value(case.state, start), as_value(case.state, end)
    held, holds = model.stored(before, case.params), model.stored(after, case.params)
    supplied = flat(after.books.supplied) - flat(before.books.supplied)
    spent = flat(after.books.spent) - flat(before.books.spent)
    energy_stored = float(holds.energy - held.energy)
    passed = max(abs(supplied).sum(), abs(spent).sum(), abs(energy_stored))
    throughput = float(max(passed, abs(held.energy), abs(holds.energy)))
    return Balance(
        energy_in=float(supplied.sum()),
        energy_out=float(spent.sum()),
        energy_stored=energy_stored,
        energy_throughput=throughput,
        oils=tuple(_oil_balances(before.books, after.books, held.volume, holds.volume)),
        falling=tuple(
            path
            for (path, _, kind), change in zip(leaves(after.books.spent), spent, strict=True)
            if change < -LIMIT * throughput and kind != EXCHANGED_ENERGY
        ),
        outside=() if extremes is None else states_outside(case, *extremes),
    )


def _oil_balances(before: Books, after: Books, held: Any, holds: Any) -> Iterator[OilBalance]:
    """The balance of each oil, from the books and the stored volumes at both ends."""
    taken_in, given_out = flat(after.taken_in) - flat(before.taken_in), flat(after.given_out) - flat(before.given_out)
    for into, out, begin, end in zip(taken_in, given_out, flat(held), flat(holds), strict=True):
        most = max(abs(into), abs(out), abs(end - begin), end)
        yield OilBalance(float(into), float(out), float(end - begin), float(most))


def states_outside(case: Case, low: Array, high: Array) -> tuple[str, ...]:
    """The states that left the range of their kind, by more than `SLACK` of its scale, from their extremes, (n,) each.

    What grows without bound, as an angle does, has no range.
    """
    return tuple(
        path
        for (path, _, kind), lowest, highest in zip(leaves(case.state), low, high, strict=True)
        if kind
        and not kind.accumulates
        and (lowest < kind.low - SLACK * kind.scale or highest > kind.high + SLACK * kind.scale)
    )
