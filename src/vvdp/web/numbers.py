"""How a page calculates the numbers of a run: from states at the ends of its means, and from its extremes.

The summary's own functions are carried out with sums in place of numbers, so that page and command line count alike.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from vvdp.base.conservation import Books
from vvdp.base.display import display_unit
from vvdp.base.kinds import DURATION, EXCHANGED_ENERGY, Kind
from vvdp.evaluation.overview import expects_steady_state
from vvdp.evaluation.quantities import quantities
from vvdp.evaluation.summary import node_numbers, part_numbers
from vvdp.evaluation.validity import bounds, cavitation_pressure
from vvdp.network.nodes import HydraulicNode
from vvdp.simulation.balance import LIMIT, SLACK
from vvdp.simulation.outcome import SETTLED, SLOWEST, SMALL, Outcome, Window
from vvdp.simulation.values import flat, leaves
from vvdp.systems.bound import Bound
from vvdp.systems.system import System

BOOKS = "books."
FAR = 1e9
"""A number so far out [SI] that a bound on it is broken."""


@dataclass(frozen=True, eq=False)
class Sum:
    """A constant and multiples of numbers that a run gives: ("mean" | "low" | "high", place in the state)."""

    terms: Mapping[tuple[str, int], float] = field(default_factory=dict)
    constant: float = 0.0

    def __add__(self, other: Any) -> "Sum":
        if not isinstance(other, Sum):
            return replace(self, constant=self.constant + float(other))
        terms = dict(self.terms)
        for key, factor in other.terms.items():
            terms[key] = terms.get(key, 0.0) + factor
        return Sum(terms, self.constant + other.constant)

    __radd__ = __add__

    def __mul__(self, factor: float) -> "Sum":
        return Sum({key: each * factor for key, each in self.terms.items()}, self.constant * factor)

    def __neg__(self) -> "Sum":
        return self * -1.0

    def __sub__(self, other: "Sum | float") -> "Sum":
        return self + other * -1.0

    def __truediv__(self, divisor: float) -> "Sum":
        return self * (1.0 / divisor)

    @property
    def flat(self) -> list[Any]:
        """As JSON has it: the constant, then kind, place and factor of each term."""
        return [self.constant, *([kind, place, factor] for (kind, place), factor in self.terms.items())]


def summary_sums(system: System) -> dict[str, Any]:
    """The numbers of nodes and parts by key of the summary, each a constant or a `Sum.flat`."""
    case, size = system.case, flat(system.case.state).size

    def row(kind: str) -> Any:
        found = np.empty(size, object)
        found[:] = [Sum({(kind, place): 1.0}) for place in range(size)]
        return found

    mean = row("mean")
    window = Window(begin=0.0, end=1.0, first=np.zeros(size), last=mean, periods=0, settled=False)
    run = Outcome(
        model=system.model, case=case, window=window, final=mean, low=row("low"), high=row("high"), end=1.0, steps=0,
        rejected=0, evaluations=0, stiff=False, seconds=0.0, finished=True,
    )  # fmt: skip
    states = [path for path, _, _ in leaves(case.state)]
    means: Any = {path.removeprefix(BOOKS): mean[at] for at, path in enumerate(states) if path.startswith(BOOKS)}
    found: Any = {**node_numbers(run, system, means), **part_numbers(system, means)}
    return {key: each.flat if isinstance(each, Sum) else [float(each)] for key, each in found.items()}


def judgement(system: System, summary: Mapping[str, float | bool]) -> dict[str, Any]:
    """Data with which a page judges a run: kinds of states, places of the books, limits, bounds of laws, words."""
    states = list(leaves(system.case.state))
    kinds = [kind for _, _, kind in states]
    spent = [place for place, (path, _, _) in enumerate(states) if path.startswith("books.spent.")]
    return {
        "units": [kind.unit if kind and kind.accumulates and kind is not DURATION else "" for kind in kinds],
        "limits": {"settled": SETTLED, "small": SMALL, "slowest": SLOWEST, "balance": LIMIT},
        "books": {name: _places(states, name) for name in Books._fields},
        "falling": [place for place in spent if kinds[place] != EXCHANGED_ENERGY],
        "ranges": [_range(kind) for kind in kinds],
        "steady": expects_steady_state(system, summary),
        "cavitation": cavitation_pressure(system),
        "pressures": {
            f"pressure_min_{name}_Pa": node.oil.reference_pressure
            for name, node in system.circuit.network.nodes.items()
            if isinstance(node, HydraulicNode)
        },
        "bounds": [_bound(key, bound, offset, way) for key, bound, offset, way in _bounds(system, summary)],
    }


def _places(states: Any, name: str) -> list[int]:
    return [
        at for at, (path, _, _) in enumerate(states) if path == f"books.{name}" or path.startswith(f"books.{name}.")
    ]


def _range(kind: Kind | None) -> list[float | None]:
    """Between which numbers a state may lie; none of what grows without bound."""
    if kind is None or kind.accumulates:
        return [None, None]
    ends = (kind.low - SLACK * kind.scale, kind.high + SLACK * kind.scale)
    return [end if np.isfinite(end) else None for end in ends]


def _bounds(system: System, summary: Mapping[str, float | bool]) -> Iterator[tuple[str, Bound, float, int]]:
    """Each number of the summary that a law bounds: key, bound, what is added to it, and the way it breaks it."""
    usual = {bound.label for bound in bounds(system, summary) if not bound.is_kept}
    for key in summary_sums(system):
        for way in (-1, 1):
            far = way * FAR
            for bound in bounds(system, {**summary, key: far}):
                value = bound.low if bound.low < bound.least else bound.high
                under, over = bound.low < bound.least, bound.high > bound.most
                if (under or over) and bound.label not in usual and abs(abs(value) - FAR) < 1e-2 * FAR:
                    yield key, bound, float(f"{value - far:.10g}") if way * value > 0.0 else 0.0, way


def _bound(key: str, bound: Bound, offset: float, way: int) -> dict[str, Any]:
    unit = display_unit(bound.kind)
    return {
        "key": key, "way": way, "offset": offset, "size": bound.low > 0.0 and way < 0, "label": bound.label,
        "least": bound.least if np.isfinite(bound.least) else None,
        "most": bound.most if np.isfinite(bound.most) else None, "otherwise": bound.otherwise,
        "unit": {"symbol": unit.symbol, "scale": unit.scale, "datum": unit.datum},
    }  # fmt: skip


def labels(system: System) -> dict[str, dict[str, Any]]:
    """Label and unit of the numbers that a page shows, by key."""
    found = {}
    for key, (kind, label) in quantities(system).items():
        unit = display_unit(kind)
        found[key] = {"label": label, "symbol": unit.symbol, "scale": unit.scale, "datum": unit.datum}
    return found
